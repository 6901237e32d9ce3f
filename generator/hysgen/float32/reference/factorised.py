"""The UD-factorised update over lanes: P = U D U', U unit upper triangular, D > 0. Bierman (1977), chapter V.

    f = U' x,  g = D f,  alpha_j = alpha_(j-1) + f_j g_j,  alpha_(-1) = 1,  D_j <- D_j alpha_(j-1)/alpha_j
    U_ij <- U_ij - k_i f_j/alpha_(j-1),   k_i <- k_i + U_ij g_j   over i < j with the old U_ij, k_j = g_j;   P x = k

Matrices are (n, n, lanes), vectors (n, lanes). Sums run in ascending order; arguments are not modified.
"""

from __future__ import annotations

import numpy as np

from hysgen.float32.learner_numbers import FACTOR_GRID, GAIN_GRID, STEP_GRID
from hysgen.model.float32_arithmetic import Floats32, bits_of, float_of, reciprocal
from hysgen.model.float32_constants import MAGNITUDE_BITS, ROUNDING


def project(u: Floats32, x: Floats32) -> Floats32:
    """f_j = sum_{i<j} U_ij x_i + x_j; each sum starts at 0 and ends with x_j."""
    f = np.zeros_like(x)
    for i in range(len(x)):
        f[i] = f[i] + x[i]
        f[i + 1 :] = f[i + 1 :] + u[i, i + 1 :] * x[i]
    return f


def gains(d: Floats32, f: Floats32) -> Floats32:
    """g = D f."""
    return on_grid(d * f, GAIN_GRID)


def denominators(f: Floats32, g: Floats32) -> Floats32:
    """alpha_0 .. alpha_(n-1), (n, lanes); alpha_(n-1) = 1 + x' P x."""
    alpha = np.empty_like(f)
    before = np.ones(f.shape[1], np.float32)
    for j in range(len(f)):
        before = before + f[j] * g[j]
        alpha[j] = before
    return alpha


def quotients(f: Floats32, alpha: Floats32) -> tuple[Floats32, Floats32, Floats32]:
    """l_j = -f_j/alpha_(j-1), (n, lanes); alpha_(j-1)/alpha_j, (n, lanes); 1/alpha_(n-1), (lanes,)."""
    per_alpha = reciprocal(alpha)
    slope, kept = f.copy(), per_alpha.copy()
    slope[1:] = f[1:] * per_alpha[:-1]
    kept[1:] = alpha[:-1] * per_alpha[1:]
    return -slope, kept, per_alpha[-1]


def factor(u: Floats32, slope: Floats32, g: Floats32) -> tuple[Floats32, Floats32]:
    """U and k = P x; slope: the l_j of `quotients`."""
    u, k = u.copy(), np.empty_like(g)
    for j in range(len(g)):
        column = u[:j, j].copy()
        u[:j, j] = on_grid(column + k[:j] * slope[j], FACTOR_GRID)
        k[:j] = k[:j] + column * g[j]
        k[j] = g[j]
    return u, k


def add_compensated(theta: Floats32, low: Floats32, k: Floats32, q: Floats32) -> tuple[Floats32, Floats32]:
    """theta <- theta + k q by compensated summation; returns the new theta and its rounding error `low`."""
    carried: Floats32 = low + on_grid(k * q, STEP_GRID)
    total: Floats32 = theta + carried
    return total, carried - (total - theta)


def magnitude(x: Floats32) -> Floats32:
    """|x|, computed by clearing the sign bit."""
    return float_of(bits_of(x) & np.uint32(MAGNITUDE_BITS))


def on_grid(x: Floats32, grid: float) -> Floats32:
    """`x` rounded to multiples of `grid` for |x| <= 2^22 grid; for larger |x| the rounding is coarser."""
    floor = ROUNDING * np.float32(grid)
    return (x + floor) - floor
