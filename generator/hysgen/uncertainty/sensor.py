"""The uncertainty of the displacement sensor, from a text as `5nm,k=2`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from hysgen.errors import HysgenError

_UNITS_UM = {"m": 1e6, "mm": 1e3, "um": 1.0, "µm": 1.0, "nm": 1e-3, "pm": 1e-6}
_LENGTH = re.compile(r"([0-9.]+(?:[eE][+-]?\d+)?)\s*([a-zµ]+)")


@dataclass(frozen=True)
class SensorUncertainty:
    """Expanded uncertainty U and coverage factor k of the sensor; source: the text."""

    expanded_um: float
    k: float
    source: str

    @property
    def standard_um(self) -> float:
        """u = U / k."""
        return self.expanded_um / self.k


def length_um(text: str) -> float:
    """A length as `5nm` in um.

    >>> length_um("5 nm")
    0.005

    Raises HysgenError for another text.
    """
    found = _LENGTH.fullmatch(text.strip())
    if found is None or found[2] not in _UNITS_UM:
        raise HysgenError(f"'{text}' is not a length; write a number and one of {', '.join(_UNITS_UM)}, as 5nm")
    return float(found[1]) * _UNITS_UM[found[2]]


def sensor_uncertainty(text: str) -> SensorUncertainty:
    """`5nm,k=2`, or `5nm` (a standard uncertainty, k = 1). Raises HysgenError for another text."""
    length, comma, factor = text.partition(",")
    name, equals, value = factor.partition("=")
    if comma and (name.strip() != "k" or not equals):
        raise HysgenError(f"--sensor-uncertainty: '{text}' is not LENGTH,k=FACTOR; write 5nm,k=2")
    try:
        k = float(value) if comma else 1.0
    except ValueError:
        k = math.nan
    if not k > 0.0:
        raise HysgenError(f"--sensor-uncertainty: the coverage factor '{value}' is not a positive number; write k=2")
    return SensorUncertainty(length_um(length), k, f"stated: {text}")
