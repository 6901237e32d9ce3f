"""The generated C on the simulated C674x: the host's bits, in cycles that do not depend on the data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from proof_models import model, texts
from target_compiler import need_compiler

from hysgen.emit import generate
from hysgen.errors import BuildError
from hysgen.model_file import load_model
from hysgen.target import generated, toolchain

SAMPLES = 400


def test_every_function_has_the_hosts_bits_and_constant_cycles() -> None:
    need_compiler()
    plain, generated_c = model("appendix_a"), texts("appendix_a")
    report = generated.verify_on_target(plain, generated_c, SAMPLES)
    assert report.equal
    assert {run.function for run in report.runs} == {"predict", "simulate", "inverse"}
    assert all(run.words > 40 for run in report.runs)
    # What the static bound says is what every call took, whatever the data: random, edges, or any 32 bits.
    bounds = generated.cycles(plain.name, generated_c)
    for run in report.runs:
        assert run.cycles == (bounds[run.function].best, bounds[run.function].worst)
    assert all(bound.constant for bound in bounds.values())


def test_learning_and_commit_have_the_hosts_bits_within_their_bounds_and_the_period() -> None:
    need_compiler()
    learner, generated_c = model("learning"), texts("learning")
    report = generated.verify_on_target(learner, generated_c, 40_960)
    assert report.equal, report.notes()
    assert report.committed
    runs = {(run.function, run.style): run for run in report.runs}
    assert runs["learn", "the model's own"].samples == 4096
    bounds = generated.cycles(learner.name, generated_c)
    for (function, _), run in runs.items():
        assert bounds[function].best <= run.cycles[0] <= run.cycles[1] <= bounds[function].worst
    # Issue 5: 6 rules, 18 parameters, everything in one period.
    worst = {function: bound.worst for function, bound in bounds.items()}
    assert worst["predict"] <= 180
    assert worst["inverse"] <= 200
    assert worst["learn"] <= 2500
    assert worst["inverse"] + worst["learn"] + worst["commit"] <= 3000


def test_one_bit_of_one_constant_is_seen_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    need_compiler()
    honest = toolchain.compile

    def altered(sources: Sequence[tuple[str, str]], flags: Sequence[str] = ()) -> toolchain.Firmware:
        wrong = [(name, text.replace("0.240226477f", "0.240226492f")) for name, text in sources]
        assert wrong != list(sources)
        return honest(wrong, flags)

    monkeypatch.setattr(toolchain, "compile", altered)
    report = generated.verify_on_target(model("appendix_a"), texts("appendix_a"), SAMPLES)
    assert not report.equal
    assert any("DIFFERENT" in note and "the host's is 0x" in note for note in report.notes())


def test_without_the_compiler_the_message_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYSGEN_C674X", str(tmp_path))
    with pytest.raises(BuildError, match=r"run firmware/toolchain/build_c674x\.sh"):
        generated.cycles("appendix_a", generate(load_model("appendix_a")))
