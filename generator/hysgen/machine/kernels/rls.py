"""Recursive least squares over given regressors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATION = """
void hysgen_rls(size_t samples, size_t size, const double *regressors, const double *target, double lambda, double *q,
                double *P, double *work);
"""


def rls_updates(regressors: Floats, target: Floats, forgetting: float, q: Floats, P: Floats) -> None:
    """Eq. (10) for every row in turn; q (p,) and P (p, p) are updated in place. regressors: (n, p); target: (n,)."""
    library = kernel("rls.c", _DECLARATION)
    library.lib.hysgen_rls(
        target.size,
        q.size,
        doubles(library, regressors),
        doubles(library, target),
        forgetting,
        doubles(library, q),
        doubles(library, P),
        doubles(library, np.empty(2 * q.size)),
    )
