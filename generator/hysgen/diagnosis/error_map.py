"""Error map of a free run: its error over the variables that causes depend on.

The prediction horizon; amplitude, frequency, level and direction of the swing of the input; the time since the last
turning point and since the start of the segment; the frequency of the error; the share of its power above the noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.model.model import Model
from hysgen.model.simulate import HorizonCurve, free_run, horizon_curve
from hysgen.record import Record
from hysgen.record.series import turning_rows

Floats = NDArray[np.float64]

BINS, BANDS = 10, 60
"""Bins of a profile and bands of a spectrum."""

SMALLEST_SWING = 0.01
"""Size of the smallest swing as a share of the range of the input; smaller ones are noise on the command."""


@dataclass(frozen=True)
class Profile:
    """Error binned by one quantity: bin edges (b + 1), rms and mean in um (b,), samples (b,); NaN in empty bins."""

    quantity: str
    unit: str
    edges: tuple[float, ...]
    rms_um: tuple[float, ...]
    mean_um: tuple[float, ...]
    samples: tuple[int, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; an empty bin is null."""
        return {
            "quantity": self.quantity,
            "unit": self.unit,
            "edges": list(self.edges),
            "rms_um": [None if count == 0 else value for value, count in zip(self.rms_um, self.samples, strict=True)],
            "mean_um": [None if count == 0 else value for value, count in zip(self.mean_um, self.samples, strict=True)],
            "samples": list(self.samples),
        }


@dataclass(frozen=True)
class Spectrum:
    """Rms of the error in um in bands of equal width in log f; centres of the bands in Hz, (b,) each."""

    f_Hz: tuple[float, ...]
    rms_um: tuple[float, ...]


@dataclass(frozen=True)
class ErrorMap:
    """Error of a free run over a record: rms, largest magnitude, horizon curve, profiles and spectrum.

    above_noise: share of the error's power above the noise floor, 0 to 1.
    """

    rms_um: float
    largest_um: float
    above_noise: float
    horizon: HorizonCurve
    profiles: tuple[Profile, ...]
    spectrum: Spectrum

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "rms_um": self.rms_um,
            "largest_um": self.largest_um,
            "above_noise": self.above_noise,
            "horizon": self.horizon.to_json(),
            "by": [profile.to_json() for profile in self.profiles],
            "spectrum": {"f_Hz": list(self.spectrum.f_Hz), "rms_um": list(self.spectrum.rms_um)},
        }


def error_map(
    model: Model, record: Record, noise_um: float = 0.0, error_um: Floats | None = None, first: int = 0
) -> ErrorMap:
    """The error map of a model's free run over a record; noise_um: the noise floor.

    error_um: (n,) simulated - measured, all segments in order; None to simulate the record here.
    first: the rows from `first` on are evaluated, the rows before it only simulated.
    Raises RecordError if the record's sampling period differs from the model's, or no row is evaluated.
    """
    if not 0 <= first < record.samples:
        raise RecordError(f"{record.source}: no row is left from row {first} on; it has {record.samples}")
    if error_um is None:
        runs = free_run(model, record)
        error_um = np.concatenate([run.y_um - s.y_um for run, s in zip(runs, record.segments, strict=True)])
    lengths = [segment.samples for segment in record.segments]
    pieces = np.split(error_um, np.cumsum(lengths)[:-1])
    evaluated = [piece[max(first - start, 0) :] for piece, start in zip(pieces, np.cumsum([0, *lengths]), strict=False)]
    swings = [_swings(s.u_V, record.Ts_s) for s in record.segments]
    time_s = np.concatenate([record.Ts_s * np.arange(s.samples, dtype=np.float64) for s in record.segments])[first:]
    level_V = record.u_V[first:]
    amplitude_V, f_Hz, direction, since_s = (np.concatenate(parts)[first:] for parts in zip(*swings, strict=True))
    error = error_um[first:]
    profiles = (
        profile("amplitude of the swing", "V", amplitude_V, error),
        profile("frequency of the swing", "Hz", f_Hz, error, logarithmic=True),
        profile("level of the input", "V", level_V, error),
        profile("direction", "down, still, up", direction, error, edges=(-1.5, -0.5, 0.5, 1.5)),
        profile("time since the last turning point", "s", since_s, error, logarithmic=True),
        profile("time in the record", "s", time_s, error),
    )
    power = float(np.mean(error * error))
    return ErrorMap(
        rms_um=float(np.sqrt(power)),
        largest_um=float(np.abs(error).max()),
        above_noise=max(0.0, 1.0 - noise_um**2 / max(power, 1e-300)),
        horizon=horizon_curve(model, record, first=first),
        profiles=profiles,
        spectrum=spectrum(max(evaluated, key=len), record.Ts_s),
    )


def profile(
    quantity: str,
    unit: str,
    values: Floats,
    error_um: Floats,
    logarithmic: bool = False,
    edges: Sequence[float] | None = None,
) -> Profile:
    """The error binned by `values`, (n,) each, in BINS bins of equal width (in log values if `logarithmic`) or `edges`.

    Values that are not finite are not counted; without positive values logarithmic bins go from 1 to 2.
    """
    if edges is None:
        usable = values[np.isfinite(values) & (values > 0)] if logarithmic else values
        low, high = (float(usable.min()), float(usable.max())) if len(usable) else (1.0, 2.0)
        high = high if high > low else low + max(abs(low), 1.0)
        bounds = np.geomspace(low, high, BINS + 1) if logarithmic else np.linspace(low, high, BINS + 1)
    else:
        bounds = np.asarray(edges, dtype=np.float64)
    count = len(bounds) - 1
    number = np.clip(np.searchsorted(bounds, values, side="right") - 1, 0, count - 1)
    finite = np.isfinite(values)
    samples = np.bincount(number[finite], minlength=count)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(number[finite], error_um[finite], minlength=count) / samples
        rms = np.sqrt(np.bincount(number[finite], error_um[finite] ** 2, minlength=count) / samples)
    return Profile(
        quantity, unit, tuple(bounds.tolist()), tuple(rms.tolist()), tuple(mean.tolist()), tuple(samples.tolist())
    )


def range_in_words(profile: Profile) -> str:
    """Smallest and largest rms of a profile and the bins in which they lie."""
    rms = np.array(profile.rms_um)
    edges = zip(profile.edges[:-1], profile.edges[1:], strict=True)
    named = profile.unit.split(", ")
    centres = named if len(named) == len(rms) else [f"{0.5 * (a + b):.3g} {profile.unit}" for a, b in edges]
    low, high = int(np.nanargmin(rms)), int(np.nanargmax(rms))
    return f"{rms[low]:.2g} um ({centres[low]}) .. {rms[high]:.2g} um ({centres[high]})"


def spectrum(error_um: Floats, Ts_s: float, bands: int = BANDS) -> Spectrum:
    """Rms of the error, (n,), in bands of equal width in log f (Hann window); the squares sum to its variance."""
    n = len(error_um)
    window = np.hanning(n) if n > 2 else np.ones(n)  # Hann's window of two samples is 0
    power = np.abs(np.fft.rfft((error_um - error_um.mean()) * window)) ** 2 * 2.0 / (n * float(window @ window))
    f_Hz = np.fft.rfftfreq(n, Ts_s)
    edges = np.geomspace(f_Hz[1], f_Hz[-1] * 1.0001, bands + 1)
    band = np.searchsorted(edges, f_Hz[1:], side="right") - 1
    total = np.bincount(band, power[1:], minlength=bands)[:bands]
    filled = np.bincount(band, minlength=bands)[:bands] > 0
    centres = np.sqrt(edges[:-1] * edges[1:])
    return Spectrum(tuple(centres[filled].tolist()), tuple(np.sqrt(total[filled]).tolist()))


def turning_points(u_V: Floats) -> NDArray[np.intp]:
    """Rows at which swings of the input, (n,), of at least 1 % of its range begin; the first and the last row included.

    A plateau at a turning point belongs to the swing that follows.
    """
    rows = turning_rows(u_V, SMALLEST_SWING * float(np.ptp(u_V)))
    plateau_starts = np.maximum.accumulate(np.where(np.diff(u_V, prepend=np.nan) != 0.0, np.arange(len(u_V)), 0))
    return np.unique(np.concatenate([[0], plateau_starts[rows], [len(u_V) - 1]]))


def _swings(u_V: Floats, Ts_s: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Half size in V, frequency in Hz, direction and age in s of the swing of each sample, (n,) each."""
    turns = turning_points(u_V)
    n = len(u_V)
    swing = np.clip(np.searchsorted(turns, np.arange(n), side="right") - 1, 0, max(len(turns) - 2, 0))
    size_V = np.abs(np.diff(u_V[turns])) if len(turns) > 1 else np.zeros(1)
    length_s = np.diff(turns) * Ts_s if len(turns) > 1 else np.full(1, n * Ts_s)
    direction = np.sign(np.diff(u_V, prepend=u_V[0]))
    age_s = (np.arange(n) - turns[swing]) * Ts_s
    return 0.5 * size_V[swing], 1.0 / (2.0 * np.maximum(length_s, Ts_s))[swing], direction, age_s.astype(np.float64)
