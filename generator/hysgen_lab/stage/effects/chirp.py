"""Chirp: a vibration whose frequency changes, such as a machine that runs up beside the stage."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Action, Effect, Setting, require, require_finite


@dataclass(frozen=True)
class ChirpEffect(Effect):
    """A sin(2 pi (f t + (g - f) t^2 / (2 T))):  from f = first_Hz at time 0 to g = last_Hz at T = over_s."""

    first_Hz: float
    last_Hz: float
    over_s: float
    amplitude_um: float

    name = "chirp"
    in_vocabulary = False
    rank = 15

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.over_s > 0, f"chirp.over_s: {self.over_s} s is no time; give a span above 0")

    def action(self, Ts_s: float, seed: int, rest_V: float) -> Action:
        return _Vibration(self, Ts_s)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """1 to 3 % of the stroke, over two octaves between 1/400 and 1/10 of the sampling rate, up or down."""
        low_Hz = float(np.exp(rng.uniform(np.log(1 / 400), np.log(1 / 40)))) / setting.Ts_s
        first_Hz, last_Hz = rng.permutation([low_Hz, 4.0 * low_Hz]).tolist()
        return cls(first_Hz, last_Hz, setting.span_s, float(rng.uniform(0.01, 0.03)) * setting.span_um)


class _Vibration(Action):
    def __init__(self, chirp: ChirpEffect, Ts_s: float) -> None:
        self._chirp, self._Ts_s, self._sample = chirp, Ts_s, 0

    def added_um(self, u_V: float) -> float:
        chirp, t_s = self._chirp, self._sample * self._Ts_s
        self._sample += 1
        turns = chirp.first_Hz * t_s + 0.5 * (chirp.last_Hz - chirp.first_Hz) * t_s * t_s / chirp.over_s
        return chirp.amplitude_um * math.sin(2 * math.pi * turns)


EFFECT = ChirpEffect
