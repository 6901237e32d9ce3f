"""What a stage remembers from before a record, estimated from the first rows of each segment, which are not scored.

Plays forget once the input has covered its range. The slow states of creep, and the sensor's zero, leave an offset;
slow states start at rest under the first input. With mean m and standard deviation s of the free-run error of the
model, on the later two thirds of the rows before the first scored one, the offset is

    m^3 / (m^2 + s^2)

the mean, shrunk because the error of plays that have not yet forgotten is correlated over all these rows, which count
as one. (Slow states of their own, fitted to these rows, left 2 to 12 times the error of the offset alone on stages of
other equations: the rows are too few to tell decades of time apart.)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.model.model import Model
from hysgen.model.regression import OFFSET, Starts
from hysgen.model.simulate import free_run
from hysgen.record import Record

Floats = NDArray[np.float64]

CORRUPTED = 10.0
"""A row counts up to this multiple of the median distance from the median: 6.7 standard deviations of white noise."""

FEWEST = 20
"""Rows that the estimate needs; with less, a segment has no offset."""


def estimate_starts(model: Model, record: Record, unscored: Sequence[int]) -> Starts:
    """The offset of each segment in um, under the key OFFSET; {} for a model without a response in its path.

    unscored: number of rows of each segment before the first that is scored.
    """
    if not any(block.responds for block in model.blocks):
        return [{} for _ in record.segments]
    runs = free_run(model, record)
    return [
        _start(segment.y_um - run.y_um, count)
        for segment, run, count in zip(record.segments, runs, unscored, strict=True)
    ]


def _start(error_um: Floats, count: int) -> dict[str, Floats]:
    shown = error_um[count // 3 : count]
    if shown.size < FEWEST:
        return {}
    away = np.abs(shown - np.median(shown))
    shown = shown[away <= CORRUPTED * np.median(away)]
    mean, variance = float(np.mean(shown)), float(np.var(shown))
    return {OFFSET: np.array([mean**3 / max(mean**2 + variance, 1e-300)])}
