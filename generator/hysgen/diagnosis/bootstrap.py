"""Confidence intervals of correlated errors by block bootstrap: blocks of samples are resampled, not single samples.

Sources: Kuensch (1989), moving blocks; Politis and Romano (1992), circular blocks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BLOCKS = 24
DRAWS = 400

LEEWAY = 0.25
"""Largest excess of the confidence by the rms over the confidence by the geometric mean that is accepted."""


@dataclass(frozen=True)
class Gain:
    """Fall of the free-run rms from `before_um` to `after_um`.

    low_um, high_um: 95 % interval of the fall. confidence: share of bootstrap draws in which the rms falls.
    """

    before_um: float
    after_um: float
    low_um: float
    high_um: float
    confidence: float

    @property
    def fall_um(self) -> float:
        """Fall of the rms, negative if the rms rises."""
        return self.before_um - self.after_um


def gain(before_um: Floats, after_um: Floats, by: float = 0.0) -> Gain:
    """The gain between two errors, (n,) each, of the same consecutive samples.

    Its confidence is the share of draws in which the rms falls by more than the share `by`. A draw is 24 blocks of n/24
    samples, the same for both errors; the seed of the 400 draws is fixed.
    """
    n = len(before_um)
    length = max(1, n // BLOCKS)
    squares = [_block_means(error * error, length) for error in (before_um, after_um)]
    chosen = np.random.default_rng(1).integers(0, n, size=(DRAWS, BLOCKS))
    before, after = (np.sqrt(side[chosen].mean(axis=1)) for side in squares)
    falls = before - after
    low, high = np.quantile(falls, [0.025, 0.975])
    root = [float(np.sqrt(np.mean(error * error))) for error in (before_um, after_um)]
    return Gain(root[0], root[1], float(low), float(high), float(np.mean(falls > by * before)))


def blockwise_confidence(before_um: Floats, after_um: Floats, by: float = 0.0) -> float:
    """Share of 400 draws in which the geometric mean of the rms over 24 blocks falls by more than the share `by`.

    In contrast to the rms over all samples, the geometric mean is not dominated by one block with a large error, such
    as a block whose stroke is wider than every stroke that the model was fitted to.
    """
    parts = [np.array_split(error, BLOCKS) for error in (before_um, after_um)]
    levels = [np.log([float(np.mean(part * part)) + 1e-300 for part in side]) for side in parts]
    chosen = np.random.default_rng(1).integers(0, BLOCKS, size=(DRAWS, BLOCKS))
    return float(np.mean((levels[0] - levels[1])[chosen].mean(axis=1) > -2.0 * np.log1p(-by)))


def combined_confidence(before_um: Floats, after_um: Floats, by: float = 0.0) -> float:
    """Confidence that the error falls by more than the share `by`: max(g, min(r, g + LEEWAY)).

    g: `blockwise_confidence`. r: `Gain.confidence`. The geometric mean limits the weight of a block with a large error,
    but gives a block with a negligible error the same weight; the rms does the opposite.
    """
    blocks, power = blockwise_confidence(before_um, after_um, by), gain(before_um, after_um, by).confidence
    return max(blocks, min(power, blocks + LEEWAY))


def _block_means(values: Floats, length: int) -> Floats:
    """(n,) mean of the `length` values from each sample on; the series continues at its start."""
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([values, values[: length - 1]]))])
    return np.asarray((sums[length:] - sums[:-length]) / length)
