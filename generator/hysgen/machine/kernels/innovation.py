"""What is new in each sample of a signal that is a fading misfit plus white noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATIONS = """
void hysgen_gains(size_t samples, const double *keep, const double *heard, double misfit, double noise, double *gain,
                  double *variance);
void hysgen_innovations(size_t rows, size_t samples, const double *keep, const double *gain, const double *weight,
                        double *z);
"""


def innovation_gains(keep: Floats, heard: Floats, misfit: float, noise: float) -> tuple[Floats, Floats]:
    """Gains and innovation variances, (n,) each, of the Kalman filter for z = m + white noise.

        m(k) = keep(k) m(k-1) + sqrt(misfit (1 - keep(k)^2)) w(k)

    keep: (n,) 0 to 1; heard: (n,) 1 where a sample counts, else 0; misfit, noise: variances of m and of the noise.
    """
    library = kernel("innovation.c", _DECLARATIONS)
    gain, variance = np.empty(keep.size), np.empty(keep.size)
    arrays = [doubles(library, x) for x in (keep, heard)]
    library.lib.hysgen_gains(keep.size, *arrays, misfit, noise, doubles(library, gain), doubles(library, variance))
    return gain, variance


def innovations(signals: Floats, keep: Floats, gain: Floats, variance: Floats) -> Floats:
    """(rows, n) innovations of each row of `signals`, (rows, n), in standard deviations."""
    library = kernel("innovation.c", _DECLARATIONS)
    out = np.array(signals, dtype=np.float64, order="C")
    weight = 1.0 / np.sqrt(variance)
    library.lib.hysgen_innovations(*out.shape, *(doubles(library, x) for x in (keep, gain, weight, out)))
    return out
