"""Properties of one sampled series: plateaus, turning points, period, white noise."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SHORTEST_PLATEAU = 40
"""Samples that a plateau needs to distinguish noise from creep and lag."""

REPEATS_WITHIN = 1e-3
"""Rms difference of two periods of an input, relative to its standard deviation, up to which it is periodic."""

MANY_DIFFERENCES = 8000
"""Up to this number of differences, `residual_noise` uses their median: the search is calibrated with the median."""

KEPT, KEPT_POWER = 0.9, 0.62302
"""Share of differences left after trimming the largest, and their mean square in Gaussian noise of variance 1."""


def plateaus(u_V: Floats, shortest: int = SHORTEST_PLATEAU, tolerance_V: float = 0.0) -> list[tuple[int, int]]:
    """[begin, end) of each part of u, (n,), of at least `shortest` samples whose steps are at most `tolerance_V`."""
    moves = np.flatnonzero(np.abs(np.diff(u_V)) > tolerance_V) + 1
    edges = np.concatenate([[0], moves, [len(u_V)]])
    return [(int(a), int(b)) for a, b in itertools.pairwise(edges) if b - a >= shortest]


def turning_rows(u_V: Floats, band_V: float) -> NDArray[np.intp]:
    """Turning points of a voltage, (n,), as rows: extremes after which it moves back by more than `band_V`."""
    slope = np.sign(np.diff(u_V))
    moving = np.flatnonzero(slope)
    # The loop visits local extremes only: no other row can be a turning point.
    extremes = moving[1:][np.diff(slope[moving]) != 0.0]
    rows: list[int] = []
    best, direction = 0, 0.0
    for row in (*extremes.tolist(), u_V.size - 1):
        away = float(u_V[row] - u_V[best])
        if direction * away > 0.0 or (direction == 0.0 and abs(away) > band_V):
            best, direction = row, np.sign(away)
        elif direction * away < -band_V:
            rows.append(best)
            best, direction = row, -direction
    return np.array(rows, dtype=np.intp)


def period_of(u_V: Floats) -> int | None:
    """The period of an input in samples if it repeats within REPEATS_WITHIN over at least two periods, else None.

    Candidates are the peaks of the autocorrelation beyond its first zero crossing.
    """
    n = u_V.size
    centred = u_V - u_V.mean()
    deviation = float(centred.std())
    if n < 2 * SHORTEST_PLATEAU or deviation == 0.0:
        return None
    spectrum = np.fft.rfft(centred, 2 * n)
    # Divided by the overlap, so that peaks at long lags are not smaller than those at short lags.
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[: n // 2 + 1] / np.arange(n, n - n // 2 - 1, -1)
    below = np.flatnonzero(correlation < 0.0)
    if below.size == 0:
        return None
    late = correlation[below[0] :]
    for lag in below[0] + np.flatnonzero(late > (1.0 - 1e-2) * late.max()):
        gap = u_V[lag:] - u_V[:-lag]
        if math.sqrt(float(np.mean(gap * gap))) <= REPEATS_WITHIN * deviation:
            return int(lag)
    return None


def white_noise(values: Floats) -> float:
    """Standard deviation of the white noise on a smooth signal, (n,), from its sixth differences; 0 below 12 samples.

        median |D^6 x| / (0.6745 sqrt(924)),    924 = binomial(12, 6)

    The sixth difference of white noise has 924 times its variance, that of a smooth signal is near 0, and 0.6745 is the
    median of |x| for a standard normal x.
    """
    if values.size < 12:
        return 0.0
    return float(np.median(np.abs(np.diff(values, 6)))) / (0.6745 * float(np.sqrt(924.0)))


def residual_noise(residual: Floats) -> float:
    """Standard deviation of the white part of a residual of consecutive samples, (n,), from its second differences.

        1.4826 median |e(k+1) - 2 e(k) + e(k-1)| / sqrt(6)

    Slow parts of e cancel; between samples that are not neighbours they would not. NaN samples are left out. Of more
    than MANY_DIFFERENCES the rms of the smaller KEPT replaces the median, which behind a sensor whose resolution is no
    finer than its noise can only take a few values.
    """
    second = residual[2:] - 2.0 * residual[1:-1] + residual[:-2]
    second = second[np.isfinite(second)]
    if len(second) <= MANY_DIFFERENCES:
        return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0))
    small = np.sort(np.abs(second))[: int(KEPT * len(second))]
    return float(np.sqrt(np.mean(small * small) / (KEPT_POWER * 6.0)))
