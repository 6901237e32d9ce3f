"""Bound of the slope of weighted play operators: |w(k) - w(k-1)| <= N |u(k) - u(k-1)|.

    w = sum_j g_j(z_j),   g_j(z) = theta_j z + theta_2j T_2(x_j) + theta_3j T_3(x_j),   x_j = clamp((z - middle)/half)

A play that moves up is at u - r_j, a play that moves down at u + r_j. If a play moves, every narrower play moves too:
the distance of two plays is at most the difference of their half-widths. Hence, while the input moves from u(k-1) to
u(k), the slope dw/du is always one of the sums

    P_J(u) = sum over j <= J of g_j'(u - r_j), upwards,  or of g_j'(u + r_j), downwards

and N is the largest |P_J(u)| over all inputs and all J. Each P_J is a piecewise parabola in u, with knots where plays
enter their reach, so the maximum is exact. Weights have signs: a negative weight of the play of half-width 0, the past
input, reduces the sums of the wider plays.

Source: Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989), section 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Move:
    """The upward move of largest |P_J|: |P_J|, its sign, J, the input v in half ranges, plays inside their reach."""

    size: float
    sign: float
    last: int
    v: float
    inside: NDArray[np.bool_]


def steepest_move(weights: Floats, r_over_half: Floats, half_V: float) -> Floats:
    """(size,) signed slopes d(phi_j)/du on the move of largest |P_J|: a row with row @ weights = N.

    For other weights theta, row @ theta is at most their N, so {theta: row @ theta <= limit} contains all weights whose
    N is below the limit. weights: (degree m,) of plays, then T_2, then T_3; r_over_half: (m,) half-widths, rising, in
    half ranges; half_V: half the range.
    """
    m = r_over_half.size
    degree = weights.size // m
    theta = np.zeros((3, m))
    theta[:degree] = weights.reshape(degree, m)
    # A downward move at u equals an upward move at -u with the odd slopes of T_2 negated.
    ways = (np.ones((3, 1)), np.array([[1.0], [-1.0], [1.0]]))
    move, way = max(((_steepest_up(theta * way, r_over_half, half_V), way) for way in ways), key=lambda m: m[0].size)
    moving = np.arange(m) <= move.last
    each = moving * way * slopes(move.v - r_over_half, move.inside, half_V)
    return np.asarray(move.sign * each[:degree].ravel())


def slopes(x: Floats, inside: NDArray[np.bool_], half_V: float) -> Floats:
    """(3, ...) d(phi)/dz at x: 1, T_2'/half, T_3'/half; 1, 0, 0 for plays outside their reach."""
    polynomial = (4.0 * x / half_V, (12.0 * x * x - 3.0) / half_V)
    return np.stack([np.ones_like(x), *(np.where(inside, slope, 0.0) for slope in polynomial)])


def _steepest_up(theta: Floats, rho: Floats, half_V: float) -> _Move:
    """The move up on which |P_J| is largest, for weights theta, (3, m), and half-widths rho, (m,)."""
    # Upwards, play j is inside its reach from v = -1 + 2 rho_j to 1: each knot adds one play.
    knots = np.concatenate([2.0 * rho[:1] - 1.0, 2.0 * rho - 1.0, [1.0]])
    low, high = knots[:-1, None], knots[1:, None]
    inside = np.tri(rho.size + 1, rho.size, -1, dtype=bool)
    # P_J = c_0 + c_1 v + c_2 v^2 with the coefficients of g_j'(v - rho_j) summed over j <= J.
    c0 = theta[0] + inside * (theta[2] * (12.0 * rho * rho - 3.0) - 4.0 * theta[1] * rho) / half_V
    c1 = inside * (4.0 * theta[1] - 24.0 * theta[2] * rho) / half_V
    c2 = inside * 12.0 * theta[2] / half_V
    c0, c1, c2 = (np.cumsum(c, axis=1) for c in (c0, c1, c2))
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = np.nan_to_num(-0.5 * c1 / c2, nan=0.0, posinf=0.0, neginf=0.0)
    v = np.stack([np.broadcast_to(low, c0.shape), np.broadcast_to(high, c0.shape), np.clip(vertex, low, high)])
    value = c0 + (c1 + c2 * v) * v
    at = np.unravel_index(np.argmax(np.abs(value)), value.shape)
    return _Move(abs(float(value[at])), float(np.sign(value[at])), int(at[2]), float(v[at]), inside[at[1]])
