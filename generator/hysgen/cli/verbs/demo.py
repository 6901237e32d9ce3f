"""The whole way on the bundled record: record, fit, score, C, equivalence, cost, pictures, all in one folder.

What it does is what the other verbs do; each step says which one.
"""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

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
from hysgen.model.rivals import fit_baselines, score_baselines
from hysgen.model.scores import score, score_lines
from hysgen.model.simulate import free_run, one_step
from hysgen.record import load_record
from hysgen.report.model import ScoredModels, model_page
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
        identified = {"identification": score(model, known).to_json()}
        save_model(dataclasses.replace(model, scores=identified), folder / f"{model.name}.json")
    console.say(f"hysgen fit   {folder / 'paper.json'}, {folder / 'stage.json'}")
    rivals = score_baselines(fit_baselines(known), unseen)
    scored = ScoredModels(unseen, {PAPER: paper, EXTENDED: extended}, scores, rivals)
    lines = "\n".join([*score_lines(scored.rows()), f"noise floor {scored.noise.describe()}"])
    console.say(f"\nhysgen score, on rows that the fit has not seen\n{lines}\n")
    console.say("\n".join(certify(extended).lines()))

    written = draw(folder, scored)
    code = folder / "c"
    write(generate(extended), code)
    console.say(f"\nhysgen generate  {code}: {', '.join(sorted(path.name for path in code.iterdir()))}")

    report = verify(code, samples=arguments.samples, structures=1, progress=console.progress)
    console.say("\nhysgen verify\n" + "\n".join(report.lines()))
    price = cost(code)
    console.say("\nhysgen cost\n" + cost_text(price))
    page = folder / "report.html"
    write_whole(page, model_page("hysgen on its bundled record", scored, report, price).html())
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


def draw(folder: Path, scored: ScoredModels) -> list[Path]:
    """Write the pictures: free run and error in time, loops, error against the horizon. Returns their paths."""
    unseen = scored.record
    runs = {name: free_run(model, unseen)[0].y_um for name, model in scored.models.items()}
    stepped = {"one step": one_step(scored.models[PAPER], unseen)[0].y_um}
    curves = {name: scores.horizon for name, scores in scored.scores.items()}
    levels = {"noise floor": scored.noise.rms_um}
    title = "Bundled record, rows that no fit has seen"
    return [
        style.save(validation(unseen, stepped | runs, title, COLOURS), folder / "free-run.png"),
        style.save(loops(unseen, runs, title, COLOURS), folder / "loops.png"),
        style.save(horizon(curves, levels, unseen.Ts_s, "Error against the horizon", COLOURS), folder / "horizon.png"),
    ]
