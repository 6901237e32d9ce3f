"""What a format is: how its files are recognised, and how they are read, as text or as arrays by name."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.columns import VOCABULARY

Array = NDArray[np.generic]

EXTRA = "hysgen[formats]"


@dataclass(frozen=True, eq=False)
class FileArrays:
    """Arrays of a file by path ("group/name"), their units where the file names them, the sampling period in s."""

    arrays: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)
    Ts_s: float | None = None
    remarks: tuple[str, ...] = ()


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
