"""Show what a model is as a dynamic system: time constant, DC gain, loop against frequency, certificates."""

from __future__ import annotations

import argparse

from hysgen.certify.certificates import certify
from hysgen.certify.dynamics import dynamics
from hysgen.cli.console import Console
from hysgen.model.file import load_model


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="model file, or a shipped one: appendix_a, appendix_b")


def run(arguments: argparse.Namespace, console: Console) -> int:
    model = load_model(arguments.model)
    system, certificates = dynamics(model), certify(model)
    console.say(system.describe())
    for term in model.terms:
        console.say(f"term {term.kind}: {term.describe()}")
    for block in model.blocks:
        console.say(f"input {block.kind}: {block.describe()}")
    console.say()
    console.say("\n".join(certificates.lines()))
    console.write_json({"dynamics": system.to_json(), "certificates": certificates.to_json()})
    return 0
