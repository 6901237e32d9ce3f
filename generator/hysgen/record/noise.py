"""How much of a record no model can explain: the noise floor of its displacement.

Three estimates, the first that the record allows is taken, and it says which:

    periods      the input repeats itself: half the variance of y(k + P) - y(k), a straight line taken out of the latter
    plateaus     the input rests: variance about a parabola over the last three quarters of each rest (creep is smooth)
    differences  sum (D^m y)^2 / C(2m, m), m = 6: white noise on a displacement that is smooth over m samples

The first two hold for noise of any colour faster than the piece looked at, the last for white noise only.
Source of the last: P. Hall, J. W. Kay and D. M. Titterington, Biometrika 77 (1990) 521-528, on difference-based
variance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hysgen.record import Record, Segment

Floats = NDArray[np.float64]
Method = Literal["periods", "plateaus", "differences"]

ORDER = 6
SHORTEST_REST = 40
"""Samples that a rest of the input must last to tell noise from creep."""

FEWEST = 100
"""Samples from which a variance is taken."""

REPEATS_WITHIN = 1e-3
"""Rms difference of two periods of the input, relative to its spread, below which it repeats itself."""


@dataclass(frozen=True)
class NoiseFloor:
    """Rms of the noise on the displacement in um, how it was estimated, and from how many samples."""

    rms_um: float
    method: Method
    samples: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {"rms_um": self.rms_um, "method": self.method, "samples": self.samples}

    def describe(self) -> str:
        """One phrase for people."""
        source = {
            "periods": "from repeated periods of the input",
            "plateaus": "from rests of the input",
            "differences": f"from differences of order {ORDER}, if the noise is white",
        }
        return f"{self.rms_um:.4g} um rms {source[self.method]}"


def noise_floor(record: Record) -> NoiseFloor:
    """The noise floor of a record by the best estimate that it allows; 0 if no segment is long enough for any."""
    methods: Sequence[tuple[Method, list[tuple[float, float]]]] = (
        ("periods", [piece for segment in record.segments for piece in _periods(segment)]),
        ("plateaus", [piece for segment in record.segments for piece in _plateaus(segment)]),
        ("differences", [piece for segment in record.segments for piece in _differences(segment)]),
    )
    for method, pieces in methods:
        freedom = sum(count for _, count in pieces)
        if freedom >= FEWEST or (method == "differences" and freedom > 0.0):
            return NoiseFloor(math.sqrt(sum(square for square, _ in pieces) / freedom), method, round(freedom))
    return NoiseFloor(0.0, "differences", 0)


def period_of(u_V: Floats) -> int | None:
    """The period of an input in samples, if at least two periods of it repeat within REPEATS_WITHIN; else None.

    Candidates are the peaks of the autocorrelation beyond its first zero.
    """
    n = u_V.size
    centred = u_V - u_V.mean()
    spread = float(centred.std())
    if n < 2 * SHORTEST_REST or spread == 0.0:
        return None
    spectrum = np.fft.rfft(centred, 2 * n)
    # Divided by the overlap, so that a late period is not worth less than an early one.
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[: n // 2 + 1] / np.arange(n, n - n // 2 - 1, -1)
    below = np.flatnonzero(correlation < 0.0)
    if below.size == 0:
        return None
    late = correlation[below[0] :]
    for lag in below[0] + np.flatnonzero(late > (1.0 - 1e-2) * late.max()):
        gap = u_V[lag:] - u_V[:-lag]
        if math.sqrt(float(np.mean(gap * gap))) <= REPEATS_WITHIN * spread:
            return int(lag)
    return None


def _periods(segment: Segment) -> Iterator[tuple[float, float]]:
    period = period_of(segment.u_V)
    if period is None:
        return
    # The first period may still hold the way there from another state.
    y = segment.y_um[period:] if segment.samples >= 3 * period else segment.y_um
    difference = y[period:] - y[:-period]
    if difference.size >= FEWEST:
        yield 0.5 * _about_polynomial(difference, 1), difference.size - 2.0


def _plateaus(segment: Segment) -> Iterator[tuple[float, float]]:
    tolerance = 1e-6 * float(np.ptp(segment.u_V))
    resting = np.concatenate([[False], np.abs(np.diff(segment.u_V)) <= tolerance, [False]])
    edges = np.flatnonzero(np.diff(resting.astype(np.int8)))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start >= SHORTEST_REST:
            rest = segment.y_um[start + (stop - start) // 4 : stop + 1]
            yield _about_polynomial(rest, 2), rest.size - 3.0


def _differences(segment: Segment) -> Iterator[tuple[float, float]]:
    difference = np.diff(segment.y_um, ORDER)
    if difference.size:
        yield float(difference @ difference) / math.comb(2 * ORDER, ORDER), float(difference.size)


def _about_polynomial(values: Floats, degree: int) -> float:
    """Sum of squares about the polynomial that fits best."""
    place = np.linspace(-1.0, 1.0, values.size)
    basis = np.polynomial.legendre.legvander(place, degree)
    residual = values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
    return float(residual @ residual)
