"""Fit a model to one or several records.

Several records are several segments, each with its own initial state. --rows uses a part and leaves the rest for
`hysgen score`: a score on rows that the fit has seen says little.
"""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

from hysgen.certify.certificates import certify
from hysgen.cli.console import Console
from hysgen.cli.learner import add_learner_options, with_learner
from hysgen.cli.records import add_record_options, parse_rows, read_records
from hysgen.fitting import FitSettings, fit
from hysgen.model.file import model_to_json, save_model
from hysgen.model.scores import score
from hysgen.model.terms import Term
from hysgen.model.terms.memory import Memory
from hysgen.record import Record, check_for_fit


def arguments(parser: argparse.ArgumentParser) -> None:
    defaults = FitSettings()
    parser.add_argument("records", nargs="+", metavar="RECORD", help="CSV, NPZ, MAT or HDF5")
    parser.add_argument("-o", "--output", required=True, metavar="MODEL", help="model file to write (JSON)")
    parser.add_argument("--rows", metavar="A:B", help="use rows A to B of the joined records, B excluded")
    parser.add_argument("--name", help="prefix of the C functions (default: the name of the model file)")
    parser.add_argument("--rules", type=int, default=defaults.rules, help="fuzzy rules L (default %(default)s)")
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
        "--plays",
        type=int,
        default=0,
        metavar="N",
        help="add memory: N play operators, half-widths spread inside half the input range",
    )
    parser.add_argument(
        "--uncertified", action="store_true", help="do not keep the fit inside the models whose certificates hold"
    )
    add_learner_options(parser)
    add_record_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    record = read_records(arguments.records, arguments, console)
    if arguments.rows:
        record = record.rows(*parse_rows(arguments.rows, record.samples))
    settings = FitSettings(
        name=arguments.name or c_name(arguments.output),
        rules=arguments.rules,
        method=arguments.method,
        forgetting=arguments.forgetting,
        alpha=arguments.alpha,
        epsilon=arguments.epsilon,
        margin=arguments.margin,
        input_range_V=tuple(arguments.input_range) if arguments.input_range else None,
        terms=memory_terms(record, arguments.plays),
        certified=not arguments.uncertified,
    )
    parameters = 3 * settings.rules + sum(term.size for term in settings.terms)
    for warning in check_for_fit(record, settings.rules, parameters):
        console.warn(warning)
    model = fit(record, settings, progress=console.progress)
    model = with_learner(model, arguments)
    scores = score(model, record)
    model = dataclasses.replace(model, scores={"identification": scores.to_json()})
    save_model(model, Path(arguments.output))
    console.say(scores.table())
    console.say()
    console.say("\n".join(certify(model).lines()))
    console.say(f"\nwritten: {arguments.output} ({settings.rules} rules, {parameters} parameters)")
    console.write_json(model_to_json(model))
    return 0


def memory_terms(record: Record, plays: int) -> tuple[Term, ...]:
    """Play operators for a record, or none: wider ones than half its voltage range would never move."""
    if plays <= 0:
        return ()
    low_V, high_V = record.u_range_V
    return (Memory.uniform(plays, 0.5 * (high_V - low_V)),)


def c_name(path: str) -> str:
    """A C identifier out of a file's name.

    >>> c_name("out/Stage 7-x.json")
    'stage_7_x'
    """
    stem = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in Path(path).stem.lower())
    return stem if stem[:1].isalpha() else f"m_{stem}"
