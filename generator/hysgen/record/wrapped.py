"""Rows that a program printed: each value with its name, or all values of a row in brackets.

    t=0.001, U=5.8 V, y=0.81      named values, also with ":" and as JSON objects, one a line
    [0.001, 5.8, 0.81]            lists, as Python and MATLAB print them

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


def unwrapped(source: str, text: str) -> tuple[str, tuple[str, ...]]:
    """The text as a table, and a remark if it was none; any other text as it is."""
    lines = [line.strip() for line in text.split("\n")]
    head = [line for line in lines if line][:LOOKED_AT]
    if len(head) < FEWEST:
        return text, ()
    named = [_named_values(line) for line in head]
    first = named[0]
    if (
        first
        and len(first) > 1
        and all(one and [name for name, _ in one] == [name for name, _ in first] for one in named)
    ):
        return _table_of_named(source, lines, [name for name, _ in first])
    if all(_bare(line) != line for line in head):
        return "\n".join(map(_bare, lines)), (f"{source}: the brackets around its rows are left out",)
    return text, ()


def _table_of_named(source: str, lines: list[str], names: list[str]) -> tuple[str, tuple[str, ...]]:
    """A header and the values; a line with other names stays as it is, for the reader of tables to report."""
    rows = []
    for line in lines:
        values = _named_values(line)
        alike = values is not None and [name for name, _ in values] == names
        rows.append(",".join(f'"{value}"' for _, value in values) if values and alike else line)
    remark = f"{source}: its rows name their values ({', '.join(names)}); messages count these names as line 1"
    return "\n".join([",".join(f'"{name}"' for name in names), *rows]), (remark,)


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
