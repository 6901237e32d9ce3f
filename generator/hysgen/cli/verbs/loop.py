"""loop: a feedback loop around the inverse of a model, with its certificate."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from hysgen.api.models import design_loop
from hysgen.cli.console import Console
from hysgen.cli.options import add_model
from hysgen.cli.verbs import Verb
from hysgen.cli.verbs.generate import usable_model
from hysgen.errors import HysgenError
from hysgen.feedback.stage import LATENCY, Uncertainty

HELP = """\
Design a feedback loop around the inverse of a model: an integral and notches of the largest bandwidth with margins of 6
dB and 45 degrees over the uncertainty of the model, and its certificate. Exit code 1 says that it does not hold.

The correction is added to the displacement that the inverse is asked for, so the inverse is the feed-forward."""


def arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)
    known = ",".join(f"{name}={value:g}" for name, value in asdict(Uncertainty()).items())
    parser.add_argument(
        "--latency",
        type=float,
        default=LATENCY,
        metavar="SAMPLES",
        help="from reading to voltage, where the record of the model does not hold it (default %(default)g)",
    )
    parser.add_argument(
        "--uncertainty",
        default="",
        metavar="KEY=VALUE,...",
        help=f"what the stage may differ by, relative; late in samples (default {known})",
    )
    parser.add_argument("--plot", metavar="FILE.png", help="draw the open loop (Bode) and the settling of a push")


def run(arguments: argparse.Namespace, console: Console) -> int:
    parts = [part.partition("=") for part in filter(None, arguments.uncertainty.split(","))]
    try:
        changes = {key.strip(): float(value) for key, _, value in parts}
    except ValueError as fault:
        raise HysgenError(f"--uncertainty: {fault}; write KEY=VALUE, as frequency=0.02,gain=0.1") from fault
    designed = design_loop(usable_model(arguments), arguments.latency, **changes)
    console.say(str(designed))
    if arguments.plot:
        designed.plot().save(arguments.plot)
        console.say(f"written: {arguments.plot}")
    return console.finish(designed.to_json(), designed.certificate.holds)


EXAMPLES = (
    "hysgen loop stage.json --json loop.json --plot loop.png",
    "hysgen loop stage.json --latency 2 --uncertainty frequency=0.03    a stage whose load changes",
)
VERBS = {"loop": Verb(HELP, arguments, run, examples=EXAMPLES)}
