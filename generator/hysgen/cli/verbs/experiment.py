"""experiment: the voltage to play next, for what a record cannot tell."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.api.diagnosing import diagnose, next_experiment
from hysgen.cli.console import Console
from hysgen.cli.options import add_record_options, read_records
from hysgen.cli.outputs import Output
from hysgen.cli.verbs import Verb
from hysgen.diagnosis import DiagnoseSettings
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.machine.files import write_whole
from hysgen.machine.processes import several_processes

EXPERIMENT_HELP = """\
Write the voltage to play next: what this record cannot tell, as strokes, rests, steps and frequencies inside limits.

The record is diagnosed first. Without limits the voltage keeps to the range, the rate of change and, where that is
enough, the length of the record. The table says what this record can tell, and what the next one is predicted to tell.
"""


def experiment_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("records", nargs="+", metavar="RECORD")
    parser.add_argument("-o", "--output", metavar="FILE.csv", required=True, help="voltage to play: time_s,voltage_V")
    parser.add_argument(
        "--range", metavar="LOW:HIGH", dest="range_V", help="voltages in V, as 0:120 or --range=-20:120"
    )
    parser.add_argument("--slew", type=float, metavar="V/s", help="fastest change of the voltage")
    parser.add_argument("--seconds", type=float, metavar="S", help="length of the voltage")
    add_record_options(parser)


@several_processes(__name__)
def run_experiment(arguments: argparse.Namespace, console: Console) -> int:
    record = read_records(arguments.records, arguments, console, gated=True)
    low_V, high_V = _range(arguments.range_V) if arguments.range_V else (None, None)
    stated = {"low_V": low_V, "high_V": high_V, "slew_V_s": arguments.slew, "seconds": arguments.seconds}
    study = diagnose(record, None, DiagnoseSettings(resume=True), console.progress)
    planned = next_experiment(study, **{name: value for name, value in stated.items() if value is not None})
    rows = [[now.name, now.text(), then.text()] for now, then in zip(planned.now, planned.then, strict=True)]
    console.say(f"{planned.words}\n\n{table(('cause', 'this record', 'the next one (predicted)'), rows)}\n")
    write_whole(Path(arguments.output), planned.csv())
    console.say(f"written: {arguments.output} ({len(planned.u_V)} rows, {len(planned.u_V) * planned.Ts_s:.4g} s)")
    return console.finish(planned.to_json())


def _range(text: str) -> tuple[float, float]:
    try:
        low, high = text.split(":")
        return float(low), float(high)
    except ValueError:
        raise HysgenError(f"--range {text!r} is not LOW:HIGH in V, as 0:120") from None


VERBS = {
    "experiment": Verb(
        EXPERIMENT_HELP,
        experiment_arguments,
        run_experiment,
        {"output": Output("-o", (".csv",))},
        (
            "hysgen experiment record.csv -o next.csv",
            "hysgen experiment record.csv -o next.csv --range 0:120 --slew 2e4 --seconds 8",
        ),
    )
}
