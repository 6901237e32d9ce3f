"""Counters that overflow, which are continued, and rows of a buffer that was never filled, which are left out.

    time            falls at a row, and rises by the usual step if M is added there
    displacement    jumps by nearly M at some rows, M more than its range, and moves as usual if M is taken off

M is 2^16, 2^24, 2^31 or 2^32 of what the column counts, of a displacement any 2^b from 2^8 on, and for a time of day
what a clock begins again after. Rows of zeros (or of no numbers) at an end are no samples if the time stands still in
them, or if the displacement jumps there as it does nowhere else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hysgen.record.segment import Segment

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
    for name, attribute, found in (
        (file.time, "stamps_s", _overflow_of_time(run.stamps_s, moduli)),
        (file.displacement, "y_um", _overflow_of_displacement(run.y_um, unit_um)),
    ):
        if found is not None:
            modulus, turns = found
            rows = np.flatnonzero(np.diff(turns)) + 1
            more = f" and {rows.size - 1} more rows" if rows.size > 1 else ""
            unit = "s" if attribute == "stamps_s" else "um"
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
