"""The endurance run: every case passes, and a learner without its protections fails."""

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import pytest

import hysgen_lab.studies.endurance.compiled_learner as compiled_learner
from hysgen.cli import main
from hysgen.codegen import Options, generate
from hysgen.model.model import Model
from hysgen_lab.studies.endurance import CASES, EnduranceTest, run
from hysgen_lab.verbs import LABORATORY

pytestmark = pytest.mark.slow

SAMPLES = 50_000

NO_RESTORING = [
    (r"self->since_refresh < BENCH_LEARN_REFRESH_EVERY", "1"),
    (r"bench_learn_ceiling\[j\], &limited", "bench_float(0x7f800000u), &limited"),
]
NO_REJECTION = [
    (r"const float y = bench_finite\(y_um, self->y_um, &y_lost\);", "const float y = y_um; y_lost = 0u;"),
    (r"if \(lost != 0u\)", "if (0)"),
]


def test_the_learner_passes_every_case_and_eq_10_as_printed_loses_its_covariance() -> None:
    for result in run([EnduranceTest(case, 0.999, 1e6, SAMPLES) for case in CASES]):
        assert result.holds, result
        assert result.updates > 0.45 * SAMPLES
        assert result.paper_lost_at is not None


@pytest.mark.proof
def test_other_settings_pass_the_case_without_excitation() -> None:
    settings = [(1.0, 1e6), (0.9999, 1e3), (0.99, 1e3)]
    for result in run([EnduranceTest("constant", forgetting, alpha, SAMPLES) for forgetting, alpha in settings]):
        assert result.holds, result


@pytest.mark.parametrize(
    ("case", "edits"),
    [("noise", NO_RESTORING), ("bursts", NO_REJECTION)],
    ids=["covariance not bounded, prior not put back", "not finite, and no restart"],
)
def test_a_learner_without_its_protections_fails(
    case: str, edits: Sequence[tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def planted(model: Model, options: Options) -> Mapping[str, str]:
        texts: dict[str, Any] = dict(generate(model, options))
        for pattern, text in edits:
            texts["bench.c"], found = re.subn(pattern, text, texts["bench.c"])
            assert found, pattern
        return texts

    monkeypatch.setattr(compiled_learner, "generate", planted)
    assert not run([EnduranceTest(case, 0.999, 1e6, SAMPLES)])[0].holds


def test_the_verb_prints_a_row_per_test_and_its_exit_code_is_the_verdict(capsys: pytest.CaptureFixture[str]) -> None:
    call = ["endurance", "--samples", "2000", "--cases", "sine", "--json", "-"]
    assert main(call, LABORATORY) == 0
    report = json.loads(capsys.readouterr().out)
    assert [(trial["trial"]["case"], trial["holds"]) for trial in report["trials"]] == [("sine", True)]
    assert main(["endurance", "--samples", "10"], LABORATORY) == 2
    assert "choose at least 1000" in capsys.readouterr().err
