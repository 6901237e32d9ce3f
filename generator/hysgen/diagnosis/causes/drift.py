"""Drift: slow movement that does not depend on the input, the same whether the stage rises or falls.

It may go on at one rate, or slow down by the logarithm of time, as what a stage did before the record began fades.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hysgen.diagnosis.causes.base import SLOW_Z, Cause, Estimate, Residual, Signature
from hysgen.diagnosis.extension import Extension, Trend
from hysgen.diagnosis.probe import Chain, Fit, Scene, standard_errors, whitened_fit
from hysgen.diagnosis.probe.scene import drift_course

ZERO_UNCERTAIN = 0.25
"""Share of the span by which the stage's zero is uncertain: an aging gain turns that into a ramp of its own."""

NEEDED_SLOWING = 3.0
"""By how much the error must grow without a drift that slows down: a little of that course is in whatever the memory's
unknown start, creep, or a limit that is not quite found leaves."""

SINCE = (0.01, 0.05, 0.25)
"""Shares of the record at which a drift that slows down is tried to have begun before it."""


class Drift(Cause):
    name = "drift"

    def present(self, chain: Chain) -> bool:
        return chain.drift

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, drift=False, since_s=None)

    def needed_in(self, chain: Chain) -> float:
        """A drift that slows down can stand for the memory's unknown start too, so more is asked of it."""
        return self.needed if chain.since_s is None else NEEDED_SLOWING

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """A ramp in place of a drift that slows down."""
        return [] if chain.since_s is None else [dataclasses.replace(chain, since_s=None)]

    def proposals(self, residual: Residual) -> list[Chain]:
        """A ramp, and drifts that slow down."""
        chain = residual.fit.chain
        slowing = [dataclasses.replace(chain, drift=True, since_s=share * residual.scene.span_s) for share in SINCE]
        if chain.drift:
            return [] if chain.since_s is not None else slowing
        return [dataclasses.replace(chain, drift=True), *slowing]

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """The drift against its standard error, and the same drift seen on rising and on falling input.

        A ramp is measured as creep is. The misfit would leave nothing certain of a drift that slows down: blocks that
        were not fitted decide on it, see `needed_in`.
        """
        slowing = residual.fit.chain.since_s is not None
        scene, fit = (residual.scene, residual.fit) if slowing else whitened_fit(residual.scene, residual.fit)
        chain, drift = fit.chain, _drift(scene, fit)
        course = float(drift_course(scene.span_s, chain.since_s))
        error = float(standard_errors(scene, fit).disturbances[scene.drift_column(chain)]) / course
        z = abs(drift.size_um) / max(error, 1e-15)
        hidden = abs(chain.aging_per_s or 0.0) * ZERO_UNCERTAIN * float(np.ptp(residual.scene.y_um))
        shares = [_seen(residual, sign) for sign in (1.0, -1.0)]
        alike = f"({shares[0]:.2f} of it seen rising, {shares[1]:.2f} falling)"
        size = f"{1e3 * drift.size_um:.3g} nm {{}} +- {1e3 * error:.1g}"
        if chain.since_s is None:
            text = f"{size.format('per second')} whatever the input does {alike}"
            parameters = {"ramp_um_per_s": Estimate(drift.size_um, error)}
        else:
            text = (
                f"{size.format('per decade of time')} whatever the input does {alike}, "
                f"slowing down like the creep of a move {chain.since_s:.2g} s before the record"
            )
            parameters = {
                "um_per_decade": Estimate(drift.size_um, error),
                "since_s": Estimate(chain.since_s, math.nan),
            }
        return Signature(
            holds=z > SLOW_Z
            and abs(drift.size_um) * course > hidden * scene.span_s
            and all(0.5 < share < 1.5 for share in shares),
            z=z,
            text=text,
            parameters=parameters,
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        _, fit = whitened_fit(scene, fit)
        return Extension(drift=_drift(scene, fit))


def _drift(scene: Scene, fit: Fit) -> Trend:
    """The drift that a fit found."""
    at = scene.hysteresis_size(fit.chain) + scene.drift_column(fit.chain)
    since_s = fit.chain.since_s
    return Trend(float(fit.weights[at]) / float(drift_course(scene.span_s, since_s)), since_s)


def _seen(residual: Residual, direction: float) -> float:
    """Share of the drift that stands in the samples where the input moves in one direction."""
    scene, drift = residual.scene, _drift(residual.scene, residual.fit)
    time_s = np.concatenate([scene.Ts_s * np.arange(len(run.u_V)) for run in scene.runs])
    moving = np.concatenate([np.gradient(run.u_V) for run in scene.runs])
    rows = scene.rows[direction * moving[scene.rows] > 0]
    if len(rows) < 10:
        return 1.0
    course = drift.at(time_s[rows])
    course = course - course.mean()
    error = residual.fit.error[rows] + course
    return float(course @ (error - error.mean()) / (course @ course))


CAUSE = Drift()
