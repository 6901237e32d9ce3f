"""What the mechanics and the ceramic do behind the hysteresis: modes, creep, a spring that yields, dry friction."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import exp1

from hysgen_lab.stage.effects import (
    Action,
    Constants,
    Effect,
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


NODES_PER_DECADE = 6  # quadrature of the spectrum: error below 1e-7 of the creep (tested)


@dataclass(frozen=True)
class CreepEffect(Effect):
    """Logarithmic creep: a continuous, flat spectrum of relaxation times in ln(tau) between two cut-offs.

        moved(t) = (per_decade / ln 10) * integral from tau_min to tau_max of (tau/tau_m)^p (1 - exp(-t/tau)) dtau/tau

    per_decade: share of a step's size by which the output moves on in every decade of time between the cut-offs.
    tau_min_s, tau_max_s: where the logarithmic law begins and ends. Movement counts from the rest before the record.
    exponent: p, of a power law (t/tau_m)^p about the geometric mean tau_m of the cut-offs; 0: logarithmic creep.
    Source: the usual law y0 (1 + g log10(t/t0)); Findley (1976) for the power law.
    """

    per_decade: float
    tau_min_s: float = 0.01
    tau_max_s: float = 1000.0
    exponent: float = 0.0

    name = "creep"
    rank = 4
    bank_index = 0
    longest_substep_s = 100e-6
    # from_s, the lower cut-off, is where the diagnosis starts a discrete spectrum: no number to compare.
    tolerances: ClassVar = {"creep.per_decade": Tolerance(0.15), "creep.from_s": None}

    def __post_init__(self) -> None:
        require_finite(self)
        require(0 < self.tau_min_s < self.tau_max_s, "creep: 0 < tau_min_s < tau_max_s must hold; widen the spectrum")

    @property
    def decades(self) -> float:
        """Width of the spectrum; the creep that is left to do after a step is per_decade * decades of its size."""
        return math.log10(self.tau_max_s / self.tau_min_s)

    def moved(self, t_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of a unit step that creep has added t_s > 0 after it, in closed form: shape of `t_s`.

        Raises StageError for a power law, which has no closed form here.
        """
        require(self.exponent == 0.0, "creep.moved: a power law has no closed form; choose exponent 0")
        late = exp1(t_s / self.tau_max_s) - exp1(t_s / self.tau_min_s)
        moved: NDArray[np.float64] = self.per_decade * (self.decades - late / math.log(10.0))
        return moved

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        """Gauss-Legendre quadrature, in ln(tau), of the continuous spectrum: n relaxations of constant weights."""
        if not present:
            return {}
        (creep,) = present
        count = max(6, math.ceil(NODES_PER_DECADE * creep.decades))
        place, weight = (np.asarray(part, dtype=np.float64) for part in np.polynomial.legendre.leggauss(count))
        tau_s = creep.tau_min_s * 10 ** (creep.decades * (place + 1) / 2)
        ratio = period.h_s[:, None] / tau_s
        gone = -np.expm1(-ratio)
        # Exact for an input linear in time: its begin counts gone/ratio - exp(-ratio), its end 1 - gone/ratio.
        g1 = 1 - gone / ratio
        return {
            "creeps": count,
            "creep_keep": np.exp(-ratio),
            "creep_g0": gone - g1,
            "creep_g1": g1,
            "creep_share": creep.per_decade
            * creep.decades
            * (weight / 2)
            * (tau_s / math.sqrt(creep.tau_min_s * creep.tau_max_s)) ** creep.exponent,
            "creep_x": np.zeros(count),
        }

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """Creep that begins within the record and goes on long after it."""
        return cls(setting.share * 0.8, setting.span_s / 400.0, 1000.0 * setting.span_s)

    def true_parameters(self) -> dict[str, float]:
        return {"creep.per_decade": self.per_decade, "creep.from_s": self.tau_min_s} if self.exponent == 0.0 else {}


ELEMENTS, TURN_STEPS = 24, 400  # Jenkins elements; steps in a period of the mode, for 1e-4 of its frequency


@dataclass(frozen=True)
class SofteningEffect(Effect):
    """A mode at f_Hz for small amplitudes, of whose stiffness the share `yielding` slips in stops up to yield_V wide.

    x'' + 2 zeta w x' + w^2 ((1 - yielding) x + yielding mean_i f_i) = w^2 u,   f_i = clamp(f_i + dx, -r_i, r_i)

    r_i uniform to yield_V; x is the voltage that the stage is given in place of u. Source: Iwan, J. Appl. Mech. (1966).
    """

    f_Hz: float
    zeta: float
    yielding: float
    yield_V: float

    name = "softening"
    rank = 17

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.f_Hz > 0 and self.yield_V > 0, "softening: give a frequency and a yield voltage above 0")
        require(0 < self.zeta < 1 and 0 < self.yielding < 1, "softening: zeta and yielding must be shares")

    def action(self, Ts_s: float, seed: int, rest_V: float) -> Action:
        return _YieldingMode(self, Ts_s, rest_V)


class _YieldingMode(Action):
    """The mode under a held voltage, by symplectic Euler steps from rest."""

    def __init__(self, effect: SofteningEffect, Ts_s: float, rest_V: float) -> None:
        self.effect, self.rest_V, self.w = effect, rest_V, 2.0 * math.pi * effect.f_Hz
        self.steps = max(1, math.ceil(TURN_STEPS * effect.f_Hz * Ts_s))
        self.h_s, self.x, self.speed = Ts_s / self.steps, 0.0, 0.0
        self.reach = effect.yield_V * (np.arange(ELEMENTS) + 0.5) / ELEMENTS
        self.force = np.zeros(ELEMENTS)

    def command_V(self, u_V: float) -> float:
        moved_V, soft = self.rest_V + self.x, self.effect.yielding
        for _ in range(self.steps):
            spring = (1.0 - soft) * self.x + soft * float(self.force.mean())
            pull = self.w**2 * (u_V - self.rest_V - spring) - 2.0 * self.effect.zeta * self.w * self.speed
            self.speed += self.h_s * pull
            self.x += self.h_s * self.speed
            self.force = np.clip(self.force + self.h_s * self.speed, -self.reach, self.reach)
        return moved_V


@dataclass(frozen=True)
class StickSlipEffect(Effect):
    """Friction: the table sticks until pulled by about `breakaway_um`, then jumps and sticks again.

    left: share of the pull that remains after a jump. scatter: relative spread of the breakaway from jump to jump.
    """

    breakaway_um: float
    left: float = 0.2
    scatter: float = 0.3

    name = "stick_slip"
    in_vocabulary = False
    rank = 10
    bank_index = 13
    longest_substep_s = 100e-6

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.breakaway_um > 0, "stick_slip.breakaway_um: nothing sticks; give a displacement above 0")
        require(0 <= self.left < 1 and 0 <= self.scatter < 1, "stick_slip: left and scatter must lie from 0 to below 1")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        if not present:
            return {}
        (slip,) = present
        return {"stick_um": slip.breakaway_um, "stick_left": slip.left, "stick_scatter": slip.scatter}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """Friction of 2 to 6 % of the stroke."""
        return cls(float(rng.uniform(0.02, 0.06)) * setting.span_um)
