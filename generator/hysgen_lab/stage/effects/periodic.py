"""Periodic: a disturbance at a fixed frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, Tolerance, require, require_finite


@dataclass(frozen=True)
class PeriodicEffect(Effect):
    """A disturbance A sin(2 pi f t + phase): mains (near 50 Hz, rarely exactly), a pump, the floor."""

    f_Hz: float
    amplitude_um: float
    phase_rad: float = 0.0

    name = "periodic"
    rank = 13
    most = 16
    bank_index = 6
    tolerances: ClassVar = {"periodic.f_Hz": Tolerance(0.1, "absolute"), "periodic.amplitude_um": Tolerance()}

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0, f"periodic.f_Hz: {self.f_Hz} Hz does not repeat; give a frequency above 0")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        return {
            "lines": len(present),
            "line_Hz": np.array([line.f_Hz for line in present]),
            "line_um": np.array([line.amplitude_um for line in present]),
            "line_rad": np.array([line.phase_rad for line in present]),
        }

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A line between 40 periods in the record and a fifth of the sampling rate."""
        f_Hz = float(np.exp(rng.uniform(np.log(40.0 / setting.span_s), np.log(0.2 / setting.Ts_s))))
        return cls(f_Hz, setting.share * setting.span_um, float(rng.uniform(0.0, 6.0)))

    def true_parameters(self) -> dict[str, float]:
        return {"periodic.f_Hz": self.f_Hz, "periodic.amplitude_um": self.amplitude_um}


EFFECT = PeriodicEffect
