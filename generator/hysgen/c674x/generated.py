"""The generated C of a model on the C674x: what each function costs there, and whether its bits are the host's.

The host's bits are the reference's (`hysgen verify` proves that over far more samples than a simulator runs), so equal
bits here close the circle: reference, host and target. What is compared is every result and every word of the state.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.c674x import toolchain
from hysgen.c674x.assembly import instructions
from hysgen.c674x.cycles import CycleBounds, bounds
from hysgen.c674x.learning import SimulatedSide
from hysgen.c674x.machine import Machine
from hysgen.c674x.packets import packets
from hysgen.checking.bits.closed_loop import LEAST_UPDATES, Followed, HostSide, follow
from hysgen.checking.bits.functions import LEARNER, SUBJECTS, Subject
from hysgen.checking.bits.inputs import STYLES, chunks
from hysgen.checking.host import Host
from hysgen.codegen.operations import figures
from hysgen.model.model import Model

Words = NDArray[np.uint32]
Progress = Callable[[float, str], None]

PIECE: Final = 2048
LEARNING_SHARE: Final = 0.1
"""Part of the samples that learning gets: its state is some hundred words, each of them compared after every sample."""
FOLLOWED: Final = "a weaker stage"


@dataclass(frozen=True)
class TargetRun:
    """One function under one style of inputs: samples, words compared per sample, samples that differ, cycles.

    first: what differs first, in words, or None.
    """

    function: str
    style: str
    samples: int
    words: int
    differing: int
    cycles: tuple[int, int]
    first: str | None


@dataclass(frozen=True)
class TargetReport:
    """All runs of a model on the simulated target; selftest: mismatches that its own self-test counted there.

    committed: shadows that became active on the way, which the target's own memory showed as a change of the bank in
    use; refused: those that commit did not accept. None for a model that does not learn.
    """

    model: str
    compiler: str
    selftest: int
    runs: tuple[TargetRun, ...]
    committed: int | None
    refused: int | None

    @property
    def equal(self) -> bool:
        """Every bit of every run, and the self-test."""
        return self.selftest == 0 and all(run.differing == 0 for run in self.runs)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"equal": self.equal}

    def header(self) -> list[str]:
        """Column heads of `rows`."""
        return ["function", "inputs", "samples", "words each", "samples differ", "cycles"]

    def rows(self) -> list[list[str]]:
        """One row of cells per run."""
        return [
            [
                run.function,
                run.style,
                f"{run.samples}",
                f"{run.words}",
                f"{run.differing}",
                f"{run.cycles[0]}" if run.cycles[0] == run.cycles[1] else f"{run.cycles[0]} .. {run.cycles[1]}",
            ]
            for run in self.runs
        ]

    def notes(self) -> list[str]:
        """What stands below the table."""
        verdict = "equal to the host in every bit" if self.equal else "NOT EQUAL"
        differences = [f"DIFFERENT: {run.function}, {run.style}: {run.first}" for run in self.runs if run.first]
        learned = []
        if self.committed is not None:
            none = "" if self.committed else ": NOTHING WAS COMMITTED"
            learned = [f"shadows that became active: {self.committed}, refused: {self.refused}{none}"]
        return [
            *differences,
            *learned,
            f"{self.model} on the C674x, simulated: {verdict}; self-test: {self.selftest} mismatches ({self.compiler})",
            "cycles are stall-free: caches, memory banks and interrupts are not modelled, and nothing ran on silicon",
        ]


def c_texts(texts: Mapping[str, str]) -> list[tuple[str, str]]:
    """The C among the generated files."""
    return [(file, text) for file, text in texts.items() if file.endswith((".c", ".h"))]


def cycles(name: str, texts: Mapping[str, str]) -> dict[str, CycleBounds]:
    """Stall-free cycles of each public function, by its name without the model's.

    Raises BuildError without the toolchain, TargetError if a function's cycles cannot be bounded.
    """
    return cycles_of(name, texts, toolchain.compile(c_texts(texts)))


def cycles_of(name: str, texts: Mapping[str, str], firmware: toolchain.Firmware) -> dict[str, CycleBounds]:
    """`cycles` of what is compiled already."""
    found = packets(instructions(firmware.listing))
    return {
        function: bounds(firmware.image, found, f"{name}_{function}") for function in figures(name, texts).operations
    }


def verify_on_target(
    model: Model, texts: Mapping[str, str], samples: int, seed: int = 1, progress: Progress | None = None
) -> TargetReport:
    """Run every function of the generated C over chained samples of every style, on the simulator and on the host.

    samples: of each function, shared by the styles; a tenth of them for learning, and so many updates, or more,
    of a learner that follows a stage and commits now and then.
    Raises BuildError without a toolchain, TargetError for what the simulator refuses.
    """
    firmware = toolchain.compile(c_texts(texts))
    host, machine = Host(model.name, texts), firmware.machine()
    failed = machine.call(f"{model.name}_selftest").bits if host.selftested else 0
    todo = [
        (subject, function, style)
        for subject in SUBJECTS
        for function in subject.functions
        if function in host.entries and function != "init"
        for style in STYLES
    ]
    runs: list[TargetRun] = []
    steps = len(todo) + 1
    for subject, function, style in todo:
        if progress is not None:
            progress(len(runs) / steps, f"{function}, {style} inputs, on the simulator")
        share = LEARNING_SHARE if function == "learn" else 1.0
        count = math.ceil(share * samples / len(STYLES))
        runs.append(_run(model, host, machine, subject, function, style, count, seed))
    committed = refused = None
    if model.learner is not None:
        if progress is not None:
            progress(len(runs) / steps, "learn and commit, on the simulator")
        updates = max(LEAST_UPDATES, math.ceil(LEARNING_SHARE * samples))
        following, told = _followed(model, host, machine, updates, seed)
        runs += following
        committed, refused = told.switches, sum(told.answers.values()) - told.committed
    return TargetReport(model.name, toolchain.version(), failed, tuple(runs), committed, refused)


def _followed(model: Model, host: Host, machine: Machine, updates: int, seed: int) -> tuple[list[TargetRun], Followed]:
    """Learning from a stage that is not quite the model, and commits; every word of both structs after every call."""
    side = SimulatedSide(host, machine)
    _, told = follow(model, [HostSide("this machine", host), side], host, updates, seed)
    words = side.words().size
    learner = host.words_of(LEARNER.start(host)).size
    where = told.first
    return [
        TargetRun("learn", FOLLOWED, told.samples, learner, told.learnt_wrong, side.learning.range, where),
        TargetRun("commit", FOLLOWED, told.calls, words + 1, told.committed_wrong, side.committing.range, where),
    ], told


def _run(
    model: Model, host: Host, machine: Machine, subject: Subject, function: str, style: str, samples: int, seed: int
) -> TargetRun:
    struct = subject.start(host)
    size = host.words_of(struct).size
    address = machine.allocate(size)
    machine.write(address, host.words_of(struct).copy())
    arguments = list(subject.functions[function])
    heard = ["channel"] * host.channels if subject.listens else []
    returns = host.entries[function].result != "void"
    differing, first, done, least, most = 0, None, 0, 1 << 62, 0
    for columns in chunks(model, style, [*arguments, *heard], samples, seed, PIECE):
        bits, after = host.run(function, struct, columns, first=0, words=size)
        got, memory, spent = _stepped(machine, host, function, address, size, columns, len(arguments))
        wrong = (memory != after).any(axis=1) | ((got != bits) & returns)
        if first is None and wrong.any():
            first = _told(host, subject, int(np.argmax(wrong)), done, bits, got, after, memory)
        differing += int(np.count_nonzero(wrong))
        done += bits.size
        least, most = min(least, int(spent.min())), max(most, int(spent.max()))
    return TargetRun(function, style, done, size + int(returns), differing, (least, most), first)


def _stepped(
    machine: Machine, host: Host, function: str, address: int, size: int, columns: Sequence[Words], count: int
) -> tuple[Words, Words, NDArray[np.int64]]:
    """Results, states and cycles of chained calls on the machine; auxiliary channels are given before each call."""
    symbol = f"{host.name}_{function}"
    if len(columns) == count:
        told = machine.map(symbol, address, *columns, read={address: size})
        return told.bits, told.memory[address], told.cycles
    samples, place = columns[0].size, machine.allocate(len(columns) - count)
    bits, memory = np.empty(samples, np.uint32), np.empty((samples, size), np.uint32)
    spent = np.empty(samples, np.int64)
    for k in range(samples):
        machine.write(place, np.array([column[k] for column in columns[count:]], dtype=np.uint32))
        machine.call(f"{host.name}_aux", address, place)
        outcome = machine.call(symbol, address, *(column[k].view(np.float32) for column in columns[:count]))
        bits[k], memory[k], spent[k] = outcome.bits, machine.read(address, size, np.uint32), outcome.cycles
    return bits, memory, spent


def _told(host: Host, subject: Subject, k: int, done: int, bits: Words, got: Words, after: Words, memory: Words) -> str:
    """The first difference in words."""
    places = np.flatnonzero(memory[k] != after[k])
    if places.size == 0:
        return f"sample {done + k}: result is 0x{got[k]:08x}, the host's is 0x{bits[k]:08x}"
    layout = host.layout(f"{host.name}_{subject.struct}")
    path = next(name for name, place in layout.items() if place == places[0])
    return f"sample {done + k}: {path} is 0x{memory[k][places[0]]:08x}, the host's is 0x{after[k][places[0]]:08x}"
