"""Coupling: another measured channel explains part of the error, once the own input is accounted for."""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.diagnose.evidence.base import Cause, Estimate, Look, Signature
from hysgen.diagnose.extension import Extension
from hysgen.diagnose.probe import Chain, Fit, Scene, standard_errors
from hysgen.terms.coupling import Coupling as CouplingTerm


class Coupling(Cause):
    name = "coupling"

    def present(self, chain: Chain) -> bool:
        return bool(chain.coupled)

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, coupled=())

    def lessened(self, chain: Chain) -> list[Chain]:
        parts = chain.coupled
        return [dataclasses.replace(chain, coupled=parts[:i] + parts[i + 1 :]) for i in range(len(parts))]

    def proposals(self, look: Look) -> list[Chain]:
        chain = look.fit.chain
        left = [name for name in look.scene.runs[0].aux if name not in chain.coupled and _moves(look, name)]
        return [dataclasses.replace(chain, coupled=(*chain.coupled, name)) for name in left]

    def signature(self, look: Look, rival: Fit) -> Signature:
        """Each channel's gain against its standard error, the own input's share taken out of the channel."""
        scene, chain = look.scene, look.fit.chain
        first = len(look.fit.weights) - len(chain.coupled)
        gains = look.fit.weights[first:]
        errors = standard_errors(scene, look.fit).disturbances[first - scene.hysteresis_size(chain) :]
        z = np.abs(gains) / np.maximum(errors, 1e-15)
        listed = ", ".join(
            f"{name} {gain:.4g} +- {error:.1g} um per unit"
            for name, gain, error in zip(chain.coupled, gains, errors, strict=True)
        )
        return Signature(
            holds=bool((z > 5.0).all()),
            z=float(z.min()),
            text=f"the error follows {listed}",
            parameters={
                f"{name}_um_per_unit": Estimate(float(gain), float(error))
                for name, gain, error in zip(chain.coupled, gains, errors, strict=True)
            },
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        ends = [
            (
                min(float(run.aux[name].min()) for run in scene.runs),
                max(float(run.aux[name].max()) for run in scene.runs),
            )
            for name in fit.chain.coupled
        ]
        return Extension(
            term=CouplingTerm(fit.chain.coupled, tuple(low for low, _ in ends), tuple(high for _, high in ends))
        )


def _moves(look: Look, name: str) -> bool:
    return all(float(np.ptp(run.aux[name])) > 0.0 for run in look.scene.runs)


CAUSE = Coupling()
