"""The whole way on the bundled record: record, fit, score, C, equivalence, cost, pictures, all in one folder.

What it does is what the other verbs do; each step says which one.
"""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from hysgen.c674x.cost import cost
from hysgen.certify.certificates import certify
from hysgen.checking.bits import verify
from hysgen.cli.console import Console
from hysgen.cli.verbs.cost import cost_text
from hysgen.cli.verbs.fit import memory_terms
from hysgen.codegen import generate, write
from hysgen.fitting import FitSettings, fit
from hysgen.machine.files import write_whole
from hysgen.model.file import save_model
from hysgen.model.model import Model
from hysgen.model.rivals import fit_baselines, score_baselines
from hysgen.model.scores import Score, Scores, score, score_lines
from hysgen.model.simulate import free_run, one_step
from hysgen.record import Record, load_record
from hysgen.report.model import model_page
from hysgen.report.plots import style
from hysgen.report.plots.traces import horizon, loops, validation
from hysgen.stage.demo_record import bundled_csv, identification_rows

PLAYS = 12
PAPER, EXTENDED = "paper's model", "with memory"
COLOURS = {PAPER: style.SIMULATED, EXTENDED: style.EXTENDED, "one step": style.BASELINE}


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", default="hysgen-demo", metavar="DIR", help="folder (default %(default)s)")
    parser.add_argument("--samples", type=int, default=200_000, help="samples that verify compares in each build")


def run(arguments: argparse.Namespace, console: Console) -> int:
    folder = Path(arguments.output)
    csv = folder / "record.csv"
    write_whole(csv, bundled_csv())
    known, unseen = load_record(csv).split_at(identification_rows())
    console.say(f"record       {csv}: {known.samples} samples to identify, {unseen.samples} to validate, 50 kHz")

    paper = fit(known, FitSettings(name="paper", method="rls"))
    extended = fit(known, FitSettings(name="stage", terms=memory_terms(known, PLAYS)), progress=console.progress)
    scores = {PAPER: score(paper, unseen), EXTENDED: score(extended, unseen)}
    for model in (paper, extended):
        told = dataclasses.replace(model, scores={"identification": score(model, known).to_json()})
        save_model(told, folder / f"{model.name}.json")
    console.say(f"hysgen fit   {folder / 'paper.json'}, {folder / 'stage.json'}")
    rivals = score_baselines(fit_baselines(known), unseen)
    console.say(f"\nhysgen score, on rows that the fit has not seen\n{score_table(scores, rivals)}\n")
    console.say("\n".join(certify(extended).lines()))

    written = draw(folder, unseen, {PAPER: paper, EXTENDED: extended}, scores)
    code = folder / "c"
    write(generate(extended), code)
    console.say(f"\nhysgen generate  {code}: {', '.join(sorted(path.name for path in code.iterdir()))}")

    report = verify(code, samples=arguments.samples, structures=1, progress=console.progress)
    console.say("\nhysgen verify\n" + "\n".join(report.lines()))
    price = cost(code)
    console.say("\nhysgen cost\n" + cost_text(price))
    page = folder / "report.html"
    models = {PAPER: paper, EXTENDED: extended}
    write_whole(page, model_page("hysgen on its bundled record", models, unseen, scores, rivals, report, price).html())
    console.say(f"\nreport       {page}")
    console.say("\npictures\n" + "\n".join(f"  {path}" for path in written))
    console.write_json(
        {
            "scores": {name: part.to_json() for name, part in scores.items()},
            "verify": report.to_json(),
            "cost": price.to_json(),
            "pictures": [str(path) for path in written],
            "report": str(page),
        }
    )
    return 0 if report.equal else 1


def score_table(scores: dict[str, Scores], rivals: list[tuple[str, Score]]) -> str:
    """Free run first, then one step with persistence beside it, then the paper's rivals."""
    rows = [(f"{name}, free run", part.free_run) for name, part in scores.items()]
    rows += [(f"{name}, one step", part.one_step) for name, part in scores.items()]
    paper = scores[PAPER]
    rows.append(("persistence, one step", paper.persistence))
    rows += [(f"{name}, free run", rival) for name, rival in rivals]
    return "\n".join([*score_lines(rows), f"noise floor {paper.noise.describe()}"])


def draw(folder: Path, unseen: Record, models: dict[str, Model], scores: dict[str, Scores]) -> list[Path]:
    """Measured against simulated in time and as loops, and the error against the horizon."""
    segment = unseen.segments[0]
    t_s = segment.start_s + unseen.Ts_s * np.arange(segment.samples, dtype=np.float64)
    runs = {name: free_run(model, unseen)[0].y_um for name, model in models.items()}
    stepped = {"one step": one_step(models[PAPER], unseen)[0].y_um}
    curves = {
        name: (np.array(part.horizon.steps, dtype=np.float64), np.array(part.horizon.rms_um))
        for name, part in scores.items()
    }
    levels = {"noise floor": scores[PAPER].noise.rms_um}
    title = "Bundled record, rows that no fit has seen"
    return [
        style.save(validation(t_s, segment.y_um, stepped | runs, title, COLOURS), folder / "free-run.png"),
        style.save(loops(segment.u_V, segment.y_um, runs, title, COLOURS), folder / "loops.png"),
        style.save(horizon(curves, levels, unseen.Ts_s, "Error against the horizon", COLOURS), folder / "horizon.png"),
    ]
