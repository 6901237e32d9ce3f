"""Creep: the output moves on for seconds after its input has stopped.

    y(k) = x(k) + amount sum_i s_i(k)
    s_i(k+1) = s_i(k) + a_i (x(k) - s_i(k)),   a_i = 1 - exp(-Ts / tau_i)        exact for an input held over a sample

x is the output of the hysteresis. Creep of piezo ceramics is logarithmic in time: time constants evenly spaced on a
logarithmic axis, with one amount for all. In float32 a state is a sum of two words (`float32_arithmetic`), because a_i
may be smaller than the last bit of s_i.
Source: Croft, Shed and Devasia, J. Dyn. Sys. Meas. Control 123 (2001) 35-43.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.machine.kernels.operators import lag_sums
from hysgen.machine.reproducible import expm1, spectral_radius
from hysgen.model.float32_arithmetic import KEPT, accumulate
from hysgen.model.intervals import Interval
from hysgen.model.path.base import BlockBox, BlockMirror, Floats, Floats32, InputBlock, StateSpace, singles
from hysgen.model.structs import INPUT_UNIT, Member, Quantity


@dataclass(frozen=True)
class Creep(InputBlock):
    """`amount` of each slow state, with time constants `tau_s`, (m,) positive and rising.

    Raises ValueError if tau_s is not positive and rising, or if 1 + m amount is not positive.
    """

    kind: ClassVar[str] = "creep"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "rate": Quantity("part of its distance to the input by which each slow state moves per sample"),
        "amount": Quantity("weight of each slow state in the output"),
    }
    place: ClassVar[int] = 40
    limits: ClassVar[bool] = False
    responds: ClassVar[bool] = True
    two_words: ClassVar[bool] = True

    amount: float
    tau_s: tuple[float, ...]

    def __post_init__(self) -> None:
        tau = np.asarray(self.tau_s, dtype=np.float64)
        if tau.size == 0 or not np.isfinite(tau).all() or tau[0] <= 0 or (np.diff(tau) <= 0).any():
            raise ValueError("tau_s must be positive and rising")
        if not 1.0 + tau.size * self.amount > 0.0:
            raise ValueError("amount must be above -1 over the number of states")

    @classmethod
    @functools.lru_cache(maxsize=64)
    def logarithmic(cls, per_decade: float, from_s: float, to_s: float, states: int = 1) -> Self:
        """Creep by the share `per_decade` of a step in each decade of time from from_s to to_s, by `states` states."""
        count = max(1, math.ceil(states * math.log10(to_s / from_s)))
        return cls(per_decade / states, tuple((from_s * 10.0 ** ((np.arange(count) + 0.5) / states)).tolist()))

    def rates(self, Ts_s: float) -> Floats:
        """(m,) a_i: the part of the distance to x that a state moves in one sample."""
        return _rates(self.tau_s, Ts_s)

    def describe(self) -> str:
        tau = self.tau_s
        states = (
            f"{len(tau)} states of {tau[0]:.3g} .. {tau[-1]:.3g} s" if len(tau) > 1 else f"1 state of {tau[0]:.3g} s"
        )
        return f"creep by {self.amount:.3g} per state, {states}"

    def start(self, x: float) -> Floats:
        """State at rest under x: every slow state at x."""
        return np.full(len(self.tau_s), x)

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        sums = lag_sums(u_V, self.rates(Ts_s), self.start(float(u_V[0])) if start is None else start)
        return np.asarray(u_V + self.amount * sums)

    def free_responses(self, t_s: Floats) -> list[Floats]:
        """exp(-t / tau_i)"""
        return [np.exp(-t_s / tau_s) for tau_s in self.tau_s]

    def image(self, u_V: Interval) -> Interval:
        """x + amount sum s_i with x and every s_i anywhere in the range of x."""
        return spread(u_V, len(self.tau_s) * self.amount)

    def zero(self, Ts_s: float) -> float:
        """Largest |eigenvalue| of the inverse, s(k+1) = s(k) + a (y(k) - amount sum_i s_i(k) - s(k))."""
        return _zero(self, Ts_s)

    def state_space(self, Ts_s: float) -> StateSpace:
        rates = self.rates(Ts_s)
        return np.diag(1.0 - rates), rates, np.full(rates.size, self.amount), 1.0

    def solves(self, Ts_s: float) -> bool:
        return self.zero(Ts_s) < 1.0

    def box(self, u_V: Interval, Ts_s: float) -> BlockBox:
        """|high_i|, |low_i| < LIMIT of `float32_arithmetic`, in the unit of x, and with them

            |y - x|, |x - y| <= m |amount| LIMIT        of `apply` and of `solve`, times 1.01 for the roundings

        That every s_i stays in the range of x is a relation between s_i and x, which intervals do not describe.
        """
        m = len(self.tau_s)
        floats = {f"{word}[{i}]": KEPT for word in ("high", "low") for i in range(m)}
        away = 1.01 * m * abs(float(self.constants(Ts_s)["amount"][0])) * KEPT.high
        return BlockBox(floats, u_V.outwards(away), u_V.outwards(2.0 * away))

    def members(self) -> tuple[Member, ...]:
        states = (len(self.tau_s),)
        return (
            Member("high", "float", "slow states of the creep", states, unit=INPUT_UNIT),
            Member("low", "float", "rounding error of `high`, added to the next step", states, unit=INPUT_UNIT),
        )

    def mirror(self, u_V: Floats32, Ts_s: float) -> CreepMirror:
        constants = self.constants(Ts_s)
        return CreepMirror(self, constants["rate"], constants["amount"][0], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {"rate": singles(self.rates(Ts_s)), "amount": singles(np.array([self.amount]))}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        tau = np.geomspace(1e-3, 10.0, 4) * rng.uniform(0.7, 1.3)
        return (cls(float(rng.uniform(0.005, 0.03)), tuple(tau.tolist())),)


@functools.lru_cache(maxsize=64)
def _rates(tau_s: tuple[float, ...], Ts_s: float) -> Floats:
    rates = np.array([-expm1(-Ts_s / tau) for tau in tau_s])
    rates.flags.writeable = False
    return rates


@functools.lru_cache(maxsize=64)
def _zero(block: Creep, Ts_s: float) -> float:
    rates = block.rates(Ts_s)
    # Similar to diag(1 - a) - amount a 1', and symmetric: the eigenvalues close to 1 keep their digits.
    return spectral_radius(np.diag(1.0 - rates) - block.amount * np.sqrt(np.outer(rates, rates)))


class CreepMirror(BlockMirror):
    """Float32 slow states over lanes, each a sum of two words; y takes the higher words."""

    def __init__(self, block: Creep, rate: Floats32, amount: np.float32, u_V: Floats32) -> None:
        self.members = block.members()
        self._rate, self._amount, self._rest = rate, amount, u_V
        self.high: list[Floats32] = [u_V.copy() for _ in rate]
        self.low: list[Floats32] = [np.zeros_like(u_V) for _ in rate]

    def rest(self) -> Floats32:
        return self._rest + self._slow()

    def apply(self, u_V: Floats32) -> Floats32:
        y = u_V + self._slow()
        # The difference omits the low word, which is below the last bit of the high word.
        sums = [
            accumulate(high, low, a * (u_V - high))
            for high, low, a in zip(self.high, self.low, self._rate, strict=True)
        ]
        self.high, self.low = [high for high, _ in sums], [low for _, low in sums]
        return y

    def solve(self, wanted: Floats32) -> Floats32:
        return wanted - self._slow()

    def _slow(self) -> Floats32:
        """amount sum_i s_i."""
        total = self.high[0]
        for state in self.high[1:]:
            total = total + state
        return np.asarray(self._amount * total)


def spread(x: Interval, share: float) -> Interval:
    """Range of x + share s with x and s anywhere in an interval."""
    ends = [x.low + share * end for end in (x.low, x.high)] + [x.high + share * end for end in (x.low, x.high)]
    return Interval(min(ends), max(ends))
