"""Pictures of the method `.plot()` of a result; those of a diagnosis: error by time, horizon, frequency and input, gain
of each extension.

The paper's model is dashed and vermilion, the extended model solid and blue. Error: simulated - measured.
"""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hysgen.certify.certificates import dynamics
from hysgen.checking.cost import Cost
from hysgen.diagnosis.error_map import ErrorMap, range_in_words
from hysgen.diagnosis.evaluation import Study
from hysgen.errors import HysgenError
from hysgen.feedback.certificate import LoopDesign
from hysgen.model.model import Model
from hysgen.model.scores import Scores
from hysgen.model.simulate import free_run
from hysgen.record import Record
from hysgen.report import plots
from hysgen.report.plots import BASE_MODEL, EXTENDED_MODEL, LINES, Picture
from hysgen.report.plots.traces import (
    LOOP_POINTS,
    Simulated,
    envelope,
    free_run_pictures,
    horizon,
    record_picture,
    response_pictures,
    time_picture,
    validation,
)
from hysgen.trajectory.plan import Waveform

BAR = 4.0
"""Width of the bar that shows the interval of a gain, in points."""


def pictures(study: Study) -> list[Picture]:
    """All pictures of a diagnosis in reading order: record, free run, error, its profiles, ladder."""
    shown = [(BASE_MODEL, study.before), *([(EXTENDED_MODEL, study.after)] if study.improved else [])]
    runs = held_out_runs(study)
    return [
        record_picture(study),
        *free_run_pictures(runs),
        *response_pictures(runs),
        time_picture(runs),
        horizon_picture(shown, study),
        spectrum_picture(shown),
        profiles_picture(shown),
        ladder_picture(study),
    ]


def held_out_runs(study: Study) -> Simulated:
    """Free runs of the paper's model and, if there are extensions, of the extended one over the held-out part."""
    held = study.held_out()
    runs = {BASE_MODEL: held.base_um} | ({EXTENDED_MODEL: held.extended_um} if study.improved else {})
    return Simulated(held.t_s, held.u_V, held.measured_um, runs, LINES)


def horizon_picture(shown: list[tuple[str, ErrorMap]], study: Study) -> Picture:
    """Error against the horizon, with noise floor and persistence."""
    levels_um = {
        "noise floor": study.diagnosis.noise.rms_um,
        "persistence, 1 step": study.diagnosis.persistence_um,
    }
    return horizon({label: error.horizon for label, error in shown}, levels_um, study.record.Ts_s, LINES)


def spectrum_picture(shown: list[tuple[str, ErrorMap]]) -> Picture:
    """The error per frequency band."""
    fig, axis = plots.axes("frequency [Hz]", "error, rms per band [µm]")
    for label, error in shown:
        axis.loglog(error.spectrum.f_Hz, error.spectrum.rms_um, label=label, **LINES[label])
    plots.decimal_ticks(axis)
    plots.legend_above(axis)
    peaks = []
    for label, error in shown:
        top = int(np.argmax(error.spectrum.rms_um))
        peaks.append(f"{label} {error.spectrum.rms_um[top]:.2g} µm at {error.spectrum.f_Hz[top]:.3g} Hz")
    return Picture("spectrum", "Error over frequency", f"Largest bands: {'; '.join(peaks)}.", fig)


SHORT = {
    "amplitude of the swing": "amplitude",
    "frequency of the swing": "frequency",
    "level of the input": "level",
    "time since the last turning point": "since the last turn",
}
"""Names of quantities below a small axis."""


def profiles_picture(shown: list[tuple[str, ErrorMap]]) -> Picture:
    """The rms error sorted by each quantity, small axes in one row with one logarithmic scale of the error."""
    profiles = [error.profiles for _, error in shown]
    fig = plots.figure(plots.WIDE_IN[0], 2.3)
    panels = fig.subplots(1, len(profiles[0]), sharey=True)
    levels = np.concatenate([np.array(profile.rms_um) for error in profiles for profile in error])
    lowest = 0.5 * float(np.nanmin(levels[levels > 0.0])) if (levels > 0.0).any() else 1e-9
    for number, axis in enumerate(panels):
        first = profiles[0][number]
        for (label, _), error in zip(shown, profiles, strict=True):
            heights = np.array(error[number].rms_um)
            # No line where the record has no such samples, and none down to the frame: both would look like an error
            # of 0.
            steps = np.where(heights > 0.0, heights, np.nan)
            axis.stairs(steps, error[number].edges, baseline=None, label=label, **LINES[label])
        axis.set_xlabel(f"{SHORT.get(first.quantity, first.quantity)} [{first.unit}]")
        axis.set_yscale("log")
        if first.edges == (-1.5, -0.5, 0.5, 1.5):
            axis.set_xticks([-1, 0, 1], first.unit.split(", "))
            axis.set_xlabel(f"{first.quantity} of the input")
        elif first.edges[0] > 0 and first.edges[-1] / first.edges[0] > 50:
            axis.set_xscale("log")
            plots.decimal_ticks_of(axis.xaxis, 3)
        else:
            axis.xaxis.set_major_locator(MaxNLocator(3))
    panels[0].set(ylabel="error rms [µm]", ylim=(lowest, 2.0 * max(float(np.nanmax(levels)), lowest)))
    plots.decimal_ticks_of(panels[0].yaxis)
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=len(shown))
    worst = (
        f"{first.quantity}: "
        + "; ".join(
            f"{label} {range_in_words(error[number])}" for (label, _), error in zip(shown, profiles, strict=True)
        )
        for number, first in enumerate(profiles[0])
    )
    return Picture("profiles", "Error by what the input does", f"Error rms by {'. By '.join(worst)}.", fig, wide=True)


def ladder_picture(study: Study) -> Picture:
    """Held-out free-run error after each extension, a row each, with the 95 % interval of its gain and its cycles.

    Bar: the error after the step plus the interval of its gain; left of the point, the step loses.
    """
    diagnosis, causes = study.diagnosis, study.extended
    levels = [diagnosis.base_rms_um, *(cause.step.after_um for cause in causes)]
    labels = [BASE_MODEL, *(f"+ {cause.name}" for cause in causes)]
    fig = plots.figure(plots.WIDE_IN[0], 1.1 + 0.36 * len(levels))
    axis = fig.subplots()
    lowest = 0.6 * min([*levels, diagnosis.noise.rms_um])
    for i, cause in enumerate(causes, start=1):
        # The error after the step plus the interval of its gain: positive where the gain is certain, unlike the error
        # before minus that interval, and inside the frame.
        step = cause.step
        ends = [max(step.after_um + gain, lowest) for gain in (step.low_um, step.high_um)]
        axis.plot([step.before_um, step.after_um], [i, i], color=plots.NOTE)
        axis.plot(ends, [i, i], color=plots.EXTENDED, linewidth=BAR, alpha=0.45, solid_capstyle="butt")
    colours = [plots.SIMULATED] + [plots.EXTENDED] * (len(levels) - 1)
    for i, (level, colour) in enumerate(zip(levels, colours, strict=True)):
        axis.plot(level, i, marker="o", color=colour)
    axis.set_xscale("log")
    highest = max([*levels, *(cause.step.after_um + cause.step.high_um for cause in causes)])
    axis.set(xlabel="free run, held out, rms [µm]", xlim=(lowest, 1.5 * highest))
    axis.set_yticks(range(len(levels)), labels)
    axis.set_ylim(len(levels) - 0.5, -0.5)
    axis.grid(visible=False, axis="y")
    plots.decimal_ticks_of(axis.xaxis)
    axis.axvline(diagnosis.noise.rms_um, color=plots.BEHIND, linestyle=":")
    plots.note(axis, "noise floor", (diagnosis.noise.rms_um, 1.0), ("data", "axes fraction"), "center")
    # Columns of numbers to the right of the frame, where no point can be.
    columns: list[tuple[float, str, list[str]]] = [
        (1.09, "rms [µm]", [f"{level:.3g}" for level in levels]),
        (1.19, "cycles", ["", *(f"{cause.price.cycles:+d}" if cause.price else "?" for cause in causes)]),
    ]
    for place, head, cells in columns:
        plots.note(axis, head, (place, 1.0), ("axes fraction", "axes fraction"), "right")
        for i, cell in enumerate(cells):
            axis.text(place, i, cell, transform=axis.get_yaxis_transform(), ha="right", va="center")
    steps = ", ".join(f"{label} {level:.3g} µm" for label, level in zip(labels, levels, strict=True))
    alt = f"Free-run error on held-out data: {steps}; noise floor {diagnosis.noise.rms_um:.2g} µm."
    return Picture("ladder", "Error after each extension", alt, fig, wide=True)


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure that a notebook displays as PNG."""

    figure: Figure

    def __post_init__(self) -> None:
        plots.named(self.figure)

    def save(self, path: str | Path) -> Path:
        """Write the figure as SVG if the name ends in .svg, else as PNG. Returns the path."""
        return plots.save(self.figure, Path(path))

    def _repr_png_(self) -> bytes:
        return plots.png_bytes(self.figure)


@functools.singledispatch
def draw(result: Any, *what: Any) -> Drawing:
    """The picture of a result. Raises HysgenError if results of its type have none."""
    raise HysgenError(f"{type(result).__name__}: there is nothing to plot; print it instead")


@draw.register
def _(result: Record) -> Drawing:
    """Input and displacement against time, and displacement against input."""
    fig, above, below, side = plots.axes_beside()
    for segment in result.segments:
        t_s = segment.start_s + result.Ts_s * np.arange(segment.samples, dtype=np.float64)
        above.plot(*envelope(t_s, segment.u_V), color=plots.EXTENDED, linewidth=plots.THIN)
        below.plot(*envelope(t_s, segment.y_um), color=plots.MEASURED, linewidth=plots.THIN)
        stride = max(1, -(-segment.samples // LOOP_POINTS))
        side.plot(segment.u_V[::stride], segment.y_um[::stride], color=plots.MEASURED, linewidth=plots.THIN)
    above.set(ylabel="voltage [V]", title=result.source)
    below.set(xlabel="time [s]", ylabel="displacement [µm]")
    side.set(xlabel="voltage [V]", ylabel="displacement [µm]")
    return Drawing(fig)


@draw.register
def _(result: Model, record: Record | None = None) -> Drawing:
    """With a record: free run and error. Without: area of the loop, as a share of its bounding box, by frequency."""
    if record is not None:
        runs = {"free run": free_run(result, record)[0].y_um}
        title = f"{result.name} on {record.source}"
        return Drawing(validation(record, runs, title, {"free run": plots.SIMULATED}))
    system = dynamics(result)
    fig, axis = plots.axes("frequency [Hz]", "loop fills its box [%]")
    axis.semilogx([loop.f_Hz for loop in system.loops], [100.0 * loop.filling for loop in system.loops], marker=".")
    axis.set(title=result.name, ylim=(0.0, None))
    return Drawing(fig)


@draw.register
def _(result: Scores) -> Drawing:
    """Error against the horizon, with noise floor and free run."""
    levels = {"noise floor": result.noise.rms_um, "free run": result.free_run.e_rms_um}
    name = f"{result.model} on {result.source}"
    return Drawing(horizon({name: result.horizon}, levels, result.Ts_s, {name: {"color": plots.EXTENDED}}).figure)


@draw.register
def _(result: Study, name: str = "ladder") -> Drawing:
    """One picture of the report, by name. Raises HysgenError for a name that is not among them."""
    drawn = {picture.name: picture for picture in pictures(result)}
    if name not in drawn:
        raise HysgenError(f"{name}: there is no such picture; choose one of {', '.join(drawn)}")
    return Drawing(drawn[name].figure)


@draw.register
def _(result: Cost) -> Drawing:
    """Cycles of every function against the sample period."""
    fig = plots.figure(5.6, 0.5 + 0.35 * (len(result.functions) + 1))
    axis = fig.subplots()
    shown = [f for f in result.functions if f.name != "init"]
    axis.barh([f.name for f in shown], [f.cycles.value for f in shown], color=plots.EXTENDED, height=0.6)
    axis.axvline(result.budget, color=plots.SIMULATED, linestyle="--", label=f"sample period, {result.budget}")
    axis.invert_yaxis()
    axis.set(xlabel="C674x cycles, stall-free", title=result.model)
    axis.legend(loc="lower right")
    return Drawing(fig)


@draw.register
def _(result: Waveform) -> Drawing:
    """Voltage with its limits, reference and displacement, and the error that the limits leave."""
    fig, above, below, side = plots.axes_beside()
    time_s = result.reference.start_s + result.Ts_s * np.arange(result.y_um.size, dtype=np.float64)
    above.plot(*envelope(result.time_s, result.u_V), color=plots.EXTENDED, linewidth=plots.THIN)
    for limit_V in (result.limits.low_V, result.limits.high_V):
        above.axhline(limit_V, color=plots.NOTE, linestyle="--")
    below.plot(*envelope(time_s, result.reference.values), color=plots.MEASURED, label="reference")
    below.plot(*envelope(time_s, result.y_um), color=plots.SIMULATED, linestyle="--", label="answer of the model")
    side.plot(*envelope(time_s, result.y_um - result.reference.values), color=plots.SIMULATED)
    above.set(ylabel="voltage [V]", title=f"{result.reference.source} with {result.model}")
    below.set(xlabel="time [s]", ylabel="displacement [µm]")
    below.legend(loc="upper left", ncols=2)
    side.set(xlabel="time [s]", ylabel="answer - reference [µm]")
    return Drawing(fig)


@draw.register
def _(result: LoopDesign) -> Drawing:
    """|L| of every draw and phase of the model itself against frequency, and the displacement after a push."""
    fig, above, below, side = plots.axes_beside()
    c = result.certificate
    above.fill_between(result.f_Hz, *(20.0 * np.log10(result.size)), color=plots.EXTENDED, alpha=0.4, linewidth=0.0)
    below.plot(result.f_Hz, result.phase_deg, color=plots.EXTENDED)
    for axis, level in ((above, 0.0), (below, -180.0)):
        axis.axhline(level, color=plots.NOTE, linestyle="--")
        axis.axvline(c.bandwidth_Hz, color=plots.SIMULATED)
        axis.set(xscale="log", xlim=(0.01 * c.bandwidth_Hz, result.f_Hz[-1]))
    time_ms = 1e3 * result.Ts_s * np.arange(result.steps.shape[1])
    side.plot(time_ms, result.steps.T, color=plots.EXTENDED, linewidth=plots.THIN, alpha=0.3)
    above.set(ylabel="|L| [dB], all draws", ylim=(-60.0, 40.0), title=f"{result.model}: {c.bandwidth_Hz:.4g} Hz")
    below.set(xlabel="frequency [Hz]", ylabel="phase [degrees]", ylim=(-720.0, 0.0))
    side.set(xlabel="time [ms]", ylabel="displacement after a push of 1")
    return Drawing(fig)
