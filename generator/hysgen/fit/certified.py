"""The set of parameters whose certificates hold, and least squares inside it.

At a fixed displacement and input, gain and slope are linear in the parameters:

    b(y) = sum_l p_l q_l2,     df/dy = sum_l (p_l + y p_l') q_l1 + u p_l' q_l2 + p_l' q_l3

so {|df/dy| <= limit, low <= sign b(y) <= high for all y and u} is convex, and so is the small-gain condition of the
inverse, sum_j gamma_j |theta_j| <= limit sign b(y). Least squares over a convex set has one solution: the best
certified model, rather than one that a ridge has pushed there. Half-spaces are imposed on a fine grid of displacements
and only when violated.

Source of the solver: Lawson and Hanson, Solving Least Squares Problems (1974), chapter 23 (LSI to LDP to NNLS).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from hysgen.errors import FitError
from hysgen.membership import membership_slopes, memberships
from hysgen.regression import Structure

Floats = NDArray[np.float64]

POINTS_PER_RULE = 16
"""Displacements between neighbouring centres at which the half-spaces are imposed."""

GAIN_FLOOR, GAIN_CEILING = 0.05, 4.0
"""The gain may range between these multiples of the gain of a single linear rule."""

LOOP_LIMIT = 0.95
"""Small gain that the nonlinear terms may have around the inverse."""

ROUNDS = 60
VIOLATION = 1e-6
"""By how much of a limit a half-space may be missed."""


@dataclass(frozen=True)
class HalfSpaces:
    """{q: rows q >= floor}; rows (m, p), floor (m,), in units of the limit that each stands for."""

    rows: Floats
    floor: Floats

    def __add__(self, other: HalfSpaces) -> HalfSpaces:
        return HalfSpaces(np.vstack([self.rows, other.rows]), np.concatenate([self.floor, other.floor]))

    def violated(self, q: Floats, most: int = 24) -> HalfSpaces:
        """The half-spaces that q lies outside of, the worst `most` of them."""
        depth = self.floor - self.rows @ q
        worst = np.argsort(-depth, kind="stable")[:most]
        worst = worst[depth[worst] > VIOLATION]
        return HalfSpaces(self.rows[worst], self.floor[worst])

    def steps_from(self, q: Floats, size: int) -> HalfSpaces:
        """The half-spaces of a step away from q, which may have further elements: (size,) in all."""
        rows = np.zeros((self.floor.size, size))
        rows[:, : q.size] = self.rows
        return HalfSpaces(rows, self.floor - self.rows @ q)


@dataclass(frozen=True)
class CertifiedSet:
    """All parameters (p,) of a structure whose gain, slope and small gain stay inside their limits.

    gain_um_per_V: gain of a single linear rule, whose sign and size set the limits of b(y).
    term_gains: gamma_j of each term regressor, 0 for terms that are linear.
    """

    structure: Structure
    gain_um_per_V: float
    slope_limit: float
    term_gains: Floats
    grid: HalfSpaces

    def violated(self, q: Floats) -> HalfSpaces:
        """Half-spaces that contain the set but not q; none if q is inside."""
        return self.grid.violated(q) + self._loop(q).violated(q)

    def _loop(self, q: Floats) -> HalfSpaces:
        """sum_j gamma_j s_j theta_j <= limit sign b(y) with s_j = sign theta_j, at the y of the smallest gain."""
        if not self.term_gains.any():
            return HalfSpaces(np.zeros((0, q.size)), np.zeros(0))
        cut = 3 * self.structure.grid.rules
        p = memberships(_displacements(self.structure), self.structure.grid)
        weakest = p[np.argmin(np.sign(self.gain_um_per_V) * (p @ q[1:cut:3]))]
        row = np.zeros((1, q.size))
        row[0, 1:cut:3] = LOOP_LIMIT * np.sign(self.gain_um_per_V) * weakest
        row[0, cut:] = -self.term_gains * np.sign(q[cut:])
        return HalfSpaces(row / abs(self.gain_um_per_V), np.zeros(1))


def certified_set(structure: Structure, Ts_s: float, gain_um_per_V: float, slope_limit: float) -> CertifiedSet:
    """The convex set of certified parameters of a structure.

    gain_um_per_V: gain of a single linear rule fitted to the same record. Raises FitError if it is zero.
    """
    if gain_um_per_V == 0.0:
        raise FitError("the displacement does not answer to the voltage at all; record with more drive")
    y = _displacements(structure)
    p, slopes = memberships(y, structure.grid), membership_slopes(y, structure.grid)
    cut = 3 * structure.grid.rules
    gain = np.zeros((y.size, structure.size))
    gain[:, 1:cut:3] = p / gain_um_per_V
    one = np.ones(y.size)
    parts = [HalfSpaces(gain, GAIN_FLOOR * one), HalfSpaces(-gain, -GAIN_CEILING * one)]
    for u_V in (structure.u_min_V, structure.u_max_V):
        slope = np.zeros((y.size, structure.size))
        slope[:, 0:cut:3] = p + y[:, None] * slopes
        slope[:, 1:cut:3] = u_V * slopes
        slope[:, 2:cut:3] = slopes
        parts += [HalfSpaces(sign * slope / slope_limit, -one) for sign in (-1.0, 1.0)]
    grid = parts[0]
    for part in parts[1:]:
        grid = grid + part
    gains = [
        np.zeros(term.size) if term.linear(Ts_s) is not None else np.asarray(term.gains(Ts_s))
        for term in structure.terms
    ]
    return CertifiedSet(structure, gain_um_per_V, slope_limit, np.concatenate([np.zeros(0), *gains]), grid)


def least_squares_inside(R: Floats, d: Floats, allowed: CertifiedSet, origin: Floats | None = None) -> Floats:
    """The x that minimises ||R x - d|| with origin + x inside the set. R: (n, n) upper triangular, regular.

    The set limits the first p elements of x; more may follow. Starts without half-spaces and adds those that the
    solution violates, until none is left. Raises FitError if no x does: then the limits contradict each other.
    """
    start = np.zeros(allowed.structure.size) if origin is None else origin
    x = np.asarray(solve_triangular(R, d))
    working = HalfSpaces(np.zeros((0, d.size)), np.zeros(0))
    for _ in range(ROUNDS):
        violated = allowed.violated(start + x[: start.size])
        if violated.floor.size == 0:
            return x
        working = working + violated.steps_from(start, d.size)
        x = _least_distance(R, d, working)
    raise FitError(
        "no certified model lies near the least-squares fit; choose fewer rules, or allow uncertified models"
    )


def _least_distance(R: Floats, d: Floats, inside: HalfSpaces) -> Floats:
    """min ||R x - d|| with rows x >= floor. With z = R x - d: min ||z|| with G z >= h, G = rows R^-1, h = floor - G d.

    From u >= 0 that minimises ||[G'; h'] u - [0; 1]|| with residual r follows z = -r_1..p / r_p+1.
    """
    G = solve_triangular(R, inside.rows.T, trans="T").T
    h = inside.floor - G @ d
    length = np.linalg.norm(G, axis=1)
    G, h = G / length[:, None], h / length
    # The problem is solved in units of its own distance, or the last row would drown or rule the others.
    unit = float(np.abs(h).max())
    target = np.append(np.zeros(d.size), 1.0)
    matrix = np.vstack([G.T, h / unit])
    u, _ = nnls(matrix, target)
    residual = matrix @ u - target
    if abs(residual[-1]) <= np.finfo(np.float64).eps:
        raise FitError("the limits on slope and gain contradict each other; allow a larger slope")
    z = -unit * residual[:-1] / residual[-1]
    return np.asarray(solve_triangular(R, z + d))


def _displacements(structure: Structure) -> Floats:
    grid = structure.grid
    return np.linspace(grid.y_min_um, grid.y_max_um, POINTS_PER_RULE * (grid.rules - 1) + 1)
