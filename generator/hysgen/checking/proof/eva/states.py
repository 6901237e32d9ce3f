"""The words of a generated struct before and after a call, as C and ACSL."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from hysgen.checking.proof.eva.banks import bank_box, state_box
from hysgen.checking.proof.eva.boxes import parts_box
from hysgen.checking.proof.eva.intervals import hexadecimal
from hysgen.codegen.interface import interface_of
from hysgen.errors import ModelError
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
from hysgen.model.structs import Word

ANY_WORD: Final = "Frama_C_unsigned_int_interval(0u, 0xffffffffu)"


@dataclass(frozen=True)
class Assumed:
    """A word of the state: a C expression of its values before the call, an ACSL condition of those after it.

    path: the word in C. label: name of the check. any: the expression. demanded: the condition, empty for any bits.
    """

    path: str
    label: str
    any: str
    demanded: str


def instance_words(model: Model, texts: Mapping[str, str]) -> list[Assumed]:
    """Every word of `<name>_t` except the banks, which `bank_words` describes, or init has written."""
    struct = f"{model.name}_t"
    words = [
        word for word in interface_of(model.name, texts).struct(struct).words() if not word.path.startswith("bank[")
    ]
    return assumed("self", struct, words, state_box(model), {"active": 1, **parts_box(model).integers})


def bank_words(model: Model) -> list[Assumed]:
    """Every number of both banks, in the interval that a learner may commit; empty if the model has no learner.

    There are no conditions after the call, because only commit writes a bank.
    """
    boxes = bank_box(model) if model.learner else {}
    words = [float_word("self", f"bank[{b}].{path}", box) for b in range(2) for path, box in boxes.items()]
    return [dataclasses.replace(word, demanded="") for word in words]


def assumed(
    name: str, struct: str, words: Sequence[Word], boxes: Mapping[str, Interval], largest: Mapping[str, int]
) -> list[Assumed]:
    """Words of the C object `name`, of type `struct`: each float in its box, each integer up to its largest value.

    An integer without a largest value may have any value. Raises ModelError for a float without a box: the proof would
    assume any 32 bits and show nothing of that float.
    """
    known: list[Assumed] = []
    for word in words:
        if word.type == "float":
            if word.path not in boxes:
                raise ModelError(
                    f"{struct}: {word.path}: a float without a box; box() of its term or block has to give it"
                )
            known.append(float_word(name, word.path, boxes[word.path]))
        else:
            known.append(integer_word(name, word.path, largest.get(word.path)))
    return known


def float_word(name: str, word: str, box: Interval) -> Assumed:
    """A float of the C object `name` that is in its box before a call and has to be in its box afterwards."""
    path = f"{name}.{word}"
    return Assumed(path, _label(word), between(box), inside(path, box))


def integer_word(name: str, word: str, largest: int | None = None) -> Assumed:
    """An integer of the C object `name` that is at most `largest`, or may have any value."""
    path = f"{name}.{word}"
    if largest is None:
        return Assumed(path, _label(word), ANY_WORD, "")
    return Assumed(path, _label(word), f"Frama_C_unsigned_int_interval(0u, {largest:#x}u)", f"{path} <= {largest}")


def between(interval: Interval) -> str:
    """Any float of an interval, as C."""
    return f"Frama_C_float_interval({hexadecimal(interval.low)}, {hexadecimal(interval.high)})"


def inside(path: str, interval: Interval) -> str:
    """Condition, in ACSL, that a float is finite and in an interval."""
    low, high = hexadecimal(interval.low)[:-1], hexadecimal(interval.high)[:-1]
    return rf"\is_finite({path}) && {low} <= {path} <= {high}"


def _label(word: str) -> str:
    return re.sub(r"\W+", "_", word).strip("_")
