"""The report of models on a record: measured and simulated, the scores, certificates, equal bits, cost, provenance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hysgen.c674x.cost import Cost
from hysgen.checking.bits.report import Report
from hysgen.model.model import Model
from hysgen.model.scores import SCORE_HEADER, Score, Scores, score_rows
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.report.page import KeyFigure, Page, Section, Table
from hysgen.report.plots import style
from hysgen.report.plots.picture import Picture
from hysgen.report.plots.traces import horizon, loops, validation
from hysgen.report.sections import cost_section, equivalence_section, model_section, provenance_section

COLOURS = (style.SIMULATED, style.EXTENDED, style.BASELINE)


def model_page(
    title: str,
    models: Mapping[str, Model],
    record: Record,
    scores: Mapping[str, Scores],
    rivals: Sequence[tuple[str, Score]] = (),
    report: Report | None = None,
    price: Cost | None = None,
) -> Page:
    """Models by the name that people shall read, all scored on `record`; the last one is the one that was generated.

    rivals: free-run scores of other kinds of models; report, price: of the C of the last model, if there is any.
    """
    chosen, best = list(models)[-1], list(models.values())[-1]
    figures = [
        KeyFigure(f"free run, {name}", f"{s.free_run.e_rms_um:.3g} µm", f"{s.free_run.of_span_percent:.2g} % of span")
        for name, s in scores.items()
    ]
    figures.append(KeyFigure("noise floor", f"{scores[chosen].noise.rms_um:.2g} µm", "what no model can pass"))
    if price is not None:
        figures.append(KeyFigure("one sample", _cycles(price), f"{100 * price.share:.2g} % of its period"))
    if report is not None:
        told = "equal bits" if report.equal else "NOT EQUAL"
        figures.append(KeyFigure("generated C", told, f"{report.samples} samples per build"))
    rows = [(f"{name}, free run", s.free_run) for name, s in scores.items()]
    rows += [(f"{name}, one step", s.one_step) for name, s in scores.items()]
    rows += [("persistence, one step", scores[chosen].persistence), *((f"{n}, free run", s) for n, s in rivals)]
    return Page(
        title=title,
        lead=[
            f"Free run over {record.samples} samples that no fit has seen: "
            + ", ".join(f"{name} {s.free_run.e_rms_um:.3g} um rms" for name, s in scores.items())
            + f"; the noise is {scores[chosen].noise.rms_um:.2g} um."
        ],
        figures=figures,
        sections=[
            Section("Measured and simulated", pictures=_pictures(models, record, scores)),
            Section(
                "Scores",
                tables=[Table(["model", *SCORE_HEADER[1:]], score_rows(rows))],
                notes=[f"Noise floor {scores[chosen].noise.describe()}.", "One step flatters; the free run counts."],
            ),
            model_section(best),
            equivalence_section(report, "no C was generated"),
            cost_section(price, "no C was generated"),
            provenance_section(best, [("record", record.source), ("record SHA-256", record.digest)]),
        ],
    )


def _pictures(models: Mapping[str, Model], record: Record, scores: Mapping[str, Scores]) -> list[Picture]:
    """Loops of each model, displacement and error in time, error against the horizon."""
    segment = record.segments[0]
    t_s = segment.start_s + record.Ts_s * np.arange(segment.samples, dtype=np.float64)
    runs = {name: free_run(model, record)[0].y_um for name, model in models.items()}
    colours = dict(zip(models, COLOURS, strict=False))
    found: list[Picture] = []
    for name, y_um in runs.items():
        alt = f"Displacement over voltage: {name} misses the loops by {scores[name].free_run.e_rms_um:.3g} µm rms."
        figure = loops(segment.u_V, segment.y_um, {name: y_um}, "", colours)
        found.append(Picture(f"loops-{len(found)}", f"Measured loops, model: {name}", alt, figure))
    told = ", ".join(f"{name} at most {s.free_run.largest_um:.3g} µm" for name, s in scores.items())
    drawn = validation(t_s, segment.y_um, runs, "", colours)
    found.append(Picture("time", "Free run in time", f"Error of the free run: {told}.", drawn))
    curves = {
        name: (np.array(s.horizon.steps, dtype=np.float64), np.array(s.horizon.rms_um)) for name, s in scores.items()
    }
    levels = {"noise floor": next(iter(scores.values())).noise.rms_um}
    told = ", ".join(f"{name} {y[0]:.2g} to {y[-1]:.2g} µm" for name, (_, y) in curves.items())
    alt = f"Error rms from one step to the longest horizon: {told}."
    found.append(
        Picture("horizon", "Error against the horizon", alt, horizon(curves, levels, record.Ts_s, "", colours))
    )
    return found


def _cycles(price: Cost) -> str:
    """Cycles of a sample, marked where they are estimated."""
    return f"{'' if price.per_sample.measured else '~'}{price.per_sample.value} cycles"


def folder_page(model: Model, report: Report, price: Cost) -> Page:
    """The report of a generated folder: equal bits, cost, certificates, provenance."""
    return Page(
        title=f"Generated C of model {model.name}",
        lead=[report.summary().title + "."],
        figures=[
            KeyFigure("bits", "equal" if report.equal else "NOT EQUAL", f"{report.samples} samples per build"),
            KeyFigure("one sample", _cycles(price), f"of {price.budget}"),
        ],
        sections=[
            equivalence_section(report),
            cost_section(price),
            model_section(model),
            provenance_section(model, []),
        ],
    )
