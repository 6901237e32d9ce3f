"""Coupling: another measured channel explains part of the error, once the own input is accounted for."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Estimate, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Scene, standard_errors
from hysgen.model.terms.coupling import Coupling as CouplingTerm

Floats = NDArray[np.float64]

TAPS = 32
"""Samples of a channel's past where one is not enough."""


class Coupling(Cause):
    name = "coupling"

    def present(self, chain: Chain) -> bool:
        return bool(chain.coupled)

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, coupled=(), taps=1)

    def without_one_part(self, chain: Chain) -> list[Chain]:
        parts = chain.coupled
        less = [dataclasses.replace(chain, coupled=parts[:i] + parts[i + 1 :]) for i in range(len(parts))]
        return less if chain.taps == 1 else [*less, dataclasses.replace(chain, taps=1)]

    def supported(self, residual: Residual) -> Chain:
        """One sample of each channel, where none of several has evidence of its own: a slow channel needs no more."""
        chain = residual.fit.chain
        if chain.taps == 1 or self.signature(residual, residual.fit).holds:
            return chain
        return dataclasses.replace(chain, taps=1)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        left = [name for name in residual.scene.runs[0].aux if name not in chain.coupled and _moves(residual, name)]
        alone = [dataclasses.replace(chain, coupled=(*chain.coupled, name)) for name in left]
        # A channel may act through the mechanics of the stage: then one sample of it is not enough.
        if chain.taps == 1 and (left or chain.coupled):
            alone.append(dataclasses.replace(chain, coupled=(*chain.coupled, *left), taps=TAPS))
        return alone

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Each channel's gain against its standard error, the own input's share taken out of the channel.

        The gain over several samples is their sum; it counts as many standard errors as their root mean square does.
        """
        scene, chain = residual.scene, residual.fit.chain
        first = len(residual.fit.weights) - len(chain.coupled) * chain.taps
        weights = residual.fit.weights[first:].reshape(-1, chain.taps)
        errors = standard_errors(scene, residual.fit).disturbances[first - scene.hysteresis_size(chain) :]
        errors = errors.reshape(-1, chain.taps)
        z = np.sqrt(np.mean((weights / np.maximum(errors, 1e-15)) ** 2, axis=1))
        gains, spread = weights.sum(axis=1), np.sqrt((errors**2).sum(axis=1))
        listed = ", ".join(
            f"{name} {gain:.4g} +- {error:.1g} um per unit"
            for name, gain, error in zip(chain.coupled, gains, spread, strict=True)
        )
        return Signature(
            holds=bool((z > 5.0).all()),
            z=float(z.min()),
            text=f"the error follows {listed}" + (f", over {chain.taps} samples" if chain.taps > 1 else ""),
            parameters={
                f"{name}_um_per_unit": Estimate(float(gain), float(error))
                for name, gain, error in zip(chain.coupled, gains, spread, strict=True)
            },
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        return Extension(term=coupling_term({name: scene.range_of(name) for name in fit.chain.coupled}, fit.chain.taps))


def coupling_term(ranges: Mapping[str, tuple[float, float]], taps: int = 1) -> CouplingTerm:
    """The term for some channels, each with its range."""
    low, high = zip(*ranges.values(), strict=True)
    return CouplingTerm(tuple(ranges), low, high, taps)


def _moves(residual: Residual, name: str) -> bool:
    return all(float(np.ptp(run.aux[name])) > 0.0 for run in residual.scene.runs)


CAUSE = Coupling()
