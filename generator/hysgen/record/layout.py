"""The layout of a text table: preamble, header, row of units, separator, decimal sign, first row of numbers.

Where a line names the voltage and the displacement as `columns` does, that line is the header. Otherwise the rows of
numbers are found first: the first lines that split, with one separator and one decimal sign, into equally many fields
of which at least two are numbers; lines of a label and numbers give way to rows of numbers alone. The header is the
line before them that names most roles, unless the preamble has the names; a row of units may stand between.
"""

import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from hysgen.errors import RecordError
from hysgen.record.columns import SEPARATORS, Columns
from hysgen.record.header import (
    Start,
    below_header,
    header,
    labels_names,
    matching,
    preamble_of,
    unique,
    units_by_name,
)
from hysgen.record.spelling import (
    CANDIDATES,
    COMMENT,
    is_data,
    is_value,
    quantity,
    split,
    split_header,
    without_comment,
)

HEAD_LINES = 400
"""Lines in which the first row of numbers has to be found."""

ALIKE = 3
"""Consecutive rows of numbers that make the beginning of the table."""


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
    if lines and (line := re.fullmatch(r'"?sep=(.)"?', lines[0].strip())):
        given = given or line.group(1)
        # Offsets into the text are lengths of lines.
        lines[0] = COMMENT.ljust(len(line.group(0)))
    if not any(is_data(line) for line in lines):
        raise RecordError(f"{source}: holds only comments; record some samples")
    named, start = _named_header(lines, columns, given), None
    if named is None:
        at = next(i for i, line in enumerate(lines) if is_data(line))
        named = at, given or max(",;\t", key=lines[at].count)
        if given is None:
            _check_upright(source, lines, *named)
        start = _first_numbers(lines, columns, given)
        data = [line for line in lines if is_data(line)] if start is None and given is None else []
        if len(data) > 1 and all(sum(map(is_value, split(line, one))) < 2 for line in data for one in CANDIDATES):
            raise RecordError(
                f"{source}: line {at + 1}: holds no columns ('{lines[at].strip()[:40]}'); save time, voltage and "
                "displacement as columns, or give --columns separator=..."
            )
    names: tuple[str, ...] = ()
    top = 1
    if start is None:
        start, names = _below(lines, columns, *named)
        top = named[0]
    above = [i for i in range(start.at) if is_data(lines[i]) or without_comment(lines[i])]
    told = preamble_of([without_comment(line) for line in lines[: start.at]], start.separator, start.fields)
    units, known = told.units, names or unique(told.names)
    if names or not known:
        nearest, beside = header(lines, above, start)
        names, units = names or nearest, beside or units
    names = names or known
    by_name = units_by_name(names, units) if names and units else {}
    if not names and above and 2 * len(split(lines[above[-1]], start.separator)) == start.fields:
        raise RecordError(
            f"{source}: line {start.at + 1}: has {start.fields} fields, the header half as many; if its decimal signs "
            "are commas too, save it with semicolons between the columns"
        )
    skipped = start.at - 1 - top - bool(by_name)
    remarks = (f"{source}: the table begins in line {start.at + 1}",) if skipped > 0 and names else ()
    shown = names or tuple(str(position) for position in range(start.fields))
    body, first = text[sum(len(line) + 1 for line in lines[: start.at]) :], start.at + 1
    return Layout(source, shown, start.separator, body, first, start.comma, bool(names), by_name, told.Ts_s, remarks)


def _below(lines: list[str], columns: Columns, at: int, separator: str) -> tuple[Start, tuple[str, ...]]:
    """The first row below a header in line `at`, which may not be sound, and the names."""
    last = below_header(lines, at, separator)
    row = next((split(line, separator) for line in lines[last + 1 :] if is_data(line)), [])
    numbers = _first_numbers(lines[last + 1 :], columns, separator)
    comma = columns.decimal == "," if numbers is None else numbers.comma
    names = split_header(lines[at], separator)
    if len(names) != len(row) - 1 or not row[-1]:
        names = matching(lines[at], Start(last + 1, separator, comma, len(row))) or names
    return Start(last + 1, separator, comma, len(names)), unique(names)


def _named_header(lines: list[str], columns: Columns, given: str | None) -> tuple[int, str] | None:
    """Line and separator of the line that names the voltage and the displacement; it may be a comment."""
    for at, line in enumerate(lines):
        if columns.voltage in line and columns.displacement in line:
            for separator in [given] if given else CANDIDATES:
                fields = split_header(line, separator)
                if {columns.voltage, columns.displacement} <= set(fields):
                    if labels_names(fields):
                        return None  # the preamble gives the names
                    if is_data(line) or _numbers_follow(lines, at, separator, len(fields)):
                        return at, separator
                    break
    return None


def _numbers_follow(lines: list[str], at: int, separator: str, count: int) -> bool:
    """Whether the next row has `count` fields by this separator, and a number in one of them."""
    row = split(next((line for line in lines[at + 1 :] if is_data(line)), ""), separator)
    return len(row) == count and any(quantity(one, comma=separator != "," and "," in one) is not None for one in row)


def _first_numbers(lines: list[str], columns: Columns, given: str | None) -> Start | None:
    """The first row of numbers; of several separators, the one by which most fields of most rows are numbers."""
    best: tuple[float, int, bool, int] = (0.0, 0, False, 0)
    found = None
    for order, separator in enumerate([given] if given else CANDIDATES):
        for comma in (False, True) if columns.decimal is None else (columns.decimal == ",",):
            if comma and separator == "," and not any('"' in line for line in lines):
                continue
            start = _begin(lines, separator, comma)
            if start is None:
                continue
            at, fields, numeric, filled = start
            # Without a comma in each cell of a row, 100,000 is a number of six digits.
            decimals = comma and all("," in cell and "." not in cell for cell in split(lines[at], separator) if cell)
            rank = (numeric / filled, numeric, decimals, -order)
            if rank > best:
                best, found = rank, Start(at, separator, comma, fields)
    return found


def _begin(lines: list[str], separator: str, comma: bool) -> tuple[int, int, int, int] | None:
    """Line, fields, numeric fields and fields that are not empty of the first of ALIKE rows of numbers.

    Of several blocks of such rows, the first with the largest share of numbers.
    """
    data = [i for i, line in enumerate(lines) if is_data(line)]
    best: tuple[int, int, int, int] | None = None
    position = 0
    while position < len(data):
        rows = [split(lines[i], separator) for i in data[position : position + ALIKE]]
        counts = [sum(is_value(cell, comma) for cell in row) for row in rows]
        worded = {_worded(row, comma) for row in rows}
        if min(counts) < 2 or len({len(row) for row in rows}) > 1 or len(worded) > 1:
            position += 1
            continue
        filled = max(sum(map(bool, row)) for row in rows)
        if best is None or min(counts) / filled > best[2] / best[3]:
            best = data[position], len(rows[0]), min(counts), filled
        if best[2] == best[3]:
            break
        position += ALIKE
        while position < len(data):
            row = split(lines[data[position]], separator)
            alike = len(row) == len(rows[0]) and {_worded(row, comma)} == worded
            if not alike or sum(is_value(cell, comma) for cell in row) < 2:
                break
            position += 1
    return best


def _worded(row: Sequence[str], comma: bool) -> bool:
    """Whether a row begins with a word, as a setting does."""
    return not is_value(next(filter(None, row), ""), comma)


def _check_upright(source: str, lines: Sequence[str], at: int, separator: str) -> None:
    """Raise RecordError for a table that lies on its side, with one line for each channel."""
    count, fields = sum(map(is_data, lines)), len(split(lines[at], separator))
    if 2 <= count < HEAD_LINES // 20 and fields > 10 * count:
        raise RecordError(
            f"{source}: line {at + 1}: has {fields} fields, and there are {count} lines; "
            "transpose the table: one line for each sample"
        )


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
