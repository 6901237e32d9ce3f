"""The voltage inside its limits whose largest error is least: a linear programme, solved about the last answer.

    minimise    t + SPREAD sum_k s(k) / n
    such that   |y(k) - r(k)| <= s(k) <= t,   low <= u(k) <= high,   |u(k) - u(k-1)| <= slew Ts,
                |u(k) - 2 u(k-1) + u(k-2)| <= acceleration Ts^2

with y(k+1) = a(k) y(k) + b(k) u(k-d) + c(k), where c makes the line pass through the answer of the model to the last
voltage. The unknowns are u, t and the error above and below, whose sum is s: every row has few entries, and the range
is a bound. HiGHS solves it, by its interior point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linprog

from hysgen.certify.enclosure import slope
from hysgen.machine.kernels.operators import slew_limited
from hysgen.model.model import Model
from hysgen.model.path import applied
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.saturation import Saturation
from hysgen.model.path.slew import Slew
from hysgen.model.regression import memberships

Floats = NDArray[np.float64]

SPREAD = 0.01
"""Weight of the mean error beside the largest, which stays within a hundredth of its least."""

ROUNDS, LEAST_FALL = 12, 0.01
"""Programmes one after the other, and the relative fall of the largest error below which they end."""

SHARES = (1.0, 0.5, 0.25)
"""Shares of the way from the last voltage to that of a programme that are tried: the line is no more than near."""

PINNED = 1e-6
"""Half of the range, as a share, in which what is given may move: an interior point needs room."""


@dataclass(frozen=True)
class Limits:
    """low_V .. high_V of the voltage; slew in V/s and acceleration in V/s^2, None for none."""

    low_V: float
    high_V: float
    slew_V_s: float | None = None
    acceleration_V_s2: float | None = None

    def broken(self, u_V: Floats, Ts_s: float) -> tuple[str, ...]:
        """Names of the limits that a voltage exceeds by more than rounding."""
        rounding = 1e-9 * (self.high_V - self.low_V)
        names = [] if u_V.min() >= self.low_V - rounding and u_V.max() <= self.high_V + rounding else ["voltage"]
        after_rest = np.append(u_V[:1], u_V)
        for order, (name, limit) in enumerate((("slew", self.slew_V_s), ("acceleration", self.acceleration_V_s2)), 1):
            if limit is not None and np.abs(np.diff(after_rest, order)).max() > limit * Ts_s**order + rounding:
                names.append(name)
        return tuple(names)


def limits_of(model: Model, given: Limits | None) -> Limits:
    """The limits of the model (input range, saturation, slew rate), narrowed by those given."""
    low_V, high_V, slew = model.u_min_V, model.u_max_V, None
    for block in model.blocks:
        if isinstance(block, Saturation):
            low_V = low_V if block.low_V is None else max(low_V, block.low_V)
            high_V = high_V if block.high_V is None else min(high_V, block.high_V)
        if isinstance(block, Slew):
            slew = min(block.rise_V_s, block.fall_V_s)
    if given is None:
        return Limits(low_V, high_V, slew)
    rates = [rate for rate in (slew, given.slew_V_s) if rate is not None]
    return Limits(max(low_V, given.low_V), min(high_V, given.high_V), min(rates, default=None), given.acceleration_V_s2)


def clipped(u_V: Floats, limits: Limits, Ts_s: float) -> Floats:
    """The voltage cut at its limits sample by sample, as an amplifier would cut it."""
    cut = np.clip(u_V, limits.low_V, limits.high_V)
    if limits.acceleration_V_s2 is None:
        step_V = np.inf if limits.slew_V_s is None else limits.slew_V_s * Ts_s
        return slew_limited(cut, step_V, step_V, float(cut[0]))
    most_V, more_V = (limits.slew_V_s or np.inf) * Ts_s, limits.acceleration_V_s2 * Ts_s**2
    made, step_V = cut.copy(), 0.0
    for k in range(1, cut.size):
        wish_V = float(np.clip(cut[k] - made[k - 1], step_V - more_V, step_V + more_V))
        # Slow enough to stop before an end of the range.
        room_V = (limits.high_V - made[k - 1]) if wish_V > 0.0 else (made[k - 1] - limits.low_V)
        stop_V = max(float(np.sqrt(2.0 * more_V * max(room_V, 0.0))) - 0.5 * more_V, 0.0)
        step_V = float(np.clip(np.clip(wish_V, -stop_V, stop_V), -most_V, most_V))
        made[k] = made[k - 1] + step_V
    return made


def best_within(model: Model, y_um: Floats, u_V: Floats, limits: Limits, scored: slice) -> tuple[Floats, Floats]:
    """A voltage inside its limits with the least largest error along y, (n + 1,), and the answer of the model to it.

    u_V: (n,) of the exact inverse. On the rows `scored`, where the error counts, never worse than the clipped voltage.
    """
    delay = sum(block.preview for block in model.blocks)
    volts = clipped(u_V, limits, model.Ts_s)
    answer = model.simulate(np.append(volts, volts[-1]))
    best = (float(np.abs(answer - y_um)[scored].max()), volts, answer)
    per_V = np.prod([2.0 * b.mean_slope / (b.high_V - b.low_V) for b in model.blocks if isinstance(b, Hysteresis)])
    for _ in range(ROUNDS):
        before, volts, answer = best
        y = answer[delay:-1]
        w = applied(model.blocks, volts, model.Ts_s, model.w_range)[delay:]
        a, b = slope(model, y, w), memberships(y, model.grid) @ model.consequents[:, 1] * per_V
        c = answer[delay + 1 :] - a * y - b * volts[: volts.size - delay]
        early = _programme((a, b, c), y_um[delay:], float(y[0]), volts[: y.size], limits, model.Ts_s)
        aim = np.append(early, np.full(delay, early[-1]))
        aim = clipped(aim, limits, model.Ts_s) if limits.broken(aim, model.Ts_s) else aim
        # The limits are convex: every voltage between two inside them is inside them, too.
        for share in SHARES:
            tried = volts + share * (aim - volts)
            answer = model.simulate(np.append(tried, tried[-1]))
            largest = float(np.abs(answer - y_um)[scored].max())
            if largest < best[0]:
                best = (largest, tried, answer)
        if best[0] > (1.0 - LEAST_FALL) * before:
            break
    return best[1], best[2]


def _programme(
    line: tuple[Floats, Floats, Floats], r: Floats, y_um: float, last_V: Floats, limits: Limits, Ts_s: float
) -> Floats:
    """The voltages, (n,), of one programme. line: a, b, c, (n,) each, about last_V; r: (n + 1,) reference; y(0)."""
    a, b, c = line
    n = a.size
    step = _neighbours(-a, np.ones(n))
    # From the rest before on, which is as high as the first voltage.
    change = _neighbours(-np.ones(n - 1), np.ones(n - 1))
    bend = sparse.vstack([change[:1], change[1:] - change[:-1]])
    rates = ((limits.slew_V_s, change, Ts_s), (limits.acceleration_V_s2, bend, Ts_s**2))
    bounds = [(matrix, rate * unit_s) for rate, matrix, unit_s in rates if rate is not None]
    unit, column, nothing = sparse.eye_array(n + 1), sparse.csr_array(np.ones((n + 1, 1))), None
    # Of above, below, u and t.
    parts: list[list[Any]] = [[unit, unit, sparse.csr_array((n + 1, n)), -column]]
    parts += [[nothing, nothing, part, nothing] for matrix, _ in bounds for part in (matrix, -matrix)]
    sides = np.concatenate([np.zeros(n + 1), *(np.full(2 * matrix.shape[0], most_V) for matrix, most_V in bounds)])
    follows = sparse.block_array([[step, -step, -sparse.diags_array(b), sparse.csr_array((n, 1))]], format="csr")
    # The displacement begins where it rests, and the first voltage is that of the rest before.
    above, below, room_V = max(y_um - r[0], 0.0), max(r[0] - y_um, 0.0), PINNED * (limits.high_V - limits.low_V)
    free = [(0.0, None)] * n
    ends: Any = [(above, above), *free, (below, below), *free, (last_V[0] - room_V, last_V[0] + room_V)]
    ends += [*[(limits.low_V, limits.high_V)] * (n - 1), (0.0, None)]
    # Not of the mean but of the sum: its share lies above the rounding of a price.
    cost = np.concatenate([np.full(2 * n + 2, SPREAD), np.zeros(n), [n + 1.0]])
    solve: Any = linprog
    rows = sparse.block_array(parts, format="csr")
    answer = solve(cost, rows, sides, follows, c - step @ r, bounds=ends, method="highs-ipm")
    # Without an answer the last voltage stays.
    return last_V if answer.x is None else np.asarray(np.clip(answer.x[2 * n + 2 : -1], limits.low_V, limits.high_V))


def _neighbours(here: Floats, next_to: Floats) -> Any:
    """The matrix (n, n + 1) whose row k is here(k) at column k and next_to(k) at column k + 1."""
    n = here.size
    columns = np.stack([np.arange(n), np.arange(1, n + 1)], axis=1).ravel()
    values = np.stack([here, next_to], axis=1).ravel()
    return sparse.csr_matrix((values, columns, 2 * np.arange(n + 1)), shape=(n, n + 1))
