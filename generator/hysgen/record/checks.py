"""What is refused in the values of a record, whatever file they came from."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.errors import RecordError

ACCEPTABLE = ("constant", "saturation", "swapped")
"""Refusals that a caller who knows better may turn into warnings."""

SHORTEST = 3
"""Samples that a segment needs: two steps, the least that shows a sampling period and a change of it."""


def index_of(row: int) -> str:
    """How a person finds a row of an array."""
    return f"index {row}"


@dataclass(frozen=True, eq=False)
class Channels:
    """The channels of one unbroken run, with the words that a message about them needs.

    source: file name. u_V, y_um: (n,) in V and um. aux: further channels, each (n,).
    u_name, y_name: the fields' names in the file. locate: row number to "line 12" or "index 10".
    """

    source: str
    u_V: NDArray[np.float64]
    y_um: NDArray[np.float64]
    aux: Mapping[str, NDArray[np.float64]]
    u_name: str = "voltage_V"
    y_name: str = "displacement_um"
    locate: Callable[[int], str] = field(default=index_of)

    @classmethod
    def of_arrays(cls, source: str, u_V: ArrayLike, y_um: ArrayLike, aux: Mapping[str, ArrayLike]) -> Channels:
        """Channels from anything that NumPy can take as numbers. Raises RecordError if it cannot."""
        named = {"voltage_V": u_V, "displacement_um": y_um, **aux}
        arrays = {name: one_series(source, name, values) for name, values in named.items()}
        return cls(source, arrays.pop("voltage_V"), arrays.pop("displacement_um"), arrays)


def one_series(source: str, name: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as float64 of shape (n,). Raises RecordError if they are not real numbers in one dimension."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise RecordError(f"{source}: {name} holds {array.dtype}, not real numbers; give float values")
    if array.ndim != 1:
        raise RecordError(f"{source}: {name} has shape {array.shape}; give a one-dimensional array")
    return array.astype(np.float64)


def check_values(runs: Sequence[Channels], accept: Collection[str] = ()) -> tuple[str, ...]:
    """Refuse what no model can be fitted to; return warnings about what looks odd. `runs`: of one file, in order.

    Refused, in this order: different lengths, NaN or infinity, fewer than 3 samples in a run, an input or output that
    never moves.
    `accept` turns the refusals it names into warnings. Raises RecordError with one line.
    """
    for name in accept:
        if name not in ACCEPTABLE:
            raise RecordError(f"accept: '{name}' is not known; choose from {', '.join(ACCEPTABLE)}")
    for run in runs:
        check_finite(run)
    warnings = []
    for name, line in (*constant(runs),):
        if name not in accept:
            raise RecordError(line)
        warnings.append(line)
    return tuple(warnings)


def check_finite(run: Channels) -> None:
    """Refuse channels of different length, with NaN or infinity (naming the first row), or of fewer than 3 samples."""
    for name, values in chain([(run.u_name, run.u_V), (run.y_name, run.y_um)], run.aux.items()):
        if values.size != run.u_V.size:
            raise RecordError(
                f"{run.source}: {name} has {values.size} samples, {run.u_name} has {run.u_V.size}; "
                "give every channel one value per sample, or leave the channel out"
            )
        finite = np.isfinite(values)
        if not finite.all():
            row = int(np.argmin(finite))
            raise RecordError(
                f"{run.source}: {run.locate(row)}: {name} is {values[row]} ({np.count_nonzero(~finite)} such values); "
                "delete the rows or record again"
            )
    if run.u_V.size < SHORTEST:
        where = f"{run.locate(0)}: " if run.u_V.size else ""
        raise RecordError(
            f"{run.source}: {where}holds a run of {run.u_V.size} samples; record at least {SHORTEST} without a break"
        )


def constant(runs: Sequence[Channels]) -> Iterator[tuple[str, str]]:
    """("constant", message) for an input or output that never moves in any of the runs."""
    first = runs[0]
    for name, channels, cure in (
        (first.u_name, [run.u_V for run in runs], "drive the stage with a signal that moves"),
        (first.y_name, [run.y_um for run in runs], "check that the sensor is connected and the right column is named"),
    ):
        if min(values.min() for values in channels) == max(values.max() for values in channels):
            samples = sum(values.size for values in channels)
            line = f"{first.source}: {name} is constant at {channels[0][0]:g} in all {samples} samples; {cure}"
            yield "constant", line
