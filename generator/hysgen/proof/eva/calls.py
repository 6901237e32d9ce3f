"""What Eva is given: one call of a generated function from any state of the certified box, and what must hold then."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.emit.render import render
from hysgen.inputs.delay import Delay
from hysgen.model import Model
from hysgen.proof.eva.boxes import KEPT, instance_box
from hysgen.proof.eva.frama import Floats, Verdict, analyse
from hysgen.proof.eva.intervals import ANY, Interval, hexadecimal
from hysgen.proof.eva.splits import annotated, splits
from hysgen.proof.layout import words
from hysgen.terms import channels_of

ENTRY: Final = "step.c"

FUNCTIONS: Final[Mapping[str, int]] = {"init": 2, "predict": 2, "simulate": 1, "inverse": 2, "aux": 0}
"""Functions of an instance, and how many floats they take."""


@dataclass(frozen=True)
class Assumed:
    """A word of the state: what it may be before the call, and what it has to be afterwards, as C and ACSL.

    label: names the check; demanded: empty if the word may have any bits.
    """

    path: str
    label: str
    any: str
    demanded: str


def functions(model: Model, texts: Mapping[str, str]) -> tuple[str, ...]:
    """The functions of an instance that the generated header declares."""
    header = texts[f"{model.name}.h"]
    return tuple(function for function in FUNCTIONS if re.search(rf"\b{model.name}_{function}\(", header))


def step(model: Model, texts: Mapping[str, str], function: str, inputs: Floats) -> tuple[dict[str, str], int]:
    """The C that Eva analyses for one call, and the number of its checks.

    inputs: every finite float, or any 32 bits. Raises ModelError if the model holds what the proof does not know.
    """
    name, known = model.name, _instance(model, texts)
    floats = {"finite": _between(ANY), "any": f"{name}_float(Frama_C_unsigned_int_interval(0u, 0xffffffffu))"}
    source = annotated(name, texts[f"{name}.c"], splits(model, KEPT))
    if inputs == "any":
        source = _finite_checked(name, source)
    facts = {
        "name": name,
        "function": function,
        "words": known,
        "inputs": FUNCTIONS[function],
        "channels": len(channels_of(model.terms)) if function == "aux" else 0,
        "input": floats[inputs],
        "result": "float" if function in ("predict", "simulate", "inverse") else "",
    }
    checks = sum(word.demanded != "" for word in known) + (facts["result"] == "float")
    return {**texts, f"{name}.c": source, ENTRY: render("proof/step.c.j2", facts)}, checks


def prove_call(model: Model, texts: Mapping[str, str], function: str, inputs: Floats) -> tuple[Verdict, int]:
    """What Eva says of one call, and how many checks it must have come to."""
    sources, checks = step(model, texts, function, inputs)
    return analyse(sources, ENTRY, inputs), checks


def _instance(model: Model, texts: Mapping[str, str]) -> list[Assumed]:
    """Every word of `<name>_t` but the banks, which hold the model's parameters as init wrote them."""
    box = instance_box(model)
    bounds = _integers(model)
    found = []
    for word in words(texts[f"{model.name}.h"], f"{model.name}_t"):
        if word.path.startswith("bank["):
            continue
        path, label = f"self.{word.path}", re.sub(r"\W+", "_", word.path).strip("_")
        if word.type == "float":
            found.append(Assumed(path, label, _between(box[word.path]), _inside(path, box[word.path])))
        else:
            largest = bounds.get(word.path)
            any_number = f"Frama_C_unsigned_int_interval(0u, {largest or 0xFFFFFFFF:#x}u)"
            found.append(Assumed(path, label, any_number, f"{path} <= {largest}" if largest else ""))
    return found


def _integers(model: Model) -> dict[str, int]:
    """Largest value of the integers that index something."""
    rings = [block.ring for block in model.blocks if isinstance(block, Delay)]
    return {"active": 1} | ({"inputs.delay.newest": rings[0] - 1} if rings else {})


def _between(interval: Interval) -> str:
    return f"Frama_C_float_interval({hexadecimal(interval.low)}, {hexadecimal(interval.high)})"


def _inside(path: str, interval: Interval) -> str:
    low, high = hexadecimal(interval.low)[:-1], hexadecimal(interval.high)[:-1]
    return rf"\is_finite({path}) && {low} <= {path} <= {high}"


def _finite_checked(name: str, source: str) -> str:
    r"""`source` with a check behind every input that was looked at: from there on it is finite, whatever came in.

    With it the rest of the call is what the proof for finite inputs has seen.
    """
    pattern = rf"^(    const float (\w+) = {name}_finite\(.*\);)$"
    return re.sub(pattern, r"\1\n    //@ check finite: \\is_finite(\2);", source, flags=re.MULTILINE)
