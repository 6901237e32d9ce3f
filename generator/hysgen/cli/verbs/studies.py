"""Studies on the virtual stage: the demo, the paper's experiments, the bank of hidden effects, endurance."""

from __future__ import annotations

import argparse
import dataclasses
import os
from pathlib import Path

from hysgen.c674x.cost import cost
from hysgen.certify.certificates import certify
from hysgen.checking.bits import VerifySettings, verify
from hysgen.checking.endurance import ALLOWED_RATIO, CASES, HEADINGS, endurance_tests, rows
from hysgen.checking.endurance import run as endure
from hysgen.cli.console import Console
from hysgen.cli.outputs import Output, check_file, check_files
from hysgen.cli.verbs import Verb
from hysgen.cli.verbs.generate import cost_text
from hysgen.codegen import generate, write
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.machine.files import write_whole
from hysgen.model.file import save_model
from hysgen.model.model import Model
from hysgen.model.rivals import fit_rivals, score_rivals
from hysgen.model.scores import score, score_identification, score_lines
from hysgen.model.simulate import free_run, one_step
from hysgen.record import Record, load_record
from hysgen.report.model import ScoredModels, model_page
from hysgen.report.plots import style
from hysgen.report.plots.experiments import modelling_figures, tracking_figure
from hysgen.report.plots.traces import horizon, loops, validation
from hysgen.stage.demo_record import bundled_csv, identification_rows
from hysgen.stage.families import FAMILIES
from hysgen.studies.bank import CATEGORIES, OWN, Judgement, limits, limits_table
from hysgen.studies.bank import run as judge_bank
from hysgen.studies.paper.results import repeat_all

DEMO_HELP = """\
The whole way on the bundled record: record, fit, score, C, equivalence, cost, pictures, all in one folder.

What it does is what the other verbs do; each step says which one.
"""
EXPERIMENTS_HELP = """\
Repeat the paper's experiments (sections 4.1 to 4.3, Fig. 11) on the virtual stage: a table and the figures.

Beyond the paper, the learner in generated C: held against Eq. (10) in float64, and after the plant has lost gain.
"""
BANK_HELP = """\
Hide effects in records of the virtual stage and count how often `diagnose` names them: confusion, limits, alarms.

With --family the stages have the hysteresis of other equations than the diagnosis, with a past that the record does not
show, other laws of creep, coloured and quantised noise, and a sensor with a curve.

Exit code 1 if a limit is missed; 130 if it was interrupted, after saying what it had until then. With --log, the same
command goes on where it was interrupted.
"""
ENDURANCE_HELP = """\
Run the generated learner for hours of samples of poor, broken and endless excitation, and test its recovery.

Every case drives the compiled learner of a model with six rules on the virtual stage. One second of persistent
excitation follows; the free-run error of the learned model is divided by that of a fresh fit to the same second. Eq.
(10) as printed runs in float32 over the same samples. Exit code 1 if a case fails.
"""

PAPER, EXTENDED = "paper's model", "with memory"
COLOURS = {PAPER: style.SIMULATED, EXTENDED: style.EXTENDED, "one step": style.BASELINE}

DEMO_FILES = ("paper.json", "stage.json", "report.html", "free-run.png", "loops.png", "horizon.png")
"""Files of the demo beside record.csv and the generated C."""

LEAST_SAMPLES = 1000
LEGEND = f"""\
holds:     factors finite, positive and bounded to the end, recovered to at most {ALLOWED_RATIO:g}
recovered: free-run error after one second of persistent excitation, divided by that of a fresh float64 fit to the
           same second with the same lambda; column `lambda 1`: divided by that of a fit without forgetting
Eq. (10):  as printed, in float32, on the same samples without NaN and spikes, which it does not reject"""


def demo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", default="hysgen-demo", metavar="DIR", help="folder (default %(default)s)")
    parser.add_argument("--samples", type=int, default=200_000, help="samples that verify compares in each build")


def run_demo(arguments: argparse.Namespace, console: Console) -> int:
    folder = Path(arguments.output)
    csv = folder / "record.csv"
    if not (csv.exists() and csv.read_bytes() == bundled_csv().encode()):
        check_file(csv, "-o", arguments.force)
        write_whole(csv, bundled_csv())
    check_files(folder, DEMO_FILES, "-o", arguments.force)
    known, unseen = load_record(csv).split_at(identification_rows())
    console.say(f"record       {csv}: {known.samples} samples to identify, {unseen.samples} to validate, 50 kHz")

    models = demo_models(known, console)
    for model in models.values():
        identified = {"identification": score_identification(model, known).to_json()}
        save_model(dataclasses.replace(model, scores=identified), folder / f"{model.name}.json")
    console.say(f"hysgen fit   {folder / 'paper.json'}, {folder / 'stage.json'}")
    scores = {name: score(model, unseen) for name, model in models.items()}
    scored = ScoredModels(unseen, models, scores, score_rivals(fit_rivals(known), unseen))
    lines = "\n".join([*score_lines(scored.rows()), f"noise floor {scored.noise.describe()}"])
    console.say(f"\nhysgen score, on rows that the fit has not seen\n{lines}\n")
    extended = models[EXTENDED]
    console.say("\n".join(certify(extended).lines()))

    written = draw(folder, scored)
    code = folder / "c"
    write(generate(extended), code)
    console.say(f"\nhysgen generate  {code}: {', '.join(sorted(path.name for path in code.iterdir()))}")

    report = verify(code, VerifySettings(samples=arguments.samples, other_models=1), console.progress)
    console.say("\nhysgen verify\n" + "\n".join(report.lines()))
    price = cost(code)
    console.say("\nhysgen cost\n" + cost_text(price))
    page = folder / "report.html"
    write_whole(page, model_page("hysgen on its bundled record", scored, report, price).html())
    console.say(f"\nreport       {page}")
    console.say("\npictures\n" + "\n".join(f"  {path}" for path in written))
    result = {
        "scores": {name: part.to_json() for name, part in scores.items()},
        "verify": report.to_json(),
        "cost": price.to_json(),
        "pictures": [str(path) for path in written],
        "report": str(page),
    }
    return console.finish(result, report.equal)


def demo_models(known: Record, console: Console) -> dict[str, Model]:
    """The paper's model by Eq. (10), and a model whose path holds a hysteresis, both fitted to `known`."""
    settings = FitSettings(name="stage", memory=PathSize())
    paper = fit(known, FitSettings(name="paper", method="rls"))
    return {PAPER: paper, EXTENDED: fit(known, settings, progress=console.progress)}


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


def experiments_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for the figures (PNG)")


def run_experiments(arguments: argparse.Namespace, console: Console) -> int:
    results = repeat_all(console.progress)
    console.say(results.text())
    if arguments.output:
        folder = Path(arguments.output)
        for outcome in results.modelling:
            for name, figure in modelling_figures(outcome).items():
                console.say(f"written: {style.save(figure, folder / name)}")
        for tracked in results.tracking:
            path = folder / f"section-4.3-{tracked.f_Hz:g}-hz.png"
            console.say(f"written: {style.save(tracking_figure(tracked), path)}")
    return console.finish(results.to_json())


def bank_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seeds", default="1000:1010", metavar="A:B", help="seeds A to B, B excluded (%(default)s)")
    parser.add_argument("--categories", nargs="+", choices=CATEGORIES, default=list(CATEGORIES), metavar="NAME")
    parser.add_argument(
        "--family",
        nargs="+",
        choices=(*FAMILIES, "all"),
        metavar="NAME",
        help=f"stages of other equations than the diagnosis': {', '.join(FAMILIES)}, or all",
    )
    parser.add_argument("--log", metavar="FILE", help="one JSON line a record as it is judged; what it holds is kept")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")


def run_bank(arguments: argparse.Namespace, console: Console) -> int:
    judged = wrong = 0

    def report(fraction: float, judgement: Judgement) -> None:
        nonlocal judged, wrong
        judged, wrong = judged + 1, wrong + (not judgement.exact)
        name = judgement.name
        if judgement.category != "poor" and not judgement.exact:
            console.say(f"wrong: {name}: {judgement.difference()}")
        console.progress(
            fraction, f"{name}: {', '.join(judgement.named) or 'nothing'} ({judged} judged, {wrong} wrong)"
        )

    log = Path(arguments.log) if arguments.log else None
    named = arguments.family or [OWN]
    families = tuple(FAMILIES) if "all" in named else tuple(named)
    result = judge_bank(parse_seeds(arguments.seeds), arguments.categories, families, arguments.jobs, report, log)
    comparison = limits(result)
    console.say(result.table())
    console.say()
    console.say(limits_table(comparison))
    console.write_json(result.to_json() | {"limits": [dataclasses.asdict(limit) for limit in comparison]})
    if not result.complete:
        console.warn(f"interrupted: {len(result.judgements)} of {result.asked} records")
        return 130
    return int(any(limit.holds is False for limit in comparison))


def parse_seeds(text: str) -> range:
    """The seeds "A:B", B excluded. Raises HysgenError for any other text.

    >>> parse_seeds("1000:1003")
    range(1000, 1003)
    """
    first, _, last = text.partition(":")
    if not (first.isdecimal() and last.isdecimal() and int(first) < int(last)):
        raise HysgenError(f"seeds: '{text}' is not a range of whole numbers; write FIRST:LAST, as 1000:1010")
    return range(int(first), int(last))


def endurance_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--samples",
        type=float,
        default=1e6,
        help="samples of each case with lambda 0.999 and alpha 1e6 (%(default)g; 0: not tried)",
    )
    parser.add_argument(
        "--others",
        type=float,
        default=0,
        metavar="SAMPLES",
        help="samples of each case with lambda 1, 0.9999, 0.99 and alpha 1e6, 1e3 (default: not tried)",
    )
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES), metavar="NAME", help=", ".join(CASES))


def run_endurance(arguments: argparse.Namespace, console: Console) -> int:
    samples, others = (_whole(name, getattr(arguments, name)) for name in ("samples", "others"))
    for name, count in (("samples", samples), ("others", others)):
        if 0 < count < LEAST_SAMPLES or samples == others == 0:
            raise HysgenError(f"{name}: {count}: choose at least {LEAST_SAMPLES}, fewer do not test endurance")
    tests = [test for test in endurance_tests(samples, others) if test.case in arguments.cases]
    results = endure(tests, console.progress)
    console.say(table(HEADINGS, rows(results)))
    failed = [result for result in results if not result.holds]
    console.say(f"\n{len(results) - len(failed)} of {len(results)} hold\n{LEGEND}")
    return console.finish(
        {"allowed_ratio": ALLOWED_RATIO, "trials": [result.to_json() for result in results]}, not failed
    )


def _whole(name: str, value: float) -> int:
    """The whole number `value` (1e8 is one). Raises HysgenError if it is not whole or out of range."""
    if not (0 <= value <= 1e12 and value == int(value)):
        raise HysgenError(f"{name}: {value:g} is not a number of samples; write a whole number, as 1e8")
    return int(value)


VERBS = {
    "demo": Verb(DEMO_HELP, demo_arguments, run_demo, {"output": Output("-o", folder=True)}),
    "experiments": Verb(
        EXPERIMENTS_HELP, experiments_arguments, run_experiments, {"output": Output("-o", folder=True)}
    ),
    "bank": Verb(BANK_HELP, bank_arguments, run_bank),
    "endurance": Verb(ENDURANCE_HELP, endurance_arguments, run_endurance),
}
