"""Creep: the output keeps moving in the direction of the last move, by a constant share in every decade of time."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hysgen.diagnosis.causes.base import SLOW_Z, Cause, Estimate, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Scene, standard_errors, whitened_fit
from hysgen.model.terms.creep import Creep as CreepTerm

LEAST_DECADES = 10.0
STATES = 4
"""Slow states of the term, spread over the decades between the start of the creep and the length of the record."""


class Creep(Cause):
    name = "creep"

    def present(self, chain: Chain) -> bool:
        return chain.creep is not None

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, creep=None, creep_from_s=0.0)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        if chain.creep is not None:
            return []
        fastest_s = max(5.0 * scene.Ts_s, 3.0 * chain.lag_s)
        slowest_s = 0.05 * scene.span_s
        decades = math.log10(max(slowest_s / fastest_s, 1.0))
        starts = [fastest_s * 10.0 ** (share * decades) for share in (0.0, 0.33, 0.67, 1.0)]
        still = np.concatenate(residual.responses(chain))
        trials = []
        for start_s in starts:
            unit = dataclasses.replace(chain, creep=1.0, creep_from_s=start_s)
            creep = residual.amount(np.concatenate(residual.responses(unit)) - still)
            trials.append(dataclasses.replace(unit, creep=float(np.clip(creep, -1.0, 1.0))))
        return trials

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The creep against its standard error: onward, not back, and over a decade of time at least.

        Plateaus tell it best: there the hysteresis rests, and what it leaves does not change.
        """
        scene, fit = whitened_fit(residual.scene, residual.fit)
        creep, from_s = fit.chain.creep or 0.0, fit.chain.creep_from_s
        error = standard_errors(scene, fit).coordinates["creep"]
        z = creep / max(error, 1e-15)
        return Signature(
            holds=z > SLOW_Z and from_s < scene.span_s / LEAST_DECADES,
            z=z,
            text=f"after a move the output goes on by {100 * creep:.2f} % +- {100 * error:.2f} of it per decade",
            parameters={"per_decade": Estimate(creep, error), "from_s": Estimate(from_s, math.nan)},
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        _, fit = whitened_fit(scene, fit)
        longest_s = max(scene.span_s, 4.0 * fit.chain.creep_from_s)
        return Extension(term=creep_term(fit.chain.creep_from_s, longest_s))


def creep_term(from_s: float, longest_s: float) -> CreepTerm:
    """The same creep in every decade from from_s to longest_s: one weight for all states.

    With a weight for each, a fit takes the slowest for a drift that the identification part happens to have: weights of
    -0.4 and +2.2 of the gain lower its error by a fifth and double that of the held-out part.
    """
    return CreepTerm.spread(STATES, from_s, longest_s, shared=True)


CAUSE = Creep()
