"""Reports of models: scored side by side on a record, or as a folder of generated C."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hysgen.c674x.cost import Cost
from hysgen.checking.bits.report import Report
from hysgen.model.model import Model
from hysgen.model.scores import SCORE_HEADER, Score, Scores, score_rows
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.record.noise import NoiseFloor
from hysgen.report.page import KeyFigure, Page, PageSection, PageTable
from hysgen.report.plots import style
from hysgen.report.plots.style import Picture
from hysgen.report.plots.traces import horizon, loops, validation
from hysgen.report.sections import cost_section, equivalence_section, model_section, provenance_section

COLOURS = (style.SIMULATED, style.EXTENDED, style.BASELINE)


@dataclass(frozen=True, eq=False)
class ScoredModels:
    """Models by their names in the report, and their scores on one record that no fit has used.

    rivals: free-run scores of models of other kinds, by name.
    """

    record: Record
    models: Mapping[str, Model]
    scores: Mapping[str, Scores]
    rivals: Sequence[tuple[str, Score]] = ()

    @property
    def noise(self) -> NoiseFloor:
        """The noise floor of the record."""
        return next(iter(self.scores.values())).noise

    def rows(self) -> list[tuple[str, Score]]:
        """(label, score): every model in free run, every model one step ahead, persistence, the rivals."""
        rows = [(f"{name}, free run", s.free_run) for name, s in self.scores.items()]
        rows += [(f"{name}, one step", s.one_step) for name, s in self.scores.items()]
        rows.append(("persistence, one step", next(iter(self.scores.values())).persistence))
        return rows + [(f"{name}, free run", score) for name, score in self.rivals]


def model_page(title: str, scored: ScoredModels, report: Report | None = None, price: Cost | None = None) -> Page:
    """The report of models on a record. report, price: of the C of the last model, None if no C was generated."""
    best, record = list(scored.models.values())[-1], scored.record
    return Page(
        title=title,
        lead=[
            f"Free run over {record.samples} samples that no fit has seen: "
            + ", ".join(f"{name} {s.free_run.e_rms_um:.3g} um rms" for name, s in scored.scores.items())
            + f"; the noise is {scored.noise.rms_um:.2g} um."
        ],
        figures=_key_figures(scored, report, price),
        sections=[
            PageSection("Measured and simulated", pictures=_pictures(scored)),
            PageSection(
                "Scores",
                tables=[PageTable(["model", *SCORE_HEADER[1:]], score_rows(scored.rows()))],
                notes=[
                    f"Noise floor {scored.noise.describe()}.",
                    "One-step errors are small for every model; the free run decides.",
                ],
            ),
            model_section(best),
            equivalence_section(report, "no C was generated"),
            cost_section(price, "no C was generated"),
            provenance_section(best, [("record", record.source), ("record SHA-256", record.digest)]),
        ],
    )


def _key_figures(scored: ScoredModels, report: Report | None, price: Cost | None) -> list[KeyFigure]:
    """Free-run errors and noise floor; with generated C its cost and the equality of its bits."""
    figures = [
        KeyFigure(
            f"free run, {name}", f"{s.free_run.e_rms_um:.3g} µm", f"{s.free_run.of_span_percent:.2g} % of the stroke"
        )
        for name, s in scored.scores.items()
    ]
    figures.append(KeyFigure("noise floor", f"{scored.noise.rms_um:.2g} µm", "lower bound for any model"))
    if price is not None:
        figures.append(KeyFigure("one sample", _cycles(price), f"{100 * price.share:.2g} % of its period"))
    if report is not None:
        bits = "equal bits" if report.equal else "NOT EQUAL"
        figures.append(KeyFigure("generated C", bits, f"{report.samples} samples per build"))
    return figures


def _pictures(scored: ScoredModels) -> list[Picture]:
    """Loops of each model, displacement and error in time, error against the horizon."""
    record, scores = scored.record, scored.scores
    runs = {name: free_run(model, record)[0].y_um for name, model in scored.models.items()}
    colours = dict(zip(scored.models, itertools.cycle(COLOURS), strict=False))
    pictures: list[Picture] = []
    for name, y_um in runs.items():
        alt = f"Displacement over voltage: {name} misses the loops by {scores[name].free_run.e_rms_um:.3g} µm rms."
        figure = loops(record, {name: y_um}, "", colours)
        pictures.append(Picture(f"loops-{len(pictures)}", f"Measured loops, model: {name}", alt, figure))
    errors = ", ".join(f"{name} at most {s.free_run.largest_um:.3g} µm" for name, s in scores.items())
    drawn = validation(record, runs, "", colours)
    pictures.append(Picture("time", "Free run in time", f"Error of the free run: {errors}.", drawn, wide=True))
    curves = {name: s.horizon for name, s in scores.items()}
    levels = {"noise floor": scored.noise.rms_um}
    ends = ", ".join(f"{name} {c.rms_um[0]:.2g} to {c.rms_um[-1]:.2g} µm" for name, c in curves.items())
    alt = f"Error rms from one step to the longest horizon: {ends}."
    pictures.append(
        Picture("horizon", "Error against the horizon", alt, horizon(curves, levels, record.Ts_s, "", colours))
    )
    return pictures


def _cycles(price: Cost) -> str:
    """Cycles of one sample; a tilde marks an estimate."""
    return f"{'' if price.per_sample.measured else '~'}{price.per_sample.value} cycles"


def folder_page(model: Model, report: Report, price: Cost) -> Page:
    """The report of a folder of generated C: equality of bits, cost, certificates, provenance."""
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
