"""Initial states of the terms of each segment, estimated from the measured displacement.

The state of play operators before sample 0 depends on inputs before the record. It is described by one number per
segment, the last turning point c of the input in V (see `Memory.state_after`). The estimate of c minimises the free-run
error over the segment; a score that uses it therefore has one parameter fitted to the scored segment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from hysgen.machine import kernels
from hysgen.machine.kernels import Rules
from hysgen.model.model import Model
from hysgen.model.regression import Starts, drive_of, structure_of, term_output
from hysgen.model.terms import Term
from hysgen.record import Record, Segment

Floats = NDArray[np.float64]

CANDIDATES = 41
"""Voltages on the coarse grid, over three times the record's range: the error has several local minima in c."""


@runtime_checkable
class TurningPointState(Protocol):
    """A term whose state is a function of the past turning points of the input."""

    def state_after(self, past_V: Sequence[float], u_V: float) -> Floats:
        """State after an input with the turning points past_V that ended at u_V."""
        ...


def estimate_starts(model: Model, record: Record) -> Starts:
    """For each segment the initial states of least free-run error, by kind; empty without `TurningPointState` terms."""
    terms = [term for term in model.terms if isinstance(term, TurningPointState)]
    return [_best(model, record, segment, terms) if terms else {} for segment in record.segments]


def _best(model: Model, record: Record, segment: Segment, terms: Sequence[Term]) -> Mapping[str, Floats]:
    first_V = float(drive_of(segment, record.Ts_s, structure_of(model)).u_V[0])
    rules = Rules(structure_of(model).range_um, model.consequents)

    def states(c_V: float) -> dict[str, Floats]:
        return {term.kind: term.state_after([c_V], first_V) for term in terms if isinstance(term, TurningPointState)}

    def error(c_V: float) -> float:
        drive = drive_of(segment, record.Ts_s, structure_of(model), states(c_V))
        y_um, _ = kernels.free_run(rules, drive.u_V, term_output(model, drive), float(segment.y_um[0]))
        away = y_um - segment.y_um
        return float(away @ away)

    low, high = float(segment.u_V.min()), float(segment.u_V.max())
    voltages = np.linspace(low - (high - low), high + (high - low), CANDIDATES)
    errors = [error(float(c_V)) for c_V in voltages]
    best = int(np.argmin(errors))
    bracket = (voltages[max(best - 1, 0)], voltages[min(best + 1, CANDIDATES - 1)])
    refined = minimize_scalar(error, bounds=bracket, method="bounded", options={"xatol": 1e-3 * (high - low)})
    return states(float(refined.x) if refined.fun < errors[best] else float(voltages[best]))
