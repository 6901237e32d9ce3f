"""HDF5: numeric datasets by their path, and DataFrames of pandas."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import Array, FileArrays, Format, one_line, period_in
from hysgen.record.formats.matlab_tables import read_tables
from hysgen.record.formats.pandas_hdf5 import TYPE, frame_arrays

FILL_VALUES = ("_FillValue", "missing_value")
"""Attributes of a dataset with the stored value that means none (CF)."""

MAGIC = b"\x89HDF\r\n\x1a\n"
MATLAB_BLOCK = 512
"""Bytes that MATLAB puts before the HDF5 part of a v7.3 file."""


class _MatlabTableError(Exception):
    """The file holds tables or timetables, which are objects of MATLAB."""


def read_hdf5(path: Path) -> FileArrays:
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
        if item.attrs.get("MATLAB_class") in (b"table", b"timetable"):
            raise _MatlabTableError
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
    except _MatlabTableError:
        return FileArrays(*read_tables(path))
    except (OSError, RuntimeError, ValueError, KeyError) as fault:
        raise RecordError(f"{path.name}: is no readable HDF5 file ({one_line(fault)}); write it again") from fault
    return FileArrays(arrays, units, periods[0] if periods and max(periods) == min(periods) else None)


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


def _is_hdf5(path: Path, head: bytes) -> bool:
    there = head.startswith(MAGIC) or head[MATLAB_BLOCK:].startswith(MAGIC)
    return there or path.suffix.lower() in (".h5", ".hdf5", ".hdf")


FORMAT = Format("hdf5", _is_hdf5, read_hdf5, after=("mat",))
