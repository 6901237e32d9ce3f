"""Commands for the records of a test stage: many levels, amplitudes and rates, over the whole range."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def command(rng: np.random.Generator, samples: int, low_V: float, high_V: float, start_V: float) -> Floats:
    """(samples,) in V: from start_V up and down the range in 4 to 8 % of the samples, then sections in random order.

    Sections: steps between held levels, triangles, sines, random walks, reversal curves; each with its own level,
    amplitude and rate, from 40 to 4000 samples a period. Between two sections stands a ramp, or in a third of the cases
    a step.
    """
    sweep = int(rng.uniform(0.04, 0.08) * samples)
    first = np.interp(np.linspace(0, 3, sweep), [0, 1, 2, 3], [start_V, high_V, low_V, rng.uniform(low_V, high_V)])
    parts = [first]
    order: list[Callable[[np.random.Generator, int], Floats]] = []
    while sum(map(len, parts)) < samples:
        order = order or [SECTIONS[i] for i in rng.permutation(len(SECTIONS))]
        wave = order.pop()(rng, int(rng.uniform(0.02, 0.06) * samples))
        # Every fourth section spans the whole range.
        size = 1.0 if len(parts) % 4 == 1 else float(rng.uniform(0.1, 0.9))
        middle = 0.5 + (1 - size) * float(rng.uniform(-0.5, 0.5))
        wave = low_V + (high_V - low_V) * (middle + 0.5 * size * wave)
        if rng.random() < 2 / 3:
            parts.append(np.linspace(parts[-1][-1], wave[0], int(rng.uniform(20, 400))))
        parts.append(wave)
    return np.concatenate(parts)[:samples]


def _period(rng: np.random.Generator, samples: int) -> float:
    return min(float(np.exp(rng.uniform(np.log(40), np.log(4000)))), float(samples))


def _steps(rng: np.random.Generator, samples: int) -> Floats:
    """Levels in -1 .. 1, held for 20 to 500 samples each."""
    holds = rng.integers(20, 500, samples // 20 + 1)
    return np.repeat(rng.uniform(-1, 1, len(holds)), holds)[:samples]


def _triangles(rng: np.random.Generator, samples: int) -> Floats:
    """Triangles whose amplitude changes from one to the next."""
    half = max(2, int(_period(rng, samples) / 2))
    count = samples // half + 2
    corners = rng.uniform(0.2, 1, count) * np.where(np.arange(count) % 2, 1, -1)
    return np.interp(np.arange(samples), half * np.arange(count), corners)


def _sines(rng: np.random.Generator, samples: int) -> Floats:
    """One sine, or the sum of two."""
    k = np.arange(samples)
    share = float(rng.choice([0.0, 0.3]))
    first, second = (np.sin(2 * np.pi * (k / _period(rng, samples) + rng.random())) for _ in range(2))
    return np.asarray((1 - share) * first + share * second)


def _walk(rng: np.random.Generator, samples: int) -> Floats:
    """Straight lines between random levels, each 5 to 300 samples long."""
    ways = np.cumsum(np.exp(rng.uniform(np.log(5), np.log(300), samples // 5 + 2)))
    return np.interp(np.arange(samples), ways - ways[0], rng.uniform(-1, 1, len(ways)))


def _reversals(rng: np.random.Generator, samples: int) -> Floats:
    """Triangles about one level whose amplitude falls to nothing."""
    half = max(2, int(_period(rng, samples) / 8))
    count = samples // half + 2
    corners = np.linspace(1, 0, count) * np.where(np.arange(count) % 2, 1, -1)
    return np.interp(np.arange(samples), half * np.arange(count), corners)


SECTIONS = (_steps, _triangles, _sines, _walk, _reversals)
