"""Saturation of the amplifier.

    v(k) = min(max(u(k), low), high)

The commands of the inverse lie between the levels already.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.model.intervals import Interval
from hysgen.model.path.base import BlockBox, BlockMirror, Floats, Floats32, InputBlock, limited
from hysgen.model.structs import Member, Quantity


@dataclass(frozen=True)
class Saturation(InputBlock):
    """Levels between which the input passes unchanged.

    Raises ValueError if they are not finite or low_V is not below high_V.
    """

    kind: ClassVar[str] = "saturation"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "low": Quantity("lowest input", "V"),
        "high": Quantity("highest input", "V"),
    }
    place: ClassVar[int] = 0
    low_V: float
    high_V: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.low_V) and np.isfinite(self.high_V) and self.low_V < self.high_V):
            raise ValueError("low_V must lie below high_V")

    def describe(self) -> str:
        return f"input saturates at {self.low_V:.5g} and {self.high_V:.5g} V"

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        return np.clip(u_V, self.low_V, self.high_V)

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """No state; max(u_low, low) <= v <= min(u_high, high) [V], or the level that all of u_V lies beyond."""
        levels = self.constants(Ts_s)
        low, high = float(levels["low"][0]), float(levels["high"][0])
        through = Interval(min(max(u_V.low, low), high), max(min(u_V.high, high), low))
        return BlockBox({}, through, through)

    def members(self) -> tuple[Member, ...]:
        return ()

    def mirror(self, u_V: Floats32, Ts_s: float) -> ClipMirror:
        levels = self.constants(Ts_s)
        return ClipMirror(levels["low"][0], levels["high"][0], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {"low": np.array([self.low_V], dtype=np.float32), "high": np.array([self.high_V], dtype=np.float32)}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        return (cls(float(rng.uniform(-15.0, -5.0)), float(rng.uniform(90.0, 110.0))),)


class ClipMirror(BlockMirror):
    """Float32 clipping over lanes; no state."""

    def __init__(self, low: np.float32, high: np.float32, u_V: Floats32) -> None:
        self._low, self._high = low, high
        self._rest = self.apply(u_V)

    def rest(self) -> Floats32:
        return self._rest

    def apply(self, u_V: Floats32) -> Floats32:
        return limited(u_V, self._low, self._high)


BLOCK = Saturation
