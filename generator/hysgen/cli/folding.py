"""Text at the width of a terminal: sentences are folded, columns of tables are narrowed and their cells folded."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

RULER = re.compile(r"-+(?:  -+)+")
"""The line under the header of a table."""

NARROWEST = 10
"""Columns of a table are not narrowed below this."""

CELLS = re.compile(r"\S {2,}\S")
"""Two blanks inside a line: columns that belong to no table, which are not folded."""


def folded(text: str, width: int | None) -> str:
    """The text with sentences and tables folded at `width` columns; None folds nothing.

    >>> print(folded("noise floor 0.001 um rms from rests of the input", 24))
    noise floor 0.001 um rms
        from rests of the
        input
    >>> print(folded("cause  because\\n-----  -----------------------\\ncreep  the longest rest is 0 s", 24))
    cause  because
    -----  -----------------
    creep  the longest rest
           is 0 s
    """
    if width is None:
        return text
    lines = text.split("\n")
    made: list[str] = []
    at = 0
    while at < len(lines):
        if at + 1 < len(lines) and RULER.fullmatch(lines[at + 1]) and len(lines[at + 1]) > width:
            end = _end(lines, at + 1)
            made += _narrowed(lines[at], lines[at + 1], lines[at + 2 : end], width)
            at = end
            continue
        line = lines[at]
        at += 1
        if len(line) <= width or CELLS.search(line):
            made.append(line)
        else:
            made += textwrap.wrap(line, width, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return "\n".join(made)


def _spans(ruler: str) -> list[tuple[int, int]]:
    return [match.span() for match in re.finditer("-+", ruler)]


def _end(lines: Sequence[str], ruler: int) -> int:
    """The line behind the rows of a table: the first that is blank or writes between the columns."""
    spans = _spans(lines[ruler])
    for at in range(ruler + 1, len(lines)):
        line = lines[at]
        if not line.strip() or any(line[stop : stop + 2].strip() for _, stop in spans):
            return at
    return len(lines)


def _narrowed(header: str, ruler: str, rows: Sequence[str], width: int) -> list[str]:
    """The table with its widest columns of text narrowed until it fits; as it is if columns of numbers are too wide."""
    spans = _spans(ruler)
    cells = [[line[start:stop].rstrip() for start, stop in spans] for line in (header, *rows)]
    right = [all(len(row[j]) in (0, b - a) for row in cells) for j, (a, b) in enumerate(spans)]
    widths = [stop - start for start, stop in spans]
    text = [j for j, is_right in enumerate(right) if not is_right]
    while sum(widths) + 2 * (len(widths) - 1) > width:
        widest = max(text, key=lambda j: widths[j], default=None)
        if widest is None or widths[widest] <= NARROWEST:
            return [header, ruler, *rows]
        widths[widest] -= 1
    made: list[str] = []
    for number, row in enumerate(cells):
        parts = [
            textwrap.wrap(cell.strip(), w, break_on_hyphens=False) or [""] for cell, w in zip(row, widths, strict=True)
        ]
        for line in range(max(map(len, parts))):
            pieces = [part[line] if line < len(part) else "" for part in parts]
            placed = (
                piece.rjust(w) if is_right else piece.ljust(w)
                for piece, w, is_right in zip(pieces, widths, right, strict=True)
            )
            made.append("  ".join(placed).rstrip())
        if number == 0:
            made.append("  ".join("-" * w for w in widths))
    return made
