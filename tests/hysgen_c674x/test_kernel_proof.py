"""Kernels are proved equal to their C, packet by packet, and none with a planted fault is."""

import importlib
import json
import sys
from pathlib import Path

import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.c674x_kernels import WRONG, changed, scheduled_model, scheduled_texts
from fixtures.tools import library
from hysgen.cli import main
from hysgen.codegen.manifest import write
from hysgen_c674x.schedule.proof import kernel_proofs

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
proofs = importlib.import_module("proofs")
pytestmark = pytest.mark.slow
LEARNER = "small_learning"


@pytest.fixture(autouse=True)
def _tools() -> None:
    need_compiler()
    library("bitwuzla")


@pytest.mark.parametrize("name", ["appendix_a", LEARNER, "small_diagnosed"])
def test_every_kernel_is_proved_equal_to_its_c(name: str) -> None:
    result = kernel_proofs(scheduled_model(name), scheduled_texts(name))
    assert {"predict", "simulate", "inverse"} <= {proof.function for proof in result.functions if proof.holds}
    assert all(proof.holds for proof in result.functions), result.lines()


@pytest.mark.proof
@pytest.mark.parametrize("name", proofs.LISTED)
def test_the_kernels_of_the_models_that_are_named_are_proved(name: str) -> None:
    answers = proofs.judged(name, task=proofs.scheduled).answers
    assert set(answers.values()) == {"proved"}, answers


@pytest.mark.parametrize("place", [0.7, pytest.param(0.2, marks=pytest.mark.proof)])
@pytest.mark.parametrize("fault", WRONG, ids=[intact for intact, _ in WRONG])
def test_a_kernel_with_a_fault_is_not_proved(fault: tuple[str, str], place: float) -> None:
    texts, file = scheduled_texts(LEARNER), f"{LEARNER}_c674x.s"
    result = kernel_proofs(scheduled_model(LEARNER), {**texts, file: changed(texts[file], fault, place)})
    assert sum(proof.holds for proof in result.functions) == len(result.functions) - 1, result.lines()


def test_a_folder_with_kernels_is_proved_with_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(scheduled_texts("appendix_a"), tmp_path / "c")
    call = ["prove", str(tmp_path / "c"), "--only", "equal", "--calls", "limits,simulate", "--json", "-"]
    assert main(call) == 0
    answer = json.loads(capsys.readouterr().out)
    functions = [proof["function"] for name in ("equal", "kernels") for proof in answer[name]["functions"]]
    assert functions == ["simulate", "limits", "simulate"]
