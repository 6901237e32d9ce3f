"""Delay: the output is late by whole or fractional samples; its phase grows with frequency, its amplitude does not."""

from __future__ import annotations

import dataclasses

from hysgen.diagnosis.causes.base import Cause, Estimate, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Scene, standard_errors
from hysgen.model.path.delay import Delay as DelayBlock


class Delay(Cause):
    name = "delay"

    def present(self, chain: Chain) -> bool:
        return chain.delayed

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, delayed=False, delay=0.0)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, Ts_s = residual.fit.chain, residual.scene.Ts_s
        if chain.delayed:
            return []
        # What was taken for lag is shared out between lag and delay in several ways.
        trials = []
        for share in (0.1, 0.4, 0.8):
            late = share * chain.lag_s / Ts_s
            if 0.05 < late < 200.0:
                trials.append(dataclasses.replace(chain, delayed=True, delay=late, lag_s=(1.0 - share) * chain.lag_s))
        trials.append(dataclasses.replace(chain, delayed=True, delay=0.5))
        return trials

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The delay itself against its standard error, with lag, modes and hysteresis free to take its place."""
        late = residual.fit.chain.delay
        error = standard_errors(residual.scene, residual.fit).coordinates["delay"]
        z = late / max(error, 1e-12)
        return Signature(
            holds=z > 5.0 and late > 0.05,
            z=z,
            text=f"phase grows with frequency at constant gain: {late:.2f} +- {error:.2f} samples late",
            parameters={"delay_samples": Estimate(late, error)},
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        return Extension(block=DelayBlock(max(fit.chain.delay, 0.0)))


CAUSE = Delay()
