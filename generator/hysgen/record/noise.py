"""The noise floor of a record: the rms of its white noise, which no model can explain.

One figure for one record, whoever asks (`inspect`, `score`, `diagnose`): from voltage and displacement alone, by the
spectra of windows of WINDOW rows, of those in which the voltage moves least:

    S = |FFT(taper (y - parabola))|^2 / sum taper^2
    noise^2 = mean of S below CLIP noise^2, over that of an exponential variable of mean 1 below CLIP

White noise fills all frequencies of all windows, and S / noise^2 is exponential there. What has a cause fills few of
them: the motion of the stage the low ones, a line or the ringing of a mode those near its own, a wrong reading all of
one window. Where the voltage repeats, y is the difference of two periods over sqrt 2, in which no motion is left.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hysgen.record.data import Record
from hysgen.record.segment import Segment
from hysgen.record.series import period_of, resolution_um

Floats = NDArray[np.float64]
Method = Literal["periods", "spectra"]

WINDOW, LEAST_WINDOW = 64, 16
"""Rows of a window, a shorter record's own length down to LEAST_WINDOW."""

SLOWEST, FEWEST = 0.1, 16
"""Share of the windows that are looked at, and their least number: a fast hysteresis fills all frequencies."""

FIRST = 3
"""First frequency that counts, in periods of a window: below it the parabola takes a part of the noise."""

CLIP = 3.0
"""Power over that of the noise above which a frequency has a cause, 5 % of those that have none."""


@dataclass(frozen=True)
class NoiseFloor:
    """Rms of the noise on the displacement in um, the method of its estimate, and the number of samples used."""

    rms_um: float
    method: Method
    samples: int

    @property
    def source(self) -> str:
        """The method as the JSON and the report of a diagnosis name it."""
        return "repeated periods" if self.method == "periods" else "spectra of the slowest rows"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {"rms_um": self.rms_um, "method": self.method, "samples": self.samples}

    def describe(self) -> str:
        """One phrase for people."""
        return f"{self.rms_um:.4g} um rms from {self.source}, if it is white"


def noise_floor(record: Record) -> NoiseFloor:
    """The noise floor of a record, at least that of the sensor's steps; 0 if no segment is long enough."""
    repeated = [later for segment in record.segments if (later := _of_a_period(segment)) is not None]
    series = repeated or [(segment.u_V, segment.y_um) for segment in record.segments]
    rows = min(WINDOW, max(len(y_um) for _, y_um in series))
    if rows < LEAST_WINDOW:
        return NoiseFloor(0.0, "spectra", 0)
    power = np.sort(_spectra(series, rows), axis=None)
    level_um2, fractions = float(np.median(power)) / math.log(2.0), np.cumsum(power)
    below = CLIP * math.exp(-CLIP) / (1.0 - math.exp(-CLIP))
    for _ in range(100):
        count = max(int(np.searchsorted(power, CLIP * level_um2)), 1)
        level_um2, last_um2 = float(fractions[count - 1]) / count / (1.0 - below), level_um2
        if abs(level_um2 - last_um2) <= 1e-6 * level_um2:
            break
    steps_um = resolution_um(record.y_um) / math.sqrt(12.0)
    method: Method = "periods" if repeated else "spectra"
    return NoiseFloor(max(math.sqrt(level_um2), steps_um), method, power.size)


def _of_a_period(segment: Segment) -> tuple[Floats, Floats] | None:
    """Voltage, and the difference of two periods of the displacement over sqrt 2; None if nothing repeats."""
    period = period_of(segment.u_V)
    # The first period may contain the transient from another state.
    first = period if period is not None and segment.samples >= 3 * period else 0
    if period is None or segment.samples - first - period < WINDOW:
        return None
    y_um = segment.y_um[first:]
    return segment.u_V[first + period :], (y_um[period:] - y_um[:-period]) / math.sqrt(2.0)


def _spectra(series: list[tuple[Floats, Floats]], rows: int) -> Floats:
    """(windows, frequencies) powers of the windows of `rows` rows, in which the voltage moves least."""
    windows, moves_V = [], []
    for u_V, y_um in series:
        if len(y_um) < rows:
            continue
        way_V, begins = np.cumsum(np.abs(np.diff(u_V, prepend=u_V[0]))), np.arange(0, len(u_V) - rows + 1, rows // 2)
        windows.append(np.lib.stride_tricks.sliding_window_view(y_um, rows)[begins])
        # A window just behind a step still rings.
        moves_V.append(way_V[begins + rows - 1] - way_V[np.maximum(begins - rows // 2, 0)])
    y_um, moved_V = np.concatenate(windows), np.concatenate(moves_V)
    y_um = y_um[np.argsort(moved_V, kind="stable")[: max(FEWEST, int(SLOWEST * len(y_um)))]]
    taper, place = np.hanning(rows + 2)[1:-1], np.linspace(-1.0, 1.0, rows)
    parabola = np.linalg.qr(np.vander(place, 3))[0]
    bent_um = y_um - (y_um @ parabola) @ parabola.T
    spectra: Floats = np.abs(np.fft.rfft(taper * bent_um, axis=1)[:, FIRST:-1]) ** 2 / float(taper @ taper)
    return spectra
