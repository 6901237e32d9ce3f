"""NPZ: arrays by name. NPY: the fields of a structured array, or a matrix of columns as "array".

Pickled Python objects, which could run code, are refused without being opened.
"""

import zipfile
import zlib
from pathlib import Path

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import Array, FileArrays, Format, one_line, seconds
from hysgen.record.formats.packed import ZIP, parts_of

NPY = b"\x93NUMPY"


def read_npz(path: Path) -> FileArrays:
    """All arrays of an NPZ file by name. Raises RecordError for pickled objects and for other files."""
    with path.open("rb") as stream:
        if stream.read(len(NPY)) == NPY:
            return _read_npy(path)
    if not zipfile.is_zipfile(path) or not parts_of(path, ZIP):
        raise RecordError(f"{path.name}: is not an NPZ file; write it with numpy.savez, or give it its own suffix")
    arrays: dict[str, Array] = {}
    name = ""
    try:
        with np.load(path, allow_pickle=False) as archive:
            for name in archive.files:
                member = archive[name]
                if isinstance(member, np.ndarray):
                    arrays[name] = seconds(member) if member.dtype.kind in "mM" else member
    except (ValueError, OSError, EOFError, RuntimeError, MemoryError, zipfile.BadZipFile, zlib.error) as fault:
        pickled = "allow_pickle" in str(fault)
        what = "is a pickled object, which could run code" if pickled else f"is damaged ({one_line(fault)})"
        raise RecordError(f"{path.name}: array {name} {what}; save arrays of plain numbers") from fault
    return FileArrays(arrays)


def _read_npy(path: Path) -> FileArrays:
    array = np.load(path, allow_pickle=False)
    if array.dtype.names:
        return FileArrays({name: array[name] for name in array.dtype.names})
    if array.ndim != 2:
        raise RecordError(f"{path.name}: holds an array of shape {array.shape}; save a matrix of columns, or use NPZ")
    return FileArrays({"array": array})


def _is_npz(path: Path, head: bytes) -> bool:
    return (
        head.startswith(NPY)
        or path.suffix.lower() == ".npz"
        or any(part.endswith(".npy") for part in parts_of(path, head))
    )


FORMAT = Format("npz", _is_npz, read_npz)
