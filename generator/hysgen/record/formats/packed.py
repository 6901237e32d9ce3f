"""Files packed by gzip, bzip2, xz or zip: the one file inside."""

import bz2
import gzip
import lzma
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from hysgen.errors import RecordError
from hysgen.record.formats import unpacked
from hysgen.record.formats.base import AT_ONCE, FileArrays, Format, Text, check_parts, check_size

ZIP = b"PK\x03\x04"

PACKED: Mapping[bytes, tuple[str, Callable[[Any], Any]]] = {
    b"\x1f\x8b": ("gzip", gzip.open),
    b"BZh": ("bzip2", bz2.open),
    b"\xfd7zXZ": ("xz", lzma.open),
}
"""What packed a file, and how it is unpacked, by the first bytes."""


def parts_of(path: Path, head: bytes) -> list[str]:
    """The names of the files in a zip; [] for other files, and for damaged ones. Raises RecordError for a bomb."""
    if not head.startswith(ZIP):
        return []
    try:
        with zipfile.ZipFile(path) as archive:
            parts = archive.infolist()
            check_size(path, sum(part.file_size for part in parts))
            return [name for name in archive.namelist() if not name.endswith("/") and not name.startswith("__MACOSX/")]
    except (zipfile.BadZipFile, OSError, EOFError, RuntimeError):
        return []


def read_packed(path: Path) -> Text | FileArrays:
    with path.open("rb") as stream:
        head = stream.read(max(map(len, PACKED)))
    for magic, (what, unpack) in PACKED.items():
        if head.startswith(magic):
            try:
                with path.open("rb") as stream, unpack(stream) as packed:
                    data = bytearray()
                    while part := packed.read(AT_ONCE):
                        data += part
                        check_size(path, len(data), stream.tell())
                return _inner(path, path.name.removesuffix(path.suffix), data)
            except (OSError, EOFError, ValueError, lzma.LZMAError) as fault:
                raise RecordError(f"{path.name}: is no whole {what} file ({fault}); pack it again") from fault
    try:
        with zipfile.ZipFile(path) as archive:
            parts = parts_of(path, head)
            check_parts(path.name, parts)
            if len(parts) == 1:
                return _inner(path, Path(parts[0]).name, archive.read(parts[0]))
    except (zipfile.BadZipFile, OSError, EOFError, RuntimeError) as fault:
        raise RecordError(f"{path.name}: is no whole zip file ({fault}); pack it again") from fault
    raise RecordError(f"{path.name}: holds {len(parts)} files; unpack it and name the record")


def _inner(path: Path, name: str, data: bytes | bytearray) -> Text | FileArrays:
    """The content of a packed file."""
    with tempfile.TemporaryDirectory() as folder:
        inner = Path(folder) / (name or path.name)
        inner.write_bytes(data)
        return unpacked(inner)


FORMAT = Format("packed", lambda path, head: head.startswith((ZIP, *PACKED)), read_packed, after=("excel", "npz"))
