"""MATLAB tables and timetables as arrays, read by the library mat-io of the extra `hysgen[formats]`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import Array

UNITS = ("varUnits", "VariableUnits")
"""Attributes of a timetable and of a table that hold the units of its columns."""


def read_tables(path: Path) -> tuple[dict[str, Array], dict[str, str]]:
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
    arrays: dict[str, Array] = {}
    units: dict[str, str] = {}
    for name, table in content.items():
        if hasattr(table, "columns") and hasattr(table, "index"):
            _take(name, table, arrays, units)
    if not arrays:
        raise RecordError(f"{path.name}: its objects are no tables of numbers; save the columns as arrays")
    return arrays, units


def _take(name: str, table: Any, arrays: dict[str, Array], units: dict[str, str]) -> None:
    """Add the times of the rows and the numeric columns of a DataFrame."""
    kind = np.asarray(table.index).dtype.kind
    if kind in "mM":
        times = np.asarray(table.index)
        start = times[0] if kind == "M" and times.size else np.timedelta64(0, "ns")
        arrays[f"{name}/Time"] = (times - start) / np.timedelta64(1, "s")
        units[f"{name}/Time"] = "s"
    stated = _units(table.attrs)
    for place, column in enumerate(table.columns):
        values = np.asarray(table[column])
        if values.dtype.kind == "m":
            values = values / np.timedelta64(1, "s")
        if values.dtype.kind in "fiub":
            arrays[f"{name}/{column}"] = values
            if place < len(stated) and stated[place]:
                units[f"{name}/{column}"] = stated[place]


def _units(attributes: Mapping[str, Any]) -> list[str]:
    """Units of the columns, in their order; empty where the table states none."""
    found = next((attributes[key] for key in UNITS if len(attributes.get(key, ()))), ())
    return [str(unit).strip() for unit in np.ravel(np.asarray(found, dtype=object))]
