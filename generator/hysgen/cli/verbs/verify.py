"""Prove that generated C equals its NumPy reference, bit for bit.

Every compiler and optimisation level that is installed is compared, with and without flushing denormal numbers to zero,
over random, edge and long-run inputs; models of other structures are generated, compiled and compared beside it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.verify import DEFAULT_SAMPLES, DEFAULT_STRUCTURES, verify


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")
    parser.add_argument("--samples", type=int, default=DEFAULT_SAMPLES, help="in each build (default %(default)s)")
    parser.add_argument(
        "--structures",
        type=int,
        default=DEFAULT_STRUCTURES,
        metavar="N",
        help="random models of other structures beside it (default %(default)s)",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the inputs and the random models (default %(default)s)")


def run(arguments: argparse.Namespace, console: Console) -> int:
    report = verify(
        Path(arguments.folder),
        samples=arguments.samples,
        structures=arguments.structures,
        seed=arguments.seed,
        progress=console.progress,
    )
    console.say("\n".join(report.lines()))
    console.write_json(report.to_json())
    return 0 if report.equal else 1
