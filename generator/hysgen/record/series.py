"""Properties of one sampled series: plateaus, turning points, period, white noise, resolution."""

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Scale = Literal["median", "trimmed"]

SHORTEST_PLATEAU = 40
"""Samples that a plateau needs to distinguish noise from creep and lag."""

REPEATS_WITHIN = 1e-3
"""Rms difference of two periods of an input, relative to its standard deviation, up to which it is periodic."""

MEDIAN_TO_DEVIATION = 1.4826
"""Standard deviation of a normal variable over the median of its magnitude."""

LEAST_STEP = 1e-9
"""Least difference of two readings, as a share of their range, that is taken for the resolution of the sensor."""

COVERED = 0.98
"""Share of its range that an input has to cover for a hysteresis to forget its initial state."""

SPARSE = 64
"""Every such difference alone refuses most lags of `period_of`: a sum of some squares is no larger than that of all."""

KEPT, KEPT_POWER = 0.9, 0.62302
"""Share of differences left after trimming the largest, and their mean square in Gaussian noise of variance 1."""


def first_covering(u_V: Floats) -> int:
    """First sample at which the input u, (n,), has covered the share COVERED of its range."""
    swept = np.maximum.accumulate(u_V) - np.minimum.accumulate(u_V)
    return int(np.argmax(swept >= COVERED * swept[-1]))


def plateaus(u_V: Floats, shortest: int = SHORTEST_PLATEAU, tolerance_V: float = 0.0) -> list[tuple[int, int]]:
    """[begin, end) of each part of u, (n,), of at least `shortest` samples whose steps are at most `tolerance_V`."""
    moves = np.flatnonzero(np.abs(np.diff(u_V)) > tolerance_V) + 1
    edges = np.concatenate([[0], moves, [len(u_V)]])
    lasting = np.flatnonzero(np.diff(edges) >= shortest)
    return list(zip(edges[lasting].tolist(), edges[lasting + 1].tolist(), strict=True))


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
        few = u_V[lag::SPARSE] - u_V[:-lag:SPARSE]
        if float(few @ few) > 1.01 * (n - lag) * (REPEATS_WITHIN * deviation) ** 2:
            continue
        gap = u_V[lag:] - u_V[:-lag]
        if math.sqrt(float(np.mean(gap * gap))) <= REPEATS_WITHIN * deviation:
            return int(lag)
    return None


def white_noise(values: Floats, order: int = 6, scale: Scale = "median") -> float:
    """Standard deviation of the white noise on a smooth series, (n,), from its differences of order m; 0 if n < 2m.

        s(D^m x) / sqrt(C(2m, m))

    The m-th difference of white noise has C(2m, m) times its variance, that of a smooth series is near 0. Differences
    that are NaN are left out. The estimate s of the standard deviation of D^m x:

        median     1.4826 median |D^m x|; outliers do not matter
        trimmed    rms of the smaller KEPT of |D^m x|, divided by that of a standard normal variable; for a sensor whose
                   resolution is no finer than its noise, where the median can only take a few values

    Source: P. Hall, J. W. Kay and D. M. Titterington, Biometrika 77 (1990) 521-528.
    """
    differences = np.diff(values, order)
    differences = differences[np.isfinite(differences)]
    if differences.size < order:
        return 0.0
    if scale == "median":
        deviation = MEDIAN_TO_DEVIATION * float(np.median(np.abs(differences)))
    else:
        small = np.sort(np.abs(differences))[: int(KEPT * differences.size)]
        deviation = math.sqrt(float(np.mean(small * small)) / KEPT_POWER)
    return deviation / math.sqrt(math.comb(2 * order, order))


def resolution_um(readings_um: Floats) -> float:
    """Least difference of two readings, (n,); 0 if it is below LEAST_STEP of their range."""
    codes = np.unique(readings_um)
    step_um = float(np.diff(codes).min()) if len(codes) > 1 else 0.0
    return step_um if step_um > LEAST_STEP * float(codes[-1] - codes[0]) else 0.0
