"""The paper's figures, drawn from our repetition of its experiments."""

from __future__ import annotations

from matplotlib.figure import Figure

from hysgen.model.simulate import free_run, one_step
from hysgen.report.plots import style
from hysgen.report.plots.traces import loops, tracking, validation
from hysgen_lab.studies.paper.modelling import RepeatedExperiment
from hysgen_lab.studies.paper.tracking import Tracking

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


def tracking_figure(case: Tracking) -> Figure:
    """Fig. 13: reference and reached displacement, tracking error, compensated loop."""
    return tracking(case.t_s, case.reference_um, case.reached_um, f"Section 4.3: {case.f_Hz:g} Hz", COLOURS)
