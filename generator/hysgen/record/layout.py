"""The layout of a text table: preamble, header, row of units, separator, decimal sign, first row of numbers.

Where a line names the voltage and the displacement as `columns` does, that line is the header. Otherwise the rows of
numbers are found first: the first lines that split, with one separator and one decimal sign, into equally many fields
of which at least two are numbers. The line before them is the header, unless it is a row of units.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from hysgen.errors import RecordError
from hysgen.record.columns import SEPARATORS, UNITS, Columns, plain_unit
from hysgen.record.spelling import THOUSANDS, is_clock, number, quantity

COMMENT = "#"
COMMENTS = ("#", "%", "//", "!")
HEAD_LINES = 400
"""Lines in which the first row of numbers has to be found."""

ALIKE = 3
"""Consecutive rows of numbers that make the beginning of the table."""

CANDIDATES = ("\t", ";", ",", "|", " ")
RULER = re.compile(r"[\s|+:=,;-]*[-=]{3}[\s|+:=,;-]*")
"""A line drawn under a header."""


@dataclass(frozen=True)
class Layout:
    """Layout of a text.

    names: of all columns; "0", "1", ... without a header (`headed` False). separator: one character. comma: decimal
    comma. body: the text after the header, `first`: number of its first line. units: by name, from a row of units.
    Ts_s: sampling period in the preamble, if any. remarks: one line each.
    """

    source: str
    names: tuple[str, ...]
    separator: str
    body: str
    first: int
    comma: bool = False
    headed: bool = True
    units: dict[str, str] = field(default_factory=dict)
    Ts_s: float | None = None
    remarks: tuple[str, ...] = ()

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line number, from 1, and fields of every data line."""
        for position, line in enumerate(io.StringIO(self.body), self.first):
            if is_data(line):
                yield position, split(line, self.separator)

    def locate(self, row: int) -> str:
        """The line of a row of numbers."""
        return next(f"line {number}" for position, (number, _) in enumerate(self.rows()) if position == row)


def layout_of(source: str, text: str, columns: Columns) -> Layout:
    """The layout of a text. Raises RecordError for a text that is no table."""
    begin = text.lstrip()[:15].lower()
    if begin.startswith(("<!doctype", "<html", "<head")):
        raise RecordError(f"{source}: is a page of the web, not a table; download the file itself")
    if begin.startswith("{\\rtf"):
        raise RecordError(f"{source}: is RTF, not plain text; save it as plain text")
    if re.match(r"<[?\w]", begin):
        raise RecordError(f"{source}: is XML, not a table; export it as CSV")
    given = columns.separator and SEPARATORS.get(columns.separator, columns.separator)
    lines = _head(text)
    if lines and (told := re.fullmatch(r'"?sep=(.)"?', lines[0].strip())):
        given = given or told.group(1)
        # Offsets into the text are lengths of lines.
        lines[0] = COMMENT.ljust(len(told.group(0)))
    if not any(is_data(line) for line in lines):
        raise RecordError(f"{source}: holds only comments; record some samples")
    named = _named_header(lines, columns, given)
    if named is not None:
        at, separator = named
        names = split_header(lines[at], separator)
        return _made(source, text, lines, columns, at, names, separator)
    at = next(i for i, line in enumerate(lines) if is_data(line))
    separator = given or max(",;\t", key=lines[at].count)
    if given is None:
        _check_upright(source, lines, at, separator)
    start = _first_numbers(lines, columns, given)
    if start is None:
        if given is None and separator not in lines[at] and sum(map(is_data, lines)) > 1:
            raise RecordError(
                f"{source}: line {at + 1}: holds no columns ('{lines[at].strip()[:40]}'); save time, voltage and "
                "displacement as columns, or give --columns separator=..."
            )
        return _made(source, text, lines, columns, at, split_header(lines[at], separator), separator)
    return _around(source, text, lines, columns, start)


@dataclass(frozen=True)
class _Start:
    """The first row of numbers: its line, separator, decimal comma and number of fields."""

    at: int
    separator: str
    comma: bool
    fields: int


def _around(source: str, text: str, lines: list[str], columns: Columns, start: _Start) -> Layout:
    """The layout with the header, the row of units and the preamble before the first row of numbers."""
    above = [i for i in range(start.at) if lines[i].strip() and lines[i].strip() != COMMENT]
    preamble, Ts_s = _preamble(lines[: start.at])
    labels = next((line.split("\t")[1:] for line in lines[: start.at] if line.startswith("Y_Unit_Label\t")), [])
    remarks = []
    names: tuple[str, ...] = ()
    units: dict[str, str] = {}
    if len(preamble) == start.fields:
        names = preamble
    elif above:
        fields = _matching(lines[above[-1]], start)
        if fields and _are_units(fields) and len(above) > 1 and (before := _matching(lines[above[-2]], start)):
            names, units = before, _units_by_name(before, fields)
        elif fields and not all(re.fullmatch(r"[\d.,+-]*", one) for one in fields):
            names = fields
    if names and names[0] == "X_Value":
        units = {name: label for name, label in zip(names[1:], labels, strict=False) if label.strip()}
    headed = bool(names)
    if not headed:
        names = tuple(str(position) for position in range(start.fields))
    skipped = start.at - len(above[-1:]) - bool(units)
    if skipped > 1 and headed:
        remarks.append(f"{source}: the table begins in line {start.at + 1}")
    body = text[sum(len(line) + 1 for line in lines[: start.at]) :]
    _check_unique(source, names)
    found = Layout(source, names, start.separator, body, start.at + 1, start.comma, headed, units, Ts_s, tuple(remarks))
    return found


def _made(
    source: str, text: str, lines: list[str], columns: Columns, at: int, names: Sequence[str], separator: str
) -> Layout:
    """The layout with a known header in line `at`; a row of units may follow it."""
    _check_unique(source, names)
    units: dict[str, str] = {}
    labels = next((line.split("\t")[1:] for line in lines[:at] if line.startswith("Y_Unit_Label\t")), [])
    if names[0] == "X_Value":
        units = {name: label for name, label in zip(names[1:], labels, strict=False) if label.strip()}
    after = next((i for i in range(at + 1, len(lines)) if is_data(lines[i])), None)
    if after is not None and len(fields := split(lines[after], separator)) == len(names) and _are_units(fields):
        units = _units_by_name(names, fields)
        at = after
    row = next((split(lines[i], separator) for i in range(at + 1, len(lines)) if is_data(lines[i])), [])
    if len(names) == len(row) + 1 and names[-1].lower() in ("", "comment"):
        names = names[:-1]  # the column of remarks of LabVIEW, which rows leave out
    first = next((lines[i] for i in range(at + 1, len(lines)) if is_data(lines[i])), "")
    comma = columns.decimal == "," or (
        columns.decimal is None
        and (separator != "," or '"' in first)
        and any("," in one and not THOUSANDS[False].fullmatch(one) for one in split(first, separator))
    )
    body = text[sum(len(line) + 1 for line in lines[: at + 1]) :]
    _, Ts_s = _preamble(lines[:at])
    return Layout(source, tuple(names), separator, body, at + 2, comma, True, units, Ts_s)


def _named_header(lines: list[str], columns: Columns, given: str | None) -> tuple[int, str] | None:
    """Line and separator of the line that names the voltage and the displacement; it may be a comment."""
    for at, line in enumerate(lines):
        if columns.voltage in line and columns.displacement in line:
            bare = _without_comment(line)
            for separator in [given] if given else CANDIDATES:
                if {columns.voltage, columns.displacement} <= set(split_header(bare, separator)):
                    return (at, separator) if is_data(line) or _numbers_follow(lines, at, separator) else None
    return None


def _numbers_follow(lines: list[str], at: int, separator: str) -> bool:
    after = next((line for line in lines[at + 1 :] if is_data(line)), "")
    return any(quantity(one, comma=separator != "," and "," in one) is not None for one in split(after, separator))


def _first_numbers(lines: list[str], columns: Columns, given: str | None) -> _Start | None:
    """The first row of numbers; of several separators, the one by which most fields of most rows are numbers."""
    best: tuple[float, int, int] = (0.0, 0, 0)
    found = None
    for order, separator in enumerate([given] if given else CANDIDATES):
        for comma in (False, True) if columns.decimal is None else (columns.decimal == ",",):
            if comma and separator == "," and not any('"' in line for line in lines):
                continue
            start = _begin(lines, separator, comma)
            if start is None:
                continue
            at, fields, numeric, filled = start
            rank = (numeric / filled, numeric, -order)
            if rank > best:
                best, found = rank, _Start(at, separator, comma, fields)
    return found


def _begin(lines: list[str], separator: str, comma: bool) -> tuple[int, int, int, int] | None:
    """Line, fields, numeric fields and fields that are not empty of the first of ALIKE rows of numbers."""
    data = [i for i, line in enumerate(lines) if is_data(line)]
    for position, at in enumerate(data):
        rows = [split(lines[i], separator) for i in data[position : position + ALIKE]]
        counts = [sum(quantity(one, comma) is not None or is_clock(one) for one in row) for row in rows]
        if min(counts) >= 2 and len({len(row) for row in rows}) == 1:
            return at, len(rows[0]), min(counts), max(sum(map(bool, row)) for row in rows)
    return None


def _matching(line: str, start: _Start) -> tuple[str, ...]:
    """The fields of a line if they are as many as those of the rows; a trailing field may be missing or empty."""
    bare = _without_comment(line)
    separators = [start.separator, *(one for one in CANDIDATES if one != start.separator and start.separator == " ")]
    for separator in separators:
        fields = split_header(bare, separator)
        if len(fields) == start.fields + 1 and (not fields[-1] or fields[-1].lower() == "comment"):
            fields = fields[:-1]
        if len(fields) == start.fields - 1:
            fields = (*fields, "")
        if len(fields) == start.fields and any(fields):
            return fields
    return ()


def _are_units(fields: Sequence[str]) -> bool:
    """Whether the fields are units: all known ones, in brackets, or empty; at least one known."""
    bare = [one.strip("[]() ") for one in fields]
    known = [any(plain_unit(one) in units for units in UNITS.values()) for one in bare]
    bracketed = [one[:1] in "[(" and one[-1:] in "])" for one in fields]
    return any(known) and all(
        is_known or is_bracketed or one in ("", "-", "1")
        for is_known, is_bracketed, one in zip(known, bracketed, bare, strict=True)
    )


def _units_by_name(names: Sequence[str], fields: Sequence[str]) -> dict[str, str]:
    """The units of a row of units, without brackets."""
    return {name: unit.strip("[]() ") for name, unit in zip(names, fields, strict=True) if unit}


def _preamble(lines: Sequence[str]) -> tuple[tuple[str, ...], float | None]:
    """Column names and sampling period that a preamble gives: a GCS array of PI, the Delta_X of LabVIEW."""
    names: dict[int, str] = {}
    Ts_s = None
    for line in lines:
        bare = _without_comment(line)
        if name := re.match(r"NAME(\d+)\s*=\s*(.+)", bare):
            names[int(name.group(1))] = name.group(2).strip()
        elif period := re.match(r"(?:SAMPLE_TIME\s*=|Delta_X\t)\s*([-+\d.,eE]+)", bare):
            value = number(period.group(1), comma="," in period.group(1))
            Ts_s = value if value and value > 0.0 else None
    return tuple(names[key] for key in sorted(names)), Ts_s


def _check_upright(source: str, lines: Sequence[str], at: int, separator: str) -> None:
    """Raise RecordError for a table that lies on its side, with one line for each channel."""
    count, fields = sum(map(is_data, lines)), len(split(lines[at], separator))
    if 2 <= count < HEAD_LINES // 20 and fields > 10 * count:
        raise RecordError(
            f"{source}: line {at + 1}: has {fields} fields, and there are {count} lines; "
            "transpose the table: one line for each sample"
        )


def _check_unique(source: str, names: Sequence[str]) -> None:
    for name in names:
        if name and names.count(name) > 1:
            raise RecordError(f"{source}: the header names {name} twice; rename one of the two columns")


def _head(text: str) -> list[str]:
    """The first HEAD_LINES lines without their ends."""
    lines: list[str] = []
    start = 0
    while len(lines) < HEAD_LINES and start < len(text):
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        lines.append(text[start:end])
        start = end + 1
    return lines


def split(line: str, separator: str) -> list[str]:
    """The fields of one line, without quotes and without a comment at its end."""
    hash_at = re.search(r"(?:^|\s)#", line)
    line = (line[: hash_at.start()] if hash_at else line).strip(" \r\n")
    if separator == " ":
        return line.split()
    fields = next(csv.reader([line], delimiter=separator)) if '"' in line else line.split(separator)
    return [one.strip() for one in fields]


def split_header(line: str, separator: str) -> tuple[str, ...]:
    """The names of a header, which may be a comment."""
    return tuple(split(_without_comment(line), separator))


def _without_comment(line: str) -> str:
    bare = line.strip()
    mark = next((mark for mark in COMMENTS if bare.startswith(mark)), "")
    return bare[len(mark) :].strip(" ") if mark else line.strip(" \r\n")


def is_data(line: str) -> bool:
    """Neither blank, nor a comment, nor a ruler under a header."""
    stripped = line.lstrip()
    return bool(stripped.strip(" \t;,")) and not stripped.startswith(COMMENTS) and not RULER.fullmatch(stripped)
