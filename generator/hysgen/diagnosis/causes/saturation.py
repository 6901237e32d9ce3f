"""Saturation: the output is constant while the command is beyond a level."""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.causes.base import (
    FEWEST_LIMITED,
    Cause,
    Effect,
    Estimate,
    Known,
    Residual,
    Signature,
    limited_rows,
)
from hysgen.diagnosis.extension import Extension
from hysgen.diagnosis.probe import Chain, Extent, Fit, Part, Scene, ShapeParameter, TrainingFit, standard_errors
from hysgen.model.path.saturation import Saturation

Floats = NDArray[np.float64]

LEVELS = (0.3, 0.5, 0.65, 0.75, 0.82, 0.88, 0.93, 0.97)
# Closer than LEVELS, because of local minima with a level too far out and a curve that is flat inside the level.
PAIRED = (0.5, 0.57, 0.64, 0.71, 0.78, 0.85, 0.92)

FURTHER_IN = 2

LEAST_BEYOND = 0.01
"""Least share of the command's range beyond a level; at the end of the range every curve resembles saturation."""


MOST_SLOPE = 0.5
"""Largest slope of the output beyond a level, as a share of that inside: nearer to a limit than to none."""


def _least_V(extent: Extent) -> float:
    """Least distance of a level from the end of the command's range."""
    return 2.0 * LEAST_BEYOND * extent.half_V


def _step_V(extent: Extent) -> float:
    """Step of a forward difference in a level: a smaller one may pass no sample of the command."""
    return 2e-3 * extent.half_V


@dataclass(frozen=True)
class SaturationPart(Part):
    """v = clamp(u, low_V, high_V); None where a side does not clip."""

    cause: ClassVar[str] = "saturation"
    order: ClassVar[int] = 10
    amplifies: ClassVar[bool] = True
    table: ClassVar[tuple[ShapeParameter, ...]] = (
        ShapeParameter("low_V", "V", lambda e: (e.low_V + _least_V(e), e.middle_V), step=_step_V),
        ShapeParameter("high_V", "V", lambda e: (e.middle_V, e.high_V - _least_V(e)), step=_step_V),
    )
    low_V: float | None = None
    high_V: float | None = None

    def amplify(self, u_V: Floats, Ts_s: float) -> Floats:
        return np.clip(u_V, self.low_V, self.high_V)

    def passes_V(self, low_V: float, high_V: float) -> tuple[float, float]:
        return (low_V if self.low_V is None else self.low_V, high_V if self.high_V is None else self.high_V)


class SaturationCause(Cause):
    name = "saturation"
    rank = 10
    experiment = "drive over the whole range of the amplifier"
    mistaken_for = ("slew",)
    part = SaturationPart
    starts = 3  # a refinement rarely moves from the level of one stroke to that of another

    def proposals(self, residual: Residual) -> list[Chain]:
        chain, operator = residual.fit.chain, residual.scene.operator
        middle, half = 0.5 * (operator.low_V + operator.high_V), 0.5 * (operator.high_V - operator.low_V)
        part, candidates = _part(chain), []
        if part.high_V is None:
            candidates += [chain.having(dataclasses.replace(part, high_V=middle + level * half)) for level in LEVELS]
        if part.low_V is None:
            candidates += [chain.having(dataclasses.replace(part, low_V=middle - level * half)) for level in LEVELS]
        if part.low_V is None and part.high_V is None:
            # If both ends clip, one limit alone may lower the error too little for a step of forward selection.
            for low, high in itertools.product(PAIRED, PAIRED):
                candidates.append(chain.having(SaturationPart(middle - low * half, middle + high * half)))
        return candidates

    def select_starts(self, candidates: list[TrainingFit]) -> list[TrainingFit]:
        """The best starts, and the next levels further in, because a refinement moves a level outward more easily."""
        if not candidates:
            return []
        best = _part(candidates[0].chain)
        inside = [start for start in candidates if 0.0 < _further_in(_part(start.chain), best) < math.inf]
        inside.sort(key=lambda start: _further_in(_part(start.chain), best))
        return candidates[: self.starts] + [
            candidate for candidate in inside[:FURTHER_IN] if candidate not in candidates[: self.starts]
        ]

    def admissible(self, scene: Scene, fit: Fit) -> bool:
        part = fit.chain.get(SaturationPart)
        if part is None:
            return True
        levels = [(level_V, sign) for level_V, sign in ((part.low_V, -1.0), (part.high_V, 1.0)) if level_V is not None]
        flat = all(abs(_slope_beyond(Residual(scene, fit), *level)) < MOST_SLOPE for level in levels)
        return flat and limited_rows(scene, fit.chain, SaturationPart) >= FEWEST_LIMITED

    def simpler_forms(self, chain: Chain) -> list[Chain]:
        """Chains in which only one of the two ends clips."""
        part = _part(chain)
        if part.low_V is None or part.high_V is None:
            return []
        return [chain.having(SaturationPart(high_V=part.high_V)), chain.having(SaturationPart(low_V=part.low_V))]

    def effect(self, residual: Residual) -> Effect:
        """The highest level that FEWEST_LIMITED samples exceed."""
        command_V = np.sort(np.concatenate([run.u_V for run in residual.scene.runs])[residual.scene.rows])
        return Effect("V and lower levels", least=float(command_V[-FEWEST_LIMITED]))

    def signature(self, residual: Residual, rival: Fit) -> Signature:
        """Slope of the output over the command beyond the level, as a share of the mean slope of the record."""
        part = _part(residual.fit.chain)
        errors = standard_errors(residual.scene, residual.fit).coordinates
        parameters, texts, shares = {}, [], []
        for name, level_V, sign in (("low_V", part.low_V, -1.0), ("high_V", part.high_V, 1.0)):
            if level_V is None:
                continue
            parameters[name] = Estimate(level_V, errors[f"saturation.{name}"])
            shares.append(_slope_beyond(residual, level_V, sign))
            texts.append(f"beyond {level_V:.4g} V the slope is {shares[-1]:.2f} of that inside")
        return Signature(
            z=float(min((1.0 - abs(share)) / 0.1 for share in shares)),
            text="; ".join(texts),
            parameters=parameters,
        )

    def extension(self, residual: Residual) -> Extension:
        scene, chain = residual.scene, residual.fit.chain
        part = _part(chain)
        span_V = scene.operator.high_V - scene.operator.low_V
        # A side that does not clip gets a level outside the range of the record.
        return Extension(
            block=Saturation(
                scene.operator.low_V - span_V if part.low_V is None else part.low_V,
                scene.operator.high_V + span_V if part.high_V is None else part.high_V,
            ),
            lag_s=chain.lag_s,
        )

    def true_extension(self, known: Known) -> Extension:
        return Extension(
            block=Saturation(known.parameters["saturation.low_V"], known.parameters["saturation.high_V"]),
            lag_s=known.lag_s,
        )


def _part(chain: Chain) -> SaturationPart:
    """The saturation part of the chain; a part that does not clip if the chain has none."""
    return chain.get(SaturationPart) or SaturationPart()


def _further_in(part: SaturationPart, other: SaturationPart) -> float:
    """Sum in V by which the levels are further in than those of `other`; inf if one is further out or missing."""
    total = 0.0
    for level_V, other_V, sign in ((part.low_V, other.low_V, 1.0), (part.high_V, other.high_V, -1.0)):
        if (level_V is None) != (other_V is None):
            return math.inf
        if level_V is not None and other_V is not None:
            inward_V = sign * (level_V - other_V)
            total += inward_V if inward_V >= 0.0 else math.inf
    return total


def _slope_beyond(residual: Residual, level_V: float, sign: float) -> float:
    """Slope of the residual over the excess of the command beyond the level, divided by the mean gain of the record.

    0 if the output is constant beyond the level, 1 if the slope does not change at the level.
    """
    scene = residual.scene
    u_V = np.concatenate([run.u_V for run in scene.runs])
    y_um = scene.y_um
    beyond_V = np.clip(sign * (u_V - level_V), 0.0, None)
    # Lag and delay: a row counts if the command was beyond the level `late` samples before.
    late = max(1, round(residual.fit.chain.delay + 1 + residual.fit.chain.lag_s / scene.Ts_s))
    rows = scene.rows[(scene.rows >= late) & (beyond_V[scene.rows - late] > 0)]
    if len(rows) < 5:
        return 1.0
    x, e = beyond_V[rows - late], residual.fit.error[rows]
    gain = np.polyfit(u_V[scene.rows], y_um[scene.rows], 1)[0]
    return float(x @ e / (x @ x) / (sign * gain))


CAUSE = SaturationCause()
