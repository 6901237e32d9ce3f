"""Formats of files: one file each, found by listing the modules of this package.

A module defines FORMAT, a `Format`, or FORMATS, several. A format is recognised by the first bytes where it has a
signature; a library is imported when its format is read, and those beside NumPy are the extra `hysgen[formats]`. What
no format recognises is text, unless it is known to be something else (`base.KINDS`).
"""

import functools
import importlib
import pkgutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import FileArrays, Format, Text, check_kind, one_line

__all__ = ["FileArrays", "Format", "Text", "formats", "names_of", "open_checked", "unpacked"]

HEAD = 520
"""Bytes by which a format is recognised; MATLAB puts 512 before the signature of HDF5."""


@functools.lru_cache(maxsize=1)
def formats() -> tuple[Format, ...]:
    """Every format, those that others come after first."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [importlib.import_module(f"{__name__}.{name}") for name in names]
    known = [item for module in modules for item in getattr(module, "FORMATS", [getattr(module, "FORMAT", None)])]
    return tuple(sorted(filter(None, known), key=lambda item: len(item.after)))


def unpacked(path: Path) -> Text | FileArrays:
    """The content of a file. Raises RecordError for a file that cannot be read."""
    with path.open("rb") as stream:
        head = stream.read(HEAD)
    check_kind(path.name, head)
    for known in formats():
        if known.recognises(path, head):
            return known.read(path)
    return Text(path.read_bytes())


def open_checked(path: Path) -> Text | FileArrays:
    """`unpacked`, with any fault of a library as RecordError."""
    try:
        return unpacked(path)
    except (RecordError, OSError, MemoryError):
        raise
    except Exception as fault:  # readers of damaged files may raise anything
        line = f"{path.name}: cannot be read ({one_line(fault)})"
        raise RecordError(f"{line}; save it again, or export it as CSV") from fault


def names_of(file: FileArrays) -> Iterator[tuple[str, str]]:
    """Key and last part of the name of every series, with its unit in brackets if the file names one."""
    for key, array in file.arrays.items():
        if array.size > 1 and np.squeeze(array).ndim == 1 and array.dtype.kind in "fiub":
            name = key.rpartition("/")[2]
            yield key, f"{name} [{file.units[key]}]" if key in file.units else name
