"""Orthogonal triangularisation of rows under a triangular factor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel

Floats = NDArray[np.float64]

_DECLARATION = """
void hysgen_triangular(size_t rows, size_t size, double *R, double *A, double *work);
"""


def triangularise(factor: Floats, rows: Floats) -> None:
    """Triangularise `rows` into `factor`: afterwards factor^T factor has grown by rows^T rows.

    factor: (m, m) upper triangular, updated in place; rows: (n, m), used up. Unlike LAPACK's, its result does not
    depend on the number of threads, and it does not slow down when they are busy.
    """
    library = kernel("triangular.c", _DECLARATION)
    size = len(factor)
    library.lib.hysgen_triangular(
        len(rows), size, doubles(library, factor), doubles(library, rows), doubles(library, np.empty(size))
    )
