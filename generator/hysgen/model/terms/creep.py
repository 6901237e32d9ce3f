"""Creep: the displacement moves for seconds after the input has stopped.

    ds_j/dt = (u - s_j) / tau_j                                   slow first-order states, tau_j log-spaced
    s_j(k+1) = s_j(k) + a_j (u(k) - s_j(k)),   a_j = 1 - exp(-Ts / tau_j)     exact for an input held over a sample
    phi_j(k) = s_j(k)                                             [V], one weight per lag
    phi(k)   = sum_j s_j(k) / m                                   [V], shared: one weight for all lags

Creep of piezo ceramics is logarithmic in time: log-spaced lags with one shared weight. The shared weight is one
parameter for fit and learner, and avoids the ill-conditioning of m similar lags. Lags with separate weights fit other
kinds of creep. A record starts at rest under u(0).
In float32 a state is a sum of two words (module `twofloat`), because a_j may be smaller than the last bit of s_j.
Source: Croft, Shed and Devasia, J. Dyn. Sys. Meas. Control 123 (2001) 35-43 (creep as a chain of lags).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.machine.kernels import lag_states
from hysgen.machine.reproducible import expm1
from hysgen.model.intervals import Interval
from hysgen.model.structs import Member
from hysgen.model.terms.base import Drive, Floats, Floats32, Mirror, StateSpace, Term, TermBox
from hysgen.model.twofloat import KEPT, accumulate


@dataclass(frozen=True)
class Creep(Term):
    """Lags with time constants `tau_s`, (m,) positive and rising; `shared`: one weight for all of them.

    Raises ValueError if tau_s is not positive and rising.
    """

    kind: ClassVar[str] = "creep"
    two_words: ClassVar[bool] = True
    tau_s: tuple[float, ...]
    shared: bool = False

    def __post_init__(self) -> None:
        tau = np.asarray(self.tau_s, dtype=np.float64)
        if tau.size == 0 or not np.isfinite(tau).all() or tau[0] <= 0 or (np.diff(tau) <= 0).any():
            raise ValueError("tau_s must be positive and rising")

    @classmethod
    def log_spaced(cls, count: int, shortest_s: float, longest_s: float, shared: bool = False) -> Self:
        """`count` time constants, evenly spaced on a logarithmic axis, both ends included."""
        return cls(tuple(float(tau) for tau in np.geomspace(shortest_s, longest_s, count)), shared)

    @property
    def size(self) -> int:
        return 1 if self.shared else self.lags

    @property
    def lags(self) -> int:
        """m: number of slow states."""
        return len(self.tau_s)

    def rates(self, Ts_s: float) -> Floats:
        """(m,) a_j: the part of the distance to u that a state moves in one sample."""
        return np.array([-expm1(-Ts_s / tau) for tau in self.tau_s])

    def describe(self) -> str:
        weights = "one weight for" if self.shared else "a weight for each of"
        return f"creep, {weights} the time constants " + ", ".join(f"{tau:.3g}" for tau in self.tau_s) + " s"

    def regressors(self, drive: Drive) -> Floats:
        """(n, m) creep states in V, or (n, 1) their mean."""
        start = drive.start.get(self.kind, self.start(float(drive.u_V[0])))
        states = lag_states(drive.u_V, self.rates(drive.Ts_s), start)
        return states @ self._mix.T if self.shared else states

    def start(self, u_V: float) -> Floats:
        """(m,) every lag at u_V."""
        return np.full(self.lags, u_V)

    def burn_in(self, drive: Drive) -> int:
        samples = np.log(100.0) * self.tau_s[-1] / drive.Ts_s
        return int(min(drive.u_V.size, np.ceil(samples)))

    def linear(self, Ts_s: float) -> StateSpace:
        rates = self.rates(Ts_s)
        return StateSpace(np.diag(1.0 - rates), rates, self._mix)

    def gains(self, Ts_s: float) -> tuple[float, ...]:
        """1: the impulse response of a lag is positive with the sum 1."""
        return (1.0,) * self.size

    def box(self, v_V: Interval, Ts_s: float) -> TermBox:
        """|high_j|, |low_j| < LIMIT of `twofloat` [V] for each of the m lags, whether they share a weight or not.

        |phi| <= LIMIT [V]; of a shared weight times 1.0001, for the m additions and 1/m are rounded.
        """
        floats = {f"{word}[{j}]": KEPT for word in ("high", "low") for j in range(self.lags)}
        return TermBox(floats, ((1.0001 if self.shared else 1.0) * KEPT.high,) * self.size)

    def shape(self) -> Floats:
        """(m,) natural logarithms of tau_j in s."""
        return np.asarray(np.log(self.tau_s))

    def with_shape(self, shape: Floats) -> Self:
        return type(self)(tuple(float(tau) for tau in np.exp(np.sort(shape))), self.shared)

    def shape_bounds(self, drive: Drive) -> tuple[Floats, Floats]:
        """From 2 samples to 3 lengths of the record: over one record, slower states are equal ramps."""
        low, high = np.log(2.0 * drive.Ts_s), np.log(3.0 * drive.Ts_s * drive.u_V.size)
        return np.full(self.lags, low), np.full(self.lags, high)

    def members(self) -> tuple[Member, ...]:
        return (
            Member("high", "float", "slow states [V]", (self.lags,)),
            Member("low", "float", "rounding error of `high`, carried along [V]", (self.lags,)),
        )

    def mirror(self, u_V: Floats32, Ts_s: float) -> CreepMirror:
        constants = self.constants(Ts_s)
        return CreepMirror(self, constants["rate"], constants["mean"][0] if self.shared else None, u_V)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        rate = self.rates(Ts_s).astype(np.float32)
        return {"rate": rate, "mean": np.array([1 / self.lags], np.float32)} if self.shared else {"rate": rate}

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        """Three lags with one weight for all, or with a weight for each."""
        lags_s = tuple(sorted(rng.uniform(1e-3, 10.0, 3).tolist()))
        return cls(lags_s, shared=True), cls(lags_s)

    @property
    def _mix(self) -> Floats:
        """(size, m) matrix from lags to regressors."""
        return np.full((1, self.lags), 1 / self.lags) if self.shared else np.eye(self.lags)


class CreepMirror(Mirror):
    """Float32 lags over lanes, each a sum of two words."""

    def __init__(self, term: Creep, rate: Floats32, mean: np.float32 | None, u_V: Floats32) -> None:
        self.members = term.members()
        self._rate, self._mean = rate, mean
        self.high: list[Floats32] = [u_V.copy() for _ in rate]
        self.low: list[Floats32] = [np.zeros_like(u_V) for _ in rate]

    def regressors(self) -> list[Floats32]:
        if self._mean is None:
            return list(self.high)
        total = self.high[0]
        for state in self.high[1:]:
            total = total + state
        return [self._mean * total]

    def advance(self, u_V: Floats32) -> None:
        # The difference ignores the low word, which is below the last bit of the high one.
        sums = [
            accumulate(high, low, a * (u_V - high))
            for high, low, a in zip(self.high, self.low, self._rate, strict=True)
        ]
        self.high, self.low = [high for high, _ in sums], [low for _, low in sums]


TERM = Creep
