"""Rows that a program printed: each value with its name, or a whole row in brackets or quotes.

    t=0.001, U=5.8 V, y=0.81      named values, also with ":" and as JSON objects, one a line
    [0.001, 5.8, 0.81]            lists, as Python and MATLAB print them; data = [ ... ]; around all of them
    "0.001,5.8,0.81"              quotes around whole rows
    0.001\\t5.8\\t0.81             tabs as a backslash and a t; colours of a terminal
    12:00:00.001 -> 5.8,0.81      a serial monitor

They become a header and rows of values, which the reader of tables takes.
"""

from __future__ import annotations

import re

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
_COLOUR = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")
_ARRIVAL = re.compile(r"(\d\d?:\d\d:\d\d[.,]\d+)\s*->\s*(.*)")
"""The time at which a serial monitor received a line, and the line."""


def unwrapped(source: str, text: str) -> tuple[str, tuple[str, ...]]:
    """The text as a table, and a remark for each thing that was done; any other text as it is."""
    text, remarks = _plain(source, text)
    lines = [line.strip() for line in text.split("\n")]
    head = _head(lines)
    if len(head) < FEWEST:
        return text, remarks
    named = [_named_values(line) for line in head]
    first = named[0]
    if (
        first
        and len(first) > 1
        and all(one and [name for name, _ in one] == [name for name, _ in first] for one in named)
    ):
        table, remark = _table_of_named(source, lines, [name for name, _ in first])
        return table, (*remarks, remark)
    bare = _matrix(lines)
    if bare is None and all(_bare(line) != line for line in head):
        bare = [_bare(line) for line in lines]
    if bare is not None:
        return "\n".join(bare), (*remarks, f"{source}: the brackets around its rows are left out")
    return text, remarks


def _head(lines: list[str]) -> list[str]:
    return [line for line in lines if line.strip()][:LOOKED_AT]


def _plain(source: str, text: str) -> tuple[str, tuple[str, ...]]:
    """The text without colours, quotes around rows and times of arrival, with tabs for what stands for them."""
    remarks = []
    if "\x1b[" in text:
        text = _COLOUR.sub("", text)
        remarks.append(f"{source}: the colours of a terminal are left out")
    lines = text.split("\n")
    head = _head(lines)
    if len(head) < FEWEST:
        return text, tuple(remarks)
    if all("\\t" in line and "\t" not in line for line in head):
        text = text.replace("\\t", "\t")
        remarks.append(f"{source}: '\\t' is taken for a tab")
    elif all(_QUOTED.fullmatch(line.strip()) for line in head):
        text = "\n".join(line.strip().strip('"') for line in lines)
        remarks.append(f"{source}: the quotes around its rows are left out")
    elif all(_ARRIVAL.fullmatch(line.strip()) for line in head):
        text = "\n".join(_with_arrival(lines))
        remarks.append(f"{source}: the times before '->' are column 'time'")
    return text, tuple(remarks)


def _with_arrival(lines: list[str]) -> list[str]:
    """The lines of a serial monitor with the time as the first value; behind the name time if the line has names."""
    made = []
    for line in lines:
        match = _ARRIVAL.fullmatch(line.strip())
        if match is None:
            made.append(line)
            continue
        time, rest = match.groups()
        if _named_values(rest):
            made.append(f"time={time},{rest}")
        else:
            headed = not made and not _NUMBERS.fullmatch(rest)
            made.append(f"{'time' if headed else time}{',' if ',' in rest else chr(9)}{rest}")
    return made


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
