"""Detection of corrupted samples: readings so far from the neighbours on both sides that no motion explains them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from hysgen.record.series import MEDIAN_TO_DEVIATION

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

LEAST_DEVIATION = 8.0
"""Least |s(k)| of a corrupted sample in robust standard deviations; probability 1e-15 for Gaussian noise."""

MOST_PASSES = 4
"""Passes over a run; each pass bridges the samples that the passes before it found."""

SPEED_GROUPS, FEWEST_IN_GROUP = 8, 200
"""Groups of samples by speed, each with its standard deviation, and samples that determine a median to 10 %."""

JITTER = 1.0
"""Largest error of a sampling instant, in periods: the displacement may be logged a row early or late."""

EDGE = 2
"""Samples at either end of a run that are never marked, because they have no neighbours on one side."""


def outlier_flags(error_um: Floats, resolution_um: float = 0.0, predicted_um: Floats | None = None) -> Flags:
    """Flags, (n,), of the corrupted samples of one run: single samples or two side by side.

        s(k) = e(k) - median(e(k-2), e(k-1), e(k+1), e(k+2)),    |s(k)| > 8 * 1.4826 median |s|

    A single sample is corrupted if |s(k)| exceeds this limit and twice |s| of both neighbours; a step or an oscillation
    also moves the neighbours. Two side by side are corrupted if both differ from the median of the two samples before
    and the two samples after by more than the same limit and by more than twice the range of these four. Flagged
    samples are replaced by linear interpolation and the test is repeated, because a corrupted sample distorts the
    median at its neighbours. The EDGE samples at either end are never flagged: a transient there would resemble a
    corrupted sample.
    error_um: (n,) residual of a model, so that the motion of the stage is not counted as scatter. resolution_um: of the
    sensor; the standard deviation is at least resolution_um / sqrt(12). predicted_um: (n,) prediction of the model. If
    given, the standard deviation is that of the samples at which the prediction moves as fast, because a jitter of the
    sampling instant adds an error in proportion to the speed; and the limit is at least the move of the prediction in
    JITTER periods, so that the one sample of a step is no corrupted one.
    """
    flags = np.zeros(len(error_um), dtype=bool)
    if len(error_um) < 6:
        return flags
    group = _speed_groups(error_um if predicted_um is None else predicted_um, predicted_um is not None)
    move_um = np.zeros(len(error_um)) if predicted_um is None else JITTER * _move_um(predicted_um)
    bridged_um = error_um
    for _ in range(MOST_PASSES):
        more = _deviating(bridged_um, resolution_um / math.sqrt(12.0), group, move_um) & ~flags
        more[:EDGE] = more[-EDGE:] = False
        if not more.any():
            break
        flags |= more
        bridged_um = error_um.copy()
        bridged_um[flags] = np.interp(np.flatnonzero(flags), np.flatnonzero(~flags), error_um[~flags])
    return flags


def _move_um(predicted_um: Floats) -> Floats:
    """(n,) the larger move to one of both neighbours."""
    steps = np.abs(np.diff(predicted_um))
    return np.asarray(np.maximum(np.append(steps, 0.0), np.append(0.0, steps)))


def _deviating(error_um: Floats, least_um: float, group: NDArray[np.intp], move_um: Floats) -> Flags:
    """Flags, (n,), of one pass of `outlier_flags`. group: (n,) samples with a common standard deviation."""
    n = len(error_um)
    deviation = np.abs(local_scatter(error_um))
    scales = [MEDIAN_TO_DEVIATION * float(np.median(deviation[group == i])) for i in range(int(group.max()) + 1)]
    # A group may hold slow and fast samples: the next faster one holds fast samples only.
    scale = np.maximum(np.maximum(scales, [*scales[1:], 0.0]), least_um)[group] + 1e-300
    neighbours = np.maximum(np.append(deviation[1:], 0.0), np.append(0.0, deviation[:-1]))
    limit = np.maximum(LEAST_DEVIATION * scale, move_um)
    single = (deviation > limit) & (deviation > 2.0 * neighbours)
    # Two samples k and k + 1 against the two samples before and the two after, which agree with each other.
    padded = np.pad(error_um, 2, mode="edge")
    outer = np.stack([padded[i : i + n - 1] for i in (0, 1, 4, 5)])
    off = np.abs(np.stack([error_um[:-1], error_um[1:]]) - np.median(outer, axis=0)).min(axis=0)
    first = (off > np.maximum(limit[:-1], limit[1:])) & (off > 2.0 * np.ptp(outer, axis=0))
    return np.asarray(single | np.append(first, False) | np.append(False, first))


def _speed_groups(predicted_um: Floats, known: bool) -> NDArray[np.intp]:
    """(n,) number of the group of each sample, by the speed of the prediction; one group if it is not known."""
    n = len(predicted_um)
    count = max(1, min(SPEED_GROUPS, n // FEWEST_IN_GROUP)) if known else 1
    # The deviation of a sample contains the errors of its neighbours.
    speed = maximum_filter1d(np.abs(np.gradient(predicted_um)), 2 * EDGE + 1)
    order = np.argsort(speed, kind="stable")
    group = np.empty(n, dtype=np.intp)
    group[order] = np.arange(n) * count // n
    return group


def local_scatter(error_um: Floats) -> Floats:
    """(n,) signed deviation of each sample from the median of its four neighbours."""
    padded = np.pad(error_um, 2, mode="edge")
    n = len(error_um)
    return np.asarray(error_um - np.median(np.stack([padded[i : i + n] for i in (0, 1, 3, 4)]), axis=0))
