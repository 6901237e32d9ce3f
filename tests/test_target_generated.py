"""The generated C on the simulated C674x: the host's bits, in cycles that do not depend on the data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from target_compiler import need_compiler

from hysgen.emit import generate
from hysgen.errors import BuildError
from hysgen.model_file import load_model
from hysgen.target import generated, toolchain

SAMPLES = 400


def test_every_function_has_the_hosts_bits_and_constant_cycles() -> None:
    need_compiler()
    model = load_model("appendix_a")
    texts = generate(model)
    report = generated.verify_on_target(model, texts, SAMPLES)
    assert report.equal
    assert {run.function for run in report.runs} == {"predict", "simulate", "inverse"}
    assert all(run.words > 40 for run in report.runs)
    # What the static bound says is what every call took, whatever the data: random, edges, or any 32 bits.
    bounds = generated.cycles(model.name, texts)
    for run in report.runs:
        assert run.cycles == (bounds[run.function].best, bounds[run.function].worst)
    assert all(bound.constant for bound in bounds.values())


def test_one_bit_of_one_constant_is_seen_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    need_compiler()
    model = load_model("appendix_a")
    honest = toolchain.compile

    def altered(sources: Sequence[tuple[str, str]], flags: Sequence[str] = ()) -> toolchain.Firmware:
        wrong = [(name, text.replace("0.240226477f", "0.240226492f")) for name, text in sources]
        assert wrong != list(sources)
        return honest(wrong, flags)

    monkeypatch.setattr(toolchain, "compile", altered)
    report = generated.verify_on_target(model, generate(model), SAMPLES)
    assert not report.equal
    assert any("DIFFERENT" in note and "the host's is 0x" in note for note in report.notes())


def test_without_the_compiler_the_message_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HYSGEN_C674X", str(tmp_path))
    with pytest.raises(BuildError, match=r"run firmware/toolchain/build_c674x\.sh"):
        generated.cycles("appendix_a", generate(load_model("appendix_a")))
