"""Gain step: the amplifier's gain changes once, at one instant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Action, Effect, Setting, require, require_finite


@dataclass(frozen=True)
class GainStepEffect(Effect):
    """The amplifier multiplies the command by 1 before `at_s` and by 1 + fraction from then on."""

    fraction: float
    at_s: float

    name = "gain_step"
    in_vocabulary = False
    rank = 16

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.fraction > -1, f"gain_step.fraction: {self.fraction} leaves no gain; choose above -1")

    def action(self, Ts_s: float, seed: int, rest_V: float) -> Action:
        return _Stepping(self, Ts_s)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A change of 3 to 8 % of either sign, in the middle half of the record."""
        return cls(
            float(rng.choice([-1, 1]) * rng.uniform(0.03, 0.08)), float(rng.uniform(0.25, 0.75)) * setting.span_s
        )


class _Stepping(Action):
    def __init__(self, step: GainStepEffect, Ts_s: float) -> None:
        self._step, self._Ts_s, self._sample = step, Ts_s, 0

    def command_V(self, u_V: float) -> float:
        stepped = self._sample * self._Ts_s >= self._step.at_s
        self._sample += 1
        return u_V * (1.0 + self._step.fraction) if stepped else u_V


EFFECT = GainStepEffect
