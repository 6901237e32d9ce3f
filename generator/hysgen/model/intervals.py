"""Intervals of numbers, float64 ends that are rounded outwards to float32 on demand.

Terms and input blocks bound their states with them; `proof/eva` proves the bounds for the generated C.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

LARGEST: Final = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class Interval:
    """low <= x <= high."""

    low: float
    high: float

    @property
    def magnitude(self) -> float:
        return max(abs(self.low), abs(self.high))

    @property
    def width(self) -> float:
        return self.high - self.low

    def outwards(self, by: float = 0.0) -> Interval:
        """Both ends moved out by `by` and to the next float32 beyond."""
        return Interval(_towards(self.low - by, -np.inf), _towards(self.high + by, np.inf))

    def scaled(self, factor: float) -> Interval:
        """`factor` times as wide about the middle."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * factor * self.width
        return Interval(middle - half, middle + half)

    def hull(self, other: Interval) -> Interval:
        """The smallest interval that holds both."""
        return Interval(min(self.low, other.low), max(self.high, other.high))


ANY: Final = Interval(-LARGEST, LARGEST)


def symmetric(magnitude: float) -> Interval:
    """-magnitude <= x <= magnitude."""
    return Interval(-magnitude, magnitude)


def _towards(x: float, end: float) -> float:
    nearest = np.float32(x)
    beyond = float(nearest) < x if end > 0 else float(nearest) > x
    return float(np.nextafter(nearest, np.float32(end)) if beyond else nearest)
