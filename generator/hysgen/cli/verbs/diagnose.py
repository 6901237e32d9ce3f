"""Show what the simulation of a record gets wrong, name the cause, extend the model, and measure the gain.

Structure and parameters come from the identification part alone; every score is on the part that is held out: the
records of --holdout, or else the last part of the record.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.records import add_record_options, parse_rows, read_records
from hysgen.cli.verbs.fit import c_name
from hysgen.diagnose import DiagnoseSettings, diagnose
from hysgen.fit import FitSettings
from hysgen.model_file import save_model


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("records", nargs="+", metavar="RECORD")
    parser.add_argument("--rows", metavar="A:B", help="identify on rows A to B and hold the rows after B out")
    parser.add_argument("--holdout", nargs="+", metavar="RECORD", help="records to score on instead of the last part")
    parser.add_argument("-o", "--output", metavar="MODEL", help="write the extended model")
    parser.add_argument("--rules", type=int, default=FitSettings().rules, help="fuzzy rules L (default %(default)s)")
    add_record_options(parser)


def run(arguments: argparse.Namespace, console: Console) -> int:
    record = read_records(arguments.records, arguments, console)
    holdout = read_records(arguments.holdout, arguments, console) if arguments.holdout else None
    if arguments.rows:
        start, stop = parse_rows(arguments.rows, record.samples)
        if holdout is None and stop < record.samples:
            holdout = record.rows(stop, record.samples)
        record = record.rows(start, stop)
    name = c_name(arguments.output) if arguments.output else "stage"
    settings = DiagnoseSettings(fit=FitSettings(name=name, rules=arguments.rules))
    found = diagnose(record, holdout, settings, console.progress)
    console.say(found.table())
    if arguments.output:
        save_model(found.model, Path(arguments.output))
        console.say(f"\nwritten: {arguments.output}")
    console.write_json(found.to_json())
    return 0
