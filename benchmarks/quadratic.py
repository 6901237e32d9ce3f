"""Sparse quadratic programmes by an interior point, for `benchmarks/loops.py`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]

INNER = 40
"""Steps of a programme."""


def quadratic(H: Any, q: Floats, E: Any, G: Any, h: Floats, at: NDArray[np.int64]) -> Floats:
    """x that minimises x' H x/2 + q' x where E x = 0, G x <= h, by an interior point; at: order of the equations."""
    n = E.shape[1]
    x, y, s = np.zeros(n), np.zeros(E.shape[0]), np.maximum(h, 1e-2)
    z, small = np.ones(h.size), sparse.diags_array(np.repeat([1e-9, -1e-9], [n, E.shape[0]]))
    for _ in range(INNER):
        gap, slack = 0.1 * float(s @ z) / s.size, G @ x + s - h
        side = np.append(-(H @ x + q + E.T @ y + G.T @ (z + (gap - s * z + z * slack) / s)), -E @ x)
        matrix = sparse.block_array([[H + G.T @ sparse.diags_array(z / s) @ G, E.T], [E, None]], format="csr") + small
        solved = np.empty(side.size)
        solved[at] = splu(matrix[at][:, at].tocsc()).solve(side[at])
        of_s = -slack - G @ solved[:n]
        of_z = (gap - s * z - z * of_s) / s
        far = min(1.0, *(0.99 * float(np.min(-v[d < 0] / d[d < 0], initial=2.0)) for v, d in ((s, of_s), (z, of_z))))
        x, y, s, z = x + far * solved[:n], y + far * solved[n:], s + far * of_s, z + far * of_z
        if gap < 1e-7:
            break
    return x
