"""A model identified again, next year or on another actuator: same structure, new numbers, and what moved.

What is kept: name, number of rules, terms and input blocks with their shapes, input range, fit and learner settings.
What is new: the displacement range, every linear parameter, scores and certificates. So the C algorithm stays as it is
and only the numbers in `<name>_params.h` change.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hysgen.dynamics import rest_line
from hysgen.errors import ModelError
from hysgen.fit import FitSettings, fit
from hysgen.fit.refine import Progress
from hysgen.model import Model
from hysgen.record import Record
from hysgen.scores import Scores, score

LEVELS = 9
"""Displacements between the ranges' ends at which two models are compared."""


@dataclass(frozen=True)
class Change:
    """One property of two models, in its unit."""

    what: str
    unit: str
    old: float
    new: float

    @property
    def percent(self) -> float | None:
        """Relative change in percent, None where the old value is zero."""
        return 100.0 * (self.new - self.old) / abs(self.old) if self.old else None


@dataclass(frozen=True)
class Comparison:
    """What moved from one model to another: properties as a person thinks of them, rules, and scores on records.

    scores: for each record (source, free-run rms of the old model, of the new one) in um.
    """

    old: str
    new: str
    changes: tuple[Change, ...]
    rules: tuple[tuple[float, float, float], ...]
    scores: tuple[tuple[str, float, float], ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "old": self.old,
            "new": self.new,
            "changes": [dataclasses.asdict(change) | {"percent": change.percent} for change in self.changes],
            "rules_change": [list(rule) for rule in self.rules],
            "free_run_rms_um": [{"record": s, "old": before, "new": after} for s, before, after in self.scores],
        }


def refit(model: Model, record: Record, progress: Progress | None = None) -> tuple[Model, Scores]:
    """The same structure fitted to another record, and its scores there.

    Raises ModelError if the model does not say how it was fitted, RecordError or FitError as `fit` does.
    """
    if abs(record.Ts_s - model.Ts_s) > 1e-4 * model.Ts_s:
        raise ModelError(
            f"{record.source}: sampled every {record.Ts_s:g} s, but {model.name} steps every {model.Ts_s:g} s; "
            "record at the model's rate, or fit a new model"
        )
    again = fit(record, settings_of(model), progress=progress)
    again = dataclasses.replace(again, learner=model.learner)
    scores = score(again, record)
    return dataclasses.replace(again, scores={"identification": scores.to_json()}), scores


def settings_of(model: Model) -> FitSettings:
    """The settings by which `model` was fitted, its structure included. Raises ModelError if it does not tell them."""
    told = model.history.get("fit")
    if not isinstance(told, dict):
        raise ModelError(f"{model.name}: the model file does not say how it was fitted; fit a new model instead")
    known = {field.name for field in dataclasses.fields(FitSettings)}
    structure = {
        "name": model.name,
        "rules": model.grid.rules,
        "terms": model.terms,
        "blocks": model.blocks,
        "input_range_V": (model.u_min_V, model.u_max_V),
    }
    return FitSettings(**({key: value for key, value in told.items() if key in known} | structure))


def compare(old: Model, new: Model, records: Sequence[Record] = ()) -> Comparison:
    """What moved from `old` to `new`, in physical terms; with both scored in free run on every record.

    Raises ModelError if the structures differ: then there is nothing to compare number by number.
    """
    if old.grid.rules != new.grid.rules or [t.kind for t in old.terms] != [t.kind for t in new.terms]:
        raise ModelError(
            f"{old.name} and {new.name}: structures differ ({_structure(old)} against {_structure(new)}); "
            "score both on one record instead"
        )
    changes = [
        Change("displacement, low end", "um", old.grid.y_min_um, new.grid.y_min_um),
        Change("displacement, high end", "um", old.grid.y_max_um, new.grid.y_max_um),
    ]
    changes += [
        Change(what, unit, before, after)
        for (what, unit, before), (_, _, after) in zip(_physics(old), _physics(new), strict=True)
    ]
    if old.weights.size:
        changes.append(Change("sum of the terms' weights", "", float(old.weights.sum()), float(new.weights.sum())))
    moved = new.consequents - old.consequents
    scores = [
        (record.source, score(old, record).free_run.e_rms_um, score(new, record).free_run.e_rms_um)
        for record in records
    ]
    return Comparison(old.name, new.name, tuple(changes), tuple((a, b, c) for a, b, c in moved.tolist()), tuple(scores))


def _physics(model: Model) -> list[tuple[str, str, float]]:
    """DC gain and time constant in the middle of the input range, and the rest position at its ends."""
    low_V, high_V = model.u_min_V, model.u_max_V
    rests = rest_line(model, np.linspace(low_V, high_V, LEVELS))
    middle = rests[LEVELS // 2]
    return [
        ("DC gain, mid-range", "um/V", middle.gain_um_per_V),
        ("time constant, mid-range", "ms", 1e3 * (middle.tau_s or 0.0)),
        ("at rest at the lowest input", "um", rests[0].y_um),
        ("at rest at the highest input", "um", rests[-1].y_um),
    ]


def _structure(model: Model) -> str:
    kinds = ", ".join(term.kind for term in model.terms) or "no terms"
    return f"{model.grid.rules} rules, {kinds}"
