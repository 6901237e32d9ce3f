"""UFF: functions of dataset 58."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from hysgen.record.formats.base import FileArrays, Format, library


def read_uff(path: Path) -> FileArrays:
    """Functions of dataset 58 by their id line; the sampling period is the increment of the abscissa."""
    module = library("pyuff", path, "UFF files")
    arrays, units, periods = {}, {}, set()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = module.UFF(str(path))
        for number in np.flatnonzero(np.asarray(file.get_set_types()) == 58):
            one = file.read_sets(int(number))
            values = np.asarray(one["data"])
            if values.dtype.kind != "f":
                continue
            name = str(one.get("id1") or one.get("rsp_ent_name") or "").strip()
            name = f"channel {number}" if name in ("", "NONE") else name
            arrays[name] = values
            if unit := str(one.get("ordinate_axis_units_lab") or "").strip():
                units[name] = unit
            periods.add(float(one["abscissa_inc"]) or float(np.diff(one["x"][:2])[0]))
    return FileArrays(arrays, units, periods.pop() if len(periods) == 1 else None)


FORMAT = Format("uff", lambda path, head: head.lstrip()[:2] == b"-1" and b"\n" in head[:90], read_uff)
