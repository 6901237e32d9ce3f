"""Files packed by gzip, bzip2, xz or zip: the one file inside."""

from __future__ import annotations

import bz2
import gzip
import lzma
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

from hysgen.errors import RecordError
from hysgen.record.formats import unpacked
from hysgen.record.formats.base import FileArrays, Format, Text, check_parts

ZIP = b"PK\x03\x04"

PACKED: Mapping[bytes, tuple[str, Callable[[bytes], bytes]]] = {
    b"\x1f\x8b": ("gzip", gzip.decompress),
    b"BZh": ("bzip2", bz2.decompress),
    b"\xfd7zXZ": ("xz", lzma.decompress),
}
"""What packed a file, and how it is unpacked, by the first bytes."""


def parts_of(path: Path, head: bytes) -> list[str]:
    """The names of the files in a zip; [] for other files, and for damaged ones."""
    if not head.startswith(ZIP):
        return []
    try:
        with zipfile.ZipFile(path) as archive:
            return [name for name in archive.namelist() if not name.endswith("/") and not name.startswith("__MACOSX/")]
    except (zipfile.BadZipFile, OSError, EOFError, RuntimeError):
        return []


def read_packed(path: Path) -> Text | FileArrays:
    data = path.read_bytes()
    for magic, (what, unpack) in PACKED.items():
        if data.startswith(magic):
            try:
                return _inner(path, path.name.removesuffix(path.suffix), unpack(data))
            except (OSError, EOFError, ValueError, lzma.LZMAError) as fault:
                raise RecordError(f"{path.name}: is no whole {what} file ({fault}); pack it again") from fault
    try:
        with zipfile.ZipFile(path) as archive:
            parts = parts_of(path, data[:4])
            check_parts(path.name, parts)
            if len(parts) == 1:
                return _inner(path, Path(parts[0]).name, archive.read(parts[0]))
    except (zipfile.BadZipFile, OSError, EOFError, RuntimeError) as fault:
        raise RecordError(f"{path.name}: is no whole zip file ({fault}); pack it again") from fault
    raise RecordError(f"{path.name}: holds {len(parts)} files; unpack it and name the record")


def _inner(path: Path, name: str, data: bytes) -> Text | FileArrays:
    """The content of a packed file."""
    with tempfile.TemporaryDirectory() as folder:
        inner = Path(folder) / (name or path.name)
        inner.write_bytes(data)
        return unpacked(inner)


FORMAT = Format("packed", lambda path, head: head.startswith((ZIP, *PACKED)), read_packed, after=("excel", "npz"))
