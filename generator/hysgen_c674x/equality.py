"""Equality of bits between the simulated C674x and the host, for every function of the generated C of a model.

`hysgen verify` proves the host's bits equal to the reference's over many more samples than the simulator can run. Equal
bits of host and simulator therefore extend the proof to the target. Every result and every word of the state is
compared.

A model's learner on the simulated C674x, as one side of `hysgen.checking.bits.learning_run`.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking import Host
from hysgen.checking.bits.comparison import Task, tasks
from hysgen.checking.bits.functions import LEARNER, LEARNING_SHARE, MODEL, STYLES, chunks
from hysgen.checking.bits.learning_run import LEAST_UPDATES, HostSide, LearningResult, compare_learning
from hysgen.display import table
from hysgen.model.model import Model
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import c_texts
from hysgen_c674x.machine import CallOutcomes, Machine

Words = NDArray[np.uint32]


class CycleRange:
    """Fewest and most cycles of all added calls."""

    def __init__(self) -> None:
        self.least, self.most = 1 << 62, 0

    def add(self, cycles: NDArray[np.int64]) -> None:
        self.least, self.most = min(self.least, int(cycles.min())), max(self.most, int(cycles.max()))

    @property
    def range(self) -> tuple[int, int]:
        return self.least, self.most


class SimulatedSide:
    """An instance and its learner in the memory of `machine`, with the host's initial states.

    learning, committing: cycles of the calls of learn and of commit.
    """

    name = "c674x"

    def __init__(self, host: Host, machine: Machine) -> None:
        self._machine, self._prefix, self._channels = machine, host.name, host.channels
        self.learning, self.committing = CycleRange(), CycleRange()
        starts = [host.words_of(MODEL.create(host)).copy(), host.words_of(LEARNER.create(host)).copy()]
        self._sizes = [start.size for start in starts]
        self._instance, self._learner = (machine.allocate(size) for size in self._sizes)
        machine.write(self._instance, starts[0])
        machine.write(self._learner, starts[1])

    def learn(self, y: Words, u: Words) -> Words:
        outcomes = self._map("learn", self._learner, y, u, self._sizes[1])
        self.learning.add(outcomes.cycles)
        return outcomes.memory[self._learner]

    def commit(self) -> int:
        outcome = self._machine.call(f"{self._prefix}_commit", self._instance, self._learner)
        self.committing.add(np.array([outcome.cycles]))
        return outcome.bits

    def predict(self, y: Words, u: Words) -> Words:
        bits = np.empty_like(y)
        channels = self._machine.allocate(self._channels) if self._channels else 0
        for k in range(y.size):
            if self._channels:
                self._machine.call(f"{self._prefix}_aux", self._instance, channels)
            bits[k] = self._map("predict", self._instance, y[k : k + 1], u[k : k + 1], 0).bits[0]
        return bits

    def words(self) -> Words:
        places = zip((self._instance, self._learner), self._sizes, strict=True)
        return np.concatenate([self._machine.read(place, size, np.uint32) for place, size in places])

    def _map(self, function: str, struct: int, y: Words, u: Words, words: int) -> CallOutcomes:
        columns = [column.view(np.float32) for column in (y, u)]
        return self._machine.map(f"{self._prefix}_{function}", struct, *columns, read={struct: words} if words else {})


Progress = Callable[[float, str], None]

CHUNK: Final = 2048
EQUAL: Final = "equal in every bit"
LEARNING_RUN: Final = "a weaker stage"
"""Input style, in reports, of the learning run."""


@dataclass(frozen=True)
class TargetRun:
    """One function under one input style.

    words: compared per sample. differing: samples that differ. cycles: fewest and most. first: the first difference in
    words, or None.
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
    """All runs of a model on the simulated target.

    selftest: mismatches counted by the generated self-test there. committed: changes of the active bank in the target's
    own memory; refused: shadows that commit did not accept; both None for a model without a learner. reference: the
    host's learner against the NumPy reference in the same updates, None without a learner.
    """

    model: str
    compiler: str
    selftest: int
    runs: tuple[TargetRun, ...]
    committed: int | None
    refused: int | None
    reference: str | None = None

    @property
    def equal(self) -> bool:
        """Whether every run is equal in every bit and the self-test found no mismatch."""
        same = self.reference in (None, EQUAL)
        return same and self.selftest == 0 and all(run.differing == 0 for run in self.runs)

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

    def lines(self) -> list[str]:
        """The table and the notes below it."""
        return [table(self.header(), self.rows()), *self.notes()]

    def notes(self) -> list[str]:
        """Lines below the table: differences, commits, the verdict and its limits."""
        verdict = "equal to the host in every bit" if self.equal else "NOT EQUAL"
        differences = [f"DIFFERENT: {run.function}, {run.style}: {run.first}" for run in self.runs if run.first]
        learned = []
        if self.committed is not None:
            none = "" if self.committed else ": NOTHING WAS COMMITTED"
            learned = [
                f"the host's learner against the NumPy reference, the same updates: {self.reference}",
                f"shadows that became active: {self.committed}, refused: {self.refused}{none}",
            ]
        return [
            *differences,
            *learned,
            f"{self.model} on the C674x, simulated: {verdict}; self-test: {self.selftest} mismatches ({self.compiler})",
            "cycles are stall-free: caches, memory banks and interrupts are not modelled, and nothing ran on silicon",
        ]


@dataclass(frozen=True)
class _Setup:
    """The model's C on both machines, and the seed of the inputs."""

    model: Model
    host: Host
    machine: Machine
    seed: int


@dataclass(frozen=True)
class _Steps:
    """Chained calls on one machine: results (n,) and states (n, words) as bits, cycles (n,) on the simulator."""

    results: Words
    states: Words
    cycles: NDArray[np.int64]


def verify_on_target(
    model: Model,
    texts: Mapping[str, str],
    samples: int,
    seed: int = 1,
    progress: Progress | None = None,
    updates: int | None = None,
) -> TargetReport:
    """Run every function of the generated C over chained samples of every style, on the simulator and on the host.

    samples: of each function, divided among the styles; LEARNING_SHARE of them for `learn`. A model with a learner also
    runs learning with commits for `updates` chained updates; None: LEARNING_SHARE of `samples`. LEAST_UPDATES is the
    least number.
    Raises BuildError without a toolchain, TargetError for code that the simulator refuses.
    """
    firmware = toolchain.compile(c_texts(texts))
    setup = _Setup(model, Host(model.name, texts), firmware.machine(), seed)
    failed = setup.machine.call(f"{model.name}_selftest").bits if setup.host.selftested else 0
    todo = [task for task in tasks(setup.host) if task.function != "init"]
    runs: list[TargetRun] = []
    steps = len(todo) + 1
    for task in todo:
        if progress is not None:
            progress(len(runs) / steps, f"{task.function}, {task.style} inputs, on the simulator")
        share = LEARNING_SHARE if task.learns else 1.0
        runs.append(_compare(setup, task, math.ceil(share * samples / len(STYLES))))
    committed = refused = reference = None
    if model.learner is not None:
        if progress is not None:
            progress(len(runs) / steps, "learn and commit, on the simulator")
        chained = math.ceil(LEARNING_SHARE * samples) if updates is None else updates
        learning_runs, here, result = _compare_learning(setup, max(LEAST_UPDATES, chained))
        reference = EQUAL if here.equal else f"DIFFERENT, {here.first}"
        runs += learning_runs
        committed, refused = result.switches, sum(result.answers.values()) - result.committed
    return TargetReport(model.name, toolchain.version(), failed, tuple(runs), committed, refused, reference)


def _compare_learning(setup: _Setup, updates: int) -> tuple[list[TargetRun], LearningResult, LearningResult]:
    """The learning run on the simulator, as one run of learn and one of commit, and the results of both machines."""
    host = setup.host
    side = SimulatedSide(host, setup.machine)
    here, result = compare_learning(setup.model, [HostSide("this machine", host), side], host, updates, setup.seed)
    words = side.words().size
    learner = host.words_of(LEARNER.create(host)).size
    learn, commit, first = side.learning.range, side.committing.range, result.first
    return (
        [
            TargetRun("learn", LEARNING_RUN, result.samples, learner, result.learnt_wrong, learn, first),
            TargetRun("commit", LEARNING_RUN, result.calls, words + 1, result.committed_wrong, commit, first),
        ],
        here,
        result,
    )


def _compare(setup: _Setup, task: Task, samples: int) -> TargetRun:
    """One chain of `samples` on host and simulator."""
    host, machine = setup.host, setup.machine
    struct = task.compared.create(host)
    size = host.words_of(struct).size
    address = machine.allocate(size)
    machine.write(address, host.words_of(struct).copy())
    quantities = task.compared.quantities(task.function, host)
    returns = host.entries[task.function].result != "void"
    differing, done, first, cycles = 0, 0, None, CycleRange()
    for columns in chunks(setup.model, task.style, quantities, samples, setup.seed, CHUNK):
        expected = _Steps(*host.run(task.function, struct, columns, first=0, words=size), np.zeros(0, np.int64))
        simulated = _simulated_steps(setup, task, address, size, columns)
        wrong = (simulated.states != expected.states).any(axis=1) | ((simulated.results != expected.results) & returns)
        if first is None and wrong.any():
            k = int(np.argmax(wrong))
            first = f"sample {done + k}: {_described(host, task, k, expected, simulated)}"
        differing, done = differing + int(wrong.sum()), done + columns[0].size
        cycles.add(simulated.cycles)
    return TargetRun(task.function, task.style, done, size + int(returns), differing, cycles.range, first)


def _simulated_steps(setup: _Setup, task: Task, address: int, size: int, columns: Sequence[Words]) -> _Steps:
    """Chained calls on the struct of `size` words at `address`; auxiliary channels are set before each call."""
    machine, name = setup.machine, setup.host.name
    symbol, count = f"{name}_{task.function}", len(task.compared.functions[task.function])
    if len(columns) == count:
        outcomes = machine.map(symbol, address, *columns, read={address: size})
        return _Steps(outcomes.bits, outcomes.memory[address], outcomes.cycles)
    samples, place = columns[0].size, machine.allocate(len(columns) - count)
    steps = _Steps(np.empty(samples, np.uint32), np.empty((samples, size), np.uint32), np.empty(samples, np.int64))
    for k in range(samples):
        machine.write(place, np.array([column[k] for column in columns[count:]], dtype=np.uint32))
        machine.call(f"{name}_aux", address, place)
        outcome = machine.call(symbol, address, *(column[k].view(np.float32) for column in columns[:count]))
        steps.results[k], steps.cycles[k] = outcome.bits, outcome.cycles
        steps.states[k] = machine.read(address, size, np.uint32)
    return steps


def _described(host: Host, task: Task, k: int, expected: _Steps, simulated: _Steps) -> str:
    """The first word that differs in step k, with both bit patterns."""
    places = np.flatnonzero(simulated.states[k] != expected.states[k])
    if places.size == 0:
        return f"result is 0x{simulated.results[k]:08x}, the host's is 0x{expected.results[k]:08x}"
    layout = host.layout(f"{host.name}_{task.compared.type_suffix}")
    path = next(name for name, place in layout.items() if place == places[0])
    got, wanted = simulated.states[k][places[0]], expected.states[k][places[0]]
    return f"{path} is 0x{got:08x}, the host's is 0x{wanted:08x}"
