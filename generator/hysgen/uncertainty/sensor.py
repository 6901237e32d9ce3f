"""The uncertainty of the displacement sensor: from a text as `5nm,k=2`, or from a Digital Calibration Certificate.

A certificate is XML after the schema DCC 3 of PTB with values in D-SI: every quantity of length with an expanded
uncertainty is read, in the element `expandedUnc` (D-SI 1) or `expandedMU` (D-SI 2); the largest U / k counts.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from hysgen.errors import HysgenError

_UNITS_UM = {"m": 1e6, "mm": 1e3, "um": 1.0, "µm": 1.0, "nm": 1e-3, "pm": 1e-6}
_SI_UM = {
    r"\metre": 1e6,
    r"\milli\metre": 1e3,
    r"\micro\metre": 1.0,
    r"\nano\metre": 1e-3,
    r"\pico\metre": 1e-6,
}
_LENGTH = re.compile(r"([0-9.]+(?:[eE][+-]?\d+)?)\s*([a-zµ]+)")


@dataclass(frozen=True)
class SensorUncertainty:
    """Expanded uncertainty U and coverage factor k of the sensor; source: text or file, and certificate number."""

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
    """`5nm,k=2`, `5nm` (a standard uncertainty, k = 1), or the path of a certificate (.xml).

    Raises HysgenError if the text is neither, or the certificate states no uncertainty of a length.
    """
    if text.lower().endswith(".xml"):
        return certificate(Path(text))
    length, comma, factor = text.partition(",")
    name, equals, value = factor.partition("=")
    if comma and (name.strip() != "k" or not equals):
        raise HysgenError(f"--sensor-uncertainty: '{text}' is not LENGTH,k=FACTOR; write 5nm,k=2 or name a file .xml")
    try:
        k = float(value) if comma else 1.0
    except ValueError:
        k = math.nan
    if not k > 0.0:
        raise HysgenError(f"--sensor-uncertainty: the coverage factor '{value}' is not a positive number; write k=2")
    return SensorUncertainty(length_um(length), k, f"stated: {text}")


def certificate(path: Path) -> SensorUncertainty:
    """The largest uncertainty of a length in a Digital Calibration Certificate. Raises HysgenError as above."""
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as fault:
        raise HysgenError(f"{path}: is no certificate that can be read ({fault})") from fault
    found = list(_uncertainties(root))
    if not found:
        raise HysgenError(f"{path}: states no expanded uncertainty of a length; write --sensor-uncertainty 5nm,k=2")
    expanded, k = max(found, key=lambda pair: pair[0] / pair[1])
    number = next((e.text for e in root.iter() if _local(e) == "uniqueIdentifier" and e.text), path.name)
    return SensorUncertainty(expanded, k, f"certificate {number}, largest of {len(found)} uncertainties of length")


def _uncertainties(root: ElementTree.Element) -> Iterator[tuple[float, float]]:
    """(expanded uncertainty in um, coverage factor) of every real of a length."""
    for real in root.iter():
        if _local(real) not in ("real", "realListXMLList"):
            continue
        texts = {_local(element): (element.text or "").strip() for element in real.iter()}
        unit = texts.get("unit", texts.get("unitXMLList", "")).split(" ")[0]
        stated = texts.get("valueExpandedMU") or texts.get("uncertainty") or texts.get("uncertaintyXMLList")
        factor = texts.get("coverageFactor") or texts.get("coverageFactorXMLList")
        if unit in _SI_UM and stated and factor:
            for value in stated.split():
                yield float(value) * _SI_UM[unit], float(factor.split()[0])


def _local(element: ElementTree.Element) -> str:
    return str(element.tag).rpartition("}")[2]
