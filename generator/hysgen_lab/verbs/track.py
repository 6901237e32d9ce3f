"""track: the complete firmware on the virtual stage."""

from __future__ import annotations

import argparse

from hysgen.cli.console import Console
from hysgen.cli.verbs import Verb
from hysgen.display import table
from hysgen_lab.firmware.tracking import PAPER_NM, SECONDS, TrackingResult, track

TRACK_HELP = """\
Run the complete firmware on the virtual stage through section 4.3 of the paper: tracking error by controller."""


def track_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, metavar="S", help=f"of reference (default {SECONDS:g})"
    )


def run_track(arguments: argparse.Namespace, console: Console) -> int:
    results, noise_nm = track(arguments.seconds, console.progress)
    console.say(tracking_table(results, noise_nm))
    return console.finish({"sensor_noise_nm": noise_nm, "tracking": [vars(result) for result in results]})


def tracking_table(results: list[TrackingResult], noise_nm: float) -> str:
    """Tracking errors by controller, with the sensor's noise and the paper's errors below."""
    rows = [
        [
            f"{result.f_Hz:g} Hz, {result.controller}",
            f"{result.rms_nm:.2f}",
            f"{result.mean_nm:+.2f}",
            f"{result.spread_nm:.2f}",
            f"{result.last_nm:.2f}",
            f"{result.voltage_V[0]:.1f} .. {result.voltage_V[1]:.1f}",
            f"{result.commits}",
        ]
        for result in results
    ]
    header = ["reading minus reference", "rms nm", "mean nm", "spread nm", "last second nm", "voltage V", "commits"]
    paper = ", ".join(f"{nm:g} nm at {f_Hz:g} Hz" for f_Hz, nm in PAPER_NM.items())
    return table(header, rows) + f"\nsensor: {noise_nm:.2f} nm rms; the paper's own stage, by its inverse: {paper}"


VERBS = {"track": Verb(TRACK_HELP, track_arguments, run_track)}
