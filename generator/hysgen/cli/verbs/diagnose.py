"""diagnose: errors of the simulation and their causes; experiment: the voltage to play next."""

import argparse
import dataclasses
from pathlib import Path

from hysgen.api.diagnosing import diagnose, next_experiment, scored_extension
from hysgen.cli.console import Console, command_line
from hysgen.cli.options import add_predict_only, add_record_options, parse_rows, read_records
from hysgen.cli.verbs import Output, Verb, check_files
from hysgen.cli.verbs.fit import c_name
from hysgen.diagnosis import DiagnoseSettings
from hysgen.diagnosis.evaluation import Study
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.fitting import FitSettings
from hysgen.machine.files import write_whole
from hysgen.machine.processes import several_processes
from hysgen.model.file import save_model
from hysgen.report.words import diagnosis_text
from hysgen.uncertainty.gum import length_um, sensor_uncertainty
from hysgen.uncertainty.simulated import characterise

DIAGNOSE_HELP = """\
Show what the simulation of a record gets wrong, name the cause, extend the model, and measure the gain.

Structure and parameters come from the identification part alone; every score is on the part that is held out: the
records of --holdout, or else the last part of the record.
"""


def diagnose_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("records", nargs="+", metavar="RECORD")
    parser.add_argument("--rows", metavar="A:B", help="identify on rows A to B and hold the rows after B out")
    parser.add_argument("--holdout", nargs="+", metavar="RECORD", help="records to score on instead of the last part")
    parser.add_argument("-o", "--output", metavar="MODEL", help="write the extended model")
    parser.add_argument("--plots", metavar="DIR", help="write the pictures, as PNG")
    parser.add_argument("--report", metavar="FILE.html", help="write the report: one page that needs no other file")
    parser.add_argument(
        "--keep-all",
        action="store_true",
        help="make every named extension, also those that gain less than 2 %% on rows left out of the fit",
    )
    add_predict_only(parser)
    parser.add_argument("--rules", type=int, default=FitSettings().rules, help="fuzzy rules L (default %(default)s)")
    parser.add_argument(
        "--sensor-uncertainty",
        metavar="U,k=K",
        help="expanded uncertainty of the sensor, as 5nm,k=2",
    )
    parser.add_argument("--drift-since", metavar="LENGTH", help="largest change of the stage since the record, as 3nm")
    add_record_options(parser)


@several_processes(__name__)
def run_diagnose(arguments: argparse.Namespace, console: Console) -> int:
    record = read_records(arguments.records, arguments, console, gated=True)
    holdout = read_records(arguments.holdout, arguments, console, gated=True) if arguments.holdout else None
    name = c_name(arguments.output) if arguments.output else "stage"
    fitted = FitSettings(name=name, rules=arguments.rules, rising=not arguments.predict_only)
    settings = DiagnoseSettings(fit=fitted, keep_all=arguments.keep_all, resume=True)
    if arguments.rows:
        start, stop = parse_rows(arguments.rows, record.samples, record.Ts_s)
        if holdout is None and stop < record.samples:
            # The two parts are one record: the states at the end of the first are those at the start of the second.
            settings = dataclasses.replace(settings, identify=(stop - start) / (record.samples - start))
            stop = record.samples
        record = record.rows(start, stop)
    if arguments.drift_since and not arguments.sensor_uncertainty:
        raise HysgenError("--drift-since belongs to --sensor-uncertainty; state both")
    sensor = sensor_uncertainty(arguments.sensor_uncertainty) if arguments.sensor_uncertainty else None
    drift_um = length_um(arguments.drift_since) if arguments.drift_since else None
    study = diagnose(record, holdout, settings, console.progress)
    console.say(diagnosis_text(study) + "\n")
    budget = characterise(study, sensor, drift_um) if sensor else None
    if budget:
        console.say("\n".join(budget.lines()) + "\n")
    if arguments.output:
        save_model(scored_extension(study), Path(arguments.output))
        console.say(f"written: {arguments.output}")
    if arguments.plots:
        for path in write_pictures(study, Path(arguments.plots), arguments.force):
            console.say(f"written: {path}")
    if arguments.report:
        from hysgen.report.pages import diagnosis_page

        write_whole(Path(arguments.report), diagnosis_page(study, budget, command=command_line()).html())
        console.say(f"written: {arguments.report}")
    result = study.to_json() | ({"uncertainty": budget.to_json()} if budget else {})
    return console.finish(result, study.follows_voltage)


def write_pictures(study: Study, folder: Path, force: bool) -> list[Path]:
    """Write every picture of the diagnosis as PNG. Returns their paths."""
    from hysgen.report import plots
    from hysgen.report.plots.results import pictures

    drawn = pictures(study)
    check_files(folder, [f"{picture.name}.png" for picture in drawn], "--plots", force)
    return [plots.save(picture.figure, folder / f"{picture.name}.png") for picture in drawn]


EXAMPLES = (
    "hysgen diagnose record.csv -o stage.json --report diagnosis.html",
    "hysgen diagnose monday.csv --holdout tuesday.csv --json - | jq .causes",
)


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
    # A cause that a named one holds, as memory holds the curve, is listed on one side alone.
    now, then = ({ability.name: ability.text() for ability in side} for side in (planned.now, planned.then))
    rows = [[name, *(side.get(name, "held by what is named") for side in (now, then))] for name in now | then]
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
    "diagnose": Verb(DIAGNOSE_HELP, diagnose_arguments, run_diagnose, {"output": Output("-o")}, EXAMPLES),
    "experiment": Verb(
        EXPERIMENT_HELP,
        experiment_arguments,
        run_experiment,
        {"output": Output("-o", (".csv",))},
        (
            "hysgen experiment record.csv -o next.csv",
            "hysgen experiment record.csv -o next.csv --range 0:120 --slew 2e4 --seconds 8",
        ),
    ),
}
