"""Kernels of estimation: recursive and orthogonal least squares, and the innovations of a Kalman filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import call

Floats = NDArray[np.float64]


def rls_updates(regressors: Floats, target: Floats, forgetting: float, q: Floats, P: Floats) -> None:
    """One update by Eq. (10) per row. regressors: (n, p); target: (n,); q (p,), P (p, p): updated in place."""
    call("rls.c", "hysgen_rls", target.size, q.size, regressors, target, forgetting, q, P, np.empty(2 * q.size))


def triangularise(factor: Floats, rows: Floats) -> None:
    """Update a QR factor by new rows: R'^T R' = R^T R + rows^T rows, by Householder reflections.

    factor: R, (m, m) upper triangular, updated in place; rows: (n, m), overwritten. Unlike LAPACK's, the result does
    not depend on the number of threads.
    """
    size = len(factor)
    call("triangular.c", "hysgen_triangular", len(rows), size, factor, rows, np.empty(size))


def innovation_gains(keep: Floats, observed: Floats, misfit: float, noise: float) -> tuple[Floats, Floats]:
    """Gains and innovation variances, (n,) each, of the Kalman filter for z = m + white noise.

        m(k) = keep(k) m(k-1) + sqrt(misfit (1 - keep(k)^2)) w(k)

    keep: (n,) 0 to 1; observed: (n,) 1 where z(k) is measured, else 0; misfit, noise: variances of m and of the noise.
    """
    gain, variance = np.empty(keep.size), np.empty(keep.size)
    call("innovation.c", "hysgen_gains", keep.size, keep, observed, misfit, noise, gain, variance)
    return gain, variance


def innovations(signals: Floats, keep: Floats, gain: Floats, variance: Floats) -> Floats:
    """Innovations of each row of `signals`, (rows, n), over their standard deviations; gain, variance: (n,) each."""
    out = np.array(signals, dtype=np.float64, order="C")
    weight = 1.0 / np.sqrt(variance)
    call("innovation.c", "hysgen_innovations", *out.shape, keep, gain, weight, out)
    return out
