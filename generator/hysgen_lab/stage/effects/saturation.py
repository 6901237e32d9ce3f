"""Saturation: the amplifier clips."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, Tolerance, require, require_finite

NO_LOW_V, NO_HIGH_V = -60.0, 160.0
"""Levels that no command of the bank reaches."""


@dataclass(frozen=True)
class SaturationEffect(Effect):
    """The amplifier's output stays in [low_V, high_V], whatever is commanded."""

    low_V: float
    high_V: float

    name = "saturation"
    rank = 2
    bank_index = 3
    tolerances: ClassVar = {
        "saturation.low_V": Tolerance(0.01, "input range"),
        "saturation.high_V": Tolerance(0.01, "input range"),
    }

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.low_V < self.high_V, f"saturation: {self.low_V} .. {self.high_V} V is empty; low must be below")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        low_V, high_V = next(((clip.low_V, clip.high_V) for clip in present), (-math.inf, math.inf))
        return {"clip_low_V": low_V, "clip_high_V": high_V}

    def passes_V(self, low_V: float, high_V: float) -> tuple[float, float]:
        return max(low_V, self.low_V), min(high_V, self.high_V)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """One level or both, 4 to 25 % of the command's range inside its ends."""
        low_V, high_V = setting.range_V
        cut_V = float(rng.uniform(0.04, 0.25)) * (high_V - low_V)
        side = rng.integers(3)
        return cls(low_V + cut_V if side != 0 else NO_LOW_V, high_V - cut_V if side != 1 else NO_HIGH_V)

    def true_parameters(self) -> dict[str, float]:
        return {"saturation.low_V": self.low_V, "saturation.high_V": self.high_V}


EFFECT = SaturationEffect
