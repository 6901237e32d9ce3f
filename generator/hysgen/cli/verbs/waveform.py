"""simulate: the displacement under a voltage; waveform: the voltage for a displacement; loop: feedback around it."""

import argparse
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hysgen.api.models import design_loop, simulate, waveform
from hysgen.cli.console import Console
from hysgen.cli.options import add_model, says_reading
from hysgen.cli.verbs import Output, Verb
from hysgen.cli.verbs.generate import usable_model
from hysgen.display import WRITTEN_IN, Displayed
from hysgen.errors import HysgenError
from hysgen.feedback.stage import LATENCY, Uncertainty
from hysgen.machine.files import write_whole
from hysgen.model.file import load_model, save_model
from hysgen.record.csv_text import write_csv
from hysgen.trajectory.reference import FORMS, Form

SIMULATE_HELP = """\
The displacement of a model under the voltages of a file, from rest under the first of them."""
SIMULATE_EXAMPLE = "hysgen simulate stage.json voltage.csv -o displacement.csv"
WAVEFORM_HELP = """\
The voltage that takes a stage along a displacement: by the exact inverse of the model, inside the limits of voltage,
slew and acceleration. What cannot be reached is said, and made with the least largest error.

REFERENCE is a file with time_s,displacement_um of any rate and format, or the name of a form: constant, sine, triangle,
scan (with flyback), steps. With --learn, the voltage for the next repeat, from the records of the repeats so far."""

Floats = NDArray[np.float64]

WRITES = {"output": Output("-o", (".csv",))}


def _output(parser: argparse.ArgumentParser, columns: str) -> None:
    parser.add_argument("-o", "--output", metavar="FILE.csv", help=f"write {columns} at the rate of the model")
    parser.add_argument("--columns", metavar="KEY=VALUE,...", default="", help="names and units of the file's columns")
    parser.add_argument("--plot", metavar="FILE.png", help="draw voltage, displacement and error")


def simulate_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)
    parser.add_argument("record", metavar="VOLTAGE", help="file with time_s,voltage_V, of any rate and format")
    _output(parser, "time_s,displacement_um")


def waveform_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)
    parser.add_argument("record", metavar="REFERENCE", help=f"file with time_s,displacement_um, or {', '.join(FORMS)}")
    _output(parser, "time_s,voltage_V")
    form = Form()
    parser.add_argument("--amplitude", type=float, metavar="UM", help="of a form: half of its stroke")
    parser.add_argument("--centre", type=float, metavar="UM", help="of a form (default: middle of the model's range)")
    parser.add_argument(
        "--frequency", type=float, default=form.f_Hz, metavar="HZ", help="of a form (default %(default)g)"
    )
    parser.add_argument(
        "--periods", type=float, default=form.periods, metavar="N", help="of a form (default %(default)g)"
    )
    parser.add_argument(
        "--learn",
        nargs="+",
        default=[],
        metavar="PLAYED",
        help="records of the repeats so far, oldest first (time_s,voltage_V,displacement_um): the voltage of the next",
    )
    parser.add_argument(
        "--loop", action="store_true", help="begin with the whole range of the voltage, which wipes out the past"
    )
    parser.add_argument(
        "--periodic", action="store_true", help="one period of the steady state, to be played in a loop"
    )
    parser.add_argument(
        "--voltage", nargs=2, type=float, metavar=("LOW", "HIGH"), help="limits in V, inside the model's"
    )
    parser.add_argument("--slew", type=float, metavar="V_S", help="largest |du/dt| in V/s")
    parser.add_argument("--acceleration", type=float, metavar="V_S2", help="largest |d2u/dt2| in V/s^2")


def run_simulate(arguments: argparse.Namespace, console: Console) -> int:
    says_reading([Path(arguments.record)], console)
    answer = simulate(load_model(arguments.model), arguments.record, arguments.columns)
    console.say(answer.one_line())
    _write(arguments, answer.time_s, {answer.quantities.columns[1]: answer.y_um}, answer, console)
    ends = {"voltage_V": list(answer.u_range_V), "displacement_um": list(answer.y_range_um)}
    return console.finish({"source": answer.source, "samples": answer.samples, "Ts_s": answer.Ts_s, **ends})


def run_waveform(arguments: argparse.Namespace, console: Console) -> int:
    model = usable_model(arguments)
    says_reading([Path(arguments.record or "")], console)
    periods = 1.0 if arguments.periodic else arguments.periods
    form = Form(arguments.amplitude, arguments.centre, arguments.frequency, periods)
    plan = waveform(
        model,
        arguments.record,
        form,
        columns=arguments.columns,
        voltage_V=arguments.voltage,
        slew_V_s=arguments.slew,
        acceleration_V_s2=arguments.acceleration,
        periodic=arguments.periodic,
        loop=arguments.loop,
        plays=arguments.learn,
    )
    console.say(str(plan))
    _write(arguments, plan.time_s, {WRITTEN_IN.get().columns[0]: plan.u_V}, plan, console)
    return console.finish(plan.to_json(), plan.holds)


def _write(
    arguments: argparse.Namespace, time_s: Floats, column: Mapping[str, Floats], result: Displayed, console: Console
) -> None:
    """Write the file and the picture that the call names."""
    if arguments.output:
        columns = {"time_s": time_s, **column}
        write_whole(Path(arguments.output), write_csv({name: values.tolist() for name, values in columns.items()}))
        console.say(f"written: {arguments.output}")
    if arguments.plot:
        result.plot().save(arguments.plot)
        console.say(f"written: {arguments.plot}")


LOOP_HELP = """\
Design a feedback loop around the inverse of a model: an integral and notches of the largest bandwidth with margins of 6
dB and 45 degrees over the uncertainty of the model, and its certificate. Exit code 1 says that it does not hold.

The correction is added to the displacement that the inverse is asked for, so the inverse is the feed-forward."""


def loop_arguments(parser: argparse.ArgumentParser) -> None:
    add_model(parser)
    known = ",".join(f"{name}={value:g}" for name, value in asdict(Uncertainty()).items())
    parser.add_argument(
        "--latency",
        type=float,
        default=LATENCY,
        metavar="SAMPLES",
        help="from reading to voltage, where the record of the model does not hold it (default %(default)g)",
    )
    parser.add_argument(
        "--uncertainty",
        default="",
        metavar="KEY=VALUE,...",
        help=f"what the stage may differ by, relative; late in samples (default {known})",
    )
    parser.add_argument("-o", "--output", metavar="NEW.json", help="write the model with the loop, of which C is made")
    parser.add_argument("--plot", metavar="FILE.png", help="draw the open loop (Bode) and the settling of a push")


def run_loop(arguments: argparse.Namespace, console: Console) -> int:
    parts = [part.partition("=") for part in filter(None, arguments.uncertainty.split(","))]
    try:
        changes = {key.strip(): float(value) for key, _, value in parts}
    except ValueError as fault:
        raise HysgenError(f"--uncertainty: {fault}; write KEY=VALUE, as frequency=0.02,gain=0.1") from fault
    model = usable_model(arguments)
    designed = design_loop(model, arguments.latency, **changes)
    console.say(str(designed))
    if arguments.output:
        save_model(designed.around(model), Path(arguments.output))
        console.say(f"written: {arguments.output}")
    if arguments.plot:
        designed.plot().save(arguments.plot)
        console.say(f"written: {arguments.plot}")
    return console.finish(designed.to_json(), designed.certificate.holds)


VERBS = {
    "simulate": Verb(SIMULATE_HELP, simulate_arguments, run_simulate, WRITES, (SIMULATE_EXAMPLE,)),
    "waveform": Verb(
        WAVEFORM_HELP,
        waveform_arguments,
        run_waveform,
        WRITES,
        (
            "hysgen waveform stage.json reference.csv -o voltage.csv --slew 20000",
            "hysgen waveform stage.json reference.csv --loop --learn played1.csv -o voltage2.csv    the next repeat",
            "hysgen waveform stage.json scan --frequency 50 --periodic -o voltage.csv    one period, to be looped",
        ),
    ),
    "loop": Verb(
        LOOP_HELP,
        loop_arguments,
        run_loop,
        {"output": Output("-o", (".json",))},
        (
            "hysgen loop stage.json -o looped.json --json loop.json --plot loop.png",
            "hysgen loop stage.json --latency 2 --uncertainty frequency=0.03    a stage whose load changes",
        ),
    ),
}
