"""Pictures of a diagnosis: error by time, horizon, frequency and input, gain of each extension, shares by cause.

The paper's model is dashed and vermilion, the extended model solid and blue. Error: simulated - measured.
"""

import numpy as np
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from hysgen.diagnosis.error_map import ErrorMap, range_in_words
from hysgen.diagnosis.evaluation import Study
from hysgen.report.plots import style
from hysgen.report.plots.style import BASE_MODEL, EXTENDED_MODEL, LINES, Picture
from hysgen.report.plots.traces import (
    Simulated,
    free_run_pictures,
    horizon,
    loop_pictures,
    record_picture,
    response_pictures,
    time_label,
    time_picture,
)

Floats = NDArray[np.float64]

WINDOWS = 60
"""Windows over the record, each with the mean square of the error."""

COLOURS = (style.EXTENDED, "#e69f00", style.BASELINE, "#cc79a7", "#56b4e9", "#f0e442", style.SIMULATED)
"""Of the extensions, in ladder order: Okabe and Ito (2008), as in `style`."""


def error_shares(errors_um: list[Floats], noise_um: float, edges: NDArray[np.intp]) -> Floats:
    """(m + 2, w) share of the noise, of what no extension explains, and of each of m extensions, in each window.

        share of extension i = (p_(i-1) - p_i) / p_0,    p_i: mean square of the error of rung i, at most p_(i-1)

    errors_um: (n,) of rungs 0 to m. edges: (w + 1,) rows at which the windows begin. The shares of a window sum to 1.
    """
    powers = np.stack([np.add.reduceat(error * error, edges[:-1]) / np.diff(edges) for error in errors_um])
    falling = np.minimum.accumulate(powers, axis=0)
    noise = np.minimum(noise_um**2, falling[-1])
    parts = np.vstack([noise, falling[-1] - noise, falling[:-1] - falling[1:]])
    return np.asarray(parts / np.maximum(falling[0], 1e-300))


def shares_picture(study: Study) -> Picture:
    """The shares of the paper's model's error over the time of the record: noise, unexplained, each extension."""
    diagnosis, record = study.diagnosis, study.record
    edges = np.linspace(0, record.samples, min(WINDOWS, record.samples) + 1).astype(np.intp)
    shares = error_shares([error for _, error in diagnosis.errors_um], diagnosis.noise.rms_um, edges)
    # The name of a rung lists its causes; the last one is its own.
    names = ["noise", "not explained", *(name.rpartition(" + ")[2] for name, _ in diagnosis.errors_um[1:])]
    colours = ["#cccccc", "#666666", *COLOURS, *COLOURS]
    fig = style.figure(*style.WIDE_IN)
    axis = fig.subplots()
    axis.set(xlabel=time_label(study), ylabel="share of the error's power [%]")
    time_s = record.Ts_s * edges
    # Each window is a step, so that no slope is drawn that was not measured.
    steps = np.repeat(100.0 * shares, 2, axis=1)
    axis.stackplot(np.repeat(time_s, 2)[1:-1], steps, labels=names, colors=colours)
    axis.axvline(record.Ts_s * study.cut, color=style.MEASURED, linestyle=":")
    style.note(axis, "held out", (record.Ts_s * study.cut, 1.0), ("data", "axes fraction"), "left")
    axis.set_xlim(0.0, float(time_s[-1]))
    axis.set_ylim(0.0, 100.0)
    fig.legend(loc="outside right center", reverse=True)
    held = shares[:, edges[:-1] >= study.cut]
    means = held.mean(axis=1) if held.size else shares.mean(axis=1)
    words = ", ".join(f"{name} {100.0 * mean:.0f} %" for name, mean in zip(names, means, strict=True))
    alt = f"Share of the paper's model's error by cause, mean over the windows of the held-out part: {words}."
    return Picture("shares", "Which cause makes the error, and when", alt, fig, wide=True)


BAR = 4.0
"""Width of the bar that shows the interval of a gain, in points."""


def pictures(study: Study) -> list[Picture]:
    """All pictures of a diagnosis in reading order: record, free run, error, its profiles, shares, ladder."""
    shown = [(BASE_MODEL, study.before), *([(EXTENDED_MODEL, study.after)] if study.improved else [])]
    runs = held_out_runs(study)
    return [
        record_picture(study),
        *free_run_pictures(runs),
        *loop_pictures(runs),
        *response_pictures(runs),
        time_picture(runs),
        horizon_picture(shown, study),
        spectrum_picture(shown),
        *(profile_picture(shown, number) for number in range(len(study.before.profiles))),
        *([shares_picture(study)] if study.improved else []),
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
    fig, axis = style.axes("frequency [Hz]", "error, rms per band [µm]")
    for label, error in shown:
        axis.loglog(error.spectrum.f_Hz, error.spectrum.rms_um, label=label, **LINES[label])
    style.decimal_ticks(axis)
    style.legend_above(axis)
    peaks = []
    for label, error in shown:
        top = int(np.argmax(error.spectrum.rms_um))
        peaks.append(f"{label} {error.spectrum.rms_um[top]:.2g} µm at {error.spectrum.f_Hz[top]:.3g} Hz")
    return Picture("spectrum", "Error over frequency", f"Largest bands: {'; '.join(peaks)}.", fig)


def profile_picture(shown: list[tuple[str, ErrorMap]], number: int) -> Picture:
    """The rms error sorted by one quantity, on a logarithmic axis: both models are seen."""
    first = shown[0][1].profiles[number]
    fig, axis = style.axes(f"{first.quantity} [{first.unit}]", "error rms [µm]")
    levels = np.concatenate([np.array(error.profiles[number].rms_um) for _, error in shown])
    lowest = 0.5 * float(np.nanmin(levels[levels > 0.0])) if (levels > 0.0).any() else 1e-9
    for label, error in shown:
        profile = error.profiles[number]
        heights = np.array(profile.rms_um)
        # No line where the record has no such samples, and none down to the frame: both would look like an error of 0.
        steps = np.where(heights > 0.0, heights, np.nan)
        axis.stairs(steps, profile.edges, baseline=None, label=label, **LINES[label])
    axis.set_yscale("log")
    axis.set_ylim(lowest, 2.0 * max(float(np.nanmax(levels)), lowest))
    style.decimal_ticks(axis, x=False)
    if first.edges == (-1.5, -0.5, 0.5, 1.5):
        axis.set_xticks([-1, 0, 1], first.unit.split(", "))
        axis.set_xlabel(f"{first.quantity} of the input")
    elif first.edges[0] > 0 and first.edges[-1] / first.edges[0] > 50:
        axis.set_xscale("log")
        axis.xaxis.set_major_formatter(FuncFormatter(style.plain_number))
    style.legend_above(axis)
    ends = "; ".join(f"{label} {range_in_words(error.profiles[number])}" for label, error in shown)
    alt = f"Error rms by {first.quantity}: {ends}."
    return Picture(
        f"error-by-{first.quantity.split(' of ')[0].replace(' ', '-')}", f"Error by {first.quantity}", alt, fig
    )


def ladder_picture(study: Study) -> Picture:
    """Held-out free-run error after each extension, a row each, with the 95 % interval of its gain and its cycles.

    Bar: the error after the step plus the interval of its gain; left of the point, the step loses.
    """
    diagnosis, causes = study.diagnosis, study.extended
    levels = [diagnosis.base_rms_um, *(cause.step.after_um for cause in causes)]
    labels = [BASE_MODEL, *(f"+ {cause.name}" for cause in causes)]
    fig = style.figure(style.WIDE_IN[0], 1.1 + 0.36 * len(levels))
    axis = fig.subplots()
    lowest = 0.6 * min([*levels, diagnosis.noise.rms_um])
    for i, cause in enumerate(causes, start=1):
        # The error after the step plus the interval of its gain: positive where the gain is certain, unlike the error
        # before minus that interval, and inside the frame.
        step = cause.step
        ends = [max(step.after_um + gain, lowest) for gain in (step.low_um, step.high_um)]
        axis.plot([step.before_um, step.after_um], [i, i], color=style.NOTE)
        axis.plot(ends, [i, i], color=style.EXTENDED, linewidth=BAR, alpha=0.45, solid_capstyle="butt")
    colours = [style.SIMULATED] + [style.EXTENDED] * (len(levels) - 1)
    for i, (level, colour) in enumerate(zip(levels, colours, strict=True)):
        axis.plot(level, i, marker="o", color=colour)
    axis.set_xscale("log")
    highest = max([*levels, *(cause.step.after_um + cause.step.high_um for cause in causes)])
    axis.set(xlabel="free run, held out, rms [µm]", xlim=(lowest, 1.5 * highest))
    axis.set_yticks(range(len(levels)), labels)
    axis.set_ylim(len(levels) - 0.5, -0.5)
    axis.grid(visible=False, axis="y")
    style.decimal_ticks_of(axis.xaxis)
    axis.axvline(diagnosis.noise.rms_um, color=style.BEHIND, linestyle=":")
    style.note(axis, "noise floor", (diagnosis.noise.rms_um, 1.0), ("data", "axes fraction"), "center")
    # Columns of numbers to the right of the frame, where no point can be.
    columns: list[tuple[float, str, list[str]]] = [
        (1.09, "rms [µm]", [f"{level:.3g}" for level in levels]),
        (1.19, "cycles", ["", *(f"{cause.price.cycles:+d}" if cause.price else "?" for cause in causes)]),
    ]
    for place, head, cells in columns:
        style.note(axis, head, (place, 1.0), ("axes fraction", "axes fraction"), "right")
        for i, cell in enumerate(cells):
            axis.text(place, i, cell, transform=axis.get_yaxis_transform(), ha="right", va="center")
    steps = ", ".join(f"{label} {level:.3g} µm" for label, level in zip(labels, levels, strict=True))
    alt = f"Free-run error on held-out data: {steps}; noise floor {diagnosis.noise.rms_um:.2g} µm."
    return Picture("ladder", "Error after each extension", alt, fig, wide=True)
