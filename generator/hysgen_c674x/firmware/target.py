"""The firmware for the C6748, compiled and linked by its gcc: sections, memories, bytes.

Interrupt and idle loop of the firmware on the simulated C674x: bits against the host, cycles by state.

The plant is the model itself with gains reduced by 3 %, read through a noisy sensor. A start runs through every state
up to tracking, with feedback and learning, and learned parameters are committed. Host and simulator get equal readings.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from hysgen.checking import Host
from hysgen.codegen import generate
from hysgen.errors import TargetError
from hysgen.firmware import CONTROLLER, EMPTY_STORE, SIMULATOR_BOARD, TARGET_BOARD, Sources, read_sources
from hysgen.firmware.wire import State
from hysgen.machine.native import build
from hysgen.model.model import Model
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import bounds, c_texts
from hysgen_c674x.toolchain import Firmware

MEMORIES: Final = {"L2 RAM": (0x11800000, 256 * 1024), "shared RAM": (0x80000000, 128 * 1024)}
"""Memories of the C6748 by name: first address, bytes."""


@dataclass(frozen=True)
class PlacedSection:
    """A section of the linked image: address, bytes, and the memory that holds it."""

    name: str
    address: int
    size: int
    memory: str


@dataclass(frozen=True)
class LinkedImage:
    """A linked image: its sections, and bytes of code by function."""

    model: str
    compiler: str
    firmware: Firmware
    sections: tuple[PlacedSection, ...]
    functions: Mapping[str, int]

    @property
    def used(self) -> dict[str, int]:
        """Bytes in use by memory."""
        total = dict.fromkeys(MEMORIES, 0)
        for section in self.sections:
            total[section.memory] += section.size
        return total

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "model": self.model,
            "compiler": self.compiler,
            "sections": [vars(section) for section in self.sections],
            "used": self.used,
            "functions": dict(self.functions),
        }


def link_image(name: str, texts: Mapping[str, str]) -> LinkedImage:
    """Compile controller, model and the C6748's board, warnings as errors, and link with the firmware's own script.

    texts: generated C and model.h by file name. Raises BuildError if there is no compiler or it reports an error.
    """
    sources = [*read_sources(CONTROLLER), *read_sources(TARGET_BOARD, "*.[chs]"), *c_texts(texts)]
    firmware = compile_placed(sources)
    sections = tuple(
        PlacedSection(each.name, each.address, each.size, _memory(each.address))
        for each in firmware.image.sections
        if each.size and each.address
    )
    functions = {s.name: s.size for s in firmware.image.symbols.values() if s.function and not s.name.startswith("__")}
    return LinkedImage(name, toolchain.version(), firmware, sections, functions)


def compile_placed(sources: Sources) -> Firmware:
    """Compile for the target and link by the firmware's script, which puts what runs in every period together.

    The settings and the key of the example count as filled in: nothing but the simulator runs the image.

    Raises BuildError as `toolchain.compile`.
    """
    script = dict(read_sources(TARGET_BOARD, "*.ld"))["c6748.ld"]
    return toolchain.compile(sources, ("-ffunction-sections", "-DMAIN_FILLED_IN"), script)


def _memory(address: int) -> str:
    return next(name for name, (start, size) in MEMORIES.items() if start <= address < start + size)


SAMPLES: Final = 12_000
WEAKER, NOISE_UM, SEED = 0.97, 2e-4, 1
REFERENCE_UM, AMPLITUDE_UM, STEP_RAD = 2.0, 0.6, 2 * np.pi * 50.0 * 20e-6

DECLARED: Final = """
uint32_t hysgen_simulated_boot(void);
float hysgen_simulated_interrupt(float, float);
uint32_t hysgen_simulated_idle(void);
uint32_t hysgen_simulated_state(void);
"""


@dataclass(frozen=True)
class SimulatedRun:
    """A run of the firmware on the simulator.

    differing: samples whose voltage, status, state or number of commits differs from the host's.
    selftest: mismatches of the self-test. interrupt: fewest and most cycles of the interrupt, by state at its end.
    idle: fewest and most cycles of the idle loop, one call of the model's commit included. boot: cycles with self-test.
    """

    samples: int
    differing: int
    selftest: int
    commits: int
    interrupt: Mapping[str, tuple[int, int]]
    idle: tuple[int, int]
    boot: int

    @property
    def equal(self) -> bool:
        """Whether all bits equal the host's and the self-test passes."""
        return self.differing == 0 and self.selftest == 0

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return vars(self) | {"interrupt": dict(self.interrupt), "equal": self.equal}


def compile_image(texts: Mapping[str, str]) -> Firmware:
    """Compile controller, generated `texts` and the simulator's board for the C674x.

    Raises BuildError without the compiler.
    """
    return compile_placed(_sources(texts))


def simulate(model: Model, texts: Mapping[str, str], compiled: Firmware, samples: int = SAMPLES) -> SimulatedRun:
    """Run the firmware of the model's `texts` on the host and, as `compile_image` compiled it, on the simulator.

    Raises BuildError without a compiler for the host, TargetError for code that the simulator does not support.
    """
    machine = compiled.machine()
    host = build(_sources(texts), DECLARED, libraries=()).lib
    booted = machine.call("hysgen_simulated_boot")
    host.hysgen_simulated_boot()
    stage, state_of_stage = virtual_stage(model)
    rng = np.random.default_rng(SEED)
    y_um, differing, commits = model.grid.y_min_um, 0, 0
    spent: dict[str, tuple[int, int]] = {}
    idle = (1 << 62, 0)
    for k in range(samples):
        reading = np.float32(y_um + NOISE_UM * rng.standard_normal())
        wanted = np.float32(REFERENCE_UM + AMPLITUDE_UM * np.sin(STEP_RAD * k))
        u_V = np.float32(host.hysgen_simulated_interrupt(reading, wanted))
        outcome = machine.call("hysgen_simulated_interrupt", reading, wanted)
        status, at_idle = host.hysgen_simulated_idle(), machine.call("hysgen_simulated_idle")
        state, at_state = host.hysgen_simulated_state(), machine.call("hysgen_simulated_state").bits
        same = (int(u_V.view(np.uint32)), status, state) == (outcome.bits, at_idle.bits, at_state)
        differing += not same
        commits = state >> 8
        name = State(state & 0xFF).name
        least, most = spent.get(name, (1 << 62, 0))
        spent[name] = (min(least, outcome.cycles), max(most, outcome.cycles))
        idle = (min(idle[0], at_idle.cycles), max(idle[1], at_idle.cycles))
        y_um = stage.call("simulate", state_of_stage, float(u_V))
    return SimulatedRun(samples, differing, booted.bits, commits, spent, idle, booted.cycles)


def static_bounds(name: str, compiled: Firmware) -> dict[str, tuple[int, int] | None]:
    """Fewest and most stall-free cycles over all paths through each function, calls included, from the listing.

    None for a function with an instruction that is not modelled.
    """
    decoded = compiled.packets
    cycles: dict[str, tuple[int, int] | None] = {}
    for symbol in (
        "hysgen_firmware_interrupt",
        *(f"{name}_{called}" for called in ("inverse", "learn_init", "learn", "commit")),
    ):
        try:
            bound = bounds(compiled.image, decoded, symbol)
        except TargetError:
            cycles[symbol] = None
        else:
            cycles[symbol] = (bound.best, bound.worst)
    return cycles


def virtual_stage(model: Model) -> tuple[Host, Any]:
    """The plant, which is the model with gains WEAKER times as large, and its state."""
    weaker = replace(model, consequents=model.consequents * [1.0, WEAKER, 1.0], learner=None)
    stage = Host(model.name, generate(weaker))
    return stage, stage.instance(model.grid.y_min_um, model.u_min_V)


def _sources(texts: Mapping[str, str]) -> Sources:
    generated = c_texts(texts)
    return [*read_sources(CONTROLLER), *read_sources(SIMULATOR_BOARD), *read_sources(*EMPTY_STORE), *generated]
