"""Slew: the amplifier limits the rate, so the output follows fast commands along a straight ramp, at any level."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hysgen.diagnosis.causes.base import Cause, Estimate, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Scene, standard_errors
from hysgen.diagnosis.probe.amplifier import amplified
from hysgen.model.path.slew import Slew as SlewBlock

QUANTILES = (0.3, 0.45, 0.6, 0.7, 0.77, 0.83, 0.87, 0.9, 0.925, 0.95, 0.965, 0.98, 0.99)
"""Of the command's rates: where a limit is looked for."""


class Slew(Cause):
    name = "slew"
    needed = 2.0  # a limit is gross wherever it acts; a smaller gain is misfit at the end of the range

    def present(self, chain: Chain) -> bool:
        return chain.rate_V_per_s is not None

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, rate_V_per_s=None)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        if chain.rate_V_per_s is not None:
            return []
        rates = np.concatenate([np.abs(np.diff(run.u_V)) for run in scene.runs]) / scene.Ts_s
        levels = np.unique(np.quantile(rates[rates > 1e-6 * rates.max()], QUANTILES))
        # A slow amplifier was taken for lag, so the lag is tried shorter too.
        return [
            dataclasses.replace(chain, rate_V_per_s=float(rate), lag_s=share * chain.lag_s)
            for rate in levels
            for share in (1.0, 0.25, 0.05)
        ]

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The rate against its standard error, and the share of the command's steps that the limit holds back."""
        scene, chain = residual.scene, residual.fit.chain
        rate = chain.rate_V_per_s or math.inf
        error = rate * standard_errors(scene, residual.fit).coordinates["rate"]
        free = dataclasses.replace(chain, rate_V_per_s=None)
        behind = np.concatenate(
            [np.abs(amplified(run.u_V, chain, scene.Ts_s) - amplified(run.u_V, free, scene.Ts_s)) for run in scene.runs]
        )
        held = int(np.count_nonzero(behind[scene.rows] > 1e-3 * (scene.operator.high_V - scene.operator.low_V)))
        z = rate / max(error, 1e-15)
        return Signature(
            holds=z > 10.0 and held >= 10,
            z=z,
            text=f"the output never follows faster than {rate:.4g} V/s +- {error:.1g}, "
            f"at any level ({held} samples held back)",
            parameters={"rate_V_per_s": Estimate(rate, error)},
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        rate = fit.chain.rate_V_per_s
        assert rate is not None
        return Extension(block=SlewBlock(rate, rate))


CAUSE = Slew()
