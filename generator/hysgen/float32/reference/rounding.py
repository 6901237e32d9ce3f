"""Proved largest error of one step of the rules: float32 reference against real arithmetic, over a whole box.

The reference's own functions are called with intervals in place of numbers. Every operation x = op(a, b) of theirs
leaves x = op(a, b) + e with |e| <= half the last bit of the largest |x|, every float32 number is the exact one plus a
difference that is known. By the mean value theorem, along the straight way from no error to all of them,

    |y_float32 - y_real|  <=  | sum_c A_c d_c |  +  sum_i |A_i| e_i,        A = dy/dx, by reverse differentiation,

with every A an interval over all numbers on that way. Numbers that numerator and denominator share keep their signs,
which makes the bound tight. The box is divided into cells, and the worst of them counts; float64 rounds outwards.

2^x and 1/x enter with the relative errors that tests/float32/test_arithmetic.py holds them to, for every float32.
Source of the method: Solovyev et al., Rigorous estimation of floating-point round-off errors with symbolic Taylor
expansions (2018), here with intervals of the first derivative instead of a second-order remainder.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.coefficients import Bank, coefficients
from hysgen.float32.reference import instance
from hysgen.machine.reproducible import exp
from hysgen.model import float32_arithmetic as arithmetic
from hysgen.model.model import Model

Floats = NDArray[np.float64]

CELLS: Final = (128, 4)
"""Parts of the range of y and of w, first."""
ENOUGH: Final = 1.1
"""Cells are divided while their bound is larger than that of the worst point of the first cells by this factor."""
DIVISIONS: Final = 6
"""Rounds of division of y in four parts; the bound of what is left then counts as it is."""
HALF_BIT: Final = 2.0**-24
UNDERFLOW: Final = 2.0**-126
"""Error of a result that is too small to be normal, zeroed or not."""
BEYOND: Final = 0.01
"""Part of the range of w by which the box of the inverse reaches further: where its limits begin to act."""
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
    """The numbers of one evaluation, in order. An operation that was done before has the same bits: one error."""

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

    def constant(self, exact: float, rounded: np.float32, size: float = 0.0) -> Enclosed:
        """A number of the model, computed from others of magnitude `size`, and its float32."""
        apart = LIBRARY * max(abs(exact), size)
        ends = Interval.over(np.full(1, exact - apart), np.full(1, exact + apart))
        both = Interval.over(ends.low, ends.high, float(rounded))
        return self.number(both, known=Interval.over(float(rounded) - ends.low, float(rounded) - ends.high))


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
                rounding = np.ldexp(HALF_BIT, np.frexp(exact.size)[1] - 1) + UNDERFLOW
            self.tape.done[key] = self.tape.number(exact, pairs, rounding)
        return self.tape.done[key]

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


for _name, _of_intervals in (("power_of_two", _power), ("reciprocal", _reciprocal), ("flushed", _flushed)):
    getattr(arithmetic, _name).register(Enclosed, _of_intervals)


def largest_error(result: Enclosed) -> Floats:
    """Bound of |float32 - real| of a result in every cell."""
    numbers = result.tape.numbers[: result.place + 1]
    zero = np.zeros_like(result.value.low)
    slopes = [Interval(zero, zero)] * result.place + [Interval(zero + 1.0, zero + 1.0)]
    known, rounding = Interval(zero, zero), zero
    for number, slope in zip(reversed(numbers), reversed(slopes), strict=True):
        slope = slopes[number.place]
        rounding = rounding + slope.size * number.rounding
        if number.known is not None:
            known = known + slope * number.known
        for place, derivative in number.operands:
            slopes[place] = slopes[place] + slope * derivative
    error = (known.size + rounding) * (1.0 + LIBRARY)  # covers the float64 rounding of these sums
    return np.where(np.isfinite(error), error, np.inf)


def worst(model: Model, path: float, *, inverse: bool = False, missed: float | None = None) -> float:
    """The largest bound over all cells, which are divided until intervals add little to it.

    Of y(k+1) of the rules, whose w is off by `path`; inverse: of the w that is found for y(k+1), or, if the path misses
    that w by up to `missed`, of the y(k+1) that is reached.
    """
    numbers = coefficients(model)
    low, high = float(numbers.w_min), float(numbers.w_max)
    past = BEYOND * (high - low) if inverse else 0.0
    y = np.linspace(float(numbers.y_min_um), float(numbers.y_max_um), CELLS[0] + 1)
    w = np.linspace(low - past, high + past, CELLS[1] + 1)
    ends = [part.ravel() for part in np.meshgrid(y[:-1], w[:-1]) + np.meshgrid(y[1:], w[1:])]
    cells = np.array(ends)[[0, 2, 1, 3]]  # low and high of y, low and high of w

    def bound(cells: Floats) -> Floats:
        with np.errstate(all="ignore"):
            result, gain = _step(model, Interval(*cells[:2]), Interval(*cells[2:]), path, inverse=inverse)
            return largest_error(result) if missed is None else gain.value.size * (largest_error(result) + missed)

    middles = np.repeat(0.5 * (cells[::2] + cells[1::2]), 2, axis=0)
    enough = ENOUGH * float(bound(middles).max())
    worst = 0.0
    for _ in range(DIVISIONS):
        errors = bound(cells)
        dividing = errors > enough
        worst = max(worst, float(errors[~dividing].max(initial=0.0)))
        if not dividing.any():
            return worst
        low, high, *over_w = cells[:, dividing]
        ends = [low + (high - low) * k / 4 for k in range(4)] + [high]
        cells = np.concatenate([np.array([*ends[k : k + 2], *over_w]) for k in range(4)], axis=1)
    return max(worst, float(errors.max()))


def _step(model: Model, y: Interval, w: Interval, path: float, *, inverse: bool) -> tuple[Enclosed, Enclosed]:
    """y(k+1) of the reference in every cell of y and w, or the w that its inverse finds for y and y(k+1); df/dw."""
    tape, numbers, grid = Tape(), coefficients(model), model.grid
    reference: Any = instance

    def vector(exact: Any, rounded: Any) -> Any:
        return [tape.constant(*pair) for pair in zip(exact, rounded, strict=True)]

    # The model's range ends between two float32 numbers: beyond its end, the displacement counts as the end.
    past = Interval(np.minimum(y.low - grid.y_min_um, 0.0), np.maximum(y.high - grid.y_max_um, 0.0))
    y_number, w_number = tape.number(y, known=past), tape.number(w, rounding=path)
    weights = [exp(-0.5 * (rule - (grid.rules - 1) / 2) ** 2) for rule in range(grid.rules)]
    q1, q2, q3 = (weights * column for column in model.consequents.T)
    slope, offset = vector(q1, numbers.bank.slope), vector(q3, numbers.bank.offset)
    bank = Bank(slope, offset, vector(q2, numbers.bank.gain), numbers.bank.weight)
    exact: Any = {
        "origin_um": tape.constant(0.5 * sum(grid.ends_um), numbers.origin_um),
        "per_step": tape.constant(1.0 / (np.log(2.0) * grid.step_um), numbers.per_step),
        "strength": vector(weights, numbers.strength),
    }
    sums = reference.rule_sums(dataclasses.replace(numbers, **exact), bank, y_number)
    result: Enclosed = arithmetic.flushed(reference.next_displacement(sums, y_number, w_number))  # type: ignore[assignment]
    if inverse:
        wanted = tape.number(result.value)
        result = arithmetic.flushed(reference.wanted_input(sums, y_number, wanted))  # type: ignore[assignment]
    return result, sums.gain * arithmetic.reciprocal(sums.weight)
