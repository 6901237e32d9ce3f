"""Measured and simulated displacement: in time, as error, as hysteresis loops, as spectra."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from hysgen.diagnosis.evaluation import Study
from hysgen.model.simulate import HorizonCurve
from hysgen.record import Record
from hysgen.report.plots import style
from hysgen.report.plots.style import Picture

Floats = NDArray[np.float64]
MOST_POINTS = 20_000
"""Most points drawn per curve: more are not visible and make the file slow to open."""


def validation(record: Record, simulated_um: Mapping[str, Floats], title: str, colours: Mapping[str, str]) -> Figure:
    """Displacement against time, measured and simulated, and below it the errors, simulated - measured.

    Each error has an axis of its own: on one axis, the smaller is flat. Shows the first segment of the record.
    simulated_um: (n,) by name in the legend; colours: by the same names.
    """
    measured_um, t_s = record.segments[0].y_um, times_s(record)
    count = len(simulated_um)
    fig = style.figure(7.2, 3.2 + 1.4 * count)
    above, *others = fig.subplots(1 + count, 1, sharex=True, height_ratios=[2.0] + [1.0] * count)
    keep = thinned(t_s.size)
    above.plot(t_s[keep], measured_um[keep], color=style.MEASURED, label="measured")
    for below, (name, y_um) in zip(others, simulated_um.items(), strict=True):
        above.plot(t_s[keep], y_um[keep], color=colours[name], linestyle="--")
        error_um = y_um - measured_um
        rms_um = float(np.sqrt(np.mean(error_um**2)))
        below.plot(t_s[keep], error_um[keep], color=colours[name], label=f"{name}: {rms_um:.2g} µm rms")
    above.set(ylabel="displacement [µm]", title=title)
    others[-1].set(xlabel="time [s]")
    # In the middle of all axes of errors: of the middle one, or between the two.
    others[(count - 1) // 2].set_ylabel("simulated - measured [µm]", y=0.5 if count % 2 else 0.0)
    fig.legend(loc="outside lower center", ncols=2)
    return fig


def horizon(
    curves: Mapping[str, HorizonCurve],
    levels_um: Mapping[str, float],
    Ts_s: float,
    title: str,
    lines: Mapping[str, Mapping[str, Any]],
) -> Figure:
    """Error rms against the horizon, both axes logarithmic, with a horizontal line for each of `levels_um`."""
    fig, axis = style.axes("horizon [ms]", "error rms [µm]")
    for name, curve in curves.items():
        steps = np.array(curve.steps, dtype=np.float64)
        axis.loglog(steps * Ts_s * 1e3, curve.rms_um, marker=".", label=name, **lines[name])
    for name, level_um in levels_um.items():
        style.level(axis, level_um, name)
    style.decimal_ticks(axis)
    if title:
        axis.set_title(title)
        axis.legend(loc="upper left")
    else:
        style.legend_above(axis)
    return fig


def times_s(record: Record) -> Floats:
    """Time stamps in s of the first segment, (n,)."""
    segment = record.segments[0]
    return segment.start_s + record.Ts_s * np.arange(segment.samples, dtype=np.float64)


def envelope(t_s: Floats, values: Floats, pieces: int = 1000) -> tuple[Floats, Floats]:
    """Minimum and maximum of each of `pieces` equal intervals, in time order: a reduced curve that keeps all peaks.

    t_s, values: (n,). Returns them unchanged if n <= 2 * pieces.
    """
    if values.size <= 2 * pieces:
        return t_s, values
    bounds = np.linspace(0, values.size, pieces + 1).astype(np.intp)
    rows = []
    for low, high in itertools.pairwise(bounds):
        part = values[low:high]
        rows += sorted({low + int(part.argmin()), low + int(part.argmax())})
    return t_s[rows], values[rows]


def thinned(samples: int) -> slice:
    """A slice with a constant stride that leaves at most MOST_POINTS of the samples."""
    return slice(None, None, max(1, -(-samples // MOST_POINTS)))


LOOP_POINTS = 4000

WINDOWS = 12
"""Windows of a spectrum, which overlap by half."""


def record_pictures(study: Study) -> list[Picture]:
    """The record in time, its loops, its spectra."""
    return [record_picture(study), loops_picture(study), spectra_picture(study)]


def record_picture(study: Study) -> Picture:
    """Voltage and displacement of the whole record, and where it was cut."""
    record = study.record
    time_s, cut_s = record.Ts_s * np.arange(record.samples, dtype=np.float64), study.cut * record.Ts_s
    fig = style.figure(*style.WIDE_IN)
    above, below = fig.subplots(2, 1, sharex=True)
    above.plot(*envelope(time_s, record.u_V), color=style.BASELINE, linewidth=style.THIN)
    below.plot(*envelope(time_s, record.y_um), color=style.MEASURED, linewidth=style.THIN)
    for axis in (above, below):
        axis.axvline(cut_s, color=style.NOTE, linestyle="--")
    for text, aside, side in (("identified", -4, "right"), ("held out", 4, "left")):
        style.note(above, text, (cut_s, 1.0), ("data", "axes fraction"), side, aside)
    above.set(ylabel="voltage [V]")
    below.set(xlabel=time_label(study), ylabel="displacement [µm]", xlim=(0.0, float(time_s[-1])))
    alt = f"{record.one_line()}; held out from {cut_s:.3g} s on."
    return Picture("record", "Voltage and displacement", alt, fig, wide=True)


def loops_picture(study: Study) -> Picture:
    """Displacement over voltage of the whole record: whether the held-out rows lie inside the identified range."""
    record, cut = study.record, study.cut
    fig, axis = style.axes("voltage [V]", "displacement [µm]")
    for rows, colour, label in (
        (slice(0, cut), "#aaaaaa", "identified"),
        (slice(cut, None), style.MEASURED, "held out"),
    ):
        u_V, y_um = record.u_V[rows], record.y_um[rows]
        stride = max(1, -(-u_V.size // LOOP_POINTS))
        axis.plot(u_V[::stride], y_um[::stride], color=colour, linewidth=style.THIN, label=label)
    style.legend_above(axis)
    ranges = "; ".join(
        f"{name} {values.min():.4g} to {values.max():.4g} {unit}"
        for name, values, unit in (
            ("voltage held out", record.u_V[cut:], "V"),
            ("displacement held out", record.y_um[cut:], "µm"),
        )
    )
    return Picture("record-loops", "Loops", f"Displacement over voltage: {ranges}.", fig)


def spectra_picture(study: Study) -> Picture:
    """Amplitude density of voltage and displacement by frequency."""
    fig, axis = style.axes("frequency [Hz]", "amplitude density / its maximum")
    longest = max(study.record.segments, key=lambda segment: segment.samples)
    tops = []
    for name, values, colour in (
        ("voltage", longest.u_V, style.BASELINE),
        ("displacement", longest.y_um, style.MEASURED),
    ):
        f_Hz, (power,) = spectra(study.record.Ts_s, values)
        density = np.sqrt(power[1:] / power[1:].max())
        axis.loglog(f_Hz[1:], density, color=colour, linewidth=style.THIN, label=name)
        tops.append(f"{name} largest at {f_Hz[1:][int(np.argmax(power[1:]))]:.3g} Hz")
    axis.xaxis.set_major_formatter(FuncFormatter(style.plain_number))
    style.legend_above(axis)
    return Picture("record-spectrum", "Spectra", f"Amplitude density: {'; '.join(tops)}.", fig)


def time_label(study: Study) -> str:
    """Label of the axis of time over the whole record."""
    return "time [s]" if len(study.record.segments) == 1 else "time [s], segments end to end"


def spectra(Ts_s: float, *series: Floats) -> tuple[Floats, tuple[Floats, ...]]:
    """Frequencies, and by Welch's method S_xx of one series, or S_xx, S_yy and S_xy of two."""
    n = series[0].size
    length = max(32, 2 * n // (WINDOWS + 1))
    window = np.hanning(min(length, n))
    starts = range(0, n - window.size + 1, max(1, window.size // 2))
    parts = [
        np.fft.rfft(
            np.stack([(values[a : a + window.size] - values[a : a + window.size].mean()) * window for a in starts])
        )
        for values in series
    ]
    powers = [np.mean(np.abs(part) ** 2, axis=0) for part in parts]
    if len(parts) == 2:
        powers.append(np.mean(np.conj(parts[0]) * parts[1], axis=0))
    return np.asarray(np.fft.rfftfreq(window.size, Ts_s), dtype=np.float64), tuple(powers)
