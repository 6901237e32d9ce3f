"""The endurance run: the learner holds in every case, and without its protections the run says that it does not."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import pytest

import hysgen.checking.endurance.endure as endure
from hysgen.checking.endurance import run
from hysgen.checking.endurance.trials import CASES, Trial
from hysgen.cli import main
from hysgen.codegen import Options, generate
from hysgen.model.model import Model

SAMPLES = 200_000

NO_RESTORING = [
    (r"self->since_refresh < BENCH_LEARN_REFRESH_EVERY", "1"),
    (r"bench_mask\(\(uint32_t\)\(v\d+ > c\d+\)\)", "0u"),
]
NO_REJECTION = [
    (r"const float y = bench_finite\(y_um, self->y_um, &y_lost\);", "const float y = y_um; y_lost = 0u;"),
    (r"if \(lost != 0u\)", "if (0)"),
]


def test_the_learner_endures_and_eq_10_as_printed_does_not() -> None:
    for outcome in run([Trial(case, 0.999, 1e6, SAMPLES) for case in CASES]):
        assert outcome.holds, outcome
        assert outcome.updates > 0.45 * SAMPLES
        assert outcome.printed_dies_at is not None


def test_other_settings_endure_the_case_without_excitation() -> None:
    settings = [(1.0, 1e6), (0.9999, 1e3), (0.99, 1e3)]
    for outcome in run([Trial("constant", forgetting, alpha, SAMPLES) for forgetting, alpha in settings]):
        assert outcome.holds, outcome


@pytest.mark.parametrize(
    ("case", "edits"),
    [("noise", NO_RESTORING), ("bursts", NO_REJECTION)],
    ids=["covariance not bounded, prior not put back", "not finite, and no restart"],
)
def test_without_its_protections_the_learner_is_seen_to_fail(
    case: str, edits: Sequence[tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def planted(model: Model, options: Options) -> Mapping[str, str]:
        texts: dict[str, Any] = dict(generate(model, options))
        for pattern, text in edits:
            texts["bench.c"], found = re.subn(pattern, text, texts["bench.c"])
            assert found, pattern
        return texts

    monkeypatch.setattr(endure, "generate", planted)
    assert not run([Trial(case, 0.999, 1e6, SAMPLES)])[0].holds


def test_the_verb_prints_a_row_per_trial_and_exits_with_what_came_of_them(
    capsys: pytest.CaptureFixture[str],
) -> None:
    call = ["endurance", "--samples", "2000", "--cases", "sine", "--json", "-"]
    assert main(call) == 0
    told = json.loads(capsys.readouterr().out)
    assert [(trial["trial"]["case"], trial["holds"]) for trial in told["trials"]] == [("sine", True)]
    assert main(["endurance", "--samples", "10"]) == 2
    assert "choose at least 1000" in capsys.readouterr().err
