"""Aging: the gain changes during the record; the error is proportional to the displacement and grows with time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import ZERO_UNCERTAIN, Cause, Effect, Estimate, Residual, Signature, comes_back
from hysgen.diagnosis.causes.drift import DriftPart
from hysgen.diagnosis.extension import Correction, Extension
from hysgen.diagnosis.probe import Chain, Fit, Part, Scene, ShapeParameter, TrainingFit, standard_errors, whitened_fit
from hysgen.diagnosis.remedy import POINTS, Advice, Motion, Seen, strokes
from hysgen.model.part import STEP

Floats = NDArray[np.float64]

FORGET = 0.35
"""Time constant of forgetting, as a share of the record: a compromise between tracking and noise."""

MOST_CHANGE = 0.5
"""Least fall of the gain over a record that is no aging, and largest start: a ceramic loses some 5 % per decade of
time, and from the first ms to a year there are ten. A gain that falls by more is a sign of a part that is missing."""

STARTING_CHANGES = (0.003, 0.03)
"""Starting values of the relative change of the gain over the record, used with both signs.

A hysteresis that was fitted without aging has absorbed part of the aging, so a change with the wrong sign can have the
smaller error before the refinement.
"""


@dataclass(frozen=True)
class AgingPart(Part):
    """The gain of the stage is 1 + per_s t about its displacement at 0 V."""

    cause: ClassVar[str] = "aging"
    place: ClassVar[int] = 60
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter(
            "per_s", "1/s", lambda e: (-MOST_CHANGE / e.span_s, 1.0 / e.span_s), step=lambda e: STEP / e.span_s
        ),
    )
    per_s: float

    def gain_change(self, t_s: Floats) -> Floats:
        return self.per_s * t_s


@dataclass(frozen=True)
class GainChange(Correction):
    """A gain 1 + per_s t about the displacement zero_um; in operation, the learner follows the change.

    Behind the identification part, from until_s on, it is what it was last: no law of a gain is known that goes on.
    """

    per_s: float
    zero_um: float = 0.0
    until_s: float = np.inf

    def removed(self, y_um: Floats, t_s: Floats) -> Floats:
        """zero + (y - zero) / (1 + per_s t)"""
        return self.zero_um + (y_um - self.zero_um) / (1.0 + self.per_s * np.minimum(t_s, self.until_s))

    def course(self, t_s: Floats, predicted_um: Floats) -> Floats:
        """t (yhat - zero)"""
        return t_s * (predicted_um - self.zero_um)


class AgingCause(Cause):
    name = "aging"
    rank = 100
    experiment = "record longer, over the whole range"
    slow = True
    part = AgingPart

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """A gain that changes shows where a level is passed again; elsewhere it looks like creep or a curve."""
        return not self.present(fit.chain) or comes_back(scene)

    def proposals(self, residual: Residual) -> list[Chain]:
        chain = residual.fit.chain
        if self.present(chain):
            return []
        scene = residual.scene
        growing = scene.time_s * residual.about_zero_um()
        most = MOST_CHANGE / scene.span_s
        rate = float(np.clip(residual.amount(growing), -most, most))
        rates = (rate, *(sign * share / scene.span_s for sign in (1.0, -1.0) for share in STARTING_CHANGES))
        return [chain.having(AgingPart(rate)) for rate in rates]

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The best start of each sign, because a refinement may not change the sign (STARTING_CHANGES)."""
        return list(
            {candidate.chain.of(AgingPart).per_s > 0.0: candidate for candidate in reversed(candidates)}.values()
        )

    def effect(self, residual: Residual) -> Effect:
        return Effect(
            "of the gain per s", residual.scene.time_s * np.concatenate(residual.responses(residual.fit.chain))
        )

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The change of the gain divided by its standard error, by the whitened fit."""
        scene, fit = whitened_fit(residual.scene, residual.fit)
        rate = fit.chain.of(AgingPart).per_s
        error = standard_errors(scene, fit).coordinates["aging.per_s"]
        z = abs(rate) / max(error, 1e-15)
        return Signature(
            z=z,
            text=f"gain changes by {100 * rate * scene.span_s:+.2f} % +- {100 * error * scene.span_s:.2f} in this time",
            parameters={
                "fraction": Estimate(rate * scene.span_s, error * scene.span_s),
                "per_s": Estimate(rate, error),
            },
        )

    def advice(self, seen: Seen) -> Advice:
        holds_s = seen.noise_um / seen.stroke_um / max(abs(seen.values["per_s"]), 1e-12)
        return Advice(
            f"the same voltage moves the stage by {100.0 * seen.values['fraction']:+.2g} % at the end of the record",
            f"let it warm up or settle after poling; identify again (hysgen refit) every {holds_s:.2g} s to stay "
            "at the noise, let the learner follow, or close a loop around the sensor",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion:
        seconds = 0.2 / max(abs(values["per_s"]), 1e-12)
        return strokes(seconds, seconds / POINTS, 8)

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats]:
        free_um = seen.stroke_um * motion.levels
        return free_um * (1.0 + seen.values["per_s"] * motion.time_s), free_um

    def extension(self, residual: Residual) -> Extension:
        scene = residual.scene
        _, fit = whitened_fit(scene, residual.fit)
        # A ramp too small for a drift of its own means that the gain changes about another point than the fitted zero.
        drift, rate = fit.chain.get(DriftPart), fit.chain.of(AgingPart).per_s
        shift_um = 0.0
        if drift is not None and drift.since_s is None:
            shift_um = float(fit.weights[scene.column_of(fit.chain, DriftPart)]) / scene.span_s / (rate or 1.0)
        hidden = abs(shift_um) < ZERO_UNCERTAIN * float(np.ptp(scene.y_um))
        zero_um = scene.zero_um(fit.chain, fit.weights) - (shift_um if hidden else 0.0)
        change = GainChange(rate, zero_um, float(scene.time_s[-1])) if rate != 0.0 else None
        return Extension(correction=change, forgetting_s=FORGET * scene.span_s)
