"""What moves a reading and not the stage's input: the sensor, disturbances, other channels."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Self

import numpy as np

from hysgen_lab.stage.effects import Action, Constants, Effect, Period, Setting, Tolerance, require, require_finite

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


@dataclass(frozen=True)
class OutliersEffect(Effect):
    """Single corrupted samples: at `rate` per sample a reading jumps by 0.5 to 1.5 times `size_um`, up or down."""

    rate: float
    size_um: float

    name = "outliers"
    rank = 8
    bank_index = 8

    def __post_init__(self) -> None:
        require_finite(self)
        require(0 <= self.rate < 1, f"outliers.rate: {self.rate} is no probability; choose from 0 to below 1")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        outliers = present[0] if present else OutliersEffect(0.0, 0.0)
        return {"outlier_rate": outliers.rate, "outlier_um": outliers.size_um}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        return cls(float(rng.uniform(1e-3, 5e-3)), 8.0 * setting.share * setting.span_um)


@dataclass(frozen=True)
class DelayEffect(Effect):
    """The reading is late by `samples` (whole or fractional) sampling periods plus `seconds`."""

    samples: float = 0.0
    seconds: float = 0.0

    name = "delay"
    rank = 5
    bank_index = 2
    tolerances: ClassVar = {"delay.delay_samples": Tolerance(0.2, "absolute")}

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.samples >= 0 and self.seconds >= 0, "delay: a reading cannot be early; give numbers from 0 up")

    def late_s(self, Ts_s: float) -> float:
        return self.samples * Ts_s + self.seconds

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        return cls(float(rng.uniform(0.5, 12.0)))

    def true_parameters(self) -> dict[str, float]:
        return {"delay.delay_samples": self.samples}


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


@dataclass(frozen=True)
class AgingEffect(Effect):
    """The ceramic's gain goes linearly from 1 to 1 + fraction in the first `over_s` of the record, then stays."""

    fraction: float
    over_s: float

    name = "aging"
    rank = 7
    bank_index = 7

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.over_s > 0, f"aging.over_s: {self.over_s} s is no time; give a span above 0")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        aging = present[0] if present else AgingEffect(0.0, 1.0)
        return {"age_fraction": aging.fraction, "age_s": aging.over_s}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A gain that rises or falls over the whole record."""
        return cls(float(rng.choice([-1, 1])) * 2.0 * setting.share, setting.span_s)

    def true_parameters(self) -> dict[str, float]:
        return {"aging.per_s": self.fraction / self.over_s}


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


BANK_RANGE = 30.0
"""Standard deviation, roughly, of the bank's further channels, in their unit."""


@dataclass(frozen=True)
class CouplingEffect(Effect):
    """Other measured channels bend this axis, through the same mechanics: um per unit of each named channel."""

    um_per_unit: Mapping[str, float]

    name = "coupling"
    rank = 9
    bank_index = 9
    needs_channel = True

    def __post_init__(self) -> None:
        require(len(self.um_per_unit) > 0, "coupling: no channel named; give a mapping such as {'axis2_V': 0.004}")
        for name, gain in self.um_per_unit.items():
            require(math.isfinite(gain), f"coupling: gain {gain} of channel {name} is not finite; give a real number")
        object.__setattr__(self, "um_per_unit", MappingProxyType(dict(self.um_per_unit)))

    def __hash__(self) -> int:
        return hash(tuple(self.um_per_unit.items()))

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.um_per_unit)

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        gains = np.array([gain for coupling in present for gain in coupling.um_per_unit.values()], dtype=np.float64)
        return {"channels": len(gains), "coupling_um": gains, "channel": np.zeros(len(gains))}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A coupling of either sign to the first further channel."""
        return cls({setting.channels[0]: float(rng.choice([-1, 1])) * setting.share * setting.span_um / BANK_RANGE})

    def true_parameters(self) -> dict[str, float]:
        return {f"coupling.{name}_um_per_unit": gain for name, gain in self.um_per_unit.items()}
