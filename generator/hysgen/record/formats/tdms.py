"""TDMS: channels as "group/channel"."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hysgen.record.formats.base import FileArrays, Format, library, seconds


def read_tdms(path: Path) -> FileArrays:
    """Channels as "group/channel"; the sampling period from the waveform property wf_increment."""
    module = library("nptdms", path, "TDMS files")
    arrays, units, periods = {}, {}, set()
    for group in module.TdmsFile.read(path, raw_timestamps=True).groups():
        for channel in group.channels():
            stored = channel[:]
            values = stored.as_datetime64("ns") if hasattr(stored, "as_datetime64") else np.asarray(stored)
            key = f"{group.name}/{channel.name}"
            if values.dtype.kind in "mM":
                values, units[key] = seconds(values), "s"
            if values.dtype.kind not in "fiub" or not values.size:
                continue
            arrays[key] = values
            properties = dict(channel.properties)
            if unit := str(properties.get("unit_string", properties.get("Unit", ""))):
                units[key] = unit
            if (step := float(properties.get("wf_increment", 0.0))) > 0.0:
                periods.add(step)
    return FileArrays(arrays, units, periods.pop() if len(periods) == 1 else None)


FORMAT = Format("tdms", lambda path, head: head.startswith(b"TDSm"), read_tdms)
