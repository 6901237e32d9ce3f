"""An HTML page that refers to no other file: sentences, pictures, tables. The same content gives the same bytes."""

from __future__ import annotations

import base64
import csv
import functools
import io
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2

from hysgen.codegen.render import template_environment
from hysgen.machine.files import write_whole
from hysgen.machine.installed import version
from hysgen.machine.processes import in_processes
from hysgen.report.plots.style import Picture, data_uri

GLOSSARY = ("free run", "fit (NRMSE)", "noise floor", "price a sample", "generated C")
"""Labels of figures that the section "Glossary" explains (`sections.TERMS`)."""


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
        stream = io.StringIO()
        csv.writer(stream, lineterminator="\n").writerows([list(self.header), *map(list, self.cells)])
        return "data:text/csv;base64," + base64.b64encode(stream.getvalue().encode()).decode()

    @property
    def rows(self) -> list[list[tuple[str, str]]]:
        """(column head, cell) by row; narrow screens show the head beside each cell."""
        return [list(zip(self.header, row, strict=True)) for row in self.cells]


@dataclass(frozen=True)
class PageSection:
    """A section of the page: sentences, pictures, tables, then notes in small print."""

    title: str
    text: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[PageTable] = ()
    notes: Sequence[str] = ()

    @property
    def anchor(self) -> str:
        """The fragment of a link to this section."""
        return "".join(letter if letter.isalnum() else "-" for letter in self.title.lower())


@dataclass(frozen=True)
class Page:
    """A page. lead: the answer in sentences; figures: the most important numbers."""

    title: str
    lead: Sequence[str]
    figures: Sequence[KeyFigure]
    sections: Sequence[PageSection]

    def html(self) -> str:
        """The page as one HTML document."""
        figures = [picture.figure for section in self.sections for picture in section.pictures]
        images = dict(zip(map(id, figures), in_processes(data_uri, figures), strict=True))
        template = _environment().get_template("report/page.html.j2")
        return template.render(page=self, image=lambda figure: images[id(figure)], version=version())

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
