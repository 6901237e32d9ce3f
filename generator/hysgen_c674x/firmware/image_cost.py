"""Sizes and cycles of the firmware's image on the C6748, for `hysgen firmware`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from hysgen.display import table
from hysgen.errors import TargetError
from hysgen.model.model import Model
from hysgen_c674x.firmware.simulated import SimulatedRun, compile_image, simulate, static_bounds
from hysgen_c674x.firmware.target import MEMORIES, LinkedImage, link_image
from hysgen_c674x.firmware.timing import TIMING_HEADS, timing_rows, timings

BUDGET = 7500

Say = Callable[[str], None]


def image_cost(model: Model, texts: Mapping[str, str], samples: int, say: Say, warn: Say) -> dict[str, Any]:
    """Link the image and run it on the simulator, `samples` long; say the tables. Returns the result as JSON.

    Raises BuildError without the compiler.
    """
    built = link_image(model.name, texts)
    say(sections_table(built))
    compiled = compile_image(texts)
    cycles = static_bounds(model.name, compiled)
    rows = [[name, f"{c[0]} .. {c[1]}" if c else "not bounded"] for name, c in cycles.items()]
    say("\n" + table(["static bounds, stall-free", "cycles"], rows))
    result: dict[str, Any] = {"target": built.to_json(), "bounds": cycles, "simulated": None, "timing": None}
    try:
        run = simulate(model, texts, compiled, samples)
        say(cycles_table(run))
        result["simulated"] = run.to_json()
        timed = timings(model, compiled)
        say("\n" + table(TIMING_HEADS, timing_rows(timed, BUDGET)))
        result["timing"] = {name: case.to_json() for name, case in timed.items()}
    except TargetError as refusal:
        warn(f"cycles are missing: {refusal}")
    return result


def sections_table(built: LinkedImage) -> str:
    """Sections of the image, and bytes used of each memory."""
    sections = [[s.name, f"0x{s.address:08x}", s.memory, f"{s.size}"] for s in built.sections]
    used = [f"{name}: {size} of {MEMORIES[name][1]} bytes" for name, size in built.used.items()]
    return "\n".join([table(["section", "address", "memory", "bytes"], sections, left=3), *used, built.compiler])


def cycles_table(run: SimulatedRun) -> str:
    """Cycles by state of the firmware, and whether the simulator gives the bits of the host."""
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
