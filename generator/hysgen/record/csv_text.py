"""From text to columns of numbers with roles and units, and from columns to text.

A line is a row if its first used cell is a value. A block of other lines

    that holds the header again    ends a part of the table; what follows is another part
    after the last row             is a footer, such as Max,54.2,4.1 or "End of measurement"
    anywhere else                  is a fault, which is reported with its line

A last row with fewer cells than the others was cut short and is left out. `spelling` alone says what a cell means;
NumPy's compiled reader is asked first, without comments, for it takes exactly the cells that Python's float takes.
"""

import io
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.checks import SHORTEST
from hysgen.record.columns import NONE, Columns, agreed
from hysgen.record.formats.base import Array, FileArrays, Text
from hysgen.record.header import unique
from hysgen.record.layout import Layout, layout_of
from hysgen.record.names import ROLES, by_place, guessed, roles_in
from hysgen.record.spelling import UnreadableError, is_clock, is_value, number, quantity, values_of
from hysgen.record.text import as_table, text_of


def read_csv(source: str, content: Text, columns: Columns, upto: int | None = None) -> tuple[FileArrays, Columns]:
    """The numeric columns of a text file, in the units of the file, and those of the roles, as given or as guessed.

    upto: number of rows that are read, None for all.

    Accepted: a byte order mark, UTF-16, CRLF, blank lines, comments after '#' or '%', quotes, a preamble, a row of
    units, units in the cells, a decimal comma, separators between thousands, Fortran exponents, times of day, no
    header, the header again, footers, a last line cut short, zero bytes at the end, named values, rows in brackets.
    Columns whose first value is not a number are left out with a remark, unless `columns` names them.
    Raises RecordError with file, line, column and cure.
    """
    text, padding = text_of(source, content.data)
    text, form = as_table(source, text)
    layout = layout_of(source, text, columns)
    if upto and (last := next(itertools.islice(layout.rows(), upto - 1, None), None)):
        layout = replace(layout, body="".join(itertools.islice(io.StringIO(layout.body), last[0] + 1 - layout.first)))
    first_row = next((fields for _, fields in layout.rows()), None)
    if first_row is None:
        raise RecordError(f"{layout.source}: holds a header and no rows; record some samples")
    layout, empty = _without_empty_columns(layout)
    given = columns
    stated_s = _stated_period(layout, columns)
    if stated_s is not None:
        columns = replace(columns, Ts_s=stated_s, time="")
    if layout.headed:
        columns, guess = guessed(columns, layout.names, source, layout.units)
    else:
        columns, guess = _by_position(columns, layout, source)
    _check_named_once(layout, columns, given)
    for role in ROLES:
        if (name := getattr(columns, role)) in empty:
            raise RecordError(f"{source}: {role} column {name} is empty in every row; name another: {role}=NAME")
    stated = {role: _stated_unit(layout, first_row, columns, role) for role in ROLES}
    units = {role: unit for role, unit in stated.items() if unit and getattr(columns, f"{role}_unit") is None}
    for role in ROLES:
        try:
            if role in units:
                columns.check_unit(role, units[role])
            columns.unit(role)
        except RecordError as fault:
            raise RecordError(f"{source}: {fault}") from fault
    columns = columns.named({}, units)
    _check_one_row_a_sample(layout, columns)
    wanted = {columns.time, columns.voltage, columns.displacement, columns.segment}
    wanted.update(name for _, name in columns.aux_pairs() or ())
    wanted.discard("")
    use, remarks = [], [*content.remarks, *padding, *form, *layout.remarks, *([guess] if guess else [])]
    remarks += (f"{source}: column {name} is empty in every row and is left out" for name in empty if layout.headed)
    if stated_s is not None:
        remarks.append(f"{source}: is sampled every {stated_s:g} s, as the lines above the table say")
    remarks += (
        f"{source}: {getattr(columns, role)} is read in {unit}, as its cells say"
        for role, unit in units.items()
        if layout.units.get(getattr(columns, role)) is None
    )
    for position, name in enumerate(layout.names):
        value = first_row[position] if position < len(first_row) else ""
        if name in wanted or (name and quantity(value, layout.comma) is not None):
            use.append(position)
        elif name and columns.aux is None:
            remarks.append(f"{layout.source}: column {name} holds '{value}', not numbers, and is left out")
    file = numbers_of(layout, use)
    table = _with_one_time(source, file.arrays, columns.time)
    return replace(file, arrays=table, remarks=(*remarks, *file.remarks)), columns


def write_csv(columns: Mapping[str, Sequence[float]]) -> str:
    """CSV text of equally long columns; every number reads back as the same float64."""
    body = zip(*(map(repr, values) for values in columns.values()), strict=True)
    return "\n".join((",".join(columns), *map(",".join, body), ""))


def _without_empty_columns(layout: Layout) -> tuple[Layout, tuple[str, ...]]:
    """The layout in which columns without a value in any row have no name, and their names."""
    empty = [at for at, name in enumerate(layout.names) if name]
    for _, fields in layout.rows():
        empty = [at for at in empty if at >= len(fields) or not fields[at]]
        if not empty:
            return layout, ()
    names = tuple("" if at in empty else name for at, name in enumerate(layout.names))
    return replace(layout, names=names), tuple(layout.names[at] for at in empty)


def _stated_unit(layout: Layout, first_row: Sequence[str], columns: Columns, role: str) -> str | None:
    """The unit of a role in the first row's cell or in the row of units. Raises RecordError if the name has another."""
    name = getattr(columns, role)
    position = layout.names.index(name) if name in layout.names else len(first_row)
    cell = quantity(first_row[position], layout.comma) if position < len(first_row) else None
    stated = {"the row of units": layout.units.get(name), "its cells": cell[1] if cell else None}
    return agreed(layout.source, name, stated)


def _check_one_row_a_sample(layout: Layout, columns: Columns) -> None:
    """Raises RecordError for a table with a value a row, and a column that says what the value is."""
    if {columns.voltage, columns.displacement} <= {*layout.names, NONE}:
        return
    every = [fields for _, fields in layout.rows()]
    rows = every[:50]
    for at, name in enumerate(layout.names):
        held = sorted({fields[at] for fields in rows if at < len(fields)})
        cells = [fields[at] for fields in every if at < len(fields)] or [""]
        blocks = [key for key, _ in itertools.groupby(cells)]
        again = cells.index(cells[0], 1) if cells[0] in cells[1:] else len(cells)
        repeats = SHORTEST <= again == len(set(cells)) < len(cells) and cells == (cells * 2)[again : again + len(cells)]
        numbered = 2 <= len(blocks) == len(set(blocks)) <= 16
        if len(layout.names) <= 3 and (numbered or repeats):
            what = (
                f"numbers what each row holds ({', '.join(blocks[:6])})" if numbered else f"repeats every {again} rows"
            )
            raise RecordError(
                f"{layout.source}: column {name} {what}: the channels "
                "stand one below the other; give each its own column, one row for each sample"
            )
        if 2 <= len(held) < len(rows) // 2 and all(quantity(one, layout.comma) is None for one in held):
            raise RecordError(
                f"{layout.source}: column {name} names what each row holds ({', '.join(held[:6])}); "
                "give each its own column, one row for each sample (pivot the table)"
            )


def _stated_period(layout: Layout, columns: Columns) -> float | None:
    """The period that the preamble states, for a table without time; None where it is not needed."""
    if columns.Ts_s is not None or columns.time in layout.names:
        return None
    timed = "time" in roles_in(layout.names, layout.units) if layout.headed else len(layout.names) > 2
    return None if timed else layout.Ts_s


def _check_named_once(layout: Layout, columns: Columns, given: Columns) -> None:
    """Raises RecordError for a voltage or displacement that was guessed and whose name stands twice."""
    for role in ("voltage", "displacement"):
        name = getattr(columns, role)
        if f"{name}.1" in layout.names and getattr(given, role) == getattr(Columns(), role):
            raise RecordError(
                f"{layout.source}: the header names {name} twice; rename one of the two columns, or choose one: "
                f'--columns "{role}={name}.1" is the second'
            )


def _with_one_time(source: str, table: Mapping[str, Array], time: str) -> dict[str, Array]:
    """The table without further columns of the same times. Raises RecordError if their times differ."""
    again = [name for name in table if time in table and name.removeprefix(time)[:1] == "." and name.startswith(time)]
    for name in again:
        apart = float(np.abs(np.subtract(table[name], table[time])).max())
        step = float(np.median(np.diff(table[time]))) if table[time].size > 1 else 0.0
        if apart > 0.5 * abs(step):
            raise RecordError(
                f"{source}: {time} and {name} differ by up to {apart:.3g}: the channels were sampled at different "
                "times; resample them to the same times"
            )
    return {name: values for name, values in table.items() if name not in again}


def _by_position(columns: Columns, layout: Layout, source: str) -> tuple[Columns, str]:
    """The roles of columns without names: time is the first that rises evenly, then voltage, then displacement."""
    own = Columns()
    if any(getattr(columns, role) in layout.names for role in ROLES):
        return columns, ""
    rows = [fields for _, (_, fields) in zip(range(200), layout.rows(), strict=False)]
    if columns.time in (own.time, "") and (columns.voltage, columns.displacement) == (own.voltage, own.displacement):
        cells = ((name, [row[at] for row in rows if at < len(row)]) for at, name in enumerate(layout.names) if name)
        even = (name for name, texts in cells if columns.Ts_s is None and _rises_evenly(texts, layout))
        chosen, option = by_place(columns, layout.names, next(even, None))
        if option:
            return chosen, f"{source}: has no header; read as {option} (columns counted from 0)"
    raise RecordError(
        f"{source}: line {layout.first}: holds numbers where the names belong; put a first line such as "
        f"{own.time},{own.voltage},{own.displacement}, or name columns by their place: "
        '--columns "time=0,voltage=1,displacement=2"'
    )


def _rises_evenly(texts: Sequence[str], layout: Layout) -> bool:
    if texts and all(is_clock(one) for one in texts):
        return True
    values = [number(one, layout.comma) for one in texts]
    if len(values) < 2 or any(value is None for value in values):
        return False
    steps = np.diff(np.array(values, dtype=np.float64))
    return bool(steps.min() >= 0.0 and steps.mean() > 0.0 and steps.max() < 3.0 * steps.mean())


Floats = NDArray[np.float64]
Row = tuple[int, list[str]]
"""The number of a line, from 1, and its cells."""

MOST_FOOTER_LINES = 40
"""More lines than these after the last row are no footer: the table is damaged there."""

CURE = "correct it, or delete the row and read the rest with --split-at-gaps"


def numbers_of(layout: Layout, use: Sequence[int]) -> FileArrays:
    """The numbers in the columns `use`, and a remark for each kind of lines that are no rows.

    Raises RecordError at the first fault, with its line and column.
    """
    names, used = tuple(filter(None, layout.names)), [layout.names[position] for position in use]
    values = _compiled(layout, use)
    if values is not None:
        return FileArrays(dict(zip(used, values.T, strict=True)), {}, layout.Ts_s, (), names, layout.locate)
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
    arrays = dict(zip(used, columns, strict=True))
    return FileArrays(arrays, {}, layout.Ts_s, tuple(remarks), names, lambda row: f"line {rows[row][0]}", tuple(starts))


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
        if not is_value(cells[place], layout.comma):
            other.append((line, cells))
            continue
        if other:
            again = next((number for number, one in other if [*unique(one)] == header), None)
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
