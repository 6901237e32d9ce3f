"""How far a step of the input moves the output of weighted play operators: by no more than its steepest slope.

    w = sum_j g_j(z_j),   g_j(z) = theta_j z + theta_2j T_2(x_j) + theta_3j T_3(x_j),   x_j = clamp((z - middle)/half)

A play that moves up stands at u - r_j, one that moves down at u + r_j, and where one moves, every narrower one moves
with it, for neighbours are never further apart than their half-widths differ. So on the way of the input from u(k-1) to
u(k) the slope dw/du is always one of the sums

    P_J(u) = sum over j <= J of g_j'(u - r_j), going up,  or of g_j'(u + r_j), going down

and |w(k) - w(k-1)| <= N |u(k) - u(k-1)|, N the largest |P_J(u)| over all inputs and all J. Between the inputs at which
plays enter their reach each P_J is a parabola in u, so N is exact. Weights of either sign count as they are: what the
play of half-width 0, the input one sample ago, has below 0 lowers the sums of the wider ones.

Source of the neighbours' rule: Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989), section 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Move:
    """The steepest move up: |P_J|, its sign, J, the input v in half ranges, and which plays are inside their reach."""

    size: float
    sign: float
    last: int
    v: float
    inside: NDArray[np.bool_]


def steepest_move(weights: Floats, r_over_half: Floats, half_V: float) -> Floats:
    """(size,) slopes d(phi_j)/du, signed, on the steepest move: their product with `weights` is N.

    For other weights the product is at most their own N, so {weights: row @ weights <= limit} holds all weights whose
    N is below the limit. weights: (degree m,) of plays, then T_2, then T_3; r_over_half: (m,) half-widths, rising, in
    half ranges; half_V: half the range.
    """
    m = r_over_half.size
    degree = weights.size // m
    theta = np.zeros((3, m))
    theta[:degree] = weights.reshape(degree, m)
    # Going down at u is going up at -u with the slopes of T_2, which are odd, turned round.
    ways = (np.ones((3, 1)), np.array([[1.0], [-1.0], [1.0]]))
    move, way = max(((_steepest_up(theta * way, r_over_half, half_V), way) for way in ways), key=lambda m: m[0].size)
    moving = np.arange(m) <= move.last
    each = moving * way * slopes(move.v - r_over_half, move.inside, half_V)
    return np.asarray(move.sign * each[:degree].ravel())


def slopes(x: Floats, inside: NDArray[np.bool_], half_V: float) -> Floats:
    """(3, ...) d(phi)/dz at x: 1, T_2'/half, T_3'/half; beyond its reach, where a play may start, 1, 0, 0."""
    bent = (4.0 * x / half_V, (12.0 * x * x - 3.0) / half_V)
    return np.stack([np.ones_like(x), *(np.where(inside, slope, 0.0) for slope in bent)])


def _steepest_up(theta: Floats, rho: Floats, half_V: float) -> _Move:
    """The move up on which |P_J| is largest, for weights theta, (3, m), and half-widths rho, (m,)."""
    # Going up, play j is inside its reach from v = -1 + 2 rho_j to 1: one more of them from knot to knot.
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
