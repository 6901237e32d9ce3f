"""Aging: the gain changes during the record, so the error is proportional to the displacement and grows with time."""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.diagnosis.causes.base import SLOW_Z, Cause, Estimate, Residual, Signature
from hysgen.diagnosis.causes.drift import ZERO_UNCERTAIN
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Scene, standard_errors, whitened_fit

FORGET = 0.35
"""Time constant of forgetting, as a share of the record: short enough to follow, long enough to average."""

MOST_CHANGE = 0.5
"""Change of the gain over the record beyond which it is looked for no further: such a stage has no gain to speak of."""

TRIED = (0.003, 0.03)
"""Changes of the gain, of either sign, from which it is looked for.

Hysteresis that was fitted without aging has bent towards it: a change of the wrong sign can explain more at first.
"""


class Aging(Cause):
    name = "aging"

    def present(self, chain: Chain) -> bool:
        return chain.aging_per_s is not None

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, aging_per_s=None)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        if chain.aging_per_s is not None:
            return []
        scene = residual.scene
        zero_um = scene.zero_um(chain, residual.fit.weights) - float(residual.fit.weights[scene.hysteresis_size(chain)])
        growing = [scene.Ts_s * np.arange(len(seen)) * (seen - zero_um) for seen in residual.responses(chain)]
        most = MOST_CHANGE / scene.span_s
        rate = float(np.clip(residual.amount(np.concatenate(growing)), -most, most))
        rates = (rate, *(sign * share / scene.span_s for sign in (1.0, -1.0) for share in TRIED))
        return [dataclasses.replace(chain, aging_per_s=rate) for rate in rates]

    def select_starts(self, trials: list[Fit]) -> list[Fit]:
        """The best of either sign: no way may lead from one to the other, see TRIED."""
        return list({(trial.chain.aging_per_s or 0.0) > 0.0: trial for trial in reversed(trials)}.values())

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The change of gain against its standard error, measured as creep is."""
        scene, fit = whitened_fit(residual.scene, residual.fit)
        rate = fit.chain.aging_per_s or 0.0
        error = standard_errors(scene, fit).coordinates["aging"]
        z = abs(rate) / max(error, 1e-15)
        return Signature(
            holds=z > SLOW_Z,
            z=z,
            text=f"gain changes by {100 * rate * scene.span_s:+.2f} % +- {100 * error * scene.span_s:.2f} in this time",
            parameters={
                "fraction": Estimate(rate * scene.span_s, error * scene.span_s),
                "per_s": Estimate(rate, error),
            },
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        _, fit = whitened_fit(scene, fit)
        # A ramp beside the aging that is no drift of its own says only that the gain turns about another point.
        ramp = (
            scene.drift_column(fit.chain) + scene.hysteresis_size(fit.chain)
            if fit.chain.drift and fit.chain.since_s is None
            else None
        )
        shift_um = 0.0 if ramp is None else float(fit.weights[ramp]) / scene.span_s / (fit.chain.aging_per_s or 1.0)
        hidden = abs(shift_um) < ZERO_UNCERTAIN * float(np.ptp(scene.y_um))
        return Extension(
            gain_per_s=fit.chain.aging_per_s or 0.0,
            zero_um=scene.zero_um(fit.chain, fit.weights) - (shift_um if hidden else 0.0),
            forgetting_s=FORGET * scene.span_s,
        )


CAUSE = Aging()
