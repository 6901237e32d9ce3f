"""Corrupted samples: readings that stand alone, far from both neighbours, where nothing that moves could have been."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SCATTERS = 8.0
"""How many robust standard deviations a sample must stand off; 1 in 1e15 does so by chance in Gaussian noise."""


def isolated(error_um: Floats) -> Flags:
    """Samples of one run that stand off their neighbours alone, (n,).

        s(k) = e(k) - median(e(k-2), e(k-1), e(k+1), e(k+2)),    |s(k)| > 8 * 1.4826 median |s|

    and twice as far as each neighbour does: a jump or a swing moves its neighbours along. error_um: (n,) what a model
    leaves, so that the stage's own motion does not count as scatter.
    """
    if len(error_um) < 5:
        return np.zeros(len(error_um), dtype=bool)
    padded = np.pad(error_um, 2, mode="edge")
    n = len(error_um)
    around = np.median(np.stack([padded[i : i + n] for i in (0, 1, 3, 4)]), axis=0)
    stand = np.abs(error_um - around)
    scale = 1.4826 * float(np.median(stand)) + 1e-300
    beside = np.maximum(np.append(stand[1:], 0.0), np.append(0.0, stand[:-1]))
    return np.asarray((stand > SCATTERS * scale) & (stand > 2.0 * beside))


def local_scatter(error_um: Floats) -> Floats:
    """(n,) how far each sample stands off the median of its four neighbours, signed."""
    padded = np.pad(error_um, 2, mode="edge")
    n = len(error_um)
    return np.asarray(error_um - np.median(np.stack([padded[i : i + n] for i in (0, 1, 3, 4)]), axis=0))
