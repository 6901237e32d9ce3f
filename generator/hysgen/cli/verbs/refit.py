"""Identify a model again from a new record: same structure, new numbers.

Exit code 1 says that the structure no longer fits: the new model simulates its own record worse than the old one did
its own by more than half. Then `hysgen diagnose` tells why.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.records import add_record_options, read_records
from hysgen.cli.verbs.diff import comparison_text
from hysgen.model_file import load_model, save_model
from hysgen.revision import compare, refit

WORSE = 1.5


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL")
    parser.add_argument("records", nargs="+", metavar="RECORD")
    parser.add_argument("-o", "--output", required=True, metavar="MODEL", help="model file to write")
    add_record_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    old = load_model(arguments.model)
    record = read_records(arguments.records, arguments, console)
    new, scores = refit(old, record, console.progress)
    save_model(new, Path(arguments.output))
    comparison = compare(old, new, [record])
    console.say(scores.table())
    console.say("\n" + comparison_text(comparison))
    console.say(f"\nwritten: {arguments.output}")
    before = old.scores.get("identification", {}).get("free_run", {}).get("of_span_percent")
    fits = before is None or scores.free_run.of_span_percent <= WORSE * before
    if not fits:
        console.warn(
            f"the structure no longer fits: free run {scores.free_run.of_span_percent:.2f} % of span, "
            f"{before:.2f} % before; run hysgen diagnose on the new record"
        )
    console.write_json({"structure_fits": fits, "scores": scores.to_json(), "comparison": comparison.to_json()})
    return 0 if fits else 1
