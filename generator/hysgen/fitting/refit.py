"""Re-identification: the structure of a model fitted to another record.

Kept: name, number of rules, terms and input blocks with their shapes, input range, fit and learner settings.
New: the displacement range (within the restricted range of the old model, if it was restricted), every linear
parameter, scores and certificates. The generated C algorithm is unchanged; only `<name>_params.h` changes.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.errors import ModelError
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.fitting.refine import Progress
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.scores import Scores, score_identification
from hysgen.record import Record

WORSE, OVER_NOISE = 1.5, 1.4
"""A structure no longer fits if the error exceeds these multiples of the old error and of the noise floor: at 1.4, the
misfit has the power of the noise."""


def refit(
    model: Model, record: Record, progress: Progress | None = None, same_range: bool = False
) -> tuple[Model, Scores]:
    """The same structure fitted to another record, and its scores there.

    same_range: keep the old displacement range, unless the record exceeds it; needed for a parameter image for running
    firmware, whose partition is fixed.
    Raises ModelError if the model file lacks its fit settings, RecordError or FitError as `fit` does.
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
    # The record may exceed the model's input range: the fit uses all of it, and the result is restricted again.
    driven_V = (min(model.u_min_V, record.u_range_V[0]), max(model.u_max_V, record.u_range_V[1]))
    again = fit(record, dataclasses.replace(settings, input_range_V=driven_V), progress=progress)
    for index, term in enumerate(model.terms):
        if term.follows_measurements:
            at = sum(other.size for other in model.terms[:index])
            terms = (*again.terms[:index], term, *again.terms[index:])
            again = dataclasses.replace(again, terms=terms, weights=np.insert(again.weights, at, 1.0))
    again = restricted_as(model, again)
    again = dataclasses.replace(again, learner=model.learner, certificates=certify(again).to_json())
    scores = score_identification(again, record)
    return dataclasses.replace(again, scores={"identification": scores.to_json()}), scores


def restricted_as(old: Model, new: Model) -> Model:
    """`new` restricted to the input range of `old`, and to its displacement range if `old` was restricted.

    A limit of `new` that is narrower already is kept. A restricted model has no scores and no certificates.

    Raises ModelError if the ranges do not overlap.
    """
    low_V, high_V = max(old.u_min_V, new.u_min_V), min(old.u_max_V, new.u_max_V)
    low_um, high_um = new.grid.y_min_um, new.grid.y_max_um
    if old.grid.centres_range_um is not None:
        low_um, high_um = max(old.grid.y_min_um, low_um), min(old.grid.y_max_um, high_um)
    as_it_is = (new.grid.y_min_um, new.grid.y_max_um, new.u_min_V, new.u_max_V)
    if (low_um, high_um, low_V, high_V) == as_it_is:
        return new
    restricted = None if (low_um, high_um) == as_it_is[:2] else (low_um, high_um)
    return new.within(restricted, (low_V, high_V))


def structure_fits(old: Model, scores: Scores) -> tuple[bool, str]:
    """Whether a structure still fits, and one line of reasons.

    scores: of the refitted model on its own record. The structure fits if the free-run error, relative to the span,
    is at most WORSE times that of `old` on its identification record, or at most OVER_NOISE times the noise floor.
    """
    percent, noise_um = scores.free_run.of_span_percent, scores.noise.rms_um
    before = old.scores.get("identification", {}).get("free_run", {}).get("of_span_percent")
    if before is None:
        return (
            True,
            f"free run {percent:.3g} % of the stroke; the old model has no score of its own to compare with",
        )
    figures = f"free run {percent:.3g} % of the stroke, {before:.3g} % before, noise {noise_um:.3g} um"
    if percent <= WORSE * before or scores.free_run.e_rms_um <= OVER_NOISE * noise_um:
        return True, f"still fits ({figures})"
    return False, f"NO LONGER FITS ({figures})"


def settings_of(model: Model) -> FitSettings:
    """The settings that `model` was fitted with, including its structure. Raises ModelError if the file lacks them."""
    stored = model.history.get("fit")
    if not isinstance(stored, dict):
        raise ModelError(f"{model.name}: the model file does not say how it was fitted; fit a new model instead")
    known = {field.name for field in dataclasses.fields(FitSettings)}
    structure = {
        "name": model.name,
        "rules": model.grid.rules,
        "terms": tuple(term for term in model.terms if not term.follows_measurements),
        "blocks": tuple(block for block in model.blocks if not isinstance(block, Hysteresis)),
        "memory": None if stored.get("memory") is None else PathSize(**stored["memory"]),
        "input_range_V": (model.u_min_V, model.u_max_V),
    }
    return FitSettings(**({key: value for key, value in stored.items() if key in known} | structure))
