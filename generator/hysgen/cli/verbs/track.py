"""Run the complete firmware on the virtual stage through section 4.3 of the paper: tracking error by controller."""

from __future__ import annotations

import argparse

from hysgen.cli.console import Console
from hysgen.display import table
from hysgen.firmware.tracking import PAPER_NM, SECONDS, Tracked, track


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", type=float, default=SECONDS, metavar="S", help=f"of reference (default {SECONDS:g})"
    )


def run(arguments: argparse.Namespace, console: Console) -> int:
    results, noise_nm = track(arguments.seconds, console.progress)
    console.say(report(results, noise_nm))
    console.write_json({"sensor_noise_nm": noise_nm, "tracking": [result.to_json() for result in results]})
    return 0


def report(results: list[Tracked], noise_nm: float) -> str:
    """The table, and what it is measured against."""
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
