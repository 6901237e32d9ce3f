"""All experiments of the paper repeated, and those of the learner: run, as tables of text, as JSON."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from hysgen.display import table
from hysgen_lab.studies.paper.learning import DISTURBANCES, GainLoss, LearnerAgreement, agreement, lose_gain
from hysgen_lab.studies.paper.modelling import EXPERIMENTS, RepeatedExperiment, repeat
from hysgen_lab.studies.paper.tracking import CASES, Tracking, track_case

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
