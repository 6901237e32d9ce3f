"""From the content of a file or of a DataFrame to the parts of a record: columns, checks of time and values."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.array_names import chosen_arrays
from hysgen.record.checks import check_finite, check_marks, check_values
from hysgen.record.columns import Columns, nearest
from hysgen.record.derived_channels import kept, left_out
from hysgen.record.formats import FileArrays
from hysgen.record.names import doubts as doubts_of_units
from hysgen.record.overflow import mended
from hysgen.record.relation import held, rate, relation, scale
from hysgen.record.runs import at_gaps, runs_of_arrays, shifted
from hysgen.record.sampling import JITTER, rounding_line, sampling_period
from hysgen.record.segment import Segment
from hysgen.record.wrong_readings import sound

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
    runs = runs_of_arrays(source, content.arrays, chosen, Ts_s)
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
        if values.dtype.kind in "mM":
            stamps = values.astype("datetime64[ns]" if values.dtype.kind == "M" else "timedelta64[ns]")
            arrays[name] = (stamps - stamps[0]).astype(np.int64) * 1e-9
        elif values.dtype.kind in "OUT":
            with contextlib.suppress(ValueError, TypeError):
                arrays[name] = values.astype(np.float64)
    numeric = {name: values for name, values in arrays.items() if values.dtype.kind in "fiub"}
    try:
        content = of_file_arrays("DataFrame", FileArrays(numeric), columns_of(columns))
        return checked("DataFrame", content, JITTER, (), False)
    except RecordError as fault:
        raise RecordError(re.sub(r'--columns ("[^"]*"|[^\s;,]+)', _as_argument, str(fault))) from fault


def _as_argument(option: re.Match[str]) -> str:
    """The option of the command line as the argument of Python."""
    return f'columns="{option.group(1).strip(chr(34))}"'


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
    runs, dropped = _with_channels(runs, source, columns)
    readings = sound(runs)
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
    if columns.displacement_unit is None and columns.unit("displacement") == "um":
        doubts += scale(readings)
    segments = [Segment(run.name, run.u_V, run.y_um, run.aux, float(run.stamps_s[:1].sum())) for run in runs]
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
    return [replace(run, aux=kept(run.aux, without)) for run in runs], lines
