"""Bandwidth: the amplifier's small-signal response."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, require, require_finite
from hysgen_lab.stage.linear import Floats, Linear, exact_steps, oscillator


@dataclass(frozen=True)
class BandwidthEffect(Effect):
    """The amplifier's small-signal response, before the hysteresis: order 1, or 2 with damping ratio `zeta`.

    1 / (1 + s/w)   or   1 / (1 + 2 zeta s/w + s^2/w^2),   w = 2 pi f_Hz
    """

    f_Hz: float
    order: int = 1
    zeta: float = 0.7

    name = "bandwidth"
    in_vocabulary = False
    rank = 1
    longest_substep_s = 100e-6
    bends_amplifier = True

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0, f"bandwidth.f_Hz: {self.f_Hz} Hz passes nothing; give a frequency above 0")
        require(self.order in (1, 2), f"bandwidth.order: {self.order} is not built; choose 1 or 2")
        require(self.zeta > 0, f"bandwidth.zeta: {self.zeta} is not stable; give a damping ratio above 0")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        if not present:
            return {"amplifier": exact_steps(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 1.0, period.h_s)}
        return {"amplifier": present[0].response(period.h_s)}

    def response(self, h_s: Floats) -> Linear:
        """Exact steps of the response over the substeps h_s, (m,), with unit gain."""
        if self.order == 1:
            w = 2 * math.pi * self.f_Hz
            return exact_steps(np.array([[-w]]), np.array([w]), np.array([1.0]), 0.0, h_s)
        A, B = oscillator(self.f_Hz, self.zeta)
        return exact_steps(A, B, np.array([1.0, 0.0]), 0.0, h_s)


EFFECT = BandwidthEffect
