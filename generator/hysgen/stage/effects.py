"""What a stage can suffer from: one frozen dataclass per effect, named as the causes that an analysis looks for.

Every effect is physics with units, none is a model term. `memory` has a module of its own (`hysteresis`); `bandwidth`
(the amplifier's) and `stick_slip` (friction) stand outside the vocabulary of causes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.special import exp1

from hysgen.errors import HysgenError


class StageError(HysgenError):
    """A virtual stage is described, or driven, by numbers that make no stage."""


def require(holds: bool, complaint: str) -> None:
    """Raise StageError with `complaint` unless `holds`."""
    if not holds:
        raise StageError(complaint)


def require_finite(effect: object) -> None:
    """Raise StageError, naming effect and field, if a field of the dataclass `effect` is not a finite number."""
    for item in fields(effect):  # type: ignore[arg-type]
        value = getattr(effect, item.name)
        if not (isinstance(value, int | float | np.number) and math.isfinite(value)):
            raise StageError(f"{type(effect).__name__}.{item.name}: {value} is not a finite number; give a real one")


@dataclass(frozen=True)
class Saturation:
    """The amplifier clips: its output stays in [low_V, high_V] whatever is commanded."""

    low_V: float
    high_V: float

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.low_V < self.high_V, f"Saturation: {self.low_V} .. {self.high_V} V is empty; low must be below")


@dataclass(frozen=True)
class Slew:
    """The amplifier limits its rate: |du/dt| <= V_per_s, where the current limit charges the ceramic."""

    V_per_s: float

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.V_per_s > 0, f"Slew.V_per_s: {self.V_per_s} V/s does not move; give a rate above 0")


@dataclass(frozen=True)
class Bandwidth:
    """The amplifier's small-signal response, before the hysteresis: order 1, or 2 with damping ratio `zeta`.

    1 / (1 + s/w)   or   1 / (1 + 2 zeta s/w + s^2/w^2),   w = 2 pi f_Hz
    """

    f_Hz: float
    order: int = 1
    zeta: float = 0.7

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0, f"Bandwidth.f_Hz: {self.f_Hz} Hz passes nothing; give a frequency above 0")
        require(self.order in (1, 2), f"Bandwidth.order: {self.order} is not built; choose 1 or 2")
        require(self.zeta > 0, f"Bandwidth.zeta: {self.zeta} is not stable; give a damping ratio above 0")


@dataclass(frozen=True)
class Creep:
    """Logarithmic creep: a continuous, flat spectrum of relaxation times in ln(tau) between two cut-offs.

        moved(t) = (per_decade / ln 10) * integral from tau_min to tau_max of (1 - exp(-t/tau)) dtau/tau

    per_decade: share of a step's size by which the output moves on in every decade of time between the cut-offs.
    tau_min_s, tau_max_s: where the logarithmic law begins and ends. Movement counts from the rest before the record.
    Source: the usual law y0 (1 + g log10(t/t0)).
    """

    per_decade: float
    tau_min_s: float = 0.01
    tau_max_s: float = 1000.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(0 < self.tau_min_s < self.tau_max_s, "Creep: 0 < tau_min_s < tau_max_s must hold; widen the spectrum")

    @property
    def decades(self) -> float:
        """Width of the spectrum; the creep that is left to do after a step is per_decade * decades of its size."""
        return math.log10(self.tau_max_s / self.tau_min_s)

    def moved(self, t_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of a unit step that creep has added t_s > 0 after it, in closed form: shape of `t_s`."""
        late = exp1(t_s / self.tau_max_s) - exp1(t_s / self.tau_min_s)
        moved: NDArray[np.float64] = self.per_decade * (self.decades - late / math.log(10.0))
        return moved


@dataclass(frozen=True)
class Resonance:
    """A lightly damped structural mode that carries `share` of the motion.

    share / (1 + 2 zeta s/w + s^2/w^2),   w = 2 pi f_Hz;  what no mode carries follows stiffly
    """

    f_Hz: float
    zeta: float
    share: float = 1.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0, f"Resonance.f_Hz: {self.f_Hz} Hz is no mode; give a frequency above 0")
        require(0 < self.zeta < 1, f"Resonance.zeta: {self.zeta} is no light damping; choose between 0 and 1")


@dataclass(frozen=True)
class Delay:
    """The reading is late by `samples` (whole or fractional) sampling periods plus `seconds`."""

    samples: float = 0.0
    seconds: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.samples >= 0 and self.seconds >= 0, "Delay: a reading cannot be early; give numbers from 0 up")


@dataclass(frozen=True)
class Drift:
    """Slow movement that does not depend on the input: a ramp and a random walk (of the temperature, say)."""

    ramp_um_per_s: float = 0.0
    walk_um_per_rt_s: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.walk_um_per_rt_s >= 0, "Drift.walk_um_per_rt_s: a spread is not negative; give a number from 0 up")


@dataclass(frozen=True)
class Periodic:
    """A disturbance A sin(2 pi f t + phase): mains (near 50 Hz, rarely exactly), a pump, the floor."""

    f_Hz: float
    amplitude_um: float
    phase_rad: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0, f"Periodic.f_Hz: {self.f_Hz} Hz does not repeat; give a frequency above 0")


@dataclass(frozen=True)
class Aging:
    """The ceramic's gain goes linearly from 1 to 1 + fraction in the first `over_s` of the record, then stays."""

    fraction: float
    over_s: float

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.over_s > 0, f"Aging.over_s: {self.over_s} s is no time; give a span above 0")


@dataclass(frozen=True)
class Outliers:
    """Single corrupted samples: at `rate` per sample a reading jumps by 0.5 to 1.5 times `size_um`, up or down."""

    rate: float
    size_um: float

    def __post_init__(self) -> None:
        require_finite(self)
        require(0 <= self.rate < 1, f"Outliers.rate: {self.rate} is no probability; choose from 0 to below 1")


@dataclass(frozen=True)
class Coupling:
    """Other measured channels bend this axis, through the same mechanics: um per unit of each named channel."""

    um_per_unit: Mapping[str, float]

    def __post_init__(self) -> None:
        require(len(self.um_per_unit) > 0, "Coupling: no channel named; give a mapping such as {'axis2_V': 0.004}")
        for name, gain in self.um_per_unit.items():
            require(math.isfinite(gain), f"Coupling: gain {gain} of channel {name} is not finite; give a real number")
        object.__setattr__(self, "um_per_unit", MappingProxyType(dict(self.um_per_unit)))

    def __hash__(self) -> int:
        return hash(tuple(self.um_per_unit.items()))


@dataclass(frozen=True)
class StickSlip:
    """Friction: the table sticks until pulled by about `breakaway_um`, then jumps and sticks again.

    left: share of the pull that remains after a jump. scatter: relative spread of the breakaway from jump to jump.
    """

    breakaway_um: float
    left: float = 0.2
    scatter: float = 0.3

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.breakaway_um > 0, "StickSlip.breakaway_um: nothing sticks; give a displacement above 0")
        require(0 <= self.left < 1 and 0 <= self.scatter < 1, "StickSlip: left and scatter must lie from 0 to below 1")


@dataclass(frozen=True)
class Noise:
    """Sensor noise per reading, rms: white, and a 1/f part spread evenly over the decades from 1 mHz to 10 kHz."""

    white_um: float = 0.0005
    flicker_um: float = 0.0

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.white_um >= 0 and self.flicker_um >= 0, "Noise: a spread is not negative; give numbers from 0 up")
