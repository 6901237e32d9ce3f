"""Say what moved from one model to another of the same structure, in physical terms and rule by rule."""

from __future__ import annotations

import argparse

from hysgen.cli.console import Console
from hysgen.cli.records import add_record_options, read_records
from hysgen.display import table
from hysgen.fitting.compare import Comparison, compare
from hysgen.model.file import load_model


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("old", metavar="OLD")
    parser.add_argument("new", metavar="NEW")
    parser.add_argument(
        "--records", nargs="+", metavar="RECORD", default=[], help="score both models in free run on these"
    )
    add_record_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    records = [read_records([path], arguments, console) for path in arguments.records]
    comparison = compare(load_model(arguments.old), load_model(arguments.new), records)
    console.say(comparison_text(comparison))
    console.write_json(comparison.to_json())
    return 0


def comparison_text(comparison: Comparison) -> str:
    """Properties with their change, the rules' consequents, and the scores."""
    rows = [
        [
            f"{change.what} [{change.unit}]" if change.unit else change.what,
            f"{change.old:.5g}",
            f"{change.new:.5g}",
            "" if change.percent is None else f"{change.percent:+.1f} %",
        ]
        for change in comparison.changes
    ]
    rows += [
        [f"free run on {source} [um rms]", f"{before:.4g}", f"{after:.4g}", ""]
        for source, before, after in comparison.scores
    ]
    rules = [
        [f"{number}", f"{before:.4g} -> {after:.4g}", *(f"{value:+.3g}" for value in rule)]
        for number, (rule, (before, after)) in enumerate(
            zip(comparison.rules, comparison.centres_um, strict=True), start=1
        )
    ]
    return "\n\n".join(
        [
            table([f"{comparison.old} -> {comparison.new}", "old", "new", "change"], rows),
            table(["rule", "centre [um]", "q1 [um/um]", "q2 [um/V]", "q3 [um]"], rules),
        ]
    )
