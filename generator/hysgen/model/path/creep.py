"""Creep: the output moves on for seconds after its input has stopped.

    y(k) = x(k) + amount sum_i s_i(k)
    s_i(k+1) = s_i(k) + a_i (x(k) - s_i(k)),   a_i = 1 - exp(-Ts / tau_i)        exact for an input held over a sample

x is the output of the hysteresis. Creep of piezo ceramics is logarithmic in time: time constants evenly spaced on a
logarithmic axis, with one amount for all. In float32 a state is a sum of two words (module `twofloat`), because a_i may
be smaller than the last bit of s_i.
Source: Croft, Shed and Devasia, J. Dyn. Sys. Meas. Control 123 (2001) 35-43.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.machine.kernels import lag_states
from hysgen.machine.reproducible import expm1
from hysgen.model.intervals import Interval
from hysgen.model.path.base import BlockMirror, Floats, Floats32, InputBlock


@dataclass(frozen=True)
class Creep(InputBlock):
    """`amount` of each slow state, with time constants `tau_s`, (m,) positive and rising.

    Raises ValueError if tau_s is not positive and rising, or if 1 + m amount is not positive.
    """

    kind: ClassVar[str] = "creep"
    place: ClassVar[int] = 4
    limits: ClassVar[bool] = False
    responds: ClassVar[bool] = True

    amount: float
    tau_s: tuple[float, ...]

    def __post_init__(self) -> None:
        tau = np.asarray(self.tau_s, dtype=np.float64)
        if tau.size == 0 or not np.isfinite(tau).all() or tau[0] <= 0 or (np.diff(tau) <= 0).any():
            raise ValueError("tau_s must be positive and rising")
        if not 1.0 + tau.size * self.amount > 0.0:
            raise ValueError("amount must be above -1 over the number of states")

    def rates(self, Ts_s: float) -> Floats:
        """(m,) a_i: the part of the distance to x that a state moves in one sample."""
        return np.array([-expm1(-Ts_s / tau) for tau in self.tau_s])

    def describe(self) -> str:
        tau = self.tau_s
        return f"creep by {self.amount:.3g} per state, {len(tau)} states of {tau[0]:.3g} .. {tau[-1]:.3g} s"

    def start(self, x: float) -> Floats:
        """State at rest under x: every slow state at x."""
        return np.full(len(self.tau_s), x)

    def apply(self, u_V: Floats, Ts_s: float, start: Floats | None = None) -> Floats:
        states = lag_states(u_V, self.rates(Ts_s), self.start(float(u_V[0])) if start is None else start)
        return np.asarray(u_V + self.amount * states.sum(axis=1))

    def image(self, u_V: Interval) -> Interval:
        """x + amount sum s_i with x and every s_i anywhere in the range of x."""
        return spread(u_V, len(self.tau_s) * self.amount)

    def mirror(self, u_V: Floats32, Ts_s: float) -> BlockMirror:
        raise NotImplementedError

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {"rate": self.rates(Ts_s).astype(np.float32), "amount": np.array([self.amount], np.float32)}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        tau = np.geomspace(1e-3, 10.0, 4) * rng.uniform(0.7, 1.3)
        return (cls(float(rng.uniform(0.005, 0.03)), tuple(tau.tolist())),)


def spread(x: Interval, share: float) -> Interval:
    """Range of x + share s with x and s anywhere in an interval."""
    ends = [x.low + share * end for end in (x.low, x.high)] + [x.high + share * end for end in (x.low, x.high)]
    return Interval(min(ends), max(ends))


BLOCK = Creep
