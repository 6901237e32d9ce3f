"""Pictures of a diagnosis beyond the error: record and spectra, free run with zoom, correlations, frequency response.

Frequency response by Welch's method, H1 = S_uy / S_uu, of the measured and of the simulated displacement under the same
voltage; shown where the measured coherence exceeds LEAST_COHERENCE.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from hysgen.diagnosis.evaluation import HeldOut, Study
from hysgen.report.plots import style
from hysgen.report.plots.style import Picture
from hysgen.report.plots.traces import envelope

Floats = NDArray[np.float64]

BASE, EXTENDED = "paper's model", "extended model"
COLOURS = {BASE: style.SIMULATED, EXTENDED: style.EXTENDED}

WIDE_IN = (9.6, 3.4)
"""Size of a picture over the whole width of the page; letters appear as large as in the small ones."""

ZOOM = 0.06
"""Share of the held-out part that the zoom shows, about the largest error of the delivered model."""

WINDOWS = 12
"""Windows of a spectrum, which overlap by half."""

LEAST_COHERENCE = 0.8
MOST_LAGS = 200
BOUND = 2.58
"""Bound of a correlation of white noise with 99 % probability, in 1/sqrt(n)."""


def system_pictures(study: Study) -> list[Picture]:
    """The record, its spectra, the free run with zoom, residual correlations, frequency response."""
    held = study.held_out()
    return [
        record_picture(study),
        spectra_picture(study),
        zoom_picture(study, held),
        correlation_picture(study, held),
        response_picture(study, held),
    ]


def fit_percent(measured_um: Floats, simulated_um: Floats) -> float:
    """NRMSE fit in %: 100 (1 - |y - yhat| / |y - mean y|), as system identification toolboxes state it."""
    about = float(np.linalg.norm(measured_um - measured_um.mean()))
    return 100.0 * (1.0 - float(np.linalg.norm(measured_um - simulated_um)) / max(about, 1e-300))


def record_picture(study: Study) -> Picture:
    """Voltage and displacement of the whole record, and where it was cut."""
    record = study.record
    time_s = record.Ts_s * np.arange(record.samples, dtype=np.float64)
    fig = style.figure(*WIDE_IN)
    above, below = fig.subplots(2, 1, sharex=True)
    above.plot(*envelope(time_s, record.u_V), color=style.BASELINE, linewidth=0.7)
    below.plot(*envelope(time_s, record.y_um), color=style.MEASURED, linewidth=0.7)
    for axis in (above, below):
        axis.axvline(study.cut * record.Ts_s, color=style.NOTE, linestyle="--", linewidth=1.0)
    below.annotate("held out", (study.cut * record.Ts_s, 1.0), xycoords=("data", "axes fraction"), xytext=(4, -10),
                   textcoords="offset points", fontsize=8)  # fmt: skip
    above.set(ylabel="voltage [V]")
    below.set(xlabel="time [s], segments end to end", ylabel="displacement [µm]")
    alt = f"{record.one_line()}; held out from {study.cut * record.Ts_s:.3g} s on."
    return Picture("record", "The record", alt, fig, wide=True)


def spectra_picture(study: Study) -> Picture:
    """Power of voltage and displacement by frequency."""
    fig, axis = _axes("frequency [Hz]", "amplitude density, relative to the largest")
    longest = max(study.record.segments, key=lambda one: one.samples)
    tops = []
    for name, values, colour in (
        ("voltage", longest.u_V, style.BASELINE),
        ("displacement", longest.y_um, style.MEASURED),
    ):
        f_Hz, (power,) = _spectra(study.record.Ts_s, values)
        density = np.sqrt(power[1:] / power[1:].max())
        axis.loglog(f_Hz[1:], density, color=colour, label=name)
        tops.append(f"{name} largest at {f_Hz[1:][int(np.argmax(power[1:]))]:.3g} Hz")
    axis.legend(loc="best")
    return Picture("record-spectrum", "Spectrum of the record", f"Amplitude density: {'; '.join(tops)}.", fig)


def zoom_picture(study: Study, held: HeldOut) -> Picture:
    """Measured and simulated displacement over the held-out part, and a part of it about the largest error."""
    fig = style.figure(*WIDE_IN)
    left, right = fig.subplots(1, 2, width_ratios=(1.5, 1.0))
    runs = _runs(study, held)
    delivered = list(runs.values())[-1]
    worst = int(np.argmax(np.abs(delivered - held.measured_um)))
    half = max(20, int(0.5 * ZOOM * held.t_s.size))
    part = slice(max(0, worst - half), min(held.t_s.size, worst + half))
    for axis, rows in ((left, slice(None)), (right, part)):
        axis.plot(*envelope(held.t_s[rows], held.measured_um[rows]), color="#777777", linewidth=2.2, label="measured")
        for name, y_um in runs.items():
            axis.plot(*envelope(held.t_s[rows], y_um[rows]), color=COLOURS[name], linewidth=1.0, label=name)
        axis.set(xlabel="time [s]")
    left.axvspan(held.t_s[part][0], held.t_s[part][-1], color=style.NOTE, alpha=0.25)
    left.set(ylabel="displacement [µm]")
    right.xaxis.set_major_locator(MaxNLocator(4))
    right.legend(loc="best")
    fits = ", ".join(f"{name} {fit_percent(held.measured_um, y_um):.4g} %" for name, y_um in runs.items())
    alt = f"Free run over {held.t_s.size} held-out samples; fit (NRMSE): {fits}. Zoom at {held.t_s[worst]:.4g} s."
    return Picture("free-run", "Measured and simulated in time, with zoom", alt, fig, wide=True)


def correlation_picture(study: Study, held: HeldOut) -> Picture:
    """Autocorrelation of the residual of the free run, and its cross-correlation with the voltage."""
    fig = style.figure(*WIDE_IN)
    left, right = fig.subplots(1, 2)
    lags = np.arange(min(MOST_LAGS, held.t_s.size // 4))
    u = held.u_V - held.u_V.mean()
    remarks = []
    for name, y_um in _runs(study, held).items():
        error = y_um - held.measured_um
        error = error - error.mean()
        auto, cross = correlation(error, error, lags), correlation(u, error, lags)
        left.plot(lags, auto, color=COLOURS[name], label=name)
        right.plot(lags, cross, color=COLOURS[name], label=name)
        remarks.append(
            f"{name}: after {lags[-1]} samples {auto[-1]:.2f}, with the voltage at most {np.abs(cross).max():.2f}"
        )
    bound = BOUND / math.sqrt(held.t_s.size)
    for axis in (left, right):
        axis.axhspan(-bound, bound, color=style.NOTE, alpha=0.3)
        axis.set(xlabel="lag [samples]", ylim=(-1.05, 1.05))
    left.set(ylabel="autocorrelation of the error")
    right.set(ylabel="cross-correlation with the voltage")
    left.legend(loc="best")
    alt = f"Correlations of the error of the free run: {'; '.join(remarks)}; 99 % bound of white noise {bound:.2g}."
    return Picture("correlation", "What the error still follows", alt, fig, wide=True)


def response_picture(study: Study, held: HeldOut) -> Picture:
    """Gain and phase against frequency, measured and simulated."""
    fig = style.figure(*WIDE_IN)
    left, right = fig.subplots(1, 2)
    f_Hz, (uu, yy, uy) = _spectra(study.record.Ts_s, held.u_V, held.measured_um)
    coherent = np.abs(uy) ** 2 > LEAST_COHERENCE * uu * yy
    coherent[0] = False
    shown = f_Hz[coherent]
    series = {"measured": held.measured_um, **_runs(study, held)}
    remarks = []
    for name, y_um in series.items():
        _, (power, _, cross) = _spectra(study.record.Ts_s, held.u_V, y_um)
        response = cross[coherent] / power[coherent]
        colour = COLOURS.get(name, "#777777")
        width = 2.2 if name == "measured" else 1.0
        left.loglog(shown, np.abs(response), color=colour, linewidth=width, label=name)
        right.semilogx(shown, np.degrees(np.unwrap(np.angle(response))), color=colour, linewidth=width)
        if shown.size:
            remarks.append(f"{name} {abs(response[0]):.3g} to {abs(response[-1]):.3g} µm/V")
    for ticks in (left.xaxis, left.yaxis, right.xaxis):
        ticks.set_major_formatter(FuncFormatter(style.plain_number))
    left.yaxis.set_minor_formatter(FuncFormatter(style.three_digits))
    right.xaxis.set_minor_formatter(NullFormatter())
    left.xaxis.set_minor_formatter(NullFormatter())
    left.set(xlabel="frequency [Hz]", ylabel="gain [µm/V]")
    right.set(xlabel="frequency [Hz]", ylabel="phase [degrees]")
    left.legend(loc="best")
    span = f"from {shown[0]:.3g} to {shown[-1]:.3g} Hz" if shown.size else "nowhere coherent"
    alt = f"Gain {span}: {'; '.join(remarks)}. Coherence above {LEAST_COHERENCE:g}."
    return Picture("response", "Gain and phase against frequency", alt, fig, wide=True)


def correlation(first: Floats, second: Floats, lags: NDArray[np.intp]) -> Floats:
    """sum_k first(k) second(k + lag) / sqrt(sum first^2 sum second^2) for each lag >= 0; inputs about their means."""
    n = first.size
    size = 2 * n
    spectrum = np.conj(np.fft.rfft(first, size)) * np.fft.rfft(second, size)
    scale = math.sqrt(float(first @ first) * float(second @ second)) or 1.0
    return np.asarray(np.fft.irfft(spectrum, size)[lags] / scale)


def _runs(study: Study, held: HeldOut) -> dict[str, Floats]:
    return {BASE: held.base_um} | ({EXTENDED: held.extended_um} if study.improved else {})


def _spectra(Ts_s: float, *series: Floats) -> tuple[Floats, tuple[Floats, ...]]:
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


def _axes(xlabel: str, ylabel: str) -> tuple[Figure, Axes]:
    fig = style.figure(4.7, 3.1)
    axis = fig.subplots()
    axis.set(xlabel=xlabel, ylabel=ylabel)
    return fig, axis
