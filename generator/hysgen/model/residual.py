"""What the residual e of a model says of a record: its white part, samples that count as independent, wrong readings.

`outlier_flags` marks readings so far from the neighbours on both sides that no motion explains them.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from hysgen.record.series import MEDIAN_TO_DEVIATION, white_noise

Floats = NDArray[np.float64]

MANY_DIFFERENCES = 8000
"""Up to this number of differences, `residual_noise` uses their median: the search is calibrated with the median."""

BLOCKS, SLOWEST = 40, 10
"""Blocks of rows in `dispersion`, and number of its slow coefficients: their mean has a standard deviation of 45 %."""


def residual_noise(residual: Floats) -> float:
    """Standard deviation of the white part of a residual of consecutive samples, (n,), by `white_noise` of order 2.

    Slow parts of the residual cancel; between samples that are not neighbours they would not. NaN samples are left out.
    Above MANY_DIFFERENCES differences the scale is "trimmed".
    """
    count = int(np.isfinite(np.diff(residual, 2)).sum())
    return white_noise(residual, 2, "median" if count <= MANY_DIFFERENCES else "trimmed")


def block_edges(rows: int) -> NDArray[np.intp]:
    """(BLOCKS + 1,) first rows of BLOCKS blocks of equal length, and the end."""
    return np.linspace(0, rows, BLOCKS + 1).astype(np.intp)


def dispersion(error: Floats, effect: Floats) -> float:
    """Number of samples of a residual that count as one independent sample where an effect acts, at least 1.

        g_b = sum over block b of error * effect
        c   = max over G of the mean of G_j^2 for j in G, over that of a white residual;   G = DCT of g

    error, effect: (n,). G: all coefficients, or the SLOWEST ones, which an error slower than a block makes larger.
    """
    edges = block_edges(len(error))
    products = np.add.reduceat(error * effect, edges[:-1])
    powers = np.add.reduceat(effect * effect, edges[:-1]) * float(np.mean(error * error))
    waves = np.cos(np.pi * np.outer(np.arange(BLOCKS), np.arange(BLOCKS) + 0.5) / BLOCKS)
    seen, white = (waves @ products) ** 2, waves**2 @ powers + 1e-300
    return max(1.0, *(float(seen[1:last].sum() / white[1:last].sum()) for last in (SLOWEST + 1, BLOCKS)))


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


def outlier_flags(error_um: Floats, resolution_um: float, predicted_um: Floats) -> Flags:
    """Flags, (n,), of the corrupted samples of one run: single samples or two side by side.

        s(k) = e(k) - median(e(k-2), e(k-1), e(k+1), e(k+2)),    |s(k)| > 8 * 1.4826 median |s|

    A single sample is corrupted if |s(k)| exceeds this limit and twice |s| of both neighbours; a step or an oscillation
    also moves the neighbours. Two side by side are corrupted if both differ from the median of the two samples before
    and the two samples after by more than the same limit and by more than twice the range of these four. Flagged
    samples are replaced by linear interpolation and the test is repeated, because a corrupted sample distorts the
    median at its neighbours. The EDGE samples at either end are never flagged: a transient there would resemble a
    corrupted sample.
    error_um: (n,) residual of a model, so that the motion of the stage is not counted as scatter. resolution_um: of the
    sensor; the standard deviation is at least resolution_um / sqrt(12). predicted_um: (n,) prediction of the model. The
    standard deviation is that of the samples at which it moves as fast, because a jitter of the sampling instant adds
    an error in proportion to the speed; the limit is at least the larger move of the prediction to one of both
    neighbours in JITTER periods, so that the one sample of a step is no corrupted one.
    """
    flags = np.zeros(len(error_um), dtype=bool)
    if len(error_um) < 6:
        return flags
    group, steps = _speed_groups(predicted_um), JITTER * np.abs(np.diff(predicted_um))
    move_um = np.maximum(np.append(steps, 0.0), np.append(0.0, steps))
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


def _speed_groups(predicted_um: Floats) -> NDArray[np.intp]:
    """(n,) number of the group of each sample, by the speed of the prediction."""
    n = len(predicted_um)
    count = max(1, min(SPEED_GROUPS, n // FEWEST_IN_GROUP))
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
