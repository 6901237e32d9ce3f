"""Resonance: lightly damped structural modes, in parallel, ahead of the lag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, Tolerance, require, require_finite
from hysgen_lab.stage.linear import Linear, exact_steps, oscillator


@dataclass(frozen=True)
class ResonanceEffect(Effect):
    """A lightly damped structural mode that carries `share` of the motion.

    share / (1 + 2 zeta s/w + s^2/w^2),   w = 2 pi f_Hz;  what no mode carries follows stiffly
    """

    f_Hz: float
    zeta: float
    share: float = 1.0

    name = "resonance"
    rank = 12
    most = 4
    bank_index = 1
    tolerances: ClassVar = {
        "resonance.f_Hz": Tolerance(0.02),
        "resonance.zeta": Tolerance(0.30),
        "resonance.share": None,
    }

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0, f"resonance.f_Hz: {self.f_Hz} Hz is no mode; give a frequency above 0")
        require(0 < self.zeta < 1, f"resonance.zeta: {self.zeta} is no light damping; choose between 0 and 1")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        return {"mechanics": modes_and_lag(present, period)}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A mode at 1 to 12 % of the sampling rate that carries 10 to 70 % of the motion."""
        f_Hz = float(np.exp(rng.uniform(np.log(0.01), np.log(0.12)))) / setting.Ts_s
        return cls(f_Hz, float(rng.uniform(0.01, 0.06)), float(rng.uniform(0.1, 0.7)))

    def true_parameters(self) -> dict[str, float]:
        return {"resonance.f_Hz": self.f_Hz, "resonance.zeta": self.zeta, "resonance.share": self.share}


def modes_and_lag(modes: Sequence[ResonanceEffect], period: Period) -> Linear:
    """Modes in parallel, then the lag:

    (sum_i share_i / (1 + 2 zeta_i s/w_i + s^2/w_i^2) + 1 - sum_i share_i) / (1 + lag s)
    """
    n = 2 * len(modes)
    lagging = period.lag_s > 0
    size = n + int(lagging)
    A, B, c = np.zeros((size, size)), np.zeros(size), np.zeros(size)
    stiff = 1.0
    for i, mode in enumerate(modes):
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], B[2 * i : 2 * i + 2] = oscillator(mode.f_Hz, mode.zeta)
        c[2 * i] = mode.share
        stiff -= mode.share
    if not lagging:
        return exact_steps(A, B, c, stiff, period.h_s)
    A[-1] = c / period.lag_s
    A[-1, -1] = -1 / period.lag_s
    B[-1] = stiff / period.lag_s
    out = np.zeros(size)
    out[-1] = 1.0
    return exact_steps(A, B, out, 0.0, period.h_s)


EFFECT = ResonanceEffect
