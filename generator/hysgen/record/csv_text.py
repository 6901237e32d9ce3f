"""Conversion between CSV text and columns of numbers.

NumPy's compiled reader parses the text. If it fails, a slow reader parses line by line and reports the line, the column
and the fault.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.columns import SEPARATORS, Columns

COMMENT = "#"


@dataclass(frozen=True, eq=False)
class CsvTable:
    """Columns of a CSV file.

    names: of all columns, numeric or not. columns: (n,) numbers by name.
    locate: row number to "line 12". remarks: one line each, for the user.
    """

    names: tuple[str, ...]
    columns: dict[str, NDArray[np.float64]]
    locate: Callable[[int], str]
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class _Layout:
    """Layout of a CSV text.

    names: of all columns. separator: one character. body: the text after the header. first: line number of its start.
    """

    source: str
    names: tuple[str, ...]
    separator: str
    body: str
    first: int

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Line number, from 1, and fields of every data line."""
        for number, line in enumerate(io.StringIO(self.body), self.first):
            if _is_data(line):
                yield number, _split(line, self.separator)

    def locate(self, row: int) -> str:
        return next(f"line {number}" for position, (number, _) in enumerate(self.rows()) if position == row)


def read_csv(path: Path, columns: Columns) -> CsvTable:
    """The numeric columns of a CSV file, in the units of the file.

    Accepted: a byte order mark, CRLF, blank lines, comments after '#', quotes, a header after '#'.
    Columns whose first value is not a number are left out with a remark, unless `columns` names them.
    Raises RecordError with file, line, column and cure.
    """
    layout = _layout(path.name, _text(path), columns)
    first_row = next((fields for _, fields in layout.rows()), None)
    if first_row is None:
        raise RecordError(f"{layout.source}: holds a header and no rows; record some samples")
    comma = columns.decimal == "," or (
        columns.decimal is None and layout.separator != "," and any("," in one for one in first_row)
    )
    wanted = {columns.time, columns.voltage, columns.displacement, columns.segment}
    wanted.update(name for _, name in columns.aux_pairs() or ())
    use, remarks = [], []
    for position, name in enumerate(layout.names):
        value = first_row[position] if position < len(first_row) else ""
        if name in wanted or (name and _number(value, comma) is not None):
            use.append(position)
        elif name:
            remarks.append(f"{layout.source}: column {name} holds '{value}', not numbers, and is left out")
    values = _parse(layout, use, comma)
    table = {layout.names[position]: values[:, place] for place, position in enumerate(use)}
    return CsvTable(tuple(filter(None, layout.names)), table, layout.locate, tuple(remarks))


def write_csv(columns: Mapping[str, Sequence[float]]) -> str:
    """CSV text of equally long columns; every number reads back as the same float64."""
    body = zip(*(map(repr, values) for values in columns.values()), strict=True)
    return "\n".join((",".join(columns), *map(",".join, body), ""))


def _text(path: Path) -> str:
    data = path.read_bytes()
    if not data.strip():
        raise RecordError(f"{path.name}: is empty; record some samples")
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise RecordError(f"{path.name}: is UTF-16 text; save it as UTF-8")
    if b"\0" in data[:65536]:
        raise RecordError(
            f"{path.name}: is binary, not CSV text; export it as CSV, or give it the suffix of its format"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older loggers write the micro sign of a header in Latin-1, in which every byte is valid.
        text = data.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def _layout(source: str, text: str, columns: Columns) -> _Layout:
    """The layout. Its header is the first line that is no comment, or the last comment before the first numbers."""
    end, header, remark = 0, "", ""
    for number, line in enumerate(io.StringIO(text), 1):  # noqa: B007 the line number is used behind the loop
        if _is_data(line):
            header = line
            break
        end += len(line)
        remark = line.strip().lstrip(COMMENT) or remark
    if not header:
        raise RecordError(f"{source}: holds only comments; record some samples")
    if not _starts_with_number(header):
        end, number = end + len(header), number + 1
    elif columns.voltage in remark:
        header = remark
    else:
        raise RecordError(
            f"{source}: line {number}: holds numbers where the names belong; "
            f"put a first line such as {columns.time},{columns.voltage},{columns.displacement}"
        )
    named = columns.separator or max(",;\t", key=header.count)
    separator = SEPARATORS.get(named, named)
    names = tuple(_split(header, separator))
    for name in names:
        if name and names.count(name) > 1:
            raise RecordError(f"{source}: the header names {name} twice; rename one of the two columns")
    return _Layout(source, names, separator, text[end:], number)


def _split(line: str, separator: str) -> list[str]:
    """The fields of one line, without quotes and without a comment at its end."""
    line = line.partition(COMMENT)[0].strip(" \r\n")
    if separator == " ":
        return line.split()
    fields = next(csv.reader([line], delimiter=separator)) if '"' in line else line.split(separator)
    return [one.strip() for one in fields]


def _parse(layout: _Layout, use: Sequence[int], comma: bool) -> NDArray[np.float64]:
    """Columns `use` as (n, len(use)); by the slow reader where the fast one fails or may have missed a fault."""
    values = _fast(layout, use, comma)
    if values is None:
        return _slow(layout, use, comma)
    if len(use) == len(layout.names):
        regular = values.shape[1] == len(layout.names)
    else:
        # If columns are left out, the fast reader does not detect rows of the wrong length.
        regular = layout.body.count(layout.separator) == values.shape[0] * (len(layout.names) - 1)
    return values if regular else _slow(layout, use, comma)


def _fast(layout: _Layout, use: Sequence[int], comma: bool) -> NDArray[np.float64] | None:
    """The numbers by NumPy's compiled reader, or None if it fails: its messages name no line and no column."""
    try:
        return np.loadtxt(
            io.StringIO(layout.body.replace(",", ".") if comma else layout.body),
            dtype=np.float64,
            comments=COMMENT,
            delimiter=None if layout.separator == " " else layout.separator,
            usecols=None if len(use) == len(layout.names) else use,
            quotechar='"' if '"' in layout.body else None,
            ndmin=2,
        )
    except ValueError:
        return None


def _slow(layout: _Layout, use: Sequence[int], comma: bool) -> NDArray[np.float64]:
    """The numbers by Python, one line at a time. Raises RecordError at the first fault, with its line and column."""
    table = []
    for number, fields in layout.rows():
        if len(fields) != len(layout.names):
            raise RecordError(
                f"{layout.source}: line {number}: has {len(fields)} fields, the header has {len(layout.names)}; "
                "complete the row"
            )
        row = []
        for position in use:
            value = _number(fields[position], comma)
            if value is None:
                shown = f"'{fields[position]}', not a number" if fields[position] else "empty"
                raise RecordError(f"{layout.source}: line {number}: {layout.names[position]} is {shown}; correct it")
            row.append(value)
        table.append(row)
    return np.array(table, dtype=np.float64)


def _number(text: str, comma: bool) -> float | None:
    """The number in `text`, or None. An underscore, which Python's float accepts, is not allowed."""
    try:
        return float(text.replace(",", ".") if comma else text) if "_" not in text else None
    except ValueError:
        return None


def _starts_with_number(line: str) -> bool:
    start = line.partition(";")[0].partition("\t")[0].partition(",")[0].strip(' "')
    return _number(start, comma=False) is not None


def _is_data(line: str) -> bool:
    """Neither blank nor a comment."""
    stripped = line.lstrip()
    return bool(stripped) and not stripped.startswith(COMMENT)
