"""Hysteresis in float32: constants and mirror of the generated C, forward and inverse.

    h(x) = g0(x) + sum_j g_j(z_j) + side sum_i d_i (b_i + c_i |d_i|)
    x = (v - middle) / half range, limited to -1 .. 1;   side = 1 while the input rises, -1 while it falls
    d_i = 1 - left_i e_i,   e_0 = 2^(-log2(e) |x - turn| / reach),   e_(i+1) = e_i^2

d_i is a Duhem state in the direction of the input. It follows in closed form from its value at the last turn of the
input, left_i = 1 - d_i(turn), so rounding errors do not accumulate between two turns. The recursion
d_i <- e d_i + (1 - e) would lose slow motion, because 1 - e is a multiple of 2^-24. At a turn, side and d_i change
sign, and left_i becomes back_i = 1 + d_i.

Inverse: Newton steps on f(x) = side h(side x) in the direction of the wanted output, where both x and f rise with the
motion if h rises with v. Ahead of the present input, the plays are
taken along in the order of their half-widths (z is a 1-Lipschitz function of r). Where n of them are taken along, f is

    f(x) = side [g0(side x) + sum_(j < n) g_j(side (x - r_j))] + side sum_(j >= n) g_j(z_j) + Duhem states

The first part is one polynomial of x; its coefficients for every n and both directions are constants. The second sum,
sum_um[n], is known from the last sample. The first x follows from the mean slope. The number of steps is found for each
block (`hysteresis_steps`).

No product is denormal: x and z_j are 0 or at least 2^-40 in magnitude (r_j >= 2^-12), coefficients are at least 2^-40,
and a partial sum c + z q of a polynomial, a multiple of the last bit of its smaller part, is 0 or at least 2^-65.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from hysgen.errors import ModelError
from hysgen.machine.kernels.operators import HysteresisSeries
from hysgen.machine.reproducible import total
from hysgen.model.float32_arithmetic import LEAST, RECIPROCAL_SEED, accumulate, bits_of, float_of, flushed, power_of_two
from hysgen.model.intervals import Interval
from hysgen.model.path.base import BlockMirror, Floats, Floats32, limited
from hysgen.model.structs import Member

SLACK: Final = np.float32(2.0**-22)
"""Distance in half ranges from which on `solve` takes a play along; larger than the rounding error of z + r."""

RELAXED: Final = 8.0
FROZEN: Final = np.float32(15.0)
"""A play relaxes by RELAXED s beyond 1 - r at most, and not at all FROZEN s or more from its threshold."""

BARRIER: Final = (np.float32(0.25 * 1.4426950408889634), np.float32(0.25 * 1.4426950408889634 / 32.0))
"""Coefficients of a and a^2 in the exponent -log2(e) a (1 + a/32) / 4 of the fourth root of a play's relative step; the
fourth root, because the argument of the float32 power of two is at most 8 in magnitude."""

LEAST_SLOPE: Final = 0.02
"""Smallest slope of a Newton step, as a part of the mean slope."""

LOG2_E: Final = 1.4426950408889634

_SIGN: Final = np.uint32(31)
ZERO, ONE, TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Numbers:
    """The float32 constants.

    middle, half, per_half: of the input range in V and 1/V. play: (m, 1 + D) half-width and coefficients of z .. z^D.
    curve: (2, m + 1, C + 1) coefficients of the powers of x in um, of g0 and the first n plays taken along,

        side [g0(side x) + sum_(j < n) g_j(side (x - r_j))],   first for side = 1, then for side = -1

    rate: exponent of the first Duhem state, -log2(e) / reach. duhem: (s, 3) b, c, 1 / reach. slope: least and largest
    dh/dx of a Newton step, and 1 / mean dh/dx. relax: (m, 3) s, 1 / s and largest |z| of plays that relax, else (0, 3).
    """

    middle: np.float32
    half: np.float32
    per_half: np.float32
    play: Floats32
    curve: Floats32
    rate: np.float32
    duhem: Floats32
    slope: Floats32
    relax: Floats32

    @classmethod
    def of(cls, series: HysteresisSeries, range_V: Interval, slopes: Interval, mean_slope: float) -> Numbers:
        """The constants of the operator `series` over range_V; slopes, mean_slope: dh/dx in um per half range.

        Raises ModelError if h does not change over the input range.
        """
        middle, half = np.float32(0.5 * (range_V.low + range_V.high)), 0.5 * range_V.width
        curve, powers = power_coefficients(series)
        rows = np.stack([_taken_along(curve, powers, side * series.half_width) for side in (1.0, -1.0)])
        rows[1] *= np.where(np.arange(curve.size) % 2 == 1, 1.0, -1.0)
        duhem = np.column_stack([_coefficients(series.duhem), (1.0 / series.reach).astype(np.float32)])
        # The factor b + 2 c of the slope of a state at d = 1 must not be tiny unless it is 0.
        vanishing = np.abs(duhem[:, 0] + (duhem[:, 1] + duhem[:, 1])) < LEAST
        duhem[vanishing, 1] = np.float32(-0.5) * duhem[vanishing, 0]
        return cls(
            middle if abs(middle) >= LEAST else ZERO,
            np.float32(half),
            np.float32(1.0 / half),
            np.column_stack([series.half_width.astype(np.float32), _coefficients(powers[:, 1:])]),
            _coefficients(rows),
            np.float32(-LOG2_E / series.reach[0]) if series.reach.size else ZERO,
            duhem,
            _newton_slopes(slopes, mean_slope),
            _relaxations(series),
        )


def power_coefficients(series: HysteresisSeries) -> tuple[Floats, Floats]:
    """Coefficients of the powers of x in g0, and (m, 1 + D) of z_j in g_j, whose constants are in g0."""
    plays, degree = series.plays.shape
    powers = np.zeros((plays, 1 + degree))
    for row, coefficients in zip(powers, series.plays, strict=True):
        row[:] = _powers(np.concatenate([[0.0], coefficients]))
    curve = np.zeros(max(series.curve.size, 1 + degree))
    curve[: series.curve.size] = _powers(series.curve)
    curve[0] += total(powers[:, 0])
    powers[:, 0] = 0.0
    return curve, powers


def _relaxations(series: HysteresisSeries) -> Floats32:
    """(m, 3) s, 1 / s and largest |z| of plays that relax; (0, 3) of others."""
    if not series.relaxation:
        return np.zeros((0, 3), np.float32)
    s = series.relaxation * series.half_width
    ends = np.minimum(1.0, 1.0 - series.half_width + RELAXED * s)
    return np.column_stack([s, 1.0 / s, ends]).astype(np.float32)


def _powers(series: Floats) -> Floats:
    """Coefficients of the powers of x of a Chebyshev series, in an array of the same size."""
    padded = np.zeros(series.size)
    powers = chebyshev.cheb2poly(series)
    padded[: powers.size] = powers
    return padded


def _taken_along(curve: Floats, plays: Floats, shifts: Floats) -> Floats:
    """(m + 1, C + 1) coefficients of curve(x) + sum_(j < n) play_j(x - shift_j), n = 0 .. m."""
    rows = [curve]
    for play, shift in zip(plays, shifts, strict=True):
        moved = np.zeros(1)
        for coefficient in play[::-1]:
            moved = np.append(0.0, moved) - shift * np.append(moved, 0.0)
            moved[0] += coefficient
        row = rows[-1].copy()
        row[: play.size] += moved[: play.size]
        rows.append(row)
    return np.stack(rows)


def _coefficients(exact: Floats) -> Floats32:
    """Float32 of coefficients, none below 2^-40 in magnitude, so that no product of them is denormal."""
    rounded = exact.astype(np.float32)
    return np.where(np.abs(rounded) < LEAST, np.where(rounded < 0.0, -LEAST, LEAST), rounded)


def _newton_slopes(slopes: Interval, mean: float) -> Floats32:
    """(3,) limits of the slope in a Newton step, the lower one first, and 1 / mean slope.

    slopes: sum of the bounds of every part of h; its end next to 0 may have the wrong sign, and is replaced by
    LEAST_SLOPE of the mean.
    """
    if abs(mean) < LEAST:
        raise ModelError("hysteresis: the output does not change over the range of the input; fit the model again")
    least = LEAST_SLOPE * mean
    low, high = (max(slopes.low, least), slopes.high) if mean > 0.0 else (slopes.low, min(slopes.high, least))
    return np.array([low, high, 1.0 / mean]).astype(np.float32)


class HysteresisMirror(BlockMirror):
    """The float32 operator over lanes, at rest under the input v_V of the constructor; steps: Newton steps."""

    def __init__(self, numbers: Numbers, members: tuple[Member, ...], steps: int, v_V: Floats32) -> None:
        self.members = members
        self._numbers, self._steps = numbers, steps
        x = self._normalised(v_V)
        self.play = [limited(x, -(ONE - row[0]), ONE - row[0]) for row in self._numbers.play]
        self.sum_um = [np.zeros_like(x) for _ in range(len(self.play) + 1)]
        self.left = [np.ones_like(x) for _ in self._numbers.duhem]
        self.back = [np.ones_like(x) for _ in self._numbers.duhem]
        self.turn = self.last = self.h_um = x
        self.apply(v_V)

    def rest(self) -> Floats32:
        return self.h_um

    def apply(self, u_V: Floats32) -> Floats32:
        x = self._normalised(u_V)
        h = series_value(x, self._numbers.curve[0, 0])
        if self.play:
            # All plays in one call, (plays, lanes): each operation rounds as for one play.
            rows = self._numbers.play.T[:, :, None]
            z, low, high = np.array(self.play), x - rows[0], x + rows[0]
            pulled = np.where(z > high, high, z)
            self.play = list(np.where(pulled < low, low, pulled))
            self._sum_plays()
            h = h + self.sum_um[0]
        if len(self._numbers.duhem):
            step, fell = bits_of(x - self.last), self.last < self.turn
            falls = ((step >> _SIGN) != 0) | (fell & (step == 0))
            way = np.where(falls ^ fell, x - self.last, x - self.turn)
            self.turn, self.left = self._turned(falls)
            decays = self._decays(np.abs(way), limit=True)
            states = [ONE - away * e for away, e in zip(self.left, decays, strict=True)]
            self.back = [ONE + d for d in states]
            parts = [d * (b + c * np.abs(d)) for d, (b, c, _) in zip(states, self._numbers.duhem, strict=True)]
            h = np.asarray(h + np.where(falls, -ONE, ONE) * _total(parts))
        self.last, self.h_um = x, h
        return h

    def _sum_plays(self) -> None:
        """sum_um[j] = sum_um[j + 1] + g_j(z_j),    g(z) = z (c_1 + z (c_2 + z (c_3 + ...)))"""
        z = np.array(self.play)
        parts_um = z * horner(z, self._numbers.play.T[1:, :, None])
        total_um = np.zeros_like(self.sum_um[0])
        for j in reversed(range(len(self.play))):
            total_um = self.sum_um[j] = total_um + parts_um[j]

    def solve(self, wanted: Floats32) -> Floats32:
        """Voltages, (lanes,), for which `apply` would return `wanted`: the last of `iterates`."""
        return self.iterates(wanted)[-1]

    def iterates(self, wanted: Floats32) -> list[Floats32]:
        """Voltages, (lanes,), of the mean slope and after every Newton step

            x <- x - (f(x) - side wanted) / f'(x)

        with f' limited to the constants `slope`, and x to the side of the last input on which `wanted` lies.
        """
        least, largest, per_mean = self._numbers.slope
        way = (wanted - self.h_um) * per_mean
        falls = way < 0.0
        side: Floats32 = np.where(falls, -ONE, ONE)
        start, aim = side * self.last, side * wanted
        taken = (
            side * np.array(self.play) + (self._numbers.play[:, :1] - SLACK)
            if self.play
            else np.zeros((0, 1), np.float32)
        )
        turn, away = self._turned(falls)
        turn = side * turn
        sums, lane = np.array(self.sum_um), np.arange(wanted.size)
        x = flushed(limited(start + side * way, start, ONE))
        iterates = [x]
        for _ in range(self._steps):
            e = self._decays(x - turn)
            n = (x > taken).sum(axis=0, dtype=np.int64)
            missed, slope = _polynomial(x, self._numbers.curve[falls.astype(np.int64), n].T)
            missed = missed + (side * sums[n, lane] - aim if self.play else -aim)
            for a, decay, row in zip(away, e, self._numbers.duhem, strict=True):
                part, rise = _duhem(a * decay, row)
                missed, slope = missed + part, slope + rise
            x = flushed(limited(x - _rough_quotient(missed, limited(slope, least, largest)), start, ONE))
            iterates.append(x)
        return [self._numbers.middle + (side * x) * self._numbers.half for x in iterates]

    def _normalised(self, v_V: Floats32) -> Floats32:
        """x of the voltages v_V."""
        return flushed(limited((v_V - self._numbers.middle) * self._numbers.per_half, -ONE, ONE))

    def _turned(self, falls: Flags) -> tuple[Floats32, list[Floats32]]:
        """Last turn and `left` of the Duhem states for a motion in the direction `falls`."""
        turns = falls ^ (self.last < self.turn)
        away = [np.where(turns, new, old) for new, old in zip(self.back, self.left, strict=True)]
        return np.where(turns, self.last, self.turn), away

    def _decays(self, way: Floats32, *, limit: bool = False) -> list[Floats32]:
        """e_i, (states,), over the way from the turn; at most 1 with `limit`."""
        if not len(self._numbers.duhem):
            return []
        e = power_of_two(way * self._numbers.rate)
        decays = [np.where(bits_of(e) > ONE.view(np.uint32), ONE, e) if limit else e]
        while len(decays) < len(self._numbers.duhem):
            decays.append(decays[-1] * decays[-1])
        return decays


class RelaxingMirror(HysteresisMirror):
    """The same operator with plays that relax after each sample; play_low: lower words of the plays.

    `apply` returns the output before the relaxation. sum_um and h_um are those of the relaxed plays, from which `solve`
    starts.
    """

    def __init__(self, numbers: Numbers, members: tuple[Member, ...], steps: int, v_V: Floats32) -> None:
        self.play_low = [np.zeros_like(v_V) for _ in numbers.play]
        self._rest = v_V
        super().__init__(numbers, members, steps, v_V)

    def rest(self) -> Floats32:
        return self._rest

    def apply(self, u_V: Floats32) -> Floats32:
        h = super().apply(u_V)
        x, before = self.last, self.sum_um[0]
        for j, (row, (s, per_s, end)) in enumerate(zip(self._numbers.play, self._numbers.relax, strict=True)):
            z = self.play[j]
            way = x - z
            far = (row[0] - np.abs(way)) * per_s
            near = limited(far, ZERO, FROZEN)
            root = power_of_two(-(near * (BARRIER[0] + BARRIER[1] * near)))
            square = root * root
            step = np.where(far > FROZEN, ZERO, s * (square * square))
            z, self.play_low[j] = accumulate(z, self.play_low[j], np.where(way < ZERO, -step, step))
            self.play[j] = limited(z, -end, end)
        self._sum_plays()
        self._rest = h
        self.h_um = h + (self.sum_um[0] - before)
        return h


def series_value(x: Floats32, coefficients: Floats32 | Sequence[Any]) -> Floats32:
    """sum_m c_m x^m as even(x^2) + x odd(x^2), both by Horner's scheme."""
    square = x * x
    return horner(square, coefficients[0::2]) + x * horner(square, coefficients[1::2])


def horner(x: Floats32, coefficients: Floats32 | Sequence[Any]) -> Floats32:
    """c_0 + x (c_1 + x (c_2 + ...)); coefficients: (C + 1,), or (C + 1, m, 1) for x, (m, lanes)."""
    value: Floats32 = functools.reduce(lambda value, coefficient: coefficient + x * value, coefficients[::-1])
    return value


def _polynomial(x: Floats32, coefficients: Floats32) -> tuple[Floats32, Floats32]:
    """sum_m c_m x^m and its derivative by Horner's scheme; coefficients: (C + 1, lanes)."""
    value = slope = coefficients[-1]
    value = coefficients[-2] + x * value
    for coefficient in coefficients[-3::-1]:
        value, slope = coefficient + x * value, value + x * slope
    return value, slope


def _duhem(ahead: Floats32, row: Floats32) -> tuple[Floats32, Floats32]:
    """Part of a Duhem state d = 1 - ahead in h, and its slope; row: b, c, 1 / reach."""
    b, c, per_reach = row
    d = ONE - ahead
    size = np.abs(d)
    return d * (b + c * size), (b + (c + c) * size) * (ahead * per_reach)


def _rough_quotient(missed: Floats32, slope: Floats32) -> Floats32:
    """missed / slope by the seed of `reciprocal` and one Newton step: relative error at most 0.0027."""
    r = float_of(np.uint32(RECIPROCAL_SEED) - bits_of(slope))
    return (missed * r) * (TWO - slope * r)


def _total(parts: list[Floats32]) -> Floats32:
    """Sum of the parts in their order."""
    return functools.reduce(np.add, parts)
