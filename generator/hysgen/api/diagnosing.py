"""From a record to its causes; reports."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from hysgen.api.models import Progress, score, scored, sound_record, warn, with_changes
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import Study, diagnose_and_evaluate
from hysgen.model.model import Model
from hysgen.model.scores import Scores
from hysgen.record import Record, check_for_fit, check_validation
from hysgen.report.words import price_of

if TYPE_CHECKING:
    from hysgen.report.page import Page


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
    return diagnose_and_evaluate(record, holdout, chosen, progress)


def scored_extension(study: Study) -> Model:
    """The extended model with its scores on the identification rows."""
    return scored(study.model, study.record.rows(0, study.cut))[0]


def page(result: Study | tuple[Model, Scores, Record] | tuple[Mapping[str, Model], Record], title: str = "") -> Page:
    """The report of a diagnosis, of a model with its scores on a record, or of several models on one record.

    `page(study).save("report.html")`; `page(({"paper": a, "memory": b}, record))` has all models in each table.
    """
    if isinstance(result, Study):
        from hysgen.report.diagnosis import diagnosis_page

        return diagnosis_page(result)
    if len(result) == 2:
        models, record = result
        scored = {name: score(model, record) for name, model in models.items()}
    else:
        model, scores, record = result
        models, scored = {model.name: model}, {model.name: scores}
    from hysgen.report.model import ScoredModels, model_page

    return model_page(title or f"{', '.join(models)} on {record.source}", ScoredModels(record, models, scored))
