"""Further columns of a file that nobody named: which of them are channels of another quantity.

A column is left out if it is

    a clock or a counter     its steps are all equal
    a late copy              c(k) correlates with a displacement before it: a second logger, a slow channel
    a second reading         c(k) is explained by displacement and voltage around sample k: the raw sensor, its
                             filtered or unfiltered channel, the set point, the position error, the amplifier's monitor
    constant

    r^2 = 1 - |c - X b|^2 / |c - mean c|^2,   X(k) = [y(k + j), u(k + j), F_i y(k)],  j in SHIFTS,  F_i first-order
    low-pass filters,  b by least squares

A second reading explains the error of every model, because it contains the answer; as an input of the model it would
be read before the displacement that is to be predicted.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from hysgen.record.relation import MOST, correlations
from hysgen.record.segment import Segment

Floats = NDArray[np.float64]

SHIFTS = (-8, -4, -2, -1, 0, 1, 2, 4, 8)
"""Shifts in samples of the displacement and of the voltage that explain a column."""

EXPLAINED = 0.9
"""r^2 from which on a column is a second reading. A second axis that moves by a signal of its own has less than 0.2."""

FASTEST_FILTER, FILTERS_IN = 8.0, 20.0
"""Time constants of first-order filters of the displacement, in samples: from 8 on, doubled, up to 1/20 of the run.
Slower ones follow the drift of any slow channel."""

LATE_COPY = 0.95
"""Correlation with a displacement before it from which on a column is a late copy; its square is EXPLAINED."""

MOST_ROWS = 20_000
"""Rows of the least-squares problem, evenly spread over a run."""

FEWEST_ROWS = 100
"""Samples of a run that the tests need; a column of a shorter record is kept."""

EQUAL_STEPS = 1e-3
"""Largest deviation of a step of a clock from the usual step, relative to that."""


def left_out(runs: Sequence[Segment]) -> dict[str, str]:
    """The further columns to leave out, by name, with the reason. runs: of one file; all have the same columns."""
    reasons = ((name, _reason([run.aux[name] for run in runs], runs)) for name in runs[0].aux)
    return {name: reason for name, reason in reasons if reason is not None}


def _reason(columns: Sequence[Floats], runs: Sequence[Segment]) -> str | None:
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
    return _late_copy(columns[longest], runs[longest])


def _counts(values: Floats) -> bool:
    steps = np.diff(values)
    mean = float(steps.mean())
    # Wrapped counters (0 .. 255) have a negative step now and then.
    usual = float(np.median(steps))
    even = np.abs(steps - usual) <= EQUAL_STEPS * abs(usual)
    return usual != 0.0 and mean != 0.0 and float(np.mean(even)) > 0.95 and bool((steps[even] * usual > 0.0).all())


def _late_copy(values: Floats, run: Segment) -> str | None:
    """What to say of a column that is a displacement before it, None if it is none."""
    found = correlations(run.y_um, values)
    if found is None:
        return None
    later = found[0] > 0
    # A shift by L leaves 1 - L/n of the sum.
    lags, c = found[0][later], found[1][later] / (1.0 - found[0][later] / min(values.size, MOST))
    best = int(np.argmax(np.abs(c)))
    if not abs(float(c[best])) >= LATE_COPY:
        return None
    return f"it follows the displacement {lags[best]} samples later (correlation {c[best]:.2f})"


def _filtered(values: Floats) -> list[Floats]:
    """The values, (n,), behind first-order low-pass filters of several time constants, from rest at the first value."""
    about = (values - values[0]) / (values.std() or 1.0)
    size = next_fast_len(2 * values.size, real=True)
    spectrum, samples = rfft(about, size), np.arange(values.size)
    filtered, time_constant = [], FASTEST_FILTER
    while time_constant <= values.size / FILTERS_IN:
        response = -np.expm1(-1.0 / time_constant) * np.exp(-samples / time_constant)
        filtered.append(irfft(spectrum * rfft(response, size), size)[: values.size])
        time_constant *= 2.0
    return filtered


def _explained(values: Floats, run: Segment) -> float:
    """r^2 of a column; 0 for a constant one."""
    reach = max(SHIFTS)
    rows = np.arange(reach, values.size - reach)
    rows = rows[:: max(1, rows.size // MOST_ROWS)]
    columns = [np.ones(rows.size)]
    for series in (run.y_um, run.u_V):
        centred = (series - series.mean()) / (series.std() or 1.0)
        columns += [centred[rows + shift] for shift in SHIFTS]
    columns += [filtered[rows] for filtered in _filtered(run.y_um)]
    target = values[rows] - values[rows].mean()
    matrix = np.column_stack(columns)
    residual = target - matrix @ np.linalg.lstsq(matrix, target, rcond=1e-9)[0]
    power = float(target @ target)
    return 1.0 - float(residual @ residual) / power if power > 0.0 else 0.0
