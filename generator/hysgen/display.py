"""Display of results: one line as `repr`, a table when printed or in a notebook, a plot on request.

Texts are written for a voltage in V and a displacement in um. Where they leave the program for a stage with two other
quantities, `Quantities.text` puts the names and units of these in their place.
"""

from __future__ import annotations

import abc
import contextlib
import html
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, Final, Self

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
    words = WRITTEN_IN.get().text
    widths = [max(len(words(row[j])) for row in cells) for j in range(len(header))]

    def line(row: Sequence[str]) -> str:
        # The columns are straight once the text is in the quantities in which it is written.
        columns = enumerate((cell, w + len(cell) - len(words(cell))) for cell, w in zip(row, widths, strict=True))
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


_UNIT = r"(?:[u\N{MICRO SIGN}]m|V)"
_WRITTEN = re.compile(
    rf"(?<![\w./'-])(?:1/)?{_UNIT}(?:/{_UNIT})?(?![\w=-]|\.\w)"
    r"|(?<![\w./'-])(?:\b([Aa]) )?([Dd]isplacement|[Vv]oltage)(s?)(?![\w=-]|\.\w)"
)


@dataclass(frozen=True)
class Quantities:
    """What drives a stage and what it answers: a voltage in V and a displacement in um, or any two others.

    One unit of another quantity is computed and stored as one V or one um is: no result depends on the scale.

    What is quoted stays.

    >>> Quantities("field", "mT", "angle", "deg").text("a displacement of 3 um: 1.5 um/V, not 'um/V'; voltage=NAME")
    "an angle of 3 deg: 1.5 deg/mT, not 'um/V'; voltage=NAME"
    """

    input: str = "voltage"
    input_unit: str = "V"
    output: str = "displacement"
    output_unit: str = "um"

    @classmethod
    def of(cls, input_: str, output: str) -> Quantities:
        """From "field [mT]" and "angle [deg]". Raises HysgenError for other texts, and for equal names."""
        parts: list[str] = []
        for key, text in (("input", input_), ("output", output)):
            match = re.fullmatch(r"\s*([a-z][a-z ]*[a-z])\s*\[([A-Za-z%][A-Za-z0-9 /^.%-]{0,11})\]\s*", text)
            if match is None:
                raise HysgenError(f"{key}: '{text}' is not a name and a unit; write it as {key}=angle [deg]")
            parts += match.groups()
        if parts[0] == parts[2]:
            raise HysgenError(f"output: {parts[2]} is the name of the input, too; call one of them otherwise")
        return cls(*parts)

    @property
    def other(self) -> bool:
        """Whether these are two other quantities than voltage in V and displacement in um."""
        return self != OWN

    @property
    def units(self) -> tuple[str, str]:
        """Of the input and of the output."""
        return self.input_unit, self.output_unit

    @property
    def columns(self) -> tuple[str, str]:
        """Names of the columns of input and output in hysgen's own files."""
        return f"{self.input}_{self.input_unit}", f"{self.output}_{self.output_unit}"

    def text(self, text: str) -> str:
        """A text that was written for V and um, with the names and units of these quantities."""
        return _WRITTEN.sub(self._named, text) if self.other else text

    def json(self, value: Any) -> Any:
        """A value of JSON with its texts in these quantities; keys stay."""
        if isinstance(value, Mapping):
            return {key: self.json(part) for key, part in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.json(part) for part in value]
        return self.text(value) if isinstance(value, str) else value

    def _named(self, match: re.Match[str]) -> str:
        article, word, plural = match.groups()
        if word is None:
            return re.sub(_UNIT, lambda unit: self.input_unit if unit[0] == "V" else self.output_unit, match[0])
        name = self.input if word.lower() == "voltage" else self.output
        name = (name if word.islower() else name.capitalize()) + plural
        return name if article is None else f"{article}{'n' if name[0] in 'aeiou' else ''} {name}"


OWN: Final = Quantities()

WRITTEN_IN: ContextVar[Quantities] = ContextVar("WRITTEN_IN", default=OWN)
"""The quantities of the texts, pages and plots that are being made."""


@contextlib.contextmanager
def written_in(quantities: Quantities) -> Iterator[None]:
    """Texts, pages and plots that are made inside are in these quantities."""
    token = WRITTEN_IN.set(quantities)
    try:
        yield
    finally:
        WRITTEN_IN.reset(token)


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
        return WRITTEN_IN.get().text("\n".join([self.title, *self.first, *body, *self.notes]))

    def html(self) -> str:
        """For notebooks: plain elements without style or script."""
        lines = [f"<p><strong>{html.escape(self.title)}</strong></p>"]
        lines += [f"<p>{html.escape(line)}</p>" for line in self.first]
        if self.rows:
            lines.append("<table><thead><tr>" + _cells(self.header, "th") + "</tr></thead><tbody>")
            lines += ["<tr>" + _cells(row, "td") + "</tr>" for row in self.rows]
            lines.append("</tbody></table>")
        lines += [f"<p>{html.escape(note)}</p>" for note in self.notes]
        return WRITTEN_IN.get().text("\n".join(lines))


class Displayed(abc.ABC):
    """A result with a display as text, as HTML and as a plot."""

    _shown_in: Quantities | None = None

    def shown_in(self, quantities: Quantities) -> Self:
        """The result, which from now on displays these quantities."""
        object.__setattr__(self, "_shown_in", quantities)
        return self

    def _own(self) -> contextlib.AbstractContextManager[None]:
        return written_in(getattr(self, "quantities", None) or self._shown_in or WRITTEN_IN.get())

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
            with self._own():
                return draw(self, *what)
        except TypeError as fault:
            if not what:
                raise
            asked = ", ".join(repr(plot) for plot in what)
            raise HysgenError(f"{type(self).__name__}: nothing to plot for {asked}; call plot() without it") from fault

    def __repr__(self) -> str:
        with self._own():
            return f"<{WRITTEN_IN.get().text(self.summary().title)}>"

    def __str__(self) -> str:
        with self._own():
            return self.summary().text()

    def _repr_html_(self) -> str:
        with self._own():
            return self.summary().html()

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text(repr(self) if cycle else str(self))


def _cells(cells: Sequence[str], tag: str) -> str:
    return "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)
