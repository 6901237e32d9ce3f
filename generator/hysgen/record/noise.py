"""The noise floor of a record: the rms of its displacement that no model can explain.

Of a record alone, by the first method that it allows:

    periods      the input is periodic: half the variance of y(k + P) - y(k) about a straight line
    plateaus     the input is constant: variance about a parabola over the last three quarters of each plateau
    differences  mean (D^m y)^2 / C(2m, m), m = 6: white noise on a displacement that is smooth over m samples

"differences" assumes white noise, see `series.white_noise`, the others noise of any colour that is faster than the
period or the plateau. Given the residual of a model: `model.residual`.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hysgen.record.data import Record
from hysgen.record.segment import Segment
from hysgen.record.series import SHORTEST_PLATEAU, period_of, plateaus, white_noise

Floats = NDArray[np.float64]
Method = Literal["periods", "plateaus", "differences", "innovation"]

ORDER = 6

FEWEST = 100
"""Samples that an estimate of the record alone needs."""


@dataclass(frozen=True)
class NoiseFloor:
    """Rms of the noise on the displacement in um, the method of its estimate, and the number of samples used."""

    rms_um: float
    method: Method
    samples: int

    @property
    def source(self) -> str:
        """The method as the JSON and the report of a diagnosis name it."""
        return "repeated periods" if self.method == "periods" else self.method

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {"rms_um": self.rms_um, "method": self.method, "samples": self.samples}

    def describe(self) -> str:
        """One phrase for people."""
        source = {
            "periods": "from repeated periods of the input",
            "plateaus": "from rests of the input",
            "differences": f"from differences of order {ORDER}, if the noise is white",
            "innovation": "from second differences of the residual, if the noise is white",
        }
        return f"{self.rms_um:.4g} um rms {source[self.method]}"


def noise_floor(record: Record) -> NoiseFloor:
    """The noise floor of a record by the first method that it allows; 0 if no segment is long enough for any."""
    methods: tuple[tuple[Method, Callable[[Segment], Iterator[tuple[float, float]]]], ...] = (
        *(("periods", _periods), ("plateaus", _plateaus), ("differences", _differences)),
    )
    for method, estimated in methods:
        pieces = [piece for segment in record.segments for piece in estimated(segment)]
        freedom = sum(count for _, count in pieces)
        if freedom >= FEWEST or (method == "differences" and freedom > 0.0):
            return NoiseFloor(math.sqrt(sum(square for square, _ in pieces) / freedom), method, round(freedom))
    return NoiseFloor(0.0, "differences", 0)


def _periods(segment: Segment) -> Iterator[tuple[float, float]]:
    period = period_of(segment.u_V)
    if period is None:
        return
    # The first period may contain the transient from another state.
    y = segment.y_um[period:] if segment.samples >= 3 * period else segment.y_um
    difference = y[period:] - y[:-period]
    if difference.size >= FEWEST:
        yield 0.5 * about_polynomial(difference, 1), difference.size - 2.0


def _plateaus(segment: Segment) -> Iterator[tuple[float, float]]:
    tolerance_V = 1e-6 * float(np.ptp(segment.u_V))
    for begin, end in plateaus(segment.u_V, SHORTEST_PLATEAU + 1, tolerance_V):
        y = segment.y_um[begin + (end - begin - 1) // 4 : end]
        yield about_polynomial(y, 2), y.size - 3.0


def _differences(segment: Segment) -> Iterator[tuple[float, float]]:
    count = segment.samples - ORDER
    if count >= ORDER:
        yield count * white_noise(segment.y_um, ORDER, "rms") ** 2, float(count)


def about_polynomial(values: Floats, degree: int) -> float:
    """Sum of squares about the least-squares polynomial."""
    place = np.linspace(-1.0, 1.0, values.size)
    basis = np.polynomial.legendre.legvander(place, degree)
    residual = values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
    return float(residual @ residual)
