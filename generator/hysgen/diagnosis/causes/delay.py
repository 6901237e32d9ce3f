"""Delay: the output is late by whole or fractional samples; its phase grows with frequency, its amplitude does not."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

from hysgen.diagnosis.causes.base import Cause, Effect, Estimate, Known, Residual, Signature
from hysgen.diagnosis.experiment import Piece
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, ShapeParameter, standard_errors
from hysgen.model.path.delay import Delay

LEAST_SAMPLES, MOST_SAMPLES = 0.05, 200.0
"""Least and largest delay: below the least, the shape of the held input within a sampling period decides."""


@dataclass(frozen=True)
class DelayPart(Part):
    """Delay by `samples`, whole or fractional."""

    cause: ClassVar[str] = "delay"
    order: ClassVar[int] = 0
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("samples", "samples", lambda e: (LEAST_SAMPLES, MOST_SAMPLES), step=lambda e: 1e-3),
    )
    samples: float

    @property
    def late(self) -> float:
        return self.samples


class DelayCause(Cause):
    name = "delay"
    rank = 30
    experiment = Piece.RATES
    mistaken_for = ("resonance",)
    part = DelayPart

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, Ts_s = residual.fit.chain, residual.scene.Ts_s
        if self.present(chain):
            return []
        # The fitted lag contains the delay; the starting values divide the lag between lag and delay in several ratios.
        candidates = []
        for share in (0.1, 0.4, 0.8):
            late = share * chain.lag_s / Ts_s
            if LEAST_SAMPLES < late < MOST_SAMPLES:
                candidates.append(dataclasses.replace(chain.having(DelayPart(late)), lag_s=(1.0 - share) * chain.lag_s))
        candidates.append(chain.having(DelayPart(0.5)))
        return candidates

    def effect(self, residual: Residual) -> Effect:
        late = residual.changed_by(residual.fit.chain.having(DelayPart(1.0)))
        return Effect("samples", late, most=MOST_SAMPLES)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The delay divided by its standard error; lag, modes and hysteresis are fitted jointly with the delay."""
        late = residual.fit.chain.delay
        error = standard_errors(residual.scene, residual.fit).coordinates["delay.samples"]
        z = late / max(error, 1e-12)
        return Signature(
            z=z,
            text=f"phase grows with frequency at constant gain: {late:.2f} +- {error:.2f} samples late",
            parameters={"delay_samples": Estimate(late, error)},
        )

    def extension(self, residual: Residual) -> Extension:
        chain = residual.fit.chain
        return Extension(block=Delay(max(chain.delay, 0.0)), lag_s=chain.lag_s)

    def true_extension(self, known: Known) -> Extension:
        return Extension(block=Delay(known.parameters["delay.delay_samples"]), lag_s=known.lag_s)


CAUSE = DelayCause()
