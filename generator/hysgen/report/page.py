"""A page of HTML that needs nothing but itself: sentences, pictures and tables; the same bytes every time."""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import dataclass

import jinja2

from hysgen.codegen.render import template_environment
from hysgen.machine.installed import version
from hysgen.report.plots.picture import Picture


@dataclass(frozen=True)
class KeyFigure:
    """One number that stands at the top of the page, what it is, and what to compare it with."""

    label: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class Table:
    """cells: rows of as many cells as `header`; left: columns of words, the others are numbers."""

    header: Sequence[str]
    cells: Sequence[Sequence[str]]
    caption: str = ""
    left: int = 1

    @property
    def rows(self) -> list[list[tuple[str, str]]]:
        """Every cell with the head of its column, which stands beside it on narrow screens."""
        return [list(zip(self.header, row, strict=True)) for row in self.cells]


@dataclass(frozen=True)
class Section:
    """text above the pictures and tables, notes below them in small print. An empty section is left out."""

    title: str
    text: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()

    @property
    def anchor(self) -> str:
        """What a link to this section ends with."""
        return "".join(letter if letter.isalnum() else "-" for letter in self.title.lower())


@dataclass(frozen=True)
class Page:
    """lead: the answer in a few sentences; figures: the numbers to remember."""

    title: str
    lead: Sequence[str]
    figures: Sequence[KeyFigure]
    sections: Sequence[Section]

    def html(self) -> str:
        """The page as text."""
        return _environment().get_template("report/page.html.j2").render(page=self, version=version())


@functools.cache
def _environment() -> jinja2.Environment:
    environment = template_environment(autoescape=True)
    environment.filters["readable"] = readable
    return environment


def readable(text: str) -> str:
    """Units as people write them: the program says um, for terminals of any kind.

    >>> readable("0.47 um, umbra, 3 um/V")
    '0.47 µm, umbra, 3 µm/V'
    """
    return re.sub(r"\bum\b", "µm", text)
