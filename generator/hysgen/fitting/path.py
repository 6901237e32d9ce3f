"""The physical path of a model by least squares: the hysteresis behind given blocks, and rules that start as one lag.

    u -> limits, slew, delay -> h -> creep, modes -> lag -> y

The blocks around the hysteresis are given. h is linear in its coefficients and the chain behind h is linear, so h, the
offset and the weights of the terms follow from one linear least-squares problem on the rows that count. The rules start
as the lag: q_l1 = a, q_l2 = 1 - a, q_l3 = 0 with a = exp(-Ts/tau), equal in all rules.

A stage never moves against its input. Noise and rows that a record does not visit may bend a fitted h the other way,
and then h has no inverse; so dh/dv >= LEAST_SLOPE times the mean slope is required along the record's own path and
along a path of random turns over the whole range, in both directions at every point. Plays that relax must have
densities that are nowhere negative: then the slope is at least that of the curve for every past (`density_slopes`).
Of a stage that does move against its input only predictions are asked, and nothing is required (`FitSettings.rising`).
Source of the constrained solution: Lawson and Hanson, Solving Least Squares Problems (1974), chapter 23.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from hysgen.certify.path_inverse import strokes, turning_points
from hysgen.errors import FitError
from hysgen.fitting.least_squares import HalfSpaces, least_squares_inside, windows
from hysgen.fitting.operator import SEARCHED, Operator, PathSize
from hysgen.fitting.path_regressors import (
    HeldWindow,
    PathTask,
    added_um,
    all_lagged,
    crept,
    held_windows,
    lagged,
    passed_V,
)
from hysgen.machine.reproducible import exp
from hysgen.model.model import Grid, Model
from hysgen.model.path import InputBlock
from hysgen.model.path.creep import Creep
from hysgen.model.path.modes import Modes
from hysgen.model.path.softening import Softening
from hysgen.model.regression import Trust, drives_of, structure_of
from hysgen.record import Record
from hysgen.record.series import first_covering

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

LEAST_SLOPE = 0.05
"""Smallest slope of h, as a part of its mean slope: of stages with 20 % of hysteresis, the slope after a turn is about
half of the mean."""

RIDGE = 1e-7
"""Prior of the coefficients relative to the scaled rows; with 1e-9 coefficients bend where nothing holds them."""

MOST_ROWS = 16_000
"""Rows of the least-squares problem; the rows of a longer record are drawn at random."""

FADING = 250
"""Samples at the start of a window that are not fitted, while the lag forgets its start: a tenth of a window."""

PATH_SAMPLES = 3000
"""Points of the record's path at which the slope is checked."""

ADDED = 30
"""Violated slopes that are added in a round."""

LATEST_COVERED = 0.3
"""Largest share of a segment that is left out until the input has covered its range."""

RELAXATIONS = (0.008, 0.0625)
"""Range in which the relaxation is searched: barriers of 45 to 150 kT with 1e3 to 1e6 attempts a sample have 0.01 to
0.05."""


def known_past(record: Record, trust: Trust | None = None, blocks: Sequence[InputBlock] = ()) -> list[Floats]:
    """Weight of each sample, by segment: 0 until the input has covered its range, at most for LATEST_COVERED of it.

    Before, plays may stand anywhere. The known past of a segment counts too. trust: further weights to multiply by;
    ones by default. blocks: of the path, whose limits the input passes: what they hold back covers nothing.
    """
    limits = [block for block in blocks if block.limits and not block.responds]
    weights = []
    for i, (segment, past) in enumerate(zip(record.whole().segments, record.past_samples, strict=True)):
        weight = np.ones(segment.samples - past) if trust is None else np.array(trust[i])
        u_V = segment.u_V
        for block in limits:
            u_V = block.apply(u_V, record.Ts_s)
        first = min(first_covering(u_V), int(LATEST_COVERED * segment.samples))
        weight[: max(first - past, 0)] = 0.0
        weights.append(weight)
    return weights


@dataclass(frozen=True, eq=False)
class PathColumns:
    """The linear problem of a path over a record, whatever rows count: columns behind the lag `lag_s`, (p, m).

    rows: (m,) rows of the joined segments; of a long record, those of its windows (`least_squares.windows`).
    """

    task: PathTask
    lag_s: float
    columns: Floats
    rows: Rows

    @property
    def nbytes(self) -> int:
        return self.columns.nbytes

    def of(self, rows: Rows) -> Floats:
        """(p, k) the columns on some of the rows."""
        return self.columns[:, np.searchsorted(self.rows, rows)]


def path_columns(task: PathTask, trust: Trust) -> PathColumns:
    """The columns of a path, with lag and relaxation of least error on the rows of `trust`.

    A path with modes has their lag; the relaxation is searched if the size requires it (`SEARCHED`).
    """
    rows, first = [], 0
    for segment in task.record.segments:
        rows += [first + np.arange(at.start, at.stop) for at in windows(segment.samples, task.record.samples)]
        first += segment.samples
    problem = PathColumns(task, 0.0, np.zeros((0, 0)), np.concatenate(rows))
    kept = _Kept.of(problem, trust)
    if task.size.relaxation == SEARCHED:
        task = _relaxing(task, _searched_relaxation(problem, kept))
        problem = dataclasses.replace(problem, task=task)
    held = held_windows(task)
    lag_s = _lag(problem, kept, held)
    return dataclasses.replace(problem, lag_s=lag_s, columns=all_lagged(task, held, lag_s))


def _relaxing(task: PathTask, relaxation: float) -> PathTask:
    """The task with plays of this relaxation."""
    return dataclasses.replace(task, size=dataclasses.replace(task.size, relaxation=relaxation))


def _lag(problem: PathColumns, kept: _Kept, held: Sequence[HeldWindow]) -> float:
    modes = next((block for block in problem.task.blocks if isinstance(block, Modes | Softening)), None)
    return _searched_lag(problem, kept, held) if modes is None else modes.lag_s


def _searched_relaxation(problem: PathColumns, kept: _Kept) -> float:
    """The relaxation of least error without constraints within RELAXATIONS.

    The lag is searched first for the middle of the range, and again for the relaxation that was found with this lag:
    the lag of a wrong relaxation moved the relaxation by up to 20 %.
    """
    low, high = np.log(RELAXATIONS)
    log_found = 0.5 * (low + high)
    for _ in range(2):
        held = _relaxing(problem.task, float(np.exp(log_found)))
        lag_s = _lag(dataclasses.replace(problem, task=held), kept, held_windows(held))

        def error(log_relaxation: float, lag_s: float = lag_s) -> float:
            task = _relaxing(problem.task, float(np.exp(log_relaxation)))
            return _error(dataclasses.replace(problem, task=task), kept.fewer, held_windows(task), lag_s)

        best = minimize_scalar(error, bounds=(low, high), method="bounded", options={"xatol": 0.03})
        log_found = float(best.x)
    return float(np.exp(log_found))


def _error(problem: PathColumns, kept: _Kept, held: Sequence[HeldWindow], lag_s: float) -> float:
    """||A x - b||^2 of the least-squares solution x without constraints, less the constant ||b||^2."""
    places = np.searchsorted(problem.rows, kept.rows)
    ends = np.cumsum([0, *(one.extra.shape[1] for one in held)])
    of_window = np.split(places, np.searchsorted(places, ends[1:-1]))
    columns = np.hstack(
        [lagged(problem.task, one, lag_s, at - first) for one, at, first in zip(held, of_window, ends, strict=False)]
    )
    A, b, _ = _scaled(columns, kept, problem.task.size)
    d = np.asarray(np.linalg.qr(np.column_stack([A, b]), mode="r"))[:-1, -1]
    return -float(d @ d)


def path_model(problem: PathColumns, trust: Trust) -> tuple[Model, list[Floats]]:
    """The model with the path of least error whose rules are one lag, and what the motion before the record adds.

    trust: weight of each sample, by segment. The second, (n,) in um of each segment, is no part of the model: it is
    known of this record alone. Raises FitError if no rising hysteresis is found.
    """
    task, lag_s = problem.task, problem.lag_s
    kept = _Kept.of(problem, trust)
    operator = task.size.operator(*passed_V(task))
    weights = _solved(task, operator, problem.of(kept.rows), kept)
    size = operator.size
    a_left = 1.0 - exp(-task.record.Ts_s / lag_s)
    # What is left of the past at the end cannot be told from the sensor's zero: the model goes on from there.
    rested, segments = task.past is None, task.record.segments
    crept_um = [np.zeros(part.samples) if rested else weights[:size] @ crept(task, part) for part in segments]
    left_um = float(crept_um[-1][-1])
    dc = 1.0 + sum(block.amount * len(block.tau_s) for block in task.blocks if isinstance(block, Creep))
    block = operator.block(weights[:size], (float(weights[size]) + left_um) / dc)
    parts = tuple(dataclasses.replace(part, lag_s=lag_s) if isinstance(part, Modes) else part for part in task.blocks)
    parts = tuple(
        dataclasses.replace(
            part, level_um=dc * float(weights[:size] @ operator.at(part.middle_V)) + float(weights[size])
        )
        if isinstance(part, Softening)
        else part
        for part in parts
    )
    model = Model(
        name=task.name,
        Ts_s=task.record.Ts_s,
        grid=task.grid,
        consequents=np.tile([1.0 - a_left, a_left, 0.0], (task.grid.rules, 1)),
        u_min_V=task.input_range_V[0],
        u_max_V=task.input_range_V[1],
        terms=task.terms,
        weights=np.asarray(weights[size + 1 :]),
        blocks=tuple(sorted((*parts, block), key=lambda part: part.place)),
        quantities=task.record.quantities,
    )
    return dataclasses.replace(model, grid=_covering(model, task.whole)), [crept - left_um for crept in crept_um]


def _covering(model: Model, whole: Record) -> Grid:
    """The grid of a model, extended to the response of its path to a record: a mode rings beyond the static range."""
    w_um = [drive.u_V for drive in drives_of(whole, structure_of(model))]
    low, high = min(w.min() for w in w_um), max(w.max() for w in w_um)
    grid = model.grid
    return Grid(min(grid.y_min_um, float(low)), max(grid.y_max_um, float(high)), grid.rules)


@dataclass(frozen=True, eq=False)
class _Kept:
    """Rows of the least-squares problem, their weights (square roots of the trust) and displacements."""

    rows: Rows
    weight: Floats
    y_um: Floats

    @classmethod
    def of(cls, problem: PathColumns, trust: Trust) -> _Kept:
        task, weight = problem.task, np.concatenate(list(trust))
        known = problem.rows
        if known.size < weight.size:
            # The lag of a window starts at its input.
            starts = np.flatnonzero(np.diff(known, prepend=-2) > 1)
            known = np.delete(known, np.add.outer(starts, np.arange(FADING)).ravel())
        rows = known[weight[known] > 0.0]
        if rows.size > MOST_ROWS:
            rows = np.sort(np.random.default_rng(0).choice(rows, MOST_ROWS, replace=False))
        y_um = np.concatenate([segment.y_um - added_um(task, segment) for segment in task.record.segments])
        return cls(rows, np.sqrt(weight[rows]), y_um[rows])

    @property
    def fewer(self) -> _Kept:
        """Every fourth row."""
        return _Kept(self.rows[::4], self.weight[::4], self.y_um[::4])


def _searched_lag(problem: PathColumns, kept: _Kept, held: Sequence[HeldWindow]) -> float:
    """The lag of least error without constraints, between a fifth and five times the best of the task's."""
    task = problem.task

    def error(log_lag: float) -> float:
        return _error(problem, kept.fewer, held, float(np.exp(log_lag)))

    middle = min((float(np.log(lag_s)) for lag_s in task.lags_s), key=error)
    low = max(middle - np.log(5.0), float(np.log(0.02 * task.record.Ts_s)))
    best = minimize_scalar(error, bounds=(low, middle + np.log(5.0)), method="bounded", options={"xatol": 1e-3})
    return float(np.exp(best.x)) if best.fun < error(middle) else float(np.exp(middle))


def _triangular(columns: Floats, kept: _Kept, size: PathSize) -> tuple[Floats, Floats, Floats]:
    """R, d and the scales of the columns: minimise ||R x - d|| over x = scale * weights, with the ridge."""
    A, b, scale = _scaled(columns, kept, size)
    Q, R = np.linalg.qr(A)
    return R, Q.T @ b, scale


def _scaled(columns: Floats, kept: _Kept, size: PathSize) -> tuple[Floats, Floats, Floats]:
    """A, b and the scales of the columns: minimise ||A x - b|| over x = scale * weights, with the ridge."""
    penalties = size.operator(-1.0, 1.0).penalties()
    ridge = RIDGE * np.append(penalties, np.ones(len(columns) - penalties.size))
    rows = columns * kept.weight
    scale = np.sqrt(np.mean(rows * rows, axis=1)) + 1e-300
    count = rows.shape[1]
    A = np.vstack([(rows / scale[:, None]).T / np.sqrt(count), np.diag(np.sqrt(ridge))])
    b = np.concatenate([kept.weight * kept.y_um / np.sqrt(count), np.zeros(len(rows))])
    return A, b, scale


def _solved(task: PathTask, operator: Operator, columns: Floats, kept: _Kept) -> Floats:
    """(p,) weights of the columns of least error; h rises where it must (falls, for a stage that falls with it)."""
    R, d, scale = _triangular(columns, kept, task.size)
    weights = np.linalg.solve(R, d) / scale
    slopes = np.vstack([operator.slopes(path) for path in _paths(task, operator)])
    middle = slopes @ weights[: operator.size]
    sign, mean = float(np.sign(np.median(middle))), abs(float(np.median(middle)))
    if mean == 0.0:
        raise FitError(f"{task.record.source}: the displacement does not answer to the voltage; record with more drive")
    if not task.rising:
        return np.asarray(weights)
    floor = np.full(len(slopes), LEAST_SLOPE)
    if operator.relaxation:
        slopes, part = operator.density_slopes()
        floor = LEAST_SLOPE * part
    rising = HalfSpaces(sign * slopes / (mean * scale[: operator.size]), floor)
    violated = partial(rising.violated, most=ADDED, least=1e-4)
    try:
        return least_squares_inside(R, d, violated, np.zeros(operator.size)).x / scale
    except FitError as fault:
        message = "no rising hysteresis lies near the record; it may not be a stage's response"
        raise FitError(f"{task.record.source}: {message}") from fault


def _paths(task: PathTask, operator: Operator) -> list[Floats]:
    """Normalised inputs: the record's own, thinned, and the path of the certificate over the whole range."""
    paths = []
    for segment in task.record.segments:
        u_V = np.clip(segment.u_V, operator.low_V, operator.high_V)
        paths.append(operator.normalised(u_V[:: max(1, task.record.samples // PATH_SAMPLES)]))
    return [*paths, np.concatenate(strokes(turning_points()))]
