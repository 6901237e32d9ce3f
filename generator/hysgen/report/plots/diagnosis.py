"""Pictures of a diagnosis: error by time, horizon, frequency and input, gain of each extension.

The paper's model is dashed and vermilion, the extended model solid and blue. Error: simulated - measured.
"""

import numpy as np
from matplotlib.ticker import MaxNLocator

from hysgen.diagnosis.error_map import ErrorMap, range_in_words
from hysgen.diagnosis.evaluation import Study
from hysgen.report.plots import style
from hysgen.report.plots.style import BASE_MODEL, EXTENDED_MODEL, LINES, Picture
from hysgen.report.plots.traces import (
    Simulated,
    free_run_pictures,
    horizon,
    record_picture,
    response_pictures,
    time_picture,
)

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
    fig = style.figure(style.WIDE_IN[0], 2.3)
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
            style.decimal_ticks_of(axis.xaxis, 3)
        else:
            axis.xaxis.set_major_locator(MaxNLocator(3))
    panels[0].set(ylabel="error rms [µm]", ylim=(lowest, 2.0 * max(float(np.nanmax(levels)), lowest)))
    style.decimal_ticks_of(panels[0].yaxis)
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
