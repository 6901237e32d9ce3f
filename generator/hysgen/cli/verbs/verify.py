"""Prove that generated C equals its NumPy reference, bit for bit.

Every compiler and optimisation level that is installed is compared, with and without flushing denormal numbers to zero,
over random, edge and long-run inputs; models of other structures are generated, compiled and compared beside it. With
--target the C runs elsewhere: on the simulated C674x, or under qemu on other processors, both orders of bytes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.c674x.cost import cost_of_texts
from hysgen.c674x.generated import verify_on_target
from hysgen.checking.bits import DEFAULT_SAMPLES, DEFAULT_STRUCTURES, verify
from hysgen.checking.proof.emulated.contraction import contraction, contraction_rows
from hysgen.checking.proof.emulated.equality import LEARNING_SHARE, equality
from hysgen.checking.proof.emulated.machines import MACHINES, Machine
from hysgen.cli.console import Console
from hysgen.codegen.manifest import read_folder
from hysgen.display import table
from hysgen.errors import HysgenError
from hysgen.machine.files import write_whole
from hysgen.report.model import folder_page

TARGET_SAMPLES = 4000
EMULATED_SAMPLES = 20_000


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="folder that `hysgen generate` wrote")
    parser.add_argument(
        "--samples",
        type=int,
        default=None,
        help=f"in each build (default {DEFAULT_SAMPLES}); with --target, of each function (default {TARGET_SAMPLES} on "
        f"the c674x, {EMULATED_SAMPLES} emulated, there {LEARNING_SHARE:g} of them for learning)",
    )
    parser.add_argument(
        "--structures",
        type=int,
        default=DEFAULT_STRUCTURES,
        metavar="N",
        help="random models of other structures beside it (default %(default)s)",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the inputs and the random models (default %(default)s)")
    parser.add_argument("--report", metavar="FILE.html", help="write the result as one page that needs no other file")
    parser.add_argument(
        "--target",
        choices=("c674x", "emulated"),
        help="c674x: run the C as its compiler makes it on the instruction-set simulator instead; emulated: on other "
        "processors under qemu, every one whose compiler is installed",
    )
    parser.add_argument(
        "--machine",
        choices=[machine.name for machine in MACHINES],
        action="append",
        help="with --target emulated: this processor only (may be repeated)",
    )
    parser.add_argument(
        "--fused",
        action="store_true",
        help="with --target emulated: tell every compiler to fuse multiplications with additions, once with the guard "
        "of the generated C and once without it, and say what becomes of the bits",
    )


def run(arguments: argparse.Namespace, console: Console) -> int:
    if arguments.target == "emulated":
        return run_fused(arguments, console) if arguments.fused else run_emulated(arguments, console)
    if arguments.machine or arguments.fused:
        raise HysgenError("--machine and --fused: they belong to --target emulated; add it")
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
    if arguments.report:
        folder = read_folder(Path(arguments.folder))
        price = cost_of_texts(folder.model, folder.texts, timed=False)
        write_whole(Path(arguments.report), folder_page(folder.model, report, price).html())
        console.say(f"written: {arguments.report}")
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


def run_emulated(arguments: argparse.Namespace, console: Console) -> int:
    """Bits of other processors against the reference's."""
    generated = read_folder(Path(arguments.folder))
    report = equality(
        generated.model,
        generated.texts,
        samples=EMULATED_SAMPLES if arguments.samples is None else arguments.samples,
        machines=chosen(arguments.machine),
        seed=arguments.seed,
        progress=console.progress,
    )
    console.say("\n".join(report.lines()))
    console.write_json(report.to_json())
    return 0 if report.equal else 1


def run_fused(arguments: argparse.Namespace, console: Console) -> int:
    """What fusing does to the bits, with the guard and without it."""
    generated = read_folder(Path(arguments.folder))
    found = contraction(
        generated.model,
        generated.texts,
        samples=EMULATED_SAMPLES if arguments.samples is None else arguments.samples,
        machines=chosen(arguments.machine),
        progress=console.progress,
    )
    header, rows = contraction_rows(found)
    console.say(table(header, rows, left=3))
    console.write_json({"fused": [row.to_json() for row in found]})
    return 0 if found and all(row.differing == 0 and row.selftest == 0 for row in found if row.guarded) else 1


def chosen(names: list[str] | None) -> list[Machine]:
    """The machines of these names; all of them if none is named."""
    return [machine for machine in MACHINES if names is None or machine.name in names]
