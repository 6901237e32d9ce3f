"""Verify says equal when C and reference are, and names the place, in every way that they can part."""

import dataclasses
import functools
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from fixtures.generated_models import hysteresis
from fixtures.guards import unguarded_against_fusing
from fixtures.proof_models import SHIPPED, shipped
from fixtures.tools import need
from hysgen.api.code import verify
from hysgen.checking.bits import Report
from hysgen.checking.bits.comparison import VerifySettings, verify_texts
from hysgen.cli.main import main
from hysgen.codegen import generate
from hysgen.codegen.manifest import write
from hysgen.model.file import load_model
from hysgen.model.model import Grid, Model
from hysgen.model.path.creep import Creep
from hysgen.model.path.limits import Slew

SAMPLES = 9000


@functools.lru_cache(maxsize=1)
def extended() -> Model:
    """Appendix A behind a slew limit, plays and creep, called `stage`."""
    return dataclasses.replace(
        load_model("appendix_a"), name="stage", blocks=(Slew(4e5, 3e5), hysteresis(3), Creep(0.01, (1e-3, 1.0)))
    )


def compared(model: Model, texts: Mapping[str, str], level: str = "-O2") -> Report:
    return verify_texts(model, texts, VerifySettings(SAMPLES, compilers=["cc"], levels=[level]))


def altered(file: str, old: str, new: str) -> dict[str, str]:
    """The extended model's texts with one fault planted."""
    texts = generate(extended())
    assert old in texts[file], f"the fault has nothing to bite on: {old}"
    return texts | {file: texts[file].replace(old, new)}


@pytest.mark.slow
def test_generated_c_equals_reference_in_every_installed_build() -> None:
    report = verify_texts(extended(), generate(extended()), VerifySettings(SAMPLES))
    assert report.equal, "\n".join(report.lines())
    assert report.samples >= SAMPLES
    assert {run.function for run in report.runs} == {"selftest", "init", "predict", "simulate", "limits", "inverse"}


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.slow
def test_the_c_that_ships_equals_its_reference(name: str) -> None:
    folder = shipped(name)
    report = verify_texts(folder.model, folder.texts, VerifySettings(SAMPLES, compilers=["cc"], levels=["-O2"]))
    assert report.equal, "\n".join(report.lines())
    assert {run.function for run in report.runs} >= {"predict", "simulate", "inverse", "learn", "commit"}


# What a wrong generator, a wrong template or a wrong compiler could do, where it must show first; more faults:
# benchmarks/proofs.py, which the proof of equality finds without samples.
FAULTS = {
    "last bit of a constant": ("stage_params.h", "0.911089778f", "0.911089838f", "predict", "result"),
    "upper clamp missing": ("stage.c", "(stage_bits(high) & lower)", "(stage_bits(x) & lower)", "init", "u_V"),
    "NaN passes": ("stage.c", "(uint32_t)(magnitude >= 0x7f800000u)", "0u", "init", ""),
    "wrong bank": ("stage.c", "&self->bank[self->active]", "&self->bank[0]", "predict", "result"),
    "last good input not kept": ("stage.c", "    self->u_V = u;\n", "", "predict", "u_V"),
    "state of a play": (
        "stage.c",
        "self->play[1] = z1;",
        "self->play[1] = z2;",
        "predict",
        "inputs.hysteresis.play[1]",
    ),
    "self-test": ("stage_selftest.c", "self.y_clamped != ", "self.y_clamped == ", "selftest", "result"),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.slow
def test_planted_fault_is_found_and_named(fault: str) -> None:
    file, old, new, function, word = FAULTS[fault]
    report = compared(extended(), altered(file, old, new))
    assert not report.equal
    named = [m for m in report.mismatches if m.function == function]
    assert named, f"found, but not in {function}: {report.mismatches[0]}"
    assert not word or word in {m.word for m in named}, f"{word} is not named: {named[0]}"
    assert all(m.got != m.expected for m in report.mismatches)


def test_mismatch_names_function_arguments_and_both_bit_patterns() -> None:
    report = compared(extended(), altered("stage_params.h", "0.911089778f", "0.911089838f"))
    line = str(next(m for m in report.mismatches if m.function == "predict"))
    assert line.startswith("stage_predict(0x")
    assert "result is 0x" in line
    assert "expected 0x" in line
    assert "inputs, sample" in line
    assert "cc -O2" in line


def test_results_that_are_not_settled_are_found_where_they_fall_below_the_least_magnitude_that_counts() -> None:
    rng = np.random.default_rng(0)
    consequents = np.ldexp(rng.uniform(1.0, 2.0, (4, 3)), rng.integers(-38, -30, (4, 3)))
    model = Model("low_gain", 2e-5, Grid(-1e-3, 1e-3, 4), consequents, u_min_V=-1.0, u_max_V=1.0)
    texts = generate(model)
    settle = "low_gain_float(bits & low_gain_mask((uint32_t)((bits & 0x7fffffffu) >= 0x2b800000u)))"
    assert settle in texts["low_gain.c"]
    assert compared(model, texts).equal
    assert not compared(model, texts | {"low_gain.c": texts["low_gain.c"].replace(settle, "x")}).equal


# clang obeys the pragma unless -ffp-contract=fast overrides it; then only the self-test can tell.
@pytest.mark.parametrize(("compiler", "contract"), [("gcc", "fast"), ("clang", "on")])
@pytest.mark.slow
def test_guard_keeps_the_compiler_from_fusing_multiplication_and_addition(compiler: str, contract: str) -> None:
    need(compiler)
    if " fma " not in Path("/proc/cpuinfo").read_text():
        pytest.skip("this processor has no fused operations: nothing to guard against")
    texts = generate(extended())
    level = f"-O3 -march=native -ffp-contract={contract}"
    settings = VerifySettings(SAMPLES, compilers=[compiler], levels=[level])
    bare = unguarded_against_fusing(texts, "stage")
    assert verify_texts(extended(), texts, settings).equal
    assert not verify_texts(extended(), bare, settings).equal


@pytest.mark.slow
def test_folder_is_verified_as_it_was_written_and_altered_files_are_named(tmp_path: Path) -> None:
    write(generate(extended()), tmp_path)
    seen: list[float] = []
    report = verify(tmp_path, 3000, lambda fraction, _: seen.append(fraction))
    assert report.equal
    assert json.loads(json.dumps(report.to_json()))["equal"] is True
    assert seen == sorted(seen)
    assert (seen[-1], len(set(seen))) == (1.0, len(seen)), "1 before the end, or more than 1"

    header = tmp_path / "stage.h"
    header.write_text(header.read_text() + "/* edited */\n")
    report = verify(tmp_path, 3000)
    assert not report.equal
    assert any(str(header) in line for line in report.altered)


def test_folder_without_manifest_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(tmp_path)]) == 2
    assert "MANIFEST.json: is missing; this is not a folder" in capsys.readouterr().err


def test_missing_compiler_is_told_loudly() -> None:
    texts = generate(extended())
    report = verify_texts(extended(), texts, VerifySettings(3000, compilers=["cc", "no-such-compiler"]))
    assert any("NOT COMPARED: no-such-compiler" in line for line in report.lines())
