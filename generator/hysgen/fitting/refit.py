"""A model identified again, next year or on another actuator: same structure, new numbers, and what moved.

What is kept: name, number of rules, terms and input blocks with their shapes, input range, fit and learner settings.
What is new: the displacement range (within the part of it to which the model was restricted, if it was), every linear
parameter, scores and certificates. So the C algorithm stays as it is and only the numbers in `<name>_params.h` change.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.certify.dynamics import SAMPLES_PER_PERIOD, loop, rest_line
from hysgen.errors import ModelError
from hysgen.fitting import FitSettings, fit
from hysgen.fitting.refine import Progress
from hysgen.model.model import Model
from hysgen.model.scores import Scores, score
from hysgen.record import Record

DRIFT = "drift"
"""The kind of term that is not fitted: it follows measured samples, with the weight 1."""

SLOW, FAST = 0.01, 0.3
"""Frequencies of the loops that are compared, as parts of the corner frequency of the old model's lag."""

WORSE, OVER_NOISE = 1.5, 2.0
"""A structure no longer fits if the error is this much larger than it was, and stands this much above the noise."""

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

    centres_um: where each rule stood and stands; rules: by how much q1, q2, q3 of each moved.
    scores: for each record (source, free-run rms of the old model, of the new one) in um.
    """

    old: str
    new: str
    changes: tuple[Change, ...]
    centres_um: tuple[tuple[float, float], ...]
    rules: tuple[tuple[float, float, float], ...]
    scores: tuple[tuple[str, float, float], ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "old": self.old,
            "new": self.new,
            "changes": [dataclasses.asdict(change) | {"percent": change.percent} for change in self.changes],
            "centres_um": [list(pair) for pair in self.centres_um],
            "rules_change": [list(rule) for rule in self.rules],
            "free_run_rms_um": [{"record": s, "old": before, "new": after} for s, before, after in self.scores],
        }


def refit(
    model: Model, record: Record, progress: Progress | None = None, same_range: bool = False
) -> tuple[Model, Scores]:
    """The same structure fitted to another record, and its scores there.

    same_range: over the old displacement range, unless the record leaves it: what a parameter image for firmware that
    runs needs, whose partition is fixed.
    Raises ModelError if the model does not say how it was fitted, RecordError or FitError as `fit` does.
    """
    if abs(record.Ts_s - model.Ts_s) > 1e-4 * model.Ts_s:
        raise ModelError(
            f"{record.source}: sampled every {record.Ts_s:g} s, but {model.name} steps every {model.Ts_s:g} s; "
            "record at the model's rate, or fit a new model"
        )
    settings = settings_of(model)
    if same_range:
        old_um = (model.grid.y_min_um, model.grid.y_max_um)
        settings = dataclasses.replace(settings, margin=0.0, displacement_range_um=old_um)
    # A record may drive further than the model is to answer: all of it is fitted, and the answer restricted again.
    driven_V = (min(model.u_min_V, record.u_range_V[0]), max(model.u_max_V, record.u_range_V[1]))
    again = fit(record, dataclasses.replace(settings, input_range_V=driven_V), progress=progress)
    for index, term in enumerate(model.terms):
        if term.kind == DRIFT:
            at = sum(other.size for other in model.terms[:index])
            terms = (*again.terms[:index], term, *again.terms[index:])
            again = dataclasses.replace(again, terms=terms, weights=np.insert(again.weights, at, 1.0))
    again = restricted_as(model, again)
    again = dataclasses.replace(again, learner=model.learner, certificates=certify(again).to_json())
    scores = score(again, record)
    return dataclasses.replace(again, scores={"identification": scores.to_json()}), scores


def restricted_as(old: Model, new: Model) -> Model:
    """`new` over the part of its ranges that `old` answers for: its input range, and its displacement range if that
    had been restricted. Where `new` reaches less far, it stays as it is. Restricted, it loses scores and certificates.

    Raises ModelError if the ranges have nothing in common.
    """
    low_V, high_V = max(old.u_min_V, new.u_min_V), min(old.u_max_V, new.u_max_V)
    low_um, high_um = new.grid.y_min_um, new.grid.y_max_um
    if old.grid.spread_um is not None:
        low_um, high_um = max(old.grid.y_min_um, low_um), min(old.grid.y_max_um, high_um)
    as_it_is = (new.grid.y_min_um, new.grid.y_max_um, new.u_min_V, new.u_max_V)
    if (low_um, high_um, low_V, high_V) == as_it_is:
        return new
    restricted = None if (low_um, high_um) == as_it_is[:2] else (low_um, high_um)
    return new.within(restricted, (low_V, high_V))


def structure_fits(old: Model, scores: Scores) -> tuple[bool, str]:
    """Whether a structure still fits: `scores` are of the refitted model on its own record, `old` tells its own.

    It does if the free run misses the record by no more than WORSE times what the old model missed its own by, as a
    part of the span, or by no more than OVER_NOISE times the noise floor. In words, too.
    """
    percent, noise_um = scores.free_run.of_span_percent, scores.noise.rms_um
    before = old.scores.get("identification", {}).get("free_run", {}).get("of_span_percent")
    if before is None:
        return (
            True,
            f"free run {percent:.3g} % of span; the old model does not tell its own score to compare with",
        )
    told = f"free run {percent:.3g} % of span, {before:.3g} % before, noise {noise_um:.3g} um"
    if percent <= WORSE * before or scores.free_run.e_rms_um <= OVER_NOISE * noise_um:
        return True, f"still fits ({told})"
    return False, f"NO LONGER FITS ({told})"


def settings_of(model: Model) -> FitSettings:
    """The settings by which `model` was fitted, its structure included. Raises ModelError if it does not tell them."""
    told = model.history.get("fit")
    if not isinstance(told, dict):
        raise ModelError(f"{model.name}: the model file does not say how it was fitted; fit a new model instead")
    known = {field.name for field in dataclasses.fields(FitSettings)}
    structure = {
        "name": model.name,
        "rules": model.grid.rules,
        "terms": tuple(term for term in model.terms if term.kind != DRIFT),
        "blocks": model.blocks,
        "input_range_V": (model.u_min_V, model.u_max_V),
    }
    return FitSettings(**({key: value for key, value in told.items() if key in known} | structure))


def compare(old: Model, new: Model, records: Sequence[Record] = ()) -> Comparison:
    """What moved from `old` to `new`, in physical terms; with both scored in free run on every record.

    Raises ModelError if the structures differ: then there is nothing to compare number by number.
    """
    if _shape(old) != _shape(new):
        raise ModelError(
            f"{old.name} and {new.name}: structures differ ({_structure(old)} against {_structure(new)}); "
            "score both on one record instead"
        )
    loops_Hz = _loop_frequencies(old)
    changes = [
        Change("displacement, low end", "um", old.grid.y_min_um, new.grid.y_min_um),
        Change("displacement, high end", "um", old.grid.y_max_um, new.grid.y_max_um),
    ]
    changes += [
        Change(what, unit, before, after)
        for (what, unit, before), (_, _, after) in zip(_physics(old, loops_Hz), _physics(new, loops_Hz), strict=True)
    ]
    moved = new.consequents - old.consequents
    scores = [
        (record.source, score(old, record).free_run.e_rms_um, score(new, record).free_run.e_rms_um)
        for record in records
    ]
    centres = zip(old.grid.centres_um.tolist(), new.grid.centres_um.tolist(), strict=True)
    rules = tuple((a, b, c) for a, b, c in moved.tolist())
    return Comparison(old.name, new.name, tuple(changes), tuple(centres), rules, tuple(scores))


def _physics(model: Model, loops_Hz: Sequence[float]) -> list[tuple[str, str, float]]:
    """DC gain and time constant in the middle of the input range, where it rests at the ends, its loops, its terms."""
    low_V, high_V = model.u_min_V, model.u_max_V
    rests = rest_line(model, np.linspace(low_V, high_V, LEVELS))
    middle, amplitude_V = rests[LEVELS // 2], 0.45 * (high_V - low_V)
    found = [
        ("DC gain, mid-range", "um/V", middle.gain_um_per_V),
        ("time constant, mid-range", "ms", 1e3 * (middle.tau_s or 0.0)),
        ("at rest at the lowest input", "um", rests[0].y_um),
        ("at rest at the highest input", "um", rests[-1].y_um),
    ]
    for f_Hz in loops_Hz:
        closed = loop(model, f_Hz, 0.5 * (low_V + high_V), amplitude_V)
        # The area is the integral of the opening over the input's 2 A.
        found.append((f"loop width at {f_Hz:.3g} Hz, mean", "um", closed.area_umV / (2.0 * amplitude_V)))
        found.append((f"gain at {f_Hz:.3g} Hz", "um/V", closed.span_um / (2.0 * amplitude_V)))
    start = 0
    for term in model.terms:
        weights = model.weights[start : start + term.size]
        start += term.size
        found.append((f"{term.kind}: sum of its {term.size} weights", "", float(weights.sum())))
    return found


def _loop_frequencies(model: Model) -> list[float]:
    """A slow and a fast sine, both slow enough for the sampling rate."""
    rests = rest_line(model, np.array([0.5 * (model.u_min_V + model.u_max_V)]))
    corner_Hz = 1.0 / (2.0 * np.pi * (rests[0].tau_s or 10.0 * model.Ts_s))
    highest_Hz = 1.0 / (SAMPLES_PER_PERIOD * model.Ts_s)
    return [min(part * corner_Hz, part / FAST * highest_Hz) for part in (SLOW, FAST)]


def _shape(model: Model) -> tuple[int, list[tuple[str, int]], list[str]]:
    """What two models must have in common to be compared number by number."""
    terms = [(term.kind, term.size) for term in model.terms]
    return model.grid.rules, terms, [block.kind for block in model.blocks]


def _structure(model: Model) -> str:
    parts = [f"{term.kind} of {term.size}" for term in model.terms] + [block.kind for block in model.blocks]
    kinds = ", ".join(parts) or "no terms"
    return f"{model.grid.rules} rules, {kinds}"
