"""Translation validation: the C of every part is proved equal to its reference, and every planted fault is seen."""

import dataclasses
import importlib
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fixtures.drawn_models import random_model
from fixtures.generated_models import everything, smooth
from fixtures.learner_bench import sized, texts_of
from fixtures.proof_models import SHIPPED, shipped
from fixtures.proof_models import model as proof_model
from fixtures.tools import library
from hysgen.checking.bits.comparison import VerifySettings, verify_texts
from hysgen.checking.proof.translation import Translation, translation
from hysgen.checking.symbolic import solver
from hysgen.checking.symbolic.arrays import Symbols, traced
from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.equivalence import SAMPLES, Sweep
from hysgen.checking.symbolic.expressions import negated
from hysgen.checking.symbolic.source import KernelRefusalError
from hysgen.codegen import generate
from hysgen.errors import BuildError, HysgenError
from hysgen.model.learner_settings import LEARNED, LearnerSettings

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
proofs = importlib.import_module("proofs")

FUNCTIONS = ("init", "limits", "predict", "simulate", "inverse")
LATER_FIRST = ("simulate", "inverse", "predict", "limits", "init", "aux")
"""The calls that reach most lines first."""
LEARNING = ("learn_init", "learn", "commit")


@pytest.fixture(autouse=True)
def _solver() -> None:
    library("bitwuzla")


def proved(result: Translation) -> dict[str, bool]:
    return {proof.function: proof.holds for proof in result.functions}


@pytest.mark.proof
@pytest.mark.parametrize("name", SHIPPED)
def test_the_models_that_ship_are_proved_for_every_input(name: str) -> None:
    folder = shipped(name)
    result = translation(folder.model, folder.texts, calls=[*FUNCTIONS, "learn_init", "commit"])
    assert proved(result) == dict.fromkeys((*FUNCTIONS, "learn_init", "commit"), True)
    assert result.lines()[-1] == f"{name}: 7 of 7 functions proved"


def test_a_question_that_runs_out_of_the_clock_is_asked_until_it_has_had_a_processor() -> None:
    """On a busy machine 60 s of the clock are a few of a processor: an equality stayed open there."""

    class Busy:
        """Bitwuzla that runs out of time before its third answer."""

        def __init__(self, library: Any, answers: list[Any]) -> None:
            self._library, self._answers = library, answers

        def __getattr__(self, name: str) -> Any:
            return getattr(self._library, name)

        def check_sat(self) -> Any:
            return self._answers.pop() if self._answers else self._library.check_sat()

    asked, graph = solver.Solver.installed(), Graph()
    assert asked is not None
    asked._solver = Busy(asked._solver, 2 * [library("bitwuzla").Result.UNKNOWN])
    x, y = graph.param(0), graph.param(1)
    other = graph.op("sub", graph.op("or", x, y), graph.op("and", x, y))
    assert asked.equal(graph.op("xor", x, y), other)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "complete"),
    [pytest.param(*drawn, marks=pytest.mark.proof) for drawn in ((0, True), (0, False), (1, False))] + [(7, False)],
)
def test_every_block_and_term_and_layout_of_the_rules_is_proved(seed: int, complete: bool) -> None:
    model = random_model(seed, complete)
    channels = ["aux"] if model.channels else []
    assert proved(translation(model, generate(model))) == dict.fromkeys([*FUNCTIONS, *channels], True), model


@pytest.mark.slow
@pytest.mark.proof
@pytest.mark.parametrize(
    "model",
    [
        *map(sized, (6, 18)),
        dataclasses.replace(smooth(5, 3), learner=LearnerSettings(learned=LEARNED["bias"])),
        dataclasses.replace(everything(), learner=LearnerSettings(learned=("gain", "offset"))),
    ],
    ids=lambda model: model.name,
)
def test_a_learner_and_its_commit_are_proved_for_every_input(model: Any) -> None:
    """In every case of the truths that the C branches on: 10, 40, 5 and 15 s of one core."""
    result = translation(model, texts_of(model), calls=LEARNING)
    assert proved(result) == dict.fromkeys(LEARNING, True), result.lines()
    learn = next(proof for proof in result.functions if proof.function == "learn")
    assert learn.cases > 100
    assert f"{learn.cases} cases" in learn.line()


@pytest.mark.slow
@pytest.mark.parametrize(
    "fault",
    [pytest.param(fault, marks=pytest.mark.proof if fault[1] == "learn" else ()) for fault in proofs.FAULTS[""]],
)
def test_a_fault_of_the_c_is_not_proved(fault: tuple[str, str, str, str]) -> None:
    name, function, intact, planted = fault
    model, texts = proofs.model_of(name)
    source = f"{model.name}.c"
    assert intact in texts[source], f"the fault has nothing to bite on: {intact}"
    (proof,) = translation(model, texts | {source: texts[source].replace(intact, planted)}, calls=[function]).functions
    assert proof.open
    assert not proof.refused


def test_a_generated_function_that_no_proof_knows_is_said() -> None:
    model = proof_model("small_everything")
    texts = dict(generate(model))
    texts[f"{model.name}.c"] += f"\nfloat {model.name}_extra(float x)\n{{\n    return x;\n}}\n"
    known, unknown, last = translation(model, texts, calls=["aux", "extra"]).lines()
    assert known.startswith("aux: equal for every input")
    assert unknown == "extra: not proved: it has no reference"
    assert last == f"{model.name}: 1 of 2 functions proved"


CHANGES = [
    (r" \+ ", " - "),
    (r" - ", " + "),
    (r" \* ", " + "),
    (r" < ", " <= "),
    (r" > ", " >= "),
    (r"\[0\]", "[1]"),
    (r" \| ", " & "),
    (r" & ", " | "),
    (r"([0-9])\.0f", r"\g<1>.5f"),
    (r" = ", " = -"),
]


def is_statement(line: str) -> bool:
    return line.startswith("    ") and "for (" not in line and "*/" not in line


def mutants(text: str, count: int) -> list[tuple[str, str]]:
    """(line, text with this line changed) of `count` statements, spread evenly over the functions."""
    lines = text.splitlines()
    changed: list[tuple[str, str]] = []
    for number, line in enumerate(lines):
        pattern, new = CHANGES[number % len(CHANGES)]
        mutant = re.sub(pattern, new, line, count=1)
        if is_statement(line) and mutant != line:
            changed.append((mutant.strip(), "\n".join([*lines[:number], mutant, *lines[number + 1 :]])))
    return changed[:: max(1, len(changed) // count)]


@pytest.mark.proof
def test_no_fault_that_samples_show_is_proved_equal_and_most_faults_are_seen() -> None:
    """Faults of the C, each judged twice: by samples of the compiled code, and by the proof, up to a call left open."""
    model = random_model(2, complete=True)
    texts = generate(model)
    name = f"{model.name}.c"
    settings = VerifySettings(4000, compilers=["cc"], levels=["-O0"])
    judged, unseen = 0, []
    for line, text in mutants(texts[name], 12):
        changed = {**texts, name: text}
        try:
            sampled = verify_texts(model, changed, settings).mismatches
            by_proof = all(translation(model, changed, calls=[call]).functions[0].holds for call in LATER_FIRST)
        except (BuildError, HysgenError):
            continue  # no C any more
        judged += 1
        assert not sampled or not by_proof, line
        if by_proof:
            unseen.append(line)
    assert judged >= 8
    assert len(unseen) <= judged // 4, unseen  # lines that compute the same, or that these functions do not reach


OF_THE_REFERENCE = [(module, fault) for module, faults in proofs.FAULTS.items() if module for fault in faults]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "fault"),
    [*OF_THE_REFERENCE[:4], *(pytest.param(*both, marks=pytest.mark.proof) for both in OF_THE_REFERENCE[4:])],
)
def test_a_fault_of_the_reference_is_not_proved(module: str, fault: tuple[str, str, str, str]) -> None:
    name, function, *change = fault
    assert proofs.judged(name, (function,), change, module).answers[function] != "proved"


def test_equal_forms_are_proved_without_a_solver_and_the_rest_stays_open(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solver, "SOLVER", "no_such_module")
    folder = shipped("appendix_a")
    result = translation(folder.model, folder.texts, calls=["inverse"])
    (proof,) = result.functions
    assert (proof.holds, proof.difference, result.equal) == (False, "", True)
    assert "not proved" in proof.line()


def test_what_is_said_twice_is_said_once() -> None:
    """Three parts that hear one channel set the same bit of the status: the C says it three times."""
    graph = Graph()
    x, y = graph.param(0), graph.param(1)
    sweep = Sweep(lambda op: np.arange(SAMPLES, dtype=np.uint32) * np.uint32(1 + op.number))
    for kind in ("or", "and"):
        once = graph.op(kind, x, y)
        (pair,) = sweep.pairs([(graph.op(kind, once, graph.op(kind, y, x)), once)])
        assert pair[0] is pair[1]
    assert sweep.asked == 0


def test_equal_bits_are_no_proof_and_assumptions_are_used() -> None:
    """x < 8 and x > 7 part at 7.5 alone; both say the same of every drawn whole number."""
    graph = Graph()
    x, seven, eight = graph.param(0), graph.const(0x40E0_0000), graph.const(0x4100_0000)
    below, above = graph.op("cmpltsp", x, eight), negated(graph, graph.op("cmpgtsp", x, seven))

    def drawn(_: Op) -> Any:
        return np.arange(SAMPLES, dtype=np.float32).view(np.uint32)

    (pair,) = Sweep(drawn).pairs([(below, above)])
    assert pair[0] is not pair[1]
    far = graph.op("or", graph.op("cmpltsp", x, seven), graph.op("cmpgtsp", x, eight))
    (pair,) = Sweep(drawn, [far]).pairs([(below, above)])
    assert pair[0] is pair[1]


@pytest.mark.parametrize(
    "call",
    [
        lambda x: x if x[0] > 1 else -x,
        np.sqrt,
        lambda x: x.sum(axis=0),
        lambda x: x + np.float64(0.1),
        lambda x: np.add.reduce(x),
        lambda x: np.cumsum(x),
        lambda x: x.view(np.uint32) // np.uint32(3),
    ],
)
def test_what_cannot_be_traced_is_refused(call: Callable[[Any], Any]) -> None:
    x = Symbols.of(Graph(), [Op("param"), Op("param", number=1)], np.float32)
    with traced(), pytest.raises(KernelRefusalError):
        call(x)
