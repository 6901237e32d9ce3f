"""Commands for the bank's records: a good excitation, which every cause responds to, and poor ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
POOR = ("one sine", "small strokes", "slow triangle")


def good(rng: np.random.Generator, samples: int, low_V: float, high_V: float) -> Floats:
    """Sines of several amplitudes, levels and frequencies over a decade, joined by ramps and steps, with plateaus.

    (samples,) in V; the first stroke runs through the whole range.
    """
    middle, half = 0.5 * (low_V + high_V), 0.5 * (high_V - low_V)
    slowest = samples / 12.0
    parts: list[Floats] = []
    while sum(map(len, parts)) < samples:
        size = 1.0 if len(parts) % 6 == 0 else float(rng.uniform(0.2, 1.0))
        period = int(slowest / 10.0 ** rng.uniform(-0.2, 0.9))
        centre = middle + rng.uniform(-1.0, 1.0) * (1.0 - size) * half
        length = int(period * rng.choice([1.0, 1.5, 2.0]))
        wave = centre + size * half * np.sin(2 * np.pi * np.arange(length) / period - np.pi / 2)
        if parts:
            parts.append(_transition(rng, float(parts[-1][-1]), float(wave[0]), period))
        parts.append(wave)
        if rng.random() < 0.4:
            parts.append(np.full(int(rng.uniform(0.01, 0.04) * samples), wave[-1]))
    return np.concatenate(parts)[:samples]


def poor(kind: str, rng: np.random.Generator, samples: int, low_V: float, high_V: float) -> Floats:
    """An excitation of one of the kinds POOR, (samples,) in V."""
    middle, half = 0.5 * (low_V + high_V), 0.5 * (high_V - low_V)
    turns = np.arange(samples) / samples
    if kind == "one sine":
        return np.asarray(middle + half * np.sin(2 * np.pi * rng.uniform(15, 40) * turns))
    if kind == "small strokes":
        return np.asarray(middle + 0.03 * half * np.sin(2 * np.pi * rng.uniform(20, 60) * turns))
    strokes = turns * rng.uniform(1.5, 3.0)
    return np.asarray(low_V + 2 * half * (1.0 - np.abs(1.0 - 2.0 * (strokes % 1.0))))


def random_levels(rng: np.random.Generator, samples: int, low: float, high: float) -> Floats:
    """A further channel, (samples,): straight lines between 40 to 80 random levels."""
    corners = np.linspace(0, samples - 1, int(rng.uniform(40, 80)))
    return np.interp(np.arange(samples), corners, rng.uniform(low, high, len(corners)))


def _transition(rng: np.random.Generator, begin_V: float, end_V: float, period: int) -> Floats:
    if rng.random() < 0.4:
        return np.full(max(2, period // 6), end_V)  # a step, and time to ring
    length = max(2, period // 4)
    return begin_V + (end_V - begin_V) * (1.0 - np.cos(np.pi * np.arange(length) / length)) / 2.0
