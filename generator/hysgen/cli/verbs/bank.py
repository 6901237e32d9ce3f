"""Hide effects in records of the virtual stage and count how often `diagnose` names them: confusion, limits, alarms."""

from __future__ import annotations

import argparse
import os

from hysgen.bank import CATEGORIES
from hysgen.bank import run as run_bank
from hysgen.cli.console import Console
from hysgen.errors import HysgenError


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seeds", default="1000:1010", metavar="A:B", help="seeds A to B, B excluded (%(default)s)")
    parser.add_argument("--categories", nargs="+", choices=CATEGORIES, default=list(CATEGORIES), metavar="NAME")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")


def run(arguments: argparse.Namespace, console: Console) -> int:
    result = run_bank(parse_seeds(arguments.seeds), arguments.categories, arguments.jobs, console.progress)
    console.say(result.table())
    console.write_json(result.to_json())
    return 0


def parse_seeds(text: str) -> range:
    """Seeds "A:B", B excluded.

    >>> parse_seeds("1000:1003")
    range(1000, 1003)
    """
    first, _, last = text.partition(":")
    if not (first.isdecimal() and last.isdecimal() and int(first) < int(last)):
        raise HysgenError(f"seeds: '{text}' is not a range of whole numbers; write FIRST:LAST, as 1000:1010")
    return range(int(first), int(last))
