"""Comparing generated C with its reference: one model, every function, every style of inputs, every build."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.builds import Build
from hysgen.checking.bits.committing import compare_commit
from hysgen.checking.bits.functions import SUBJECTS, Lanes, Subject
from hysgen.checking.bits.induction import Difference, first_difference
from hysgen.checking.bits.inputs import SHARES, STYLES, chunks
from hysgen.checking.bits.report import Mismatch, Run
from hysgen.model.model import Model

Words = NDArray[np.uint32]
START_SAMPLES: Final = 5000
Progress = Callable[[int], None]
"""Called with the number of samples that were just compared in every build."""


@dataclass(frozen=True)
class Task:
    """A function of a subject under a style of inputs."""

    subject: Subject
    function: str
    style: str


@dataclass
class Record:
    """A chain of samples in one build: its struct, and the words of it that are compared."""

    build: Build
    struct: Any
    first: int
    count: int

    @property
    def words(self) -> Words:
        """(1, count) the compared words as they are now."""
        words = self.build.host.words_of(self.struct)[self.first : self.first + self.count]
        return words.reshape(1, -1).copy()

    def run(self, function: str, columns: Sequence[Words]) -> tuple[Words, Words, Words]:
        """The next samples: states before them, results, states after them."""
        start = self.words
        out, after = self.build.host.run(
            function, self.struct, columns, first=self.first, words=self.count, flush=self.build.flush
        )
        return np.concatenate([start, after[:-1]]), out, after


def tasks(build: Build) -> list[Task]:
    """What there is to compare in the generated code of `build`."""
    return [
        Task(subject, function, style)
        for subject in SUBJECTS
        for function in subject.functions
        if function in build.host.entries
        for style in STYLES
    ]


def compare(
    model: Model, builds: Sequence[Build], samples: int, seed: int, progress: Progress
) -> Iterator[tuple[Run, list[Mismatch]]]:
    """Every step over its share of `samples`, starts over START_SAMPLES besides; the first difference per build."""
    if builds[0].host.selftested:
        yield compare_selftest(model, builds)
    if builds[0].host.commits:
        yield compare_commit(model, builds, seed)
    todo = tasks(builds[0])
    functions = len({task.function for task in todo} - {"init"})
    for task in todo:
        share = START_SAMPLES if task.function == "init" else math.ceil(SHARES[task.style] * samples / functions)
        yield compare_task(model, builds, task, share, seed, progress)


def compare_selftest(model: Model, builds: Sequence[Build]) -> tuple[Run, list[Mismatch]]:
    """The generated self-test, once per build; its result is the number of its mismatches."""
    found = []
    for build in builds:
        result = int(build.host.call("selftest"))
        if result != 0:
            found.append(Mismatch(model.name, "selftest", "fixed", str(build), 0, "result", result, 0, ()))
    return Run(model.name, "selftest", "fixed", 1, len(builds)), found


def compare_task(
    model: Model, builds: Sequence[Build], task: Task, samples: int, seed: int, progress: Progress
) -> tuple[Run, list[Mismatch]]:
    """One chain of `samples` in every build. A build that differs is told once and left out of the rest."""
    lanes = task.subject.reference(model)
    records = [_record(build, task, lanes) for build in builds]
    found: list[Mismatch] = []
    done = 0
    arguments = task.subject.functions[task.function]
    heard = ["channel"] * builds[0].host.channels if task.subject.listens else []
    for columns in chunks(model, task.style, [*arguments, *heard], samples, seed, task.subject.piece):
        # Once one build's record of this piece is proved, the same record in another build is proved as well.
        proved: tuple[Words, Words, Words] | None = None
        for record in list(records):
            run = record.run(task.function, columns)
            if proved is not None and all(np.array_equal(a, b) for a, b in zip(run, proved, strict=True)):
                continue
            difference = first_difference(
                lanes, task.function, columns[: len(arguments)], columns[len(arguments) :], *run
            )
            if difference is None:
                proved = run
            else:
                found.append(_mismatch(model, task, record.build, difference, columns, done))
                records.remove(record)
        done += columns[0].size
        progress(columns[0].size)
        if not records:
            break
    return Run(model.name, task.function, task.style, samples, len(builds)), found


def _record(build: Build, task: Task, lanes: Lanes) -> Record:
    struct = task.subject.start(build.host)
    if task.style == "edges":
        task.subject.wear(build.host, struct)
    first = _layout(build, task)[task.subject.first]
    return Record(build, struct, first, len(lanes.words()))


def _layout(build: Build, task: Task) -> dict[str, int]:
    return build.host.layout(f"{build.host.name}_{task.subject.struct}")


def _mismatch(
    model: Model, task: Task, build: Build, difference: Difference, columns: Sequence[Words], first: int
) -> Mismatch:
    layout = _layout(build, task)
    paths, first_word = list(layout), layout[task.subject.first]
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
