"""Comparison of generated C with its reference: one model, every function, every input style, every build."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.builds import Build
from hysgen.checking.bits.committing import compare_commit
from hysgen.checking.bits.functions import COMPARED_STRUCTS, ComparedStruct, Lanes
from hysgen.checking.bits.induction import CallTrace, Difference, first_difference
from hysgen.checking.bits.inputs import SHARES, STYLES, chunks
from hysgen.checking.bits.report import ComparedRun, Mismatch
from hysgen.checking.host import Host
from hysgen.model.model import Model

Words = NDArray[np.uint32]
START_SAMPLES: Final = 5000
"""Samples of each function of SETUP per style."""
SETUP: Final = frozenset({"init", "limits"})
"""Functions that are not called at every sample."""
Progress = Callable[[int], None]
"""Called with the number of samples just compared in every build."""


@dataclass(frozen=True)
class Task:
    """A function of a compared struct under one input style."""

    compared: ComparedStruct
    function: str
    style: str

    @property
    def learns(self) -> bool:
        return self.function == "learn"


@dataclass
class SampleChain:
    """The struct of one build that a chain of samples steps, and its compared words."""

    build: Build
    struct: Any
    first: int
    count: int

    @property
    def words(self) -> Words:
        """(1, count) current values of the compared words."""
        words = self.build.host.words_of(self.struct)[self.first : self.first + self.count]
        return words.reshape(1, -1).copy()

    def run(self, function: str, columns: Sequence[Words], arguments: int) -> CallTrace:
        """Step the struct through samples. columns: the arguments of the function, then the auxiliary channels."""
        start = self.words
        out, after = self.build.host.run(
            function, self.struct, columns, first=self.first, words=self.count, flush=self.build.flush
        )
        return CallTrace(columns[:arguments], columns[arguments:], np.concatenate([start, after[:-1]]), out, after)


def tasks(host: Host) -> list[Task]:
    """Every function of the generated code on `host` under every style."""
    return [
        Task(compared, function, style)
        for compared in COMPARED_STRUCTS
        for function in compared.functions
        if function in host.entries
        for style in STYLES
    ]


def compare(
    model: Model, builds: Sequence[Build], samples: int, seed: int, progress: Progress
) -> Iterator[tuple[ComparedRun, list[Mismatch]]]:
    """Self-test, commit and every task: the run, and the first difference of each build that differs.

    samples: divided among the functions and their styles; those of SETUP get START_SAMPLES per style in addition.
    """
    if builds[0].host.selftested:
        yield compare_selftest(model, builds)
    if builds[0].host.commits:
        yield compare_commit(model, builds, seed)
    for task, share in _shares(builds[0].host, samples):
        yield compare_task(model, builds, task, share, seed, progress)


def samples_to_compare(host: Host, samples: int) -> int:
    """Samples of all tasks of `compare`: more than `samples`, by those of SETUP and by rounding."""
    return sum(share for _, share in _shares(host, samples))


def _shares(host: Host, samples: int) -> list[tuple[Task, int]]:
    """Every task with its samples."""
    todo = tasks(host)
    functions = len({task.function for task in todo} - SETUP)
    return [
        (task, START_SAMPLES if task.function in SETUP else math.ceil(SHARES[task.style] * samples / functions))
        for task in todo
    ]


def compare_selftest(model: Model, builds: Sequence[Build]) -> tuple[ComparedRun, list[Mismatch]]:
    """The generated self-test, once per build; it returns the number of its mismatches."""
    mismatches = []
    for build in builds:
        result = int(build.host.call("selftest"))
        if result != 0:
            mismatches.append(Mismatch(model.name, "selftest", "fixed", str(build), 0, "result", result, 0, ()))
    return ComparedRun(model.name, "selftest", "fixed", 1, len(builds)), mismatches


def compare_task(
    model: Model, builds: Sequence[Build], task: Task, samples: int, seed: int, progress: Progress
) -> tuple[ComparedRun, list[Mismatch]]:
    """One chain of `samples` in every build. A build that differs is reported once and then left out."""
    lanes = task.compared.reference(model)
    chains = [_chain(build, task, lanes) for build in builds]
    mismatches: list[Mismatch] = []
    done = 0
    arguments = len(task.compared.functions[task.function])
    quantities = task.compared.quantities(task.function, builds[0].host)
    for columns in chunks(model, task.style, quantities, samples, seed, task.compared.chunk):
        # A trace equal to a proved trace of another build needs no reference of its own.
        proved: CallTrace | None = None
        for chain in list(chains):
            trace = chain.run(task.function, columns, arguments)
            if proved is not None and trace.equals(proved):
                continue
            difference = first_difference(lanes, task.function, trace)
            if difference is None:
                proved = trace
            else:
                mismatches.append(_mismatch(model, task, chain.build, difference, columns, done))
                chains.remove(chain)
        done += columns[0].size
        progress(columns[0].size)
        if not chains:
            break
    return ComparedRun(model.name, task.function, task.style, samples, len(builds)), mismatches


def _chain(build: Build, task: Task, lanes: Lanes) -> SampleChain:
    struct = task.compared.create(build.host)
    if task.style == "edges":
        task.compared.wear(build.host, struct)
    first = _layout(build, task)[task.compared.first_word]
    return SampleChain(build, struct, first, len(lanes.words()))


def _layout(build: Build, task: Task) -> dict[str, int]:
    return build.host.layout(f"{build.host.name}_{task.compared.type_suffix}")


def _mismatch(
    model: Model, task: Task, build: Build, difference: Difference, columns: Sequence[Words], first: int
) -> Mismatch:
    layout = _layout(build, task)
    paths, first_word = list(layout), layout[task.compared.first_word]
    return Mismatch(
        model=model.name,
        function=task.function,
        style=task.style,
        build=str(build),
        sample=first + difference.sample,
        word="result" if difference.place is None else paths[first_word + difference.place],
        got=difference.got,
        expected=difference.expected,
        inputs=tuple(int(column[difference.sample]) for column in columns),
    )
