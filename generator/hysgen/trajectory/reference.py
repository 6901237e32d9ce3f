"""The wanted displacement: a file of any rate, or a form by name, at the sampling period of the model."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import scipy  # its parts are imported where they work
from numpy.typing import ArrayLike, NDArray

from hysgen.errors import ModelError, RecordError
from hysgen.model.model import Model
from hysgen.model.simulate import rest_um, series
from hysgen.record.checks import check_finite
from hysgen.record.columns import NONE, Columns
from hysgen.record.read import content_of
from hysgen.record.runs import DEFAULT

Floats = NDArray[np.float64]

SAME_STEP = 1e-3
"""Deviation of a time step from the period, as a share of it, up to which samples are taken as they are."""

FLYBACK, LEVELS = 0.2, 8
"""Share of a period in which a scan flies back, and number of the steps of a staircase, up and down."""

OF_RANGE, F_HZ, PERIODS = 0.4, 10.0, 3
"""Of a form by name: amplitude as a share of the range at rest, frequency, number of periods, where none is given."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """values: (n,) in V or um at the period of a model, from start_s on. remarks: one line each."""

    values: Floats
    start_s: float
    source: str
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True)
class Form:
    """Amplitude (half of the stroke) and centre in um, frequency and number of periods of a form by name."""

    amplitude_um: float | None = None
    centre_um: float | None = None
    f_Hz: float = F_HZ
    periods: float = PERIODS


def _scan(phase: Floats) -> Floats:
    """-1 to 1 at constant speed, back along half a cosine."""
    back = (phase - (1.0 - FLYBACK)) / FLYBACK
    forth = 2.0 * phase / (1.0 - FLYBACK) - 1.0
    return np.asarray(np.where(back < 0.0, forth, np.cos(np.pi * np.clip(back, 0.0, 1.0))))


def _steps(phase: Floats) -> Floats:
    """LEVELS levels up and the same levels down."""
    place = np.floor(2 * LEVELS * phase)
    return np.asarray(2.0 * np.minimum(place, 2 * LEVELS - 1 - place) / (LEVELS - 1) - 1.0)


FORMS: Mapping[str, Callable[[Floats], Floats]] = {
    "constant": lambda phase: np.zeros(phase.size),
    "sine": lambda phase: np.sin(2.0 * np.pi * phase),
    "triangle": lambda phase: 1.0 - 4.0 * np.abs((phase + 0.25) % 1.0 - 0.5),
    "scan": _scan,
    "steps": _steps,
}
"""Forms by name: values in -1 .. 1 of the phase, which rises from 0 to 1 in every period."""


def reference_of(
    model: Model, given: str | os.PathLike[str] | ArrayLike, form: Form, columns: Columns = DEFAULT
) -> Sampled:
    """The reference from the name of a form, from a file, or from an array at the model's period, as `series_of`.

    Raises ModelError for a form that is empty or too fast, too.
    """
    if isinstance(given, str) and given in FORMS and not Path(given).exists():
        return _of_form(model, given, form)
    return series_of(given, "displacement", columns, model.Ts_s)


@dataclass(frozen=True, eq=False)
class Series:
    """One quantity over time: time_s (n,) rising, values (n,) in V or um, the file, and remarks for the user."""

    time_s: NDArray[np.float64]
    values: NDArray[np.float64]
    source: str
    remarks: tuple[str, ...]


def load_series(
    path: str | os.PathLike[str], role: Literal["voltage", "displacement"], columns: Columns = DEFAULT
) -> Series:
    """The voltage or the displacement of a file that need not hold the other, at any rate, in any format of a record.

    Raises RecordError for a file that cannot be read, a number that is not finite, or times that do not rise.
    """
    file, other = Path(path), "voltage" if role == "displacement" else "displacement"
    read = content_of(file, columns.named({other: NONE}))
    run = read.runs[0]
    check_finite(run)
    values = run.y_um if role == "displacement" else run.u_V
    Ts_s = columns.Ts_s or read.Ts_s
    if not run.stamps_s.size and Ts_s is None:
        raise RecordError(f"{file.name}: has no time and no sampling period; give --columns Ts_s=SECONDS")
    time_s = run.stamps_s if run.stamps_s.size else (Ts_s or 0.0) * np.arange(values.size, dtype=np.float64)
    if values.size < 2 or not (np.diff(time_s) > 0.0).all():
        row = int(np.argmin(np.diff(time_s))) + 1 if values.size > 1 else 0
        raise RecordError(f"{file.name}: row {row}: the time does not rise; give two rows or more in the order of time")
    return Series(time_s, values, file.name, read.remarks)


def series_of(
    given: str | os.PathLike[str] | ArrayLike, role: Literal["voltage", "displacement"], columns: Columns, Ts_s: float
) -> Sampled:
    """A series at the period Ts from a file (`load_series`), or from an array that has this period.

    Raises RecordError for a file that cannot be read, ModelError for one that is too short or an array of no numbers.
    """
    if isinstance(given, (str, os.PathLike)):
        return at_rate(load_series(given, role, columns), Ts_s)
    return Sampled(series(given, role), 0.0, "array")


def at_rate(given: Series, Ts_s: float) -> Sampled:
    """The series at the period Ts, through its samples without overshoot (monotone cubic), with the reason in words."""
    steps = np.diff(given.time_s)
    if np.abs(steps - Ts_s).max() <= SAME_STEP * Ts_s:
        return Sampled(given.values, float(given.time_s[0]), given.source, given.remarks)
    count = int((given.time_s[-1] - given.time_s[0]) / Ts_s * (1.0 + 1e-9)) + 1
    if count < 2:
        raise ModelError(f"{given.source}: is shorter than two samples of the model, {2 * Ts_s:g} s; give a longer one")
    times_s = np.minimum(given.time_s[0] + Ts_s * np.arange(count), given.time_s[-1])
    values = scipy.interpolate.PchipInterpolator(given.time_s, given.values)(times_s)
    reason = (
        f"{given.source}: a sample every {float(np.median(steps)):.6g} s; the model steps every {Ts_s:.6g} s, so it is "
        "read between the samples"
    )
    return Sampled(np.asarray(values), float(times_s[0]), given.source, (*given.remarks, reason))


def _of_form(model: Model, name: str, form: Form) -> Sampled:
    low_um, high_um = (rest_um(model, u_V, {}) for u_V in (model.u_min_V, model.u_max_V))
    centre = 0.5 * (low_um + high_um) if form.centre_um is None else form.centre_um
    amplitude = OF_RANGE * abs(high_um - low_um) if form.amplitude_um is None else form.amplitude_um
    if not form.f_Hz > 0.0 or form.f_Hz * model.Ts_s > 0.1:
        raise ModelError(f"{name}: {form.f_Hz:g} Hz leaves fewer than 10 samples a period; choose a lower frequency")
    # A whole number of samples a period, so that a period can be played again and again.
    period = round(1.0 / (form.f_Hz * model.Ts_s))
    count = round(form.periods * period)
    if count < 2:
        raise ModelError(f"{name}: {form.periods:g} periods hold no two samples; choose more")
    phase = (np.arange(count) % period) / period
    return Sampled(centre + amplitude * FORMS[name](phase), 0.0, name)
