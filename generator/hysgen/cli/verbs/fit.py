"""fit: a model of one or several records."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

from hysgen.api.models import certificates, fit, parameter_count, scored
from hysgen.cli.console import Console
from hysgen.cli.options import add_learner_options, add_record_options, parse_rows, read_records, with_learner
from hysgen.cli.outputs import Output
from hysgen.cli.verbs import Verb
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings, PathSize
from hysgen.fitting.operator import MOST_PLAYS, RELAXING
from hysgen.model.file import save_model
from hysgen.model.model import MOST_RULES

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


VERBS = {
    "fit": Verb(FIT_HELP, fit_arguments, run_fit, {"output": Output("-o")}, FIT_EXAMPLES),
}
