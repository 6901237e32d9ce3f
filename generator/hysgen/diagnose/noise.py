"""The noise floor: what no model can explain, estimated from what the best model leaves.

From repeated periods, where the command repeats itself sample by sample: what differs between them. Else on plateaus,
where the input stands still long enough: scatter about a straight line, so that an inexact level, drift or
creep does not count. Else from the innovation: second differences, in which smooth misfit vanishes.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.record import Record

Floats = NDArray[np.float64]

SHORTEST_PLATEAU = 40
SHORTEST_PERIOD = 100
REPEATS = 0.01
SETTLING = 12.0
"""Lags at the beginning of a plateau that are left to the dynamics to die out."""


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
    repeated = _repeated(record)
    if repeated is not None:
        return repeated
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
    second = left_um[2:] - 2.0 * left_um[1:-1] + left_um[:-2]
    second = second[np.isfinite(second)]
    return NoiseFloor(float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0)), "innovation", len(second))


def _repeated(record: Record) -> NoiseFloor | None:
    """From the differences between equal periods of the command, each less its mean and slope; None without any."""
    square, samples = 0.0, 0
    for segment in record.segments:
        period = _period(segment.u_V)
        if period is None:
            continue
        for begin in range(period, segment.samples - period + 1, period):
            change = segment.y_um[begin : begin + period] - segment.y_um[begin - period : begin]
            time = np.arange(period) - 0.5 * (period - 1)
            change = change - change.mean()
            change = change - time * float(time @ change / (time @ time))
            square, samples = square + 0.5 * float(change @ change), samples + period - 2
    return NoiseFloor(float(np.sqrt(square / samples)), "repeated periods", samples) if samples else None


def _period(u_V: Floats) -> int | None:
    """Samples after which the command repeats itself to 1 % of its rms; None if it does not."""
    n = len(u_V)
    v = u_V - u_V.mean()
    power = float(v @ v) / n
    spectrum = np.fft.rfft(v, 2 * n)
    overlap = np.fft.irfft(spectrum * np.conj(spectrum), 2 * n)[: n // 2 + 1]
    likeness = overlap / (power * (n - np.arange(len(overlap))) + 1e-300)
    for period in np.argsort(-likeness[SHORTEST_PERIOD:])[:5] + SHORTEST_PERIOD:
        change = v[period:] - v[:-period]
        if float(np.mean(change * change)) < REPEATS**2 * power:
            return int(period)
    return None


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
