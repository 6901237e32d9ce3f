"""history: what moved over all refits of a stage."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.verbs import Verb
from hysgen.display import table
from hysgen.uncertainty.history import LIMIT_PERCENT, history

HELP = """\
Show what moved over all refits of a stage: its models in one folder, ordered by file name.

Exit code 1 says that a property moved by more than the limit since the first model, as a periodic test needs it.
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="FOLDER", help="folder with the model files of one stage")
    parser.add_argument(
        "--limit", type=float, default=LIMIT_PERCENT, metavar="PERCENT", help="largest change (default %(default)g)"
    )
    parser.add_argument("--plot", metavar="FILE.png", help="write the picture of the changes")


def run(arguments: argparse.Namespace, console: Console) -> int:
    moved = history(Path(arguments.folder), arguments.limit)
    heads = ["property", "unit", "first", "last", "largest change", ""]
    console.say(table(heads, moved.rows()))
    first, last = moved.files[0], moved.files[-1]
    console.say(f"{len(moved.files)} models, {first} to {last}; drift at rest {moved.drift_um:.3g} um")
    if arguments.plot:
        from hysgen.report.plots import style
        from hysgen.report.plots.results import changes

        console.say(f"written: {style.save(changes(moved).figure, Path(arguments.plot))}")
    exceeded = ", ".join(trend.what for trend in moved.exceeded)
    console.say(f"beyond {moved.limit:g} %: {exceeded}" if exceeded else f"every change is within {moved.limit:g} %")
    return console.finish(moved.to_json(), not moved.exceeded)


VERBS = {"history": Verb(HELP, arguments, run)}
