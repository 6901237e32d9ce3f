"""Rate limiter over a whole record."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATION = "void hysgen_slew(size_t samples, const double *u, double rise, double fall, double start, double *out);"


def slew_limited(u_V: Floats, rise_V: float, fall_V: float, start_V: float) -> Floats:
    """v(k) = max(v(k-1) - fall, min(v(k-1) + rise, u(k))).

    u_V: (n,); rise_V, fall_V: largest steps up and down in one sample; start_V: v before the first sample.
    """
    library = kernel("slew.c", _DECLARATION)
    u = np.ascontiguousarray(u_V, dtype=np.float64)
    out = np.empty(u.size)
    library.lib.hysgen_slew(u.size, doubles(library, u), rise_V, fall_V, start_V, doubles(library, out))
    return out
