"""Confidence intervals that respect correlation: whole blocks of samples are drawn again, never single ones.

Source: Kuensch (1989), moving blocks; Politis and Romano (1992), circular ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BLOCKS = 24
DRAWS = 400

LEEWAY = 0.25
"""How much less sure the mean over blocks may be of a fall than the rms is."""


@dataclass(frozen=True)
class Gain:
    """Free-run rms before and after in um, the 95 % interval of the fall, and in what share of draws it is one."""

    before_um: float
    after_um: float
    low_um: float
    high_um: float
    confidence: float

    @property
    def fall_um(self) -> float:
        """How far the rms falls."""
        return self.before_um - self.after_um


def gain(before_um: Floats, after_um: Floats, by: float = 0.0) -> Gain:
    """The gain between two errors of the same samples, (n,) each, in order; sure of a fall by more than the share `by`.

    Blocks of n/24 samples, drawn 400 times with a fixed seed, the same blocks for both errors.
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
    """In what share of draws the error falls by more than the share `by` of it, in the geometric mean over 24 blocks.

    The blocks are drawn again 400 times.

    A model that was not fitted to the one block with the widest stroke may be far off there, whatever its extensions;
    the rms over all blocks would be that of this one.
    """
    parts = [np.array_split(error, BLOCKS) for error in (before_um, after_um)]
    levels = [np.log([float(np.mean(part * part)) + 1e-300 for part in side]) for side in parts]
    chosen = np.random.default_rng(1).integers(0, BLOCKS, size=(DRAWS, BLOCKS))
    return float(np.mean((levels[0] - levels[1])[chosen].mean(axis=1) > -2.0 * np.log1p(-by)))


def combined_confidence(before_um: Floats, after_um: Floats, by: float = 0.0) -> float:
    """How sure it is that the error falls by more than the share `by`, in the geometric mean over blocks or in the rms.

    The geometric mean hears no single wild block, but a quiet one as loud as any; the rms the other way round. So the
    rms is believed where the mean over blocks, g, is not much less sure: max(g, min(r, g + LEEWAY)).
    """
    blocks, power = blockwise_confidence(before_um, after_um, by), gain(before_um, after_um, by).confidence
    return max(blocks, min(power, blocks + LEEWAY))


def _block_means(values: Floats, length: int) -> Floats:
    """(n,) mean of the `length` values from each sample on, around the end to the start."""
    sums = np.concatenate([[0.0], np.cumsum(np.concatenate([values, values[: length - 1]]))])
    return np.asarray((sums[length:] - sums[:-length]) / length)
