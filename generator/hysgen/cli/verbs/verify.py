"""Prove that generated C equals its NumPy reference, bit for bit.

Every compiler and optimisation level that is installed is compared, with and without flushing denormal numbers to zero,
over random, edge and long-run inputs; models of other structures are generated, compiled and compared beside it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.emit.manifest import read_folder
from hysgen.tables import table
from hysgen.target.generated import verify_on_target
from hysgen.verify import DEFAULT_SAMPLES, DEFAULT_STRUCTURES, verify

TARGET_SAMPLES = 4000


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")
    parser.add_argument(
        "--samples",
        type=int,
        default=None,
        help=f"in each build (default {DEFAULT_SAMPLES}; on the target {TARGET_SAMPLES} of each function)",
    )
    parser.add_argument(
        "--structures",
        type=int,
        default=DEFAULT_STRUCTURES,
        metavar="N",
        help="random models of other structures beside it (default %(default)s)",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the inputs and the random models (default %(default)s)")

    parser.add_argument(
        "--target",
        choices=("c674x",),
        help="run the C as its compiler makes it on the instruction-set simulator instead",
    )


def run(arguments: argparse.Namespace, console: Console) -> int:
    if arguments.target:
        return run_on_target(arguments, console)
    report = verify(
        Path(arguments.folder),
        samples=DEFAULT_SAMPLES if arguments.samples is None else arguments.samples,
        structures=arguments.structures,
        seed=arguments.seed,
        progress=console.progress,
    )
    console.say("\n".join(report.lines()))
    console.write_json(report.to_json())
    return 0 if report.equal else 1


def run_on_target(arguments: argparse.Namespace, console: Console) -> int:
    """Bits of the simulated target against the host's."""
    generated = read_folder(Path(arguments.folder))
    samples = TARGET_SAMPLES if arguments.samples is None else arguments.samples
    report = verify_on_target(generated.model, generated.texts, samples, arguments.seed, console.progress)
    console.say("\n".join([table(report.header(), report.rows()), *report.notes()]))
    console.write_json(report.to_json())
    return 0 if report.equal else 1
