"""Input checks over lanes: replacement of numbers that are not finite, flush to zero, limits."""

from __future__ import annotations

import numpy as np

from hysgen.model.float32_arithmetic import LEAST_BITS, Floats32, Words, bits_of, float_of
from hysgen.model.float32_constants import INFINITY_BITS, MAGNITUDE_BITS


def finite(x: Floats32, held: Floats32) -> tuple[Floats32, Words]:
    """`x` where it is finite, `held` where it is NaN or infinite; magnitudes below 2^-40 become +0.

    Returns the numbers, and 1 where `x` was replaced by `held`, else 0. The bit patterns are compared, not the floats,
    so that no float comparison has a NaN operand.
    """
    magnitude = bits_of(x) & np.uint32(MAGNITUDE_BITS)
    rejected = magnitude >= np.uint32(INFINITY_BITS)
    chosen = np.where(magnitude < LEAST_BITS, np.uint32(0), bits_of(x))
    return float_of(np.where(rejected, bits_of(held), chosen)), rejected.astype(np.uint32)


def limited(x: Floats32, low: Floats32 | np.float32, high: Floats32 | np.float32) -> tuple[Floats32, Words]:
    """`x` limited to [low, high], and 1 where the limit changed it, else 0."""
    below, above = x < low, x > high
    return np.where(below, low, np.where(above, high, x)), (below | above).astype(np.uint32)
