"""Files that hold no record, told by their first bytes: what they are, and what to do."""

from __future__ import annotations

from collections.abc import Sequence

from hysgen.errors import RecordError

PICTURE = "a picture; give the numbers that it shows, as CSV"
PROGRAM = "a program; give the file that the logger wrote"

KINDS: tuple[tuple[int, bytes, str], ...] = (
    (0, b"\x89PNG", PICTURE),
    (0, b"\xff\xd8\xff", PICTURE),
    (0, b"GIF8", PICTURE),
    (0, b"II*\0", PICTURE),
    (0, b"BM", PICTURE),
    (4, b"ftyp", "a film; give the file of the logger"),
    (0, b"%PDF", "a PDF; export its table as CSV"),
    (0, b"\xd0\xcf\x11\xe0", "a document of old Office; save it as .xlsx or CSV"),
    (0, b"SQLite format 3\0", "a data base; export its table as CSV"),
    (0, b"\x7fELF", PROGRAM),
    (0, b"MZ", PROGRAM),
    (0, b"\x80\x04\x95", "a pickle, which could run code; save arrays of plain numbers"),
    (0, b"7z\xbc\xaf", "a 7z archive; unpack it and name the record"),
    (0, b"Rar!", "a RAR archive; unpack it and name the record"),
    (0, b"PK\x05\x06", "an empty zip archive; pack the record again"),
    (257, b"ustar", "a tar archive; unpack it and name the record"),
    (0, b"version https://git-lfs", "a pointer of Git LFS, not the file; fetch it with git lfs pull"),
)
"""Offset, bytes there, what the file is and what to do."""

PARTS_OF_ZIPS: tuple[tuple[str, str], ...] = (
    ("word/document.xml", "a Word document; save its table as CSV"),
    ("ppt/presentation.xml", "a presentation; save its table as CSV"),
    ("content.xml", "an OpenDocument file; save it as .xlsx or CSV"),
)


def check_kind(name: str, head: bytes) -> None:
    """Raises RecordError for a file that begins like one of another kind. head: its first 512 bytes at least.

    Two letters alone, BM and MZ, are taken for a kind only before bytes that no text holds.
    """
    for at, mark, what in KINDS:
        if head[at : at + len(mark)] == mark and (len(mark) > 2 or b"\0" in head[:64]):
            raise RecordError(f"{name}: is {what}")


def check_parts(name: str, parts: Sequence[str]) -> None:
    """Raises RecordError for a document that is a zip file."""
    for part, what in PARTS_OF_ZIPS:
        if part in parts:
            raise RecordError(f"{name}: is {what}")
