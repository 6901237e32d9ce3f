"""Slew: the amplifier limits the rate of the voltage, so fast commands become ramps of constant slope at any level."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import (
    FEWEST_LIMITED,
    Cause,
    Effect,
    Estimate,
    Known,
    Residual,
    Signature,
    limited_rows,
)
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, Scene, ShapeParameter, standard_errors
from hysgen.machine.kernels import rate_limited
from hysgen.model.path.slew import Slew

Floats = NDArray[np.float64]


QUANTILES = (0.3, 0.5, 0.65, 0.77, 0.85, 0.9, 0.935, 0.96, 0.975, 0.985, 0.992, 0.997, 0.999)
"""Quantiles of the command's rates that are the starting values of the limit; two or three edges are 0.2 % of a log."""


@dataclass(frozen=True)
class SlewPart(Part):
    """v(k) = v(k-1) + clamp(u(k) - v(k-1), -rate Ts, rate Ts)."""

    cause: ClassVar[str] = "slew"
    order: ClassVar[int] = 20
    amplifies: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter(
            "rate_V_per_s",
            "V/s",
            lambda e: (0.1 * e.half_V / e.span_s, 4 * e.half_V / e.Ts_s),
            logarithm=True,
            step=lambda e: 1e-3,
        ),
    )
    rate_V_per_s: float

    def amplify(self, u_V: Floats, Ts_s: float) -> Floats:
        return rate_limited(u_V, self.rate_V_per_s * Ts_s)

    def amplify_held(self, u_V: Floats, held: NDArray[np.int64], Ts_s: float) -> Floats:
        v_V = u_V.copy()
        for k in range(1, len(u_V)):
            most_V = self.rate_V_per_s * Ts_s * float(held[k - 1])
            v_V[k] = v_V[k - 1] + min(max(u_V[k] - v_V[k - 1], -most_V), most_V)
        return v_V

    def averaged(self, columns: Floats, v_V: Floats, Ts_s: float) -> Floats:
        """A limited amplifier moves for the share |dv| / (rate Ts) of a period; the mean lags by half of this share."""
        moving = np.minimum(np.abs(np.diff(v_V)) / (self.rate_V_per_s * Ts_s), 1.0)
        columns[:, 1:] -= 0.5 * moving * np.diff(columns, axis=1)
        return columns


class SlewCause(Cause):
    name = "slew"
    rank = 20
    experiment = Piece.STEPS
    part = SlewPart

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        return not self.present(fit.chain) or limited_rows(scene, fit.chain, SlewPart) >= FEWEST_LIMITED

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        if self.present(chain):
            return []
        rates = np.concatenate([np.abs(np.diff(run.u_V)) / run.stride for run in scene.runs]) / scene.Ts_s
        levels = np.unique(np.quantile(rates[rates > 1e-6 * rates.max()], QUANTILES))
        # The fitted lag may contain the effect of the limit, so shorter lags are starting values too.
        return [
            dataclasses.replace(chain.having(SlewPart(float(rate))), lag_s=share * chain.lag_s)
            for rate in levels
            for share in (1.0, 0.25, 0.05)
        ]

    def effect(self, residual: Residual) -> Effect:
        """The highest rate of the command that FEWEST_LIMITED samples exceed."""
        scene = residual.scene
        rates = np.concatenate([np.abs(np.diff(run.u_V)) / run.stride for run in scene.runs])
        return Effect("V/s", limit=True, least=float(np.sort(rates)[-FEWEST_LIMITED]) / scene.Ts_s)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The rate divided by its standard error, and the number of samples at which the limit delays the command."""
        scene, chain = residual.scene, residual.fit.chain
        rate = chain.of(SlewPart).rate_V_per_s
        error = rate * standard_errors(scene, residual.fit).coordinates["slew.rate_V_per_s"]
        held = limited_rows(scene, chain, SlewPart)
        z = rate / max(error, 1e-15)
        return Signature(
            z=z,
            text=f"the output never follows faster than {rate:.4g} V/s +- {error:.1g}, "
            f"at any level ({held} samples held back)",
            parameters={"rate_V_per_s": Estimate(rate, error)},
        )

    def extension(self, residual: Residual) -> Extension:
        chain = residual.fit.chain
        rate = chain.of(SlewPart).rate_V_per_s
        return Extension(block=Slew(rate, rate), lag_s=chain.lag_s)

    def true_extension(self, known: Known) -> Extension:
        rate = known.parameters["slew.rate_V_per_s"]
        return Extension(block=Slew(rate, rate), lag_s=known.lag_s)


CAUSE = SlewCause()
