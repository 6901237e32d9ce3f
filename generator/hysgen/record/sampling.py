"""The sampling period from time stamps, and checks of the stamps: gaps, jitter, stamps that do not rise.

Counters that overflow, which are continued, and rows of a buffer that was never filled, which are left out.

    time            falls at a row, and rises by the usual step if M is added there
    displacement    jumps by nearly M at some rows, M more than its range, and moves as usual if M is taken off

M is 2^16, 2^24, 2^31 or 2^32 of what the column counts, of a displacement any 2^b from 2^8 on, and for a time of day
what a clock begins again after. Rows of zeros (or of no numbers) at an end are no samples if the time stands still in
them, or if the displacement jumps there as it does nowhere else.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

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
"""Stamps of a run that show whether they are rounded."""

REPEATED = 0.2
"""Share of stamps that repeat the one before them, from which on they are rounded to more than a period."""

AGREEMENT = 0.01
"""Largest relative difference between the period given by the user and the period of the time stamps."""


class Rounded(NamedTuple):
    """Stamps that a logger rounded: period of the samples, its error, and quantum of the stamps, all in s."""

    period_s: float
    error_s: float
    quantum_s: float


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
    lengths = np.array([run.samples - 1 for run in runs])
    rounded = [one for run in runs if (one := _rounded(run)) is not None]
    if len(rounded) == len(runs):
        # The logger wrote the time with few digits: the samples are even, the stamps are not.
        mean, error, _ = (float(value) for value in np.average(rounded, axis=0, weights=lengths))
        return given_s or _simplest(mean, error)
    for run in runs:
        _check_rising(run)
    median = float(np.median(np.concatenate([np.diff(run.stamps_s) for run in runs])))
    for run in runs:
        _check_even(run, median, jitter)
    mean = sum(float(run.stamps_s[-1] - run.stamps_s[0]) for run in runs) / int(lengths.sum())
    if given_s is not None:
        file = runs[0].origin
        if abs(given_s - mean) > AGREEMENT * mean:
            raise RecordError(
                f"{file.source}: Ts_s = {given_s:g} s was given, but {file.time} rises by {mean:.6g} s per row; "
                "correct one of them, give --columns time_unit=..., or read without it: --columns time=,Ts_s=..."
            )
        return given_s
    return _simplest(mean, 2.0 * len(runs) * max(_rounding(run, mean) for run in runs) / int(lengths.sum()))


def rounding_line(runs: Sequence[Segment]) -> str | None:
    """A line for time stamps that the logger rounded; None for others."""
    first, *others = (_rounded(run) for run in runs)
    if first is None or None in others:
        return None
    file = runs[0].origin
    return (
        f"{file.source}: {file.time} is rounded to {first.quantum_s:.3g} s; the samples are taken to be even "
        "(if they are not, give --columns Ts_s=SECONDS)"
    )


def _rounded(run: Segment) -> Rounded | None:
    """Period, its error, and quantum q of stamps that lie on a uniform grid within q and are not even.

        |t(k) - a - k Ts| <= q,   a and Ts by least squares,   q a usual step that is not zero

    Rounded stamps repeat, or their steps are whole multiples of the smallest. None for other stamps.
    """
    if run.samples < FEWEST_ROUNDED or not np.isfinite(run.stamps_s).all():
        return None
    time_s = run.stamps_s - run.stamps_s[0]
    steps = np.diff(time_s)
    if steps.min() < 0.0 or steps.max() <= 0.0:
        return None
    row = np.arange(run.samples) - 0.5 * (run.samples - 1)
    period = float(row @ time_s) / float(row @ row)
    positive = steps[steps > 0.0]
    quantum = smallest = float(positive.min())
    if positive.size < (1.0 - REPEATED) * steps.size:
        # Stamps of six digits or of float32 are written more coarsely from a power of ten or of two on.
        quantum = float(np.quantile(positive, 0.9))
    elif np.abs(steps / smallest - np.rint(steps / smallest)).max() > 0.01:
        return None
    # One row twice, or one row lost, in stamps of enough digits: a fault of the file, and no rounding.
    between = (period / quantum) % 1.0
    if period > 0.5 * quantum and min(between, 1.0 - between) < 0.02:
        return None
    if not float(np.max(np.abs(steps - period))) > JITTER * period:
        return None
    if steps.max() > 1.01 * quantum * max(2.0, np.ceil(period / quantum + 1e-9)):
        return None
    off = time_s - time_s.mean() - period * row
    error = 3.0 * quantum / (steps.size * positive.size**0.5)
    return Rounded(period, error, quantum) if float(np.max(np.abs(off))) <= 1.01 * quantum else None


def _check_rising(run: Segment) -> None:
    finite = np.isfinite(run.stamps_s)
    if not finite.all():
        row = int(np.argmin(finite))
        raise RecordError(f"{run.origin.at(row)}: {run.origin.time} is {run.stamps_s[row]}; write its time")
    steps = np.diff(run.stamps_s)
    if (steps > 0.0).all():
        return
    row = int(np.argmax(steps <= 0.0)) + 1
    now, before = run.stamps_s[row], run.stamps_s[row - 1]
    where = f"{run.origin.at(row)}: {run.origin.time}"
    if now == before:
        raise RecordError(
            f"{where} repeats {now:.9g} s, one of {np.count_nonzero(steps == 0.0)} such rows; delete one of the two "
            f"rows, or, if the logger rounds, read without the column: --columns time=,Ts_s={np.mean(steps):.4g}"
        )
    raise RecordError(
        f"{where} falls from {before:.9g} to {now:.9g} s; sort the rows, or number the runs in a segment column"
    )


def _check_even(run: Segment, period: float, jitter: float) -> None:
    steps = np.diff(run.stamps_s)
    gaps = np.flatnonzero(steps > GAP * period)
    if gaps.size:
        step = int(gaps[0])
        raise RecordError(
            f"{run.origin.at(step + 1)}: {run.origin.time} jumps from {run.stamps_s[step]:.9g} s by "
            f"{steps[step]:.6g} s where the period is {period:.6g} s ({gaps.size} such gaps); "
            "number the runs in a segment column, or give --split-at-gaps"
        )
    off = np.abs(steps - period) / period
    step = int(np.argmax(off))
    if off[step] > jitter:
        raise RecordError(
            f"{run.origin.at(step + 1)}: {run.origin.time} steps by {steps[step]:.6g} s where the period is "
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


Floats = NDArray[np.float64]

COUNTS = tuple(2.0**bits for bits in (16, 24, 31, 32))
FRACTIONS = (1.0, 1e-3, 1e-6, 1e-9)
"""Counts in one of the file's units: milliseconds that are written as seconds overflow at 65.536."""
CLOCKS_S = (86_400.0, 43_200.0, 3600.0)
"""Spans after which a clock begins again."""
DIGITS = 7
"""Decimal digits in which a displacement may count."""
FEWEST_EMPTY = 3
"""Rows of zeros at an end, while the time goes on, that are taken for a buffer that was not filled."""


def mended(run: Segment, time_unit_s: float, unit_um: float) -> tuple[Segment, list[str]]:
    """The run without empty ends and with its counters continued, and a line for each of these.

    time_unit_s, unit_um: what one in the file is.
    """
    run, lines = _without_empty_ends(run)
    file = run.origin
    moduli = [count * part * time_unit_s for count in COUNTS for part in FRACTIONS] + [*CLOCKS_S]
    for name, attribute, unit, found in (
        (file.time, "stamps_s", "s", _overflow_of_time(run.stamps_s, moduli)),
        (file.displacement, "y_um", "um", _overflow_of_displacement(run.y_um, unit_um)),
    ):
        if found is not None:
            modulus, turns = found
            rows = np.flatnonzero(np.diff(turns)) + 1
            more = f" and {rows.size - 1} more rows" if rows.size > 1 else ""
            lines.append(
                f"{file.at(int(rows[0]))}: {name} jumps by {modulus:.10g} {unit}, the overflow of a counter, in this"
                f"{more or ' row'}; it is continued there"
            )
            run = replace(run, **{attribute: getattr(run, attribute) + modulus * turns})
    return run, lines


def _overflow_of_time(time_s: Floats, moduli: Sequence[float]) -> tuple[float, Floats] | None:
    """Modulus and the number of overflows before each row, (n,); None for a time that needs none."""
    steps = np.diff(time_s)
    falls = steps < 0.0
    if not falls.any() or not (steps > 0.0).any() or not np.isfinite(steps).all():
        return None
    usual = float(np.median(steps[steps > 0.0]))
    for modulus in moduli:
        if np.all(np.abs(steps[falls] + modulus - usual) <= 0.5 * usual):
            return modulus, np.concatenate([[0.0], np.cumsum(falls)])
    return None


def _overflow_of_displacement(y_um: Floats, unit_um: float) -> tuple[float, Floats] | None:
    """Modulus and the number of overflows before each row, (n,); None for a displacement that needs none."""
    steps, span = np.diff(y_um), float(np.ptp(y_um)) if y_um.size else 0.0
    if not 0.0 < span < np.inf:
        return None
    digits = next((d for d in range(DIGITS) if _whole(y_um[:1000] / (unit_um * 0.1**d))), None)
    if digits is None:
        return None
    for bits in range(8, 33):
        modulus = 2.0**bits * unit_um * 0.1**digits
        if not span <= modulus <= 1.25 * span:
            continue
        turns = np.rint(steps / modulus)
        usual = float(np.abs(steps[turns == 0.0]).max(initial=0.0))
        rest = float(np.abs(steps - turns * modulus).max())
        if turns.any() and rest <= 2.0 * usual and 8.0 * usual < modulus <= span + 4.0 * usual:
            return modulus, -np.concatenate([[0.0], np.cumsum(turns)])
    return None


def _whole(values: Floats) -> bool:
    return bool(np.abs(values - np.rint(values)).max() < 1e-6 * max(1.0, float(np.abs(values).max()) * 1e-6))


def _without_empty_ends(run: Segment) -> tuple[Segment, list[str]]:
    """The run without rows of zeros, or of no numbers, before or after its samples, and a line for each end."""
    empty = ((run.u_V == 0.0) & (run.y_um == 0.0)) | (np.isnan(run.u_V) & np.isnan(run.y_um))
    if not (empty.size and (empty[0] or empty[-1])) or empty.all():
        return run, []
    first, stop = int(np.argmin(empty)), run.samples - int(np.argmin(empty[::-1]))
    steps = np.abs(np.diff(run.y_um[first:stop]))
    largest = float(steps.max(initial=0.0))
    lines = []
    for begin, end, inside, which in ((0, first, first, "first"), (stop, run.samples, stop - 1, "last")):
        stamps = run.stamps_s[begin:end]
        stands = stamps.size > 0 and bool(np.isnan(stamps).all() or (stamps == 0.0).all())
        stands = stands and (begin > 0 or end - begin >= FEWEST_EMPTY)
        jumps = end - begin >= FEWEST_EMPTY and bool(
            np.isnan(run.y_um[begin]) or abs(float(run.y_um[inside])) > 3.0 * largest
        )
        if end > begin and (stands or jumps):
            what = "hold no numbers" if np.isnan(run.y_um[begin]) else "are zero in all columns"
            lines.append(f"{run.origin.at(begin)}: the {which} {end - begin} rows {what} and are left out")
        elif begin == 0:
            first = 0
        else:
            stop = run.samples
    return (run.part(first, stop) if lines else run), lines
