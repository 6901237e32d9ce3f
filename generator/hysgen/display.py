"""Display of results: one line as `repr`, a table when printed or in a notebook, a plot on request."""

from __future__ import annotations

import abc
import html
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hysgen import upward
from hysgen.errors import HysgenError


def table(header: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """A text table. The first `left` columns are left-aligned, the others (numbers) right-aligned.

    >>> print(table(["model", "rms"], [["base", "0.47"], ["extended", "0.1"]]))
    model      rms
    --------  ----
    base      0.47
    extended   0.1
    """
    cells = [list(header), *[list(row) for row in rows]]
    widths = [max(len(row[j]) for row in cells) for j in range(len(header))]

    def line(row: Sequence[str]) -> str:
        columns = enumerate(zip(row, widths, strict=True))
        return "  ".join(cell.ljust(w) if j < left else cell.rjust(w) for j, (cell, w) in columns).rstrip()

    return "\n".join([line(cells[0]), "  ".join("-" * width for width in widths), *[line(row) for row in cells[1:]]])


def decimal(value: float, digits: int) -> str:
    """A number with at most `digits` significant digits, without an exponent between 1e-6 and 1e9.

    >>> decimal(13824.0, 2), decimal(1.63e-5, 2), decimal(0.25, 4), decimal(3e-9, 2)
    ('14000', '0.000016', '0.25', '3e-09')
    """
    text = f"{value:.{digits}g}"
    if not 1e-6 <= abs(value) < 1e9:
        return text
    rounded = float(text)
    return f"{rounded:.{max(0, digits - 1 - math.floor(math.log10(abs(rounded))))}f}" if "e" in text else text


@dataclass(frozen=True)
class Summary:
    """title: one line; first: lines below it; header, rows: a table, possibly empty, with `left` left-aligned columns;
    notes: lines below the table."""

    title: str
    header: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()
    left: int = 1
    first: Sequence[str] = ()

    def text(self) -> str:
        """For terminals."""
        body = [table(self.header, self.rows, self.left)] if self.rows else []
        return "\n".join([self.title, *self.first, *body, *self.notes])

    def html(self) -> str:
        """For notebooks: plain elements without style or script."""
        lines = [f"<p><strong>{html.escape(self.title)}</strong></p>"]
        lines += [f"<p>{html.escape(line)}</p>" for line in self.first]
        if self.rows:
            lines.append("<table><thead><tr>" + _cells(self.header, "th") + "</tr></thead><tbody>")
            lines += ["<tr>" + _cells(row, "td") + "</tr>" for row in self.rows]
            lines.append("</tbody></table>")
        lines += [f"<p>{html.escape(note)}</p>" for note in self.notes]
        return "\n".join(lines)


class Displayed(abc.ABC):
    """A result with a display as text, as HTML and as a plot."""

    @abc.abstractmethod
    def summary(self) -> Summary:
        """The content of the display."""

    def plot(self, *what: Any) -> Any:
        """A plot, displayed by a notebook; `.save(path)` writes it, `.figure` is the matplotlib figure.

        what: depends on the kind of result, see docs/api.md.
        Raises HysgenError if there is nothing to plot or matplotlib is not installed.
        """
        try:
            draw = upward.draw()
        except ModuleNotFoundError as fault:
            missing = str(fault.name).partition(".")[0]
            raise HysgenError(f"{missing} is not installed; pip install {missing} to plot") from fault
        try:
            return draw(self, *what)
        except TypeError as fault:
            if not what:
                raise
            asked = ", ".join(repr(plot) for plot in what)
            raise HysgenError(f"{type(self).__name__}: nothing to plot for {asked}; call plot() without it") from fault

    def __repr__(self) -> str:
        return f"<{self.summary().title}>"

    def __str__(self) -> str:
        return self.summary().text()

    def _repr_html_(self) -> str:
        return self.summary().html()

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text(repr(self) if cycle else str(self))


def _cells(cells: Sequence[str], tag: str) -> str:
    return "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)
