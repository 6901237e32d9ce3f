"""Coupling: another measured channel explains part of the residual beside the stage's own input."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Known, Residual, Signature
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Extent, Fit, Part, RunSignals, octaves, standard_errors
from hysgen.model.disturbances.coupling import Coupling

Floats = NDArray[np.float64]

TAPS = 32
"""Past samples of a channel in the form with several taps."""


@dataclass(frozen=True)
class CouplingPart(Part):
    """Auxiliary `channels` behind the lag and the delay; each adds `taps` past samples as columns."""

    cause: ClassVar[str] = "coupling"
    order: ClassVar[int] = 80
    channels: tuple[str, ...]
    taps: int = 1

    @property
    def added(self) -> int:
        return len(self.channels) * self.taps

    @property
    def weight_orders(self) -> float:
        return len(self.channels) * octaves(self.taps)

    def apart(self, runs: Sequence[RunSignals], Ts_s: float) -> bool:
        return True

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        lagged = [seen(run.aux[name]) for name in self.channels]
        at = np.arange(len(run.u_V))
        return [np.interp(at - tap / run.stride, at, one) for one in lagged for tap in range(self.taps)]

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        return (self, lag_s, delay)


class CouplingCause(Cause):
    name = "coupling"
    rank = 70
    experiment = "record the other axes, the temperature or the load as further columns"
    part = CouplingPart

    def without_one_part(self, chain: Chain) -> list[Chain]:
        part = chain.of(CouplingPart)
        names = part.channels
        fewer = [names[:i] + names[i + 1 :] for i in range(len(names))]
        less = [chain.having(CouplingPart(kept, part.taps)) if kept else self.without(chain) for kept in fewer]
        return less if part.taps == 1 else [*less, chain.having(dataclasses.replace(part, taps=1))]

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        part = chain.get(CouplingPart) or CouplingPart(())
        further = [name for name in residual.scene.runs[0].aux if name not in part.channels and _moves(residual, name)]
        chains = [chain.having(CouplingPart((*part.channels, name), part.taps)) for name in further]
        # A channel that acts through the dynamics of the stage needs several taps.
        if part.taps == 1 and (further or part.channels):
            chains.append(chain.having(CouplingPart((*part.channels, *further), TAPS)))
        return chains

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
        part = chain.of(CouplingPart)
        first, added = scene.column_of(chain, CouplingPart), chain.first_column(CouplingPart)
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

    def extension(self, residual: Residual) -> Extension:
        part = residual.fit.chain.of(CouplingPart)
        return Extension(term=coupling_term({name: residual.scene.range_of(name) for name in part.channels}, part.taps))

    def true_extension(self, known: Known) -> Extension:
        ranges = {name: (float(values.min()), float(values.max())) for name, values in known.channels.items()}
        return Extension(term=coupling_term(ranges))


def coupling_term(ranges: Mapping[str, tuple[float, float]], taps: int = 1) -> Coupling:
    """The term for channels with their ranges (low, high) by name."""
    low, high = zip(*ranges.values(), strict=True)
    return Coupling(tuple(ranges), low, high, taps)


def _moves(residual: Residual, name: str) -> bool:
    return all(float(np.ptp(run.aux[name])) > 0.0 for run in residual.scene.runs)


CAUSE = CouplingCause()
