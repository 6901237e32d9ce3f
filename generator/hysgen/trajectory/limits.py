"""The voltage inside its limits whose error is least: quadratic programmes, each about the last answer.

    minimise    t + spread mean_k e(k)^2 / t0
    such that   |e(k)| <= t,   e = y - r,   low <= u(k) <= high,   |u(k) - u(k-1)| <= slew Ts,
                |u(k) - 2 u(k-1) + u(k-2)| <= acceleration Ts^2

Unknown is v, the output of the hysteresis, whose exact inverse gives u: v ends where u does, and changes by the slope
of the hysteresis along the last answer times as much. Behind it the stage is linear but for the curve of its rules:

    x(k+1) = A x(k) + B v(k-d),   y(k+1) = a(k) y(k) + b(k) (C x(k) + D v(k-d))        of creep and modes, and of rules

in deviations from the last answer, whose largest error is t0. A small `spread` gives the least largest error, a large
one the least mean square. The unknowns are v, e, x and t.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from hysgen.certify.enclosure import gain, slope
from hysgen.machine.kernels.operators import slew_limited
from hysgen.model.model import Model
from hysgen.model.path import applied, preview
from hysgen.model.path.base import InputBlock, StateSpace, series
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.limits import Saturation, Slew
from hysgen.trajectory.interior_point import least
from hysgen.trajectory.inverse import inverse_of_path

Floats = NDArray[np.float64]

SPREAD, MEAN_SQUARE = 0.1, 1e3
"""`spread` for the least largest error, within hundredths, as the mean square is a small share of its square; and for
the least mean square."""

UNFORESEEN = 0.01
"""Share of what a programme moves the voltage, in displacement at rest, that counts as an error beside that along the
reference: hystereses move otherwise than the model says, and what hardly matters, as long before it, stays."""

ROUNDS, LEAST_FALL = 12, 0.01
"""Programmes at most; they end where the error falls by less, or is as near to that of the programme."""

SHARES = (1.0, 0.5, 0.25)
"""Shares of the way from the last voltage to that of a programme that are tried: the line is no more than near."""

REACHED = 1e-5
"""Largest error of a reference that is reached, as a share of its range (of the model's for a constant)."""

MOVED = 1e-6
"""Change of the voltage, as a share of the range, from which on the slope of a hysteresis is read from it."""


NO_STATE: StateSpace = (np.zeros((1, 1)), np.zeros(1), np.zeros(1), 1.0)
"""What passes through without a response; one state that rests, for a model that has none."""


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
    """The limits of the model (input range, saturation, hysteresis, slew rate), narrowed by those given."""
    low_V, high_V, slew = model.u_min_V, model.u_max_V, None
    for block in model.blocks:
        if isinstance(block, Saturation | Hysteresis):
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


def best_within(
    model: Model,
    y_um: Floats,
    tried: Sequence[Floats],
    limits: Limits,
    scored: slice,
    counted: slice,
    first: int,
    spread: float = SPREAD,
) -> tuple[Floats, Floats]:
    """A voltage inside its limits with the least error along y, (n + 1,), and the answer of the model to it.

    tried: voltages, (n,), to begin with, as they stay before the sample `first`. The programmes count the error on the
    rows `counted`. On the rows `scored` it is never worse than that of one of them cut at the limits.
    """

    def judged(volts: Floats) -> tuple[float, Floats, Floats]:
        answer = model.simulate(np.append(volts, volts[-1]))
        return _worth((answer - y_um)[scored], spread), volts, answer

    def nearest(voltages: Iterable[Floats]) -> tuple[float, Floats, Floats]:
        return min(map(judged, voltages), key=lambda pair: pair[0])

    best = nearest(clipped(volts, limits, model.Ts_s) for volts in tried)
    for _ in range(ROUNDS):
        before, volts, answer = best
        if np.abs(answer - y_um)[scored].max() < REACHED * np.ptp(y_um):
            break
        aim, least_um = _programme(model, y_um, volts, answer, limits, counted, first, spread)
        aim = clipped(aim, limits, model.Ts_s) if limits.broken(aim, model.Ts_s) else aim
        # The limits are convex: every voltage between two inside them is inside them, too.
        best = min(best, nearest(volts + share * (aim - volts) for share in SHARES), key=lambda pair: pair[0])
        if best[0] < (1.0 + LEAST_FALL) * least_um or best[0] > (1.0 - LEAST_FALL) * before:
            break
    return np.clip(best[1], limits.low_V, limits.high_V), best[2]


def _worth(error_um: Floats, spread: float) -> float:
    """What the programmes make least, in um: largest error, and mean square over it."""
    largest = float(np.abs(error_um).max())
    return largest + spread * float(np.mean(error_um**2)) / max(largest, 1e-300)


def _programme(
    model: Model,
    y_um: Floats,
    volts: Floats,
    answer: Floats,
    limits: Limits,
    counted: slice,
    first: int,
    spread: float,
) -> tuple[Floats, float]:
    """The voltages, (n,), of a programme about the last ones and their answer, and what it makes least, in um."""
    Ts_s, begin = model.Ts_s, first + preview(model.blocks)
    spaces = [block.state_space(Ts_s) for block in model.blocks]
    head = [block for block, space in zip(model.blocks, spaces, strict=True) if space is None]
    A, B, C, D = series([NO_STATE, *(space for space in spaces if space is not None)])
    v, slopes, (low, high) = _behind(head, volts, limits, Ts_s)
    error, w = (answer - y_um)[begin + 1 :], applied(model.blocks, volts, Ts_s, model.w_range)
    a, b = slope(model, answer[begin:-1], w[begin:]), gain(model, answer[begin:-1])
    counts = np.arange(max(counted.start - begin - 1, 0), counted.stop - begin - 1)
    # Of v and x in half ranges; of e and t in the last largest error.
    n, m, half, unit_um = a.size, B.size, 0.5 * (high - low), float(np.abs(error[counts]).max())
    unit, late, of_w = sparse.eye_array(n), sparse.eye_array(n, k=-1), sparse.diags_array(half / unit_um * b)
    nothing, free = None, sparse.csr_array((n, 1))
    equations: list[list[Any]] = [
        [-D * of_w, unit - sparse.diags_array(a) @ late, -sparse.kron(of_w @ late, C[None, :]), free],
        [-sparse.kron(unit, B[:, None]), nothing, sparse.eye_array(n * m) - sparse.kron(late, A), nothing],
        [sparse.eye_array(1, n), nothing, nothing, nothing],
    ]
    along, largest = unit.tocsr()[counts], sparse.csr_array(np.ones((counts.size, 1)))
    bounds: list[list[Any]] = [
        [sparse.csr_array((counts.size, n)), along, sparse.csr_array((counts.size, n * m)), -largest],
        [nothing, -along, nothing, -largest],
    ]
    sides = [np.zeros(2 * counts.size)]
    last_V = np.append(volts[max(first - 1, 0)], volts[first : first + n])
    within = (unit, [(high - v[begin:]) / half, (v[begin:] - low) / half])
    for matrix, room in (within, *_rates(half / slopes[begin:], last_V, limits, Ts_s)):
        bounds += [[sign * matrix, nothing, nothing, nothing] for sign in (1.0, -1.0)]
        sides += room
    cost, squares, start = np.zeros((3, n * (2 + m) + 1))
    cost[-1], squares[n + counts], start[n : 2 * n], start[-1] = 1.0, 2.0 * spread / counts.size, error / unit_um, 1.0
    moved = UNFORESEEN * 0.5 * (model.grid.y_max_um - model.grid.y_min_um) / unit_um
    squares[:n] = 2.0 * spread * moved**2 / n
    k = np.arange(float(n))
    unknowns = np.concatenate([k, k + 0.6, np.repeat(k, m) + 0.8, [n]])
    rows_of = np.concatenate([k + 0.2, np.repeat(k, m) + 0.4, [0.0]])
    E, G = (sparse.block_array(parts, format="csr") for parts in (equations, bounds))
    x = least(cost, squares, E, G, np.concatenate(sides), start, (unknowns, rows_of))
    v[begin:] = np.clip(v[begin:] + half * x[:n], low, high)
    return inverse_of_path(head, v, float(volts[0]), Ts_s), _worth(unit_um * x[n + counts], spread)


def _rates(per_V: Floats, last_V: Floats, limits: Limits, Ts_s: float) -> Iterator[tuple[Any, list[Floats]]]:
    """Matrices and sides of the limits of slew and acceleration, in units of the limit.

    per_V: (n - 1,) half ranges of v over changes of u from sample to sample; last_V: (n + 1,) from the sample before.
    """
    n, moved_V, bent_V = last_V.size - 1, np.diff(last_V)[1:], np.diff(last_V, 2)
    change = (sparse.diags_array(per_V) @ (sparse.eye_array(n - 1, n, k=1) - sparse.eye_array(n - 1, n))).tocsr()
    bend = sparse.vstack([change[:1], change[1:] - change[:-1]])
    rates = ((change, moved_V, limits.slew_V_s, Ts_s), (bend, bent_V, limits.acceleration_V_s2, Ts_s**2))
    for matrix, last, rate, unit_s in rates:
        if rate is not None:
            yield matrix / (rate * unit_s), [1.0 - last / (rate * unit_s), 1.0 + last / (rate * unit_s)]


def _behind(
    head: Sequence[InputBlock], volts: Floats, limits: Limits, Ts_s: float
) -> tuple[Floats, Floats, list[float]]:
    """Output of delay and hysteresis, (n,), its slope from sample to sample, (n - 1,), and where it ends."""
    v, slopes, ends = volts, np.ones(volts.size - 1), [limits.low_V, limits.high_V]
    for block in head:
        before, v = np.diff(v), block.apply(v, Ts_s)
        if isinstance(block, Hysteresis):
            slopes = np.full(before.size, 2.0 * block.mean_slope / (block.high_V - block.low_V))
            turns = np.abs(before) > MOVED * (limits.high_V - limits.low_V)
            slopes[turns] = np.diff(v)[turns] / before[turns]
            ends = [float(block.apply(np.array([volts[0], end_V]), Ts_s)[-1]) for end_V in ends]
    return v, slopes, ends
