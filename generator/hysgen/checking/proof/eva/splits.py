"""Where the analysis looks at cases: ghost code in a copy of the generated C.

Eva knows an interval of every number and no relation between numbers. Code without branches decides by masks, and
Newton's iteration converges because its seed belongs to its argument: both are relations. Looked at case by case (the
sign of x, between which two numbers it lies) every mask is a constant and every seed a narrow interval. The cases are
ghost branches with nothing in them, at the hooks of the templates: they assert nothing, all of them together are all
there are, and the C around them is the generated text to the byte.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.checking.proof.eva.banks import committed_gain
from hysgen.checking.proof.eva.intervals import hexadecimal
from hysgen.float32.coefficients import Coefficients, coefficients
from hysgen.model.float32_constants import INFINITY_BITS, LEAST, POWER_LIMIT
from hysgen.model.intervals import Interval
from hysgen.model.model import Model

PIECES_PER_RULE: Final = 12
"""Pieces of the displacement's range in which numerator and denominator of Eq. (4) stay together."""

SIGN_BIT: Final = 0x80000000
PIECES_PER_OCTAVE: Final = 4
PIECES_OF_SUM: Final = 6
"""Pieces of a state and of what is added to it in which its rounding is seen to stay below the limit."""


@dataclass(frozen=True)
class Split:
    """Cases that the analysis distinguishes from a hook of the templates on.

    hook: name of the hook. borders: conditions on one number, C text, each true wherever the one before it is.
    """

    hook: str
    borders: tuple[str, ...]


def splits(model: Model, kept: float) -> list[Split]:
    """The cases that the functions of a model's generated C are looked at in.

    kept: largest magnitude of an accumulated state.
    """
    numbers = coefficients(model)
    least, limit = (_bits(size) for size in (float(LEAST), kept))
    cases = [
        *(Split(function, signs("x")) for function in ("finite", "flushed", "inside", "limited", "magnitude")),
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
        Split("accumulate", _pieces("*high", Interval(-kept, kept), PIECES_OF_SUM)),
        Split("accumulate: t", _pieces("t", Interval(-kept, kept), PIECES_OF_SUM)),
        Split("cosine_sine: quadrant", tuple(f"quadrant < {k}u" for k in range(1, 4))),
        Split("cosine_sine: r", signs("r")),
        Split("coupling_channel", signs("self->sample[c][0]")),
        Split("coupling_channel: finite", ("rejected == 0u",)),
        Split("coupling_channel: inside", _around("inside", f"{model.name}_coupling_middle[c]")),
    ]
    for function in ("predict", "simulate", "inverse"):
        cases.append(Split(f"{function}: y", displacements(numbers)))
    return cases


@dataclass(frozen=True)
class Join:
    """A hook where the cases so far are taken together again.

    borders: new cases behind the hook. kept: instead of a join, conditions that stay apart from here on, C text.
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
    """Nested branches with nothing in them: each case meets only as many conditions as a search by halves.

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
    """Both signs of a bit pattern, each divided where its magnitude reaches a border."""
    places = [*borders, SIGN_BIT, *(SIGN_BIT + border for border in borders)]
    return tuple(f"bits < 0x{place:08x}u" for place in places)


def _around(x: str, middle: str) -> tuple[str, ...]:
    return (f"{x} < {middle}", f"{x} <= {middle}")


def signs(x: str) -> tuple[str, ...]:
    return (f"{x} < 0.0f", f"{x} <= 0.0f")


def _pieces(x: str, over: Interval, count: int) -> tuple[str, ...]:
    """`count` pieces of equal width."""
    return _below(x, np.linspace(over.low, over.high, count + 1)[1:-1])


def _below(x: str, borders: Sequence[float] | np.ndarray) -> tuple[str, ...]:
    return tuple(f"{x} < {hexadecimal(float(border))}" for border in borders)


def _octaves(x: str, over: Interval) -> tuple[str, ...]:
    """Pieces of equal ratio over positive magnitudes, and the same for negative ones."""
    first, last = (int(np.floor(np.log2(end))) for end in (over.low, over.high))
    sizes = [
        2.0**octave * (1.0 + piece / PIECES_PER_OCTAVE)
        for octave in range(first, last + 1)
        for piece in range(PIECES_PER_OCTAVE)
    ]
    return _below(x, [*(-size for size in reversed(sizes)), *sizes])


def _roundings(x: str, limit: float) -> tuple[str, ...]:
    """Where the nearest integer of x changes; the halves themselves are cases of their own."""
    halves = np.arange(-np.ceil(limit) - 0.5, limit + 1.0)
    return tuple(f"{x} {sign} {hexadecimal(float(half))}" for half in halves for sign in ("<", "<="))


def displacements(numbers: Coefficients) -> tuple[str, ...]:
    """Pieces of the range, narrower where more rules fire whose strengths rise with r."""
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
    """Magnitudes that the sums over the rules can have in a denominator, generously."""
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
