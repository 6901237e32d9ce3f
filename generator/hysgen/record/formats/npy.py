"""NPY: the fields of a structured array, or a matrix of columns as "array"."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import FileArrays, Format


def read_npy(path: Path) -> FileArrays:
    try:
        array = np.load(path, allow_pickle=False)
    except (ValueError, OSError, EOFError) as fault:
        raise RecordError(f"{path.name}: cannot be read ({fault}); save an array of plain numbers") from fault
    if array.dtype.names:
        return FileArrays({name: array[name] for name in array.dtype.names})
    if array.ndim != 2:
        raise RecordError(f"{path.name}: holds an array of shape {array.shape}; save a matrix of columns, or use NPZ")
    return FileArrays({"array": array})


FORMAT = Format("npy", lambda path, head: head.startswith(b"\x93NUMPY"), read_npy)
