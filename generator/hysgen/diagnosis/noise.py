"""The noise floor of a diagnosis: what no model can explain.

From repeated periods of the command where there are any (`hysgen.record.noise`). Else from what the probe leaves, so
that what a cause explains, such as hum on a plateau, does not count as noise: on plateaus, where the input stands
still, its scatter about a straight line; without plateaus its second differences, in which smooth misfit vanishes.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.record import Record, noise

Floats = NDArray[np.float64]

SHORTEST_PLATEAU = 40
SETTLING = 12.0
"""Lags at the beginning of a plateau that are left to the dynamics to die out."""


MANY = 8000
"""Second differences up to which their median tells the noise: the thresholds of the search were found with it."""

KEPT, KEPT_POWER = 0.9, 0.62302
"""Share of many second differences that is not taken for jumps, and the mean square of these in Gaussian noise of 1."""


@dataclass(frozen=True)
class NoiseFloor:
    """rms_um, and where it comes from: "repeated periods", "plateaus" or "innovation"; samples it rests on."""

    rms_um: float
    source: str
    samples: int


def noise_floor(record: Record, left_um: Floats, lag_s: float) -> NoiseFloor:
    """The noise floor of a record.

    left_um: (n,) what the best model leaves, all segments in order; NaN where it does not count.

    lag_s: time constant of the stage; a plateau counts from SETTLING of them on.
    """
    repeated = noise.noise_floor(record)
    if repeated.method == "periods":
        return NoiseFloor(repeated.rms_um, "repeated periods", repeated.samples)
    settling = max(4, round(SETTLING * lag_s / record.Ts_s))
    edges = np.cumsum([0, *(segment.samples for segment in record.segments)])
    parts = [left_um[a:b] for a, b in itertools.pairwise(edges)]
    scatter = [
        part
        for segment, left in zip(record.segments, parts, strict=True)
        for part in _plateau_scatter(segment.u_V, left, settling)
    ]
    samples = sum(len(part) for part in scatter)
    if samples >= 200:
        # The median over plateaus, for on some the amplifier may still be under way.
        variances = [float(part @ part) / (len(part) - 2) for part in scatter]
        return NoiseFloor(float(np.sqrt(np.median(variances))), "plateaus", samples)
    return NoiseFloor(innovation(left_um), "innovation", len(left_um) - 2)


def innovation(left_um: Floats) -> float:
    """Standard deviation in um of the white part of an error, (n,), from its second differences.

        1.4826 median |e(k+1) - 2 e(k) + e(k-1)| / sqrt(6)

    What is smooth vanishes; samples that are NaN do not count. left_um: samples in a row. Thinned out, they would show
    smooth misfit as noise. Of more than MANY differences the rms of the smaller KEPT is taken in place of the median:
    with a sensor that resolves no more than its noise, the median can only be one of a few steps.
    """
    second = left_um[2:] - 2.0 * left_um[1:-1] + left_um[:-2]
    second = second[np.isfinite(second)]
    if len(second) <= MANY:
        return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0))
    small = np.sort(np.abs(second))[: int(KEPT * len(second))]
    return float(np.sqrt(np.mean(small * small) / (KEPT_POWER * 6.0)))


def plateaus(u_V: Floats, shortest: int = SHORTEST_PLATEAU) -> list[tuple[int, int]]:
    """Stretches [begin, end) of at least `shortest` samples at one voltage."""
    moves = np.flatnonzero(np.diff(u_V) != 0.0) + 1
    edges = np.concatenate([[0], moves, [len(u_V)]])
    return [(int(a), int(b)) for a, b in itertools.pairwise(edges) if b - a >= shortest]


def _plateau_scatter(u_V: Floats, left_um: Floats, settling: int) -> list[Floats]:
    parts = []
    for begin, end in plateaus(u_V):
        y = left_um[begin + settling : end]
        if len(y) >= 16 and np.isfinite(y).all():
            time = np.arange(len(y)) - 0.5 * (len(y) - 1)
            y = y - y.mean()
            parts.append(y - time * float(time @ y / (time @ time)))
    return parts
