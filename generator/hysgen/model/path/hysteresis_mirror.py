"""Float32 of the hysteresis: the constants of the generated C, its mirror over lanes, and its inverse by Newton steps.

    h(x) = even(x^2) + x odd(x^2) + sum_j z_j q_j(z_j) + side sum_i d_i (b_i + c_i |d_i|)
    x = (v - middle) / half range, limited to -1 .. 1
    d_i = 1 - left_i e_i,   e_0 = 2^(-log2(e) |x - turn| / reach),   e_(i+1) = e_i^2

d_i is the Duhem state measured along the input's direction, side = 1 up and -1 down. On the way from one turn of the
input to the next it decays from its value at the turn, left_i = 1 - d_i(turn), over the distance from the turn. The
rounding errors of slow motion therefore do not accumulate, as they would in d_i <- d_i + (1 - e)(1 - d_i), whose
increments vanish in float32. At a turn the direction changes sign: left_i = 1 + d_i.

solve(wanted): Newton steps from the last x on the function of x at the present state, on the side of the last x on
which `wanted` lies. h is monotone and piecewise smooth there.

Denormal numbers: x and every z_j are 0 or at least 2^-40 in magnitude (the half-widths are at least 2^-12), every
coefficient at least 2^-40. A partial sum c + z q of a polynomial is then 0 or at least 2^-65, because it is a multiple
of the last bit of its smaller part, and no product falls below 2^-126.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.machine.kernels import HysteresisSeries
from hysgen.model.float32_arithmetic import flushed, power_of_two, reciprocal
from hysgen.model.float32_constants import LEAST
from hysgen.model.intervals import Interval
from hysgen.model.path.base import BlockMirror, Floats, Floats32, limited
from hysgen.model.structs import Member

GROUP: Final = 4
"""Plays that one pass of the loop of the C computes side by side; plays without effect fill the last group."""

STEPS: Final = 4
"""Newton steps of `solve`."""

LEAST_SLOPE: Final = 0.02
"""Smallest slope of a Newton step, as a part of the mean slope."""

LOG2_E: Final = 1.4426950408889634

ONE, ZERO = np.float32(1.0), np.float32(0.0)

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Numbers:
    """The float32 constants.

    middle, half, per_half: of the input range in V and 1/V. curve, curve_slope: (C + 1,) and (C,) coefficients of the
    powers of x in um, and of their derivative. play: (rows, 1 + D) half-width and coefficients of z .. z^D, rows a
    multiple of GROUP. rate: exponent of the first Duhem state, -log2(e) / reach. duhem: (s, 3) b, c, 1 / reach.
    slope: least and largest dh/dx of a Newton step, and 1 / mean dh/dx.
    """

    middle: np.float32
    half: np.float32
    per_half: np.float32
    curve: Floats32
    curve_slope: Floats32
    play: Floats32
    rate: np.float32
    duhem: Floats32
    slope: Floats32

    @classmethod
    def of(cls, series: HysteresisSeries, range_V: Interval, slopes: Interval, mean_slope: float) -> Numbers:
        """The constants of the operator `series` over range_V; slopes, mean_slope: dh/dx in um per half range.

        Raises ModelError if h does not change over the input range.
        """
        middle, half = np.float32(0.5 * (range_V.low + range_V.high)), 0.5 * range_V.width
        curve = _powers(series.curve)
        plays, degree = len(series.half_width), series.plays.shape[1]
        play = np.zeros((-(-plays // GROUP) * GROUP, 1 + degree))
        play[:, 0] = 1.0
        for row, r, coefficients in zip(play, series.half_width, series.plays, strict=False):
            powers = _powers(np.concatenate([[0.0], coefficients]))
            curve[0] += powers[0]
            row[0], row[1:] = r, powers[1:]
        duhem = np.column_stack([_coefficients(series.duhem), (1.0 / series.reach).astype(np.float32)])
        return cls(
            middle if abs(middle) >= LEAST else ZERO,
            np.float32(half),
            np.float32(1.0 / half),
            _coefficients(curve),
            _coefficients(curve[1:] * np.arange(1.0, curve.size)),
            np.column_stack([play[:, :1].astype(np.float32), _coefficients(play[:, 1:])]),
            np.float32(-LOG2_E / series.reach[0]) if series.reach.size else ZERO,
            duhem,
            _newton_slopes(slopes, mean_slope),
        )


def _powers(series: Floats) -> Floats:
    """Coefficients of the powers of x, of a Chebyshev series; as many."""
    found = np.zeros(series.size)
    powers = chebyshev.cheb2poly(series)
    found[: powers.size] = powers
    return found


def _coefficients(exact: Floats) -> Floats32:
    """Float32 of coefficients, none below 2^-40 in magnitude, so that no product of them is denormal."""
    rounded = exact.astype(np.float32)
    return np.where(np.abs(rounded) < LEAST, np.where(rounded < 0.0, -LEAST, LEAST), rounded)


def _newton_slopes(slopes: Interval, mean: float) -> Floats32:
    """(3,) least and largest slope of a Newton step, in the order of numbers, and 1 / mean slope.

    `slopes` bounds the parts of h one by one, so its end next to 0 may have the wrong sign; slopes below LEAST_SLOPE of
    the mean are not believed.
    """
    if abs(mean) < LEAST:
        raise ModelError("hysteresis: the output does not change over the range of the input; fit the model again")
    least = LEAST_SLOPE * mean
    low, high = (max(slopes.low, least), slopes.high) if mean > 0.0 else (slopes.low, min(slopes.high, least))
    return np.array([low, high, 1.0 / mean]).astype(np.float32)


class HysteresisMirror(BlockMirror):
    """The float32 operator over lanes, at rest under the input v_V of the constructor."""

    def __init__(self, numbers: Numbers, members: tuple[Member, ...], v_V: Floats32) -> None:
        self.members = members
        self._numbers = numbers
        x = self._normalised(v_V)
        self.play = [limited(x, -(ONE - row[0]), ONE - row[0]) for row in self._numbers.play]
        self.left = [np.ones_like(x) for _ in self._numbers.duhem]
        self.back = [np.ones_like(x) for _ in self._numbers.duhem]
        self.turn = self.last = self.h_um = x
        self.apply(v_V)

    def rest(self) -> Floats32:
        return self.h_um

    def apply(self, u_V: Floats32) -> Floats32:
        x = self._normalised(u_V)
        for j, row in enumerate(self._numbers.play):
            z, low, high = self.play[j], x - row[0], x + row[0]
            pulled = np.where(z > high, high, z)
            self.play[j] = np.where(pulled < low, low, pulled)
        values = [_polynomial(z, row) for z, row in zip(self.play, self._numbers.play, strict=True)]
        h = _grouped(_series(x, self._numbers.curve), values)
        if len(self._numbers.duhem):
            falls = (x < self.last) | ((self.last < self.turn) & (x <= self.last))
            self.turn, self.left = self._turned(falls)
            states = [ONE - left * e for left, e in zip(self.left, self._decays(x, self.turn), strict=True)]
            self.back = [ONE + d for d in states]
            parts = [d * (b + c * np.abs(d)) for d, (b, c, _) in zip(states, self._numbers.duhem, strict=True)]
            h = np.asarray(h + np.where(falls, -ONE, ONE) * _total(parts))
        self.last, self.h_um = x, h
        return h

    def solve(self, wanted: Floats32) -> Floats32:
        """v for which `apply` would return `wanted`, after STEPS Newton steps

            x <- x - (h(x) - wanted) / h'(x)

        from the last x; h' limited to the constants `slope`, x to the side of the last x on which `wanted` lies.
        """
        least, largest, per_mean = self._numbers.slope
        falls = (wanted - self.h_um) * per_mean < 0.0
        side = np.where(falls, -ONE, ONE)
        low, high = np.where(falls, -ONE, self.last), np.where(falls, self.last, ONE)
        turn, left = self._turned(falls)
        x = self.last
        for _ in range(STEPS):
            h, slope = self._ahead(x, side, turn, left)
            per_slope = reciprocal(limited(slope, least, largest))
            x = flushed(limited(x - (h - wanted) * per_slope, low, high))
        return self._numbers.middle + x * self._numbers.half

    def _ahead(self, x: Floats32, side: Floats32, turn: Floats32, left: list[Floats32]) -> tuple[Floats32, Floats32]:
        """h and dh/dx at an input that has moved on to x in the direction `side` (1 up, -1 down)."""
        plays, rises = [], []
        for z, row in zip(self.play, self._numbers.play, strict=True):
            edge = x - side * row[0]
            taken = side * (edge - z) >= 0.0
            place = np.where(taken, edge, z)
            plays.append(_polynomial(place, row))
            rises.append(np.where(taken, _slope(place, row), ZERO))
        h = _grouped(_series(x, self._numbers.curve), plays)
        slope = _grouped(_series(x, self._numbers.curve_slope), rises)
        if left:
            values, rises = [], []
            for missing, e, (b, c, per_reach) in zip(left, self._decays(x, turn), self._numbers.duhem, strict=True):
                ahead = missing * e
                d = ONE - ahead
                bent = c * np.abs(d)
                values.append(d * (b + bent))
                rises.append((b + (bent + bent)) * (ahead * per_reach))
            h, slope = h + side * _total(values), slope + _total(rises)
        return h, slope

    def _normalised(self, v_V: Floats32) -> Floats32:
        """x of the voltages v_V."""
        return flushed(limited((v_V - self._numbers.middle) * self._numbers.per_half, -ONE, ONE))

    def _turned(self, falls: Flags) -> tuple[Floats32, list[Floats32]]:
        """Last turn and `left` of the Duhem states for a motion in the direction `falls`."""
        turns = falls ^ (self.last < self.turn)
        left = [np.where(turns, new, old) for new, old in zip(self.back, self.left, strict=True)]
        return np.where(turns, self.last, self.turn), left

    def _decays(self, x: Floats32, turn: Floats32) -> list[Floats32]:
        """e_i, (states,), between the turn and x."""
        e = power_of_two(np.abs(x - turn) * self._numbers.rate)
        found = [np.where(e > ONE, ONE, e)]
        while len(found) < len(self._numbers.duhem):
            found.append(found[-1] * found[-1])
        return found


def _series(x: Floats32, coefficients: Floats32) -> Floats32:
    """sum_m c_m x^m as even(x^2) + x odd(x^2), both by Horner's scheme."""
    square = x * x
    return _horner(square, coefficients[0::2]) + x * _horner(square, coefficients[1::2])


def _horner(x: Floats32, coefficients: Floats32) -> Floats32:
    """c_0 + x (c_1 + x (c_2 + ...))"""
    total = np.full_like(x, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = coefficient + x * total
    return total


def _polynomial(z: Floats32, row: Floats32) -> Floats32:
    """g(z) = z q(z),  q(z) = c_1 + z (c_2 + z (c_3 + ...)),  row: half-width, c_1, c_2, ..."""
    return z * _horner(z, row[1:])


def _slope(z: Floats32, row: Floats32) -> Floats32:
    """g'(z) = q(z) + z q'(z), with q' by Horner's scheme on the partial sums of q."""
    q, rise = np.full_like(z, row[-1]), np.zeros_like(z)
    for coefficient in row[-2:0:-1]:
        q, rise = coefficient + z * q, q + z * rise
    return q + z * rise


def _grouped(total: Floats32, parts: list[Floats32]) -> Floats32:
    """total + sum of the parts, GROUP after GROUP."""
    for j in range(0, len(parts), GROUP):
        total = total + ((parts[j] + parts[j + 1]) + (parts[j + 2] + parts[j + 3]))
    return total


def _total(parts: list[Floats32]) -> Floats32:
    """Sum of the parts in their order."""
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total
