"""Drift: slow movement that does not depend on the input and is equal on rising and falling input.

Its rate is constant, or it decreases with the logarithm of time, like creep from a move before the record, or changes
at evenly spaced times, as that of a stage does whose surroundings warm up and cool down: how it goes on is not known.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import ZERO_UNCERTAIN, Cause, Effect, Estimate, Residual, Signature
from hysgen.diagnosis.causes.creep import CreepPart
from hysgen.diagnosis.extension import Correction, Extension
from hysgen.diagnosis.probe import (
    Chain,
    Extent,
    Fit,
    Part,
    RunSignals,
    Scene,
    ShapeParameter,
    TrainingFit,
    standard_errors,
    whitened_fit,
)
from hysgen.diagnosis.remedy import Advice, Motion, Seen, held
from hysgen.display import decimal
from hysgen.model.disturbances.drift import Drift
from hysgen.model.model import Model

Floats = NDArray[np.float64]

SOONEST = 0.003
"""Least time before the record, as a share of it, at which a drift that slows down may have begun."""

AT_BOUND = 1.05
"""Ratio of the time of the move to its least value below which the fit has ended at that bound."""

SLOWER = 0.1 * math.log10(math.e)
"""What creep slower than ten times the record moves within it, per decade and unit of a step before it."""

BENDS = 7
"""Changes of the rate within the record: an eighth of it is slow beside any motion that tells memory from dynamics."""

SINCE = (0.01, 0.05, 0.25)
"""Starting values of the time between the start of a drift that slows down and the record, as shares of the record."""


FOLLOWED = 0.02
"""Time constant of the bias state, as a share of the record over which the drift was seen."""

WIDEST_BIAS = 0.05
"""Limit of the bias per sample, as a share of the range of y."""


def trend_course(t_s: Floats | float, since_s: float | None) -> Floats:
    """Course of a drift of unit size at time t: t, or log10(1 + t / since) if it slows down."""
    return np.asarray(t_s, dtype=np.float64) if since_s is None else np.log10(1.0 + np.asarray(t_s) / since_s)


def bent_courses(t_s: Floats, span_s: float, bends: int) -> list[Floats]:
    """Ramps from each of `bends` evenly spaced times within span_s on, to its end: there, one from 0 on would be 1."""
    at_s = span_s * np.arange(1, bends + 1) / (bends + 1)
    return [np.clip(t_s - begin_s, 0.0, span_s - begin_s) / span_s for begin_s in at_s]


@dataclass(frozen=True)
class Trend(Correction):
    """The drift over a segment: size_um times `trend_course`, i.e. um per second, or per decade if it slows down.

    level_s: end of the identified rows; the level of the model is that of the stage from then on. bends_um: sizes of
    the `bent_courses` until then; a drift with any stays at its last level.
    """

    size_um: float
    since_s: float | None = None
    level_s: float = 0.0
    bends_um: tuple[float, ...] = ()

    def at(self, t_s: Floats) -> Floats:
        """(n,) um at times t_s after the start of a segment."""
        if not self.bends_um:
            return self.size_um * trend_course(t_s, self.since_s)
        bent = np.array(self.bends_um) @ bent_courses(t_s, self.level_s, len(self.bends_um))
        return np.asarray(self.size_um * np.minimum(t_s, self.level_s) + bent)

    def course(self, t_s: Floats, predicted_um: Floats) -> Floats:
        """(n,) the course of a drift of unit size; (1 + p, n) those of one that bends, over the time t_s."""
        if not self.bends_um:
            return super().course(t_s, predicted_um)
        return np.array([t_s, *bent_courses(t_s - t_s[0], float(np.ptp(t_s)), len(self.bends_um))])

    @property
    def level_um(self) -> float:
        return float(self.at(np.array(self.level_s)))

    def removed(self, y_um: Floats, t_s: Floats) -> Floats:
        """y - drift(t)"""
        return y_um - self.at(t_s)

    def online_term(self, model: Model, span_s: float) -> Drift:
        """A bias state; it starts at 0 and is constant in a free run, so that no score changes."""
        tau_s = max(span_s * FOLLOWED, 100.0 * model.Ts_s)
        return Drift(tau_s, WIDEST_BIAS * (model.grid.y_max_um - model.grid.y_min_um))


@dataclass(frozen=True)
class DriftPart(Part):
    """A ramp as one added column, 1 at the end of the longest run.

    since_s: None for a constant rate; otherwise the drift slows down like the creep of a move that was made since_s
    before the run, log(1 + t / since_s).
    """

    cause: ClassVar[str] = "drift"
    place: ClassVar[int] = 70
    timed: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("since_s", "s", lambda e: (SOONEST * e.span_s, e.span_s), logarithm=True, closed=True),
    )
    since_s: float | None = None

    @property
    def added(self) -> int:
        return 1

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        return [trend_course(run.time_s(extent.Ts_s), self.since_s) / trend_course(extent.span_s, self.since_s)]


@dataclass(frozen=True)
class BentDriftPart(DriftPart):
    """A ramp and the `bent_courses` as added columns."""

    flexible: ClassVar[bool] = True
    bends: int = 0

    @property
    def added(self) -> int:
        return 1 + self.bends

    def columns(self, run: RunSignals, extent: Extent, seen: Callable[[Floats], Floats]) -> list[Floats]:
        ramp = super().columns(run, extent, seen)
        return [*ramp, *bent_courses(run.time_s(extent.Ts_s), extent.span_s, self.bends)]


class DriftCause(Cause):
    name = "drift"
    rank = 90
    experiment = "record longer"
    slow = True
    mistaken_for = ("aging", "creep")
    part = DriftPart
    starts = 2

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        """More drift than a gain that changes about another zero, or creep that is slower than its states, can leave.

        Of a move over the whole range before the record, the states slower than ten records, which the creep of an
        earlier move lacks, leave a ramp by per_decade log10(e) / 10. A drift that slows down has the course of the
        creep of such a move, so beside creep it has no score; one that bends has that of any slow change.
        """
        chain, part = fit.chain, fit.chain.get(DriftPart)
        if part is None:
            return True
        creep = chain.get(CreepPart)
        if part.since_s is not None:
            return creep is None
        if isinstance(part, BentDriftPart):
            return creep is None and not np.any(chain.gain_change(scene.time_s))
        past = 0.0 if creep is None or creep.past is None else creep.per_decade
        hidden = max(SLOWER * past, ZERO_UNCERTAIN * float(np.max(np.abs(chain.gain_change(scene.time_s)))))
        return abs(_drift(scene, fit).size_um) * scene.span_s > hidden * float(np.ptp(scene.y_um))

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """A ramp in place of a drift that slows down or bends."""
        return [] if chain.of(DriftPart) == DriftPart() else [chain.having(DriftPart())]

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The best with few columns, and the one that bends, which leaves less whatever the course is."""
        few = [start for start in candidates if not isinstance(start.chain.of(DriftPart), BentDriftPart)]
        return [*few[: self.starts], *(start for start in candidates if start not in few)]

    def proposals(self, residual: Residual) -> list[Chain]:
        """A ramp, and drifts that slow down or bend."""
        chain = residual.fit.chain
        creep = chain.get(CreepPart)
        if creep is not None:
            # Creep of an earlier move takes a part of a ramp: the drift is beside that of a stage that rested, too.
            forms = dict.fromkeys((chain, chain.having(creep.rested)))
            return [] if self.present(chain) else [form.having(DriftPart()) for form in forms]
        uneven = [DriftPart(share * residual.scene.span_s) for share in SINCE] + [BentDriftPart(bends=BENDS)]
        part = chain.get(DriftPart)
        if part is not None:
            return [chain.having(form) for form in uneven] if part == DriftPart() else []
        return [chain.having(form) for form in (DriftPart(), *uneven)]

    def effect(self, residual: Residual) -> Effect:
        return Effect("um/s", residual.scene.time_s)

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The drift divided by its standard error, and the drift on rising and on falling input, which should agree.

        The error of a ramp is by the whitened fit.
        """
        part = residual.fit.chain.of(DriftPart)
        scene, fit = (
            whitened_fit(residual.scene, residual.fit) if part == DriftPart() else (residual.scene, residual.fit)
        )
        chain, drift = fit.chain, _drift(scene, fit)
        course, first = float(trend_course(scene.span_s, drift.since_s)), chain.first_column(DriftPart)
        errors = standard_errors(scene, fit).added[first : first + part.added]
        error = float(errors[0]) / course
        z = float(np.max(np.abs([drift.size_um * course, *drift.bends_um]) / np.maximum(errors, 1e-15)))
        shares = [_seen(residual, sign) for sign in (1.0, -1.0)]
        alike = f"whatever the input does ({shares[0]:.2f} of it seen rising, {shares[1]:.2f} falling)"
        size = f"{decimal(drift.size_um, 3)} um per {{}} +- {decimal(error, 1)} {alike}"
        if drift.bends_um:
            at_s = np.linspace(0.0, scene.span_s, len(errors) + 1)
            rates = np.diff(drift.at(at_s)) / np.diff(at_s)
            moved_um = float(np.ptp(drift.at(at_s)))
            low, high = decimal(float(rates.min()), 2), decimal(float(rates.max()), 2)
            text = f"{decimal(moved_um, 3)} um in all {alike}, at {low} to {high} um/s: no line describes it"
            parameters = {"moved_um": Estimate(moved_um, math.nan)}
        elif drift.since_s is None:
            text = size.format("second")
            parameters = {"ramp_um_per_s": Estimate(drift.size_um, error)}
        else:
            text = (
                f"{size.format('decade of time')}, "
                f"slowing down like the creep of a move {drift.since_s:.2g} s before the record"
            )
            if drift.since_s < AT_BOUND * SOONEST * scene.span_s:
                text += "; earlier moves fit as well, so that the rows do not say how it goes on"
            parameters = {
                "um_per_decade": Estimate(drift.size_um, error),
                "since_s": Estimate(drift.since_s, math.nan),
            }
        return Signature(
            z=z,
            text=text,
            parameters=parameters,
        )

    def advice(self, seen: Seen) -> Advice:
        slow = "warm up, shield from draughts, mount sensor and stage on one material"
        if (per_s := seen.values.get("ramp_um_per_s")) is None:
            return Advice(
                "the stage wanders by itself, at a rate that changes", f"{slow}; refer to a fixed point often"
            )
        return Advice(
            f"the stage moves by {decimal(60.0 * per_s, 2)} um in a minute whatever the voltage does",
            f"{slow}; refer to a fixed point every {seen.noise_um / max(abs(per_s), 1e-12):.2g} s to stay at the noise",
        )

    def motion(self, values: Mapping[str, float], Ts_s: float) -> Motion | None:
        return held(60.0) if "ramp_um_per_s" in values else None

    def motions_um(self, motion: Motion, seen: Seen) -> tuple[Floats, Floats]:
        ramp_um = seen.values["ramp_um_per_s"] * motion.time_s
        return ramp_um, np.zeros_like(ramp_um)

    def extension(self, residual: Residual) -> Extension:
        """The drift of the whitened fit; that of the fit itself if it bends: whitening weighs rates, not levels."""
        scene, fit = residual.scene, residual.fit
        if not isinstance(fit.chain.of(DriftPart), BentDriftPart):
            _, fit = whitened_fit(scene, fit)
        return Extension(correction=_drift(scene, fit))


def _drift(scene: Scene, fit: Fit) -> Trend:
    """The drift of a fit."""
    first, part = scene.column_of(fit.chain, DriftPart), fit.chain.of(DriftPart)
    size_um, *bends_um = fit.weights[first : first + part.added].tolist()
    size_um /= float(trend_course(scene.span_s, part.since_s))
    return Trend(size_um, part.since_s, scene.span_s, tuple(bends_um))


def _seen(residual: Residual, direction: float) -> float:
    """Ratio of the drift in the samples whose input moves in `direction` to the drift of the whole fit."""
    scene, drift = residual.scene, _drift(residual.scene, residual.fit)
    moving = np.concatenate([np.gradient(run.u_V) for run in scene.runs])
    rows = scene.rows[direction * moving[scene.rows] > 0]
    if len(rows) < 10:
        return 1.0
    course = drift.at(scene.time_s[rows])
    course = course - course.mean()
    error = residual.fit.error[rows] + course
    return float(course @ (error - error.mean()) / (course @ course))
