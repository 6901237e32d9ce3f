"""What a stage remembers from before a record, estimated from the first rows of each segment, which are not scored.

The slow states of creep remember for their time constants, and the sensor's zero for ever; plays forget once the input
has covered its range. With the free-run error e of the model at rest under the first input, on the later half of the
rows before the first scored one,

    min over d  ||e - C d||^2 / s^2 + ||d||^2 / p^2

C: responses of the model to a deviation of 1 um of each slow state, or of the offset. s: rms of e without its mean.
p: half the range of w, a wide prior that only decides what these rows leave open.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels import lag_states
from hysgen.model.model import Model
from hysgen.model.path import InputBlock, state_key
from hysgen.model.path.creep import Creep
from hysgen.model.regression import OFFSET, Starts, drive_of, structure_of
from hysgen.model.simulate import free_run
from hysgen.record import Record, Segment

Floats = NDArray[np.float64]

FEWEST = 20
"""Rows that the estimate needs; with less, a segment starts at rest."""


def estimate_starts(model: Model, record: Record, unscored: Sequence[int]) -> Starts:
    """Initial states of each segment, by `state_key` and OFFSET; {} for a model without a response in its path.

    unscored: number of rows of each segment before the first that is scored.
    """
    if not any(block.responds for block in model.blocks):
        return [{} for _ in record.segments]
    runs = free_run(model, record)
    return [
        _start(model, record, segment, segment.y_um - run.y_um, count)
        for segment, run, count in zip(record.segments, runs, unscored, strict=True)
    ]


def _start(model: Model, record: Record, segment: Segment, error_um: Floats, count: int) -> dict[str, Floats]:
    rows = np.arange(count // 2, count)
    if rows.size < FEWEST:
        return {}
    slow = next((block for block in model.blocks if isinstance(block, Creep)), None)
    columns = _columns(model, slow, count)[:, rows]
    noise = max(float(np.std(error_um[rows])), 1e-12)
    ridge = (noise / (0.5 * model.w_range.width)) ** 2 * np.eye(len(columns))
    deviation = np.linalg.solve(columns @ columns.T + ridge, columns @ error_um[rows])
    if slow is None:
        return {OFFSET: np.asarray(deviation)}
    return {state_key(slow): slow.start(_first_input(model, record, segment, slow)) + deviation}


def _columns(model: Model, slow: Creep | None, count: int) -> Floats:
    """(d, count) responses in um to a deviation of 1 um of each slow state, or of the offset."""
    if slow is None:
        return np.ones((1, count))
    rate = np.array([1.0 - float(np.mean(model.consequents[:, 0]))])
    kept = 1.0 - slow.rates(model.Ts_s)
    fading = [slow.amount * keep ** np.arange(float(count)) for keep in kept]
    return np.stack([lag_states(column, rate, np.zeros(1))[:, 0] for column in fading])


def _first_input(model: Model, record: Record, segment: Segment, slow: InputBlock) -> float:
    """Input of a block at the first sample of a segment."""
    before = structure_of(model).before(slow)
    return float(drive_of(segment, record.Ts_s, before).u_V[0])
