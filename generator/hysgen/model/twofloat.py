"""A float32 sum in two words, for states whose increments are smaller than their last bit.

    step = (delta + K) - K            K = 1.5 * 2^-37: steps below 2^-61 become 0
    t    = low + step
    sum  = high + t
    low' = t - (sum - high)           rounding error of the sum, exact for |t| <= |high|
    high' = sum, or 0 where |sum| >= LIMIT or not finite

A creep state of 10 s at 50 kHz moves by 2e-6 of its input per sample: below the last bit of one float, but not below
the last bit of `low`. A decaying state ends at 0 and not at a denormal number, since inputs and steps are multiples of
2^-63. For |t| > |high| (a zero crossing) the error is at most the last bit of t. Valid states are far below LIMIT; the
limit bounds the state after one sample even if memory was corrupted.
Source: Dekker, A floating-point technique for extending the available precision (1971), Fast2Sum.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.model.intervals import Interval, symmetric

Floats32 = NDArray[np.float32]

FLOOR: Final = np.float32(1.5 * 2.0**-37)
LIMIT: Final = np.float32(2.0**20)
FACTS: Final = {"floor": FLOOR, "limit": LIMIT}
KEPT: Final[Interval] = symmetric(float(LIMIT))
"""What `high` never leaves, in the unit of the state; and `low` neither, which is far smaller in truth."""

_MAGNITUDE: Final = np.uint32(0x7FFFFFFF)


def accumulate(high: Floats32, low: Floats32, delta: Floats32) -> tuple[Floats32, Floats32]:
    """(high, low) + delta, in the generated C's order; float32 throughout."""
    step = (delta + FLOOR) - FLOOR
    t = low + step
    total = high + t
    magnitude = np.ascontiguousarray(total).view(np.uint32) & _MAGNITUDE
    return np.where(magnitude < LIMIT.view(np.uint32), total, np.float32(0.0)), t - (total - high)
