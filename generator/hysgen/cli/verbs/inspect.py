"""inspect: what a file holds, before any analysis; schema: the JSON Schemas of results, model files and manifests.

Apart from the other verbs, so that fits and pages are not imported.
"""

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.cli.options import add_record_options, parse_rows, read_records
from hysgen.cli.verbs import Verb
from hysgen.diagnosis.identifiability import inspect
from hysgen.schemas import names, text_of

INSPECT_HELP = """\
Say what a file holds: channels, units, rate, ranges, noise, excitation, and from which size on each cause would show.

No cause is searched for: each would show beside hysteresis, lag and noise. The line "read as --columns ..." is what the
other verbs take to read the file in the same way.
"""


def inspect_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "records", nargs="+", metavar="RECORD", help="text, NPZ, MAT, HDF5, TDMS, Excel, ... (docs/records.md)"
    )
    parser.add_argument("--rows", metavar="A:B", help="look at rows A to B, B excluded; 0.5s:2s in seconds")
    parser.add_argument("--plot", metavar="FILE.png", help="draw voltage and displacement in time, and the loops")
    add_record_options(parser)


def run_inspect(arguments: argparse.Namespace, console: Console) -> int:
    record = read_records(arguments.records, arguments, console, echo=False)
    if arguments.rows:
        record = record.rows(*parse_rows(arguments.rows, record.samples, record.Ts_s))
    inspection = inspect(record)
    console.say(inspection.summary().text())
    if arguments.plot:
        record.plot().save(Path(arguments.plot))
        console.say(f"written: {arguments.plot}")
    return console.finish(inspection.to_json())


EXAMPLES = ("hysgen inspect log.tdms", "hysgen inspect record.csv --plot record.png --json -")


SCHEMA_HELP = """\
Print the JSON Schema of what --json writes, of a model file or of a manifest; without a name, list them."""


def schema_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", metavar="NAME", help="as score, score-1, model, manifest")


def run_schema(arguments: argparse.Namespace, console: Console) -> int:
    if arguments.name is None:
        console.say("\n".join(names()))
    else:
        console.say(text_of(arguments.name).rstrip("\n"))
    return console.finish({"schemas": names()})


VERBS = {
    "inspect": Verb(INSPECT_HELP, inspect_arguments, run_inspect, examples=EXAMPLES),
    "schema": Verb(SCHEMA_HELP, schema_arguments, run_schema, examples=("hysgen schema score > score.schema.json",)),
}
