"""Write what the firmware needs of a model (its C and model.h), and say what the image costs on the C6748.

The firmware itself, which calls it, is in firmware/ of the sources; docs/firmware.md says how to put both together."""

from __future__ import annotations

import argparse
from pathlib import Path

from hysgen.cli.console import Console
from hysgen.codegen import write
from hysgen.display import table
from hysgen.errors import BuildError, TargetError
from hysgen.firmware.binding import firmware_model
from hysgen.firmware.reference_models import with_learner
from hysgen.firmware.simulated import SAMPLES, Simulated, image, simulate, static_bounds
from hysgen.firmware.target import MEMORIES, Built, build
from hysgen.model.file import load_model

BUDGET = 7500


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="model file, or a shipped one: appendix_a, extended")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for its C and model.h")
    parser.add_argument(
        "--samples", type=int, default=SAMPLES, metavar="N", help="on the simulator (default %(default)s)"
    )


def run(arguments: argparse.Namespace, console: Console) -> int:
    model = load_model(arguments.model)
    if model.learner is None:
        model = with_learner(model)
        console.say(f"{model.name}: no learner settings in the file; one of all parameters is added")
    texts = firmware_model(model)
    if arguments.output:
        write(texts, Path(arguments.output))
        console.say(f"written: {len(texts)} files in {arguments.output}")
    try:
        built = build(model.name, texts)
    except BuildError as refusal:
        console.warn(f"sizes and cycles are missing: {refusal}")
        console.write_json({"model": model.name, "target": None})
        return 0
    console.say(report(built))
    compiled = image(texts)
    cycles = static_bounds(model.name, compiled)
    rows = [[name, f"{c[0]} .. {c[1]}" if c else "not bounded"] for name, c in cycles.items()]
    console.say("\n" + table(["static bounds, stall-free", "cycles"], rows))
    found: dict[str, object] = {"model": model.name, "target": built.to_json(), "bounds": cycles, "simulated": None}
    try:
        run = simulate(model, texts, compiled, arguments.samples)
        console.say(cycles_report(run))
        found["simulated"] = run.to_json()
    except TargetError as refusal:
        console.warn(f"cycles are missing: {refusal}")
    console.write_json(found)
    return 0


def report(built: Built) -> str:
    """Sections and memories."""
    sections = [[s.name, f"0x{s.address:08x}", s.memory, f"{s.size}"] for s in built.sections]
    used = [f"{name}: {size} of {MEMORIES[name][1]} bytes" for name, size in built.used.items()]
    return "\n".join([table(["section", "address", "memory", "bytes"], sections, left=3), *used, built.compiler])


def cycles_report(run: Simulated) -> str:
    """Cycles by state, and whether the bits are the host's."""
    named = {f"interrupt, {state}": cycles for state, cycles in run.interrupt.items()} | {"idle loop": run.idle}
    rows = [[name, f"{best} .. {worst}", f"{100 * worst / BUDGET:.1f} %"] for name, (best, worst) in named.items()]
    verdict = "the host's bits" if run.equal else f"NOT THE HOST'S BITS in {run.differing}"
    return "\n".join(
        [
            "",
            table(["on the simulator", "cycles", "of 7500"], rows),
            f"{run.samples} samples, {run.commits} commits: {verdict}; self-test at boot: {run.selftest} mismatches, "
            f"{run.boot} cycles",
            "stall-free cycles; nothing ran on silicon",
        ]
    )
