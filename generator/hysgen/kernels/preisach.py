"""Columns of a Preisach operator, linear filters over many columns, and a rate limiter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATION = """
void hysgen_preisach(size_t samples, const double *v, size_t plays, const double *radius, double *state, size_t hats,
                     const double *hat, size_t curve, size_t degree, double *out);
void hysgen_filter(size_t columns, size_t samples, size_t order, const double *b, const double *a, const double *x,
                   double *y);
void hysgen_dahl(size_t samples, const double *v, size_t states, const double *reach, double *out);
void hysgen_rate_limit(size_t samples, const double *u, double step, double *out);
"""
_FILE = "preisach.c"


def preisach_columns(v: Floats, radius: Floats, start: Floats, hat: Floats, curve: int, degree: int) -> Floats:
    """T_1(v) .. T_curve(v), then sum_i hat_ib T_p(z_i) for p = 1 .. degree and every b; z_i: play of radius_i on v.

    v: (n,); radius, start: (m,); hat: (m, b). Returns (curve + degree * b, n).
    Raises ValueError for more than 64 plays, or more than 64 sums of hats.
    """
    library = kernel(_FILE, _DECLARATION)
    plays, hats = hat.shape
    if plays > 64 or degree * hats > 64:
        raise ValueError("at most 64 plays, and 64 hats times powers")
    out = np.empty((curve + degree * hats, v.size))
    library.lib.hysgen_preisach(
        v.size,
        doubles(library, np.ascontiguousarray(v)),
        plays,
        doubles(library, np.ascontiguousarray(radius)),
        doubles(library, np.array(start, dtype=np.float64)),
        hats,
        doubles(library, np.ascontiguousarray(hat)),
        curve,
        degree,
        doubles(library, out),
    )
    return out


def dahl_columns(v: Floats, reach: Floats) -> Floats:
    """d_j and d_j |d_j| of the states d_j' = (sign(v') - d_j) |v'| / reach_j, from 0. v: (n,). Returns (2 m, n)."""
    library = kernel(_FILE, _DECLARATION)
    out = np.empty((2 * reach.size, v.size))
    library.lib.hysgen_dahl(
        v.size,
        doubles(library, np.ascontiguousarray(v)),
        reach.size,
        doubles(library, np.ascontiguousarray(reach)),
        doubles(library, out),
    )
    return out


def filtered(numerator: Floats, denominator: Floats, x: Floats) -> Floats:
    """Each row of x, (m, n) or (n,), through numerator/denominator in z^-1, (order + 1,) each, from rest. Same shape.

    Raises ValueError if the two differ in length, the order is not 1 to 7, or the denominator does not start with 1.
    """
    order = len(denominator) - 1
    if len(numerator) != len(denominator) or not 1 <= order <= 7 or denominator[0] != 1.0:
        raise ValueError("numerator and denominator need the same length, 2 to 8, and a leading 1 in the denominator")
    library = kernel(_FILE, _DECLARATION)
    given = np.ascontiguousarray(x)
    out = np.empty_like(given)
    library.lib.hysgen_filter(
        1 if given.ndim == 1 else len(given),
        given.shape[-1],
        order,
        doubles(library, np.ascontiguousarray(numerator)),
        doubles(library, np.ascontiguousarray(denominator)),
        doubles(library, given),
        doubles(library, out),
    )
    return out


def rate_limited(u_V: Floats, step_V: float) -> Floats:
    """v(k) = v(k-1) + clamp(u(k) - v(k-1), -step, step), from v(0) = u(0); u_V: (n,) in V."""
    library = kernel(_FILE, _DECLARATION)
    out = np.empty(u_V.size)
    library.lib.hysgen_rate_limit(u_V.size, doubles(library, np.ascontiguousarray(u_V)), step_V, doubles(library, out))
    return out
