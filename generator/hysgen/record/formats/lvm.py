"""LabVIEW measurement files (LVM): a file header, then parts, each with a header of its own, column names and rows.

A header is lines `key<separator>value ...` up to `***End_of_Header***`. `X_Columns` says whether the rows have one
column of times (One), one before each channel (Multi), or none (No).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.formats.base import FileArrays, Format
from hysgen.record.spelling import UnreadableError, values_of
from hysgen.record.text import text_of

MARK: Final = "LabVIEW Measurement"
END: Final = "***End_of_Header***"
X: Final = "X_Value"


def read_lvm(path: Path) -> FileArrays:
    """Columns as "part/name", or "name" if the file has one part; the period only where no column holds the times.

    Raises RecordError with line and cure for a row that is no numbers.
    """
    source = path.name
    lines = text_of(source, path.read_bytes())[0].splitlines()
    end = next((at for at, line in enumerate(lines) if line.startswith(END)), None)
    if end is None:
        raise RecordError(f"{source}: has no line {END}; save it again")
    head = lines[:end]
    separator = "," if any(line.lower().startswith("separator") and "comma" in line.lower() for line in head) else "\t"
    stated = {fields[0]: fields[1:] for fields in (line.split(separator) for line in head)}
    comma = stated.get("Decimal_Separator", ["."])[0] == ","
    every = (stated.get("X_Columns") or ["One"])[0].strip().lower()
    parts = list(_parts(source, lines, end + 1, separator))
    arrays: dict[str, NDArray[np.float64]] = {}
    units: dict[str, str] = {}
    periods = set()
    for number, part in enumerate(parts, 1):
        prefix = f"part{number}/" if len(parts) > 1 else ""
        names = [name.strip() for name in part.names]
        at = [place for place, name in enumerate(names) if name and name not in (X, "Comment")]
        rows = _numbers(source, part, [names.index(X), *at] if X in names and every != "no" else at, comma)
        if X in names and every != "no":
            arrays[prefix + X], rows = rows[:, 0], rows[:, 1:]
        labels = part.head.get("Y_Unit_Label", [])
        for channel, place in enumerate(at):
            arrays[prefix + names[place]] = rows[:, channel]
            if channel < len(labels) and labels[channel].strip():
                units[prefix + names[place]] = labels[channel].strip()
        periods |= {float(step.replace(",", ".")) for step in part.head.get("Delta_X", []) if step.strip()}
    timed = any(X in key for key in arrays)
    return FileArrays(arrays, units, periods.pop() if len(periods) == 1 and not timed else None)


@dataclass(frozen=True)
class _Part:
    """head: values by key; names: of the columns; first: line of the first row, from 0; rows: their fields."""

    head: Mapping[str, Sequence[str]]
    names: Sequence[str]
    first: int
    rows: Sequence[Sequence[str]]


def _parts(source: str, lines: Sequence[str], start: int, separator: str) -> Iterator[_Part]:
    at = start
    while at < len(lines):
        head: dict[str, Sequence[str]] = {}
        while at < len(lines) and not lines[at].startswith(END):
            fields = lines[at].split(separator)
            head[fields[0].strip()] = fields[1:]
            at += 1
        if at + 1 >= len(lines):
            return
        names, first = lines[at + 1].split(separator), at + 2
        at = first
        while at < len(lines) and lines[at].strip() and not lines[at].startswith("Channels"):
            at += 1
        if at == first:
            raise RecordError(f"{source}: line {first}: a header without rows; record some samples")
        yield _Part(head, names, first, [line.split(separator) for line in lines[first:at]])


def _numbers(source: str, part: _Part, columns: Sequence[int], comma: bool) -> NDArray[np.float64]:
    """The numbers of some columns, (rows, columns); a last row that is cut short is left out."""
    rows = part.rows
    if len(rows) > 1 and len(rows[-1]) <= max(columns):
        rows = rows[:-1]
    values = []
    for at in columns:
        try:
            values.append(values_of([fields[at] if at < len(fields) else "" for fields in rows], comma))
        except UnreadableError as fault:
            where = f"{source}: line {part.first + fault.row + 1}: {part.names[at].strip()}"
            raise RecordError(f"{where} is {fault}; {fault.cure or 'correct it'}") from fault
    return np.column_stack(values)


FORMAT = Format("lvm", lambda path, head: head.startswith(MARK.encode()), read_lvm)
