"""The paper's figures, drawn from our repetition of its experiments."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hysgen.model.simulate import free_run, one_step
from hysgen.record import Record
from hysgen.report.plots import style
from hysgen.report.plots.traces import thinned, validation
from hysgen_lab.studies.paper.modelling import RepeatedExperiment
from hysgen_lab.studies.paper.tracking import Tracking

Floats = NDArray[np.float64]

COLOURS = {
    "one step": style.BASELINE,
    "free run": style.SIMULATED,
    "free run, with memory": style.EXTENDED,
    "proportional": style.NOTE,
    "paper's inverse": style.SIMULATED,
    "refined inverse": style.BASELINE,
    "with memory": style.EXTENDED,
}


def modelling_figures(outcome: RepeatedExperiment) -> dict[str, Figure]:
    """Figures by file name: displacement and error against time (Figs 6, 7, 9, 10, 11), and loops."""
    record, experiment = outcome.validation, outcome.experiment
    runs = {
        "one step": one_step(outcome.models["paper"], record)[0].y_um,
        "free run": free_run(outcome.models["paper"], record)[0].y_um,
        "free run, with memory": free_run(outcome.models["memory"], record)[0].y_um,
    }
    stem = experiment.name if experiment.name.startswith("fig") else f"section-{experiment.name}"
    return {
        f"{stem}-validation.png": validation(record, runs, experiment.title, COLOURS),
        f"{stem}-loops.png": loops(record, runs, experiment.title, COLOURS),
    }


def loops(record: Record, simulated_um: Mapping[str, Floats], title: str, colours: Mapping[str, str]) -> Figure:
    """Displacement against voltage over the first segment: one panel per simulation, each with the measured loops."""
    u_V, measured_um = record.segments[0].u_V, record.segments[0].y_um
    fig = style.figure(3.4 * len(simulated_um) + 0.6, 3.4)
    panels = np.atleast_1d(fig.subplots(1, len(simulated_um), sharex=True, sharey=True))
    keep = thinned(u_V.size)
    for panel, (name, y_um) in zip(panels, simulated_um.items(), strict=True):
        panel.plot(u_V[keep], measured_um[keep], color=style.MEASURED, label="measured")
        panel.plot(u_V[keep], y_um[keep], color=colours[name], label=name)
        panel.set(xlabel="voltage [V]", title=name if len(simulated_um) > 1 else "")
        panel.legend(loc="upper left")
    panels[0].set_ylabel("displacement [µm]")
    fig.suptitle(title)
    return fig


def tracking(
    t_s: Floats, reference_um: Floats, reached_um: Mapping[str, Floats], title: str, colours: Mapping[str, str]
) -> Figure:
    """Reference and reached displacement, tracking error in nm, reached against reference (ideally a straight line).

    Error: reached - reference.
    """
    fig, above, below, side = style.axes_beside()
    keep = thinned(t_s.size)
    above.plot(t_s[keep], reference_um[keep], color=style.MEASURED, label="reference")
    for name, y_um in reached_um.items():
        above.plot(t_s[keep], y_um[keep], color=colours[name], label=name, linestyle="--")
        below.plot(t_s[keep], 1e3 * (y_um - reference_um)[keep], color=colours[name])
        side.plot(reference_um[keep], y_um[keep], color=colours[name], label=name)
    above.set(ylabel="displacement [µm]", title=title)
    below.set(xlabel="time [s]", ylabel="reached - reference [nm]")
    side.set(xlabel="reference [µm]", ylabel="reached [µm]", title="compensated loop")
    side.legend(loc="upper left")
    return fig


def tracking_figure(case: Tracking) -> Figure:
    """Fig. 13: reference and reached displacement, tracking error, compensated loop."""
    return tracking(case.t_s, case.reference_um, case.reached_um, f"Section 4.3: {case.f_Hz:g} Hz", COLOURS)
