"""Noise: of the sensor, white and 1/f."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, require, require_finite

CORNERS_HZ = 10.0 ** np.arange(-3, 5)  # corner frequencies of relaxations whose sum is 1/f between them


@dataclass(frozen=True)
class NoiseEffect(Effect):
    """Sensor noise per reading, rms: white, and a 1/f part of equal power in each decade from 1 mHz to 10 kHz."""

    white_um: float = 0.0005
    flicker_um: float = 0.0

    name = "noise"
    in_vocabulary = False
    active = False  # every sensor has noise
    rank = 11

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.white_um >= 0 and self.flicker_um >= 0, "noise: a spread is not negative; give numbers from 0 up")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        noise = present[0] if present else NoiseEffect(0.0, 0.0)
        keep = np.exp(-2 * np.pi * CORNERS_HZ * period.Ts_s)
        return {"white_um": noise.white_um, "flicker_um": noise.flicker_um, "flicker_keep": keep}


EFFECT = NoiseEffect
