"""The words of a generated struct before and after a call, as C and ACSL, and case distinctions of the analysis.

Eva computes an interval of every number and no relation between numbers. Code without branches selects by masks, and
Newton's iteration converges because its seed depends on its argument: both are relations. In each case (the sign of x,
the interval of x) every mask is a constant and every seed a narrow interval. A case is an empty ghost branch. The cases
cover all values and assert nothing; without them the text is the generated C, byte for byte.
"""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.checking.proof.eva.boxes import hexadecimal, parts_box, state_box
from hysgen.codegen.structs import interface_of
from hysgen.errors import ModelError
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.float32.learner_numbers import bank_box, committed_gain
from hysgen.model.float32_arithmetic import INFINITY_BITS, LEAST, LIMIT, POWER_LIMIT
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


PIECES_PER_RULE: Final = 12
"""Cases per rule of the displacement, for intervals of numerator and denominator of Eq. (4) that fit together."""

SIGN_BIT: Final = 0x80000000
PIECES_PER_OCTAVE: Final = 4
PIECES_OF_SUM: Final = 6
"""Cases of a state, so that the interval of the rounded sum stays below the limit."""
PIECES_OF_STEP: Final = 10
"""Cases of the step of a state, as wide as those of the state: over its limit, for the rest that the step takes in, and
two thirds of it, which no mode below a twelfth of the sampling rate passes."""


@dataclass(frozen=True)
class Split:
    """Cases that the analysis keeps separate behind a hook of the templates.

    hook: name of the hook. borders: conditions on one number, C text, each true wherever the one before it is.
    """

    hook: str
    borders: tuple[str, ...]


def splits(model: Model) -> list[Split]:
    """The cases of the functions of a model's generated C."""
    numbers, kept = coefficients(model), float(LIMIT)
    least, limit = (_bits(size) for size in (float(LEAST), kept))
    cases = [
        *(Split(function, signs("x")) for function in ("finite", "flushed", "inside", "limited")),
        Split("finite: bits", _magnitudes(least, INFINITY_BITS)),
        Split("finite", signs("held")),
        Split("flushed: bits", _magnitudes(least)),
        Split("inside: bits", _magnitudes(limit)),
        Split("limited", signs("low")),
        Split("limited", signs("high")),
        Split("limited: below", ("below == 0u",)),
        Split("limited: above", ("above == 0u",)),
        Split("power_of_two", _roundings("x", POWER_LIMIT)),
        Split("reciprocal", _octaves("x", _sums_range(model))),
        Split("lost", _pieces("high", kept, PIECES_OF_SUM)),
        Split("lost", _pieces("t", kept * PIECES_OF_STEP / PIECES_OF_SUM, PIECES_OF_STEP)),
        Split("cosine_sine: quadrant", tuple(f"quadrant < {k}u" for k in range(1, 4))),
        Split("cosine_sine: r", signs("r")),
    ]
    for kind in (part.kind for part in (*model.terms, *model.blocks) if part.channels):
        cases += [
            Split(f"{kind}_channel", signs("self->sample[c][0]")),
            Split(f"{kind}_channel: finite", ("rejected == 0u",)),
            Split(f"{kind}_channel: inside", _around("inside", f"{model.name}_{kind}_middle[c]")),
        ]
    if any(block.kind == "hysteresis" for block in model.blocks):
        cases.append(Split("magnitude", signs("x")))
    for function in ("predict", "simulate", "inverse"):
        cases.append(Split(f"{function}: y", displacements(numbers)))
    return cases


@dataclass(frozen=True)
class Join:
    """A hook where the analysis merges the cases so far.

    borders: new cases behind the hook. kept: C conditions whose cases stay separate, in place of the merge.
    """

    hook: str
    borders: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()


def case_lines(splits: Sequence[Split], joins: Sequence[Join] = ()) -> dict[str, list[str]]:
    """The lines of the proof by hook: ghost branches of the splits and the merges of the joins."""
    lines: dict[str, list[str]] = {}
    for split in splits:
        lines.setdefault(split.hook, []).append(f"    /*@ ghost {_tree(split.borders)} */")
    for join in joins:
        notes = [f"//@ split {condition};" for condition in join.kept] or ["//@ slevel merge;"]
        notes += [f"/*@ ghost {_tree(join.borders)} */"] if join.borders else []
        lines.setdefault(join.hook, []).extend(f"    {note}" for note in notes)
    return lines


def _tree(borders: Sequence[str]) -> str:
    """Nested empty branches, as deep as a binary search over the borders.

    >>> _tree(["x < 0.0f", "x <= 0.0f"])
    'if (x <= 0.0f) { if (x < 0.0f) { ; } else { ; } } else { ; }'
    """
    if not borders:
        return ";"
    middle = len(borders) // 2
    left, right = _tree(borders[:middle]), _tree(borders[middle + 1 :])
    return f"if ({borders[middle]}) {{ {left} }} else {{ {right} }}"


def _bits(x: float) -> int:
    return int(np.float32(x).view(np.uint32))


def _magnitudes(*borders: int) -> tuple[str, ...]:
    """Borders of a bit pattern at magnitudes, for both signs."""
    places = [*borders, SIGN_BIT, *(SIGN_BIT + border for border in borders)]
    return tuple(f"bits < 0x{place:08x}u" for place in places)


def _around(x: str, middle: str) -> tuple[str, ...]:
    return (f"{x} < {middle}", f"{x} <= {middle}")


def signs(x: str) -> tuple[str, ...]:
    return (f"{x} < 0.0f", f"{x} <= 0.0f")


def _pieces(x: str, reach: float, count: int) -> tuple[str, ...]:
    """`count` pieces of equal width over -reach .. reach."""
    return _below(x, np.linspace(-reach, reach, count + 1)[1:-1])


def _below(x: str, borders: Sequence[float] | np.ndarray) -> tuple[str, ...]:
    return tuple(f"{x} < {hexadecimal(float(border))}" for border in borders)


def _octaves(x: str, over: Interval) -> tuple[str, ...]:
    """Borders of equal ratio over positive magnitudes, and their negatives."""
    first, last = (int(np.floor(np.log2(end))) for end in (over.low, over.high))
    sizes = [
        2.0**octave * (1.0 + piece / PIECES_PER_OCTAVE)
        for octave in range(first, last + 1)
        for piece in range(PIECES_PER_OCTAVE)
    ]
    return _below(x, [*(-size for size in reversed(sizes)), *sizes])


def _roundings(x: str, limit: float) -> tuple[str, ...]:
    """Borders where the nearest integer of x changes; each half is a case of its own."""
    halves = np.arange(-np.ceil(limit) - 0.5, limit + 1.0)
    return tuple(f"{x} {sign} {hexadecimal(float(half))}" for half in halves for sign in ("<", "<="))


def displacements(numbers: Coefficients) -> tuple[str, ...]:
    """Borders in the displacement range; the cases are narrower where more rules fire whose strengths rise with r."""
    low, high = float(numbers.y_min_um), float(numbers.y_max_um)
    count = PIECES_PER_RULE * (numbers.rules - 1)
    even = np.linspace(0.0, 1.0, count + 1)[1:-1]
    if numbers.windowed:
        return _below("y", low + (high - low) * even)
    # With s = (y - y_min)/h the sums behave as powers of r of degree 1 + s.
    last = numbers.rules - 1.0
    s = np.sqrt(1.0 + even * ((1.0 + last) ** 2 - 1.0)) - 1.0
    return _below("y", low + (high - low) * s / last)


def _sums_range(model: Model) -> Interval:
    """Bounds, with a margin, of the magnitudes of the denominators: sums over the rules."""
    numbers = coefficients(model)
    if numbers.windowed:
        gains = np.abs(numbers.bank.gain[numbers.bank.gain != 0.0].astype(np.float64))
        return Interval(0.25 * min(1.0, float(gains.min(initial=1.0))), 64.0)
    y = np.linspace(float(numbers.y_min_um), float(numbers.y_max_um), 1001)
    r = 2.0 ** ((y - float(numbers.origin_um)) * float(numbers.per_step))
    powers = r[:, None] ** np.arange(numbers.rules)
    weight = powers @ numbers.strength.astype(np.float64)
    gains = [np.abs(powers @ numbers.bank.gain.astype(np.float64))]
    if model.learner:
        committed = committed_gain(model)
        gains = [committed.low * weight, committed.high * weight]
    sums = np.stack([weight, *gains])
    return Interval(0.25 * float(sums[sums > 0.0].min(initial=1.0)), 4.0 * float(sums.max()))
