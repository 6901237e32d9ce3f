"""Reading a record from files: choice of the reader, checks of time and values, joining of files."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.array_names import chosen_arrays
from hysgen.record.checks import check_finite, check_values
from hysgen.record.columns import Columns, nearest
from hysgen.record.csv_text import read_csv, write_csv
from hysgen.record.data import Record
from hysgen.record.formats import FileArrays, open_checked
from hysgen.record.further import kept, left_out
from hysgen.record.relation import rate, relation, scale
from hysgen.record.runs import RawRun, at_gaps, runs_of_arrays, runs_of_table
from hysgen.record.sampling import JITTER, Stamps, rounding_line, sampling_period
from hysgen.record.segment import Segment

DEFAULT = Columns()


def load_record(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    columns: Columns | str | Mapping[str, Any] = DEFAULT,
    *,
    jitter: float = JITTER,
    accept: Collection[str] = (),
    split_at_gaps: bool = False,
) -> Record:
    """Read a record from one file, or from several files as several segments.

    path: text (CSV, LVM, GCS array, ...), NPZ, NPY, MAT v5 or v7.3, HDF5, and with `hysgen[formats]` Excel, Parquet,
        Feather, TDMS, MDF4, UFF 58; each also packed by gzip or zip. The format is recognised by the content.
    columns: names, units and separators, the same for all files, as Columns, as a dict of its fields, or as the text of
        --columns; names that are not given are guessed (`names`).
    jitter: largest deviation of a time step, relative to the period.
    accept: refusals that become warnings, out of "constant", "saturation", "swapped".
    split_at_gaps: start a new segment after a gap in time instead of refusing it.

    Nothing in the files can run code. Raises RecordError with one line: file, row, field, fault and cure.
    """
    columns = columns_of(columns)
    if not 0.0 <= jitter < 1.0:
        raise RecordError(f"jitter: {jitter:g} is no share of the sampling period; choose 0 to below 1")
    if hasattr(path, "columns"):
        raise RecordError("a DataFrame is no file; give it to Record.from_dataframe")
    if hasattr(path, "read"):
        raise RecordError("an open file is no name of a file; give its path")
    try:
        paths = [Path(path)] if isinstance(path, (str, os.PathLike)) else [Path(one) for one in path]
    except TypeError as fault:
        raise RecordError(f"a {type(path).__name__} is no name of a file; give a path, or several") from fault
    records = []
    for one in paths:
        record = _load_file(one, columns, jitter, accept, split_at_gaps)
        records.append(record if len(paths) == 1 else _named_after(record, one.stem))
    if len(records) == 1:
        return records[0]
    joined = Record.joined(*records)
    return replace(joined, warnings=(*joined.warnings, *_repeated(paths, records)))


def _repeated(paths: Sequence[Path], records: Sequence[Record]) -> Iterator[str]:
    """A line for each file that holds the same samples as a file before it."""
    seen: dict[str, Path] = {}
    for path, record in zip(paths, records, strict=True):
        if record.digest in seen:
            yield f"{path.name}: holds the same samples as {seen[record.digest].name}; name each record once"
        seen.setdefault(record.digest, path)


def record_csv(record: Record) -> str:
    """The record as CSV text; `load_record` reads back the same numbers and the same digest.

    Columns time_s, voltage_V, displacement_um, the further channels, and segment (0, 1, ...) if there are several.
    """
    columns: dict[str, list[float]] = {"time_s": [], "voltage_V": [], "displacement_um": []}
    columns.update((name, []) for name in record.aux_names)
    if len(record.segments) > 1:
        columns["segment"] = []
    for number, segment in enumerate(record.segments):
        columns["time_s"].extend(segment.start_s + k * record.Ts_s for k in range(segment.samples))
        columns["voltage_V"].extend(segment.u_V.tolist())
        columns["displacement_um"].extend(segment.y_um.tolist())
        for name in record.aux_names:
            columns[name].extend(segment.aux[name].tolist())
        if "segment" in columns:
            columns["segment"].extend([number] * segment.samples)
    return write_csv(columns)


def record_of_frame(frame: Any, columns: Columns | str | Mapping[str, Any] | None = None) -> Record:
    """`Record.from_dataframe`."""
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
        content = _of_file_arrays("DataFrame", FileArrays(numeric), columns_of(columns))
        return _checked("DataFrame", content, JITTER, (), False)
    except RecordError as fault:
        raise RecordError(re.sub(r'--columns ("[^"]*"|[^\s;,]+)', _as_argument, str(fault))) from fault


def record_of(given: Any) -> Record:
    """A Record from itself, from a DataFrame, or from the name of a file. Raises RecordError for anything else."""
    if isinstance(given, Record):
        return given
    if isinstance(given, (str, os.PathLike)):
        return load_record(given)
    if hasattr(given, "columns"):
        return record_of_frame(given)
    raise RecordError(
        f"a {type(given).__name__} is no record; give a Record, a DataFrame or the name of a file, or make one with "
        "Record.from_arrays(u_V, y_um, Ts_s)"
    )


def _as_argument(option: re.Match[str]) -> str:
    """The option of the command line as the argument of Python."""
    return f'columns="{option.group(1).strip(chr(34))}"'


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


def _load_file(path: Path, columns: Columns, jitter: float, accept: Collection[str], split_at_gaps: bool) -> Record:
    return _checked(path.name, _content(path, columns), jitter, accept, split_at_gaps)


def _checked(source: str, content: _Content, jitter: float, accept: Collection[str], split_at_gaps: bool) -> Record:
    """The record of a file's content, after the checks of time and values."""
    runs, columns, remarks, given_s = content.runs, content.columns, content.remarks, content.Ts_s
    # Before the check of the time: channels of unequal length would be cut at the wrong rows.
    for run in runs:
        check_finite(run.channels)
    if split_at_gaps:
        runs = [part for run in runs for part in at_gaps(run)]
    if columns.shift:
        runs = [run.shifted(columns.shift) for run in runs]
    runs, dropped = _with_channels(runs, source, columns)
    warnings = check_values([run.channels for run in runs], accept)
    stamps = [Stamps(source, run.time_s, columns.time, run.channels.locate) for run in runs if run.time_s is not None]
    Ts_s = sampling_period(stamps, jitter, columns.Ts_s) if stamps else given_s
    if stamps and (line := rounding_line(stamps)) is not None:
        remarks = (*remarks, line)
    if Ts_s is None:
        raise RecordError(f"{source}: has no time and no sampling period; give --columns Ts_s=SECONDS")
    channels = [run.channels for run in runs]
    doubts = list(rate(source, Ts_s))
    if not any("exchanged" in line for line in warnings):
        doubts += relation(channels, Ts_s)
    if columns.displacement_unit is None and columns.unit("displacement") == "um":
        doubts += scale(channels)
    segments = []
    for run in runs:
        start_s = float(run.time_s[0]) if run.time_s is not None else 0.0
        segments.append(Segment(run.name, run.channels.u_V, run.channels.y_um, run.channels.aux, start_s))
    named = (f"{source}: {line.removeprefix(f'{source}: ')}" for line in (*columns.remarks(), *remarks))
    return Record.from_segments(segments, Ts_s, source, (*named, *dropped, *warnings, *doubts))


def _with_channels(runs: list[RawRun], source: str, columns: Columns) -> tuple[list[RawRun], tuple[str, ...]]:
    """The runs with the further columns that are channels, and a line for the others; all if the user names them."""
    without = left_out([run.channels for run in runs]) if columns.aux is None else {}
    if not without:
        return runs, ()
    lines = tuple(
        f"{source}: column {name} is left out, for {reason}; --columns aux={name} keeps it"
        for name, reason in without.items()
    )
    trimmed = [replace(run, channels=replace(run.channels, aux=kept(run.channels.aux, without))) for run in runs]
    return trimmed, lines


@dataclass(frozen=True, eq=False)
class _Content:
    """The runs of a file; columns as given or as guessed; remarks; the sampling period from the file or the user."""

    runs: list[RawRun]
    columns: Columns
    remarks: tuple[str, ...]
    Ts_s: float | None


def _content(path: Path, columns: Columns) -> _Content:
    if re.match(r"(https?|ftp):/", str(path)):
        raise RecordError(f"{path}: is an address, not a file; download it first and give its name")
    if path.is_dir():
        raise RecordError(f"{path}: is a folder; name the record in it")
    if path.is_symlink() and not path.exists():
        raise RecordError(f"{path}: is a link to {path.readlink()}, which is not there; check the link")
    if not path.exists() and "=" in path.name:
        raise RecordError(f"{path}: there is no such file; columns are named by --columns {path.name}")
    if not path.exists():
        there = [] if not path.parent.is_dir() else [one.name for one in path.parent.iterdir() if one.exists()]
        raise RecordError(f"{path}: there is no such file{nearest(path.name, there)}; check the name")
    try:
        content = open_checked(path)
    except OSError as fault:
        raise RecordError(f"{path}: cannot be read ({fault.strerror}); check its permissions") from fault
    if isinstance(content, bytes):
        table = read_csv(path.name, content, columns)
        return _Content(runs_of_table(path.name, table), table.chosen, table.remarks, table.chosen.Ts_s or table.Ts_s)
    return _of_file_arrays(path.name, content, columns)


def _of_file_arrays(source: str, content: FileArrays, columns: Columns) -> _Content:
    if not content.arrays:
        raise RecordError(f"{source}: holds no numeric arrays; save voltage and displacement as arrays of numbers")
    chosen, Ts_s, guess = chosen_arrays(source, content, columns)
    runs = runs_of_arrays(source, content.arrays, chosen, Ts_s)
    return _Content(runs, chosen, (*content.remarks, *([guess] if guess else [])), Ts_s)


def _named_after(record: Record, stem: str) -> Record:
    """The record with its segments named after the file, for messages about several files."""
    single = len(record.segments) == 1
    segments = (replace(one, name=stem if single else f"{stem}:{one.name}") for one in record.segments)
    return replace(record, segments=tuple(segments))
