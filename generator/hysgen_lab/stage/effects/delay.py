"""Delay: the reading is late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen_lab.stage.effects.base import Effect, Setting, Tolerance, require, require_finite


@dataclass(frozen=True)
class DelayEffect(Effect):
    """The reading is late by `samples` (whole or fractional) sampling periods plus `seconds`."""

    samples: float = 0.0
    seconds: float = 0.0

    name = "delay"
    rank = 5
    bank_index = 2
    tolerances: ClassVar = {"delay.delay_samples": Tolerance(0.2, "absolute")}

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.samples >= 0 and self.seconds >= 0, "delay: a reading cannot be early; give numbers from 0 up")

    def late_s(self, Ts_s: float) -> float:
        return self.samples * Ts_s + self.seconds

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        return cls(float(rng.uniform(0.5, 12.0)))

    def true_parameters(self) -> dict[str, float]:
        return {"delay.delay_samples": self.samples}


EFFECT = DelayEffect
