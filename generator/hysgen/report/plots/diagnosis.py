"""Pictures of a diagnosis: error of the free run by time, horizon, frequency and input, and the gain of each extension.

The base model is dashed and vermilion, the extended model solid and blue. Error: simulated - measured.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from hysgen.diagnosis.error_map import ErrorMap, range_in_words
from hysgen.diagnosis.evaluation import Study
from hysgen.report.plots import style
from hysgen.report.plots.shares import shares_picture
from hysgen.report.plots.style import Picture
from hysgen.report.plots.system import system_pictures
from hysgen.report.plots.traces import envelope

Floats = NDArray[np.float64]

BASE, EXTENDED = "paper's model", "extended model"
LINES: dict[str, dict[str, Any]] = {
    BASE: {"color": style.SIMULATED, "linestyle": (0, (4, 1.5))},
    EXTENDED: {"color": style.EXTENDED, "linestyle": "solid"},
}
SIZE_IN = (4.7, 3.1)
LOOP_POINTS = 4000


def pictures(study: Study) -> list[Picture]:
    """All pictures of a diagnosis in reading order: loops, horizon, time, spectrum, profiles, shares, ladder."""
    shown = [(BASE, study.before), *([(EXTENDED, study.after)] if study.improved else [])]
    return [
        *system_pictures(study),
        *loop_pictures(study),
        horizon_picture(shown, study),
        time_picture(study),
        spectrum_picture(shown),
        *(profile_picture(shown, number) for number in range(len(study.before.profiles))),
        *([shares_picture(study)] if study.improved else []),
        ladder_picture(study),
    ]


def loop_pictures(study: Study) -> list[Picture]:
    """Measured loops behind those of the base, and behind those of the extended model."""
    held = study.held_out()
    runs = [("loops-before", BASE, held.base_um, study.before)]
    if study.improved:
        runs.append(("loops-after", EXTENDED, held.extended_um, study.after))
    stride = max(1, -(-held.u_V.size // LOOP_POINTS))
    panels = []
    for name, label, simulated_um, error in runs:
        fig, axis = _figure("voltage [V]", "displacement [µm]")
        axis.plot(held.u_V[::stride], held.measured_um[::stride], color="#777777", linewidth=2.2, label="measured")
        axis.plot(held.u_V[::stride], simulated_um[::stride], linewidth=1.0, label=label, **LINES[label])
        axis.legend(loc="upper left")
        alt = f"Displacement over voltage, held out: the {label} misses the loops by {error.rms_um:.3g} µm rms."
        panels.append(Picture(name, f"Measured loops and the {label}", alt, fig))
    return panels


def horizon_picture(shown: list[tuple[str, ErrorMap]], study: Study) -> Picture:
    """Error against the horizon, with noise floor and persistence."""
    fig, axis = _figure("horizon [ms]", "error rms [µm]")
    for label, error in shown:
        horizon_ms = 1e3 * study.record.Ts_s * np.array(error.horizon.steps, dtype=np.float64)
        axis.loglog(horizon_ms, error.horizon.rms_um, marker=".", label=label, **LINES[label])
    _level(axis, study.diagnosis.noise.rms_um, "noise floor")
    _level(axis, study.diagnosis.persistence_um, "persistence, 1 step")
    _plain(axis, x=False)
    axis.legend(loc="best")
    ends = "; ".join(f"{label} {w.horizon.rms_um[0]:.2g} to {w.horizon.rms_um[-1]:.2g} µm" for label, w in shown)
    last = study.before.horizon.steps[-1]
    return Picture("horizon", "Error against the horizon", f"Error rms from 1 to {last} samples ahead: {ends}.", fig)


def time_picture(study: Study) -> Picture:
    """The error against time over the held-out part. Each model has an axis of its own: on one, the smaller is flat."""
    held = study.held_out()
    runs = [(BASE, held.base_um), *([(EXTENDED, held.extended_um)] if study.improved else [])]
    fig = style.figure(*SIZE_IN)
    panels = fig.subplots(len(runs), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (label, simulated_um) in zip(panels, runs, strict=True):
        axis.plot(
            *envelope(held.t_s, simulated_um - held.measured_um),
            linewidth=0.8,
            label=label,
            color=LINES[label]["color"],
        )
        axis.margins(y=0.25)
        axis.legend(loc="upper left")
    fig.supylabel("simulated - measured [µm]", fontsize="medium")
    panels[-1].set_xlabel("time [s]")
    worst = "; ".join(f"{label} at most {float(np.abs(y - held.measured_um).max()):.3g} µm" for label, y in runs)
    return Picture("time", "Error in time", f"Error of the free run over the held-out part: {worst}.", fig)


def spectrum_picture(shown: list[tuple[str, ErrorMap]]) -> Picture:
    """The error per frequency band."""
    fig, axis = _figure("frequency [Hz]", "error, rms per band [µm]")
    for label, error in shown:
        axis.loglog(error.spectrum.f_Hz, error.spectrum.rms_um, label=label, **LINES[label])
    _plain(axis)
    axis.legend(loc="best")
    peaks = []
    for label, error in shown:
        top = int(np.argmax(error.spectrum.rms_um))
        peaks.append(f"{label} {error.spectrum.rms_um[top]:.2g} µm at {error.spectrum.f_Hz[top]:.3g} Hz")
    return Picture("spectrum", "Error over frequency", f"Largest bands: {'; '.join(peaks)}.", fig)


def profile_picture(shown: list[tuple[str, ErrorMap]], number: int) -> Picture:
    """The rms error sorted by one quantity, on a logarithmic axis: both models are seen."""
    first = shown[0][1].profiles[number]
    fig, axis = _figure(f"{first.quantity} [{first.unit}]", "error rms [µm]")
    levels = np.concatenate([np.array(error.profiles[number].rms_um) for _, error in shown])
    lowest = 0.5 * float(np.nanmin(levels[levels > 0.0])) if (levels > 0.0).any() else 1e-9
    for label, error in shown:
        profile = error.profiles[number]
        heights = np.array(profile.rms_um)
        # No line where the record has no such samples, and none down to the frame: both would look like an error of 0.
        steps = np.where(heights > 0.0, heights, np.nan)
        axis.stairs(steps, profile.edges, baseline=None, label=label, linewidth=1.4, **LINES[label])
    axis.set_yscale("log")
    axis.set_ylim(lowest, 3.0 * max(float(np.nanmax(levels)), lowest))
    _plain(axis, x=False)
    if first.edges == (-1.5, -0.5, 0.5, 1.5):
        axis.set_xticks([-1, 0, 1], first.unit.split(", "))
        axis.set_xlabel(f"{first.quantity} of the input")
    elif first.edges[0] > 0 and first.edges[-1] / first.edges[0] > 50:
        axis.set_xscale("log")
        axis.xaxis.set_major_formatter(FuncFormatter(style.plain_number))
    axis.legend(loc="upper left", ncols=2)
    ends = "; ".join(f"{label} {range_in_words(error.profiles[number])}" for label, error in shown)
    alt = f"Error rms by {first.quantity}: {ends}."
    return Picture(f"error-by-{first.quantity.split(' of ')[0].replace(' ', '-')}", f"By {first.quantity}", alt, fig)


def ladder_picture(study: Study) -> Picture:
    """Held-out free-run error after each extension, with the 95 % interval of its gain and its cycles."""
    diagnosis, causes = study.diagnosis, study.extended
    levels = [diagnosis.base_rms_um, *(cause.step.after_um for cause in causes)]
    labels = [BASE, *(f"+ {cause.name}" for cause in causes)]
    fig, axis = _figure("", "free run, held out, rms [µm]")
    place = np.arange(len(levels))
    lowest = 0.6 * min([*levels, diagnosis.noise.rms_um])
    axis.plot(place, levels, color=style.NOTE, linewidth=0.8, zorder=1)
    axis.scatter(place, levels, color=[style.SIMULATED] + [style.EXTENDED] * (len(levels) - 1), s=45, zorder=3)
    for i, cause in enumerate(causes, start=1):
        ends = [max(cause.step.before_um - fall, lowest) for fall in (cause.step.high_um, cause.step.low_um)]
        axis.plot([i, i], ends, color=style.EXTENDED, linewidth=1.5, zorder=2)
        if cause.step.before_um - cause.step.high_um < lowest:
            # The interval goes on below the frame: an arrow says so, where a line would look like its end.
            axis.plot([i], [lowest], marker="v", color=style.EXTENDED, clip_on=False, zorder=2)
    for i, level in enumerate(levels):
        price = causes[i - 1].price if i else None
        text = f"{level:.3g}" + (f"\n{price.cycles:+d} cycles" if price else "")
        # Labels of neighbours of about the same level would touch: every second one stands below its point.
        below = i % 2 == 1
        axis.annotate(
            text,
            (i, level),
            xytext=(8, -4 if below else 4),
            textcoords="offset points",
            va="top" if below else "bottom",
            fontsize=8,
        )
    axis.set_yscale("log")
    axis.set_ylim(lowest, 4.0 * max(levels))
    _plain(axis, x=False)
    axis.set_xlim(-0.4, len(levels) + 0.3)
    _level(axis, diagnosis.noise.rms_um, "noise floor")
    axis.set_xticks(place, [label.replace("'s ", "'s\n") for label in labels], fontsize=8 if len(labels) < 6 else 7)
    steps = ", ".join(f"{label} {level:.3g} µm" for label, level in zip(labels, levels, strict=True))
    alt = f"Free-run error on held-out data: {steps}; noise floor {diagnosis.noise.rms_um:.2g} µm."
    return Picture("ladder", "What each extension gains", alt, fig)


def _figure(xlabel: str, ylabel: str) -> tuple[Figure, Axes]:
    fig = style.figure(*SIZE_IN)
    axis = fig.subplots()
    axis.set(xlabel=xlabel, ylabel=ylabel)
    return fig, axis


def _plain(axis: Axes, x: bool = True) -> None:
    """Decimal tick labels on logarithmic axes, at 1, 2 and 5 of each decade."""
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=20))
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_formatter(FuncFormatter(style.plain_number))
    if x:
        axis.xaxis.set_major_formatter(FuncFormatter(style.plain_number))


def _level(axis: Axes, level_um: float, name: str) -> None:
    axis.axhline(level_um, color="#666666", linestyle=":", linewidth=1.0)
    axis.annotate(
        name,
        (1.0, level_um),
        xycoords=("axes fraction", "data"),
        xytext=(0, 2),
        textcoords="offset points",
        ha="right",
        va="bottom",
        fontsize=8,
        color="#555555",
    )
