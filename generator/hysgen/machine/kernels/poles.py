"""Banks of first-order and second-order linear states over a whole record."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATIONS = """
void hysgen_lags(size_t samples, size_t lags, const double *u, const double *q, double *s, double *out);
void hysgen_modes(size_t samples, size_t modes, const double *u, const double *q, double *state, double *out);
"""


def lag_states(u_V: Floats, rates: Floats, start_V: Floats) -> Floats:
    """s_j(k+1) = s_j(k) + a_j (u(k) - s_j(k)).

    u_V: (n,); rates a_j, start_V s_j(0): (m,). Returns s_j(k), (n, m), each row before u(k) acts.
    """
    library = kernel("poles.c", _DECLARATIONS)
    u, q, s = (np.ascontiguousarray(x, dtype=np.float64) for x in (u_V, rates, np.array(start_V)))
    out = np.empty((u.size, q.size))
    library.lib.hysgen_lags(u.size, q.size, *(doubles(library, x) for x in (u, q, s, out)))
    return out


def mode_states(u_V: Floats, steps: NDArray[np.complex128], start: Floats) -> Floats:
    """c_j(k+1) = c_j(k) + q_j (u(k) - c_j(k)), complex: position and velocity of a damped mode driven by u.

    u_V: (n,); steps q_j: (m,) complex; start: (2 m,) position and velocity of each. Returns (n, 2 m) in that order,
    each row before u(k) acts.
    """
    library = kernel("poles.c", _DECLARATIONS)
    pairs = np.ascontiguousarray(steps, dtype=np.complex128).view(np.float64)
    u, c = np.ascontiguousarray(u_V, dtype=np.float64), np.array(start, dtype=np.float64)
    out = np.empty((u.size, pairs.size))
    library.lib.hysgen_modes(u.size, pairs.size // 2, *(doubles(library, x) for x in (u, pairs, c, out)))
    return out
