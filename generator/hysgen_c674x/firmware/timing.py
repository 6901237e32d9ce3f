"""Time from reading to voltage of the firmware on the simulated C674x, and the cache lines of an interrupt.

The plant is the model itself; one start up to tracking a sine. Without the idle loop nothing is committed, so the
voltages with and without the learner are equal, and so must be the cycles from reading the A/D to writing the D/A.

Sizes and cycles of the firmware's image on the C6748, for `hysgen firmware`.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hysgen.display import table
from hysgen.errors import TargetError
from hysgen.firmware.wire import State
from hysgen.model.model import Model
from hysgen_c674x.caches import Caches, Misses
from hysgen_c674x.firmware.target import (
    AMPLITUDE_UM,
    MEMORIES,
    REFERENCE_UM,
    STEP_RAD,
    LinkedImage,
    SimulatedRun,
    compile_image,
    link_image,
    simulate,
    static_bounds,
    virtual_stage,
)
from hysgen_c674x.machine import Machine
from hysgen_c674x.processor import AccessKind, Trace
from hysgen_c674x.toolchain import Firmware

LOOP, LEARN = 1, 2
TRACKED: Final = 400
"""Samples in TRACK: one period of the sine."""
CACHED: Final = 25
"""Samples of them, the last ones, whose accesses run through the model of the caches."""
MOST: Final = 5000
"""Samples until TRACK."""
CYCLES_A_LINE: Final = (6, 12)
"""Cycles that the table charges for a missed line. Lines of straight code that follow each other cost less on silicon,
where fetches overlap (SPRUG82, L1P miss pipelining)."""


_LEFT: Final = tuple(f"left at {cycles}" for cycles in CYCLES_A_LINE)


@dataclass(frozen=True)
class Timing:
    """Of the interrupts in TRACK.

    delay: cycles from the call that reads the A/D to the call that writes the D/A, (TRACKED,). total: cycles of the
    whole interrupt, as delay. cold: lines missed with both caches empty, at the interrupt that misses most. warm: the
    same with the caches as the interrupt before, and the idle loop if it ran, left them.
    """

    delay: tuple[int, ...]
    total: tuple[int, ...]
    cold: Misses
    warm: Misses

    def left(self, budget: int, cycles_a_line: int, misses: Misses) -> int:
        """Cycles of a period of `budget` that the longest interrupt leaves if it misses so many lines."""
        return budget - max(self.total) - cycles_a_line * misses.lines

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "delay": [min(self.delay), max(self.delay)],
            "total": [min(self.total), max(self.total)],
            "cold": [self.cold.program, self.cold.data],
            "warm": [self.warm.program, self.warm.data],
        }


def timings(model: Model, compiled: Firmware) -> dict[str, Timing]:
    """Timing by what runs. With the idle loop the learner's parameters are committed, and voltages differ."""
    return {
        "loop": tracked(model, compiled.machine(), LOOP),
        "loop, learner": tracked(model, compiled.machine(), LOOP | LEARN),
        "loop, learner, idle loop": tracked(model, compiled.machine(), LOOP | LEARN, idle=True),
    }


def tracked(model: Model, machine: Machine, options: int, idle: bool = False) -> Timing:
    """Start with the SETTINGS_ bits `options` and trace TRACKED samples in TRACK.

    idle: call the idle loop after each interrupt. Raises TargetError if TRACK is not reached in MOST samples.
    """
    caches = Caches(machine.packets)
    delay, total, cold, warm = [], [], [], []
    for period in periods(model, machine, options, idle):
        called = (f"hysgen_board_{each}" for each in ("displacement_um", "voltage"))
        reads, writes = (_called(machine, period.interrupt, name) for name in called)
        delay.append(writes - reads)
        total.append(period.cycles)
        if len(delay) > TRACKED - CACHED:
            cold.append(Caches(machine.packets).run(period.interrupt))
            warm.append(caches.run(period.interrupt))
            caches.run(period.idle)
    most = max(cold, key=lambda each: each.lines), max(warm[1:], key=lambda each: each.lines)
    return Timing(tuple(delay), tuple(total), *most)


@dataclass(frozen=True)
class Period:
    """Accesses of an interrupt in TRACK and of the idle loop behind it, and the cycles of the interrupt."""

    interrupt: Trace
    idle: Trace
    cycles: int


def periods(model: Model, machine: Machine, options: int, idle: bool) -> Iterator[Period]:
    """TRACKED periods in TRACK, behind a start; arguments and errors of `tracked`."""
    machine.call("hysgen_simulated_options", options)
    machine.call("hysgen_simulated_boot")
    stage, state = virtual_stage(model)
    y_um, found, tracks = model.grid.y_min_um, 0, False
    for k in range(MOST):
        reading, wanted = np.float32(y_um), np.float32(REFERENCE_UM + AMPLITUDE_UM * np.sin(STEP_RAD * k))
        outcome, trace = machine.trace("hysgen_simulated_interrupt", reading, wanted)
        after = machine.trace("hysgen_simulated_idle")[1] if idle else Trace()
        if tracks:
            yield Period(trace, after, outcome.cycles)
            found += 1
        if found == TRACKED:
            return
        tracks = tracks or machine.call("hysgen_simulated_state").bits & 0xFF == State.TRACK
        y_um = stage.call("simulate", state, outcome.float32)
    raise TargetError(f"{model.name}: not in TRACK for {TRACKED} of {MOST} samples")


def _called(machine: Machine, trace: Trace, function: str) -> int:
    """Cycle of the first packet of `function` in a trace."""
    first = np.uint64(AccessKind.FETCH << 32 | machine.address(function))
    found = np.flatnonzero(trace.words[: trace.count] & np.uint64((1 << 34) - 1) == first)
    if not found.size:
        raise TargetError(f"{function}: not called")
    return int(trace.words[found[0]] >> np.uint64(34))


def timing_rows(found: Mapping[str, Timing], budget: int) -> list[list[str]]:
    """Rows of the table under TIMING_HEADS."""
    return [
        [
            name,
            f"{min(each.delay)} .. {max(each.delay)}",
            str(max(each.total)),
            *(
                text
                for misses in (each.warm, each.cold)
                for text in (
                    f"{misses.program} + {misses.data}",
                    *(str(each.left(budget, cycles, misses)) for cycles in CYCLES_A_LINE),
                )
            ),
        ]
        for name, each in found.items()
    ]


TIMING_HEADS: Final = ("in TRACK", "A/D to D/A", "interrupt", "warm lines", *_LEFT, "cold lines", *_LEFT)
"""Cycles; lines missed of L1P + L1D; cycles of the period that are left at so many cycles a line."""


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
