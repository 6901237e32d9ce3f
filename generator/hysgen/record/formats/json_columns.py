"""Columns in a JSON file.

{"time": [0, ...], "voltage": [...], "position": [...], "dt": 2e-5}     arrays by name, scalars beside them
[{"time": 0, "voltage": 5.8, "position": 0.8}, ...]                      a row an object
{"columns": ["time", ...], "data": [[0, 5.8, 0.8], ...]}                 pandas, orient="split"
{"time": {"0": 0, "1": 1e-3, ...}, ...}                                  pandas, as it is
"""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import FileArrays, Format

FEWEST_COLUMNS = 2
"""Columns without which a file is no record."""


def read_json(path: Path) -> FileArrays:
    """The numeric columns, and numeric scalars, by name. Raises RecordError for any other JSON, as a model file."""
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except (ValueError, RecursionError) as fault:
        raise RecordError(f"{path.name}: is no whole JSON ({fault}); save it again, or as CSV") from fault
    arrays = {}
    for name, values in _columns(content).items():
        try:
            # null, which JSON has for NaN, becomes NaN among numbers; numbers may stand in quotes
            array = np.asarray(values)
            if array.ndim == 1 and array.dtype.kind in "OU":
                array = array.astype(np.float64)
        except (ValueError, TypeError):  # rows of unequal length, words, lists
            continue
        if array.dtype.kind in "fiub" and array.ndim <= 1:
            arrays[str(name)] = array
    if sum(array.ndim == 1 for array in arrays.values()) < FEWEST_COLUMNS:
        raise RecordError(f"{path.name}: is JSON without columns of numbers, not a record; save the columns as CSV")
    return FileArrays(arrays)


def _columns(content: Any) -> Mapping[str, Any]:
    if isinstance(content, list) and content and all(isinstance(row, dict) for row in content):
        return {name: [row.get(name) for row in content] for name in content[0]}
    if not isinstance(content, dict):
        return {}
    if isinstance(content.get("columns"), list) and isinstance(content.get("data"), list):
        return dict(zip(map(str, content["columns"]), zip(*content["data"], strict=False), strict=False))
    return {name: list(one.values()) if isinstance(one, dict) else one for name, one in content.items()}


START = re.compile(rb"[\xef\xbb\xbf \t\r\n]*[{\[]")
FORMAT = Format("json", lambda path, head: path.suffix.lower() == ".json" and bool(START.match(head)), read_json)
