"""Repeat the paper's experiments (sections 4.1 to 4.3, Fig. 11) on the virtual stage: a table and the figures.

Beyond the paper, the learner in generated C: held against Eq. (10) in float64, and after the plant has lost gain.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.display import table
from hysgen.report.plots import style
from hysgen.report.plots.experiments import modelling_figures, tracking_figure
from hysgen.studies.paper.learning import CHANGES, Agreement, Change, agreement, change
from hysgen.studies.paper.modelling import EXPERIMENTS, Outcome, repeat
from hysgen.studies.paper.tracking import CASES, Tracking, track_case

LEARNED = EXPERIMENTS[:2]


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for the figures (PNG)")


def run(arguments: argparse.Namespace, console: Console) -> int:
    steps = len(EXPERIMENTS) + len(CASES) + len(LEARNED) + len(CHANGES)
    outcomes: list[Outcome] = []
    for experiment in EXPERIMENTS:
        console.progress(len(outcomes) / steps, experiment.title)
        outcomes.append(repeat(experiment))
    tracked: list[Tracking] = []
    for case in CASES:
        console.progress((len(outcomes) + len(tracked)) / steps, f"section 4.3: tracking at {case.f_Hz:g} Hz")
        tracked.append(track_case(case))
    done = len(outcomes) + len(tracked)
    agreements: list[Agreement] = []
    for experiment in LEARNED:
        console.progress((done + len(agreements)) / steps, f"learner: {experiment.title}")
        agreements.append(agreement(experiment))
    changes: list[Change] = []
    for what in CHANGES:
        console.progress((done + len(agreements) + len(changes)) / steps, f"learner: {what}")
        changes.append(change(what))
    tables = modelling_table(outcomes), tracking_table(tracked), agreement_table(agreements), change_table(changes)
    console.say("\n\n".join(tables))
    if arguments.output:
        folder = Path(arguments.output)
        for outcome in outcomes:
            for name, figure in modelling_figures(outcome).items():
                console.say(f"written: {style.save(figure, folder / name)}")
        for case_tracked in tracked:
            path = folder / f"section-4.3-{case_tracked.f_Hz:g}-hz.png"
            console.say(f"written: {style.save(tracking_figure(case_tracked), path)}")
    console.write_json(
        {
            "modelling": [outcome.to_json() for outcome in outcomes],
            "tracking": [t.to_json() for t in tracked],
            "learning": [a.to_json() for a in agreements],
            "changes": [c.to_json() for c in changes],
        }
    )
    return 0


def modelling_table(outcomes: list[Outcome]) -> str:
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


def tracking_table(tracked: list[Tracking]) -> str:
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


def agreement_table(agreements: list[Agreement]) -> str:
    """One-step e_rms in nm of Eq. (10) in float64 and of the learner in generated C, on a record neither has seen."""
    rows = [
        [a.title, f"{1e3 * a.float64_um:.4f}", f"{1e3 * a.learned_um:.4f}", f"{100.0 * a.excess:+.3f} %"]
        for a in agreements
    ]
    return table(["learning, one step", "Eq. (10) float64 [nm]", "generated C [nm]", "difference"], rows)


def change_table(changes: list[Change]) -> str:
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
