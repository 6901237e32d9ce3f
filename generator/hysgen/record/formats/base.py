"""What a format is: how its files are recognised and read, as text or as arrays by name; files that hold no record."""

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.columns import VOCABULARY
from hysgen.record.segment import index_of

Array = NDArray[np.generic]

EXTRA = "hysgen[formats]"


@dataclass(frozen=True, eq=False)
class FileArrays:
    """Arrays of a file by path ("group/name"), their units where the file names them, the sampling period in s.

    Of a table of text: names of all columns, numeric or not; locate, row number to "line 12"; starts, the rows before
    which the header stands again.
    """

    arrays: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)
    Ts_s: float | None = None
    remarks: tuple[str, ...] = ()
    names: tuple[str, ...] = ()
    locate: Callable[[int], str] = index_of
    starts: tuple[int, ...] = ()


class Series(NamedTuple):
    """A series as a reader meets it: its name, its values, their unit and their sampling period, where stated."""

    name: str
    values: Array
    unit: str = ""
    period_s: float = 0.0


def collected(series: Iterable[Series]) -> FileArrays:
    """Those of numbers or of times, which become s, under their names; the sampling period if all state the same."""
    arrays: dict[str, Array] = {}
    units: dict[str, str] = {}
    periods: set[float] = set()
    for name, values, unit, period_s in series:
        if values.dtype.kind in "mM":
            values, unit = seconds(values), "s"
        if values.dtype.kind in "fiub":
            arrays[name] = values
            units |= {name: unit} if unit else {}
            periods |= {period_s} - {0.0}
    return FileArrays(arrays, units, periods.pop() if len(periods) == 1 else None)


@dataclass(frozen=True)
class Text:
    """The text of a table, as bytes, and remarks."""

    data: bytes
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Format:
    """A format of files.

    recognises: whether a file is of this format, from its path and its first 520 bytes; the suffix alone decides only
    where the format has no signature. read: the content; may raise RecordError, and whatever its library raises.
    after: formats whose files have the signature of this one, and are asked first.
    """

    name: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path], Text | FileArrays]
    after: tuple[str, ...] = ()


MOST_BYTES = 2 << 30
"""Size up to which a packed file is unpacked: some 50 million rows; what is hardly packed may be larger."""

AT_ONCE, MOST_TIMES = 64 << 20, 100
"""Bytes that are unpacked in one step, and how many times its packed size a larger file may have: measured numbers pack
to a third or a tenth, a bomb to a thousandth."""


def check_size(path: Path, size: int, packed: int = 0) -> None:
    """Raises RecordError for a bomb, by the bytes unpacked or stated so far and those that they were packed to.

    packed: 0 for all of the file.
    """
    packed = packed or path.stat().st_size
    if size > max(MOST_BYTES, 2 * packed):
        raise RecordError(f"{path.name}: is more than {MOST_BYTES >> 30} GiB unpacked; unpack it and give a part")
    if size > max(AT_ONCE, MOST_TIMES * packed):
        raise RecordError(f"{path.name}: unpacks to more than {MOST_TIMES} times its size, as no measured record does")


def library(name: str, path: Path, what: str) -> Any:
    """A library of the extra `hysgen[formats]`. Raises RecordError without it."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as fault:
        raise RecordError(f"{path.name}: {what} need {fault.name}; pip install '{EXTRA}', or save it as CSV") from fault


def seconds(values: Array) -> Array:
    """Time stamps as seconds since the first, spans of time as seconds."""
    spans = np.subtract(values, values[:1]) if values.dtype.kind == "M" else values
    return np.asarray(spans.astype("timedelta64[ns]").astype(np.int64) * 1e-9)


def one_line(fault: BaseException) -> str:
    """The message of a library in one line."""
    return " ".join(str(fault).split())[:120] or type(fault).__name__


PERIODS = {name: 1.0 for name in VOCABULARY["scalars"]["period"].split()} | {
    name: -1.0 for name in VOCABULARY["scalars"]["rate"].split()
}
"""Lower-case names of scalars that give the sampling period in s (+1) or the rate in Hz (-1)."""


def period_in(values: Mapping[str, Any]) -> float | None:
    """The sampling period in s from a scalar with a name in PERIODS; None without one."""
    for key, value in values.items():
        power = PERIODS.get(key.rpartition("/")[2].lower())
        array = np.asarray(value)
        if power is not None and array.size == 1 and array.dtype.kind in "fiu" and float(np.ravel(array)[0]) > 0.0:
            return float(float(np.ravel(array)[0]) ** power)
    return None


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
