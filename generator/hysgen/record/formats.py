"""Files of other programs as arrays by name: NumPy, Excel, Parquet, Feather, TDMS, MDF4, UFF 58, and packed files.

The format is recognised by the first bytes, not by the suffix. A library is imported when its format is read; those
beside NumPy are the extra `hysgen[formats]`.
"""

from __future__ import annotations

import bz2
import gzip
import importlib
import lzma
import tempfile
import warnings
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.arrays import HDF5_MAGIC, MATLAB_BLOCK, Array, MatlabObjectError, read_hdf5, read_mat, read_npz
from hysgen.record.json_columns import read_json
from hysgen.record.lvm import MARK, X, read_lvm
from hysgen.record.refused_kinds import check_kind, check_parts
from hysgen.record.text import text_of
from hysgen.record.timetable import read_tables

EXTRA = "hysgen[formats]"


@dataclass(frozen=True, eq=False)
class FileArrays:
    """Arrays of a file by path ("group/name"), their units where the file names them, the sampling period in s."""

    arrays: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)
    Ts_s: float | None = None
    remarks: tuple[str, ...] = ()


def unpacked(path: Path) -> bytes | FileArrays:
    """The content of a file: bytes of text, or arrays. Raises RecordError for a format that cannot be read."""
    with path.open("rb") as stream:
        head = stream.read(MATLAB_BLOCK + 8)
    for magic, (what, unpack) in PACKED.items():
        if head.startswith(magic):
            try:
                return _inner(path, path.name.removesuffix(path.suffix), unpack(path.read_bytes()))
            except (OSError, EOFError, ValueError, lzma.LZMAError) as fault:
                raise RecordError(f"{path.name}: is no whole {what} file ({fault}); pack it again") from fault
    check_kind(path.name, head)
    if head[:4] == b"PK\x03\x04":
        return _of_zip(path)
    for magic, reader in BY_MAGIC.items():
        if head.startswith(magic):
            return reader(path)
    if head.startswith(b"MATLAB") or head[MATLAB_BLOCK:].startswith(HDF5_MAGIC) or path.suffix.lower() == ".mat":
        return read_mat_arrays(path)
    if path.suffix.lower() in (".h5", ".hdf5", ".hdf"):
        return read_hdf5_arrays(path)
    if path.suffix.lower() == ".npz":
        return FileArrays(read_npz(path))
    if head.lstrip()[:2] == b"-1" and b"\n" in head[:90]:
        return read_uff(path)
    if head.startswith(MARK.encode()):
        found = read_lvm(path.name, text_of(path.name, path.read_bytes())[0])
        return FileArrays(found.arrays, found.units, None if any(X in key for key in found.arrays) else found.Ts_s)
    if head.lstrip()[:1] in (b"{", b"[") and path.suffix.lower() == ".json":
        return FileArrays(read_json(path))
    return path.read_bytes()


def read_mat_arrays(path: Path) -> FileArrays:
    try:
        return FileArrays(read_mat(path))
    except MatlabObjectError:
        return FileArrays(*read_tables(path))


def read_hdf5_arrays(path: Path) -> FileArrays:
    try:
        return FileArrays(*read_hdf5(path))
    except MatlabObjectError:
        return FileArrays(*read_tables(path))


def read_npy(path: Path) -> FileArrays:
    """The fields of a structured array, or a matrix of columns as "array"."""
    try:
        array = np.load(path, allow_pickle=False)
    except (ValueError, OSError, EOFError) as fault:
        raise RecordError(f"{path.name}: cannot be read ({fault}); save an array of plain numbers") from fault
    if array.dtype.names:
        return FileArrays({name: array[name] for name in array.dtype.names})
    if array.ndim != 2:
        raise RecordError(f"{path.name}: holds an array of shape {array.shape}; save a matrix of columns, or use NPZ")
    return FileArrays({"array": array})


def read_excel(path: Path) -> bytes:
    """The first sheet that holds numbers, as tab-separated text."""
    openpyxl = _library("openpyxl", path, "Excel files")
    book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    try:
        for sheet in book.worksheets:
            rows = ["\t".join(_cell(value) for value in row) for row in sheet.iter_rows(values_only=True)]
            if sum(row.strip() != "" for row in rows) > 1:
                return "\n".join([*rows, ""]).encode()
    finally:
        book.close()
    raise RecordError(f"{path.name}: its sheets are empty; save the record in one of them")


def read_parquet(path: Path) -> FileArrays:
    return _of_table(_library("pyarrow.parquet", path, "Parquet files").read_table(path))


def read_feather(path: Path) -> FileArrays:
    return _of_table(_library("pyarrow.feather", path, "Feather files").read_table(path))


def read_tdms(path: Path) -> FileArrays:
    """Channels as "group/channel"; the sampling period from the waveform property wf_increment."""
    library = _library("nptdms", path, "TDMS files")
    arrays, units, periods = {}, {}, set()
    for group in library.TdmsFile.read(path, raw_timestamps=True).groups():
        for channel in group.channels():
            stored = channel[:]
            values = stored.as_datetime64("ns") if hasattr(stored, "as_datetime64") else np.asarray(stored)
            key = f"{group.name}/{channel.name}"
            if values.dtype.kind in "mM":
                values, units[key] = _seconds(values), "s"
            if values.dtype.kind not in "fiub" or not values.size:
                continue
            arrays[key] = values
            properties = dict(channel.properties)
            if unit := str(properties.get("unit_string", properties.get("Unit", ""))):
                units[key] = unit
            if (step := float(properties.get("wf_increment", 0.0))) > 0.0:
                periods.add(step)
    return FileArrays(arrays, units, periods.pop() if len(periods) == 1 else None)


def read_mdf(path: Path) -> FileArrays:
    """Channels of each group as "group0/channel", with the time of the group; groups of one time are one group."""
    library = _library("asammdf", path, "MDF files")
    arrays: dict[str, Array] = {}
    units: dict[str, str] = {}
    with library.MDF(path) as file:
        for number, group in enumerate(file.groups):
            master = file.masters_db.get(number)
            names = [channel.name for place, channel in enumerate(group.channels) if place != master]
            folder = _group_of_time(arrays, file.get_master(number), names, number)
            for place, channel in enumerate(group.channels):
                if place == master:
                    continue
                signal = file.get(channel.name, group=number, index=place)
                if signal.samples.dtype.kind not in "fiub" or signal.samples.ndim != 1:
                    continue
                arrays[f"{folder}/time"] = signal.timestamps
                arrays[f"{folder}/{channel.name}"] = signal.samples
                units[f"{folder}/time"] = "s"
                if signal.unit:
                    units[f"{folder}/{channel.name}"] = signal.unit
    return FileArrays(arrays, units)


def _group_of_time(arrays: Mapping[str, Array], time_s: Array, names: Sequence[str], number: int) -> str:
    """The group that has these times and none of these names, else a new one of this number."""
    for key, values in arrays.items():
        folder, _, name = key.rpartition("/")
        if name == "time" and np.array_equal(values, time_s) and not any(f"{folder}/{one}" in arrays for one in names):
            return folder
    return f"group{number}"


def read_uff(path: Path) -> FileArrays:
    """Functions of dataset 58 by their id line; the sampling period is the increment of the abscissa."""
    library = _library("pyuff", path, "UFF files")
    arrays, units, periods = {}, {}, set()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = library.UFF(str(path))
        for number in np.flatnonzero(np.asarray(file.get_set_types()) == 58):
            one = file.read_sets(int(number))
            values = np.asarray(one["data"])
            if values.dtype.kind != "f":
                continue
            name = str(one.get("id1") or one.get("rsp_ent_name") or "").strip()
            name = f"channel {number}" if name in ("", "NONE") else name
            arrays[name] = values
            if unit := str(one.get("ordinate_axis_units_lab") or "").strip():
                units[name] = unit
            periods.add(float(one["abscissa_inc"]) or float(np.diff(one["x"][:2])[0]))
    return FileArrays(arrays, units, periods.pop() if len(periods) == 1 else None)


def _of_zip(path: Path) -> bytes | FileArrays:
    try:
        with zipfile.ZipFile(path) as archive:
            names = [one for one in archive.namelist() if not one.endswith("/") and not one.startswith("__MACOSX/")]
            check_parts(path.name, names)
            if "[Content_Types].xml" in names:
                return read_excel(path)
            if len(names) == 1 and not names[0].endswith(".npy"):
                return _inner(path, Path(names[0]).name, archive.read(names[0]))
    except (zipfile.BadZipFile, OSError, EOFError, RuntimeError) as fault:
        if path.suffix.lower() != ".npz":
            raise RecordError(f"{path.name}: is no whole zip file ({fault}); pack it again") from fault
        return FileArrays(read_npz(path))
    if any(name.endswith(".npy") for name in names):
        return FileArrays(read_npz(path))
    raise RecordError(f"{path.name}: holds {len(names)} files; unpack it and name the record")


def _inner(path: Path, name: str, data: bytes) -> bytes | FileArrays:
    """The content of a packed file."""
    with tempfile.TemporaryDirectory() as folder:
        inner = Path(folder) / (name or path.name)
        inner.write_bytes(data)
        return unpacked(inner)


def _of_table(table: Any) -> FileArrays:
    """Columns of an Arrow table; time stamps as seconds since the first."""
    arrays, units = {}, {}
    for name in table.column_names:
        values = table.column(name).to_numpy()
        if values.dtype.kind in "mM":
            values, units[str(name)] = _seconds(values), "s"
        if values.dtype.kind in "fiub":
            arrays[str(name)] = values
    return FileArrays(arrays, units)


def _seconds(values: Array) -> Array:
    """Time stamps as seconds since the first, spans of time as seconds."""
    spans = np.subtract(values, values[:1]) if values.dtype.kind == "M" else values
    return np.asarray(spans.astype("timedelta64[ns]").astype(np.int64) * 1e-9)


def _cell(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return "" if value is None else str(int(value))
    if isinstance(value, (datetime, time)):
        return value.isoformat().replace("T", " ")
    if isinstance(value, date):
        return value.isoformat()
    return repr(value) if isinstance(value, (int, float)) else str(value).replace("\t", " ").replace("\n", " ")


def _library(name: str, path: Path, what: str) -> Any:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as fault:
        raise RecordError(f"{path.name}: {what} need {fault.name}; pip install '{EXTRA}', or save it as CSV") from fault


def open_checked(path: Path) -> bytes | FileArrays:
    """`unpacked`, with any fault of a library as RecordError."""
    try:
        return unpacked(path)
    except (RecordError, OSError, MemoryError):
        raise
    except Exception as fault:  # readers of damaged files may raise anything
        line = " ".join(str(fault).split())[:120] or type(fault).__name__
        raise RecordError(f"{path.name}: cannot be read ({line}); save it again, or export it as CSV") from fault


BY_MAGIC: Mapping[bytes, Callable[[Path], FileArrays]] = {
    b"TDSm": read_tdms,
    b"PAR1": read_parquet,
    b"ARROW1": read_feather,
    b"MDF     ": read_mdf,
    b"\x93NUMPY": read_npy,
    HDF5_MAGIC: read_hdf5_arrays,
}
"""Readers by the first bytes of a file."""


PACKED: Mapping[bytes, tuple[str, Callable[[bytes], bytes]]] = {
    b"\x1f\x8b": ("gzip", gzip.decompress),
    b"BZh": ("bzip2", bz2.decompress),
    b"\xfd7zXZ": ("xz", lzma.decompress),
}
"""What packed a file, and how it is unpacked, by the first bytes."""


def names_of(file: FileArrays) -> Iterator[tuple[str, str]]:
    """Key and last part of the name of every series, with its unit in brackets if the file names one."""
    for key, array in file.arrays.items():
        if array.size > 1 and np.squeeze(array).ndim == 1 and array.dtype.kind in "fiub":
            name = key.rpartition("/")[2]
            yield key, f"{name} [{file.units[key]}]" if key in file.units else name
