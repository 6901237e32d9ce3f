"""Least squares over a record, one step ahead: in batch, in square-root form, recursively by Eq. (10); penalties.

    min over q of  sum_k lambda^(N-k) t(k) (y(k+1) - x(k)'q)^2 + lambda^N/alpha ||q - epsilon 1||^2

Both converge to the same q. The batch form keeps the triangular factor [R d; 0 e] of all rows [x' | y]: each chunk of
rows is appended to the factor and the stack is triangularised again. Memory does not grow with the record, and R has
the condition number of the regressors, not its square. Source: Bierman, Factorization Methods for Discrete Sequential
Estimation (1977), chapter IV.

Two quadratic penalties may be added to the free-run error, where a record leaves a choice:

    V(q) = mean over y and over both ends w of the range of  sum_l p_l (v_l - f)^2

    v_l = q_l1 y + q_l2 w + q_l3,    f = sum_l p_l v_l

*Disagreement of the rules*, V: overlapping rules with linear consequents represent the same function f in many ways.
Without V, least squares may choose consequents of hundreds of um that cancel in f, and float32 loses the difference.
*One-step error*: holds the rules that a record visits only during the burn-in, which the free-run error weighs little.

The set of parameters whose certificates hold, and least squares inside it.

At a fixed displacement and input, gain and slope are linear in the parameters:

    b(y) = sum_l p_l q_l2,     df/dy = sum_l (p_l + y p_l') q_l1 + w p_l' q_l2 + p_l' q_l3

so {|df/dy| <= limit, low <= sign b(y) <= high for all y and w} is convex. Least squares over a convex set has one
solution, the certified model of least error. Half-spaces are imposed on a fine grid of displacements, and only those
that an iterate violates. w is the voltage, or behind a hysteresis the output of the path in um.

Source of the solver: Lawson and Hanson, Solving Least Squares Problems (1974), chapter 23 (LSI to LDP to NNLS).
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from hysgen.certify.enclosure import slope_extremum
from hysgen.errors import FitError
from hysgen.machine.kernels import rls_updates, triangularise
from hysgen.model.model import Model
from hysgen.model.regression import (
    Starts,
    Structure,
    Trust,
    membership_slopes,
    memberships,
    regression_rows,
    structure_of,
)
from hysgen.record import Record

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Weighting:
    """How samples and prior count in a least-squares fit.

    forgetting: lambda; a row n places before the last one has the weight lambda^n. alpha: the prior has the weight
    1/alpha, i.e. P(0) = alpha I. epsilon: the prior mean, q(0) = epsilon [1, 1, ...].
    trust: weight t of each sample, one array per segment; 0 excludes a sample. starts: states of the terms before each
    segment, where they are known.
    """

    forgetting: float = 1.0
    alpha: float = 1e6
    epsilon: float = 0.0
    trust: Trust | None = None
    starts: Starts | None = None


UNIFORM = Weighting()
"""Every sample counts once, with the paper's prior."""


@dataclass(frozen=True)
class Information:
    """A sum of squares as a function of the parameters: ||R q - d||^2 + rest^2.

    R: (p, p) upper triangular and d: (p,), where it comes from a record; (n, p) and (n,), where it is a penalty.
    """

    R: Floats
    d: Floats
    rest: float

    def square(self, parameters: Floats) -> float:
        """The sum of squares at these parameters, (p,)."""
        away = self.R @ parameters - self.d
        return float(away @ away) + self.rest**2

    def solve(self) -> Floats:
        """The least-squares parameters, (p,)."""
        return np.asarray(solve_triangular(self.R, self.d))


def information(record: Record, structure: Structure, weighting: Weighting = UNIFORM) -> Information:
    """The square-root information of a record, including the prior."""
    size, forgetting = structure.size, weighting.forgetting
    prior = np.eye(size) / np.sqrt(weighting.alpha)
    factor = np.zeros((size + 1, size + 1))
    factor[:size, :size], factor[:size, size] = prior, weighting.epsilon * prior.sum(axis=1)
    for rows in regression_rows(record, structure, weighting.trust, weighting.starts):
        count = rows.target_um.size
        weight = np.sqrt(rows.trust * forgetting ** np.arange(count - 1.0, -1.0, -1.0))
        block = np.empty((count, size + 1))
        np.multiply(rows.regressors, weight[:, None], out=block[:, :size])
        np.multiply(rows.target_um, weight, out=block[:, size])
        factor *= forgetting ** (0.5 * count)
        triangularise(factor, block)
    return Information(factor[:size, :size].copy(), factor[:size, size].copy(), abs(float(factor[size, size])))


def recursive_least_squares(record: Record, structure: Structure, weighting: Weighting = UNIFORM) -> Floats:
    """q after one pass over all pairs (k, k+1), Eq. (10), from P(0) = alpha I and q(0) = epsilon [1, 1, ...].

        K = P x/(lambda + x'P x),   q += K (y(k+1) - x'q),   P = (I - K x') P/lambda

    Eq. (10) has no weights: rows of trust 0 are skipped, all others count fully.
    Returns (3 L + T,) parameters in the order of Model.parameters. Raises FitError if P is no longer a covariance
    (a negative variance), or if q is not finite.
    """
    q = np.full(structure.size, float(weighting.epsilon))
    P = weighting.alpha * np.eye(structure.size)
    for rows in regression_rows(record, structure, weighting.trust, weighting.starts):
        used = rows.trust > 0.0
        if used.all():
            rls_updates(rows.regressors, rows.target_um, weighting.forgetting, q, P)
        else:
            rls_updates(np.ascontiguousarray(rows.regressors[used]), rows.target_um[used], weighting.forgetting, q, P)
    if not np.isfinite(q).all() or (np.diag(P) < 0.0).any():
        raise FitError(
            f"{record.source}: recursive least squares with forgetting {weighting.forgetting:g} and alpha "
            f"{weighting.alpha:g} lost its covariance; forget less, or fit in batch"
        )
    return q


MOST_SAMPLES = 100_000
"""Samples of a record above which a fit looks at windows of as many samples in all: with at most some 80 parameters,
the standard error from the noise is then far below the error of the model's structure."""

WINDOWS = 40
"""Windows at equal distances: 2500 samples each, many time constants of the lag of a stage."""


def windows(samples: int, record_samples: int) -> list[slice]:
    """The windows of a segment of `samples`, of a record of `record_samples`; the whole segment of a short record."""
    share = MOST_SAMPLES / record_samples
    if share >= 1.0:
        return [slice(0, samples)]
    count = max(1, round(WINDOWS * samples / record_samples))
    length = max(2, int(share * samples / count))
    return [slice(start, start + length) for start in np.linspace(0, samples - length, count).astype(int).tolist()]


POINTS_PER_RULE = 8

ONE_STEP_SHARE = 0.1
"""Penalty of the one-step error at the start, as a part of the free-run error."""

DISAGREEMENT_SHARE = 1e-3
"""Penalty of rules that disagree by one step of the grid (rms), as a part of the free-run error."""

DISAGREEMENT_SHARE_ON_PATH = 1.0
"""The same behind a response of the path (hysteresis, creep, modes). There, rules that disagree overfit: they lower the
error of the identification record and raise the error of the next record."""

Penalties = tuple[tuple[float, Information], ...]
"""(kappa, form) each: the penalty kappa ||form.R q - form.d||^2."""


def penalties_at(model: Model, free_run_um2: float, one_step: Information) -> Penalties:
    """The penalties of a refinement that starts at `model`, whose free run has the square error free_run_um2."""
    structure, single = structure_of(model), one_step.square(model.parameters)
    share = DISAGREEMENT_SHARE_ON_PATH if model.responds else DISAGREEMENT_SHARE
    forms = [(share * free_run_um2 / model.grid.step_um**2, disagreement(structure))]
    if single > 0.0:
        forms.append((ONE_STEP_SHARE * free_run_um2 / single, one_step))
    return tuple(forms)


def disagreement(structure: Structure) -> Information:
    """V(q) = ||R q||^2 in um^2 over all linear parameters; the columns of terms are zero."""
    grid = structure.grid
    y = np.linspace(grid.y_min_um, grid.y_max_um, POINTS_PER_RULE * (grid.rules - 1) + 1)
    p = memberships(y, grid)
    factor = np.zeros((structure.size, structure.size))
    for w in (structure.w_range.low, structure.w_range.high):
        local = np.stack([y, np.full_like(y, w), np.ones_like(y)], axis=1)
        for rule in range(grid.rules):
            # sqrt(p_l) (v_l - f) at every y: -p from f, and 1 from v_l.
            share = -p
            share[:, rule] += 1.0
            rows = np.zeros((y.size, structure.size))
            rows[:, : 3 * grid.rules] = (share[:, :, None] * local[:, None, :]).reshape(y.size, -1)
            rows *= np.sqrt(p[:, rule] / (2.0 * y.size))[:, None]
            triangularise(factor, rows)
    return Information(factor, np.zeros(structure.size), 0.0)


HALF_SPACES_PER_RULE = 16
"""Displacements between neighbouring centres at which the half-spaces are imposed."""

GAIN_FLOOR, GAIN_CEILING = 0.05, 4.0
"""Limits of the gain b(y), as multiples of the gain of a single linear rule."""

ROUNDS = 400
"""Most rounds of adding half-spaces; 30 free weights needed up to 120."""

PIVOTS = 30
"""Most iterations of SciPy's nnls per half-space; its default of 3 is too few for 30 weights."""

VIOLATION = 1e-6
"""Violation of a half-space that counts as none, as a part of the limit."""

NARROW = 1e-4
"""Width of the enclosure of the largest slope between the grid points."""


@dataclass(frozen=True)
class HalfSpaces:
    """{q: rows q >= floor}; rows (m, p), floor (m,), each scaled by its limit."""

    rows: Floats
    floor: Floats

    def __add__(self, other: HalfSpaces) -> HalfSpaces:
        return HalfSpaces(np.vstack([self.rows, other.rows]), np.concatenate([self.floor, other.floor]))

    def violated(self, q: Floats, most: int = 24, least: float = VIOLATION) -> HalfSpaces:
        """The half-spaces that q violates by more than `least`, at most the `most` worst."""
        depth = self.floor - self.rows @ q
        worst = np.argsort(-depth, kind="stable")[:most]
        worst = worst[depth[worst] > least]
        return HalfSpaces(self.rows[worst], self.floor[worst])

    def steps_from(self, q: Floats, size: int) -> HalfSpaces:
        """The half-spaces for a step from q; a step has (size,) elements, of which the first are those of q."""
        rows = np.zeros((self.floor.size, size))
        rows[:, : q.size] = self.rows
        return HalfSpaces(rows, self.floor - self.rows @ q)


@dataclass(frozen=True)
class CertifiedSet:
    """All parameters (p,) of a structure whose gain and slope stay inside their limits.

    grid: the half-spaces of both at a grid of displacements.
    """

    structure: Structure
    slope_limit: float
    grid: HalfSpaces

    def violated(self, q: Floats) -> HalfSpaces:
        """Half-spaces that contain the set but not q; none if q is inside.

        First those on the grid. If q satisfies them, the one at the steepest point, which may lie between grid points.
        """
        outside = self.grid.violated(q)
        return outside if outside.floor.size else self._steepest(q).violated(q)

    def _steepest(self, q: Floats) -> HalfSpaces:
        """|df/dy| <= limit at the point of the largest |df/dy|."""
        s, cut = self.structure, 3 * self.structure.grid.rules
        rules = Model("candidate", 1.0, s.grid, q[:cut].reshape(-1, 3), s.w_range.low, s.w_range.high)
        worst = slope_extremum(rules, narrow=NARROW)
        assert worst.w is not None
        return _slope_limits(s, np.array([worst.y_um]), worst.w, self.slope_limit)


def certified_set(structure: Structure, single_gain: float, slope_limit: float) -> CertifiedSet:
    """The convex set of certified parameters of a structure.

    single_gain: gain of a single linear rule fitted to the same record, in um per unit of w; its sign and size set the
    limits of b(y). Raises FitError if it is zero.
    """
    if single_gain == 0.0:
        raise FitError("the displacement does not answer to the voltage at all; record with more drive")
    grid = structure.grid
    y = np.linspace(grid.y_min_um, grid.y_max_um, HALF_SPACES_PER_RULE * (grid.rules - 1) + 1)
    cut = 3 * structure.grid.rules
    gain = np.zeros((y.size, structure.size))
    gain[:, 1:cut:3] = memberships(y, grid) / single_gain
    one = np.ones(y.size)
    parts = [HalfSpaces(gain, GAIN_FLOOR * one), HalfSpaces(-gain, -GAIN_CEILING * one)]
    for w in (structure.w_range.low, structure.w_range.high):
        parts.append(_slope_limits(structure, y, w, slope_limit))
    return CertifiedSet(structure, slope_limit, functools.reduce(operator.add, parts))


@dataclass(frozen=True, eq=False)
class Inside:
    """The best x inside a set, and its active half-spaces, which are a good start for a similar task."""

    x: Floats
    edges: HalfSpaces


def least_squares_inside(
    R: Floats, d: Floats, violated: Callable[[Floats], HalfSpaces], start: Floats, edges: HalfSpaces | None = None
) -> Inside:
    """The x that minimises ||R x - d|| with start + x inside a set. R: (n, n) upper triangular, regular.

    violated: half-spaces that hold the set and not a point, none of a point inside. start: (p,); the set limits the
    first p elements of x, further ones are free. Starts with the half-spaces `edges` (default: none) and adds those
    that the solution violates, until it violates none; `edges` change the number of rounds and not the solution.
    Raises FitError if there is no solution: the limits contradict each other.
    """
    # With z = R x - d the task is min ||z||, G z >= h, G = rows R^-1, h = floor - G d.
    inverse = np.asarray(solve_triangular(R, np.eye(d.size)))
    imposed = HalfSpaces(np.zeros((0, start.size)), np.zeros(0)) if edges is None else edges
    for _ in range(ROUNDS):
        away = imposed.steps_from(start, d.size)
        G = away.rows @ inverse
        z, active = least_distance(G, away.floor - G @ d)
        x = np.asarray(solve_triangular(R, z + d))
        outside = violated(start + x[: start.size])
        if outside.floor.size == 0:
            return Inside(x, HalfSpaces(imposed.rows[active], imposed.floor[active]))
        imposed = imposed + outside
    raise FitError(
        "no certified model lies near the least-squares fit; choose fewer rules, or allow uncertified models"
    )


def least_distance(G: Floats, h: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """The shortest z with G z >= h, (n,), and which of these constraints are active, (m,).

    With the u >= 0 that minimises ||[G'; h'] u - [0; 1]|| and its residual r, z = -r_1..n / r_n+1; u_i > 0 where
    constraint i is active.
    """
    if not (h > 0.0).any():
        return np.zeros(G.shape[1]), np.zeros(h.size, dtype=bool)
    length = np.linalg.norm(G, axis=1)
    G, h = G / length[:, None], h / length
    # Scaled by the distance, so that the last row of the matrix has the size of the others.
    unit = float(np.abs(h).max())
    target = np.append(np.zeros(G.shape[1]), 1.0)
    matrix = np.vstack([G.T, h / unit])
    try:
        u, _ = nnls(matrix, target, maxiter=PIVOTS * G.shape[0])
    except RuntimeError:
        raise FitError("the certified set has too many edges near the fit; choose fewer rules") from None
    residual = matrix @ u - target
    if abs(residual[-1]) <= np.finfo(np.float64).eps:
        raise FitError("the limits on slope and gain contradict each other; allow a larger slope")
    return np.asarray(-unit * residual[:-1] / residual[-1]), u > 0.0


def _slope_limits(structure: Structure, y_um: Floats, w: float, limit: float) -> HalfSpaces:
    """|df/dy| <= limit at displacements (n,) and one input, in units of the limit."""
    p, rise = memberships(y_um, structure.grid), membership_slopes(y_um, structure.grid)
    cut = 3 * structure.grid.rules
    slope = np.zeros((y_um.size, structure.size))
    slope[:, 0:cut:3] = p + y_um[:, None] * rise
    slope[:, 1:cut:3] = w * rise
    slope[:, 2:cut:3] = rise
    return HalfSpaces(np.vstack([slope, -slope]) / limit, np.full(2 * y_um.size, -1.0))
