"""Pictures of the record of a diagnosis: voltage and displacement in time, as loops, and their spectra."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from hysgen.diagnosis.evaluation import Study
from hysgen.report.plots import style
from hysgen.report.plots.style import Picture
from hysgen.report.plots.traces import envelope

Floats = NDArray[np.float64]

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
    longest = max(study.record.segments, key=lambda one: one.samples)
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
        np.fft.rfft(np.stack([(one[a : a + window.size] - one[a : a + window.size].mean()) * window for a in starts]))
        for one in series
    ]
    powers = [np.mean(np.abs(part) ** 2, axis=0) for part in parts]
    if len(parts) == 2:
        powers.append(np.mean(np.conj(parts[0]) * parts[1], axis=0))
    return np.asarray(np.fft.rfftfreq(window.size, Ts_s), dtype=np.float64), tuple(powers)
