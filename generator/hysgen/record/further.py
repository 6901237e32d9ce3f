"""Further columns of a file that nobody named: which of them are channels of another quantity.

A column is left out if it is

    a clock or a counter     its steps are all equal
    a second reading         c(k) is explained by displacement and voltage around sample k: the raw sensor, its
                             unfiltered channel, the set point, the position error, the amplifier's monitor

    r^2 = 1 - |c - X b|^2 / |c - mean c|^2,   X(k) = [y(k + j), u(k + j)],  j in SHIFTS,  b by least squares

A second reading explains the error of every model, because it contains the answer; as an input of the model it would
be read before the displacement that is to be predicted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.record.channels import Channels

Floats = NDArray[np.float64]

SHIFTS = (-8, -4, -2, -1, 0, 1, 2, 4, 8)
"""Shifts in samples of the displacement and of the voltage that explain a column."""

EXPLAINED = 0.9
"""r^2 from which on a column is a second reading. A second axis that moves by a signal of its own has less than 0.2."""

MOST_ROWS = 20_000
"""Rows of the least-squares problem, evenly spread over a run."""

FEWEST_ROWS = 100
"""Samples of a run that the tests need; a column of a shorter record is kept."""

EQUAL_STEPS = 1e-6
"""Largest deviation of a step of a clock from the mean step, relative to the mean step."""


def left_out(runs: Sequence[Channels]) -> dict[str, str]:
    """The further columns to leave out, by name, with the reason. runs: of one file; all have the same columns."""
    reasons = {}
    for name in runs[0].aux:
        reason = _reason([run.aux[name] for run in runs], runs)
        if reason is not None:
            reasons[name] = reason
    return reasons


def kept(aux: Mapping[str, Floats], without: Mapping[str, str]) -> dict[str, Floats]:
    """The further columns that are not left out."""
    return {name: values for name, values in aux.items() if name not in without}


def _reason(columns: Sequence[Floats], runs: Sequence[Channels]) -> str | None:
    if min(values.size for values in columns) < FEWEST_ROWS:
        return None
    if all(np.ptp(values) == 0.0 for values in columns) and len({float(values[0]) for values in columns}) == 1:
        return "it is constant"
    if all(_counts(values) for values in columns):
        return "it counts: a clock or a sample counter"
    longest = max(range(len(runs)), key=lambda number: runs[number].u_V.size)
    explained = _explained(columns[longest], runs[longest])
    if explained >= EXPLAINED:
        return f"displacement and voltage explain {100.0 * explained:.1f} % of it: a second reading of one of them"
    return None


def _counts(values: Floats) -> bool:
    steps = np.diff(values)
    mean = float(steps.mean())
    # Wrapped counters (0 .. 255) have a negative step now and then.
    usual = float(np.median(steps))
    even = np.abs(steps - usual) <= max(EQUAL_STEPS * abs(usual), 1e-3 * abs(usual))
    return usual != 0.0 and mean != 0.0 and float(np.mean(even)) > 0.95 and bool((steps[even] * usual > 0.0).all())


def _explained(values: Floats, run: Channels) -> float:
    """r^2 of a column; 0 for a constant one."""
    reach = max(SHIFTS)
    rows = np.arange(reach, values.size - reach)
    rows = rows[:: max(1, rows.size // MOST_ROWS)]
    columns = [np.ones(rows.size)]
    for series in (run.y_um, run.u_V):
        centred = (series - series.mean()) / (series.std() or 1.0)
        columns += [centred[rows + shift] for shift in SHIFTS]
    target = values[rows] - values[rows].mean()
    matrix = np.column_stack(columns)
    residual = target - matrix @ np.linalg.lstsq(matrix, target, rcond=1e-9)[0]
    power = float(target @ target)
    return 1.0 - float(residual @ residual) / power if power > 0.0 else 0.0
