"""MDF4: channels of each group."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from hysgen.record.formats.base import Array, FileArrays, Format, library


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


FORMAT = Format("mdf", lambda path, head: head.startswith(b"MDF     "), read_mdf)
