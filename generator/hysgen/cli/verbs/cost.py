"""State what generated C costs: operations by kind, bytes, cycles against the sample period, host time."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cost import Cost, cost
from hysgen.emit.manifest import read_folder
from hysgen.tables import table
from hysgen.target.generated import cycles


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")
    parser.add_argument("--target", choices=("c674x",), help="count cycles on the target's instruction set")


def run(arguments: argparse.Namespace, console: Console) -> int:
    folder = Path(arguments.folder)
    price = cost(folder, target_cycles(folder) if arguments.target else None)
    console.say(cost_text(price))
    console.write_json(price.to_json())
    return 0


def target_cycles(folder: Path) -> dict[str, int]:
    """Stall-free cycles of the worst way through each function, of the C as the target's compiler makes it."""
    generated = read_folder(folder)
    return {function: bound.worst for function, bound in cycles(generated.model.name, generated.texts).items()}


def cost_text(price: Cost) -> str:
    """One row per function, and below what the columns mean."""
    return "\n".join([table(price.header(), price.rows()), *price.notes()])
