"""Play operators over a whole record."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATION = """
void hysgen_play(size_t samples, size_t plays, const double *u, const double *half_width, double *state, double *out);
"""


def play_operators(u_V: Floats, half_width_V: Floats, initial_V: Floats) -> Floats:
    """z_j(k) = max(u(k) - r_j, min(u(k) + r_j, z_j(k-1))) for every k and j.

    u_V: (n,); half_width_V, initial_V: (m,) with initial_V the z_j before the first sample. Returns (n, m) in V.
    """
    library = kernel("play.c", _DECLARATION)
    out = np.empty((u_V.size, half_width_V.size))
    state = np.array(initial_V, dtype=np.float64)
    library.lib.hysgen_play(
        u_V.size,
        half_width_V.size,
        doubles(library, u_V),
        doubles(library, half_width_V),
        doubles(library, state),
        doubles(library, out),
    )
    return out
