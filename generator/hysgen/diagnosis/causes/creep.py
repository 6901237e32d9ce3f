"""Creep: after a step the output continues in the same direction, by a constant share of the step per decade."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import (
    Chain,
    Extent,
    Fit,
    Part,
    RunSignals,
    Scene,
    ShapeParameter,
    TrainingFit,
    octaves,
    standard_errors,
    whitened_fit,
)
from hysgen.model.path.creep import Creep
from hysgen.record.excitation import Excitation

Floats = NDArray[np.float64]

LEAST_DECADES = 10.0
"""Least ratio of the length of the record to the time from which the creep starts."""

FITTED_PER_DECADE, PER_DECADE = 2, 1
"""Slow states per decade of time of the block that is fitted, and of the one that is delivered: half its cycles."""

LEAST_START = 1e-3
"""Least starting value of the creep per decade: a fit does not leave the bound at 0."""

PAST_DECAYS = (1 / 30, 1 / 8, 1 / 2)
"""Time constants of the decay of creep from before the record, as shares of its length."""


@dataclass(frozen=True)
class CreepPart(Part):
    """After a step the output moves by `per_decade` times the step in every decade of time, from from_s on.

    The block with FITTED_PER_DECADE states, up to 100 times the length of the run. rested: the stage rested before the
    record, so the states start at its first value. Otherwise added columns: the creep that the unknown motion before
    the record causes, as three exponentials and the creep of a step at the start.
    """

    cause: ClassVar[str] = "creep"
    place: ClassVar[int] = 40
    timed: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("per_decade", "1", lambda e: (0.0, 1.0)),
        ShapeParameter("from_s", "s", lambda e: (2 * e.Ts_s, e.span_s / LEAST_DECADES), logarithm=True, closed=True),
    )
    per_decade: float
    from_s: float
    rested: bool = False

    def slow_states(self, span_s: float, states: int = FITTED_PER_DECADE) -> Creep:
        # Creep slower than ten times the length of the record cannot be measured.
        return Creep.logarithmic(self.per_decade, self.from_s, 10.0 * span_s, states)

    @property
    def added(self) -> int:
        return 0 if self.rested else len(PAST_DECAYS) + 1

    @property
    def weight_orders(self) -> float:
        return octaves(self.added) if self.added else 0.0

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        if self.rested:
            return []
        t_s = run.time_s(extent.Ts_s)
        fading = [np.exp(-t_s / (share * extent.span_s)) for share in PAST_DECAYS]
        return [*fading, crept_step(t_s, run.whole * extent.Ts_s, self.from_s)]

    def columns_depend_on(self, lag_s: float, delay: float) -> Hashable:
        return (self.cause, self.from_s, self.rested)


def crept_step(t_s: Floats, span_s: float, from_s: float) -> Floats:
    """(n,) logarithmic creep of a unit step at time 0, at the times t_s, (n,), per unit of `per_decade`.

    span_s: length of the segment.

    sum_i (1 - exp(-t / tau_i)) / 2,    with the tau_i of `CreepPart.slow_states`
    """
    block = CreepPart(1.0, from_s).slow_states(span_s)
    return np.asarray(sum(-block.amount * np.expm1(-t_s / tau_s) for tau_s in block.tau_s))


LONG_REST_S, DECADES = 0.5, 1.5
"""Rest from which creep shows, and the decades of time after a step that it needs."""


class CreepCause(Cause):
    name = "creep"
    rank = 50
    experiment = Piece.RESTS
    slow = True
    part = CreepPart

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Whether the motion before the record that is fitted stayed within the range of the record.

        Slow states that start between the lowest and the highest displacement, low and high, leave in (t, t')

            per_decade (c(t') - c(t)) (high - y(0))   at most, and with low at least,      c: `crept_step`

        and what is beyond by less than the rms error is no motion. Free weights would take a drift beside creep.
        """
        part = fit.chain.get(CreepPart)
        if part is None or part.rested:
            return True
        first, start_um = scene.column_of(fit.chain, CreepPart), scene.y_um - scene.y_um[0]
        times_s = scene.span_s * np.array([0.0, *PAST_DECAYS, 1.0])
        fading = [np.exp(-times_s / (share * scene.span_s)) for share in PAST_DECAYS]
        crept = crept_step(times_s, scene.span_s, part.from_s)
        moved_um = np.diff(fit.weights[first : first + part.added] @ np.vstack([*fading, crept]))
        least_um, most_um = (-part.per_decade * np.diff(crept) * edge for edge in (start_um.max(), start_um.min()))
        return bool(np.all((moved_um > least_um - fit.rms_um) & (moved_um < most_um + fit.rms_um)))

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Creep of a stage that rested before the record."""
        part = chain.of(CreepPart)
        return [] if part.rested else [chain.having(dataclasses.replace(part, rested=True))]

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The best start of each form."""
        return list({start.chain.of(CreepPart).rested: start for start in reversed(candidates)}.values())

    def requirement(self, seen: Excitation) -> tuple[bool, str]:
        decades = math.log10(max(seen.longest_rest_s / (10.0 * seen.record.Ts_s), 1e-9))
        rests = seen.longest_rest_s >= LONG_REST_S and decades >= DECADES
        short = f"; only strong creep shows, hold the voltage for {LONG_REST_S:g} s or more"
        return rests, f"longest rest {seen.longest_rest_s:.3g} s" + ("" if rests else short)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        if self.present(chain):
            return []
        fastest_s = max(5.0 * scene.Ts_s, 3.0 * chain.lag_s)
        slowest_s = 0.05 * scene.span_s
        decades = math.log10(max(slowest_s / fastest_s, 1.0))
        starts = [fastest_s * 10.0 ** (share * decades) for share in (0.0, 0.33, 0.67, 1.0)]
        still = np.concatenate(residual.responses(chain))
        candidates = []
        for start_s in starts:
            unit = chain.having(CreepPart(1.0, start_s))
            creep = residual.amount(np.concatenate(residual.responses(unit)) - still)
            per_decade = float(np.clip(creep, LEAST_START, 1.0))
            candidates += [chain.having(CreepPart(per_decade, start_s, rested)) for rested in (False, True)]
        return candidates

    def effect(self, residual: Residual) -> Effect:
        chain, scene = residual.fit.chain, residual.scene
        from_s = max(5.0 * scene.Ts_s, 3.0 * chain.lag_s)
        return Effect("of a move per decade", residual.changed_by(chain.having(CreepPart(1.0, from_s))), most=1.0)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The creep divided by its standard error.

        The whitened fit weights plateaus most, because the misfit of the hysteresis is constant on a plateau.
        """
        scene, fit = whitened_fit(residual.scene, residual.fit)
        part = fit.chain.of(CreepPart)
        creep, from_s = part.per_decade, part.from_s
        error = standard_errors(scene, fit).coordinates["creep.per_decade"]
        z = creep / max(error, 1e-15)
        return Signature(
            z=z,
            text=f"after a move the output goes on by {100 * creep:.2f} % +- {100 * error:.2f} of it per decade",
            parameters={"per_decade": Estimate(creep, error), "from_s": Estimate(from_s, math.nan)},
        )

    def extension(self, residual: Residual) -> Extension:
        _, fit = whitened_fit(residual.scene, residual.fit)
        part = fit.chain.of(CreepPart)
        return Extension(block=part.slow_states(residual.scene.span_s, PER_DECADE), lag_s=fit.chain.lag_s)

    def forms(self, extension: Extension) -> list[Extension]:
        """The block without its slowest two states, one state, or none.

        After rest a stage creeps on beyond the record; after an unknown movement the slowest states start with a wrong
        value, which costs more than they gain.
        """
        assert isinstance(extension.block, Creep)
        tau_s = extension.block.tau_s
        counts = [count for count in (len(tau_s) - 2, len(tau_s) - 1, len(tau_s)) if count > 0]
        blocks = [dataclasses.replace(extension.block, tau_s=tau_s[:count]) for count in counts]
        return [dataclasses.replace(extension, block=block) for block in blocks]


CAUSE = CreepCause()
