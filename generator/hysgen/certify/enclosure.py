"""Gain and slope of a model, and rigorous enclosures of their extrema over its operating range.

    gain   b(y) = df/dw = E[q2]
    slope  df/dy = E[q1] + Cov(l, v)/h,     v_l = q_l1 y + q_l2 w + q_l3

E and Cov are taken over the rules with the firing strengths p_l. With s = (y - y_min)/h these are p_l ~ exp(s l -
l^2/2), so about the middle s_i of a cell, with t = s - s_i, p_l = p_l(s_i), o_l = l - E[l] there, and any numbers g_l,

    E[g](t) = c + G(t)/D(t),   G = sum p_l exp(t o_l) (g_l - c),   D = sum p_l exp(t o_l),   c = E[g](0)

(for the slope g_l = v_l + t h q_l1, and c moves with t likewise). The Taylor series of G, D and their quotient come
from the moments sum p_l o_l^k g_l. Their remainder is bounded by Cauchy's estimate: in the disk |t| <= rho

    |D| >= 1 - sum p_l (exp(rho |o_l|) - 1 - rho |o_l|) = delta > 0,   |G| <= sum p_l exp(rho |o_l|) |g_l - c| = gamma,

hence the k-th coefficient of G/D is at most gamma/delta rho^-k. In a cell the extremum of the quadratic part is exact,
and the higher terms are bounded by their absolute values. Cells that may contain the extremum are split until the
enclosure has the requested width. df/dy is affine in w, so its extrema over w are at the ends of its range.

The bounds include rounding. c and the E[l] of o_l may be any numbers, so they may be rounded ones. What is left are
sums and products of the p_l, whose relative error is known (`_relative_error`), and of exact numbers: where each
factor of a term has a relative error of at most e, and a term at most n of them, the sum is off by at most n e times
the sum of the magnitudes of its terms, which the same recursion gives with every sign positive (`Series.magnitude`).
Source: Higham, Accuracy and Stability of Numerical Algorithms (2002), chapter 3.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.reproducible import exponential, product, total
from hysgen.model.model import Model
from hysgen.model.regression import memberships

Floats = NDArray[np.float64]

NARROW = 1e-6
"""Width of the enclosures: absolute for slopes, relative to the largest gain for gains."""

CELLS_PER_RULE = 8
ORDER = 12
RHO = 0.8
MOST_CELLS = 200_000
UNIT = 2.0**-53
"""Relative error of one float64 operation."""
FARTHEST = 39.0
"""Distance from a rule, in steps of the grid, beyond which its strength is 0 in float64."""


@dataclass(frozen=True)
class Extremum:
    """An extremum over the operating range: the value attained at (y, w), and a bound that no point exceeds.

    w: input of the rules in its unit (`Model.w_unit`), None where the quantity does not depend on w.
    """

    value: float
    bound: float
    y_um: float
    w: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {"value": self.value, "bound": self.bound, "y_um": self.y_um, "w": self.w}


@dataclass(frozen=True)
class Cells:
    """Intervals of s: middle, half-width, and the input w of each, (n,) each."""

    middle: Floats
    half: Floats
    w: Floats

    def thirds(self, chosen: NDArray[np.bool_]) -> Cells:
        """The chosen cells, each split in three."""
        shift = np.array([-2.0, 0.0, 2.0]) / 3.0
        middle = (self.middle[chosen, None] + self.half[chosen, None] * shift).ravel()
        return Cells(middle, np.repeat(self.half[chosen] / 3.0, 3), np.repeat(self.w[chosen], 3))


@dataclass(frozen=True)
class Series:
    """A function over cells: Taylor coefficients (n, ORDER) about the middle, and a bound (n,) of the remainder.

    magnitude: the coefficients with the sums of magnitudes in place of sums, (n, ORDER).
    """

    coefficients: Floats
    remainder: Floats
    magnitude: Floats


Quantity = Callable[[Cells], Series]


def gain(model: Model, y_um: Floats) -> Floats:
    """b(y), (n,), at displacements (n,), in um/V or, behind a hysteresis, in um/um."""
    return np.asarray(product(memberships(y_um, model.grid), model.consequents[:, 1]))


def slope(model: Model, y_um: Floats, w: Floats) -> Floats:
    """df/dy, (n,), at displacements inside the grid and inputs, (n,) each: factor of a deviation over one step."""
    p = memberships(y_um, model.grid)
    q1, q2, q3 = model.consequents.T
    v = q1 * y_um[:, None] + q2 * w[:, None] + q3
    v = v - product(p, v)[:, None]
    rule = np.arange(model.grid.rules, dtype=np.float64)
    return np.asarray(product(p, q1) + product(p * v, rule) / model.grid.step_um)


def gain_extrema(model: Model, narrow: float = NARROW) -> tuple[Extremum, Extremum]:
    """Smallest and largest gain b(y), enclosed within `narrow` times the largest |b|."""
    scale = narrow * max(float(np.abs(gain(model, model.grid.centres_um)).max()), np.finfo(np.float64).tiny)
    lowest = _largest(gain_series(model, -1.0), model, (0.0,), scale, absolute=False)
    highest = _largest(gain_series(model, 1.0), model, (0.0,), scale, absolute=False)
    return Extremum(-lowest.value, -lowest.bound, lowest.y_um), Extremum(highest.value, highest.bound, highest.y_um)


def slope_extremum(model: Model, w: tuple[float, ...] | None = None, narrow: float = NARROW) -> Extremum:
    """Largest |df/dy| over the displacement range and the inputs `w`, by default the ends of the range of w."""
    return _largest(slope_series(model), model, w or (model.w_range.low, model.w_range.high), narrow, absolute=True)


def gain_series(model: Model, sign: float = 1.0) -> Quantity:
    """`sign` times b(y) over cells."""

    def quantity(cells: Cells) -> Series:
        firing = _Firing(model, cells.middle)
        g = sign * np.tile(model.consequents[:, 1], (cells.middle.size, 1))
        mean, quotient, size = firing.expectation(g, 0.0)
        magnitude = firing.magnitude(np.abs(g) + np.abs(mean)[:, None], np.zeros_like(g))
        quotient[:, 0] += mean
        magnitude[:, 0] += np.abs(mean)
        return Series(quotient[:, :ORDER], size * _tail(cells.half / RHO, 0), magnitude[:, :ORDER])

    return quantity


def slope_series(model: Model) -> Quantity:
    """df/dy over cells: the derivative of the series of f = E[v]."""
    q1, q2, q3 = model.consequents.T
    h = model.grid.step_um

    def quantity(cells: Cells) -> Series:
        firing = _Firing(model, cells.middle)
        y = model.grid.ends_um[0] + h * cells.middle
        v = q1 * y[:, None] + q2 * cells.w[:, None] + q3
        mean, quotient, size = firing.expectation(v, h * np.broadcast_to(q1, v.shape))
        slopes = quotient[:, 1:] * np.arange(1.0, ORDER + 1.0) / h
        slopes[:, 0] += product(firing.p, q1)
        most_um = np.abs(model.grid.ends_um).max() + h * model.grid.rules
        most = np.abs(q1) * most_um + np.abs(q2) * np.abs(cells.w)[:, None] + np.abs(q3) + np.abs(mean)[:, None]
        own = product(firing.p, np.abs(q1))
        magnitude = firing.magnitude(most, h * (np.abs(q1) + own[:, None]))[:, 1:] * np.arange(1.0, ORDER + 1.0) / h
        magnitude[:, 0] += own
        return Series(slopes, size / (RHO * h) * _tail(cells.half / RHO, 1), magnitude)

    return quantity


class _Firing:
    """Firing strengths in the middle of cells, (n, L), and the moments for expectations over the cells."""

    def __init__(self, model: Model, middle: Floats) -> None:
        index = np.arange(model.grid.rules, dtype=np.float64)
        self.p = memberships(model.grid.ends_um[0] + model.grid.step_um * middle, model.grid)
        offset = index - product(self.p, index)[:, None]
        powers = [self.p]
        for k in range(1, ORDER + 1):
            powers.append(powers[-1] * offset / k)
        # p_l o_l^k / k!, (ORDER + 1, n, L)
        self.moments = np.stack(powers)
        away = RHO * np.abs(offset)
        grown = exponential(away)
        self.most = self.p * grown
        self.delta = 1.0 - product(self.p, grown - 1.0 - away)

    def expectation(self, g: Floats, rising: Floats | float) -> tuple[Floats, Floats, Floats]:
        """E of g_l + t rising_l, (n, L) each, as mean + t (mean of rising) + G/D.

        Returns the mean at t = 0, (n,); the series of G/D, (n, ORDER + 1); and gamma/delta, (n,).
        """
        mean = product(self.p, g)
        g = g - mean[:, None]
        G = product(self.moments, g)
        most = np.abs(g)
        if isinstance(rising, np.ndarray):
            rising = rising - product(self.p, rising)[:, None]
            G[1:] += product(self.moments[:-1], rising)
            most = most + RHO * np.abs(rising)
        D = total(self.moments)
        return mean, _quotient(G, -D), product(self.most, most) / self.delta

    def magnitude(self, g: Floats, rising: Floats) -> Floats:
        """(n, ORDER + 1): sums of the magnitudes of all terms of the series of G/D, for numbers up to g and rising."""
        moments = np.abs(self.moments)
        G = product(moments, g)
        G[1:] += product(moments[:-1], rising)
        return _quotient(G, total(moments))


def _quotient(G: Floats, D: Floats) -> Floats:
    """(n, ORDER + 1): coefficients of G/(1 - D_1 t - D_2 t^2 - ...), of those of G and D, (ORDER + 1, n) each."""
    quotient = np.empty_like(G)
    for k in range(ORDER + 1):
        quotient[k] = G[k] + total(D[1 : k + 1] * quotient[:k][::-1], axis=0)
    return quotient.T.copy()


def _tail(x: Floats, derivative: int) -> Floats:
    """sum_{k >= ORDER} x^k, or sum_{k >= ORDER} (k + 1) x^k for the derivative, 0 <= x < 1."""
    power = functools.reduce(np.multiply, [x] * ORDER)
    if derivative == 0:
        return np.asarray(power / (1.0 - x))
    return np.asarray(power * (ORDER + 1.0 - ORDER * x) / ((1.0 - x) * (1.0 - x)))


def _misplaced(model: Model) -> float:
    """Largest error of a place s and of a distance from a rule, in steps of the grid: eight operations on y and s."""
    grid = model.grid
    return float(8.0 * UNIT * (np.abs(grid.ends_um).max() / grid.step_um + grid.rules))


def _relative_error(model: Model) -> float:
    """Of a term of the coefficients: at most ORDER + 2 factors, each a sum over the rules and a firing strength.

    exp(-d^2/2) is off by d times the error of d, eight operations of d^2/2 and that of exp; its share by L more.
    """
    rules = model.grid.rules
    distance = min(FARTHEST, float(rules))
    strength = UNIT * (4.0 * distance * distance + rules + 16.0) + distance * _misplaced(model)
    return 1.01 * (ORDER + 2) * (strength + UNIT * (2.0 * rules + 2.0 * ORDER + 16.0))


def _largest(quantity: Quantity, model: Model, inputs: tuple[float, ...], narrow: float, absolute: bool) -> Extremum:
    """The largest value (or magnitude) over the displacement range and the given inputs, by branch and bound."""
    low, high = model.grid.places
    count = math.ceil(CELLS_PER_RULE * (high - low))
    half = 0.5 * (high - low) / count
    middle = low + half * (2.0 * np.arange(count) + 1.0)
    cells = Cells(
        np.tile(middle, len(inputs)),
        np.full(count * len(inputs), half),
        np.repeat(np.asarray(inputs, dtype=np.float64), count),
    )
    best, place, excluded = -np.inf, (0.0, 0.0), -np.inf
    off, beside = _relative_error(model), 8.0 * _misplaced(model)
    while True:
        reached = dataclasses.replace(cells, half=cells.half + beside)
        value, bound, at = _peak(series := quantity(reached), reached.half, absolute)
        # delta is above a quarter: gamma/delta is off by no more than 16 times a sum.
        rounding = off * (_polynomial(series.magnitude, reached.half) + 16.0 * series.remainder)
        bound = bound + rounding
        top = int(np.argmax(value))
        if value[top] > best:
            best, place = float(value[top]), (float(cells.middle[top] + at[top]), float(cells.w[top]))
        undecided = bound > best + narrow + rounding  # no smaller cell has less of it
        excluded = max(excluded, float(np.max(bound[~undecided], initial=-np.inf)))
        if not undecided.any() or 3 * np.count_nonzero(undecided) > MOST_CELLS:
            limit = max(best, excluded, float(np.max(bound[undecided], initial=-np.inf)))
            y_um = float(model.grid.clamp(np.array(model.grid.ends_um[0] + model.grid.step_um * place[0])))
            return Extremum(best, limit, y_um, place[1])
        cells = cells.thirds(undecided)


def _peak(series: Series, half: Floats, absolute: bool) -> tuple[Floats, Floats, Floats]:
    """Per cell: value at the extremum of the quadratic part, upper bound over the cell, and t of the extremum."""
    c = series.coefficients
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = np.where(c[:, 2] != 0.0, -0.5 * c[:, 1] / c[:, 2], 0.0)
    t = np.stack([-half, np.clip(vertex, -half, half), half])
    quadratic = c[:, 0] + t * (c[:, 1] + t * c[:, 2])
    chosen = np.argmax(np.abs(quadratic) if absolute else quadratic, axis=0)
    lane = np.arange(half.size)
    at = t[chosen, lane]
    beyond = _polynomial(np.abs(c[:, 3:]), half) * (half * half * half) + series.remainder
    value = _polynomial(c, at)
    top = quadratic[chosen, lane]
    if absolute:
        value, top = np.abs(value), np.abs(top)
    return value, top + beyond, at


def _polynomial(coefficients: Floats, t: Floats) -> Floats:
    """sum_k c_k t^k, (n,), of coefficients (n, K), rising powers."""
    return functools.reduce(lambda value, c: value * t + c, coefficients.T[::-1], np.zeros_like(t))
