"""score: errors of a model on a record; describe: a model as a dynamic system."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.api.models import PAPERS_MODEL, certificates, describe, rivals, score
from hysgen.cli.console import Console, command_line
from hysgen.cli.options import add_model, add_record_options, parse_rows, read_records
from hysgen.cli.verbs import Verb
from hysgen.machine.files import write_whole
from hysgen.model.file import load_model
from hysgen.model.scores import OWN, Score, score_lines
from hysgen.model.simulate import free_run, one_step

SCORE_HELP = """\
Score a model on a record: one step, against the horizon, and in free run, beside persistence and the noise floor."""
DESCRIBE_HELP = """\
Show what a model is as a dynamic system: time constant, DC gain, loop against frequency, certificates."""

SCORE_EXAMPLES = (
    "hysgen score stage.json later.csv --plot free-run.png",
    "hysgen score stage.json record.csv --rows 5000: --rivals 0:5000    rows after those of the fit, and rivals",
)


def score_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)
    parser.add_argument("records", nargs="+", metavar="RECORD")
    parser.add_argument("--rows", metavar="A:B", help="score on rows A to B of the joined records, B excluded")
    parser.add_argument(
        "--settle",
        type=int,
        metavar="N",
        help="samples at the start that are not scored (default: those that depend on the unknown input before the "
        "record; rows before --rows are simulated and known)",
    )
    parser.add_argument(
        "--rivals",
        metavar="A:B",
        help="also score the paper's model and its rivals, fitted to rows A to B of the same records",
    )
    parser.add_argument(
        "--beside", action="append", default=[], metavar="MODEL", help="another model in the same tables and pictures"
    )
    parser.add_argument("--report", metavar="FILE.html", help="write one page with the scores, the model and pictures")
    parser.add_argument("--plot", metavar="FILE.png", help="draw measured and simulated displacement")
    add_record_options(parser)


def run_score(arguments: argparse.Namespace, console: Console) -> int:
    model = load_model(arguments.model)
    whole = read_records(arguments.records, arguments, console)
    record = whole.rows(*parse_rows(arguments.rows, whole.samples, whole.Ts_s)) if arguments.rows else whole
    scores = score(model, record, arguments.settle)
    result = scores.to_json()
    others_fitted: dict[str, Score] = {}
    if arguments.rivals:
        known = whole.rows(*parse_rows(arguments.rivals, whole.samples, whole.Ts_s))
        unscored = arguments.settle if scores.unknown_past is None else scores.unknown_past.rows
        others_fitted = rivals(known, record, 0 if unscored is None else unscored)
        simple = others_fitted[PAPERS_MODEL]
        if scores.free_run.e_rms_um > simple.e_rms_um:
            console.warn(
                f"{record.source}: in free run the model is worse than the paper's model, fitted to rows "
                f"{arguments.rivals}: {scores.free_run.e_rms_um:.4g} um against {simple.e_rms_um:.4g} um"
            )
    console.say(scores.table())
    others = {Path(name).stem: load_model(name) for name in arguments.beside}
    beside = {name: score(other, record, arguments.settle) for name, other in others.items()}
    if beside:
        shown = {**beside, Path(arguments.model).stem: scores}
        rows = [(f"{name}, free run", errors.free_run) for name, errors in shown.items()]
        rows += [(f"{name}, {OWN}", errors.own) for name, errors in shown.items()]
        rows += [(f"{name}, one step", errors.one_step) for name, errors in shown.items()]
        console.say("\nbeside each other")
        console.say("\n".join(score_lines(rows)))
        result["beside"] = {name: errors.to_json() for name, errors in beside.items()}
    if others_fitted:
        console.say("\nrivals in free run")
        console.say("\n".join(score_lines(list(others_fitted.items()))))
        result["rivals_free_run"] = {name: rival.to_json() for name, rival in others_fitted.items()}
    if arguments.report:
        from hysgen.report.model import ScoredModels, model_page

        name = Path(arguments.model).stem if beside else model.name
        scored = ScoredModels(record, {**others, name: model}, {**beside, name: scores}, list(others_fitted.items()))
        title = f"{', '.join(scored.models)} on {record.source}"
        write_whole(Path(arguments.report), model_page(title, scored, command=command_line()).html())
        console.say(f"\nwritten: {arguments.report}")
    if arguments.plot:
        # matplotlib takes half a second to import.
        from hysgen.report.plots import style
        from hysgen.report.plots.traces import validation

        runs = {"free run": free_run(model, record)[0].y_um, "one step": one_step(model, record)[0].y_um}
        colours = {"free run": style.SIMULATED, "one step": style.BASELINE}
        style.save(validation(record, runs, f"{model.name} on {record.source}", colours), Path(arguments.plot))
        console.say(f"\nwritten: {arguments.plot}")
    return console.finish(result)


def describe_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)


def run_describe(arguments: argparse.Namespace, console: Console) -> int:
    model = load_model(arguments.model)
    system, certified = describe(model), certificates(model)
    console.say(system.describe())
    for block in model.blocks:
        console.say(f"path: {block.kind}: {block.describe()}")
    for term in model.terms:
        console.say(f"disturbance: {term.kind}: {term.describe()}")
    console.say()
    console.say("\n".join(certified.lines()))
    return console.finish({"dynamics": system.to_json(), "certificates": certified.to_json()})


VERBS = {
    "score": Verb(SCORE_HELP, score_arguments, run_score, examples=SCORE_EXAMPLES),
    "describe": Verb(DESCRIBE_HELP, describe_arguments, run_describe, examples=("hysgen describe stage.json",)),
}
