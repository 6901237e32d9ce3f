"""An HTML page that refers to no other file: sentences, pictures, tables, and the sections common to all reports."""

import base64
import csv
import functools
import io
import json
import os
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
import scipy

from hysgen.certify.certificates import certify, dynamics
from hysgen.checking.bits import Report
from hysgen.checking.cost import Cost
from hysgen.codegen.render import template_environment
from hysgen.display import WRITTEN_IN, Quantities, written_in
from hysgen.machine.files import digest, version, write_whole
from hysgen.machine.processes import in_processes
from hysgen.model.file import dump_model
from hysgen.model.model import Model
from hysgen.report import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION, YELLOW
from hysgen.report.plots import Picture, data_uri, named
from hysgen.uncertainty.simulated import Characterisation

GLOSSARY = ("free run", "fit (NRMSE)", "noise floor", "price a sample", "generated C")
"""Labels of figures that the section "Glossary" explains (`TERMS`)."""


@dataclass(frozen=True)
class KeyFigure:
    """A number at the top of the page: its label, its value, and a note to compare it with."""

    label: str
    value: str
    note: str = ""

    @property
    def explained(self) -> bool:
        """Whether the glossary of a page has the label."""
        return self.label.partition(",")[0] in GLOSSARY


PALETTE = (
    *((BLUE, "#fff"), (ORANGE, "#000"), (GREEN, "#fff"), (PURPLE, "#000"), (SKY, "#000")),
    *((YELLOW, "#000"), (VERMILION, "#000")),
)
"""Colours of shares, largest first, and of the letters on them."""


@dataclass(frozen=True)
class Share:
    """A part of a bar: name, share (0 to 1), the share in words, colour and that of letters on it."""

    name: str
    share: float
    words: str
    colour: str = "#808080"
    ink: str = "#fff"


@dataclass(frozen=True)
class PageTable:
    """A table of the page. cells: rows as long as `header`.

    The first `left` and the last `right` columns hold words, the others numbers; left None: all hold words.
    """

    header: Sequence[str]
    cells: Sequence[Sequence[str]]
    caption: str = ""
    left: int | None = None
    right: int = 0

    @property
    def numbers(self) -> range:
        """The columns that hold numbers, counted from 1."""
        return range(0) if self.left is None else range(self.left + 1, len(self.header) - self.right + 1)

    @property
    def csv_uri(self) -> str:
        """The table as CSV inside a `data:` address."""
        stream, words = io.StringIO(), WRITTEN_IN.get().text
        rows = [[words(cell) for cell in row] for row in (self.header, *self.cells)]
        csv.writer(stream, lineterminator="\n").writerows(rows)
        return "data:text/csv;base64," + base64.b64encode(stream.getvalue().encode()).decode()

    @property
    def rows(self) -> list[list[tuple[str, str]]]:
        """(column head, cell) by row; narrow screens show the head beside each cell."""
        return [list(zip(self.header, row, strict=True)) for row in self.cells]


@dataclass(frozen=True)
class Card:
    """A small drawing, an SVG element or none, with what is said about it, by heads."""

    title: str
    drawing: str
    lines: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class PageSection:
    """A section of the page: sentences, pictures, tables, cards, then notes in small print."""

    title: str
    text: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[PageTable] = ()
    notes: Sequence[str] = ()
    cards: Sequence[Card] = ()

    @property
    def anchor(self) -> str:
        """The fragment of a link to this section."""
        return "".join(letter if letter.isalnum() else "-" for letter in self.title.lower())


@dataclass(frozen=True)
class Page:
    """A page. lead: the answer in sentences; figures: the most important numbers.

    headline: the answer in a few words; shares: a bar below it; warnings: what changes the answer.
    """

    title: str
    lead: Sequence[str]
    figures: Sequence[KeyFigure]
    sections: Sequence[PageSection]
    quantities: Quantities | None = None
    headline: str = ""
    shares: Sequence[Share] = ()
    warnings: Sequence[str] = ()

    def html(self) -> str:
        """The page as one HTML document, in the page's quantities, or in those in which texts are written."""
        with written_in(self.quantities or WRITTEN_IN.get()):
            return self._html()

    def _html(self) -> str:
        figures = [named(picture.figure) for section in self.sections for picture in section.pictures]
        images = dict(zip(map(id, figures), in_processes(data_uri, figures), strict=True))
        template = _environment().get_template("report/page.html.j2")
        text = template.render(page=self, image=lambda figure: images[id(figure)], version=version())
        words = WRITTEN_IN.get().text  # of all but the pictures and tables inside addresses
        return "".join(part if part.startswith('"data:') else words(part) for part in re.split(r'("data:[^"]*")', text))

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the page, whole or not at all. Returns its path."""
        write_whole(Path(path), self.html())
        return Path(path)


@functools.cache
def _environment() -> jinja2.Environment:
    environment = template_environment(autoescape=True)
    environment.filters["readable"] = readable
    environment.filters["sentence"] = sentence
    return environment


def sentence(text: str) -> str:
    """The text with a capital at its beginning; a name (`record.csv`, `stage_t`, `stage:`) is kept.

    >>> sentence("resonance is named"), sentence("record.csv: 50 samples"), sentence("stage: first-order lag")
    ('Resonance is named', 'record.csv: 50 samples', 'stage: first-order lag')
    """
    first = text.split(maxsplit=1)[:1]
    return text if not first or re.search(r"[._]\w|:$", first[0]) else text[0].upper() + text[1:]


def readable(text: str) -> str:
    """The text with the micro sign in units and the sign ±; terminals get the ASCII `um` and `+-`.

    A compiler's option is not broken behind its hyphen: a word joiner follows.

    >>> readable("0.47 +- 0.01 um, umbra, 3 um/V")
    '0.47 ± 0.01 µm, umbra, 3 µm/V'
    """
    return re.sub(r"-(?=O\d)", "-\u2060", re.sub(r"\bum\b", "µm", text).replace(" +- ", " ± "))


def model_section(model: Model) -> PageSection:
    """The model as a dynamic system, its parts, and its certificates."""
    held = certify(model)
    facts = [
        ["rules", f"{model.grid.rules} over {model.grid.ends_um[0]:.4g} .. {model.grid.ends_um[1]:.4g} um"],
        ["displacement range", f"{model.grid.y_min_um:.4g} .. {model.grid.y_max_um:.4g} um"],
        ["input range", f"{model.u_min_V:.4g} .. {model.u_max_V:.4g} V"],
        ["sampling period", f"{1e6 * model.Ts_s:.6g} µs"],
        *[[f"path: {block.kind}", block.describe()] for block in model.blocks],
        *[[f"disturbance: {term.kind}", term.describe()] for term in model.terms],
        *([["learner", f"forgetting {model.learner.forgetting:.9g}"]] if model.learner else []),
    ]
    verdicts = [
        ["gain of one sign: the inverse exists", _holds(held.gain_holds), held.lines()[0]],
        ["contraction: the free run is stable", _holds(held.contraction_holds), held.lines()[1]],
        ["inverse stable", _holds(held.inverse_holds), held.lines()[2]],
    ]
    return PageSection(
        "Model and certificates",
        text=[dynamics(model).describe().splitlines()[0]],
        tables=[
            PageTable(["part", "what it is"], facts, "Model"),
            PageTable(["certificate", "holds", "how close"], verdicts, "Certificates over the whole range"),
        ],
        notes=[
            f"Fitted beside the path: {3 * model.grid.rules} consequents of the rules, {model.weights.size} weights of "
            "disturbances. The model file holds every number."
        ],
    )


def equivalence_section(report: Report | None, why_not: str = "") -> PageSection:
    """Whether the generated C equals its float32 reference, by function and build. report: None if not compared."""
    title = "Generated C against its reference"
    if report is None:
        return PageSection(title, text=[f"Not compared: {why_not}."])
    summary = report.summary()
    answer = (
        f"Equal in every bit over {report.samples} samples per build."
        if report.equal
        else f"NOT EQUAL: {len(report.mismatches)} runs differ."
    )
    compared = PageTable(summary.header, summary.rows, left=summary.left, right=1)
    return PageSection(title, text=[answer], tables=[compared], notes=[f"{note}." for note in summary.notes])


def cost_section(price: Cost | None, why_not: str = "") -> PageSection:
    """Cycles against the sample period, operations and bytes. price: None if unknown, for the reason `why_not`."""
    title = "Cost against budget"
    if price is None:
        return PageSection(title, text=[f"Not known: {why_not}."])
    rows = [
        [
            f.name,
            f"{f.cycles.value}" if f.cycles.measured else f"~{f.cycles.value}",
            f"{100.0 * f.cycles.value / price.budget:.2g} %",
            f"{f.operations.add + f.operations.multiply}",
            f"{f.operations.load + f.operations.store}",
        ]
        for f in price.functions
    ]
    measured = all(f.cycles.measured for f in price.functions)
    return PageSection(
        title,
        text=[
            f"One sample takes {price.per_sample} of {price.budget} at {1e-3 / price.Ts_s:.4g} kHz and "
            f"{price.clock_Hz / 1e6:.4g} MHz: {100.0 * price.share:.2g} %."
        ],
        tables=[
            PageTable(["function", "C674x cycles", "of a period", "float operations", "loads and stores"], rows, left=1)
        ],
        notes=[
            "Bytes: "
            + ", ".join(f"{name} {size}" for name, size in price.struct_bytes.items())
            + f", constants {price.constant_bytes}.",
            *([] if measured else ["~ cycles are estimated from the operations; init runs once, not in every sample."]),
            "Memory stalls, caches and interrupts are not modelled; nothing has run on silicon.",
        ],
    )


def uncertainty_section(uncertainty: Characterisation) -> PageSection:
    """Budget after the GUM with the model error by cause, quantities of a positioning axis, and errors removed."""
    budget = uncertainty.budget
    head = ["contribution", "type", "standard uncertainty um", "degrees of freedom", "of the variance", "from"]
    removed = [[name, f"{size_um:.3g}"] for name, size_um in uncertainty.removed]
    tables = [
        PageTable(head, budget.rows(), f"Budget: {budget.measurand}", left=2, right=1),
    ]
    if removed:
        tables.append(
            PageTable(
                ["extension", "error removed, um rms"],
                removed,
                "Error of the free run that each extension removes",
                left=1,
            )
        )
    return PageSection(
        "Uncertainty",
        text=[
            f"Expanded uncertainty {budget.expanded_um:.3g} um: k = {budget.factor:.3g} for a coverage of "
            f"{100 * budget.coverage:.0f} %, combined standard uncertainty {budget.combined_um:.3g} um."
        ],
        tables=tables,
        notes=[
            *(f"Not known: {name}." for name in uncertainty.missing),
            "This page is a characterisation report, not a calibration certificate.",
        ],
    )


TERMS = (
    ("free run", "simulation from the first measured displacement alone; its error is the error of a simulation"),
    ("fit (NRMSE)", "100 (1 - |y - yhat| / |y - mean y|) in %, of the free run"),
    ("noise floor", "rms of the displacement that no model can explain, estimated from the record"),
    ("stroke", "range of the displacement over the whole record; percentages refer to it"),
    ("held out", "rows that no fit uses; they are scored only"),
    ("gain", "fall of the held-out rms error by an extension, with a 95 % interval by block bootstrap"),
    ("confidence", "posterior probability of the cause over all chains of causes that were compared"),
    ("of the error", "share of the power of the error above the noise floor"),
    ("horizon", "time over which the displacement is predicted from one measured sample"),
    ("price a sample", "cycles of the DSP and bytes that the extensions add"),
    ("generated C", "float32 C of the model; equal bits: every build computes what the NumPy reference computes"),
)
"""Words of the page with their meaning."""


def glossary_section() -> PageSection:
    """The words of the page; the figures at its top link to it."""
    return PageSection("Glossary", tables=[PageTable(["word", "meaning"], [list(term) for term in TERMS])])


def provenance_section(model: Model, facts: Sequence[tuple[str, str]]) -> PageSection:
    """The inputs of this page: `facts`, digest of the model, settings of its fit, versions of the software."""
    fit = model.history.get("fit", {})
    rows = [
        *[list(fact) for fact in facts],
        ["model", f"{model.name}, SHA-256 {digest(dump_model(model).encode())}"],
        ["fit settings", _settings(fit if isinstance(fit, dict) else {})],
        ["hysgen", version()],
        ["Python, NumPy, SciPy", f"{platform.python_version()}, {np.__version__}, {scipy.__version__}"],
    ]
    return PageSection("Provenance", tables=[PageTable(["what", "which"], rows)])


def _settings(fit: Mapping[str, Any]) -> str:
    """The settings of a fit without its terms and blocks, which the model section lists."""
    plain = {key: value for key, value in fit.items() if key not in ("terms", "blocks")}
    return ", ".join(f"{key} {json.dumps(value)}" for key, value in plain.items()) or "not recorded in the model"


def _holds(holds: bool) -> str:
    return "yes" if holds else "NO"
