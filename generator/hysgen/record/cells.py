"""The rows of a text table as cells with line numbers, and the numbers in its columns.

A line is a row if its first used cell is a value. A block of other lines

    that holds the header again    ends a part of the table; what follows is another part
    after the last row             is a footer, such as Max,54.2,4.1 or "End of measurement"
    anywhere else                  is a fault, which is reported with its line

A last row with fewer cells than the others was cut short and is left out. `spelling` alone says what a cell means;
NumPy's compiled reader is asked first, without comments, for it takes exactly the cells that Python's float takes.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.layout import Layout
from hysgen.record.spelling import UnreadableError, values_of

Floats = NDArray[np.float64]
Row = tuple[int, list[str]]
"""The number of a line, from 1, and its cells."""

MOST_FOOTER_LINES = 40
"""More lines than these after the last row are no footer: the table is damaged there."""

CURE = "correct it, or delete the row and read the rest with --split-at-gaps"


@dataclass(frozen=True, eq=False)
class Numbers:
    """values: (n, columns). locate: row number to "line 12". starts: rows before which the header stands again.
    remarks: one line for each kind of lines that are no rows."""

    values: Floats
    locate: Callable[[int], str]
    starts: tuple[int, ...] = ()
    remarks: tuple[str, ...] = ()


def numbers_of(layout: Layout, use: Sequence[int]) -> Numbers:
    """The numbers in the columns `use`. Raises RecordError at the first fault, with its line and column."""
    values = _compiled(layout, use)
    if values is not None:
        return Numbers(values, layout.locate)
    rows, starts, remarks = _rows(layout, use)
    fields = len(layout.names)
    if len(rows) > 1 and len(rows[-1][1]) < fields == len(rows[-2][1]):
        remarks.append(f"{layout.source}: the last line is cut short and is left out")
        rows.pop()
    for line, cells in rows:
        if len(cells) != fields:
            cure = "complete the row"
            if layout.separator == "," and len(cells) == 2 * fields:
                cure = "if its decimal signs are commas too, save it with semicolons between the columns"
            named = "header" if layout.headed else "first row"
            raise RecordError(
                f"{layout.source}: line {line}: has {len(cells)} fields, the {named} has {fields}; {cure}"
            )
    columns: list[Floats] = []
    faults: list[tuple[int, int, UnreadableError]] = []
    for position in use:
        try:
            columns.append(values_of([cells[position] for _, cells in rows], layout.comma))
        except UnreadableError as fault:
            faults.append((fault.row, position, fault))
    if faults:
        row, position, first = min(faults, key=lambda entry: entry[:2])
        where = f"{layout.source}: line {rows[row][0]}: {layout.names[position]}"
        raise RecordError(f"{where} is {first}; {first.cure or CURE}")
    return Numbers(np.column_stack(columns), lambda row: f"line {rows[row][0]}", tuple(starts), tuple(remarks))


def _compiled(layout: Layout, use: Sequence[int]) -> Floats | None:
    """The numbers by NumPy's reader, or None if it fails: its messages name no line and no column."""
    if layout.comma and layout.separator == ",":
        return None
    body = layout.body.replace(",", ".") if layout.comma else layout.body
    fields = len(layout.names)
    try:
        values = np.loadtxt(
            io.StringIO(body),
            comments=None,
            delimiter=None if layout.separator == " " else layout.separator,
            usecols=None if len(use) == fields else use,
            quotechar='"' if '"' in layout.body else None,
            ndmin=2,
        )
    except ValueError:
        return None
    if len(use) == fields:
        return values if values.shape[1] == fields else None
    # If columns are left out, the compiled reader does not detect rows of the wrong length.
    regular = layout.separator != " " and layout.body.count(layout.separator) == values.shape[0] * (fields - 1)
    return values if regular else None


def _rows(layout: Layout, use: Sequence[int]) -> tuple[list[Row], list[int], list[str]]:
    """The rows, the rows before which the header stands again, and remarks."""
    header, units = [*layout.names], [layout.units.get(name, "") for name in layout.names]
    rows: list[Row] = []
    starts: list[int] = []
    repeated: list[int] = []
    other: list[Row] = []
    for line, cells in layout.rows():
        place = use[0] if use and use[0] < len(cells) else 0
        if not layout.is_value(cells[place]):
            other.append((line, cells))
            continue
        if other:
            again = next((number for number, one in other if one == header), None)
            if again is not None or other[-1][1] == units:
                starts.append(len(rows))
                repeated.append(other[0][0] if again is None else again)
            else:
                rows += other
            other = []
        rows.append((line, cells))
    remarks = []
    if repeated:
        shown = ", ".join(map(str, repeated[:3])) + (", ..." if len(repeated) > 3 else "")
        remarks.append(
            f"{layout.source}: the header is repeated in line {shown}; a part whose time begins anew is a segment"
        )
    if other and rows and len(other) <= MOST_FOOTER_LINES:
        shown = layout.body.split("\n")[other[0][0] - layout.first].strip()
        remarks.append(
            f"{layout.source}: line {other[0][0]} and what follows is no row of numbers and is left out "
            f"('{shown[:40]}{'...' if len(shown) > 40 else ''}')"
        )
        other = []
    return rows + other, starts, remarks
