"""Steps of the voltage that the displacement answers in their own row, where the model has it answer from the next on.

    d(k) = y(k) - 2 y(k-1) + y(k-2),   s = sum d(k) du(k) / (g sum du(k)^2)   over the rows k with a step du(k)

d is what the displacement moves beyond its motion before the step, g the gain of the record. s is 0 for
y(k+1) = f(y(k), u(k)), and the first sample of the answer to a step where both columns were written at the end of a
period: such a log is one row off, and the error at every step would be taken for a fault of the sensor.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.record.segment import Segment

Floats = NDArray[np.float64]

FEWEST = 3
"""Fewest steps: a single one may coincide with a knock."""

STEP, BEFORE = 0.02, 0.1
"""Least step, as a share of the range, and largest change in each of the two rows before it, as a share of the step."""

LEAST_SHARE, CLEARLY = 0.01, 5.0
"""Least share of the answer in the step's own row, that of a lag of 100 samples, and its standard errors."""


def same_row(runs: Sequence[Segment]) -> Iterator[str]:
    """A line for a displacement that answers a step of the voltage in the row of the step."""
    steps, moves, gains = [], [], []
    for run in runs:
        du, d = _steps(run)
        steps.append(du)
        moves.append(d)
        gains.append(_gain(run))
    du, d, gain = np.concatenate(steps), np.concatenate(moves), float(np.mean(gains))
    power = float(du @ du)
    if len(du) < FEWEST or gain == 0.0:
        return
    share = float(d @ du) / power
    error = float(np.sqrt(np.sum(((d - share * du) * du) ** 2))) / power
    if share / gain > LEAST_SHARE and abs(share) > CLEARLY * error:
        file = runs[0].origin
        yield (
            f"{file.source}: {file.displacement} answers {len(du)} steps of {file.voltage} in their own rows (with "
            f"{100.0 * share / gain:.0f} % of the answer), but a voltage acts from the next row on: if it is "
            "written a row early, --columns shift=1"
        )


def _steps(run: Segment) -> tuple[Floats, Floats]:
    """(m,) steps du(k) of a run and the moves d(k) of the displacement in their rows."""
    du = np.diff(run.u_V)
    size = np.abs(du)
    quiet = (size[:-2] <= BEFORE * size[2:]) & (size[1:-1] <= BEFORE * size[2:])
    at = 2 + np.flatnonzero(quiet & (size[2:] >= STEP * np.ptp(run.u_V)) & (size[2:] > 0.0))
    y = run.y_um
    return du[at], y[at + 1] - 2.0 * y[at] + y[at - 1]


def _gain(run: Segment) -> float:
    """Slope of the straight line through displacement over voltage, um/V; 0 for a constant voltage."""
    u = run.u_V - run.u_V.mean()
    power = float(u @ u)
    return float(u @ run.y_um) / power if power > 0.0 else 0.0
