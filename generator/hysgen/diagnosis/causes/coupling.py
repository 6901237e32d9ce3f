"""Coupling: another measured channel explains part of the residual beside the stage's own input."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.excitation import Excitation
from hysgen.diagnosis.probe import Chain, Fit, standard_errors
from hysgen.model.disturbances.coupling import Coupling

Floats = NDArray[np.float64]

TAPS = 32
"""Past samples of a channel in the form with several taps."""


class CouplingCause(Cause):
    name = "coupling"
    rank = 70
    experiment = "record the other axes, the temperature or the load as further columns"
    part = Coupling

    def without_one_part(self, chain: Chain) -> list[Chain]:
        part = chain.of(Coupling)
        ranges = part.ranges
        fewer = [{other: ranges[other] for other in ranges if other != name} for name in ranges]
        less = [chain.having(Coupling.of(own, part.taps)) if own else self.without(chain) for own in fewer]
        return less if part.taps == 1 else [*less, chain.having(dataclasses.replace(part, taps=1))]

    def requirement(self, seen: Excitation) -> tuple[bool, str]:
        channels = seen.record.aux_names
        return bool(channels), ", ".join(channels) if channels else "no further channel in the file"

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        part = chain.get(Coupling)
        names, taps = ((), 1) if part is None else (part.channels, part.taps)
        further = [name for name in scene.runs[0].aux if name not in names and _moves(residual, name)]
        sets = [((*names, name), taps) for name in further]
        # A channel that acts through the dynamics of the stage needs several taps.
        if taps == 1 and (further or names):
            sets.append(((*names, *further), TAPS))
        ranges = [({name: scene.range_of(name) for name in chosen}, count) for chosen, count in sets]
        return [chain.having(Coupling.of(own, count)) for own, count in ranges]

    def effect(self, residual: Residual) -> Effect | None:
        """Of the first further channel, per standard deviation of it."""
        moving = [name for name in residual.scene.runs[0].aux if _moves(residual, name)]
        if not moving:
            return None
        channel = np.concatenate([run.aux[moving[0]] for run in residual.scene.runs])
        column = (channel - channel.mean()) / float(np.std(channel))
        return Effect(f"um for a standard deviation of {moving[0]}", column)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The gain of each channel divided by its standard error, beside all columns of the own input.

        The gain of several taps is the sum of their weights; z is the root mean square of the weights in standard
        errors.
        """
        scene, chain = residual.scene, residual.fit.chain
        part = chain.of(Coupling)
        first, added = scene.column_of(chain, Coupling), chain.first_column(Coupling)
        weights = residual.fit.weights[first : first + part.added].reshape(-1, part.taps)
        errors = standard_errors(scene, residual.fit).added[added : added + part.added].reshape(-1, part.taps)
        z = np.sqrt(np.mean((weights / np.maximum(errors, 1e-15)) ** 2, axis=1))
        gains, gain_errors = weights.sum(axis=1), np.sqrt((errors**2).sum(axis=1))
        listed = ", ".join(
            f"{name} {gain:.4g} +- {error:.1g} um per unit"
            for name, gain, error in zip(part.channels, gains, gain_errors, strict=True)
        )
        return Signature(
            z=float(z.min()),
            text=f"the error follows {listed}" + (f", over {part.taps} samples" if part.taps > 1 else ""),
            parameters={
                f"{name}_um_per_unit": Estimate(float(gain), float(error))
                for name, gain, error in zip(part.channels, gains, gain_errors, strict=True)
            },
        )


def _moves(residual: Residual, name: str) -> bool:
    return all(float(np.ptp(run.aux[name])) > 0.0 for run in residual.scene.runs)


CAUSE = CouplingCause()
