"""Creep: the output keeps moving for seconds after the input has stopped.

    ds_j/dt = (u - s_j) / tau_j                                   slow first-order states, tau_j spread over decades
    s_j(k+1) = s_j(k) + a_j (u(k) - s_j(k)),   a_j = 1 - exp(-Ts / tau_j)     exact for an input held over a sample
    phi_j(k) = s_j(k)                                             [V]

A few time constants per decade stand for the logarithmic creep of piezo ceramics. A record starts at rest under u(0).
In float32 a state is a sum of two words (module `twofloat`), because a_j may be smaller than the last bit of s_j.
Source: Croft, Shed and Devasia, J. Dyn. Sys. Meas. Control 123 (2001) 35-43 (creep as a chain of lags).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from hysgen.kernels.poles import lag_states
from hysgen.terms.base import Bits, Drive, Floats, Floats32, Mirror, StateSpace
from hysgen.terms.twofloat import accumulate


@dataclass(frozen=True)
class Creep:
    """Lags with time constants `tau_s`, (m,) positive and rising.

    Raises ValueError if they are not.
    """

    kind: ClassVar[str] = "creep"
    parts: ClassVar[tuple[str, ...]] = ("twofloat",)
    channels: ClassVar[tuple[str, ...]] = ()
    tau_s: tuple[float, ...]

    def __post_init__(self) -> None:
        tau = np.asarray(self.tau_s, dtype=np.float64)
        if tau.size == 0 or not np.isfinite(tau).all() or tau[0] <= 0 or (np.diff(tau) <= 0).any():
            raise ValueError("tau_s must be positive and rising")

    @classmethod
    def spread(cls, count: int, shortest_s: float, longest_s: float) -> Self:
        """`count` time constants, evenly spaced on a logarithmic axis, both ends included."""
        return cls(tuple(float(tau) for tau in np.geomspace(shortest_s, longest_s, count)))

    @property
    def size(self) -> int:
        return len(self.tau_s)

    def rates(self, Ts_s: float) -> Floats:
        """(m,) a_j: the part of the way to u that a state goes in one sample."""
        return np.asarray(-np.expm1(-Ts_s / np.asarray(self.tau_s)))

    def scales(self, span_V: float) -> tuple[float, ...]:
        return (span_V,) * self.size

    def describe(self) -> str:
        return "creep, time constants " + ", ".join(f"{tau:.3g}" for tau in self.tau_s) + " s"

    def regressors(self, drive: Drive) -> Floats:
        """(n, m) creep states in V."""
        start = drive.start.get(self.kind, self.start(float(drive.u_V[0])))
        return lag_states(drive.u_V, self.rates(drive.Ts_s), start)

    def start(self, u_V: float) -> Floats:
        return np.full(self.size, u_V)

    def settled(self, drive: Drive) -> int:
        samples = np.log(100.0) * self.tau_s[-1] / drive.Ts_s
        return int(min(drive.u_V.size, np.ceil(samples)))

    def linear(self, Ts_s: float) -> StateSpace:
        rates = self.rates(Ts_s)
        return StateSpace(np.diag(1.0 - rates), rates, np.eye(self.size))

    def gains(self, Ts_s: float) -> tuple[float, ...]:
        """The impulse response of a lag is positive and adds up to 1."""
        return (1.0,) * self.size

    def shape(self) -> Floats:
        """(m,) natural logarithms of tau_j in s."""
        return np.asarray(np.log(self.tau_s))

    def with_shape(self, shape: Floats) -> Self:
        return type(self)(tuple(float(tau) for tau in np.exp(np.sort(shape))))

    def shape_bounds(self, drive: Drive) -> tuple[Floats, Floats]:
        """From 2 samples to 3 records: a slower state is a ramp that no record of this length tells from another."""
        low, high = np.log(2.0 * drive.Ts_s), np.log(3.0 * drive.Ts_s * drive.u_V.size)
        return np.full(self.size, low), np.full(self.size, high)

    def mirror(self, u_V: Floats32, Ts_s: float) -> CreepMirror:
        return CreepMirror(self.constants(Ts_s)["rate"], u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {"rate": self.rates(Ts_s).astype(np.float32)}

    def to_json(self) -> dict[str, Any]:
        return {"kind": self.kind, "tau_s": list(self.tau_s)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        return cls(tuple(float(tau) for tau in data["tau_s"]))


class CreepMirror(Mirror):
    """Float32 lags over lanes, each a sum of two words; the state is every high word, then every low one."""

    def __init__(self, rate: Floats32, u_V: Floats32) -> None:
        self._rate = rate
        self._words = [(u_V.copy(), np.zeros_like(u_V)) for _ in rate]

    def regressors(self) -> list[Floats32]:
        return [high for high, _ in self._words]

    def advance(self, u_V: Floats32) -> None:
        # The low word is left out of the difference: it is below the last bit of the high one.
        self._words = [
            accumulate(high, low, a * (u_V - high)) for (high, low), a in zip(self._words, self._rate, strict=True)
        ]

    def state(self) -> list[Floats32]:
        return [*(high for high, _ in self._words), *(low for _, low in self._words)]

    def restore(self, words: Sequence[Bits]) -> None:
        floats = [word.view(np.float32) for word in words]
        self._words = list(zip(floats[: len(self._rate)], floats[len(self._rate) :], strict=True))


TERM = Creep
