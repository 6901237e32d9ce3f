"""Measured and simulated displacement: in time, as error, as loops; frequency response.

Frequency response by Welch's method, H1 = S_uy / S_uu, of the measured and of the simulated displacement under the same
voltage; shown where the measured coherence exceeds LEAST_COHERENCE. Error: simulated - measured.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from scipy.signal import csd

from hysgen.diagnosis.evaluation import Study
from hysgen.model.simulate import HorizonCurve
from hysgen.record import Record
from hysgen.report import plots
from hysgen.report.plots import Picture

Floats = NDArray[np.float64]
MOST_POINTS = 20_000
"""Most points drawn per curve: more are not visible and make the file slow to open."""


def validation(record: Record, simulated_um: Mapping[str, Floats], title: str, colours: Mapping[str, str]) -> Figure:
    """Displacement against time, measured and simulated, and below it the errors, simulated - measured.

    Each error has an axis of its own: on one axis, the smaller is flat. Shows the first segment of the record.
    simulated_um: (n,) by name in the legend; colours: by the same names.
    """
    segment = record.segments[0]
    measured_um, t_s = segment.y_um, segment.start_s + record.Ts_s * np.arange(segment.samples, dtype=np.float64)
    count = len(simulated_um)
    fig = plots.figure(7.2, 3.2 + 1.4 * count)
    above, *others = fig.subplots(1 + count, 1, sharex=True, height_ratios=[2.0] + [1.0] * count)
    keep = thinned(t_s.size)
    above.plot(t_s[keep], measured_um[keep], color=plots.MEASURED, label="measured")
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
    lines: Mapping[str, Mapping[str, Any]],
) -> Picture:
    """Error rms against the horizon, both axes logarithmic, with a horizontal line for each of `levels_um`."""
    fig, axis = plots.axes("horizon [ms]", "error rms [µm]")
    for name, curve in curves.items():
        steps = np.array(curve.steps, dtype=np.float64)
        axis.loglog(steps * Ts_s * 1e3, curve.rms_um, marker=".", label=name, **lines[name])
    for name, level_um in levels_um.items():
        plots.level(axis, level_um, name)
    plots.decimal_ticks(axis)
    plots.legend_above(axis)
    ends = "; ".join(f"{name} {curve.rms_um[0]:.2g} to {curve.rms_um[-1]:.2g} µm" for name, curve in curves.items())
    last = max(curve.steps[-1] for curve in curves.values())
    return Picture("horizon", "Error against the horizon", f"Error rms from 1 to {last} samples ahead: {ends}.", fig)


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


def record_picture(study: Study) -> Picture:
    """Voltage and displacement of the whole record, and where it was cut."""
    record = study.record
    time_s, cut_s = record.Ts_s * np.arange(record.samples, dtype=np.float64), study.cut * record.Ts_s
    fig = plots.figure(*plots.WIDE_IN)
    above, below = fig.subplots(2, 1, sharex=True)
    above.plot(*envelope(time_s, record.u_V), color=plots.BASELINE, linewidth=plots.THIN)
    below.plot(*envelope(time_s, record.y_um), color=plots.MEASURED, linewidth=plots.THIN)
    for axis in (above, below):
        axis.axvline(cut_s, color=plots.NOTE, linestyle="--")
    for text, aside, side in (("identified", -4, "right"), ("held out", 4, "left")):
        plots.note(above, text, (cut_s, 1.0), ("data", "axes fraction"), side, aside)
    above.set(ylabel="voltage [V]")
    time_label = "time [s]" if len(record.segments) == 1 else "time [s], segments end to end"
    below.set(xlabel=time_label, ylabel="displacement [µm]", xlim=(0.0, float(time_s[-1])))
    alt = f"{record.one_line()}; held out from {cut_s:.3g} s on."
    return Picture("record", "Voltage and displacement", alt, fig, wide=True)


def spectra(Ts_s: float, u_V: Floats, y_um: Floats) -> tuple[Floats, tuple[Floats, Floats, NDArray[np.complex128]]]:
    """Frequencies in Hz, and by Welch's method S_uu, S_yy and S_uy of two series, (n,) each."""
    length = min(max(32, 2 * u_V.size // (WINDOWS + 1)), u_V.size)
    (f_Hz, uu), (_, yy), (_, uy) = (
        csd(first, second, 1.0 / Ts_s, "hann", length, length - length // 2)
        for first, second in ((u_V, u_V), (y_um, y_um), (u_V, y_um))
    )
    return f_Hz, (uu.real, yy.real, uy)


ZOOM = 0.06
"""Share of the samples that the zoom shows, about the largest error of the last model."""

LEAST_COHERENCE = 0.8

MEASURED: dict[str, Any] = {"color": plots.BEHIND, "linewidth": 2.2}


@dataclass(frozen=True, eq=False)
class Simulated:
    """Measured displacement, and free runs of models under the same voltage, (n,) each; the last model is the best one.

    runs: simulated displacement by the name of the model; lines: colour and line style by the same names.
    """

    t_s: Floats
    u_V: Floats
    measured_um: Floats
    runs: Mapping[str, Floats]
    lines: Mapping[str, Mapping[str, Any]]

    def error_um(self, name: str) -> Floats:
        """Error of a model, simulated - measured, (n,)."""
        return self.runs[name] - self.measured_um

    def rms_um(self, name: str) -> float:
        """Root mean square of the error of a model."""
        return float(np.sqrt(np.mean(self.error_um(name) ** 2)))


def fit_percent(measured_um: Floats, simulated_um: Floats) -> float:
    """NRMSE fit in %: 100 (1 - |y - yhat| / |y - mean y|), as system identification toolboxes state it."""
    about = float(np.linalg.norm(measured_um - measured_um.mean()))
    return 100.0 * (1.0 - float(np.linalg.norm(measured_um - simulated_um)) / max(about, 1e-300))


def free_run_pictures(shown: Simulated) -> list[Picture]:
    """Measured and simulated displacement in time, and the part of it about the largest error of the last model."""
    name = list(shown.runs)[-1]
    error_um = np.abs(shown.error_um(name))
    worst = int(np.argmax(error_um))
    half = max(20, int(0.5 * ZOOM * shown.t_s.size))
    part = slice(max(0, worst - half), min(shown.t_s.size, worst + half))
    fits = ", ".join(f"{key} {fit_percent(shown.measured_um, y_um):.4g} %" for key, y_um in shown.runs.items())
    where = f"Zoom at {shown.t_s[worst]:.4g} s: {name} is wrong by {error_um[worst]:.3g} µm."
    pictures = []
    for key, title, rows, alt in (
        ("free-run", "Free run", slice(None), f"Free run over {shown.t_s.size} samples; fit (NRMSE): {fits}."),
        ("zoom", f"Zoom on the largest error: {name}", part, where),
    ):
        fig, axis = plots.axes("time [s]", "displacement [µm]")
        axis.plot(*envelope(shown.t_s[rows], shown.measured_um[rows]), label="measured", **MEASURED)
        for label, y_um in shown.runs.items():
            axis.plot(*envelope(shown.t_s[rows], y_um[rows]), label=label, **shown.lines[label])
        axis.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        plots.legend_above(axis)
        pictures.append(Picture(key, title, alt, fig))
    pictures[0].figure.axes[0].axvspan(shown.t_s[part][0], shown.t_s[part][-1], color=plots.NOTE, alpha=0.25)
    return pictures


def loop_pictures(shown: Simulated) -> list[Picture]:
    """Measured loops behind those of each model."""
    stride = max(1, -(-shown.u_V.size // LOOP_POINTS))
    pictures = []
    for number, (label, y_um) in enumerate(shown.runs.items(), start=1):
        fig, axis = plots.axes("voltage [V]", "displacement [µm]")
        axis.plot(shown.u_V[::stride], shown.measured_um[::stride], label="measured", **MEASURED)
        axis.plot(shown.u_V[::stride], y_um[::stride], label=label, **shown.lines[label])
        plots.legend_above(axis)
        alt = f"Displacement over voltage: {label} misses the measured loops by {shown.rms_um(label):.3g} µm rms."
        pictures.append(Picture(f"loops-{number}", f"Loops: {label}", alt, fig))
    return pictures


def time_picture(shown: Simulated) -> Picture:
    """The error against time. Each model has an axis of its own: on one axis, the smaller error is flat."""
    fig = plots.figure(plots.HALF_IN[0], plots.HALF_IN[1] * max(1.0, 0.35 * len(shown.runs)))
    panels = fig.subplots(len(shown.runs), 1, sharex=True, squeeze=False)[:, 0]
    for axis, label in zip(panels, shown.runs, strict=True):
        axis.plot(
            *envelope(shown.t_s, shown.error_um(label)),
            linewidth=plots.THIN,
            label=label,
            color=shown.lines[label]["color"],
        )
        plots.legend_above(axis)
    fig.supylabel("simulated - measured [µm]", fontsize="medium")
    panels[-1].set_xlabel("time [s]")
    worst = "; ".join(f"{label} at most {float(np.abs(shown.error_um(label)).max()):.3g} µm" for label in shown.runs)
    return Picture("time", "Error in time", f"Error of the free run: {worst}.", fig)


def response_pictures(shown: Simulated) -> list[Picture]:
    """Gain and phase against frequency, measured and simulated."""
    Ts_s = float(np.mean(np.diff(shown.t_s)))
    f_Hz, (uu, yy, uy) = spectra(Ts_s, shown.u_V, shown.measured_um)
    coherent = np.abs(uy) ** 2 > LEAST_COHERENCE * uu * yy
    coherent[0] = False
    at_Hz = f_Hz[coherent]
    gain, gains = plots.axes("frequency [Hz]", "gain [µm/V]")
    phase, phases = plots.axes("frequency [Hz]", "phase [degrees]")
    remarks: dict[str, list[str]] = {"gain": [], "phase": []}
    for name, y_um in {"measured": shown.measured_um, **shown.runs}.items():
        _, (power, _, cross) = spectra(Ts_s, shown.u_V, y_um)
        response = cross[coherent] / power[coherent]
        turned = np.degrees(np.unwrap(np.angle(response)))
        line = MEASURED if name == "measured" else shown.lines[name]
        gains.loglog(at_Hz, np.abs(response), label=name, **line)
        phases.semilogx(at_Hz, turned, label=name, **line)
        if at_Hz.size:
            remarks["gain"].append(f"{name} {abs(response[0]):.3g} to {abs(response[-1]):.3g} µm/V")
            remarks["phase"].append(f"{name} {turned[0]:.0f} to {turned[-1]:.0f} degrees")
    for axis in (gains, phases):
        plots.decimal_ticks_of(axis.xaxis)
        plots.legend_above(axis)
    plots.decimal_ticks_of(gains.yaxis)
    span = f"from {at_Hz[0]:.3g} to {at_Hz[-1]:.3g} Hz" if at_Hz.size else f"nowhere above {LEAST_COHERENCE:g} coherent"
    return [
        Picture("gain", "Gain against frequency", f"Gain {span}: {'; '.join(remarks['gain'])}.", gain),
        Picture("phase", "Phase against frequency", f"Phase {span}: {'; '.join(remarks['phase'])}.", phase),
    ]
