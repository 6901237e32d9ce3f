"""Formats that libraries of the extra `hysgen[formats]` read: Excel, Parquet and Feather, TDMS, MDF4, UFF 58."""

import warnings
from collections.abc import Mapping, Sequence
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.formats.base import Array, FileArrays, Format, Series, Text, collected, library
from hysgen.record.formats.packed import parts_of
from hysgen.record.spelling import is_value

MAGIC = {b"PAR1": ("pyarrow.parquet", "Parquet files"), b"ARROW1": ("pyarrow.feather", "Feather files")}


def read_arrow(path: Path) -> FileArrays:
    """Columns of an Arrow table; time stamps as seconds since the first."""
    with path.open("rb") as stream:
        head = stream.read(6)
    module, what = next(reader for magic, reader in MAGIC.items() if head.startswith(magic))
    table = library(module, path, what).read_table(path)
    return collected(Series(str(name), table.column(name).to_numpy()) for name in table.column_names)


def read_tdms(path: Path) -> FileArrays:
    """Channels as "group/channel"; the sampling period from the waveform property wf_increment."""
    file = library("nptdms", path, "TDMS files").TdmsFile.read(path, raw_timestamps=True)
    return collected(_tdms(channel) for group in file.groups() for channel in group.channels() if len(channel))


def _tdms(channel: Any) -> Series:
    stored, told = channel[:], dict(channel.properties)
    values = stored.as_datetime64("ns") if hasattr(stored, "as_datetime64") else np.asarray(stored)
    unit = str(told.get("unit_string", told.get("Unit", "")))
    return Series(f"{channel.group_name}/{channel.name}", values, unit, float(told.get("wf_increment", 0.0)))


def read_uff(path: Path) -> FileArrays:
    """Functions of dataset 58 by their id line; the sampling period is the increment of the abscissa."""
    module = library("pyuff", path, "UFF files")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = module.UFF(str(path))
        numbers = np.flatnonzero(np.asarray(file.get_set_types()) == 58).tolist()
        return collected(_uff(number, file.read_sets(number)) for number in numbers)


def _uff(number: int, stored: Mapping[str, Any]) -> Series:
    name = str(stored.get("id1") or stored.get("rsp_ent_name") or "").strip()
    name = f"channel {number}" if name in ("", "NONE") else name
    values = np.asarray(stored["data"])
    step = float(stored["abscissa_inc"]) or float(np.diff(stored["x"][:2])[0])
    return Series(name, values, str(stored.get("ordinate_axis_units_lab") or "").strip(), step)


def read_mdf(path: Path) -> FileArrays:
    """Channels of each group as "group0/channel", with the time of the group; groups of one time are one group."""
    module = library("asammdf", path, "MDF files")
    arrays: dict[str, Array] = {}
    units: dict[str, str] = {}
    with module.MDF(path) as file:
        for number, group in enumerate(file.groups):
            master = file.masters_db.get(number)
            names = [channel.name for place, channel in enumerate(group.channels) if place != master]
            folder = _group_of_time(arrays, file.get_master(number), names, number)
            for place, channel in enumerate(group.channels):
                if place == master:
                    continue
                signal = file.get(channel.name, group=number, index=place)
                if signal.samples.dtype.kind not in "fiub" or signal.samples.ndim != 1:
                    continue
                arrays[f"{folder}/time"] = signal.timestamps
                arrays[f"{folder}/{channel.name}"] = signal.samples
                units[f"{folder}/time"] = "s"
                if signal.unit:
                    units[f"{folder}/{channel.name}"] = signal.unit
    return FileArrays(arrays, units)


def _group_of_time(arrays: Mapping[str, Array], time_s: Array, names: Sequence[str], number: int) -> str:
    """The group that has these times and none of these names, else a new one of this number."""
    for key, values in arrays.items():
        folder, _, name = key.rpartition("/")
        if name == "time" and np.array_equal(values, time_s) and not any(f"{folder}/{one}" in arrays for one in names):
            return folder
    return f"group{number}"


FEWEST_ROWS = 3
"""Rows of at least two values that make a sheet a table; sheets of parameters have one value a row."""


def read_excel(path: Path) -> Text:
    openpyxl = library("openpyxl", path, "Excel files")
    book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    filled: list[tuple[str, list[list[str]]]] = []
    try:
        for sheet in book.worksheets:
            rows = [[_cell(value) for value in row] for row in sheet.iter_rows(values_only=True)]
            if sum(any(row) for row in rows) > 1:
                filled.append((str(sheet.title), rows))
                if _is_table(rows):
                    break
    finally:
        book.close()
    if not filled:
        raise RecordError(f"{path.name}: its sheets are empty; save the record in one of them")
    name, rows = filled[-1] if _is_table(filled[-1][1]) else filled[0]
    others = ", ".join(repr(other) for other, _ in filled if other != name)
    remarks = (f"{path.name}: sheet {name!r} is read, not {others}",) if others else ()
    return Text("\n".join(["\t".join(row) for row in rows] + [""]).encode(), remarks)


def _is_table(rows: Sequence[Sequence[str]]) -> bool:
    return sum(sum(map(is_value, row)) >= 2 for row in rows) >= FEWEST_ROWS


def _cell(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return "" if value is None else str(int(value))
    if isinstance(value, (datetime, time)):
        return value.isoformat().replace("T", " ")
    if isinstance(value, date):
        return value.isoformat()
    return repr(value) if isinstance(value, (int, float)) else str(value).replace("\t", " ").replace("\n", " ")


FORMATS = (
    Format("arrow", lambda path, head: head.startswith(tuple(MAGIC)), read_arrow),
    Format("tdms", lambda path, head: head.startswith(b"TDSm"), read_tdms),
    Format("uff", lambda path, head: head.lstrip()[:2] == b"-1" and b"\n" in head[:90], read_uff),
    Format("mdf", lambda path, head: head.startswith(b"MDF     "), read_mdf),
    Format("excel", lambda path, head: "xl/workbook.xml" in parts_of(path, head), read_excel),
)
