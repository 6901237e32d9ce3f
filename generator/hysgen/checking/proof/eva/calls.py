"""The program that Eva analyses for one call: any state of the box before the call, checks of the state after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from hysgen.checking.proof.eva.banks import committed_gain_annotation
from hysgen.checking.proof.eva.boxes import KEPT
from hysgen.checking.proof.eva.frama import Floats, Verdict, analyse
from hysgen.checking.proof.eva.splits import Join, case_lines, splits
from hysgen.checking.proof.eva.states import ANY_WORD, bank_words, between, instance_words
from hysgen.checking.proof.hooked import hooked
from hysgen.codegen.interface import interface_of
from hysgen.codegen.render import render
from hysgen.model.disturbances import channels_of
from hysgen.model.intervals import ANY
from hysgen.model.model import Model

ENTRY: Final = "step.c"

FUNCTIONS: Final[Mapping[str, int]] = {"init": 2, "predict": 2, "simulate": 1, "limits": 3, "inverse": 2, "aux": 0}
"""Functions of an instance and the number of their float arguments."""


JOINS: Final = (Join("span"), Join("allowed"))
"""Merges of the cases of a voltage and its limits, of which the interval of the voltage is all that matters later."""

FINITE_CHECKED: Final[Mapping[str, Sequence[str]]] = {
    f"is_finite: {word}": [rf"    //@ check finite: \is_finite({word});"] for word in ("finite", "y", "u_finite")
}
"""A check behind the replacement of non-finite inputs, by hook: the number is finite for every input.

If these checks hold, the proof for finite inputs covers the rest of the call.
"""


def functions(model: Model, texts: Mapping[str, str]) -> tuple[str, ...]:
    """The functions of an instance that the generated header declares."""
    known = interface_of(model.name, texts)
    return tuple(function for function in FUNCTIONS if known.has(function))


def step(model: Model, texts: Mapping[str, str], function: str, inputs: Floats) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call, and the number of its checks.

    inputs: every finite float, or any 32 bits. Raises ModelError for a state without a box.
    """
    name, known = model.name, instance_words(model, texts)
    banks = [] if function == "init" else bank_words(model)
    floats = {"finite": between(ANY), "any": f"{name}_float({ANY_WORD})"}
    lines: dict[str, Sequence[str]] = {**case_lines(splits(model, KEPT), JOINS)}
    if inputs == "any":
        lines |= FINITE_CHECKED
    if function == "inverse" and banks:
        lines |= {"inverse: sums": [committed_gain_annotation(model)]}
    source = hooked(model, texts, lines)
    facts = {
        "name": name,
        "function": function,
        "words": [*banks, *known],
        "inputs": FUNCTIONS[function],
        "channels": len(channels_of(model.terms)) if function == "aux" else 0,
        "input": floats[inputs],
        "result": "float" if function in ("predict", "simulate", "inverse") else "",
    }
    checks = sum(word.demanded != "" for word in known) + (facts["result"] == "float")
    return {**texts, f"{name}.c": source, ENTRY: render("proof/step.c.j2", facts)}, checks


def prove_call(model: Model, texts: Mapping[str, str], function: str, inputs: Floats) -> tuple[Verdict, int]:
    """Eva's verdict on one call, and the number of checks that a complete analysis reaches."""
    sources, checks = step(model, texts, function, inputs)
    return analyse(sources, ENTRY, inputs), checks
