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
from hysgen.model.part import Extent, ShapeParameter
from hysgen.model.path.base import BlockBox, BlockMirror, Floats, Floats32, InputBlock, limited
from hysgen.model.structs import Member, Quantity

LEAST_BEYOND = 0.01
"""Least share of the command's range beyond a level; at the end of the range every curve resembles saturation."""

UNLIMITED = np.finfo(np.float32).max
"""Level in C of a side that does not clip."""


def _least_V(extent: Extent) -> float:
    """Least distance of a level from the end of the command's range."""
    return 2.0 * LEAST_BEYOND * extent.half_V


def _step_V(extent: Extent) -> float:
    """Step of a forward difference in a level: a smaller one may pass no sample of the command."""
    return 2e-3 * extent.half_V


@dataclass(frozen=True)
class Saturation(InputBlock):
    """Levels between which the input passes unchanged; None where a side does not clip.

    Raises ValueError if they are not finite or low_V is not below high_V.
    """

    kind: ClassVar[str] = "saturation"
    cause: ClassVar[str] = "saturation"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "low": Quantity("lowest input", "V"),
        "high": Quantity("highest input", "V"),
    }
    place: ClassVar[int] = 0
    amplifies: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("low_V", "V", lambda e: (e.low_V + _least_V(e), e.middle_V - _step_V(e)), step=_step_V),
        ShapeParameter("high_V", "V", lambda e: (e.middle_V + _step_V(e), e.high_V - _least_V(e)), step=_step_V),
    )
    low_V: float | None = None
    high_V: float | None = None

    def __post_init__(self) -> None:
        levels_V = [level_V for _, level_V, _ in self.levels]
        if not np.isfinite(levels_V).all() or levels_V != sorted(set(levels_V)):
            raise ValueError("low_V must lie below high_V")

    @property
    def levels(self) -> tuple[tuple[str, float, float], ...]:
        """Name, level and outward direction of each side that clips."""
        both = (("low_V", self.low_V, -1.0), ("high_V", self.high_V, 1.0))
        return tuple((name, level_V, sign) for name, level_V, sign in both if level_V is not None)

    def describe(self) -> str:
        return f"input saturates at {' and '.join(f'{level_V:.5g}' for _, level_V, _ in self.levels)} V"

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
        low, high = (
            level if level_V is None else np.float32(level_V)
            for level_V, level in ((self.low_V, -UNLIMITED), (self.high_V, UNLIMITED))
        )
        return {"low": np.array([low]), "high": np.array([high])}

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
