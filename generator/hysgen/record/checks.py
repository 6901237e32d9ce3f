"""Checks of the values of a record, independent of its file format."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.record.plausibility import saturation, swapped
from hysgen.record.segment import Segment

ACCEPTABLE = ("constant", "saturation", "swapped")
"""Refusals that the caller may turn into warnings."""

SHORTEST = 3
"""Samples that a run needs: two steps are the least from which a sampling period and its variation follow."""


NO_READING = 1e30
"""Magnitude from which on a number is no reading: SCPI instruments write 9.9e37 for an overload, 9.91e37 for none."""

MARKED = 0.01
"""Share of the rows below which a value such as -9999, far off all others, marks rows without a reading."""

LIMITS = frozenset(2.0**bits - less for bits in (15, 16, 31, 32, 63, 64) for less in (0.0, 1.0))
"""Magnitudes at which integers end."""


def check_marks(runs: Sequence[Segment], unit_V: float = 1.0, unit_um: float = 1.0) -> None:
    """Refuse numbers that stand for an overload or a missing reading, with the first row.

    unit_V, unit_um: what one in the file is.
    """
    for run in runs:
        named = ((run.origin.voltage, run.u_V / unit_V), (run.origin.displacement, run.y_um / unit_um))
        for name, values in chain(named, run.aux.items()):
            rows = np.isfinite(values) & (np.abs(values) >= NO_READING)
            what = "as instruments write for an overload or for no reading"
            ends = values[np.isfinite(values)]
            for end in (ends.min(), ends.max()) if ends.size and not rows.any() else ():
                if _is_mark(values, float(end)):
                    rows, what = values == end, "far off all others, as loggers write for no reading"
            if rows.any():
                row = int(np.argmax(rows))
                raise RecordError(
                    f"{run.origin.at(row)}: {name} is {values[row]:.10g} ({np.count_nonzero(rows)} such values), "
                    f"{what}; correct it, or delete the row and read the rest with --split-at-gaps"
                )


def _is_mark(values: NDArray[np.float64], end: float) -> bool:
    """Whether the extreme value `end` is all nines or a limit of an integer, in few rows and far off all others."""
    digits = f"{abs(end):.10g}".replace(".", "")
    if not (abs(end) in LIMITS or (len(digits) > 2 and set(digits) == {"9"})):
        return False
    rest = values[(values != end) & np.isfinite(values)]
    if not rest.size >= (1.0 - MARKED) * values.size:
        return False
    return max(float(rest.min()) - end, end - float(rest.max())) > float(np.ptp(rest))


def check_values(runs: Sequence[Segment], accept: Collection[str] = ()) -> tuple[str, ...]:
    """Refuse values that no model can be fitted to; return warnings about suspicious values.

    runs: of one file, in order. Refused, in this order: different lengths, NaN or infinity, fewer than 3 samples in a
    run, a constant input or output; exchanged columns and a saturated sensor if certain, else a warning.
    accept: names of refusals that become warnings. Raises RecordError with one line.
    """
    for name in accept:
        if name not in ACCEPTABLE:
            raise RecordError(f"accept: '{name}' is not known; choose from {', '.join(ACCEPTABLE)}")
    for run in runs:
        check_finite(run)
    warnings = []
    for check in (constant, swapped, saturation):
        for name, certain, line in check(runs):
            if certain and name not in accept:
                raise RecordError(f"{line}; if it is sound all the same, --accept {name}")
            warnings.append(line)
        if check is constant and warnings:
            break  # the other checks need channels that move
    return tuple(warnings)


def check_finite(run: Segment) -> None:
    """Refuse channels of different length, with NaN or infinity (naming the first row), or of fewer than 3 samples."""
    for name, values in chain([(run.origin.voltage, run.u_V), (run.origin.displacement, run.y_um)], run.aux.items()):
        finite = np.isfinite(values)
        if not finite.all():
            row = int(np.argmin(finite))
            raise RecordError(
                f"{run.origin.at(row)}: {name} is {values[row]} ({np.count_nonzero(~finite)} such values: nan, null, a "
                "fill value); interpolate them, or cut the record there into segments"
            )
    if run.u_V.size < SHORTEST:
        where = run.origin.at(0) if run.samples else run.origin.source
        raise RecordError(f"{where}: holds a run of {run.samples} samples; record at least {SHORTEST} without a break")


def constant(runs: Sequence[Segment]) -> Iterator[tuple[str, bool, str]]:
    """("constant", True, message) for an input or output that is constant over all runs."""
    first = runs[0].origin
    for name, channels, cure in (
        (first.voltage, [run.u_V for run in runs], "drive the stage with a signal that moves"),
        (
            first.displacement,
            [run.y_um for run in runs],
            "check that the sensor is connected and the right column is named",
        ),
    ):
        if min(values.min() for values in channels) == max(values.max() for values in channels):
            samples = sum(values.size for values in channels)
            line = f"{first.source}: {name} is constant at {channels[0][0]:g} in all {samples} samples; {cure}"
            yield "constant", True, line
