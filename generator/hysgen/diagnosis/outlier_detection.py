"""Detection of corrupted samples: readings so far from the neighbours on both sides that no motion explains them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.record.series import MEDIAN_TO_DEVIATION

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEAST_DEVIATION = 8.0
"""Least |s(k)| of a corrupted sample in robust standard deviations; probability 1e-15 for Gaussian noise."""

MOST_PASSES = 4
"""Passes over a run; each pass bridges the samples that the passes before it found."""

EDGE = 2
"""Samples at either end of a run that are never marked, because they have no neighbours on one side."""


def outlier_flags(error_um: Floats) -> Flags:
    """Flags, (n,), of the corrupted samples of one run: single samples or two side by side.

        s(k) = e(k) - median(e(k-2), e(k-1), e(k+1), e(k+2)),    |s(k)| > 8 * 1.4826 median |s|

    A single sample is corrupted if |s(k)| exceeds this limit and twice |s| of both neighbours; a step or an oscillation
    also moves the neighbours. Two side by side are corrupted if both differ from the median of the two samples before
    and the two samples after by more than the same limit and by more than twice the range of these four. Flagged
    samples are replaced by linear interpolation and the test is repeated, because a corrupted sample distorts the
    median at its neighbours. The EDGE samples at either end are never flagged: a transient there would resemble a
    corrupted sample.
    error_um: (n,) residual of a model, so that the motion of the stage is not counted as scatter.
    """
    flags = np.zeros(len(error_um), dtype=bool)
    if len(error_um) < 6:
        return flags
    bridged_um = error_um
    for _ in range(MOST_PASSES):
        more = _deviating(bridged_um) & ~flags
        more[:EDGE] = more[-EDGE:] = False
        if not more.any():
            break
        flags |= more
        bridged_um = error_um.copy()
        bridged_um[flags] = np.interp(np.flatnonzero(flags), np.flatnonzero(~flags), error_um[~flags])
    return flags


def _deviating(error_um: Floats) -> Flags:
    """Flags, (n,), of one pass of `outlier_flags`."""
    n = len(error_um)
    deviation = np.abs(local_scatter(error_um))
    scale = MEDIAN_TO_DEVIATION * float(np.median(deviation)) + 1e-300
    neighbours = np.maximum(np.append(deviation[1:], 0.0), np.append(0.0, deviation[:-1]))
    single = (deviation > LEAST_DEVIATION * scale) & (deviation > 2.0 * neighbours)
    # Two samples k and k + 1 against the two samples before and the two after, which agree with each other.
    padded = np.pad(error_um, 2, mode="edge")
    outer = np.stack([padded[i : i + n - 1] for i in (0, 1, 4, 5)])
    off = np.abs(np.stack([error_um[:-1], error_um[1:]]) - np.median(outer, axis=0)).min(axis=0)
    first = (off > LEAST_DEVIATION * scale) & (off > 2.0 * np.ptp(outer, axis=0))
    return np.asarray(single | np.append(first, False) | np.append(False, first))


def local_scatter(error_um: Floats) -> Floats:
    """(n,) signed deviation of each sample from the median of its four neighbours."""
    padded = np.pad(error_um, 2, mode="edge")
    n = len(error_um)
    return np.asarray(error_um - np.median(np.stack([padded[i : i + n] for i in (0, 1, 3, 4)]), axis=0))
