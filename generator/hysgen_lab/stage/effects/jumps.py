"""Jumps: the sensor's zero moves suddenly, as after a knock or a loosened clamp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Action, Effect, Setting, require, require_finite


@dataclass(frozen=True)
class JumpsEffect(Effect):
    """At `rate` per sample the displacement moves by 0.5 to 1.5 times `size_um`, up or down, and stays there."""

    rate: float
    size_um: float

    name = "jumps"
    in_vocabulary = False
    rank = 14

    def __post_init__(self) -> None:
        require_finite(self)
        require(0 <= self.rate < 1, f"jumps.rate: {self.rate} is no probability; choose from 0 to below 1")

    def action(self, Ts_s: float, seed: int, rest_V: float) -> Action:
        return _Jumping(self, np.random.default_rng([seed, self.rank]))

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """5 to 12 jumps of 1 to 3 % of the stroke."""
        return cls(float(rng.uniform(5, 12)) / len(setting.u_V), float(rng.uniform(0.01, 0.03)) * setting.span_um)


class _Jumping(Action):
    def __init__(self, jumps: JumpsEffect, rng: np.random.Generator) -> None:
        self._jumps, self._rng, self._zero_um = jumps, rng, 0.0

    def added_um(self, u_V: float) -> float:
        if self._rng.random() < self._jumps.rate:
            self._zero_um += float(self._rng.choice([-1, 1]) * self._rng.uniform(0.5, 1.5)) * self._jumps.size_um
        return self._zero_um


EFFECT = JumpsEffect
