"""Slew: the amplifier limits the rate of its output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, Tolerance, require, require_finite


@dataclass(frozen=True)
class SlewEffect(Effect):
    """|du/dt| <= V_per_s: the rate at which the amplifier's current limit charges the ceramic."""

    V_per_s: float

    name = "slew"
    rank = 3
    bank_index = 4
    longest_substep_s = 20e-6  # the ramp ends in a kink at an instant of its own
    bends_amplifier = True
    tolerances: ClassVar = {"slew.rate_V_per_s": Tolerance(0.05)}

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.V_per_s > 0, f"slew.V_per_s: {self.V_per_s} V/s does not move; give a rate above 0")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        return {"slew_V_per_s": present[0].V_per_s} if present else {}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A rate that 3 to 25 % of the command's moving samples exceed."""
        rates = np.abs(np.diff(setting.u_V)) / setting.Ts_s
        return cls(float(np.quantile(rates[rates > 0], rng.uniform(0.75, 0.97))))

    def true_parameters(self) -> dict[str, float]:
        return {"slew.rate_V_per_s": self.V_per_s}


EFFECT = SlewEffect
