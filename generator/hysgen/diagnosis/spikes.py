"""Corrupted samples: readings that stand alone, far from both neighbours, where nothing that moves could have been."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SCATTERS = 8.0
"""How many robust standard deviations a sample must stand off; 1 in 1e15 does so by chance in Gaussian noise."""

LOOKS = 4

EDGE = 2
"""Samples at either end of a run that are never judged."""


def isolated(error_um: Floats) -> Flags:
    """Samples of one run that stand off their neighbours alone, or two side by side, (n,).

        s(k) = e(k) - median(e(k-2), e(k-1), e(k+1), e(k+2)),    |s(k)| > 8 * 1.4826 median |s|

    and twice as far as each neighbour does: a jump or a swing moves its neighbours along. Two side by side stand off
    the two before and the two behind them, twice as far as these four differ. What is found is bridged by a straight
    line and the rest looked at again, for a corrupted sample spoils the neighbourhood of the next. The two samples at
    either end have no neighbours on both sides: what fades in or out there would stand off those that it has.
    error_um: (n,) what a model leaves, so that the stage's own motion does not count as scatter.
    """
    found = np.zeros(len(error_um), dtype=bool)
    if len(error_um) < 6:
        return found
    left = error_um
    for _ in range(LOOKS):
        more = _standing(left) & ~found
        more[:EDGE] = more[-EDGE:] = False
        if not more.any():
            break
        found |= more
        left = error_um.copy()
        left[found] = np.interp(np.flatnonzero(found), np.flatnonzero(~found), error_um[~found])
    return found


def _standing(error_um: Floats) -> Flags:
    """What `isolated` finds at one look."""
    n = len(error_um)
    stand = np.abs(local_scatter(error_um))
    scale = 1.4826 * float(np.median(stand)) + 1e-300
    beside = np.maximum(np.append(stand[1:], 0.0), np.append(0.0, stand[:-1]))
    alone = (stand > SCATTERS * scale) & (stand > 2.0 * beside)
    # Two samples k and k + 1, off the two before and the two behind, which agree with each other.
    padded = np.pad(error_um, 2, mode="edge")
    outer = np.stack([padded[i : i + n - 1] for i in (0, 1, 4, 5)])
    off = np.abs(np.stack([error_um[:-1], error_um[1:]]) - np.median(outer, axis=0)).min(axis=0)
    first = (off > SCATTERS * scale) & (off > 2.0 * np.ptp(outer, axis=0))
    return np.asarray(alone | np.append(first, False) | np.append(False, first))


def local_scatter(error_um: Floats) -> Floats:
    """(n,) how far each sample stands off the median of its four neighbours, signed."""
    padded = np.pad(error_um, 2, mode="edge")
    n = len(error_um)
    return np.asarray(error_um - np.median(np.stack([padded[i : i + n] for i in (0, 1, 3, 4)]), axis=0))
