"""Columns of a Preisach operator and of Duhem states, and a rate limiter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATION = """
void hysgen_preisach(size_t samples, const double *v, size_t plays, const double *radius, double *state, size_t hats,
                     const double *hat, size_t curve, size_t degree, double *out);
void hysgen_dahl(size_t samples, const double *v, size_t states, const double *reach, double *out);
void hysgen_rate_limit(size_t samples, const double *u, double step, double *out);
"""
_FILE = "preisach.c"


def preisach_columns(
    out: Floats, v: Floats, radius: Floats, start: Floats, hat: Floats, curve: int, degree: int
) -> None:
    """T_1(v) .. T_curve(v), then sum_i hat_ib T_p(z_i) for p = 1 .. degree and every b; z_i: play of radius_i on v.

    out: (curve + degree * b, n), written to; v: (n,); radius, start: (m,); hat: (m, b).
    Raises ValueError for more than 64 plays, or more than 64 sums of hats, or an `out` of another shape.
    """
    library = kernel(_FILE, _DECLARATION)
    plays, hats = hat.shape
    if plays > 64 or degree * hats > 64:
        raise ValueError("at most 64 plays, and 64 hats times powers")
    if out.shape != (curve + degree * hats, v.size):
        raise ValueError("the result needs a row for each polynomial, and for each power of each hat")
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


def dahl_columns(out: Floats, v: Floats, reach: Floats) -> None:
    """d_j and d_j |d_j| of the states d_j' = (sign(v') - d_j) |v'| / reach_j, from 0. v: (n,); out: (2 m, n), written.

    Raises ValueError if `out` has another shape.
    """
    library = kernel(_FILE, _DECLARATION)
    if out.shape != (2 * reach.size, v.size):
        raise ValueError("the result needs two rows for each reach")
    library.lib.hysgen_dahl(
        v.size,
        doubles(library, np.ascontiguousarray(v)),
        reach.size,
        doubles(library, np.ascontiguousarray(reach)),
        doubles(library, out),
    )


def rate_limited(u_V: Floats, step_V: float) -> Floats:
    """v(k) = v(k-1) + clamp(u(k) - v(k-1), -step, step), from v(0) = u(0); u_V: (n,) in V."""
    library = kernel(_FILE, _DECLARATION)
    out = np.empty(u_V.size)
    library.lib.hysgen_rate_limit(u_V.size, doubles(library, np.ascontiguousarray(u_V)), step_V, doubles(library, out))
    return out
