"""schema: the JSON Schemas of the results of the verbs, of model files and of manifests."""

import argparse

from hysgen.cli.console import Console
from hysgen.cli.verbs import Verb
from hysgen.schemas import names, text_of

HELP = """\
Print the JSON Schema of what --json writes, of a model file or of a manifest; without a name, list them."""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", metavar="NAME", help="as score, score-1, model, manifest")


def run(arguments: argparse.Namespace, console: Console) -> int:
    if arguments.name is None:
        console.say("\n".join(names()))
    else:
        console.say(text_of(arguments.name).rstrip("\n"))
    return console.finish({"schemas": names()})


VERBS = {
    "schema": Verb(HELP, arguments, run, examples=("hysgen schema score > score.schema.json",)),
}
