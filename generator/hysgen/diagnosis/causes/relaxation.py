"""Relaxation: domains switch by thermal activation, so the loop depends on the rate and a held input lets h creep."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, Scene, ShapeParameter, standard_errors
from hysgen.fitting.operator import RELAXING
from hysgen.fitting.path import RELAXATIONS

STARTS = (0.015, 0.04)
"""Starting values of the relaxation, a third of the logarithm of its range from either end."""

SIZES = (dataclasses.replace(RELAXING, plays=12), RELAXING)
"""Sizes of a hysteresis that relaxes, in rising cost."""


@dataclass(frozen=True)
class RelaxationPart(Part):
    """Plays that relax by `half_widths` of their half-widths per factor e of time (`model.path.hysteresis`)."""

    cause: ClassVar[str] = "relaxation"
    place: ClassVar[int] = 30
    amplifies: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("half_widths", "1", lambda e: RELAXATIONS, logarithm=True, step=lambda e: 1e-3),
    )
    half_widths: float

    @property
    def relaxation(self) -> float:
        return self.half_widths


class RelaxationCause(Cause):
    name = "relaxation"
    kind = "hysteresis"
    rank = 45
    experiment = Piece.RATES
    mistaken_for = ("creep",)
    part = RelaxationPart
    starts = 2

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """Only plays relax; and a run whose samples are several periods apart would relax too little."""
        return not self.present(fit.chain) or (fit.chain.memory and _every_sample(scene))

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        if self.present(chain) or not chain.memory or not _every_sample(residual.scene):
            return []
        return [chain.having(RelaxationPart(start)) for start in STARTS]

    def effect(self, residual: Residual) -> Effect | None:
        chain = residual.fit.chain
        if not chain.memory or not _every_sample(residual.scene):
            return None
        small = RELAXATIONS[0]
        change = residual.changed_by(chain.having(RelaxationPart(small))) / small
        return Effect("of the half-widths", change, most=RELAXATIONS[1])

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The relaxation divided by its standard error."""
        value = residual.fit.chain.relaxation
        error = value * standard_errors(residual.scene, residual.fit).coordinates["relaxation.half_widths"]
        return Signature(
            z=value / max(error, 1e-15),
            text=f"plays go on by {100 * value:.2g} % +- {100 * error:.1g} % of their half-widths per factor e of time "
            f"while the input rests; the error is {rival.rms_um / residual.fit.rms_um:.2f} times larger without it",
            parameters={"half_widths": Estimate(value, error)},
        )

    def forms(self, extension: Extension) -> list[Extension]:
        """The size of the hysteresis that memory has, or densities fine enough for many hysterons."""
        return [extension, *(dataclasses.replace(extension, size=size) for size in SIZES)]

    def extension(self, residual: Residual) -> Extension:
        chain = residual.fit.chain
        return Extension(relaxation=chain.relaxation, lag_s=chain.lag_s)


def _every_sample(scene: Scene) -> bool:
    """Whether all runs of the scene hold every sample from the start of their segment on."""
    return all(run.stride == 1 and not len(run.history) for run in scene.runs)


CAUSE = RelaxationCause()
