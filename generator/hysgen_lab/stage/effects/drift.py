"""Drift: slow movement that does not depend on the input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, require, require_finite


@dataclass(frozen=True)
class DriftEffect(Effect):
    """A ramp and a random walk (with the temperature, for example), independent of the input."""

    ramp_um_per_s: float = 0.0
    walk_um_per_rt_s: float = 0.0

    name = "drift"
    rank = 6
    bank_index = 5

    def __post_init__(self) -> None:
        require_finite(self)
        require(
            self.walk_um_per_rt_s >= 0,
            "drift.walk_um_per_rt_s: a spread is not negative; give a number from 0 up",
        )

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        drift = present[0] if present else DriftEffect()
        return {"drift_um_per_s": drift.ramp_um_per_s, "walk_um_per_rt_s": drift.walk_um_per_rt_s}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A ramp of either sign."""
        return cls(float(rng.choice([-1, 1])) * 2.0 * setting.share * setting.span_um / setting.span_s)

    def true_parameters(self) -> dict[str, float]:
        return {"drift.ramp_um_per_s": self.ramp_um_per_s}


EFFECT = DriftEffect
