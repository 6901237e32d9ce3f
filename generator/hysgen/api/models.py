"""From a record to a model: inspect, fit, score, refit, compare."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from hysgen.certify.certificates import Certificates, Dynamics, certify, dynamics
from hysgen.diagnosis.identifiability import Inspection
from hysgen.diagnosis.identifiability import inspect as inspect_record
from hysgen.display import OWN, WRITTEN_IN, Quantities
from hysgen.errors import FitError, RecordWarning, nearest
from hysgen.feedback import certificate
from hysgen.feedback.certificate import LoopDesign
from hysgen.feedback.stage import LATENCY, Uncertainty
from hysgen.fitting import FitSettings, PathSize, check_for_fit
from hysgen.fitting import fit as fit_model
from hysgen.fitting.refit import Comparison, loop_line
from hysgen.fitting.refit import compare as compare_models
from hysgen.fitting.refit import refit as refit_model
from hysgen.model.file import model_of
from hysgen.model.model import Model
from hysgen.model.rivals import fit_rivals, score_rivals
from hysgen.model.scores import Score, Scores, score_identification, score_prediction
from hysgen.model.scores import score as score_model
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.record.columns import Columns
from hysgen.record.read import record_of
from hysgen.record.runs import columns_of
from hysgen.record.segment import Segment
from hysgen.trajectory.inverse import own_response
from hysgen.trajectory.learning import learn
from hysgen.trajectory.limits import Limits
from hysgen.trajectory.plan import Waveform, plan
from hysgen.trajectory.reference import Form, reference_of, series_of

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Progress = Callable[[float, str], None]
Settings = TypeVar("Settings", bound="DataclassInstance")

PAPERS_MODEL = "paper's model"


def fit(
    record: Record | Any,
    settings: FitSettings | None = None,
    *,
    memory: bool | int | PathSize = False,
    progress: Progress | None = None,
    **changes: Any,
) -> Model:
    """A model of a record: by default the paper's structure with refined free run, otherwise as in `settings`.

    record: a Record, a DataFrame, or the name of a file. memory: whether the path holds a hysteresis: True, the number
    of its plays, or a PathSize. changes: fields of FitSettings, as rules=8. Raises FitError or RecordError.
    """
    record = sound_record(record)
    chosen = with_changes(settings or FitSettings(), changes)
    if memory is not False:
        size = PathSize(plays=memory) if isinstance(memory, int) and memory is not True else memory
        chosen = dataclasses.replace(chosen, memory=PathSize() if size is True else size)
    warn(check_for_fit(record, chosen.rules, parameter_count(chosen, record)), quantities=record.quantities)
    return fit_model(record, chosen, progress=progress)


def sound_record(given: Record | Any, gated: bool = False) -> Record:
    """The record of `record_of` without wrong readings (`Record.without_wrong_readings`), and a warning for each."""
    record = record_of(given)
    sound = record.without_wrong_readings(gated)
    warn(sound.warnings[len(record.said) :], 4)
    return sound


def parameter_count(settings: FitSettings, record: Record) -> int:
    """Parameters that `fit` identifies: three of each rule, and the weights of the hysteresis."""
    rules = 3 * settings.rules
    return rules if settings.memory is None else rules + settings.memory.operator(*record.u_range_V).size


def scored(model: Model, record: Record) -> tuple[Model, Scores]:
    """The model with its scores on the record that it was fitted to, which `refit` compares its own with."""
    scores = score_identification(model, record)
    return dataclasses.replace(model, scores={"identification": scores.to_json()}), scores


def score(model: Model | str | Path, record: Record | Any, settle: int | None = None) -> Scores:
    """Errors of a model on a record: one step, against the horizon, in free run; persistence; noise floor.

    settle: samples at the start that are not scored; by default those that depend on an unknown past. Raises ModelError
    or RecordError.
    """
    stage = model_of(model)
    return score_model(stage, sound_record(record), settle).shown_in(stage.quantities)


def inspect(record: Record | Any) -> Inspection:
    """Ranges, noise and excitation of a record, and from which size on each cause would show. Raises RecordError."""
    sound = sound_record(record)
    return inspect_record(sound).shown_in(sound.quantities)


def refit(model: Model, record: Record | Any, progress: Progress | None = None) -> tuple[Model, Scores]:
    """The same structure fitted to another record, and its scores there. Raises ModelError, RecordError or FitError."""
    old = model_of(model)
    new, scores = refit_model(old, sound_record(record), progress)
    warn([loop_line(old, new)] if old.feedback and not new.feedback else [])
    return new, scores


def diff(old: Model, new: Model, records: Sequence[Record | Any] = ()) -> Comparison:
    """What changed from one model to another of the same structure; free-run errors of both on `records`."""
    first = model_of(old)
    compared = compare_models(first, model_of(new), [sound_record(record) for record in records])
    return compared.shown_in(first.quantities)


def rivals(
    known: Record | Any, unseen: Record | Any, settle: int | Sequence[int] = 0, progress: Progress | None = None
) -> dict[str, Score]:
    """Free-run scores on `unseen` of the paper's model and its rivals (Prandtl-Ishlinskii, proportional, ARX).

    Each is fitted to `known`. settle: samples at the start of each segment that are not scored.
    Raises RecordError or FitError.
    """
    known, unseen = sound_record(known), sound_record(unseen)
    outputs = [run.y_um for run in free_run(fit_model(known, progress=progress), unseen)]
    simple = score_prediction(unseen, outputs, settle)
    return {PAPERS_MODEL: simple, **dict(score_rivals(fit_rivals(known), unseen, settle))}


def certificates(model: Model) -> Certificates:
    """Contraction of the free run, gain and inverse over the whole range of a model."""
    stage = model_of(model)
    return certify(stage).shown_in(stage.quantities)


def describe(model: Model) -> Dynamics:
    """A model as a dynamic system: time constant, gain, loop against frequency."""
    stage = model_of(model)
    return dynamics(stage).shown_in(stage.quantities)


def simulate(
    model: Model | str | Path, voltage: str | os.PathLike[str] | ArrayLike, columns: Columns | str | None = None
) -> Record:
    """Voltage and simulated displacement of a model, without its disturbances, from rest under the first voltage.

    voltage: a file with time_s and voltage_V of any rate, or an array at the model's period. A voltage outside the
    range of the model is limited to it, with a warning. Raises ModelError or RecordError.
    """
    stage = own_response(model_of(model))
    given = series_of(voltage, "voltage", columns_of(columns).of(stage.quantities), stage.Ts_s)
    u_V = given.values
    outside = int(np.count_nonzero((u_V < stage.u_min_V) | (u_V > stage.u_max_V)))
    limited = f"{given.source}: {outside} voltages are outside {stage.u_min_V:g} .. {stage.u_max_V:g} V and limited"
    warn([*given.remarks, *([limited] if outside else [])])
    segment = Segment("0", u_V, stage.simulate(u_V), {}, given.start_s, quantities=stage.quantities)
    return Record.from_segments([segment], stage.Ts_s, given.source)


def waveform(
    model: Model | str | Path,
    reference: str | os.PathLike[str] | ArrayLike,
    form: Form | None = None,
    *,
    columns: Columns | str | None = None,
    voltage_V: Sequence[float] | None = None,
    slew_V_s: float | None = None,
    acceleration_V_s2: float | None = None,
    periodic: bool = False,
    loop: bool = False,
    plays: Sequence[Record | str | Path] = (),
) -> Waveform:
    """The voltage that takes a stage along a reference: exact, or of least largest error inside the limits.

    reference: a file with time_s and displacement_um of any rate, the name of a form ("sine", see `form`), or an array
    at the model's period. periodic: one period of the steady state. loop: begin with the whole range of the voltage.
    plays: records of the repeats so far, oldest first; the waveform is then that of the next repeat.
    Raises ModelError or RecordError.
    """
    model = model_of(model)
    wanted = reference_of(model, reference, form or Form(), columns_of(columns).of(model.quantities))
    low_V, high_V = (model.u_min_V, model.u_max_V) if voltage_V is None else voltage_V
    limits = Limits(low_V, high_V, slew_V_s, acceleration_V_s2)
    if plays:
        repeats = [record_of(play) for play in plays]
        return learn(model, wanted, repeats, limits, loop).shown_in(model.quantities)
    return plan(model, wanted, limits, periodic, loop).shown_in(model.quantities)


def design_loop(model: Model | str | Path, latency: float = LATENCY, **uncertainty: float) -> LoopDesign:
    """Integral and notches around the inverse of a model, of the largest bandwidth that keeps its margins, certified.

    latency: samples between reading and voltage that the record of the model does not hold. uncertainty: fields of
    `Uncertainty`, as frequency=0.02. Raises ModelError where no loop keeps the margins, FitError for an unknown field.
    """
    return certificate.design_loop(model_of(model), with_changes(Uncertainty(), uncertainty), latency)


def with_changes(settings: Settings, changes: Mapping[str, Any]) -> Settings:
    """The settings with these fields. Raises FitError for a field that they do not have."""
    known = [field.name for field in dataclasses.fields(settings)]
    for name in changes:
        if name not in known:
            raise FitError(f"{name}: is not known{nearest(name, known)}; choose from {', '.join(known)}")
    return dataclasses.replace(settings, **changes)


def warn(lines: Iterable[str], callers: int = 3, quantities: Quantities = OWN) -> None:
    """Warn of a record of these quantities; a verb prints these warnings on stderr, in its own."""
    for line in lines:
        text = line if WRITTEN_IN.get().other else quantities.text(line)
        warnings.warn(text, RecordWarning, stacklevel=callers)
