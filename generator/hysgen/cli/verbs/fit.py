"""fit: a model of records; score: its errors on a record; compare: those of several; describe: a dynamic system."""

import argparse
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from hysgen.api.models import PAPERS_MODEL, certificates, describe, fit, parameter_count, rivals, score, scored
from hysgen.cli.console import Console, command_line
from hysgen.cli.options import (
    add_learner_options,
    add_model,
    add_predict_only,
    add_record_options,
    parse_rows,
    read_records,
    with_learner,
)
from hysgen.cli.verbs import Output, Verb
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings, PathSize
from hysgen.fitting.operator import MOST_PLAYS, RELAXING
from hysgen.machine.files import write_whole
from hysgen.model.file import is_model, load_model, save_model
from hysgen.model.model import MOST_RULES, Model
from hysgen.model.scores import Score, Scores, decimals, score_lines
from hysgen.model.simulate import free_run, one_step
from hysgen.record import Record

FIT_HELP = """\
Fit a model to one or several records.

Several records are several segments, each with its own initial state. --rows uses a part and leaves the rest for
`hysgen score`: a score on rows that the fit has seen says little.
"""
FAR = 2.0
"""Range of the input, relative to that of the record, beyond which --input-range is warned of."""

FIT_EXAMPLES = (
    "hysgen fit record.csv --memory -o stage.json",
    "hysgen fit a.csv b.csv --rows 0:20000 --rules 8 -o stage.json      two records, two segments",
    'hysgen fit log.csv --columns "voltage=U [V],displacement=Sensor [nm],time=t [ms]" -o stage.json',
)


def fit_arguments(parser: argparse.ArgumentParser) -> None:
    defaults = FitSettings()
    parser.add_argument(
        "records", nargs="+", metavar="RECORD", help="text, NPZ, MAT, HDF5, TDMS, Excel, ... (docs/records.md)"
    )
    parser.add_argument("-o", "--output", required=True, metavar="MODEL", help="model file to write (JSON)")
    parser.add_argument("--rows", metavar="A:B", help="use rows A to B of the joined records, B excluded")
    parser.add_argument("--name", help="prefix of the C functions (default: the name of the model file)")
    parser.add_argument("--rules", type=int, default=defaults.rules, help=f"2 to {MOST_RULES} (default %(default)s)")
    parser.add_argument(
        "--method",
        choices=("rls", "batch", "refined"),
        default=defaults.method,
        help="Eq. (10) as printed; its least-squares optimum; or that with the free run refined (default)",
    )
    parser.add_argument("--forgetting", type=float, default=defaults.forgetting, metavar="LAMBDA")
    parser.add_argument("--alpha", type=float, default=defaults.alpha, help="P(0) = alpha I (default %(default)g)")
    parser.add_argument("--epsilon", type=float, default=defaults.epsilon, help="q(0) = epsilon (default %(default)g)")
    parser.add_argument(
        "--margin",
        type=float,
        default=defaults.margin,
        help="part of the range added to the grid at each end (default %(default)g, the paper's)",
    )
    parser.add_argument(
        "--input-range",
        type=float,
        nargs=2,
        metavar=("LOW_V", "HIGH_V"),
        help="voltages for which the model is to answer (default: those of the record)",
    )
    parser.add_argument(
        "--memory",
        type=int,
        nargs="?",
        const=PathSize().plays,
        metavar="PLAYS",
        help="a hysteresis before the rules, of PLAYS play operators (default %(const)s) and Duhem states",
    )
    parser.add_argument(
        "--relaxation",
        action="store_true",
        help="with --memory: play operators that relax by thermal activation (creep, loops that depend on the rate)",
    )
    parser.add_argument(
        "--uncertified", action="store_true", help="do not keep the fit inside the models whose certificates hold"
    )
    add_predict_only(parser)
    add_learner_options(parser)
    add_record_options(parser)


def _size(arguments: argparse.Namespace) -> PathSize | None:
    """The size of the hysteresis that the options ask for, None without one."""
    if arguments.memory is None:
        if arguments.relaxation:
            raise HysgenError("--relaxation: is a property of the hysteresis; give --memory too")
        return None
    if not 0 <= arguments.memory <= MOST_PLAYS:
        raise HysgenError(f"--memory {arguments.memory}: is not supported; choose 0 to {MOST_PLAYS} play operators")
    return dataclasses.replace(RELAXING if arguments.relaxation else PathSize(), plays=arguments.memory)


def run_fit(arguments: argparse.Namespace, console: Console) -> int:
    record = read_records(arguments.records, arguments, console)
    if arguments.rows:
        record = record.rows(*parse_rows(arguments.rows, record.samples, record.Ts_s))
    settings = FitSettings(
        name=arguments.name or c_name(arguments.output),
        rules=arguments.rules,
        method=arguments.method,
        forgetting=arguments.forgetting,
        alpha=arguments.alpha,
        epsilon=arguments.epsilon,
        margin=arguments.margin,
        input_range_V=tuple(arguments.input_range) if arguments.input_range else None,
        memory=_size(arguments),
        rising=not arguments.predict_only,
        certified=not arguments.uncertified,
    )
    if not 2 <= settings.rules <= MOST_RULES:
        raise HysgenError(f"--rules {settings.rules}: is not supported; choose 2 to {MOST_RULES}")
    low_V, high_V = record.u_range_V
    if settings.input_range_V is not None:
        wanted_V = settings.input_range_V[1] - settings.input_range_V[0]
        if wanted_V > FAR * (high_V - low_V):
            console.warn(
                f"--input-range: {wanted_V:.4g} V is more than {FAR:g} times the {high_V - low_V:.4g} V of the record; "
                "outside the record the model extrapolates"
            )
    model = with_learner(fit(record, settings, progress=console.progress), arguments)
    model, scores = scored(model, record)
    save_model(model, Path(arguments.output))
    console.say(scores.table())
    console.say()
    console.say("\n".join(certificates(model).lines()))
    console.say(
        f"\nwritten: {arguments.output} ({settings.rules} rules, {parameter_count(settings, record)} parameters)"
    )
    return console.finish(model.to_json())


def c_name(path: str) -> str:
    """The stem of a file name as a C identifier.

    >>> c_name("out/Stage 7-x.json")
    'stage_7_x'
    """
    stem = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in Path(path).stem.lower())
    return stem if stem[:1].isalpha() else f"m_{stem}"


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
    if others_fitted:
        console.say("\nrivals in free run")
        console.say("\n".join(score_lines(list(others_fitted.items()))))
        result["rivals_free_run"] = {name: rival.to_json() for name, rival in others_fitted.items()}
    if arguments.report:
        _write_page(arguments.report, console, record, {model.name: model}, {model.name: scores}, others_fitted)
    if arguments.plot:
        # matplotlib takes half a second to import.
        from hysgen.report import plots
        from hysgen.report.plots.traces import validation

        runs = {"free run": free_run(model, record)[0].y_um, "one step": one_step(model, record)[0].y_um}
        colours = {"free run": plots.SIMULATED, "one step": plots.BASELINE}
        plots.save(validation(record, runs, f"{model.name} on {record.source}", colours), Path(arguments.plot))
        console.say(f"\nwritten: {arguments.plot}")
    return console.finish(result)


def _write_page(
    path: str,
    console: Console,
    record: Record,
    models: Mapping[str, Model],
    scores: Mapping[str, Scores],
    rivals: Mapping[str, Score],
) -> None:
    from hysgen.report.pages import model_page

    title = f"{', '.join(models)} on {record.source}"
    write_whole(Path(path), model_page(title, record, models, scores, rivals, command_line()).html())
    console.say(f"\nwritten: {path}")


COMPARE_HELP = """\
Several models on the same records: the errors of each in one table, and which is best.

A file that says it is a model, and the name of a shipped one, is a model; every other file is a record."""

COMPARED = ("model", "free run um", "own um", "one step um", "largest um", "of stroke %")


def compare_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", metavar="FILE", help="models and records, in any order")
    parser.add_argument("--rows", metavar="A:B", help="score on rows A to B of the joined records, B excluded")
    parser.add_argument("--report", metavar="FILE.html", help="write one page with the scores and pictures of all")
    add_record_options(parser)


def run_compare(arguments: argparse.Namespace, console: Console) -> int:
    files = [name for name in arguments.files if is_model(name)]
    records = [name for name in arguments.files if name not in files]
    if not (files and records):
        raise HysgenError(f"compare: {len(files)} models and {len(records)} records given; give one of each or more")
    alike = len({Path(name).stem for name in files}) < len(set(files))
    models = {name if alike else Path(name).stem: load_model(name) for name in files}
    whole = read_records(records, arguments, console)
    record = whole.rows(*parse_rows(arguments.rows, whole.samples, whole.Ts_s)) if arguments.rows else whole
    scores = {name: score(model, record) for name, model in models.items()}
    rows = []
    digits = decimals(s.own.e_rms_um for s in scores.values())
    for name, s in scores.items():
        for line in s.warnings:
            console.warn(f"{name}: {line}")
        errors_um = (s.free_run.e_rms_um, s.own.e_rms_um, s.one_step.e_rms_um, s.free_run.largest_um)
        rows.append([name, *(f"{error_um:.{digits}f}" for error_um in errors_um), f"{s.free_run.of_span_percent:.3f}"])
    some, best = next(iter(scores.values())), min(scores, key=lambda name: scores[name].own.e_rms_um)
    rows.append(["persistence", "", "", f"{some.persistence.e_rms_um:.{digits}f}", "", ""])
    console.say(table(COMPARED, rows))
    console.say(f"noise floor {some.noise.describe()}\nleast own error: {best}")
    if arguments.report:
        _write_page(arguments.report, console, record, models, scores, {})
    return console.finish(
        {
            "record": some.to_json()["record"],
            "noise_floor": some.noise.to_json(),
            "models": {name: s.to_json() for name, s in scores.items()},
            "best": best,
        }
    )


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
    "fit": Verb(FIT_HELP, fit_arguments, run_fit, {"output": Output("-o")}, FIT_EXAMPLES),
    "score": Verb(SCORE_HELP, score_arguments, run_score, examples=SCORE_EXAMPLES),
    "compare": Verb(
        COMPARE_HELP,
        compare_arguments,
        run_compare,
        examples=("hysgen compare a.json b.json record.csv --rows 46003: --report page.html",),
    ),
    "describe": Verb(DESCRIBE_HELP, describe_arguments, run_describe, examples=("hysgen describe stage.json",)),
}
