"""Reading a record from files: choice of the reader, joining of files."""

import os
import re
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, Final

from hysgen.errors import RecordError, nearest
from hysgen.record.columns import Columns
from hysgen.record.csv_text import read_csv, write_csv
from hysgen.record.data import Record
from hysgen.record.formats import FileArrays, Text, open_checked
from hysgen.record.relation import followers
from hysgen.record.runs import DEFAULT, Content, checked, columns_of, of_file_arrays, runs_of_arrays
from hysgen.record.sampling import JITTER


def load_record(
    path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    columns: Columns | str | Mapping[str, Any] = DEFAULT,
    *,
    jitter: float = JITTER,
    accept: Collection[str] = (),
    split_at_gaps: bool = False,
    upto: int | None = None,
) -> Record:
    """Read a record from one file, or from several files as several segments.

    path: text (CSV, LVM, GCS array, ...), NPZ, NPY, MAT v5 or v7.3, HDF5, and with `hysgen[formats]` Excel, Parquet,
        Feather, TDMS, MDF4, UFF 58; each also packed by gzip or zip. The format is recognised by the content.
    columns: names, units and separators, the same for all files, as Columns, as a dict of its fields, or as the text of
        --columns; names that are not given are guessed (`names`).
    jitter: largest deviation of a time step, relative to the period.
    accept: refusals that become warnings, out of "constant", "saturation", "swapped".
    split_at_gaps: start a new segment after a gap in time instead of refusing it.

    upto: row from which on a fault does not refuse a single file: these rows are then left out, and it is said.

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
        try:
            parts = checked(one.name, content_of(one, columns), jitter, accept, split_at_gaps)
        except RecordError as fault:
            if upto is None or len(paths) > 1:
                raise
            segments, Ts_s, source, said = checked(
                one.name, content_of(one, columns, upto), jitter, accept, split_at_gaps
            )
            parts = segments, Ts_s, source, (*said, f"{source}: the rows from {upto} on are left out: {fault}")
        record = Record.from_segments(*parts)
        records.append(record if len(paths) == 1 else _named_after(record, one.stem))
    if len(records) == 1:
        return records[0]
    joined = Record.joined(*records)
    return replace(joined, said=(*joined.said, *_repeated(paths, records)))


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
    numbered = record.columns(range(len(record.segments)))
    return write_csv({name: values.tolist() for name, values in numbered.items()})


def record_of(given: Any) -> Record:
    """A Record from itself, from a DataFrame, or from the name of a file. Raises RecordError for anything else."""
    if isinstance(given, Record):
        return given
    if isinstance(given, (str, os.PathLike)):
        return load_record(given)
    if hasattr(given, "columns"):
        return Record.from_dataframe(given)
    raise RecordError(
        f"a {type(given).__name__} is no record; give a Record, a DataFrame or the name of a file, or make one with "
        "Record.from_arrays(u_V, y_um, Ts_s)"
    )


def _opened(path: Path) -> Text | FileArrays:
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
        return open_checked(path)
    except OSError as fault:
        raise RecordError(f"{path}: cannot be read ({fault.strerror}); check its permissions") from fault


def content_of(path: Path, columns: Columns, upto: int | None = None) -> Content:
    """What a file holds, before the checks of time and values; of its first `upto` rows."""
    file = _opened(path)
    content = _content(path.name, file, columns, upto)
    chosen = content.columns.displacement
    if chosen == columns.displacement or len(better := [*followers(content.runs)]) != 1:
        return content
    # The name alone decided, and another column of the kind follows the voltage.
    content = _content(path.name, file, columns.named({"displacement": better[0]}), upto)
    said = f"{chosen} does not follow {content.columns.voltage}, {better[0]} does: read as displacement={better[0]}"
    return replace(content, remarks=(*content.remarks, said))


def _content(source: str, file: Text | FileArrays, columns: Columns, upto: int | None) -> Content:
    if not isinstance(file, Text):
        content = of_file_arrays(source, file, columns)
        return content if upto is None else replace(content, runs=[content.runs[0].part(0, upto), *content.runs[1:]])
    table, columns = read_csv(source, file, columns, upto)
    runs = runs_of_arrays(source, table, columns, columns.Ts_s)
    return Content(runs, columns, table.remarks, columns.Ts_s or table.Ts_s)


def _named_after(record: Record, stem: str) -> Record:
    """The record with its segments named after the file, for messages about several files."""
    single = len(record.segments) == 1
    segments = (replace(one, name=stem if single else f"{stem}:{one.name}") for one in record.segments)
    return replace(record, segments=tuple(segments))


BUNDLED: Final = "demo_stage.csv"
"""The bundled record: the laboratory's stage at 50 kHz, excited for memory, lag, creep and modes."""

IDENTIFICATION_ROWS: Final = 46_003
"""Rows for identification; validation begins at this row, counted from 0."""


def bundled_csv() -> str:
    """The record as it is shipped with the package."""
    return resources.files(__package__).joinpath(BUNDLED).read_text(encoding="utf-8")


def demo_record() -> Record:
    """The bundled record, read as any other; its first IDENTIFICATION_ROWS are for identification."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "demo.csv"
        path.write_text(bundled_csv(), encoding="utf-8")
        return load_record(path)
