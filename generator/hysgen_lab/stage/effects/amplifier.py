"""What the amplifier does to the command."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen_lab.stage.effects import (
    Action,
    Constants,
    Effect,
    Floats,
    Linear,
    Period,
    Setting,
    Tolerance,
    exact_steps,
    oscillator,
    require,
    require_finite,
)


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


NO_LOW_V, NO_HIGH_V = -60.0, 160.0
"""Levels that no command of the bank reaches."""


@dataclass(frozen=True)
class SaturationEffect(Effect):
    """The amplifier's output stays in [low_V, high_V], whatever is commanded."""

    low_V: float
    high_V: float

    name = "saturation"
    rank = 2
    bank_index = 3
    tolerances: ClassVar = {
        "saturation.low_V": Tolerance(0.01, "input range"),
        "saturation.high_V": Tolerance(0.01, "input range"),
    }

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.low_V < self.high_V, f"saturation: {self.low_V} .. {self.high_V} V is empty; low must be below")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        low_V, high_V = next(((clip.low_V, clip.high_V) for clip in present), (-math.inf, math.inf))
        return {"clip_low_V": low_V, "clip_high_V": high_V}

    def passes_V(self, low_V: float, high_V: float) -> tuple[float, float]:
        return max(low_V, self.low_V), min(high_V, self.high_V)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """One level or both, 4 to 25 % of the command's range inside its ends."""
        low_V, high_V = setting.range_V
        cut_V = float(rng.uniform(0.04, 0.25)) * (high_V - low_V)
        side = rng.integers(3)
        return cls(low_V + cut_V if side != 0 else NO_LOW_V, high_V - cut_V if side != 1 else NO_HIGH_V)

    def true_parameters(self) -> dict[str, float]:
        return {"saturation.low_V": self.low_V, "saturation.high_V": self.high_V}


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
