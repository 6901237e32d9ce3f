"""Reports of models, scored side by side on a record."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hysgen.model.model import Model
from hysgen.model.scores import OWN, SCORE_HEADER, Score, Scores, score_rows
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.record.noise import NoiseFloor
from hysgen.report.page import (
    KeyFigure,
    Page,
    PageSection,
    PageTable,
    glossary_section,
    model_section,
    provenance_section,
)
from hysgen.report.plots import style
from hysgen.report.plots.style import Picture
from hysgen.report.plots.traces import (
    Simulated,
    fit_percent,
    free_run_pictures,
    horizon,
    loop_pictures,
    response_pictures,
    time_picture,
)

COLOURS = (style.SIMULATED, style.EXTENDED, style.BASELINE, "#cc79a7", "#e69f00", "#56b4e9")
"""Of the models, in their order: Okabe and Ito (2008), as in `style`."""


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
        rows += [(f"{name}, {OWN}", s.own) for name, s in self.scores.items()]
        rows += [(f"{name}, one step", s.one_step) for name, s in self.scores.items()]
        rows.append(("persistence, one step", next(iter(self.scores.values())).persistence))
        return rows + [(f"{name}, free run", score) for name, score in self.rivals]


def model_page(title: str, scored: ScoredModels, command: str = "") -> Page:
    """The report of models on a record. command: the command line that repeats the report, if there is one."""
    best, record = list(scored.models.values())[-1], scored.record
    shown, pictures = _pictures(scored)
    return Page(
        title=title,
        lead=[
            f"Free run over {record.samples} samples: "
            + ", ".join(f"{name} {s.free_run.e_rms_um:.3g} um rms" for name, s in scored.scores.items())
            + f"; the noise is {scored.noise.rms_um:.2g} um."
        ],
        figures=_key_figures(scored, shown),
        sections=[
            PageSection(
                "Scores",
                tables=[PageTable(["model", *SCORE_HEADER[1:]], score_rows(scored.rows()), left=1)],
                notes=[
                    f"{min(scored.scores.values(), key=lambda s: s.one_step.e_rms_um).noise_note()}.",
                    *(f"Warning: {line}." for s in scored.scores.values() for line in s.warnings),
                    "e_r: largest error. Stroke: range of the displacement over the record and the rows before it. "
                    "One-step errors are small for every model; the free run decides.",
                ],
            ),
            PageSection(
                "Measured and simulated",
                text=["Grey is measured."],
                pictures=pictures,
                notes=["Error: simulated - measured."],
            ),
            model_section(best),
            glossary_section(),
            provenance_section(
                best,
                [
                    *([("command", command)] if command else []),
                    ("record", record.source),
                    ("record SHA-256", record.digest),
                ],
            ),
        ],
    )


def _key_figures(scored: ScoredModels, shown: Simulated) -> list[KeyFigure]:
    """Free-run errors and noise floor."""
    return [
        KeyFigure(
            f"free run, {name}",
            f"{s.free_run.e_rms_um:.3g} µm",
            f"{s.free_run.of_span_percent:.2g} % of the stroke; fit (NRMSE) "
            f"{fit_percent(shown.measured_um, shown.runs[name]):.4g} %",
        )
        for name, s in scored.scores.items()
    ] + [KeyFigure("noise floor", f"{scored.noise.rms_um:.2g} µm", scored.noise.describe().partition(" rms ")[2])]


def _pictures(scored: ScoredModels) -> tuple[Simulated, list[Picture]]:
    """The free runs over the longest scored segment and their pictures, error against the horizon among them."""
    record, scores = scored.record, scored.scores
    number = int(np.argmax([segment.samples for segment in record.segments]))
    segment = record.segments[number]
    lines = {name: {"color": colour} for name, colour in zip(scored.models, itertools.cycle(COLOURS), strict=False)}
    shown = Simulated(
        segment.start_s + record.Ts_s * np.arange(segment.samples, dtype=np.float64),
        segment.u_V,
        segment.y_um,
        {name: free_run(model, record)[number].y_um for name, model in scored.models.items()},
        lines,
    )
    curves = {name: s.horizon for name, s in scores.items()}
    return shown, [
        *free_run_pictures(shown),
        *response_pictures(shown),
        *loop_pictures(shown),
        time_picture(shown),
        horizon(curves, {"noise floor": scored.noise.rms_um}, record.Ts_s, lines),
    ]
