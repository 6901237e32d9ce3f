"""Reading a record from files: choice of the reader, checks of time and values, joining of files."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from hysgen.errors import RecordError
from hysgen.record.arrays import Array, read_hdf5, read_mat, read_npz
from hysgen.record.checks import check_finite, check_values
from hysgen.record.columns import Columns, nearest
from hysgen.record.csv_text import read_csv, write_csv
from hysgen.record.data import Record, Segment
from hysgen.record.further import kept, left_out
from hysgen.record.relation import rate, relation, scale
from hysgen.record.runs import RawRun, at_gaps, runs_of_arrays, runs_of_table, scalar_period
from hysgen.record.sampling import JITTER, Stamps, sampling_period

CSV_SUFFIXES = (".csv", ".txt", ".tsv", ".dat")
ARRAY_READERS: Mapping[str, Callable[[Path], dict[str, Array]]] = {
    ".npz": read_npz,
    ".mat": read_mat,
    ".h5": read_hdf5,
    ".hdf5": read_hdf5,
    ".hdf": read_hdf5,
}
SUFFIXES = (*CSV_SUFFIXES, *ARRAY_READERS)
DEFAULT = Columns()


def load_record(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    columns: Columns = DEFAULT,
    *,
    jitter: float = JITTER,
    accept: Collection[str] = (),
    split_at_gaps: bool = False,
) -> Record:
    """Read a record from one file, or from several files as several segments.

    path: CSV (.csv .txt .tsv .dat), NPZ, MAT v5 or v7.3, HDF5 (.h5 .hdf5 .hdf).
    columns: names, units and separators, the same for all files.
    jitter: largest deviation of a time step, relative to the period.
    accept: refusals that become warnings, out of "constant", "saturation", "swapped".
    split_at_gaps: start a new segment after a gap in time instead of refusing it.

    Nothing in the files can run code. Raises RecordError with one line: file, row, field, fault and cure.
    """
    paths = [Path(path)] if isinstance(path, (str, os.PathLike)) else [Path(one) for one in path]
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


def _load_file(path: Path, columns: Columns, jitter: float, accept: Collection[str], split_at_gaps: bool) -> Record:
    runs, remarks, given_s = _runs(path, columns)
    # Before the check of the time: channels of unequal length would be cut at the wrong rows.
    for run in runs:
        check_finite(run.channels)
    if split_at_gaps:
        runs = [part for run in runs for part in at_gaps(run)]
    runs, dropped = _with_channels(runs, path.name, columns)
    warnings = check_values([run.channels for run in runs], accept)
    stamps = [
        Stamps(path.name, run.time_s, columns.time, run.channels.locate) for run in runs if run.time_s is not None
    ]
    Ts_s = sampling_period(stamps, jitter, columns.Ts_s) if stamps else given_s
    if Ts_s is None:
        raise RecordError(f"{path.name}: has no time and no sampling period; give --columns Ts_s=SECONDS")
    channels = [run.channels for run in runs]
    doubts = list(rate(path.name, Ts_s))
    if not any("exchanged" in line for line in warnings):
        doubts += relation(channels, Ts_s)
    if columns.displacement_unit is None and columns.unit("displacement") == "um":
        doubts += scale(channels)
    segments = []
    for run in runs:
        start_s = float(run.time_s[0]) if run.time_s is not None else 0.0
        segments.append(Segment(run.name, run.channels.u_V, run.channels.y_um, run.channels.aux, start_s))
    named = (f"{path.name}: {line}" for line in (*columns.remarks(), *remarks))
    return Record.from_segments(segments, Ts_s, path.name, (*named, *dropped, *warnings, *doubts))


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


def _runs(path: Path, columns: Columns) -> tuple[list[RawRun], tuple[str, ...], float | None]:
    """The runs of a file, remarks about it, and the sampling period from its scalars or from the user, if any."""
    suffix = path.suffix.lower()
    if path.is_dir():
        raise RecordError(f"{path}: is a folder; name the record in it")
    if not path.exists():
        there = [one.name for one in path.parent.iterdir()] if path.parent.is_dir() else []
        raise RecordError(f"{path}: there is no such file{nearest(path.name, there)}; check the name")
    if suffix not in SUFFIXES:
        raise RecordError(
            f"{path.name}: the suffix '{suffix}' is not known; save the record as one of {' '.join(SUFFIXES)}"
        )
    try:
        if suffix in CSV_SUFFIXES:
            table = read_csv(path, columns)
            return runs_of_table(path.name, table, columns), table.remarks, columns.Ts_s
        arrays = ARRAY_READERS[suffix](path)
    except OSError as fault:
        raise RecordError(f"{path}: cannot be read ({fault.strerror}); check its permissions") from fault
    return runs_of_arrays(path.name, arrays, columns), (), columns.Ts_s or scalar_period(arrays)


def _named_after(record: Record, stem: str) -> Record:
    """The record with its segments named after the file, for messages about several files."""
    single = len(record.segments) == 1
    segments = (replace(one, name=stem if single else f"{stem}:{one.name}") for one in record.segments)
    return replace(record, segments=tuple(segments))
