"""Hide effects in records of the virtual stage and count how often `diagnose` names them: confusion, limits, alarms.

Exit code 1 if a limit is missed; 130 if it was interrupted, after saying what it had until then. With --log, the same
command goes on where it was interrupted.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.errors import HysgenError
from hysgen.studies.bank import CATEGORIES, Judgement, limits, limits_table
from hysgen.studies.bank import run as run_bank


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seeds", default="1000:1010", metavar="A:B", help="seeds A to B, B excluded (%(default)s)")
    parser.add_argument("--categories", nargs="+", choices=CATEGORIES, default=list(CATEGORIES), metavar="NAME")
    parser.add_argument("--log", metavar="FILE", help="one JSON line a record as it is judged; what it holds is kept")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")


def run(arguments: argparse.Namespace, console: Console) -> int:
    judged = wrong = 0

    def tell(fraction: float, judgement: Judgement) -> None:
        nonlocal judged, wrong
        judged, wrong = judged + 1, wrong + (not judgement.exact)
        name = f"{judgement.category} {judgement.seed}"
        if judgement.category != "poor" and not judgement.exact:
            console.say(f"wrong: {name}: {judgement.difference()}")
        console.progress(
            fraction, f"{name}: {', '.join(judgement.named) or 'nothing'} ({judged} judged, {wrong} wrong)"
        )

    log = Path(arguments.log) if arguments.log else None
    result = run_bank(parse_seeds(arguments.seeds), arguments.categories, arguments.jobs, tell, log)
    found = limits(result)
    console.say(result.table())
    console.say()
    console.say(limits_table(found))
    told = [dataclasses.asdict(limit) for limit in found]
    console.write_json(result.to_json() | {"limits": told})
    if not result.complete:
        console.warn(f"interrupted: {len(result.judgements)} of {result.asked} records")
        return 130
    return int(any(limit.holds is False for limit in found))


def parse_seeds(text: str) -> range:
    """Seeds "A:B", B excluded.

    >>> parse_seeds("1000:1003")
    range(1000, 1003)
    """
    first, _, last = text.partition(":")
    if not (first.isdecimal() and last.isdecimal() and int(first) < int(last)):
        raise HysgenError(f"seeds: '{text}' is not a range of whole numbers; write FIRST:LAST, as 1000:1010")
    return range(int(first), int(last))
