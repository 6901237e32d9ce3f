"""Reading NPZ, MAT (v5 and v7.3) and HDF5 files into arrays by name, and selecting series from arrays.

Only numeric arrays are read. Pickled Python objects, which could run code, are refused without being opened.
"""

from __future__ import annotations

import re
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.io
from numpy.typing import NDArray
from scipy.io.matlab import MatlabOpaque

from hysgen.errors import RecordError
from hysgen.record.columns import nearest
from hysgen.record.pandas_hdf5 import TYPE, frame_arrays

Array = NDArray[np.generic]


class MatlabObjectError(RecordError):
    """A MAT file holds tables or timetables, which are objects of MATLAB (`hysgen.record.timetable`)."""


PERIODS = {
    "ts_s": 1.0,
    "ts": 1.0,
    "dt": 1.0,
    "delta_t": 1.0,
    "sample_time": 1.0,
    "sampletime": 1.0,
    "sampling_period": 1.0,
    "fs_hz": -1.0,
    "fs": -1.0,
    "sample_rate": -1.0,
    "samplerate": -1.0,
    "sampling_rate": -1.0,
    "sampling_frequency": -1.0,
}
"""Lower-case names of scalars that give the sampling period in s (+1) or the rate in Hz (-1)."""

FILL_VALUES = ("_FillValue", "missing_value")
"""Attributes of a dataset with the stored value that means none (CF)."""

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
MATLAB_BLOCK = 512
"""Bytes that MATLAB puts before the HDF5 part of a v7.3 file."""


def read_npz(path: Path) -> dict[str, Array]:
    """All arrays of an NPZ file by name. Raises RecordError for pickled objects and for other files."""
    if not zipfile.is_zipfile(path):
        raise RecordError(f"{path.name}: is not an NPZ file; write it with numpy.savez, or give it its own suffix")
    arrays: dict[str, Array] = {}
    name = ""
    try:
        with np.load(path, allow_pickle=False) as archive:
            for name in archive.files:
                member = archive[name]
                if isinstance(member, np.ndarray):
                    arrays[name] = member
    except (ValueError, OSError, EOFError, RuntimeError, MemoryError, zipfile.BadZipFile, zlib.error) as fault:
        pickled = "allow_pickle" in str(fault)
        what = "is a pickled object, which could run code" if pickled else f"is damaged ({_one_line(fault)})"
        raise RecordError(f"{path.name}: array {name} {what}; save arrays of plain numbers") from fault
    return arrays


def read_mat(path: Path) -> dict[str, Array]:
    """All numeric variables of a MAT file; fields of structures as "structure/field". v7.3 is read as HDF5.

    Raises MatlabObjectError for a file of tables and timetables.
    """
    start = path.read_bytes()[: MATLAB_BLOCK + len(HDF5_MAGIC)]
    if start.startswith(HDF5_MAGIC) or start.endswith(HDF5_MAGIC):
        return read_hdf5(path)[0]
    if not start.startswith(b"MATLAB 5.0 MAT-file") and not _is_mat_4(path):
        raise RecordError(f"{path.name}: is not a MAT file of version 4, 5 or 7.3; save it with MATLAB's -v7 or -v7.3")
    try:
        content = scipy.io.loadmat(str(path), simplify_cells=True)
    except Exception as fault:  # SciPy's parser may raise any exception on a damaged file
        raise RecordError(f"{path.name}: is damaged ({_one_line(fault)}); save it again") from fault
    arrays = dict(_flat("", content))
    if not arrays and any(isinstance(item, MatlabOpaque) for item in content.values()):
        raise MatlabObjectError(path.name)
    return arrays


def _is_mat_4(path: Path) -> bool:
    """Whether the first word of a file is the type of a matrix of version 4, which has no signature."""
    try:
        return bool(scipy.io.matlab.matfile_version(str(path))[0] == 0)
    except (ValueError, OSError, scipy.io.matlab.MatReadError):
        return False


def read_hdf5(path: Path) -> tuple[dict[str, Array], dict[str, str], float | None]:
    """All numeric datasets of an HDF5 file by path, without the leading slash, their units, and the sampling period.

    The fields of a compound dataset are arrays of their own, "table/field". Units are attributes `unit` or `units`,
    in any case; values that were packed with `scale_factor` and `add_offset` are unpacked;
    the period is a scalar attribute of a group or dataset with a name in PERIODS.
    DataFrames of pandas are read by `pandas_hdf5`; the indices of PyTables (_i_table) are left out.
    MATLAB stores the axes of an array in reverse order. Datasets with MATLAB's attribute are transposed, and their
    vectors made one-dimensional, so that indices have the order of MATLAB. Links are not followed.
    """
    arrays: dict[str, Array] = {}
    units: dict[str, str] = {}
    periods: list[float] = []
    frames: list[str] = []

    def take(name: str, item: Any) -> None:
        if name.startswith(tuple(frames)) or re.search(r"(^|/)_i_", name):
            return
        if isinstance(item, h5py.Group) and TYPE in item.attrs:
            frames.append(f"{name}/")
            arrays.update(frame_arrays(name, item))
            return
        period = period_in({str(key): item.attrs[key] for key in item.attrs})
        if period is not None:
            periods.append(period)
        if "MATLAB_class" in item.attrs and item.attrs["MATLAB_class"] in (b"table", b"timetable"):
            raise MatlabObjectError(path.name)
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            return
        unit = next((item.attrs[key] for key in item.attrs if str(key).lower() in ("unit", "units")), None)
        if unit is not None:
            units[name] = unit.decode() if isinstance(unit, bytes) else str(unit)
        if item.dtype.names:
            table = np.asarray(item[()])
            arrays.update({f"{name}/{key}": table[key] for key in item.dtype.names if table[key].dtype.kind in "fiu"})
        elif item.dtype.kind in "fiu":
            values = _scaled(np.asarray(item[()]), item.attrs)
            arrays[name] = np.squeeze(values.T) if "MATLAB_class" in item.attrs else values

    try:
        with h5py.File(path, "r") as file:
            take("", file)
            file.visititems(take)
    except (OSError, RuntimeError, ValueError, KeyError) as fault:
        raise RecordError(f"{path.name}: is no readable HDF5 file ({_one_line(fault)}); write it again") from fault
    return arrays, units, periods[0] if periods and max(periods) == min(periods) else None


def _scaled(values: Array, attributes: Mapping[str, Any]) -> Array:
    """The values in their unit, where the attributes `scale_factor` and `add_offset` say how they were packed (CF).

    Where the stored value is a fill value, NaN.
    """
    marks = [np.ravel(attributes[key]) for key in FILL_VALUES if key in attributes]
    missing = np.isin(values, np.concatenate(marks)) if marks else np.zeros(1, dtype=bool)
    if missing.any():
        values = np.where(missing, np.nan, values.astype(np.float64))
    if not {"scale_factor", "add_offset"} & set(attributes):
        return values
    factor, offset = (float(np.ravel(attributes.get(*one))[0]) for one in (("scale_factor", 1.0), ("add_offset", 0.0)))
    return np.asarray(values, dtype=np.float64) * factor + offset


def period_in(values: Mapping[str, Any]) -> float | None:
    """The sampling period in s from a scalar with a name in PERIODS; None without one."""
    for key, value in values.items():
        power = PERIODS.get(key.rpartition("/")[2].lower())
        array = np.asarray(value)
        if power is not None and array.size == 1 and array.dtype.kind in "fiu" and float(np.ravel(array)[0]) > 0.0:
            return float(float(np.ravel(array)[0]) ** power)
    return None


def find(source: str, arrays: Mapping[str, Array], role: str, text: str) -> list[tuple[str, Array]]:
    """The series named by `text`: "name", "group/name" or "name[selection]".

    In a selection, a number is an index on its axis, the first ':' (or 'a:b') is the time axis, and each further ':' is
    an axis of segments; indices start at 0. Returns (label, (n,) array) for each segment.
    Raises RecordError if there is no such array, if it has several axes and no selection, or if an index is outside.
    """
    name, index = (text, None) if key_of(arrays, text) else _cut_selection(text)
    key = key_of(arrays, name)
    if key is None:
        there = ", ".join(sorted(arrays)) or "no numeric arrays"
        cure = f"--columns {role}=NAME" + (" or --columns Ts_s=SECONDS" if role == "time" else "")
        raise RecordError(
            f"{source}: has no {role} array '{name}'{nearest(name, arrays)}; it holds {there}; "
            f"say which one it is: {cure}"
        )
    array = arrays[key]
    if index is None:
        vector = np.squeeze(array)
        if vector.ndim > 1:
            example = ",".join([":"] + ["0"] * (array.ndim - 1))
            raise RecordError(
                f"{source}: {role} array '{name}' has shape {array.shape}; pick series from it, as '{name}[{example}]'"
            )
        return [("0", np.atleast_1d(vector))]
    return list(_series(source, name, array, index))


def key_of(arrays: Mapping[str, Array], name: str) -> str | None:
    """The key of the array `name`: its full path, or the last part of the path where that is unique; else None."""
    name = name.strip("/")
    if name in arrays:
        return name
    ending = [key for key in arrays if key.rpartition("/")[2] == name]
    return ending[0] if len(ending) == 1 else None


def _cut_selection(text: str) -> tuple[str, str | None]:
    match = re.fullmatch(r"(.+?)\s*\[([^\[\]]*)\]\s*", text)
    return (match.group(1), match.group(2)) if match else (text, None)


def _series(source: str, name: str, array: Array, index: str) -> Iterator[tuple[str, Array]]:
    """The series of `array` under a selection such as ":,0,:,:"; see `find`."""
    parts = [part.strip() for part in index.split(",")]
    if len(parts) != array.ndim:
        raise RecordError(
            f"{source}: '{name}[{index}]' has {len(parts)} indices, the array has {array.ndim} axes "
            f"(shape {array.shape}); give one for each axis"
        )
    ranges = []
    for axis, part in enumerate(parts):
        length = array.shape[axis]
        match = re.fullmatch(r"(-?\d+)|(\d*):(\d*)", part)
        if match is None:
            raise RecordError(f"{source}: '{part}' in '{name}[{index}]' is no index; write a number, ':' or 'a:b'")
        if match.group(1) is None:
            ranges.append(range(length)[slice(*(int(end) if end else None for end in match.group(2, 3)))])
            continue
        if not -length <= (pick := int(match.group(1))) < length:
            raise RecordError(
                f"{source}: index {pick} in '{name}[{index}]' is outside axis {axis} of length {length}; count from 0"
            )
        ranges.append(range(pick % length, pick % length + 1))
    time = next((axis for axis, part in enumerate(parts) if ":" in part), None)
    if time is None:
        raise RecordError(f"{source}: '{name}[{index}]' picks a single number; put ':' where time runs")
    segments = [axis for axis, part in enumerate(parts) if ":" in part and axis != time]
    for picks in np.ndindex(*(len(one) for axis, one in enumerate(ranges) if axis != time)):
        numbers = iter(picks)
        place = [0 if axis == time else one[next(numbers)] for axis, one in enumerate(ranges)]
        label = ",".join(str(place[axis]) for axis in segments) or "0"
        steps = slice(ranges[time].start, ranges[time].stop)
        yield label, array[tuple(steps if axis == time else at for axis, at in enumerate(place))]


def _flat(prefix: str, content: Mapping[str, Any]) -> Iterator[tuple[str, Array]]:
    """Numeric variables of nested dictionaries, by path.

    An item of a structure array has the name that it gives itself (Simulink: label, dSPACE: Name), else its number from
    1; a structure with `Data` or `values` (dSPACE, Simulink) is that array.
    """
    for name, item in content.items():
        if isinstance(item, Mapping):
            held = next((item[key] for key in ("Data", "data", "values") if key in item), None)
            if held is not None and not isinstance(held, (Mapping, str)) and np.asarray(held).dtype.kind in "fiub":
                yield prefix + (_given_name(item) or ("time" if name == "X" else name)), np.asarray(held)
            else:
                yield from _flat(f"{prefix}{name}/", item)
        elif (
            isinstance(item, (list, np.ndarray)) and len(np.atleast_1d(item)) and isinstance(np.ravel(item)[0], Mapping)
        ):
            parts = [(_given_name(one) or f"{name}{number}", one) for number, one in enumerate(np.ravel(item), 1)]
            yield from _flat(f"{prefix}{name}/", dict(parts))
        elif not name.startswith("__") and np.asarray(item).dtype.kind in "fiub":
            yield prefix + name, np.asarray(item)


def _given_name(item: Mapping[str, Any]) -> str:
    """The name in the fields of a structure; "" if it has none."""
    given = next((item[key] for key in ("label", "Name", "name") if isinstance(item.get(key), str)), "")
    return str(given).strip().replace("/", " ")


def _one_line(fault: BaseException) -> str:
    return " ".join(str(fault).split())[:120] or type(fault).__name__
