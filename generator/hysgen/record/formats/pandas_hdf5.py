"""DataFrames in HDF5 files, as pandas writes them through PyTables: columns by their names, the index as a column.

    fixed     block0_items (names), block0_values (rows, names), axis1 (index)
    table     one compound dataset: a field for each data column, fields of several columns (values_block_0), index

The names stand in attributes as text pickles of strings. They are read as text, never unpickled.
"""

from __future__ import annotations

import re
from typing import Any

import h5py
import numpy as np

from hysgen.record.formats.base import Array

TYPE = "pandas_type"
"""The attribute of a group that holds a DataFrame."""

_TEXTS = re.compile(rb"(?m)^a?V(.*)$")
_INDEX_NAME = re.compile(rb"Vindex_name\np\d+\nV([^\n]*)\n")


def frame_arrays(name: str, group: Any) -> dict[str, Array]:
    """The numeric columns of the DataFrame in a group, and its index if it is no plain count, as "group/column"."""
    columns = _of_table(group) if isinstance(group.get("table"), h5py.Dataset) else _of_blocks(group)
    return {f"{name}/{key}": values for key, values in columns.items() if values.dtype.kind in "fiu"}


def _of_table(group: Any) -> dict[str, Array]:
    table = group["table"]
    rows = np.asarray(table[()])
    found: dict[str, Array] = {}
    for field in rows.dtype.names or ():
        values = rows[field]
        if field == "index":
            named = _INDEX_NAME.search(bytes(group.attrs.get("info", b"")))
            found |= _index(values, named.group(1).decode() if named else "", _text(table.attrs.get("index_kind")))
        elif values.ndim == 2:
            found |= dict(zip(_texts(table.attrs.get(f"{field}_kind")), values.T, strict=False))
        else:
            found[field] = values
    return found


def _of_blocks(group: Any) -> dict[str, Array]:
    found: dict[str, Array] = {}
    if "axis1" in group:
        attributes = group["axis1"].attrs
        named = _texts(attributes.get("name"))
        index = np.asarray(group["axis1"][()])
        found |= _index(index, named[0] if named else "", _text(attributes.get("kind")))
    for key in group:
        if block := re.fullmatch(r"(block\d+)_items", key):
            names = [item.decode() if isinstance(item, bytes) else str(item) for item in group[key][()]]
            found |= dict(zip(names, np.asarray(group[f"{block.group(1)}_values"][()]).T, strict=False))
    return found


def _index(values: Array, name: str, kind: str) -> dict[str, Array]:
    """The index as a column: dates as "time" in s, numbers by their name; a plain count without a name is none."""
    if kind.startswith(("datetime", "timedelta")):
        per_second = {"s": 1.0, "ms": 1e3, "us": 1e6}.get(kind.partition("[")[2].partition("]")[0].split(",")[0], 1e9)
        seconds = (values - values[:1]) / per_second  # type: ignore[operator]
        return {"time": np.asarray(seconds, dtype=np.float64)}
    return {} if not name and kind == "integer" else {name or "time": values}


def _texts(attribute: Any) -> list[str]:
    return [text.decode() for text in _TEXTS.findall(attribute)] if isinstance(attribute, bytes) else []


def _text(attribute: Any) -> str:
    return attribute.decode() if isinstance(attribute, bytes) else str(attribute)
