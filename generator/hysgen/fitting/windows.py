"""Windows of a long record: the consecutive samples on which the fit of a model looks at a free run, or at a path."""

from __future__ import annotations

import numpy as np

MOST_SAMPLES = 100_000
"""Samples of a record above which a fit looks at windows of as many samples in all: with at most some 80 parameters,
the standard error from the noise is then far below the error of the model's structure."""

WINDOWS = 40
"""Windows at equal distances: 2500 samples each, many time constants of the lag of a stage."""


def windows(samples: int, record_samples: int) -> list[slice]:
    """The windows of a segment of `samples`, of a record of `record_samples`; the whole segment of a short record."""
    share = MOST_SAMPLES / record_samples
    if share >= 1.0:
        return [slice(0, samples)]
    count = max(1, round(WINDOWS * samples / record_samples))
    length = max(2, int(share * samples / count))
    return [slice(start, start + length) for start in np.linspace(0, samples - length, count).astype(int).tolist()]
