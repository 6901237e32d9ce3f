"""Creep: after a step the output continues in the same direction, by a constant share of the step per decade."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import (
    Chain,
    Fit,
    Part,
    Scene,
    ShapeParameter,
    TrainingFit,
    standard_errors,
    whitened_fit,
)
from hysgen.diagnosis.remedy import Advice, Motion, Seen, voltage_step
from hysgen.model.path.creep import Creep

Floats = NDArray[np.float64]

LEAST_DECADES = 10.0
"""Least ratio of the length of the record to the time from which the creep starts."""

FITTED_PER_DECADE, PER_DECADE = 2, 1
"""Slow states per decade of time of the block that is fitted, and of the one that is delivered: half its cycles."""

LEAST_START = 1e-3
"""Least starting value of the creep per decade: a fit does not leave the bound at 0."""

PAST_S = 0.05
"""Starting value of the time since the stage rested at another level, as a share of the record."""


@dataclass(frozen=True)
class CreepPart(Part):
    """After a step the output moves by `per_decade` times the step in every decade of time, from from_s on.

    The block with FITTED_PER_DECADE states, up to 100 times the length of the run. Before the record the stage rested
    at the voltage past_V, and past_s before the first sample it moved to where the record starts; None: it rested
    at first_V until the first sample, or where the record starts. Whatever moved it, it stayed within the range of the
    record: a free past would take a drift beside creep.
    """

    cause: ClassVar[str] = "creep"
    place: ClassVar[int] = 40
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("per_decade", "1", lambda e: (0.0, 1.0)),
        ShapeParameter("from_s", "s", lambda e: (2 * e.Ts_s, e.span_s / LEAST_DECADES), logarithm=True, closed=True),
        ShapeParameter("past_V", "V", lambda e: (e.low_V, e.high_V), closed=True, closed_above=True),
        ShapeParameter(
            "past_s", "s", lambda e: (e.Ts_s, 10.0 * e.span_s), logarithm=True, closed=True, closed_above=True
        ),
    )
    per_decade: float
    from_s: float
    past_V: float | None = None
    past_s: float | None = None
    first_V: float | None = None

    @property
    def rested(self) -> CreepPart:
        """The creep of a stage that rested before the record."""
        return CreepPart(self.per_decade, self.from_s, first_V=self.first_V)

    def slow_states(self, span_s: float, states: int = FITTED_PER_DECADE) -> Creep:
        # Creep slower than ten times the length of the record cannot be measured.
        return Creep.logarithmic(self.per_decade, self.from_s, 10.0 * span_s, states)

    @property
    def past(self) -> tuple[float, float] | None:
        if self.past_V is None or self.past_s is None:
            return None if self.first_V is None else (self.first_V, 0.0)
        return self.past_V, self.past_s


LONG_REST_S, DECADES = 0.5, 1.5
"""Rest from which creep shows, and the decades of time after a step that it needs."""


class CreepCause(Cause):
    name = "creep"
    rank = 50
    experiment = Piece.RESTS
    slow = True
    part = CreepPart

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Creep of a stage that rested before the record."""
        part = chain.of(CreepPart)
        return [] if part.past_V is None else [chain.having(part.rested)]

    def fuller_forms(self, chain: Chain, scene: Scene) -> list[Chain]:
        """Creep of a stage that moved before the record, which drifts."""
        part, past_s = chain.of(CreepPart), PAST_S * scene.span_s
        ends_V = () if part.past_V is not None else (scene.extent.low_V, scene.extent.high_V)
        return [chain.having(dataclasses.replace(part, past_V=past_V, past_s=past_s)) for past_V in ends_V]

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The best start for each level of the past: a fit does not leave the side on which it starts."""
        return list({start.chain.of(CreepPart).past_V: start for start in reversed(candidates)}.values())

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, scene = residual.fit.chain, residual.scene
        if self.present(chain):
            return []
        fastest_s = max(5.0 * scene.Ts_s, 3.0 * chain.lag_s)
        slowest_s = 0.05 * scene.span_s
        decades = math.log10(max(slowest_s / fastest_s, 1.0))
        starts = [fastest_s * 10.0 ** (share * decades) for share in (0.0, 0.33, 0.67, 1.0)]
        still = np.concatenate(residual.responses(chain))
        candidates, first_V = [], scene.first_level_V(chain, residual.fit.weights)
        for start_s in starts:
            unit = chain.having(CreepPart(1.0, start_s))
            creep = residual.amount(np.concatenate(residual.responses(unit)) - still)
            per_decade = float(np.clip(creep, LEAST_START, 1.0))
            candidates.append(chain.having(CreepPart(per_decade, start_s, first_V=first_V)))
            candidates += self.fuller_forms(candidates[-1], scene)
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

    def advice(self, seen: Seen) -> Advice:
        share, from_s = seen.values["per_decade"], seen.values["from_s"]
        um = share * seen.stroke_um
        return Advice(
            f"after a full stroke the stage goes on by {um:.3g} um in each decade of time, from {from_s:.2g} s on",
            f"wait before you measure: from {100.0 * from_s:.2g} to {200.0 * from_s:.2g} s it moves by "
            f"{0.301 * um:.2g} um only; or let a slow integrator on the sensor, or the inverse of this model, hold it",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        return voltage_step(100.0 * values["from_s"], Ts_s)

    def extension(self, residual: Residual) -> Extension:
        _, fit = whitened_fit(residual.scene, residual.fit)
        part = fit.chain.of(CreepPart)
        block = part.slow_states(residual.scene.span_s, PER_DECADE)
        return Extension(block=block, past=part.past, lag_s=fit.chain.lag_s)
