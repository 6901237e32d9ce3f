"""Generate the C of a model: header, source, parameters, self-test, manifest; with --learn, the learner too.

With --check nothing is written: exit code 0 says that every file in the folder is what would be generated now, 1 that
some are stale, which are then listed.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.learner import add_learner_options, with_learner
from hysgen.codegen import Options, generate, write
from hysgen.codegen.freshness import stale
from hysgen.model.file import load_model
from hysgen.model.model import Model


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="model file, or a shipped one: appendix_a, appendix_b")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="folder for the files")
    parser.add_argument(
        "--displacement-range",
        nargs=2,
        type=float,
        metavar=("LOW", "HIGH"),
        help="use the model, and certify it, over this part of its displacements in um only",
    )
    parser.add_argument(
        "--input-range", nargs=2, type=float, metavar=("LOW", "HIGH"), help="and over this part of its inputs in V"
    )
    parser.add_argument("--no-inverse", action="store_true", help="leave the inverse out")
    parser.add_argument("--check", action="store_true", help="only say whether the files in DIR are up to date")
    add_learner_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    model = restricted(with_learner(load_model(arguments.model), arguments), arguments)
    texts = generate(model, Options(inverse=not arguments.no_inverse))
    folder = Path(arguments.output)
    if arguments.check:
        return check(texts, folder, console)
    write(texts, folder)
    for name, text in texts.items():
        console.say(f"written: {folder / name} ({len(text.encode())} bytes)")
    console.write_json({"model": model.name, "files": {name: len(text.encode()) for name, text in texts.items()}})
    return 0


def restricted(model: Model, arguments: argparse.Namespace) -> Model:
    """`model` over the ranges that the options ask for; without options, as it is."""
    displacement, voltage = arguments.displacement_range, arguments.input_range
    if displacement is None and voltage is None:
        return model
    return model.within(tuple(displacement) if displacement else None, tuple(voltage) if voltage else None)


def check(texts: Mapping[str, str], folder: Path, console: Console) -> int:
    """0 if every file is up to date; else 1, with the list of those that are not."""
    found = stale(texts, folder)
    for item in found:
        console.say(f"stale: {folder / item.name}: {str(item).partition(': ')[2]}")
    console.say(
        f"{folder}: {len(found)} of {len(texts)} files are stale; generate them again"
        if found
        else f"{folder}: all {len(texts)} files are up to date"
    )
    console.write_json({"up_to_date": not found, "stale": [vars(item) for item in found]})
    return 1 if found else 0
