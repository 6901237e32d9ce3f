"""State what generated C costs: operations by kind, bytes, cycles against the sample period, host time."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console, table
from hysgen.cost import Cost, cost


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")


def run(arguments: argparse.Namespace, console: Console) -> int:
    price = cost(Path(arguments.folder))
    console.say(cost_text(price))
    console.write_json(price.to_json())
    return 0


def cost_text(price: Cost) -> str:
    """One row per function, and below what the columns mean."""
    return "\n".join([table(price.header(), price.rows()), *price.notes()])
