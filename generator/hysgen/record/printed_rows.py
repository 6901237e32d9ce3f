"""Rows that a program wrote: each value with its name, or a whole row in brackets or quotes.

    t=0.001, U=5.8 V, y=0.81      named values, also with ":" and as JSON objects, one a line
    [0.001, 5.8, 0.81]            lists, as Python and MATLAB write them; data = [ ... ]; around all of them
    "0.001,5.8,0.81"              quotes around whole rows

They become a header and rows of values, which the reader of tables takes. What only a terminal prints is refused.
"""

from __future__ import annotations

import re

from hysgen.errors import RecordError

LOOKED_AT = 20
"""Lines that must have one of these forms before all lines are read so."""

FEWEST = 3
"""Rows below which a file is no record."""

_NAMED = re.compile(
    r"""["']?([^\W\d][^=:,;"']*?)["']?\s*[=:]\s*["']?([^,;="'\s]+(?:\s(?!\w+\s*[=:])[^\W\d]\w*)?)["']?"""
)
_BETWEEN = re.compile(r"[,;\s]*")
_BRACKETS = {"[": "]", "(": ")", "{": "}"}
_MATRIX = re.compile(r"(?:[^\W\d]\w*\s*=\s*)?[\[({]")
"""What stands before the first row of a matrix: data = [."""

_NUMBERS = re.compile(r"[-+\d.,;eE\s]*")
_QUOTED = re.compile(r'"[^"]*[,;\t][^"]*"')
_TERMINAL = {
    "colours": re.compile(r"\x1b\[[0-9;]*[A-Za-z]"),
    "frames": re.compile(r"[\u2500-\u257f]|\s*\+(?:[-=]+\+){2,}\s*"),
    "times of arrival": re.compile(r"\d\d?:\d\d:\d\d[.,]\d+\s*->"),
    "tabs written as a backslash and a t": re.compile(r"[^\t]*\\t[^\t]*\\t"),
}
"""What a terminal, a table printer or a serial monitor puts into a line, and no logger."""


def unwrapped(source: str, text: str) -> tuple[str, tuple[str, ...]]:
    """The text as a table, and a remark for each thing that was done; any other text as it is."""
    lines = [line.strip() for line in text.split("\n")]
    head = _head(lines)
    if len(head) < FEWEST:
        return text, ()
    _check_no_terminal(source, head)
    if all(_QUOTED.fullmatch(line) for line in head):
        return "\n".join(line.strip('"') for line in lines), (f"{source}: the quotes around its rows are left out",)
    named = [_named_values(line) for line in head]
    first = named[0]
    if (
        first
        and len(first) > 1
        and all(one and [name for name, _ in one] == [name for name, _ in first] for one in named)
    ):
        table, remark = _table_of_named(source, lines, [name for name, _ in first])
        return table, (remark,)
    bare = _matrix(lines)
    if bare is None and all(_bare(line) != line for line in head):
        bare = [_bare(line) for line in lines]
    if bare is not None:
        return "\n".join(bare), (f"{source}: the brackets around its rows are left out",)
    return text, ()


def _head(lines: list[str]) -> list[str]:
    return [line for line in lines if line.strip()][:LOOKED_AT]


def _check_no_terminal(source: str, head: list[str]) -> None:
    """Raise RecordError for lines that only a terminal prints, with the first of them."""
    for what, mark in _TERMINAL.items():
        if sum(mark.match(line) is not None for line in head) >= 2:
            bare = (_TERMINAL["colours"].sub("", line) for line in head)
            shown = " / ".join([line[:40] for line in bare if any(map(str.isalnum, line))][:FEWEST])
            raise RecordError(
                f"{source}: is what a terminal printed, with {what}, and no table ({shown}); write the values "
                "themselves, one row for each sample, with commas between them"
            )


def _matrix(lines: list[str]) -> list[str] | None:
    """The rows of one matrix over all lines, each in its line; None if the text is something else."""
    used = [at for at, line in enumerate(lines) if line]
    start = _MATRIX.match(lines[used[0]])
    if start is None or lines[used[-1]].rstrip(",; ")[-1:] not in _BRACKETS.values():
        return None
    made = [lines[used[0]][start.end() :], *lines[used[0] + 1 :]]
    made = [line.strip("[](){},; ") for line in made]
    head = _head(made)
    return [""] * used[0] + made if head and all(_NUMBERS.fullmatch(line) for line in head) else None


def _table_of_named(source: str, lines: list[str], names: list[str]) -> tuple[str, str]:
    """A header and the values; a line with other names stays as it is, for the reader of tables to report."""
    rows = []
    for line in lines:
        values = _named_values(line)
        alike = values is not None and [name for name, _ in values] == names
        rows.append(",".join(f'"{value}"' for _, value in values) if values and alike else line)
    remark = f"{source}: its rows name their values ({', '.join(names)}); messages count these names as line 1"
    return "\n".join([",".join(f'"{name}"' for name in names), *rows]), remark


def _named_values(line: str) -> list[tuple[str, str]] | None:
    """Names and values of a line; None if it contains anything else."""
    rest, found = _bare(line), []
    while rest:
        match = _NAMED.match(rest)
        if match is None:
            return None
        found.append((match.group(1).strip(), match.group(2)))
        after = rest[match.end() :]
        rest = after[_BETWEEN.match(after).end() :]  # type: ignore[union-attr]
        if rest and len(rest) == len(after):
            return None
    return found or None


def _bare(line: str) -> str:
    """The line without brackets around it, and without the comma or semicolon behind them."""
    inner = line.rstrip(",; ")
    return inner[1:-1].strip() if len(inner) > 2 and _BRACKETS.get(inner[0]) == inner[-1] else line
