"""Gain and slope of a model, and their extrema over its operating range: enclosed, not sampled.

    gain   b(y) = df/du = sum_l p_l q_l2
    slope  df/dy = E[q1] + Cov(l, v)/h,     v_l = q_l1 y + q_l2 u + q_l3

E and Cov are taken over the rules with the firing strengths p_l. With s = (y - y_min)/h these are
p_l ~ exp(s l - l^2/2), hence for any numbers g_l, d/ds E[g] = Cov(l, g), and

    d/ds (df/dy) = 2 Cov(l, q1) + E[(l - m)^2 (v - E v)]/h,     m = E[l].

Over a cell of half-width r around s_i both derivatives are bounded from the values at s_i alone: since
d/ds log p_l = l - m and m only rises, p_l(s) <= P_l = p_l(s_i) exp(r |l - m_i|); then
Var(l) <= V = sum P_l (l - m_i)^2, m moves by at most r V, and every expectation is at most its sum with P in place of
p. Cells that could still hold the extremum are split until the enclosure is as narrow as asked. df/dy is affine in u,
so its extrema over u lie at u_min and u_max. Rounding, about 1e-13, is not part of the bounds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.membership import memberships
from hysgen.model import Model

Floats = NDArray[np.float64]
Enclosure = Callable[[Floats, Floats, Floats], tuple[Floats, Floats]]
"""(middle, half-width, u) of cells -> value in the middle, and how much more it can be anywhere in the cell."""

NARROW = 1e-5
"""Width to which extrema are enclosed, relative to 1 for slopes and to the largest gain for gains."""

MOST_CELLS = 200_000


@dataclass(frozen=True)
class Extremum:
    """An extremum over the operating range: the value met at (y, u), and the bound that no point exceeds.

    u_V is None where the quantity does not depend on u.
    """

    value: float
    bound: float
    y_um: float
    u_V: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {"value": self.value, "bound": self.bound, "y_um": self.y_um, "u_V": self.u_V}


def gain(model: Model, y_um: Floats) -> Floats:
    """b(y) in um/V, (n,), at displacements (n,)."""
    return np.asarray(memberships(y_um, model.grid) @ model.consequents[:, 1])


def slope(model: Model, y_um: Floats, u_V: Floats) -> Floats:
    """df/dy, (n,), at displacements inside the grid and inputs, (n,) each: what is left of a deviation one step on."""
    p = memberships(y_um, model.grid)
    q1, q2, q3 = model.consequents.T
    v = q1 * y_um[:, None] + q2 * u_V[:, None] + q3
    v = v - (p * v).sum(axis=1, keepdims=True)
    return np.asarray(p @ q1 + (p * v) @ np.arange(model.grid.rules) / model.grid.step_um)


def gain_extrema(model: Model, narrow: float = NARROW) -> tuple[Extremum, Extremum]:
    """Smallest and largest gain b(y) = sum_l p_l q_l2 in um/V, enclosed to `narrow` times the largest |q_l2|."""
    q2 = model.consequents[:, 1]
    scale = max(float(np.abs(q2).max()), np.finfo(np.float64).tiny)

    def enclosure(sign: float) -> Enclosure:
        def signed_gain(middle: Floats, half: Floats, _u: Floats) -> tuple[Floats, Floats]:
            cells = _Cells(model, middle, half)
            return sign * (cells.p @ q2), half * cells.covariance(np.broadcast_to(q2, cells.p.shape))

        return signed_gain

    lowest = _largest(enclosure(-1.0), model, (0.0,), narrow * scale)
    highest = _largest(enclosure(1.0), model, (0.0,), narrow * scale)
    return (
        Extremum(-lowest.value, -lowest.bound, lowest.y_um),
        Extremum(highest.value, highest.bound, highest.y_um),
    )


def slope_extremum(model: Model, u_V: tuple[float, ...] | None = None, narrow: float = NARROW) -> Extremum:
    """Largest |df/dy| over the displacement range and the inputs `u_V`, by default the ends of the input range."""
    return _largest(slope_enclosure(model), model, u_V or (model.u_min_V, model.u_max_V), narrow)


def slope_enclosure(model: Model) -> Enclosure:
    """|df/dy| in the middle of cells and how much more it can be inside them, as the module's heading derives."""
    q1, q2, q3 = model.consequents.T
    h = model.grid.step_um

    def enclosure(middle: Floats, half: Floats, u: Floats) -> tuple[Floats, Floats]:
        cells = _Cells(model, middle, half)
        y = model.grid.y_min_um + h * middle
        v = q1 * y[:, None] + q2 * u[:, None] + q3
        v = v - (cells.p * v).sum(axis=1, keepdims=True)
        value = cells.p @ q1 + (cells.p * cells.offset * v).sum(axis=1) / h
        # Inside the cell v_l differs from its middle value by (q_l1 - mean)(y - y_i), up to a common shift.
        spread = np.abs(v) + (half * h)[:, None] * np.abs(q1 - (cells.p @ q1)[:, None])
        spread = spread + (cells.most * spread).sum(axis=1, keepdims=True)
        third = (cells.most * (np.abs(cells.offset) + cells.shift[:, None]) ** 2 * spread).sum(axis=1)
        return np.abs(value), half * (2.0 * cells.covariance(np.broadcast_to(q1, v.shape)) + third / h)

    return enclosure


class _Cells:
    """Firing strengths in the middle of cells and their bounds P inside them, (n, L)."""

    def __init__(self, model: Model, middle: Floats, half: Floats) -> None:
        index = np.arange(model.grid.rules)
        self.p = memberships(model.grid.y_min_um + model.grid.step_um * middle, model.grid)
        self.offset = index - (self.p @ index)[:, None]
        self.most = self.p * np.exp(half[:, None] * np.abs(self.offset))
        self.shift = half * (self.most * self.offset**2).sum(axis=1)

    def covariance(self, g: Floats) -> Floats:
        """Bound of |Cov(l, g)| anywhere in each cell. g: (n, L)."""
        away = np.abs(g - (self.p * g).sum(axis=1, keepdims=True))
        bound = (self.most * (np.abs(self.offset) + self.shift[:, None]) * away).sum(axis=1)
        return np.asarray(bound)


def _largest(enclosure: Enclosure, model: Model, inputs: tuple[float, ...], narrow: float) -> Extremum:
    """The largest value over the displacement range and the given inputs, by branch and bound."""
    count = 8 * (model.grid.rules - 1)
    half_width = 0.5 * (model.grid.rules - 1) / count
    middle = np.tile(half_width * (2.0 * np.arange(count) + 1.0), len(inputs))
    half = np.full(middle.size, half_width)
    u = np.repeat(np.asarray(inputs, dtype=np.float64), count)
    best, place, settled = -np.inf, (0.0, 0.0), -np.inf
    while True:
        value, slack = enclosure(middle, half, u)
        top = int(np.argmax(value))
        if value[top] > best:
            best, place = float(value[top]), (float(middle[top]), float(u[top]))
        open_cells = value + slack > best + narrow
        settled = max(settled, float(np.max((value + slack)[~open_cells], initial=-np.inf)))
        if not open_cells.any() or 3 * np.count_nonzero(open_cells) > MOST_CELLS:
            bound = max(best, settled, float(np.max((value + slack)[open_cells], initial=-np.inf)))
            y_um = model.grid.y_min_um + model.grid.step_um * place[0]
            return Extremum(best, bound, y_um, place[1])
        thirds = np.array([-2.0, 0.0, 2.0]) / 3.0
        middle = (middle[open_cells, None] + half[open_cells, None] * thirds).ravel()
        half, u = np.repeat(half[open_cells] / 3.0, 3), np.repeat(u[open_cells], 3)
