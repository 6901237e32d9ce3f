"""All experiments of the paper repeated, and those of the learner: run, as tables of text, as JSON, as figures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hysgen.display import table
from hysgen.model.simulate import free_run, one_step
from hysgen.record import Record
from hysgen.report import plots
from hysgen.report.plots.traces import thinned, validation
from hysgen_lab.studies.paper.experiments import CASES, EXPERIMENTS, RepeatedExperiment, Tracking, repeat, track_case
from hysgen_lab.studies.paper.learning import DISTURBANCES, GainLoss, LearnerAgreement, agreement, lose_gain

Floats = NDArray[np.float64]

COLOURS = {
    "one step": plots.BASELINE,
    "free run": plots.SIMULATED,
    "free run, with memory": plots.EXTENDED,
    "proportional": plots.NOTE,
    "paper's inverse": plots.SIMULATED,
    "refined inverse": plots.BASELINE,
    "with memory": plots.EXTENDED,
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
    fig = plots.figure(3.4 * len(simulated_um) + 0.6, 3.4)
    panels = np.atleast_1d(fig.subplots(1, len(simulated_um), sharex=True, sharey=True))
    keep = thinned(u_V.size)
    for panel, (name, y_um) in zip(panels, simulated_um.items(), strict=True):
        panel.plot(u_V[keep], measured_um[keep], color=plots.MEASURED, label="measured")
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
    fig, above, below, side = plots.axes_beside()
    keep = thinned(t_s.size)
    above.plot(t_s[keep], reference_um[keep], color=plots.MEASURED, label="reference")
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


LEARNED = EXPERIMENTS[:2]
"""Experiments whose identification records the compiled learner is fed."""


@dataclass(frozen=True)
class PaperResults:
    """modelling: sections 4.1, 4.2, Fig. 11; tracking: section 4.3; learning, changes: the learner in generated C."""

    modelling: tuple[RepeatedExperiment, ...]
    tracking: tuple[Tracking, ...]
    learning: tuple[LearnerAgreement, ...]
    changes: tuple[GainLoss, ...]

    def text(self) -> str:
        """A table for each of the four."""
        tables = (
            _modelling_table(self.modelling),
            _tracking_table(self.tracking),
            _agreement_table(self.learning),
            _gain_loss_table(self.changes),
        )
        return "\n\n".join(tables)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "modelling": [outcome.to_json() for outcome in self.modelling],
            "tracking": [tracked.to_json() for tracked in self.tracking],
            "learning": [comparison.to_json() for comparison in self.learning],
            "changes": [change.to_json() for change in self.changes],
        }


def repeat_all(progress: Callable[[float, str], None]) -> PaperResults:
    """Run every experiment. progress: called with the fraction done and the title of the next one."""
    done, total = 0, len(EXPERIMENTS) + len(CASES) + len(LEARNED) + len(DISTURBANCES)

    def begin(title: str) -> None:
        nonlocal done
        progress(done / total, title)
        done += 1

    modelling, tracking, learning, changes = [], [], [], []
    for experiment in EXPERIMENTS:
        begin(experiment.title)
        modelling.append(repeat(experiment))
    for case in CASES:
        begin(f"section 4.3: tracking at {case.f_Hz:g} Hz")
        tracking.append(track_case(case))
    for experiment in LEARNED:
        begin(f"learner: {experiment.title}")
        learning.append(agreement(experiment))
    for disturbance in DISTURBANCES:
        begin(f"learner: {disturbance}")
        changes.append(lose_gain(disturbance))
    return PaperResults(tuple(modelling), tuple(tracking), tuple(learning), tuple(changes))


def _modelling_table(outcomes: Sequence[RepeatedExperiment]) -> str:
    """Sections 4.1 and 4.2 and Fig. 11: e_rms in um and maximum e_r in percent of each predictor."""
    rows: list[list[str]] = []
    for outcome in outcomes:
        published, rival = outcome.experiment.published, outcome.experiment.published_rival
        paper, persistence = outcome.scores["paper"], outcome.scores["paper"].persistence
        rows += [
            [outcome.experiment.title, "", ""],
            ["  paper, one step", _um(published.e_rms_um), f"{published.e_r_percent:.2f}"],
            ["  ours, one step", _um(paper.one_step.e_rms_um), _percent(paper.one_step.e_r_percent)],
            ["  persistence, one step", _um(persistence.e_rms_um), _percent(persistence.e_r_percent)],
        ]
        labels = {"paper": "ours", "refined": "ours, refined", "memory": "ours, refined, with memory"}
        rows += [
            [f"  {label}, free run", _um(scores.free_run.e_rms_um), _percent(scores.free_run.e_r_percent)]
            for (variant, label), scores in zip(labels.items(), outcome.scores.values(), strict=True)
        ]
        memory = outcome.started["memory"]
        rows.append(["    the same, after the first 20 ms", _um(memory.e_rms_um), _percent(memory.e_r_percent)])
        rows += [[f"  {name}, free run", _um(s.e_rms_um), _percent(s.e_r_percent)] for name, s in outcome.rivals]
        if rival is not None:
            rows.append(["  paper's Prandtl-Ishlinskii", _um(rival.e_rms_um), f"{rival.e_r_percent:.2f}"])
        rows.append(["  noise floor of the record", _um(paper.noise.rms_um), ""])
    return table(["modelling", "e_rms [um]", "max e_r [%]"], rows)


def _tracking_table(tracked: Sequence[Tracking]) -> str:
    """Section 4.3: e_rms in nm and maximum e_r in percent of each controller."""
    rows: list[list[str]] = []
    for case in tracked:
        published = case.published
        rows += [
            [f"Section 4.3: y_d = 2.0 + 0.6 sin(2 pi {case.f_Hz:g} t) um", "", ""],
            ["  paper, inverse", f"{published.e_rms_nm:.1f}", f"{published.e_r_percent:.2f}"],
            ["  paper, proportional", "", f"about {published.proportional_percent:.0f}"],
        ]
        rows += [
            [f"  ours, {name}", f"{rms:.1f}", f"{case.e_r_percent[name]:.2f}"] for name, rms in case.e_rms_nm.items()
        ]
    return table(["tracking", "e_rms [nm]", "max e_r [%]"], rows)


def _agreement_table(agreements: Sequence[LearnerAgreement]) -> str:
    """One-step e_rms in nm of Eq. (10) in float64 and of the learner in generated C, on a record held out from both."""
    rows = [
        [a.title, f"{1e3 * a.float64_um:.4f}", f"{1e3 * a.learned_um:.4f}", f"{100.0 * a.excess:+.3f} %"]
        for a in agreements
    ]
    return table(["learning, one step", "Eq. (10) float64 [nm]", "generated C [nm]", "difference"], rows)


def _gain_loss_table(changes: Sequence[GainLoss]) -> str:
    """Free-run e_rms in nm of the active model around the change, how soon it is back, and what was committed."""
    rows = []
    for c in changes:
        back = "never" if c.caught_up_s is None else f"{c.caught_up_s:.2f}"
        free_run_nm = [f"{1e3 * value:.1f}" for value in (c.before_um, c.stale_um, c.free_run_um[-1])]
        rows.append([c.what, *free_run_nm, back, str(c.committed), str(c.refused), str(c.unsafe)])
    heads = [
        "the plant changes",
        "before [nm]",
        "at once",
        "2 s later",
        "back after [s]",
        "committed",
        "refused",
        "unsafe",
    ]
    return table(heads, rows)


def _um(value: float | None) -> str:
    return "" if value is None else f"{value:.4f}"


def _percent(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"
