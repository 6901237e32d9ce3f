"""Numbers with their errors, over many cells at once: intervals, and a tape of the operations between them.

Every operation x = op(a, b) of the float32 reference leaves x = op(a, b) + e with |e| <= half the last bit of the
largest |x|, every float32 number is the exact one plus a difference that is known. By the mean value theorem, along the
straight way from no error to all of them,

    |y_float32 - y_real|  <=  | sum_c A_c d_c |  +  sum_i |A_i| e_i,        A = dy/dx, by reverse differentiation,

with every A an interval over all numbers on that way; float64 rounds outwards.

2^x and 1/x enter with the relative errors that tests/float32/test_arithmetic.py holds them to, for every float32.
Source of the method: Solovyev et al., Rigorous estimation of floating-point round-off errors with symbolic Taylor
expansions (2018), here with intervals of the first derivative instead of a second-order remainder.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.model import float32_arithmetic as arithmetic

Floats = NDArray[np.float64]

HALF_BIT: Final = 2.0**-24
UNDERFLOW: Final = 2.0**-126
"""Error of a result that is too small to be normal, zeroed or not."""
LIBRARY: Final = 2.0**-45
"""Relative error allowed to the float64 library and to a few operations behind it: 128 times their last bit."""


@dataclass(frozen=True)
class Interval:
    """low <= x <= high in every cell."""

    low: Floats
    high: Floats

    @classmethod
    def over(cls, *values: Any, apart: float = 0.0) -> Interval:
        """The smallest interval over these numbers, outwards by one last bit and `apart` of their size."""
        low, high = functools.reduce(np.minimum, values), functools.reduce(np.maximum, values)
        if apart:
            low, high = low - apart * np.abs(low), high + apart * np.abs(high)
        return cls(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))

    @property
    def size(self) -> Floats:
        return np.maximum(np.abs(self.low), np.abs(self.high))

    def __add__(self, other: Interval) -> Interval:
        return Interval(np.nextafter(self.low + other.low, -np.inf), np.nextafter(self.high + other.high, np.inf))

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __mul__(self, other: Interval | int) -> Interval:
        """The product with an interval, or with 1 or -1."""
        if isinstance(other, int):
            return self if other == 1 else -self
        if self is other:
            low = np.where(self.low * self.high < 0.0, 0.0, np.minimum(np.abs(self.low), np.abs(self.high)))
            return Interval.over(low * low, self.size * self.size)
        return Interval.over(*(a * b for a in (self.low, self.high) for b in (other.low, other.high)))


@dataclass
class Tape:
    """The numbers of one evaluation, in order. An operation that was done before has the same bits: one error.

    rule: the one that is nearest in each cell.
    """

    rule: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    numbers: list[Enclosed] = field(default_factory=list)
    done: dict[tuple[str, tuple[int, ...]], Enclosed] = field(default_factory=dict)

    def number(
        self,
        value: Interval,
        operands: tuple[tuple[int, Interval | int], ...] = (),
        rounding: Floats | float = 0.0,
        known: Interval | None = None,
    ) -> Enclosed:
        """A further number: value is that without its rounding."""
        value = Interval.over(value.low - rounding, value.high + rounding)
        self.numbers.append(Enclosed(self, len(self.numbers), value, operands, rounding, known))
        return self.numbers[-1]

    def constant(self, exact: Floats | float, rounded: Any, size: float = 0.0) -> Enclosed:
        """A number of the model, or one of each cell, computed from others of magnitude `size`, and its float32."""
        numbers, singles = np.atleast_1d(exact), np.atleast_1d(rounded).astype(np.float64)
        apart = LIBRARY * np.maximum(np.abs(numbers), size)
        ends = Interval.over(numbers - apart, numbers + apart)
        both = Interval.over(ends.low, ends.high, singles)
        return self.number(both, known=Interval.over(singles - ends.low, singles - ends.high))


@dataclass(frozen=True)
class Enclosed:
    """A number of the reference with its error: value; operands with the derivative by each; what it adds to the error.

    rounding: largest |e|. known: interval of a difference whose sign is known.
    """

    tape: Tape
    place: int
    value: Interval
    operands: tuple[tuple[int, Interval | int], ...]
    rounding: Floats | float
    known: Interval | None

    def then(
        self, kind: str, exact: Interval, operands: Sequence[tuple[Enclosed, Interval | int]], rounding: Any = None
    ) -> Enclosed:
        """The result of an operation: its exact value, and the largest error, by default half the last bit."""
        pairs = tuple((operand.place, slope) for operand, slope in operands)
        key = kind, tuple(place for place, _ in pairs)
        if key not in self.tape.done:
            if rounding is None:
                rounding = half_bit(exact.size)
            self.tape.done[key] = self.tape.number(exact, pairs, rounding)
        return self.tape.done[key]

    def __array_function__(self, function: Any, types: Any, arguments: Any, named: Any) -> Enclosed:
        """What `powers` asks of NumPy: the number 1 like another."""
        assert function is np.full_like
        return self.tape.constant(float(arguments[1]), arguments[1])

    def __add__(self, other: Enclosed) -> Enclosed:
        return self.then("+", self.value + other.value, [(self, 1), (other, 1)])

    def __sub__(self, other: Enclosed) -> Enclosed:
        return self.then("-", self.value + -other.value, [(self, 1), (other, -1)])

    def __mul__(self, other: Enclosed) -> Enclosed:
        return self.then("*", self.value * other.value, [(self, other.value), (other, self.value)])


def _power(x: Enclosed) -> Enclosed:
    assert (x.value.size <= arithmetic.POWER_LIMIT).all(), "2^x outside the range of its error"
    exact = Interval.over(np.exp2(x.value.low), np.exp2(x.value.high), apart=LIBRARY)
    slope = exact * Interval.over(np.log(2.0), apart=LIBRARY)
    return x.then("2^", exact, [(x, slope)], arithmetic.POWER_RELATIVE_ERROR * exact.size)


def _reciprocal(x: Enclosed) -> Enclosed:
    """Unbounded where x may be 0, or outside the range of the stated error: a smaller cell is needed there."""
    least = np.minimum(np.abs(x.value.low), np.abs(x.value.high))
    known = (
        (x.value.low * x.value.high > 0.0)
        & (least >= arithmetic.RECIPROCAL_LEAST)
        & (x.value.size <= arithmetic.RECIPROCAL_MOST)
    )
    ends = (np.where(known, 1.0 / end, sign * np.inf) for end, sign in ((x.value.low, 1.0), (x.value.high, -1.0)))
    exact = Interval.over(*ends)
    return x.then("1/", exact, [(x, -(exact * exact))], arithmetic.RECIPROCAL_RELATIVE_ERROR * exact.size)


def _flushed(x: Enclosed) -> Enclosed:
    return x.then("flushed", x.value, [(x, 1)], float(arithmetic.LEAST))


def _nearest(steps: Enclosed) -> tuple[NDArray[np.int64], Enclosed]:
    """The rule of each cell; the distance from it is exact."""
    away = -steps.tape.rule.astype(np.float64)
    return steps.tape.rule, steps.then("nearest", steps.value + Interval(away, away), [(steps, 1)], 0.0)


for _name, _of_intervals in (
    ("power_of_two", _power),
    ("reciprocal", _reciprocal),
    ("flushed", _flushed),
    ("nearest", _nearest),
):
    getattr(arithmetic, _name).register(Enclosed, _of_intervals)


def largest_error(result: Enclosed) -> Floats:
    """Bound of |float32 - real| of a result in every cell."""
    unit = np.ones_like(result.value.low)
    return _propagated(result.tape, {result.place: Interval(unit, unit)})


def quotient_error(product: Enclosed, ratio: Interval, divides: Floats | None = None) -> Floats:
    """`largest_error` of a product n (1/d), where n/d lies in `ratio` in real arithmetic, and |d| >= `divides`."""
    numbers = product.tape.numbers
    (numerator, _), (inverse, _) = product.operands
    divisor = numbers[numbers[inverse].operands[0][0]]
    unit = np.ones_like(divisor.value.low)
    of_sums = _propagated(product.tape, {numerator: Interval(unit, unit), divisor.place: -ratio})
    least = np.where(divisor.value.low * divisor.value.high > 0.0, np.abs([divisor.value.low, divisor.value.high]), 0.0)
    off = of_sums / np.maximum(least.min(axis=0), np.zeros(1) if divides is None else divides)
    off = off + arithmetic.RECIPROCAL_RELATIVE_ERROR * (ratio.size + off)
    return counted(off + half_bit(ratio.size + off))


def slopes(tape: Tape, slopes_of: Mapping[int, Interval]) -> list[Interval]:
    """Slopes by every number up to the last of a sum of numbers, whose places and factors are given."""
    last = max(slopes_of)
    zero = np.zeros_like(slopes_of[last].low)
    all_slopes = [slopes_of.get(place, Interval(zero, zero)) for place in range(last + 1)]
    for number in reversed(tape.numbers[: last + 1]):
        for place, derivative in number.operands:
            all_slopes[place] = all_slopes[place] + all_slopes[number.place] * derivative
    return all_slopes


def _propagated(tape: Tape, slopes_of: Mapping[int, Interval]) -> Floats:
    """Bound of the error of a sum of numbers by their places, each with its factor."""
    known, rounding = Interval(np.zeros(1), np.zeros(1)), np.zeros(1)
    for slope, number in zip(slopes(tape, slopes_of), tape.numbers, strict=False):
        rounding = rounding + slope.size * number.rounding
        if number.known is not None:
            known = known + slope * number.known
    return counted(known.size + rounding)


def counted(error: Floats) -> Floats:
    """The bound with the float64 rounding of its own sums; infinite where there is none."""
    return np.where(np.isfinite(error), error * (1.0 + LIBRARY), np.inf)


def half_bit(size: Floats) -> Floats:
    """Largest rounding error of a result up to `size`."""
    rounding: Floats = np.ldexp(HALF_BIT, np.frexp(size)[1] - 1) + UNDERFLOW
    return rounding
