"""Kernels of hysteresis: columns and paths of a Preisach operator, Duhem states, and a limiter of the rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_PREISACH = """
void hysgen_preisach(size_t samples, const double *v, size_t plays, const double *radius, double share, double *state,
                     size_t hats, const double *hat, size_t curve, size_t degree, double *out);
void hysgen_preisach_path(size_t samples, const double *v, size_t plays, const double *radius, double share,
                          double *state, size_t curve, const double *terms, size_t degree, const double *play,
                          double *out);
void hysgen_duhem(size_t samples, const double *v, size_t states, const double *reach, double *out);
void hysgen_hysteresis(size_t samples, const double *v, size_t terms, const double *curve, size_t plays, size_t degree,
                       const double *radius, double share, const double *play, size_t states, const double *reach,
                       const double *duhem, double *state, double *out);
void hysgen_rate_limit(size_t samples, const double *u, double step, double *out);
"""


@dataclass(frozen=True, eq=False)
class PreisachBasis:
    """Functions that a Preisach operator is expanded in.

    half_width: (m,) of the plays. hat: (m, b) weights of the plays in each of b hat functions of the half-width.
    curve, degree: highest Chebyshev polynomial of the input and of the plays. relaxation: s_j / r_j of plays that relax
    by thermal activation (`model.path.hysteresis`), 0 for plays that do not.
    """

    half_width: Floats
    hat: Floats
    curve: int
    degree: int
    relaxation: float = 0.0


def preisach_columns(out: Floats, v: Floats, start: Floats, basis: PreisachBasis) -> None:
    """Write the columns of a Preisach operator: T_1(v) .. T_curve(v), then for each power p and each hat b

        sum_i hat_ib T_p(z_i),    z_i(k) = max(v(k) - r_i, min(v(k) + r_i, z_i(k-1)))

    v: (n,); start: (m,) z_i before the first sample; out: (curve + degree * b, n), overwritten.
    Raises ValueError for more than 64 plays, for degree * b above 128, or if `out` has another shape.
    """
    library = kernel("preisach.c", _PREISACH)
    (plays, hats), curve, degree = basis.hat.shape, basis.curve, basis.degree
    if plays > 64 or degree * hats > 128:
        raise ValueError("at most 64 plays, and 128 hats times powers")
    if out.shape != (curve + degree * hats, v.size):
        raise ValueError("the result needs a row for each polynomial, and for each power of each hat")
    library.lib.hysgen_preisach(
        v.size,
        doubles(library, np.ascontiguousarray(v)),
        plays,
        doubles(library, np.ascontiguousarray(basis.half_width)),
        basis.relaxation,
        doubles(library, np.array(start, dtype=np.float64)),
        hats,
        doubles(library, np.ascontiguousarray(basis.hat)),
        curve,
        degree,
        doubles(library, out),
    )


def preisach_path(v: Floats, start: Floats, basis: PreisachBasis, weights: Floats) -> Floats:
    """(n,) weights @ columns, for the columns of `preisach_columns`, which are not formed.

    weights: (curve + degree * b,). Raises ValueError if there are more or fewer.
    """
    plays, hats = basis.hat.shape
    if weights.shape != (basis.curve + basis.degree * hats,):
        raise ValueError("one weight for each polynomial, and for each power of each hat")
    library = kernel("preisach.c", _PREISACH)
    of_plays = basis.hat @ weights[basis.curve :].reshape(basis.degree, hats).T
    out = np.empty(v.size)
    library.lib.hysgen_preisach_path(
        v.size,
        doubles(library, np.ascontiguousarray(v)),
        plays,
        doubles(library, np.ascontiguousarray(basis.half_width)),
        basis.relaxation,
        doubles(library, np.array(start, dtype=np.float64)),
        basis.curve,
        doubles(library, np.ascontiguousarray(weights[: basis.curve])),
        basis.degree,
        doubles(library, np.ascontiguousarray(of_plays)),
        doubles(library, out),
    )
    return out


def duhem_columns(out: Floats, v: Floats, reach: Floats) -> None:
    """Write d_j and d_j |d_j| of the Duhem states d_j' = (sign(v') - d_j) |v'| / reach_j, d_j(0) = 0.

    v: (n,); reach: (m,); out: (2 m, n), overwritten, rows d_1, d_1 |d_1|, d_2, ...
    Raises ValueError if `out` has another shape.
    """
    library = kernel("preisach.c", _PREISACH)
    if out.shape != (2 * reach.size, v.size):
        raise ValueError("the result needs two rows for each reach")
    library.lib.hysgen_duhem(
        v.size,
        doubles(library, np.ascontiguousarray(v)),
        reach.size,
        doubles(library, np.ascontiguousarray(reach)),
        doubles(library, out),
    )


@dataclass(frozen=True, eq=False)
class HysteresisSeries:
    """Coefficients of a hysteresis operator, all for inputs in [-1, 1].

    curve: (C + 1,) of T_0(v) .. T_C(v). half_width: (m,) of the plays. plays: (m, degree) of T_1(z_j) .. T_degree(z_j).
    reach: (s,) of the Duhem states. duhem: (s, 2) of d_i and d_i |d_i|. relaxation: s_j / r_j of plays that relax.
    """

    curve: Floats
    half_width: Floats
    plays: Floats
    reach: Floats
    duhem: Floats
    relaxation: float = 0.0


def hysteresis_path(series: HysteresisSeries, v: Floats, state: Floats) -> tuple[Floats, Floats]:
    """Displacement h(k) along the input v, (n,), and the state after the last sample.

    state: plays z_j, Duhem states d_i, and the input before the first sample, (m + s + 1,).
    """
    library = kernel("preisach.c", _PREISACH)
    after, out = np.array(state, dtype=np.float64), np.empty(v.size)
    arrays = (series.curve, series.half_width, series.plays, series.reach, series.duhem)
    curve, half_width, plays, reach, duhem = (np.ascontiguousarray(x, dtype=np.float64) for x in arrays)
    library.lib.hysgen_hysteresis(
        v.size,
        doubles(library, np.ascontiguousarray(v, dtype=np.float64)),
        curve.size,
        doubles(library, curve),
        half_width.size,
        plays.shape[1] if plays.ndim == 2 else 0,
        doubles(library, half_width),
        series.relaxation,
        doubles(library, plays),
        reach.size,
        doubles(library, reach),
        doubles(library, duhem),
        doubles(library, after),
        doubles(library, out),
    )
    return out, after


def rate_limited(u_V: Floats, step_V: float) -> Floats:
    """Slew-rate limiter from v(0) = u(0): v(k) = v(k-1) + clamp(u(k) - v(k-1), -step, step), u_V (n,).

    Differs from `slew_limited` in rounding: v(k-1) + (u(k) - v(k-1)) need not equal u(k) in the last bit.
    """
    library = kernel("preisach.c", _PREISACH)
    out = np.empty(u_V.size)
    library.lib.hysgen_rate_limit(u_V.size, doubles(library, np.ascontiguousarray(u_V)), step_V, doubles(library, out))
    return out
