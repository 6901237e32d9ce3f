"""HDF5: numeric datasets by their path, and DataFrames of pandas."""

import itertools
import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import Array, FileArrays, Format, Series, check_size, collected, one_line, period_in

FILL_VALUES = ("_FillValue", "missing_value")
"""Attributes of a dataset with the stored value that means none (CF)."""

MAGIC = b"\x89HDF\r\n\x1a\n"
MATLAB_BLOCK = 512
"""Bytes that MATLAB puts before the HDF5 part of a v7.3 file."""


def read_hdf5(path: Path) -> FileArrays:
    """All numeric datasets of an HDF5 file by path, without the leading slash, their units, and the sampling period.

    The fields of a compound dataset are arrays of their own, "table/field". Units are attributes `unit` or `units`,
    in any case; values that were packed with `scale_factor` and `add_offset` are unpacked;
    the period is a scalar attribute of a group or dataset with a name in PERIODS.
    A DataFrame, whose names pandas pickles, is refused; the indices of PyTables (_i_table) are left out.
    MATLAB stores the axes of an array in reverse order. Datasets with MATLAB's attribute are transposed, and their
    vectors made one-dimensional, so that indices have the order of MATLAB. Links are not followed.
    """
    arrays: dict[str, Array] = {}
    units: dict[str, str] = {}
    periods: list[float] = []
    sizes: list[int] = []
    tables: list[str] = []

    def take(name: str, item: Any) -> None:
        if re.search(r"(^|/)_i_", name):
            return
        if "pandas_type" in item.attrs:
            raise RecordError(
                f"{path.name}: holds a DataFrame ({name}), whose names are pickled; save it as CSV or Parquet, or in "
                f"Python: hysgen.Record.from_dataframe(pandas.read_hdf('{path.name}'))"
            )
        period = period_in({str(key): item.attrs[key] for key in item.attrs})
        if period is not None:
            periods.append(period)
        if item.attrs.get("MATLAB_class") in (b"table", b"timetable"):
            tables.append(name)
        if not isinstance(item, h5py.Dataset) or item.shape is None:
            return
        sizes.append(int(item.nbytes))
        check_size(path, sum(sizes))
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
        raise RecordError(f"{path.name}: is no readable HDF5 file ({one_line(fault)}); write it again") from fault
    if tables:
        return read_tables(path)
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


SUFFIXES = (".h5", ".hdf5", ".hdf")
FORMAT = Format(
    "hdf5",
    lambda path, head: MAGIC in (head[:8], head[MATLAB_BLOCK:]) or path.suffix.lower() in SUFFIXES,
    read_hdf5,
    after=("mat",),
)

UNITS = ("varUnits", "VariableUnits")
"""Attributes of a timetable and of a table that hold the units of its columns."""


def read_tables(path: Path) -> FileArrays:
    """The columns of all tables and timetables of a MAT file as "table/column", and their units.

    The times of the rows are "table/Time" in s: durations unchanged, dates relative to the first row.
    Raises RecordError without mat-io and for a file whose objects are no tables.
    """
    try:
        from matio import load_from_mat
    except ModuleNotFoundError as fault:
        raise RecordError(
            f"{path.name}: holds a MATLAB table or timetable; pip install 'hysgen[formats]' reads it, or in MATLAB: "
            "s = table2struct(timetable2table(x), 'ToScalar', true); save('record.mat', '-struct', 's')"
        ) from fault
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        content = load_from_mat(str(path), add_table_attrs=True)
    tables = [(name, item) for name, item in content.items() if hasattr(item, "columns") and hasattr(item, "index")]
    file = collected(series for name, table in tables for series in _columns(name, table))
    if not file.arrays:
        raise RecordError(f"{path.name}: its objects are no tables of numbers; save the columns as arrays")
    return file


def _columns(name: str, table: Any) -> Iterator[Series]:
    """The times of the rows, where they are times, and the columns that are none; units in the order of the columns."""
    times = np.asarray(table.index)
    if times.dtype.kind in "mM":
        yield Series(f"{name}/Time", times)
    stated = next((table.attrs[key] for key in UNITS if len(table.attrs.get(key, ()))), ())
    units = [str(unit).strip() for unit in np.ravel(np.asarray(stated, dtype=object))]
    for column, unit in itertools.zip_longest(table.columns, units[: len(table.columns)], fillvalue=""):
        values = np.asarray(table[column])
        if values.dtype.kind != "M":
            yield Series(f"{name}/{column}", values, unit)
