"""Pictures of a diagnosis: what is wrong with the free run, and what each extension gains."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hysgen.diagnose.diagnosis import Diagnosis
from hysgen.diagnose.misfit import Misfit, Profile
from hysgen.plots import style


def misfit_figure(before: Misfit, after: Misfit | None = None, noise_um: float | None = None) -> Figure:
    """The free-run error against the horizon, over frequency, and by everything a cause could hang on."""
    fig = style.figure(9.0, 8.0)
    axes = fig.subplots(4, 2)
    shown = [(before, style.SIMULATED, "paper's model"), *([(after, style.EXTENDED, "extended")] if after else [])]
    for misfit, colour, label in shown:
        horizon, spectrum = misfit.horizon, misfit.spectrum
        axes[0, 0].loglog(horizon.steps, np.array(horizon.rms_um), color=colour, label=label, marker=".")
        axes[0, 1].loglog(spectrum.f_Hz, np.array(spectrum.rms_um), color=colour)
        for axis, profile in zip(axes.flat[2:], misfit.profiles, strict=True):
            _steps(axis, profile, colour)
    axes[0, 0].set(xlabel="horizon [samples]", ylabel="rms [um]", title="error against the horizon")
    axes[0, 1].set(xlabel="frequency [Hz]", ylabel="rms per band [um]", title="error over frequency")
    if noise_um:
        axes[0, 0].axhline(noise_um, color=style.NOTE, linestyle=":", label="noise floor")
    axes[0, 0].legend()
    return fig


def ladder_figure(diagnosis: Diagnosis) -> Figure:
    """Free-run error on held-out data after each extension, with the 95 % interval of each gain, above the noise."""
    fig = style.figure(7.2, 3.6)
    axis = fig.subplots()
    levels = [diagnosis.base_rms_um, *(cause.step.after_um for cause in diagnosis.causes)]
    labels = ["paper's model", *(f"+ {cause.name}" for cause in diagnosis.causes)]
    place = np.arange(len(levels))
    colours = [style.SIMULATED] + [style.EXTENDED] * (len(levels) - 1)
    axis.bar(place, levels, color=colours, width=0.6)
    for i, cause in enumerate(diagnosis.causes, start=1):
        low, high = cause.step.before_um - cause.step.high_um, cause.step.before_um - cause.step.low_um
        axis.plot([i, i], [max(low, 0.0), high], color=style.MEASURED, linewidth=1.5)
    axis.axhline(diagnosis.noise.rms_um, color=style.NOTE, linestyle=":", label="noise floor")
    axis.set_xticks(place, labels)
    axis.set(ylabel="free run, held out, rms [um]", title="What each extension gains")
    axis.legend()
    return fig


def error_figure(diagnosis: Diagnosis, Ts_s: float) -> Figure:
    """The free-run error of the paper's model and of the extended one over the record; the held-out part is marked."""
    fig = style.figure(7.2, 3.2)
    axis = fig.subplots()
    chosen = [diagnosis.errors_um[0], *(diagnosis.errors_um[-1:] if len(diagnosis.errors_um) > 1 else [])]
    for (label, error_um), colour in zip(chosen, (style.SIMULATED, style.EXTENDED), strict=False):
        axis.plot(Ts_s * np.arange(len(error_um)), error_um, color=colour, label=label, linewidth=0.8)
    first_s, last_s = Ts_s * float(diagnosis.held_rows[0]), Ts_s * float(diagnosis.held_rows[-1])
    axis.axvspan(first_s, last_s, color=style.NOTE, alpha=0.15)
    axis.set(xlabel="time [s]", ylabel="error [um]", title="Free run; shaded: held out")
    axis.legend()
    return fig


def _steps(axis: Axes, profile: Profile, colour: str) -> None:
    logarithmic = profile.edges[0] > 0 and profile.edges[-1] / profile.edges[0] > 50
    axis.stairs(profile.rms_um, profile.edges, color=colour)
    axis.stairs(profile.mean_um, profile.edges, color=colour, linestyle=":")
    axis.set_xlabel(f"{profile.quantity} [{profile.unit}]")
    axis.set_ylabel("rms, mean [um]")
    axis.set_xscale("log" if logarithmic else "linear")
