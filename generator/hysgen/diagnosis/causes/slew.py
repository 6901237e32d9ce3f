"""Slew: the amplifier limits the rate of the voltage, so fast commands become ramps of constant slope at any level."""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.diagnosis.causes.base import (
    FEWEST_LIMITED,
    Cause,
    Effect,
    Estimate,
    Residual,
    Signature,
    limited_rows,
)
from hysgen.diagnosis.excitation import Excitation
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.probe import Chain, Fit, Scene, standard_errors
from hysgen.model.path.slew import Slew

QUANTILES = (0.3, 0.5, 0.65, 0.77, 0.85, 0.9, 0.935, 0.96, 0.975, 0.985, 0.992, 0.997, 0.999)
"""Quantiles of the command's rates that are the starting values of the limit; two or three edges are 0.2 % of a log."""


class SlewCause(Cause):
    name = "slew"
    rank = 20
    experiment = Piece.STEPS
    part = Slew

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        return not self.present(fit.chain) or limited_rows(scene, fit.chain, Slew) >= FEWEST_LIMITED

    def requirement(self, seen: Excitation) -> tuple[bool, str]:
        return seen.fastest_V_per_s > 0.0, f"limits below {seen.fastest_V_per_s:.4g} V/s"

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        if self.present(chain):
            return []
        rates = np.concatenate([np.abs(np.diff(run.u_V)) / run.stride for run in scene.runs]) / scene.Ts_s
        levels = np.unique(np.quantile(rates[rates > 1e-6 * rates.max()], QUANTILES))
        # The fitted lag may contain the effect of the limit, so shorter lags are starting values too.
        return [
            dataclasses.replace(chain.having(Slew(rate, rate)), lag_s=share * chain.lag_s)
            for rate in levels.tolist()
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
        rate = chain.of(Slew).rise_V_s
        error = rate * standard_errors(scene, residual.fit).coordinates["slew.rise_V_s"]
        held = limited_rows(scene, chain, Slew)
        z = rate / max(error, 1e-15)
        return Signature(
            z=z,
            text=f"the output never follows faster than {rate:.4g} V/s +- {error:.1g}, "
            f"at any level ({held} samples held back)",
            parameters={"rate_V_per_s": Estimate(rate, error)},
        )


CAUSE = SlewCause()
