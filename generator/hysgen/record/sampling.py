"""The sampling period from time stamps, and checks of the stamps: gaps, jitter, stamps that do not rise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.segment import Segment

JITTER = 0.05
"""Largest deviation of one step from the period, relative to the period.

A sample taken 5 % of a period late has an error of 5 % of the movement in one step. A 22.7 us clock (44.1 kHz) written
in whole microseconds, which is valid, has steps that are 3 % off.
"""
GAP = 1.5
"""A step longer than this many periods is a gap: samples are missing."""
FEWEST_ROUNDED = 20
"""Segment of a run that show whether they are rounded."""

AGREEMENT = 0.01
"""Largest relative difference between the period given by the user and the period of the time stamps."""


def gap_rows(time_s: NDArray[np.float64]) -> NDArray[np.intp]:
    """Rows after a gap: the step before them is longer than 1.5 times the median step."""
    steps = np.diff(time_s)
    return np.flatnonzero(steps > GAP * np.median(steps)) + 1


def sampling_period(runs: Sequence[Segment], jitter: float = JITTER, given_s: float | None = None) -> float:
    """The sampling period in s of all runs.

    Each step is compared with the median step. The result is the mean step, whose rounding error falls with the number
    of samples, as the number with the fewest digits within that error, in s or in Hz: stamps 0, 0.00133333333,
    0.00266666667 ... give 1/750 s.

    Raises RecordError with file, row and cure for stamps that are not finite or do not rise, for a gap, for a step more
    than `jitter` periods off, and for a period `given_s` that differs by more than 1 %.
    """
    rounded = [_rounded(run) for run in runs]
    if all(period is not None for period in rounded):
        # The logger wrote the time with few digits: the samples are even, the stamps are not.
        return _same_period(runs, [period for period in rounded if period is not None], given_s)
    for run in runs:
        _check_rising(run)
    median = float(np.median(np.concatenate([np.diff(run.stamps_s) for run in runs])))
    for run in runs:
        _check_even(run, median, jitter)
    steps = sum(run.stamps_s.size - 1 for run in runs)
    mean = sum(float(run.stamps_s[-1] - run.stamps_s[0]) for run in runs) / steps
    if given_s is not None:
        file = runs[0].origin
        if abs(given_s - mean) > AGREEMENT * mean:
            raise RecordError(
                f"{file.source}: Ts_s = {given_s:g} s was given, but {file.time} rises by {mean:.6g} s per row; "
                "correct one of them, give --columns time_unit=..., or read without it: --columns time=,Ts_s=..."
            )
        return given_s
    return _simplest(mean, 2.0 * len(runs) * max(_rounding(run, mean) for run in runs) / steps)


def rounding_line(runs: Sequence[Segment]) -> str | None:
    """A line for time stamps that the logger rounded; None for others."""
    if any(_rounded(run) is None for run in runs):
        return None
    quantum = _quantum(runs[0].stamps_s)
    return (
        f"{runs[0].origin.source}: {runs[0].origin.time} is rounded to {quantum:g} s; the samples are taken to be even "
        "(if they are not, give --columns Ts_s=SECONDS)"
    )


def _same_period(runs: Sequence[Segment], periods: Sequence[float], given_s: float | None) -> float:
    steps = sum(run.stamps_s.size - 1 for run in runs)
    mean = sum(period * (run.stamps_s.size - 1) for run, period in zip(runs, periods, strict=True)) / steps
    if given_s is not None:
        return given_s
    uncertainty = 2.0 * _quantum(runs[0].stamps_s) / max(run.stamps_s.size - 1 for run in runs)
    return _simplest(mean, uncertainty)


def _quantum(time_s: NDArray[np.float64]) -> float:
    """The smallest positive step, as a decimal with one or two digits."""
    steps = np.diff(time_s)
    positive = steps[steps > 0.0]
    return float(f"{positive.min():.2g}") if positive.size else 0.0


def _rounded(run: Segment) -> float | None:
    """The period in s of stamps that lie on a uniform grid within their last digit and are not even; else None.

    Rounded stamps repeat, or their steps differ by multiples of the quantum q, and |t(k) - t(0) - k Ts| <= q for all k.
    """
    if run.stamps_s.size < FEWEST_ROUNDED or not np.isfinite(run.stamps_s).all():
        return None
    steps = np.diff(run.stamps_s)
    if steps.min() < 0.0 or steps.max() <= 0.0:
        return None
    quantum = _quantum(run.stamps_s)
    period = float(run.stamps_s[-1] - run.stamps_s[0]) / steps.size
    repeats = float(np.mean(steps == 0.0))
    uneven = float(np.max(np.abs(steps - period))) > JITTER * period
    whole = np.abs(steps / quantum - np.rint(steps / quantum)).max() < 0.01 if quantum else False
    between = (period / quantum) % 1.0 if quantum else 0.0
    # One row twice, or one row lost, in stamps of enough digits: a fault of the file, and no rounding.
    if min(between, 1.0 - between) < 0.02:
        return None
    if not (repeats > 0.0 or uneven) or not whole or steps.max() > np.ceil(period / quantum + 1e-9) * quantum * 1.01:
        return None
    grid = run.stamps_s[0] + period * np.arange(run.stamps_s.size)
    return period if float(np.max(np.abs(run.stamps_s - grid))) <= 1.5 * quantum else None


def _check_rising(run: Segment) -> None:
    finite = np.isfinite(run.stamps_s)
    if not finite.all():
        row = int(np.argmin(finite))
        where = f"{run.origin.at(row)}: {run.origin.time}"
        raise RecordError(f"{where} is {run.stamps_s[row]}; write its time")
    steps = np.diff(run.stamps_s)
    if (steps > 0.0).all():
        return
    row = int(np.argmax(steps <= 0.0)) + 1
    now, before = run.stamps_s[row], run.stamps_s[row - 1]
    where = f"{run.origin.at(row)}: {run.origin.time}"
    if now == before:
        raise RecordError(
            f"{where} repeats {now:.9g} s; delete one of the two rows, "
            "or, if the logger rounds, read without the column: --columns time=,Ts_s=SECONDS"
        )
    raise RecordError(
        f"{where} falls from {before:.9g} to {now:.9g} s; sort the rows, or number the runs in a segment column"
    )


def _check_even(run: Segment, period: float, jitter: float) -> None:
    steps = np.diff(run.stamps_s)
    name = run.origin.time
    gaps = np.flatnonzero(steps > GAP * period)
    if gaps.size:
        step = int(gaps[0])
        raise RecordError(
            f"{run.origin.at(step + 1)}: {name} jumps from {run.stamps_s[step]:.9g} s by "
            f"{steps[step]:.6g} s where the period is {period:.6g} s ({gaps.size} such gaps); "
            "number the runs in a segment column, or give --split-at-gaps"
        )
    off = np.abs(steps - period) / period
    step = int(np.argmax(off))
    if off[step] > jitter:
        raise RecordError(
            f"{run.origin.at(step + 1)}: {name} steps by {steps[step]:.6g} s where the period is "
            f"{period:.6g} s: {100 * off[step]:.1f} % off, the worst of {np.count_nonzero(off > jitter)} "
            f"above {100 * jitter:g} %; sample evenly, write the time with more digits, or give "
            f"--jitter {np.ceil(100.0 * off[step]) / 100.0:g}"
        )


def _rounding(run: Segment, period: float) -> float:
    """Largest distance in s of a stamp from the uniform grid through the run's first stamp."""
    grid = run.stamps_s[0] + period * np.arange(run.stamps_s.size)
    return float(max(np.max(np.abs(run.stamps_s - grid)), np.spacing(np.max(np.abs(run.stamps_s)))))


def _simplest(period: float, uncertainty: float) -> float:
    """The number with the fewest digits, as a period or as a rate, within `uncertainty` of `period`."""
    for digits in range(1, 16):
        for candidate in (float(f"{period:.{digits}g}"), 1.0 / float(f"{1.0 / period:.{digits}g}")):
            if abs(candidate - period) <= uncertainty:
                return candidate
    return period
