"""Drift: slow movement that does not depend on the input, the same whether the stage rises or falls."""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.diagnose.evidence.base import Cause, Estimate, Look, Signature
from hysgen.diagnose.extension import Extension
from hysgen.diagnose.probe import Chain, Fit, Scene, standard_errors

ZERO_UNCERTAIN = 0.25
"""Share of the span by which the stage's zero is uncertain: an aging gain turns that into a ramp of its own."""


class Drift(Cause):
    name = "drift"

    def present(self, chain: Chain) -> bool:
        return chain.drift

    def without(self, chain: Chain) -> Chain:
        return dataclasses.replace(chain, drift=False)

    def proposals(self, look: Look) -> list[Chain]:
        return [] if look.fit.chain.drift else [dataclasses.replace(look.fit.chain, drift=True)]

    def signature(self, look: Look, rival: Fit) -> Signature:
        """The ramp against its standard error, and the same ramp seen on rising and on falling input."""
        scene, chain = look.scene, look.fit.chain
        at = scene.drift_column(chain)
        slope = float(look.fit.weights[scene.hysteresis_size(chain) + at]) / scene.span_s
        error = float(standard_errors(scene, look.fit).disturbances[at]) / scene.span_s
        z = abs(slope) / max(error, 1e-15)
        hidden = abs(chain.aging_per_s or 0.0) * ZERO_UNCERTAIN * float(np.ptp(scene.y_um))
        shares = [_seen(look, slope, sign) for sign in (1.0, -1.0)]
        return Signature(
            holds=z > 5.0 and abs(slope) > hidden and all(0.5 < share < 1.5 for share in shares),
            z=z,
            text=f"{1e3 * slope:.3g} nm/s +- {1e3 * error:.1g} whatever the input does "
            f"({shares[0]:.2f} of it seen rising, {shares[1]:.2f} falling)",
            parameters={"ramp_um_per_s": Estimate(slope, error)},
        )

    def extension(self, scene: Scene, fit: Fit) -> Extension:
        at = scene.hysteresis_size(fit.chain) + scene.drift_column(fit.chain)
        ramp_um_per_s = float(fit.weights[at]) / scene.span_s
        return Extension(ramp_um_per_s=ramp_um_per_s)


def _seen(look: Look, slope_um_per_s: float, direction: float) -> float:
    """Share of the ramp that stands in the samples where the input moves in one direction."""
    scene = look.scene
    time_s = np.concatenate([scene.Ts_s * np.arange(len(run.u_V)) for run in scene.runs])
    moving = np.concatenate([np.gradient(run.u_V) for run in scene.runs])
    rows = scene.rows[direction * moving[scene.rows] > 0]
    if len(rows) < 10:
        return 1.0
    ramp = slope_um_per_s * (time_s[rows] - time_s[rows].mean())
    error = look.fit.error[rows] + ramp
    return float(ramp @ (error - error.mean()) / (ramp @ ramp))


CAUSE = Drift()
