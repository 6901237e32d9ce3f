"""Which array of a file is time, voltage and displacement: `names.guessed` on the names of arrays, and matrices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hysgen.record.arrays import key_of
from hysgen.record.columns import OWN, Columns
from hysgen.record.formats import FileArrays, names_of
from hysgen.record.formats.base import Array, period_in
from hysgen.record.names import ROLES, guessed

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
        if getattr(columns, f"{role}_unit") is None and (unit := _unit(file, names[role])) is not None
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
    rising = next((at for at in range(len(picks)) if Ts_s is None and bool((np.diff(table[:, at]) > 0).all())), None)
    others = [pick for at, pick in enumerate(picks) if at != rising]
    if len(others) < 2:
        return columns, ""
    roles = {"voltage": others[0], "displacement": others[1]} | ({"time": picks[rising]} if rising is not None else {})
    pairs = ",".join(f"{role}={pick}" for role, pick in roles.items())
    return columns.named(roles), f'{source}: read as --columns "{pairs}"'
