"""From a record to its causes; reports."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hysgen.api.models import Progress, score, scored, sound_record, warn, with_changes
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import Study, diagnose_and_evaluate, name_causes
from hysgen.diagnosis.experiment import Limits, in_words, lacking, voltage, with_time_for
from hysgen.diagnosis.identifiability import Ability
from hysgen.display import Quantities
from hysgen.fitting import check_for_fit
from hysgen.model.model import Model
from hysgen.model.scores import NEXT_TO_NOTHING, Scores
from hysgen.record import Record, check_validation
from hysgen.record.csv_text import write_csv
from hysgen.report.words import price_of

if TYPE_CHECKING:
    from hysgen.report.page import Page

Floats = NDArray[np.float64]


def diagnose(
    record: Record | Any,
    holdout: Record | Any | None = None,
    settings: DiagnoseSettings | None = None,
    progress: Progress | None = None,
    **changes: Any,
) -> Study:
    """Errors of the simulation of a record, their causes, and the gain and price of an extended model.

    Structure and parameters come from `record` (from its first 65 % if `holdout` is None); scores are held out.
    changes: fields of DiagnoseSettings, as keep_all=True. Raises RecordError or FitError.
    """
    record = sound_record(record, gated=True)
    holdout = None if holdout is None else sound_record(holdout, gated=True)
    chosen = with_changes(settings or DiagnoseSettings(), changes)
    if chosen.price is None:
        chosen = dataclasses.replace(chosen, price=price_of)
    part = record if holdout is not None else record.split(chosen.identify)[0]
    warn(check_for_fit(part, chosen.fit.rules, 3 * chosen.fit.rules))
    if holdout is not None:
        warn(check_validation(part, holdout))
    return diagnose_and_evaluate(record, holdout, chosen, progress).shown_in(record.quantities)


def scored_extension(study: Study) -> Model:
    """The extended model with its scores on the identification rows, and the doubt of a displacement made of lines."""
    model, scores = scored(study.model, study.record.rows(0, study.cut))
    if not study.lines_prevail:
        return model
    doubt = (
        f"{study.record.source}: lines that do not depend on the voltage are {study.of_lines:.0%} of the displacement; "
        f"without them {NEXT_TO_NOTHING}"
    )
    known = scores.to_json()
    return dataclasses.replace(model, scores={"identification": known | {"warnings": [*known["warnings"], doubt]}})


@dataclass(frozen=True, eq=False)
class NextExperiment:
    """A voltage that shows what a record cannot: u_V, (n,), at Ts_s; words: its pieces.

    now, then: what the record can tell about every cause, and what a record of this voltage would, as predicted by the
    model of the diagnosis with noise as large as its floor.
    """

    u_V: Floats
    Ts_s: float
    words: str
    now: tuple[Ability, ...]
    then: tuple[Ability, ...]
    quantities: Quantities

    def csv(self) -> str:
        """`time_s` and the input, as `voltage_V`, every number as the float64 that it is."""
        time_s = (np.arange(len(self.u_V)) * self.Ts_s).tolist()
        return write_csv({"time_s": time_s, self.quantities.columns[0]: self.u_V.tolist()})

    def to_json(self) -> dict[str, Any]:
        """The pieces in words, the length, and what each record can tell (`Ability.to_json`)."""
        tells = {"now": self.now, "predicted": self.then}
        return {"words": self.words, "rows": len(self.u_V), "period_s": self.Ts_s} | {
            name: [ability.to_json() for ability in abilities] for name, abilities in tells.items()
        }


def next_experiment(study: Study, **stated: float) -> NextExperiment:
    """The voltage to play next: what the record of a diagnosis cannot tell.

    stated: fields of `diagnosis.experiment.Limits`, as high_V=120; the others are those of the record, with as many
    seconds as it takes.
    Raises HysgenError if the record lacks nothing, or the limits leave no room.
    """
    u_V, now = study.record.rows(0, study.cut).u_V, study.diagnosis.abilities
    pieces = lacking(u_V, [ability.lacks for ability in now])
    limits = dataclasses.replace(Limits.of(u_V, study.record.Ts_s), **stated)
    if "seconds" not in stated:
        limits = with_time_for(pieces, limits)
    u_V = voltage(pieces, limits)
    noise_um = study.diagnosis.noise.rms_um * np.random.default_rng(0).standard_normal(len(u_V))
    played = Record.from_arrays(u_V, study.model.simulate(u_V) + noise_um, limits.Ts_s)
    words, then = in_words(pieces, limits), name_causes(played).abilities
    return NextExperiment(u_V, limits.Ts_s, words, now, then, study.record.quantities)


def page(result: Study | tuple[Model, Scores, Record] | tuple[Mapping[str, Model], Record], title: str = "") -> Page:
    """The report of a diagnosis, of a model with its scores on a record, or of several models on one record.

    `page(study).save("report.html")`; `page(({"paper": a, "memory": b}, record))` has all models in each table.
    """
    if isinstance(result, Study):
        from hysgen.report.pages import diagnosis_page

        return dataclasses.replace(diagnosis_page(result), quantities=result.record.quantities)
    if len(result) == 2:
        models, record = result
        scored = {name: score(model, record) for name, model in models.items()}
    else:
        model, scores, record = result
        models, scored = {model.name: model}, {model.name: scores}
    from hysgen.report.pages import model_page

    made = model_page(title or f"{', '.join(models)} on {record.source}", record, models, scored)
    return dataclasses.replace(made, quantities=record.quantities)
