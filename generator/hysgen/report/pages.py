"""Reports of models, scored side by side on a record.

The HTML report of a diagnosis: error, causes, ladder, model, equality of bits, cost, provenance on one page.
"""

import itertools
from collections.abc import Mapping

import numpy as np

from hysgen.checking.bits import Report
from hysgen.checking.bits.comparison import VerifySettings, verify_texts
from hysgen.checking.cost import Cost, cost_of_texts
from hysgen.codegen import Derived, generate
from hysgen.diagnosis.evaluation import LADDER, Study, confidence_text, share_text
from hysgen.errors import HysgenError
from hysgen.model.model import Model
from hysgen.model.scores import OWN, SCORE_HEADER, Score, Scores, score_rows
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.report import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from hysgen.report.page import (
    PALETTE,
    Card,
    KeyFigure,
    Page,
    PageSection,
    PageTable,
    Share,
    cost_section,
    equivalence_section,
    glossary_section,
    model_section,
    provenance_section,
    uncertainty_section,
)
from hysgen.report.plots import Picture
from hysgen.report.plots.results import pictures
from hysgen.report.plots.traces import (
    Simulated,
    fit_percent,
    free_run_pictures,
    horizon,
    loop_pictures,
    response_pictures,
    time_picture,
)
from hysgen.report.sketches import svg
from hysgen.report.words import CONFIDENCE, headline, in_one_sentence, parameter_text, total_price, warnings
from hysgen.uncertainty.simulated import Characterisation

COLOURS = (VERMILION, BLUE, GREEN, PURPLE, ORANGE, SKY)
"""Of the models, in their order."""


def model_page(
    title: str,
    record: Record,
    models: Mapping[str, Model],
    scores: Mapping[str, Scores],
    rivals: Mapping[str, Score] | None = None,
    command: str = "",
) -> Page:
    """The report of models, by their names in it, with their scores on one record that no fit has used.

    rivals: free-run scores of models of other kinds, by name. command: the command line that repeats the report, if
    there is one.
    """
    some = next(iter(scores.values()))
    rows = [(f"{name}, free run", s.free_run) for name, s in scores.items()]
    rows += [(f"{name}, {OWN}", s.own) for name, s in scores.items()]
    rows += [(f"{name}, one step", s.one_step) for name, s in scores.items()]
    rows += [("persistence, one step", some.persistence)]
    rows += [(f"{name}, free run", score) for name, score in (rivals or {}).items()]
    shown, pictures = _pictures(record, models, scores)
    return Page(
        title=title,
        lead=[
            f"Free run over {record.samples} samples: "
            + ", ".join(f"{name} {s.free_run.e_rms_um:.3g} um rms" for name, s in scores.items())
            + f"; the noise is {some.noise.rms_um:.2g} um."
        ],
        figures=_key_figures(scores, shown),
        sections=[
            PageSection(
                "Scores",
                tables=[PageTable(["model", *SCORE_HEADER[1:]], score_rows(rows), left=1)],
                notes=[
                    f"Noise floor {next(iter(scores.values())).noise.describe()}.",
                    *(f"Warning: {line}." for s in scores.values() for line in s.warnings),
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
            model_section(best := list(models.values())[-1]),
            glossary_section(),
            provenance_section(best, _sources(command, record)),
        ],
    )


def _sources(command: str, record: Record) -> list[tuple[str, str]]:
    asked = [("command", command)] if command else []
    return [*asked, ("record", record.source), ("record SHA-256", record.digest)]


def _key_figures(scores: Mapping[str, Scores], shown: Simulated) -> list[KeyFigure]:
    """Free-run errors and noise floor."""
    noise = next(iter(scores.values())).noise
    return [
        KeyFigure(
            f"free run, {name}",
            f"{s.free_run.e_rms_um:.3g} µm",
            f"{s.free_run.of_span_percent:.2g} % of the stroke; fit (NRMSE) "
            f"{fit_percent(shown.measured_um, shown.runs[name]):.4g} %",
        )
        for name, s in scores.items()
    ] + [KeyFigure("noise floor", f"{noise.rms_um:.2g} µm", noise.describe().partition(" rms ")[2])]


def _pictures(
    record: Record, models: Mapping[str, Model], scores: Mapping[str, Scores]
) -> tuple[Simulated, list[Picture]]:
    """The free runs over the longest scored segment and their pictures, error against the horizon among them."""
    number = int(np.argmax([segment.samples for segment in record.segments]))
    segment = record.segments[number]
    lines = {name: {"color": colour} for name, colour in zip(models, itertools.cycle(COLOURS), strict=False)}
    shown = Simulated(
        segment.start_s + record.Ts_s * np.arange(segment.samples, dtype=np.float64),
        segment.u_V,
        segment.y_um,
        {name: free_run(model, record)[number].y_um for name, model in models.items()},
        lines,
    )
    curves = {name: s.horizon for name, s in scores.items()}
    return shown, [
        *free_run_pictures(shown),
        *response_pictures(shown),
        *loop_pictures(shown),
        time_picture(shown),
        horizon(curves, {"noise floor": next(iter(scores.values())).noise.rms_um}, record.Ts_s, lines),
    ]


SAMPLES = 100_000
"""Samples per build in the comparison of the generated C with its reference."""


def diagnosis_page(
    study: Study,
    characterisation: Characterisation | None = None,
    proof: tuple[Report, Cost] | None = None,
    command: str = "",
) -> Page:
    """The report.

    characterisation: uncertainty, as a section of their own. proof: comparison and cost of the extended
    model's C; by default, both are made here. command: the command line that repeats the report, if there is one.
    """
    drawn = {picture.name: picture for picture in pictures(study)}
    report, price, why_not = (*proof, "") if proof is not None else _proof(study)
    return Page(
        title=f"{file_names(study.record.source)}: what the simulation gets wrong",
        lead=[in_one_sentence(study)],
        headline=headline(study),
        shares=shares(study),
        warnings=warnings(study),
        figures=key_figures(study, report, price),
        sections=[
            *_remedies(study),
            _causes(study),
            _ladder(drawn, study),
            _error(drawn, study),
            PageSection(
                "Measured and simulated",
                text=["Held-out part of the record. Grey is measured."],
                pictures=[drawn[name] for name in ("free-run", "zoom", "gain", "phase")],
            ),
            PageSection("The record", text=[f"{study.record.one_line()}."], pictures=[drawn["record"]]),
            _abilities(study),
            *([uncertainty_section(characterisation)] if characterisation else []),
            model_section(study.diagnosis.model),
            equivalence_section(report, why_not),
            cost_section(price, why_not),
            glossary_section(),
            provenance_section(
                study.diagnosis.model,
                [
                    *_sources(command, study.record),
                    ("identified on", f"rows 0 to {study.cut - 1}"),
                    ("scored on", f"rows {study.cut} to {study.record.samples - 1}"),
                    ("sampling period", f"{1e6 * study.record.Ts_s:.6g} µs"),
                ],
            ),
        ],
    )


def file_names(source: str) -> str:
    """The file names in the source of a record, without row ranges and repetitions.

    >>> file_names("a.csv[0:50], a.csv[50:99]")
    'a.csv'
    """
    return ", ".join(dict.fromkeys(part.partition("[")[0] for part in source.split(", ")))


def shares(study: Study) -> list[Share]:
    """The parts of the bar: causes in the model, the largest first, and what is not explained."""
    ranked = sorted(study.extended, key=lambda cause: -cause.share)
    rest = study.diagnosis.unexplained_fraction
    return [
        Share(cause.name, cause.share, share_text(cause), *colours)
        for cause, colours in zip(ranked, itertools.cycle(PALETTE), strict=False)
    ] + [Share("not explained", rest, f"{100.0 * rest:.1f} %")]


def key_figures(study: Study, report: Report | None, price: Cost | None) -> list[KeyFigure]:
    """Free-run errors, noise floor, price and equality of bits, for the top of the page."""
    diagnosis = study.diagnosis
    base_um = diagnosis.base_rms_um
    span = f"{study.percent(base_um):.2g} % of the stroke, held out"
    figures = [KeyFigure("free run, paper's model", f"{base_um:.3g} µm", span)]
    held = study.held_out()
    delivered = held.extended_um if study.improved else held.base_um
    percent = fit_percent(held.measured_um, delivered)
    own = diagnosis.remaining
    cold = f"cold {diagnosis.extended_rms_um:.3g} µm; finer model {own.probe_rms_um:.3g} µm"
    figures.append(KeyFigure(f"free run, {'extended' if study.improved else 'own'}", f"{own.rms_um:.3g} µm", cold))
    figures.append(KeyFigure("fit (NRMSE)", f"{percent:.4g} %", "free run of the model written, held out"))
    figures.append(KeyFigure("noise floor", f"{diagnosis.noise.rms_um:.2g} µm", f"from {diagnosis.noise.source}"))
    total = total_price(study)
    if total is not None:
        note = f"{total.bytes:+} bytes" + (f"; {100 * price.share:.2g} % of a sample in all" if price else "")
        figures.append(KeyFigure("price a sample", f"{total.cycles:+} cycles", note))
    if report is not None:
        figures.append(
            KeyFigure(
                "generated C", "equal bits" if report.equal else "NOT EQUAL", f"{report.samples} samples per build"
            )
        )
    return figures


def _error(drawn: dict[str, Picture], study: Study) -> PageSection:
    after = f", {100 * study.after.above_noise:.0f} % of that of the extended model" if study.improved else ""
    return PageSection(
        "Where the error lies",
        text=[
            f"{100 * study.before.above_noise:.0f} % of the power of the paper's model's error stands above the noise "
            f"floor{after}. One-step errors are small for every model; the free run is the error of a simulation."
        ],
        pictures=[drawn[name] for name in ("profiles", "time", "horizon", "spectrum")],
        notes=["Error: simulated - measured. A gap in a line: the record has no such samples."],
    )


def _remedies(study: Study) -> list[PageSection]:
    shares = {cause.name: share_text(cause) for cause in study.diagnosis.causes}
    cards = [
        Card(
            f"{remedy.name}, {shares[remedy.name]} of the error" if remedy.name in shares else remedy.name,
            svg(remedy.sketch, remedy.name) if remedy.sketch else "",
            [("means", remedy.advice.means), ("change", remedy.advice.change), ("gain", remedy.gain)],
        )
        for remedy in study.remedies()
    ]
    note = "Pictures: the model of this record, with the cause and without it, on one scale."
    return [PageSection("What to do to the stage", cards=cards, notes=[note])] if cards else []


def _causes(study: Study) -> PageSection:
    diagnosis = study.diagnosis
    ranked = sorted(diagnosis.causes, key=lambda cause: -cause.share)
    rows = [
        [
            cause.name,
            share_text(cause) if cause.extended else "not extended",
            confidence_text(cause),
            cause.evidence,
            parameter_text(study, cause.name),
        ]
        for cause in ranked
    ]
    left_out = len(diagnosis.causes) > len(study.extended)
    if diagnosis.unknown:
        rows.append(["unknown", f"{100 * diagnosis.unexplained_fraction:.1f} %", "", diagnosis.unknown, ""])
    return PageSection(
        "Causes and their evidence",
        text=[] if rows else ["None: the error of the paper's model is not above that of hysteresis and noise."],
        tables=[PageTable(["cause", "of the error", "confidence", "evidence", "parameters"], rows)] if rows else [],
        notes=[
            *(
                [f"{cause.why_not_extended}." for cause in diagnosis.causes if cause.why_not_extended]
                if left_out
                else []
            ),
            "A cause is named if the most probable chain contains it. The ladder shows what its extension gains.",
            *([f"{CONFIDENCE[0].upper()}{CONFIDENCE[1:]}."] if rows else []),
        ],
    )


def _abilities(study: Study) -> PageSection:
    diagnosis = study.diagnosis
    shown = [
        [ability.name, "yes: named" if ability.verdict == "named" else ability.text()]
        for ability in diagnosis.abilities
    ]
    refused = [[item.name, item.why] for item in diagnosis.refused]
    return PageSection(
        "What this record can tell",
        text=[f"Next experiment: {diagnosis.next_experiment}."] if diagnosis.next_experiment else [],
        tables=[
            PageTable(["cause", "could this record show it?"], shown),
            *([PageTable(["cause", "why not"], refused, "Examined and not named")] if refused else []),
        ],
    )


def _ladder(drawn: dict[str, Picture], study: Study) -> PageSection:
    diagnosis = study.diagnosis
    return PageSection(
        "What each extension gains, and its price",
        pictures=[drawn["ladder"]],
        tables=[PageTable(LADDER, study.ladder(), left=1)],
        notes=[
            diagnosis.remaining.line(),
            *(f"Taken out: {taken.text}." for taken in diagnosis.remaining.taken),
            f"Free run over the held-out part; noise floor from {diagnosis.noise.source}. Own: without what no model "
            "can know. Gain: fall of own, 95 % interval by block bootstrap. Bar: this interval, from the point to the "
            "right; where the bar reaches left of the point, the gain of the step is not certain. Of the error: share "
            "of its power above the noise. "
            "Cycles: estimated, of the dearest of predict, simulate and inverse.",
            f"Not explained: {100 * diagnosis.unexplained_fraction:.1f} % of the power of the error of the paper's "
            "model above the noise.",
        ],
    )


def _proof(study: Study) -> tuple[Report | None, Cost | None, str]:
    """Comparison and cost of the extended model's C, and the reason if one of them is missing."""
    model = study.diagnosis.model
    try:
        derived = Derived(model)
        texts = generate(derived, derived.options)
        price = cost_of_texts(model, texts, timed=False)
    except HysgenError as fault:
        return None, None, str(fault)
    try:
        return verify_texts(model, texts, VerifySettings(samples=SAMPLES)), price, ""
    except HysgenError as fault:
        return None, price, str(fault)
