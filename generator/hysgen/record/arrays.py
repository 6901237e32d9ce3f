"""Series from the arrays of a file: which array is time, voltage and displacement, by name, by path or by place; the
period among scalars; a selection of axes."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from hysgen.errors import RecordError, nearest
from hysgen.record.columns import NONE, OWN, Columns, agreed, split_unit
from hysgen.record.formats import FileArrays, names_of
from hysgen.record.formats.base import Array, period_in
from hysgen.record.names import ROLES, WORDS, by_place, guessed, to_paste, words_of


def find(source: str, file: FileArrays, columns: Columns, role: str, text: str) -> list[tuple[str, Array]]:
    """The series named by `text`: "name", "group/name" or "name[selection]"; of a table, "name" alone.

    In a selection, a number is an index on its axis, the first ':' (or 'a:b') is the time axis, and each further ':' is
    an axis of segments; indices start at 0. Returns (label, (n,) array) for each segment.
    Raises RecordError if there is no such array, if it has several axes and no selection, or if an index is outside.
    """
    if text == NONE:
        return [("0", np.zeros(max(array.shape[0] for array in file.arrays.values() if array.ndim)))]
    plain = file.names or key_of(file.arrays, text)
    chosen = None if plain else re.fullmatch(r"(.+?)\s*\[([^\[\]]*)\]\s*", text)
    name, index = chosen.groups() if chosen else (text, None)
    key = key_of(file.arrays, name)
    if key is None:
        raise RecordError(_absent(source, file, columns, role, name))
    array = file.arrays[key]
    if index is None:
        vector = np.squeeze(array)
        if vector.ndim > 1:
            example = ",".join([":"] + ["0"] * (array.ndim - 1))
            raise RecordError(
                f"{source}: {role} array '{name}' has shape {array.shape}; pick series from it, as '{name}[{example}]'"
            )
        return [("0", np.atleast_1d(vector))]
    return list(_series(source, name, array, index))


def _absent(source: str, file: FileArrays, columns: Columns, role: str, name: str) -> str:
    """What to say of a series that is not there, with those that are. Raises RecordError for one of another unit."""
    there = file.names or sorted(file.arrays)
    free = columns.quantities.other
    # A name may have the word of the role, and the unit of another quantity.
    for other in there if role in ("voltage", "displacement") and not free and len(there) > 1 else ():
        if set(words_of(other)) & set(WORDS[role]) and (unit := split_unit(other)[1]):
            columns.named({role: other}).check_unit(role, unit, source)
    cure = f"say which one it is: {to_paste(columns, {}, there)}"
    if role == "aux":
        cure = "give each further channel its own aux=NAME, as aux=a,aux=b"
    if role == "displacement" and not free:
        cure += "; if it holds another quantity, say both, as input=field [mT],output=angle [deg]"
    if role == "time":
        cure += " or, without time stamps, --columns Ts_s=SECONDS"
    if file.names and role != "time" and sum(one not in (columns.time, columns.segment) for one in file.arrays) == 1:
        cure = (
            "the file holds one channel; put voltage and displacement into one, as with "
            "paste -d, VOLTAGE.csv DISPLACEMENT.csv > record.csv"
        )
    if len(file.names) == 1:
        cure = "give --columns separator=... if that is several names in one"
    kind, holds = ("column", "the header names") if file.names else ("array", "it holds")
    return f"{source}: has no {role} {kind} '{name}'{nearest(name, there)}; {holds} {', '.join(there)}; {cure}"


def key_of(arrays: Mapping[str, Array], name: str) -> str | None:
    """The key of the array `name`: its full path, or the last part of the path where that is unique; else None."""
    name = name.strip("/")
    if name in arrays:
        return name
    ending = [key for key in arrays if key.rpartition("/")[2] == name]
    return ending[0] if len(ending) == 1 else None


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


MOST_COLUMNS = 64
"""Columns of a matrix that is read as a table."""


def chosen_arrays(source: str, file: FileArrays, columns: Columns) -> tuple[Columns, float | None, str]:
    """The columns with an array for each role that the user did not name; the period in s; a message that states them.

    A matrix without other arrays is a table: the first column that rises is time, then voltage, then displacement.
    """
    Ts_s = columns.Ts_s or period_in(file.arrays) or file.Ts_s
    matrix = _matrix(file.arrays)
    if matrix is not None and (columns.voltage, columns.displacement) == (OWN["voltage"], OWN["displacement"]):
        chosen, guess = _by_place(matrix, file.arrays[matrix], columns, Ts_s, source)
        return chosen, Ts_s, guess
    labels = {label: key.rpartition("/")[2] for key, label in names_of(file)}
    there = [OWN[role] for role in ROLES if key_of(file.arrays, OWN[role]) is not None]
    chosen, guess = guessed(replace(columns, Ts_s=Ts_s), [*labels, *there], source)
    names = {role: labels.get(getattr(chosen, role), getattr(chosen, role)) for role in ROLES}
    units = {
        role: unit
        for role in ROLES
        if getattr(columns, f"{role}_unit") is None
        and (unit := agreed(source, names[role], {"the file": _unit(file, names[role])})) is not None
    }
    return replace(chosen.named(names, units), Ts_s=columns.Ts_s), Ts_s, guess


def _unit(file: FileArrays, name: str) -> str | None:
    """The unit that the file gives the array `name`, in any group."""
    return next((unit for key, unit in file.units.items() if key == name or key.endswith(f"/{name}")), None)


def _matrix(arrays: Mapping[str, Array]) -> str | None:
    """The name of the only matrix of a file without vectors; None otherwise."""
    large = [key for key, array in arrays.items() if array.size > 1]
    if len(large) != 1 or np.squeeze(arrays[large[0]]).ndim != 2:
        return None
    return large[0] if min(arrays[large[0]].shape) <= MOST_COLUMNS else None


def _by_place(name: str, matrix: Array, columns: Columns, Ts_s: float | None, source: str) -> tuple[Columns, str]:
    tall = matrix.shape[0] >= matrix.shape[1]
    table = matrix if tall else matrix.T
    picks = [f"{name}[:,{place}]" if tall else f"{name}[{place},:]" for place in range(table.shape[1])]
    rising = (pick for pick, one in zip(picks, table.T, strict=True) if Ts_s is None and bool((np.diff(one) > 0).all()))
    chosen, option = by_place(columns, picks, next(rising, None))
    return chosen, option and f"{source}: read as {option}"
