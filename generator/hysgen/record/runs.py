"""From the content of a file or of a DataFrame to the parts of a record: runs in V and um, and their checks."""

import contextlib
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import pairwise, starmap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError, nearest
from hysgen.record.arrays import chosen_arrays, find, key_of
from hysgen.record.checks import check_finite, check_marks, check_values
from hysgen.record.columns import Columns
from hysgen.record.derived_channels import left_out
from hysgen.record.formats import FileArrays
from hysgen.record.formats.base import Array, Series, collected
from hysgen.record.names import doubts as doubts_of_units
from hysgen.record.relation import held, rate, relation, scale
from hysgen.record.sampling import GAP, JITTER, gap_rows, mended, rounding_line, sampling_period
from hysgen.record.segment import NO_STAMPS, Origin, Segment, series_of
from hysgen.record.wrong_readings import sound


def shifted(run: Segment, rows: int) -> Segment:
    """The run with the displacement taken `rows` later than it was written, earlier if negative.

    Raises RecordError if no row is left.
    """
    count = run.samples - abs(rows)
    if count <= 0:
        raise RecordError(f"{run.origin.source}: shift={rows} leaves no row of {run.samples}; give fewer rows")
    start = max(rows, 0)
    return replace(run.part(start, start + count), y_um=run.y_um[max(-rows, 0) :][:count])


def _at_headers(run: Segment, starts: Sequence[int]) -> Iterator[Segment]:
    """The parts of the run between repeated headers; where the time goes on by one step, the part does."""
    bounds = [0, run.samples]
    for row in starts:
        steps = np.diff(run.stamps_s[max(row - 2, 0) : row + 2])
        if not (steps.size and steps.min() > 0.0 and steps.max() < GAP * steps.min()):
            bounds.insert(-1, row)
    for number, (start, stop) in enumerate(pairwise(bounds)):
        yield run if len(bounds) == 2 else run.part(start, stop, str(number))


def runs_of_arrays(source: str, file: FileArrays, columns: Columns, Ts_s: float | None = None) -> list[Segment]:
    """The runs of arrays or of a table. Ts_s: sampling period, if it is known otherwise; then no time is needed.

    Groups that hold the same names are segments, if the names are given without a group.
    Raises RecordError for an array that is missing, of another length, or of several axes without a selection.
    """
    arrays = file.arrays
    groups = _groups(arrays, columns)
    if len(groups) > 1:
        return [
            replace(run, name=group if run.name == "0" else f"{group}:{run.name}")
            for group in groups
            for run in runs_of_arrays(source, replace(file, arrays=_inside(arrays, group)), columns, Ts_s)
        ]
    series = partial(find, source, file, columns)
    u, y = series("voltage", columns.voltage), series("displacement", columns.displacement)
    time = None
    beside = f"{(key_of(arrays, columns.voltage) or '').rpartition('/')[0]}/{columns.time}"
    if beside in arrays:
        columns = replace(columns, time=beside)
    there = any(key_of(arrays, name) for name in (columns.time, columns.time.partition("[")[0]))
    if columns.time and (there or Ts_s is None):
        time = _as_many(source, columns.time, series("time", columns.time), len(u))
    pairs = _neighbours(file, columns) if (pairs := columns.aux_pairs()) is None else pairs
    aux = {label: _as_many(source, name, series("aux", name), len(u)) for label, name in pairs}
    if len(y) != len(u):
        raise RecordError(
            f"{source}: '{columns.voltage}' selects {len(u)} series and '{columns.displacement}' {len(y)}; "
            "select the same segments from both"
        )
    runs = []
    for number, (label, values) in enumerate(u):
        locate = file.locate if len(u) == 1 else partial("segment {}, index {}".format, label)
        origin = Origin(source, columns.time, columns.voltage, columns.displacement, locate)
        stamps = NO_STAMPS
        if time is not None:
            stamps = columns.in_base_unit("time", series_of(source, columns.time, time[number]))
        u_V = columns.in_base_unit("voltage", series_of(source, columns.voltage, values))
        y_um = columns.in_base_unit("displacement", series_of(source, columns.displacement, y[number][1]))
        further = {name: series_of(source, name, values[number]) for name, values in aux.items()}
        runs.append(Segment(label, u_V, y_um, further, quantities=columns.quantities, stamps_s=stamps, origin=origin))
    if len(runs) > 1:
        return runs
    if key_of(arrays, columns.segment) is None and columns.segment == Columns.segment:
        return list(_at_headers(runs[0], file.starts))
    numbers = series_of(source, columns.segment, series("segment", columns.segment)[0][1])
    if numbers.size != runs[0].samples:
        raise RecordError(
            f"{source}: {columns.segment} has {numbers.size} samples, {columns.voltage} has {runs[0].samples}; "
            "number every sample"
        )
    return list(_at_numbers(runs[0], numbers, columns.segment))


def _groups(arrays: Mapping[str, Array], columns: Columns) -> list[str]:
    """The groups that hold voltage and displacement, in the order of the file; "" for names that are unique."""
    names = (columns.voltage, columns.displacement)
    if any("/" in name or key_of(arrays, name.partition("[")[0]) is not None for name in names):
        return []
    folders = dict.fromkeys(key.rpartition("/")[0] for key in arrays)
    return [folder for folder in folders if all(f"{folder}/{name}" in arrays for name in names)]


def _inside(arrays: Mapping[str, Array], group: str) -> dict[str, Array]:
    """The arrays of a group under their names in it, and scalars of the whole file."""
    inside = {key.removeprefix(f"{group}/"): array for key, array in arrays.items() if key.startswith(f"{group}/")}
    return {key: array for key, array in arrays.items() if "/" not in key and array.size == 1} | inside


def at_gaps(run: Segment) -> Iterator[Segment]:
    """The parts of the run between gaps in time."""
    if run.stamps_s.size < 2:
        yield run
        return
    bounds = [0, *gap_rows(run.stamps_s).tolist(), run.samples]
    for number, (start, stop) in enumerate(pairwise(bounds)):
        yield run.part(start, stop, run.name if len(bounds) == 2 else f"{run.name}.{number}")


def _at_numbers(run: Segment, numbers: NDArray[np.float64], column: str) -> Iterator[Segment]:
    """The parts of the run with one segment number each. Raises RecordError if a number occurs in two parts."""
    if not np.isfinite(numbers).all():
        row = int(np.argmin(np.isfinite(numbers)))
        raise RecordError(f"{run.origin.at(row)}: {column} is {numbers[row]}; number every row")
    bounds = [0, *(np.flatnonzero(np.diff(numbers)) + 1).tolist(), numbers.size]
    seen = set()
    for start, stop in pairwise(bounds):
        name = f"{numbers[start]:.9g}"
        if name in seen:
            raise RecordError(
                f"{run.origin.at(start)}: {column} {name} comes back after another; "
                "give each unbroken run its own number"
            )
        seen.add(name)
        yield run.part(start, stop, name)


def _neighbours(file: FileArrays, columns: Columns) -> tuple[tuple[str, str], ...]:
    """The other vectors in the folder of the voltage; none if the voltage is a selection. Of a table, all others."""
    voltage = key_of(file.arrays, columns.voltage)
    if voltage is None:
        return ()
    named = (columns.time, columns.voltage, columns.displacement, columns.segment, Columns.time)
    used = {key_of(file.arrays, name) for name in named if name}
    folder = voltage.rpartition("/")[0]
    return tuple(
        (key if file.names else key.rpartition("/")[2], key)
        for key, array in file.arrays.items()
        if key not in used
        and (file.names or key.rpartition("/")[0] == folder)
        and array.size > 1
        and np.squeeze(array).ndim == 1
        and array.dtype.kind in "fiub"
    )


def _as_many(source: str, name: str, series: Sequence[tuple[str, Array]], count: int) -> list[Array]:
    """One series for each of `count` segments; a single series is used for all."""
    if len(series) not in (1, count):
        raise RecordError(f"{source}: '{name}' selects {len(series)} series, the voltage {count}; select as many")
    return [series[number % len(series)][1] for number in range(count)]


DEFAULT = Columns()

Parts = tuple[list[Segment], float, str, tuple[str, ...]]
"""The arguments of `Record.from_segments`: segments, sampling period, source, warnings."""


@dataclass(frozen=True, eq=False)
class Content:
    """The runs of a file; columns as given or as guessed; remarks; the sampling period from the file or the user."""

    runs: list[Segment]
    columns: Columns
    remarks: tuple[str, ...]
    Ts_s: float | None


def columns_of(given: Columns | str | Mapping[str, Any] | None) -> Columns:
    """Columns from themselves, from the text of --columns, or from a mapping of the fields. Raises RecordError."""
    if given is None:
        return DEFAULT
    if isinstance(given, Columns):
        return given
    if isinstance(given, str):
        return Columns.from_text(given) if given else DEFAULT
    if isinstance(given, Mapping):
        known = [one.name for one in fields(Columns)]
        for key in given:
            if key not in known:
                raise RecordError(
                    f"columns: '{key}' is not known{nearest(str(key), known)}; choose from {', '.join(known)}"
                )
        return Columns(**given)
    raise RecordError(
        f"columns: a {type(given).__name__} is no description of columns; give Columns(...), text or a dict"
    )


def of_file_arrays(source: str, content: FileArrays, columns: Columns) -> Content:
    if not content.arrays:
        raise RecordError(f"{source}: holds no numeric arrays; save voltage and displacement as arrays of numbers")
    chosen, Ts_s, guess = chosen_arrays(source, content, columns)
    runs = runs_of_arrays(source, content, chosen, Ts_s)
    return Content(runs, chosen, (*content.remarks, *([guess] if guess else [])), Ts_s)


def parts_of_frame(frame: Any, columns: Columns | str | Mapping[str, Any] | None = None) -> Parts:
    """The parts of `Record.from_dataframe`."""
    if not hasattr(frame, "columns") or not hasattr(frame, "__getitem__"):
        raise RecordError(f"a {type(frame).__name__} is no DataFrame; give one, or Record.from_arrays(u_V, y_um, Ts_s)")
    arrays = {str(name): np.asarray(frame[name]) for name in frame.columns}
    index = getattr(frame, "index", None)
    if index is not None and type(index).__name__ != "RangeIndex":
        values = np.asarray(index)
        arrays["time" if values.dtype.kind in "mM" else str(index.name or "time")] = values
    for name, values in arrays.items():
        if values.dtype.kind in "OUT":
            with contextlib.suppress(ValueError, TypeError):
                arrays[name] = values.astype(np.float64)
    try:
        content = of_file_arrays("DataFrame", collected(starmap(Series, arrays.items())), columns_of(columns))
        return checked("DataFrame", content, JITTER, (), False)
    except RecordError as fault:
        # The option of the command line is an argument of Python.
        raise RecordError(re.sub(r'--columns (?:"([^"]*)"|([^\s;,]+))', r'columns="\1\2"', str(fault))) from fault


def checked(source: str, content: Content, jitter: float, accept: Collection[str], split_at_gaps: bool) -> Parts:
    """The parts of the record of a file's content, after the checks of time and values."""
    runs, columns, remarks, given_s = content.runs, content.columns, content.remarks, content.Ts_s
    units = [multiply / divide for multiply, divide in (columns.scale("time"), columns.scale("displacement"))]
    mends = [mended(run, *units) for run in runs]
    runs = [run for run, _ in mends]
    remarks = (*remarks, *(line for _, lines in mends for line in lines))
    multiply, divide = columns.scale("voltage")
    check_marks(runs, multiply / divide, units[1])
    for run in runs:
        check_finite(run)
    if split_at_gaps:
        runs = [part for run in runs for part in at_gaps(run)]
    if columns.shift:
        runs = [shifted(run, columns.shift) for run in runs]
    readings = sound(runs)
    runs, dropped = _with_channels(runs, source, columns)
    warnings = check_values(readings, accept)
    stamps = [run for run in runs if run.stamps_s.size]
    Ts_s = sampling_period(stamps, jitter, columns.Ts_s) if stamps else given_s
    if stamps and (line := rounding_line(stamps)) is not None:
        remarks = (*remarks, line)
    if Ts_s is None:
        raise RecordError(f"{source}: has no time and no sampling period; give --columns Ts_s=SECONDS")
    doubts = list(rate(source, Ts_s))
    if not any("exchanged" in line for line in warnings):
        doubts += relation(readings, Ts_s)
    doubts += held(readings, Ts_s)
    if columns.displacement_unit is None and not columns.quantities.other and columns.unit("displacement") == "um":
        doubts += scale(readings)
    segments = [
        Segment(run.name, run.u_V, run.y_um, run.aux, float(run.stamps_s[:1].sum()), quantities=columns.quantities)
        for run in runs
    ]
    named = (
        f"{source}: {line.removeprefix(f'{source}: ')}"
        for line in (*columns.remarks(), *doubts_of_units(columns), *remarks)
    )
    return segments, Ts_s, source, (*named, *dropped, *warnings, *doubts)


def _with_channels(runs: list[Segment], source: str, columns: Columns) -> tuple[list[Segment], tuple[str, ...]]:
    """The runs with the further columns that are channels, and a line for the others; all if the user names them."""
    without = left_out(runs) if columns.aux is None else {}
    if not without:
        return runs, ()
    lines = tuple(
        f"{source}: column {name} is left out, for {reason}; --columns aux={name} keeps it"
        for name, reason in without.items()
    )
    channels = [name for name in runs[0].aux if name not in without]
    return [replace(run, aux={name: run.aux[name] for name in channels}) for run in runs], lines
