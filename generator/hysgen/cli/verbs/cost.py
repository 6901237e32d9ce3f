"""State what generated C costs: operations by kind, bytes, cycles against the sample period, host time.

With --budget, cycles, code, stack and data on the target are compared with a file; more than 2 % above it is an error.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from hysgen.c674x.cost import Cost, cost
from hysgen.c674x.cost.budget_file import Change, changes, read, update
from hysgen.c674x.footprint import footprint
from hysgen.c674x.toolchain import version
from hysgen.cli.console import Console
from hysgen.codegen.manifest import read_folder
from hysgen.display import table
from hysgen.errors import HysgenError


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")
    parser.add_argument("--target", choices=("c674x",), help="count cycles on the target's instruction set")
    parser.add_argument("--budget", metavar="FILE", help="with --target: what each function may cost there")
    parser.add_argument("--update-budget", action="store_true", help="write the figures into that file instead")


def run(arguments: argparse.Namespace, console: Console) -> int:
    if (arguments.budget and not arguments.target) or (arguments.update_budget and not arguments.budget):
        raise HysgenError("--budget FILE belongs to --target c674x, --update-budget to --budget; add what is missing")
    folder = Path(arguments.folder)
    generated = read_folder(folder)
    taken = footprint(generated.model.name, generated.texts) if arguments.target else {}
    price = cost(folder, {name: figures["cycles"] for name, figures in taken.items() if "cycles" in figures})
    console.say(cost_text(price))
    if taken:
        console.say(footprint_text(taken))
    answer = price.to_json() | ({"target": taken} if taken else {})
    different: list[Change] = []
    if arguments.update_budget:
        update(Path(arguments.budget), generated.model.name, taken, version())
        console.say(f"written: {arguments.budget}")
    elif arguments.budget:
        different = changes(generated.model.name, read(Path(arguments.budget), generated.model.name), taken)
        console.say("\n".join(str(change) for change in different) or f"within the budget of {arguments.budget}")
        answer["budget_changes"] = [dataclasses.asdict(change) | {"exceeds": change.exceeds} for change in different]
    console.write_json(answer)
    return 1 if any(change.exceeds for change in different) else 0


def footprint_text(taken: Mapping[str, Mapping[str, int]]) -> str:
    """Cycles, code and stack of each function on the target, and of all; then the data."""
    columns = ("cycles", "code_bytes", "stack_bytes")
    rows = [
        [name, *(f"{figures[column]}" if column in figures else "-" for column in columns)]
        for name, figures in taken.items()
        if name != "data"
    ]
    data = taken["data"]
    below = f"data: {data['struct_bytes']} bytes of structs, {data['constant_bytes']} of constants"
    return "\n".join(["", table(["on the C674x", "cycles", "code bytes", "stack bytes"], rows), below])


def cost_text(price: Cost) -> str:
    """One row per function, and below what the columns mean."""
    return "\n".join([table(price.header(), price.rows()), *price.notes()])
