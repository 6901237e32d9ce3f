"""The words of a generated struct before and after a call, as C and ACSL."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.checking.proof.eva.banks import bank_box, state_box
from hysgen.checking.proof.eva.intervals import Interval, hexadecimal
from hysgen.checking.proof.layout import words
from hysgen.model.model import Model
from hysgen.model.path.delay import Delay

ANY_WORD: Final = "Frama_C_unsigned_int_interval(0u, 0xffffffffu)"


@dataclass(frozen=True)
class Assumed:
    """A word of the state: what it may be before the call, and what it has to be afterwards, as C and ACSL.

    label: names the check; demanded: empty if the word may have any bits.
    """

    path: str
    label: str
    any: str
    demanded: str


def instance_words(model: Model, texts: Mapping[str, str]) -> list[Assumed]:
    """Every word of `<name>_t` but the banks: those are of `bank_words`, or as init wrote them."""
    found = [word for word in words(texts[f"{model.name}.h"], f"{model.name}_t") if not word.path.startswith("bank[")]
    floats, integers = state_box(model), {"active": 1, **ring_places(model)}
    return [assumed("self", word.path, floats.get(word.path), integers.get(word.path)) for word in found]


def bank_words(model: Model) -> list[Assumed]:
    """Every number of both banks, within what a learner may commit; none if the model has no learner.

    Not looked at afterwards: no call but commit writes a bank.
    """
    boxes = bank_box(model) if model.learner else {}
    found = [assumed("self", f"bank[{b}].{path}", box, None) for b in range(2) for path, box in boxes.items()]
    return [dataclasses.replace(word, demanded="") for word in found]


def ring_places(model: Model) -> dict[str, int]:
    """Largest index into the ring of a delay, by the path of the index."""
    return {"inputs.delay.newest": block.ring - 1 for block in model.blocks if isinstance(block, Delay)}  # noqa: B035


def assumed(struct: str, word: str, box: Interval | None, largest: int | None) -> Assumed:
    """A word of `struct`: a float if it has a box, else an integer that is at most `largest`, or any."""
    path, label = f"{struct}.{word}", re.sub(r"\W+", "_", word).strip("_")
    if box is not None:
        return Assumed(path, label, between(box), inside(path, box))
    if largest is None:
        return Assumed(path, label, ANY_WORD, "")
    return Assumed(path, label, f"Frama_C_unsigned_int_interval(0u, {largest:#x}u)", f"{path} <= {largest}")


def between(interval: Interval) -> str:
    """Any float of an interval, as C."""
    return f"Frama_C_float_interval({hexadecimal(interval.low)}, {hexadecimal(interval.high)})"


def inside(path: str, interval: Interval) -> str:
    """That a float is finite and in an interval, as ACSL."""
    low, high = hexadecimal(interval.low)[:-1], hexadecimal(interval.high)[:-1]
    return rf"\is_finite({path}) && {low} <= {path} <= {high}"
