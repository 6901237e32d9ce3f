"""What is refused in the values of a record, whatever file they came from."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
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


def check_values(channels: Channels, accept: Collection[str] = ()) -> tuple[str, ...]:
    """Refuse what no model can be fitted to; return warnings about what looks odd.

    Refused: different lengths, fewer than 3 samples, NaN or infinity, a constant input, a constant output.
    Raises RecordError with one line.
    """
    for name in accept:
        if name not in ACCEPTABLE:
            raise RecordError(f"accept: '{name}' is not known; choose from {', '.join(ACCEPTABLE)}")
    check_finite(channels)
    return check_constant(channels, accept)


def check_finite(channels: Channels) -> None:
    """Refuse channels of different length, of fewer than 3 samples, or with NaN or infinity, naming the first row."""
    c = channels
    for name, values in chain([(c.u_name, c.u_V), (c.y_name, c.y_um)], c.aux.items()):
        if values.size != c.u_V.size:
            raise RecordError(
                f"{c.source}: {name} has {values.size} samples, {c.u_name} has {c.u_V.size}; "
                "give every channel one value per sample, or leave the channel out"
            )
        finite = np.isfinite(values)
        if not finite.all():
            row = int(np.argmin(finite))
            raise RecordError(
                f"{c.source}: {c.locate(row)}: {name} is {values[row]} ({np.count_nonzero(~finite)} such values); "
                "delete the rows or record again"
            )
    if c.u_V.size < SHORTEST:
        raise RecordError(f"{c.source}: holds {c.u_V.size} samples; record at least {SHORTEST}")


def check_constant(channels: Channels, accept: Collection[str] = ()) -> tuple[str, ...]:
    """Refuse an input or output that never moves."""
    c = channels
    warnings = []
    for name, values, cure in (
        (c.u_name, c.u_V, "drive the stage with a signal that moves"),
        (c.y_name, c.y_um, "check that the sensor is connected and the right column is named"),
    ):
        if values.min() == values.max():
            line = f"{c.source}: {name} is constant at {values[0]:g} in all {values.size} samples; {cure}"
            if "constant" not in accept:
                raise RecordError(line)
            warnings.append(line)
    return tuple(warnings)
