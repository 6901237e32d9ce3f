"""Drift: a slow movement of the displacement that does not depend on the input (temperature, sensor offset).

    b(k) = b(k-1) + g (y(k) - yhat(k)),   g = 1 - exp(-Ts / tau)          where y(k) is measured; else b(k) = b(k-1)
    phi(k) = b(k) [um], its weight is 1                                    |b| <= limit

yhat(k) is the one-step prediction of y(k), including b(k-1). Thus b is the one-step error of the model, averaged over
the past tau seconds. `predict` and `learn` update b; `simulate` and `inverse` keep it constant. b adds to y(k+1): in
the steady state it moves the displacement by b / (1 - a), with the slope a = df/dy of the rules.

On the host, `regressors` computes b from `Drive.innovation_um`, the one-step errors of the model without drift; without
them b is constant. A free run with them uses past measured samples, averaged over tau: it is a free run for movements
faster than tau and a predictor for slower ones. State this and tau beside its score. The drift has no fitted weight:
fit the other terms first, then add it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from hysgen.machine.kernels.operators import lag_states
from hysgen.machine.reproducible import expm1
from hysgen.model.disturbances.base import Drive, Floats, Floats32, Mirror, Term, TermBox
from hysgen.model.float32_arithmetic import KEPT, accumulate
from hysgen.model.intervals import symmetric
from hysgen.model.structs import Member, Quantity


@dataclass(frozen=True)
class Drift(Term):
    """A bias that follows the one-step error with time constant `tau_s`, never beyond `limit_um`.

    Raises ValueError if one of them is not positive and finite.
    """

    kind: ClassVar[str] = "drift"
    quantities: ClassVar[Mapping[str, Quantity]] = {
        "rate": Quantity("part of the innovation that enters the bias"),
        "limit": Quantity("largest bias", "um"),
    }
    follows_measurements: ClassVar[bool] = True
    two_words: ClassVar[bool] = True
    tau_s: float
    limit_um: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.tau_s) and self.tau_s > 0 and np.isfinite(self.limit_um) and self.limit_um > 0):
            raise ValueError("tau_s and limit_um must be positive")

    def rate(self, Ts_s: float) -> float:
        """g: the part of a one-step error that is added to the bias in one sample."""
        return -expm1(-Ts_s / self.tau_s)

    def describe(self) -> str:
        return f"drift followed over {self.tau_s:.3g} s, bias within {self.limit_um:.3g} um per sample"

    def regressors(self, drive: Drive) -> Floats:
        """(n, 1) the bias in um: from past one-step errors if the drive has them, else constant."""
        start = drive.start.get(self.kind, np.zeros(1))
        if drive.innovation_um is None:
            return np.full((drive.u_V.size, 1), start[0])
        # b(k) is a sum over the errors of samples 1 .. k: there is no prediction of sample 0.
        errors = np.append(drive.innovation_um[1:], 0.0)
        bias = lag_states(errors, np.array([self.rate(drive.Ts_s)]), start)
        return np.clip(bias, -self.limit_um, self.limit_um)

    def burn_in(self, drive: Drive) -> int:
        return int(min(drive.u_V.size, np.ceil(np.log(100.0) * self.tau_s / drive.Ts_s)))

    def box(self, Ts_s: float) -> TermBox:
        """|bias_um| <= limit [um], |bias_low_um| < LIMIT of `float32_arithmetic` [um]; phi is bias_um."""
        limit = float(self.constants(Ts_s)["limit"][0])
        return TermBox({"bias_um": symmetric(limit), "bias_low_um": KEPT}, (limit,))

    def members(self) -> tuple[Member, ...]:
        return (
            Member("bias_um", "float", "slow displacement of the stage", unit="um"),
            Member("bias_low_um", "float", "rounding error of `bias_um`, added to the next step", unit="um"),
        )

    def mirror(self, lanes: int, Ts_s: float) -> BiasMirror:
        constants = self.constants(Ts_s)
        return BiasMirror(self, constants["rate"][0], constants["limit"][0], lanes)

    def constants(self, Ts_s: float) -> Mapping[str, Floats32]:
        return {
            "rate": np.array([self.rate(Ts_s)], dtype=np.float32),
            "limit": np.array([self.limit_um], dtype=np.float32),
        }

    @classmethod
    def examples(cls, rng: np.random.Generator) -> tuple[Self, ...]:
        return (cls(float(rng.uniform(0.1, 5.0)), float(rng.uniform(0.01, 0.2))),)


class BiasMirror(Mirror):
    """The float32 bias over lanes, a sum of two words."""

    def __init__(self, term: Drift, rate: np.float32, limit: np.float32, lanes: int) -> None:
        self.members = term.members()
        self._rate, self._limit = rate, limit
        self.bias_um = self.bias_low_um = np.zeros(lanes, np.float32)

    def correct(self, innovation_um: Floats32) -> None:
        high, self.bias_low_um = accumulate(self.bias_um, self.bias_low_um, self._rate * innovation_um)
        high = np.where(high > self._limit, self._limit, high)
        self.bias_um = np.where(high < -self._limit, -self._limit, high)

    def regressors(self) -> list[Floats32]:
        return [self.bias_um]

    def advance(self) -> None:
        """Only measured samples move the bias."""
