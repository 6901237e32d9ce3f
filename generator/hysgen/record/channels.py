"""The channels of one unbroken run during reading, with the names that error messages need."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hysgen.errors import RecordError


def index_of(row: int) -> str:
    """The position of a row of an array in an error message."""
    return f"index {row}"


@dataclass(frozen=True, eq=False)
class Channels:
    """Voltage, displacement and further channels of one unbroken run.

    source: file name. u_V, y_um: (n,) in V and um. aux: further channels, each (n,).
    u_name, y_name: the fields' names in the file. locate: row number to "line 12" or "index 10".
    """

    source: str
    u_V: NDArray[np.float64]
    y_um: NDArray[np.float64]
    aux: Mapping[str, NDArray[np.float64]]
    u_name: str = "voltage_V"
    y_name: str = "displacement_um"
    locate: Callable[[int], str] = index_of

    @classmethod
    def of_arrays(cls, source: str, u_V: ArrayLike, y_um: ArrayLike, aux: Mapping[str, ArrayLike]) -> Channels:
        """Channels from array-likes. Raises RecordError if one of them is not a series of real numbers."""
        named = {"voltage_V": u_V, "displacement_um": y_um, **aux}
        arrays = {name: one_series(source, name, values) for name, values in named.items()}
        return cls(source, arrays.pop("voltage_V"), arrays.pop("displacement_um"), arrays)


def one_series(source: str, name: str, values: ArrayLike) -> NDArray[np.float64]:
    """`values` as float64 of shape (n,). Raises RecordError if they are not real numbers in one dimension."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise RecordError(f"{source}: {name} holds {array.dtype}, not real numbers; give float values")
    if array.ndim == 2 and 1 in array.shape and array.size > 1:
        array = array.ravel()  # a column of MATLAB or of a DataFrame
    if array.ndim != 1:
        raise RecordError(f"{source}: {name} has shape {array.shape}; give a one-dimensional array")
    return array.astype(np.float64)
