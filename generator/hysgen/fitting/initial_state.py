"""What a stage remembers from before a record, estimated from the first rows of each segment, which are not scored.

The slow states of creep remember for their time constants, and the sensor's zero for ever; plays forget once the input
has covered its range. With the free-run error e of the model, whose slow states start at the mean of their input over
the segment, on the later two thirds of the rows before the first scored one,

    min over d  mean (e - C d)^2 / s^2 + sum_i (c_i d_i)^2 / p^2

C: responses of the model to a deviation of 1 um of the offset and of each slow state, and c_i their mean sizes.
s: rms of e without its mean, and p the mean: the error of plays that have not yet forgotten is correlated over all
these rows, which count as one.
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

CORRUPTED = 10.0
"""A row counts up to this multiple of the median distance from the median: 6.7 standard deviations of white noise."""

FEWEST = 20
"""Rows that the estimate needs; with less, a segment starts at rest."""


def estimate_starts(model: Model, record: Record, unscored: Sequence[int]) -> Starts:
    """Initial states of each segment, by `state_key` and OFFSET; {} for a model without a response in its path.

    unscored: number of rows of each segment before the first that is scored.
    """
    if not any(block.responds for block in model.blocks):
        return [{} for _ in record.segments]
    usual = [_usual(model, record, segment) for segment in record.segments]
    runs = free_run(model, record, usual)
    return [
        _start(model, record, segment, segment.y_um - run.y_um, count)
        for segment, run, count in zip(record.segments, runs, unscored, strict=True)
    ]


def _usual(model: Model, record: Record, segment: Segment) -> dict[str, Floats]:
    """The states before a segment whose past was like the segment: slow states at the mean of their input."""
    slow = _creep(model)
    return {} if slow is None else {state_key(slow): slow.start(_mean_input(model, record, segment, slow))}


def _creep(model: Model) -> Creep | None:
    return next((block for block in model.blocks if isinstance(block, Creep)), None)


def _start(model: Model, record: Record, segment: Segment, error_um: Floats, count: int) -> dict[str, Floats]:
    rows = np.arange(count // 3, count)
    if rows.size < FEWEST:
        return _usual(model, record, segment)
    slow = _creep(model)
    away = np.abs(error_um[rows] - np.median(error_um[rows]))
    rows = rows[away <= CORRUPTED * np.median(away)]
    columns = _columns(model, slow, count)[:, rows]
    mean, spread = float(np.mean(error_um[rows])), float(np.std(error_um[rows]))
    # The prior of every deviation is the one that contributes the mean: a slow state contributes `amount` um per um.
    unit = np.abs(columns).mean(axis=1) + 1e-12
    ridge = rows.size * np.diag((unit * spread / max(abs(mean), 1e-9)) ** 2)
    deviation = np.linalg.solve(columns @ columns.T + ridge, columns @ error_um[rows])
    if slow is None:
        return {OFFSET: np.asarray(deviation)}
    crept = slow.start(_mean_input(model, record, segment, slow)) + deviation[1:]
    return {OFFSET: np.asarray(deviation[:1]), state_key(slow): crept}


def _columns(model: Model, slow: Creep | None, count: int) -> Floats:
    """(d, count) responses in um to a deviation of 1 um of the offset, and of each slow state."""
    if slow is None:
        return np.ones((1, count))
    rate = np.array([1.0 - float(np.mean(model.consequents[:, 0]))])
    kept = 1.0 - slow.rates(model.Ts_s)
    fading = [slow.amount * keep ** np.arange(float(count)) for keep in kept]
    return np.stack([np.ones(count), *(lag_states(column, rate, np.zeros(1))[:, 0] for column in fading)])


def _mean_input(model: Model, record: Record, segment: Segment, slow: InputBlock) -> float:
    """Mean input of a block over a segment: what its slow states are near if the past was like the segment."""
    before = structure_of(model).before(slow)
    return float(np.mean(drive_of(segment, record.Ts_s, before).u_V))
