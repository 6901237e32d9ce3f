"""Interrupt and idle loop of the firmware on the simulated C674x: bits against the host, cycles by state.

The plant is the model itself with gains reduced by 3 %, read through a noisy sensor. A start runs through every state
up to tracking, with feedback and learning, and learned parameters are committed. Host and simulator get equal readings.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from hysgen.checking.host import Host
from hysgen.codegen import generate
from hysgen.errors import TargetError
from hysgen.firmware.binding import CONTROLLER, EMPTY_STORE, SIMULATOR_BOARD, Sources, read_sources
from hysgen.firmware.host import State
from hysgen.machine.native import build
from hysgen.model.model import Model
from hysgen_c674x.cycles import bounds
from hysgen_c674x.firmware.target import compile_placed
from hysgen_c674x.footprint import c_texts
from hysgen_c674x.toolchain import Firmware

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
