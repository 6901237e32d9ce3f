"""Conversion between CSV text and columns of numbers.

NumPy's compiled reader parses the text. If it fails, a slow reader parses line by line and reports the line, the column
and the fault.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.columns import Columns, plain_unit, split_unit
from hysgen.record.exports import as_table
from hysgen.record.interludes import Parts, without_interludes
from hysgen.record.layout import Layout, layout_of
from hysgen.record.lines import COMMENT, split
from hysgen.record.names import ROLES, guessed, has_time
from hysgen.record.spelling import FORTRAN, MINUS, clock_seconds, in_unit, is_clock, number, quantity
from hysgen.record.text import text_of
from hysgen.record.wrapped import unwrapped


@dataclass(frozen=True, eq=False)
class CsvTable:
    """Columns of a text table.

    names: of all columns, numeric or not. columns: (n,) numbers by name. chosen: the columns of time, voltage and
    displacement, as given or as guessed. Ts_s: sampling period in the preamble, if any.
    locate: row number to "line 12". remarks: one line each, for the user. starts: rows before which the header stands
    again.
    """

    names: tuple[str, ...]
    columns: dict[str, NDArray[np.float64]]
    chosen: Columns
    Ts_s: float | None
    locate: Callable[[int], str]
    remarks: tuple[str, ...]
    starts: tuple[int, ...] = ()


def read_csv(source: str, data: bytes, columns: Columns) -> CsvTable:
    """The numeric columns of a text file, in the units of the file.

    Accepted: a byte order mark, UTF-16, CRLF, blank lines, comments after '#' or '%', quotes, a preamble, a row of
    units, units in the cells, a decimal comma, separators between thousands, Fortran exponents, times of day, no
    header, the header again, footers, a last line cut short, zero bytes at the end, named values, rows in brackets.
    Columns whose first value is not a number are left out with a remark, unless `columns` names them.
    Raises RecordError with file, line, column and cure.
    """
    text, padding = text_of(source, data)
    text, export = as_table(source, text)
    text, form = unwrapped(source, text)
    layout = layout_of(source, text, columns)
    first_row = next((fields for _, fields in layout.rows()), None)
    if first_row is None:
        raise RecordError(f"{layout.source}: holds a header and no rows; record some samples")
    given = columns
    stated_s = _stated_period(layout, columns)
    if stated_s is not None:
        columns = replace(columns, Ts_s=stated_s, time="")
    if layout.headed:
        columns, guess = guessed(columns, layout.names, source, layout.units)
    else:
        columns, guess = _by_position(columns, layout, source)
    _check_named_once(layout, columns, given)
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
    use, remarks = [], [*padding, *export, *form, *layout.remarks, *([guess] if guess else [])]
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
    values, parts = _parse(layout, use)
    remarks += parts.remarks
    table = {layout.names[position]: values[:, place] for place, position in enumerate(use)}
    table = _with_one_time(source, table, columns.time)
    names = tuple(filter(None, layout.names))
    return CsvTable(names, table, columns, layout.Ts_s, parts.layout.locate, tuple(remarks), parts.starts)


def write_csv(columns: Mapping[str, Sequence[float]]) -> str:
    """CSV text of equally long columns; every number reads back as the same float64."""
    body = zip(*(map(repr, values) for values in columns.values()), strict=True)
    return "\n".join((",".join(columns), *map(",".join, body), ""))


def _stated_unit(layout: Layout, first_row: Sequence[str], columns: Columns, role: str) -> str | None:
    """The unit of a role in the first row's cell or in the row of units. Raises RecordError if the name has another."""
    name = getattr(columns, role)
    position = layout.names.index(name) if name in layout.names else len(first_row)
    found = quantity(first_row[position], layout.comma) if position < len(first_row) else None
    if found is None or not found[1]:
        return layout.units.get(name)
    named = layout.units.get(name) or split_unit(name)[1]
    if named and plain_unit(named) != found[1]:
        raise RecordError(
            f"{layout.source}: {name} is in {named} by its name and in {found[1]} by its cells; correct one of the two"
        )
    return found[1]


def _check_one_row_a_sample(layout: Layout, columns: Columns) -> None:
    """Raises RecordError for a table with a value a row, and a column that says what the value is."""
    if {columns.voltage, columns.displacement} <= set(layout.names):
        return
    rows = [fields for _, (_, fields) in zip(range(50), layout.rows(), strict=False)]
    for at, name in enumerate(layout.names):
        held = sorted({fields[at] for fields in rows if at < len(fields)})
        if 2 <= len(held) < len(rows) // 2 and all(quantity(one, layout.comma) is None for one in held):
            raise RecordError(
                f"{layout.source}: column {name} names what each row holds ({', '.join(held[:6])}); "
                "give each its own column, one row for each sample (pivot the table)"
            )


def _stated_period(layout: Layout, columns: Columns) -> float | None:
    """The period that the preamble states, for a table without time; None where it is not needed."""
    if columns.Ts_s is not None or columns.time in layout.names:
        return None
    timed = has_time(layout.names, layout.units) if layout.headed else len(layout.names) > 2
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


def _with_one_time(source: str, table: dict[str, NDArray[np.float64]], time: str) -> dict[str, NDArray[np.float64]]:
    """The table without further columns of the same times. Raises RecordError if their times differ."""
    again = [name for name in table if time in table and name.removeprefix(time)[:1] == "." and name.startswith(time)]
    for name in again:
        apart = float(np.abs(table[name] - table[time]).max())
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
        rising = (
            None
            if columns.Ts_s is not None
            else next(
                (
                    name
                    for at, name in enumerate(layout.names)
                    if _rises_evenly([row[at] for row in rows if at < len(row)], layout)
                ),
                None,
            )
        )
        others = [name for name in layout.names if name != rising]
        if len(others) >= 2:
            roles = {"voltage": others[0], "displacement": others[1]} | ({"time": rising} if rising else {})
            chosen = columns.named(roles)
            pairs = ",".join(f"{role}={name}" for role, name in roles.items())
            return chosen, f'{source}: has no header; read as --columns "{pairs}" (columns counted from 0)'
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


def _parse(layout: Layout, use: Sequence[int]) -> tuple[NDArray[np.float64], Parts]:
    """Columns `use` as (n, len(use)), and the parts of the table that they are.

    By the slow reader where the fast one fails or may have missed a fault.
    """
    values = _fast(layout, use)
    if values is not None:
        return values, Parts(layout)
    parts = without_interludes(layout, use)
    cut = _without_cut_line(parts.layout)
    if cut is not None:
        remark = f"{layout.source}: the last line is cut short and is left out"
        parts = replace(parts, layout=cut, remarks=(*parts.remarks, remark))
    values = None if parts.layout is layout else _fast(parts.layout, use)
    return (_slow(parts.layout, use) if values is None else values), parts


def _without_cut_line(layout: Layout) -> Layout | None:
    """The layout without its last line, if that has fewer fields than the others; else None."""
    body = layout.body.rstrip("\n")
    start = body.rfind("\n") + 1
    last = body[start:]
    if start == 0 or not last.strip() or len(split(last, layout.separator)) >= len(layout.names):
        return None
    before = body[: start - 1]
    line = before[before.rfind("\n") + 1 :]
    if len(split(line, layout.separator)) != len(layout.names):
        return None
    return replace(layout, body=body[:start])


def _fast(layout: Layout, use: Sequence[int]) -> NDArray[np.float64] | None:
    """The numbers by NumPy's compiled reader, or None if it fails: its messages name no line and no column."""
    comments: str | list[str] = COMMENT if "%" not in layout.body else [COMMENT, "%"]
    if layout.comma and layout.separator == ",":
        return None
    body = layout.body.replace(",", ".") if layout.comma else layout.body
    if not body.isascii():
        body = body.translate(MINUS)
    if FORTRAN.search(body, 0, 1000):
        body = FORTRAN.sub("E", body)
    try:
        values = np.loadtxt(
            io.StringIO(body),
            dtype=np.float64,
            comments=comments,
            delimiter=None if layout.separator == " " else layout.separator,
            usecols=None if len(use) == len(layout.names) else use,
            quotechar='"' if '"' in layout.body else None,
            ndmin=2,
        )
    except ValueError:
        return None
    if len(use) == len(layout.names):
        return values if values.shape[1] == len(layout.names) else None
    # If columns are left out, the fast reader does not detect rows of the wrong length.
    if layout.separator == " ":
        return None
    regular = layout.body.count(layout.separator) == values.shape[0] * (len(layout.names) - 1)
    return values if regular else None


CURE = "correct it, or delete the row and read the rest with --split-at-gaps"


def _in_unit(layout: Layout, line: int, position: int, text: str, unit: str) -> float | None:
    """The number in a cell, in the unit of the column's first cell; None if it is none. Raises RecordError."""
    if not unit and (value := number(text, layout.comma)) is not None:
        return value
    found = quantity(text, layout.comma)
    if found is None:
        return None
    value = in_unit(*found, unit)
    if value is None:
        first = f"in {unit}" if unit else "without a unit"
        raise RecordError(
            f"{layout.source}: line {line}: {layout.names[position]} is '{text}', the first row is {first}; correct it"
        )
    return value


def _slow(layout: Layout, use: Sequence[int]) -> NDArray[np.float64]:
    """The numbers by Python, one line at a time. Raises RecordError at the first fault, with its line and column."""
    table: list[list[float]] = []
    clocks: dict[int, list[str]] = {}
    units: list[str] = []
    for line, fields in layout.rows():
        if len(fields) != len(layout.names):
            named = "header" if layout.headed else "first row"
            cure = "complete the row"
            if layout.separator == "," and len(fields) == 2 * len(layout.names):
                cure = "if its decimal signs are commas too, save it with semicolons between the columns"
            raise RecordError(
                f"{layout.source}: line {line}: has {len(fields)} fields, the {named} has {len(layout.names)}; {cure}"
            )
        if not table:
            found = [quantity(fields[position], layout.comma) for position in use]
            units = ["" if one is None else one[1] for one in found]
        row = []
        for place, position in enumerate(use):
            value = _in_unit(layout, line, position, fields[position], units[place])
            if value is None and is_clock(fields[position]):
                clocks.setdefault(place, []).append(fields[position])
                value = 0.0
            if value is None:
                shown, cure = f"'{fields[position]}', not a number" if fields[position] else "empty", CURE
                if fields[position][:2].lower() == "0x":
                    shown = f"'{fields[position]}', a hexadecimal number"
                    cure = "write decimal numbers, in the unit of the column"
                raise RecordError(f"{layout.source}: line {line}: {layout.names[position]} is {shown}; {cure}")
            row.append(value)
        table.append(row)
    values = np.array(table, dtype=np.float64)
    for place, texts in clocks.items():
        if len(texts) != len(table):
            name = layout.names[use[place]]
            raise RecordError(
                f"{layout.source}: {name} is a time of day in {len(texts)} of {len(table)} rows; correct it"
            )
        values[:, place] = clock_seconds(texts)
    return values
