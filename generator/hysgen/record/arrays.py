"""Series from the arrays of a file: by name, by path, by a selection of axes; the sampling period among scalars."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

import numpy as np

from hysgen.errors import RecordError
from hysgen.record.columns import nearest
from hysgen.record.formats.base import Array


def find(source: str, arrays: Mapping[str, Array], role: str, text: str) -> list[tuple[str, Array]]:
    """The series named by `text`: "name", "group/name" or "name[selection]".

    In a selection, a number is an index on its axis, the first ':' (or 'a:b') is the time axis, and each further ':' is
    an axis of segments; indices start at 0. Returns (label, (n,) array) for each segment.
    Raises RecordError if there is no such array, if it has several axes and no selection, or if an index is outside.
    """
    name, index = (text, None) if key_of(arrays, text) else _cut_selection(text)
    key = key_of(arrays, name)
    if key is None:
        there = ", ".join(sorted(arrays)) or "no numeric arrays"
        cure = f"--columns {role}=NAME" + (" or --columns Ts_s=SECONDS" if role == "time" else "")
        raise RecordError(
            f"{source}: has no {role} array '{name}'{nearest(name, arrays)}; it holds {there}; "
            f"say which one it is: {cure}"
        )
    array = arrays[key]
    if index is None:
        vector = np.squeeze(array)
        if vector.ndim > 1:
            example = ",".join([":"] + ["0"] * (array.ndim - 1))
            raise RecordError(
                f"{source}: {role} array '{name}' has shape {array.shape}; pick series from it, as '{name}[{example}]'"
            )
        return [("0", np.atleast_1d(vector))]
    return list(_series(source, name, array, index))


def key_of(arrays: Mapping[str, Array], name: str) -> str | None:
    """The key of the array `name`: its full path, or the last part of the path where that is unique; else None."""
    name = name.strip("/")
    if name in arrays:
        return name
    ending = [key for key in arrays if key.rpartition("/")[2] == name]
    return ending[0] if len(ending) == 1 else None


def _cut_selection(text: str) -> tuple[str, str | None]:
    match = re.fullmatch(r"(.+?)\s*\[([^\[\]]*)\]\s*", text)
    return (match.group(1), match.group(2)) if match else (text, None)


def _series(source: str, name: str, array: Array, index: str) -> Iterator[tuple[str, Array]]:
    """The series of `array` under a selection such as ":,0,:,:"; see `find`."""
    parts = [part.strip() for part in index.split(",")]
    if len(parts) != array.ndim:
        raise RecordError(
            f"{source}: '{name}[{index}]' has {len(parts)} indices, the array has {array.ndim} axes "
            f"(shape {array.shape}); give one for each axis"
        )
    ranges = []
    for axis, part in enumerate(parts):
        length = array.shape[axis]
        match = re.fullmatch(r"(-?\d+)|(\d*):(\d*)", part)
        if match is None:
            raise RecordError(f"{source}: '{part}' in '{name}[{index}]' is no index; write a number, ':' or 'a:b'")
        if match.group(1) is None:
            ranges.append(range(length)[slice(*(int(end) if end else None for end in match.group(2, 3)))])
            continue
        if not -length <= (pick := int(match.group(1))) < length:
            raise RecordError(
                f"{source}: index {pick} in '{name}[{index}]' is outside axis {axis} of length {length}; count from 0"
            )
        ranges.append(range(pick % length, pick % length + 1))
    time = next((axis for axis, part in enumerate(parts) if ":" in part), None)
    if time is None:
        raise RecordError(f"{source}: '{name}[{index}]' picks a single number; put ':' where time runs")
    segments = [axis for axis, part in enumerate(parts) if ":" in part and axis != time]
    for picks in np.ndindex(*(len(one) for axis, one in enumerate(ranges) if axis != time)):
        numbers = iter(picks)
        place = [0 if axis == time else one[next(numbers)] for axis, one in enumerate(ranges)]
        label = ",".join(str(place[axis]) for axis in segments) or "0"
        steps = slice(ranges[time].start, ranges[time].stop)
        yield label, array[tuple(steps if axis == time else at for axis, at in enumerate(place))]
