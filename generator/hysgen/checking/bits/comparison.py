"""Comparison of generated C with its reference: one model, every function, every input style, every build."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.checking import LEVELS, Build, Host, compiled, host_compilers, toolchains, versions
from hysgen.checking.bits import ComparedRun, Mismatch, Report
from hysgen.checking.bits.functions import (
    COMPARED_STRUCTS,
    LEARNER,
    MODEL,
    SHARES,
    START_UM,
    START_V,
    STYLES,
    CallTrace,
    ComparedStruct,
    Difference,
    Lanes,
    chunks,
    first_difference,
)
from hysgen.float32.coefficients import MOST_DENSE_RULES, commit_numbers
from hysgen.float32.reference.commit import Committer
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.learner import Learner
from hysgen.model.model import Model

Words = NDArray[np.uint32]
Floats32 = NDArray[np.float32]

MOST_PARAMETERS: Final = 3 * MOST_DENSE_RULES
"""Largest number of learned parameters."""

SHADOWS: Final = MOST_PARAMETERS + 16
"""Number of shadows committed side by side, each in its own instance and learner."""

CHANGES: Final = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 1e3)
"""Distances of shadows from the model's parameters, as a share of each parameter's typical magnitude."""

COMMIT: Final = "commit"


@dataclass(frozen=True)
class Shadows:
    """Two generations of shadows, theta (2, n, shadows) and the words of PLANTED (2, shadows); the second at call
    `second_from`, with trials of the first that have ended."""

    theta: Floats32
    words: dict[str, Words]
    second_from: int
    calls: int


def compare_commit(model: Model, builds: Sequence[Build], seed: int) -> tuple[ComparedRun, list[Mismatch]]:
    """Answers, candidates, both banks and reference parameters over SHADOWS commits; the first difference per build."""
    committer = committer_of(model)
    shadows = _shadows(committer, seed)
    paths, expected = _reference_trace(committer, shadows)
    mismatches: list[Mismatch] = []
    for build in builds:
        got = _compiled_trace(build, shadows, paths)
        wrong = np.argwhere(got != expected)
        if wrong.size:
            call, lane, word = wrong[0]
            bits = int(got[call, lane, word]), int(expected[call, lane, word])
            path = (*paths, "result")[word]
            mismatches.append(Mismatch(model.name, COMMIT, f"shadow {lane}", str(build), int(call), path, *bits, ()))
    return ComparedRun(model.name, COMMIT, "shadows", shadows.calls * SHADOWS, len(builds)), mismatches


def committer_of(model: Model, lanes: int = SHADOWS) -> Committer:
    """The reference of commit; every lane holds the model's own parameters and is old enough to be committed."""
    start = Instance(model, np.full(lanes, START_UM), np.full(lanes, START_V))
    numbers = commit_numbers(model, start.numbers, certify(model))
    learner = Learner(model, start)
    learner.age = np.full(lanes, numbers.settings.mature, np.uint32)
    return Committer(numbers, learner)


def _shadows(committer: Committer, seed: int) -> Shadows:
    """Shadows at all distances of CHANGES, each parameter broken in turn; then others near the own ones.

    A tenth of them is too young. The second generation arrives while candidates of the first are being checked.
    """
    rng = np.random.default_rng([seed, *COMMIT.encode()])
    numbers, own = committer.numbers, committer.learner.theta
    calls_per_check = -(-numbers.points // numbers.settings.points_per_call) + 5
    lane = np.arange(SHADOWS)
    change = np.where(lane < SHADOWS - MOST_PARAMETERS, np.array(CHANGES)[lane % len(CHANGES)], 0.0)
    typical = np.maximum(np.abs(own), np.abs(own).mean())
    drawn = (own + typical * change * rng.standard_normal(own.shape)).astype(np.float32)
    broken = np.arange(own.shape[0])[:, None] == SHADOWS - 1 - lane
    drawn[broken] = rng.choice(np.array([np.nan, np.inf, -np.inf, 1e30], np.float32), int(broken.sum()))
    near = (own + typical * np.array(CHANGES)[lane % 5] * rng.standard_normal(own.shape)).astype(np.float32)
    young = rng.random((2, SHADOWS)) < 0.1
    age = np.where(young, numbers.settings.mature // 2, numbers.settings.mature).astype(np.uint32)
    updates, errors = rng.integers(0, 2, (2, SHADOWS)), rng.integers(0, 3, (2, 2, SHADOWS)).astype(np.float32)
    ended = dict(zip(("trial_error", "trial_reference_error"), errors.view(np.uint32), strict=True))
    words = {"age": age, "updates": updates.astype(np.uint32), "trying": np.zeros_like(age), **ended}
    return Shadows(np.stack([drawn, near]), words, calls_per_check - 3, 2 * calls_per_check)


def _reference_trace(committer: Committer, shadows: Shadows) -> tuple[list[str], Words]:
    """C paths of the compared words, and their values with the answer last, (calls, shadows, words + 1)."""
    rows = []
    paths: list[str] = []
    with np.errstate(all="ignore"):
        for call in range(shadows.calls):
            if call in (0, shadows.second_from):
                learner, generation = committer.learner, call // shadows.second_from
                planted = {path: words[generation] for path, words in shadows.words.items()}
                learner.theta, learner.age, learner.trying = (
                    shadows.theta[generation],
                    planted["age"],
                    planted["trying"],
                )
                learner.counters["updates"] = planted["updates"]
                for path in ("trial_error", "trial_reference_error"):
                    setattr(learner, path, planted[path].view(np.float32))
            answer = committer.commit()
            words = _words(committer)
            paths = list(words)
            rows.append(np.stack([*words.values(), answer], axis=1).astype(np.uint32))
    return paths, np.stack(rows)


def _words(committer: Committer) -> dict[str, Words]:
    """By C path: `candidate.`, `reference` and the trial of the learner, `active` and `bank` of the instance."""
    named = {f"candidate.{path}": word for path, word in committer.words().items()}
    learner = committer.learner
    for name, rows in {"reference": learner.reference, "trial": learner.trial}.items():
        named |= {f"{name}[{i}]": row.view(np.uint32) for i, row in enumerate(rows)}
    named["trying"] = learner.trying
    named["active"] = committer.active
    for group, rows in committer.banks.items():
        for bank in range(2):
            named |= {f"bank[{bank}].{group}[{i}]": row.view(np.uint32) for i, row in enumerate(rows[bank])}
    return named


def _compiled_trace(build: Build, shadows: Shadows, paths: Sequence[str]) -> Words:
    """The values of `_reference_trace`, from the compiled C."""
    host = build.host
    layout, in_learner = host.layout(f"{host.name}_t"), host.layout(f"{host.name}_learner_t")
    places = np.array([in_learner[path] if path in in_learner else len(in_learner) + layout[path] for path in paths])
    trace = np.empty((shadows.calls, SHADOWS, len(paths) + 1), dtype=np.uint32)
    for lane in range(SHADOWS):
        instance, learner = MODEL.create(host), LEARNER.create(host)
        active, learned = host.words_of(instance), host.words_of(learner)
        for call in range(shadows.calls):
            if call in (0, shadows.second_from):
                generation, first = call // shadows.second_from, in_learner["theta[0]"]
                theta = shadows.theta[generation, :, lane].view(np.uint32)
                learned[first : first + theta.size] = theta
                for path, words in shadows.words.items():
                    learned[in_learner[path]] = words[generation, lane]
            trace[call, lane, -1] = host.commit(instance, learner, flush=build.flush)
            trace[call, lane, :-1] = np.concatenate([learned, active])[places]
    return trace


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
    model: Model,
    builds: Sequence[Build],
    planned: Sequence[tuple[Task, int]],
    seed: int,
    progress: Callable[[float], None],
    *,
    commit: bool = False,
) -> tuple[tuple[ComparedRun, ...], tuple[Mismatch, ...]]:
    """Runs of the self-test, with `commit` of commits, and of every task with its samples; the first difference of each
    build that differs. progress: called with the share of the samples that is done.
    """
    total, done = sum(samples for _, samples in planned), 0

    def advance(samples: int) -> None:
        nonlocal done
        done += samples
        progress(min(1.0, done / total))

    results = [compare_selftest(model, builds)] if builds[0].host.selftested else []
    results += [compare_commit(model, builds, seed)] if commit and builds[0].host.commits else []
    results += [compare_task(model, builds, task, samples, seed, advance) for task, samples in planned]
    return tuple(run for run, _ in results), tuple(wrong for _, differ in results for wrong in differ)


def shares(host: Host, samples: int) -> list[tuple[Task, int]]:
    """Every task with its samples: divided among functions and styles; in addition, START_SAMPLES for those of SETUP
    per style."""
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


DEFAULT_SAMPLES: Final = 1_000_000


@dataclass(frozen=True)
class VerifySettings:
    """Extent of a verification.

    samples: in each build, divided among the functions. compilers, levels: the builds; the report names a compiler that
    is not installed.
    """

    samples: int = DEFAULT_SAMPLES
    seed: int = 1
    compilers: Sequence[str] = field(default_factory=host_compilers)
    levels: Sequence[str] = LEVELS


def verify_texts(
    model: Model,
    texts: Mapping[str, str],
    settings: VerifySettings | None = None,
    progress: Callable[[float, str], None] | None = None,
    altered: tuple[str, ...] = (),
) -> Report:
    """Compare generated C with the reference of its model.

    progress: called with the fraction done and the current step. altered: files that differ from the manifest, for the
    report. Raises BuildError if no compiler is installed or one rejects the C.
    """
    started = time.monotonic()
    chosen, report = settings or VerifySettings(), progress or (lambda fraction, step: None)
    installed, skipped = toolchains(chosen.compilers, chosen.levels)
    report(0.0, f"compiling {model.name}")
    builds, unavailable = compiled(model.name, texts, installed)
    planned, comparing = shares(builds[0].host, chosen.samples), f"comparing {model.name}"
    compared = compare(model, builds, planned, chosen.seed, lambda done: report(done, comparing), commit=True)
    skipped = list(dict.fromkeys([*skipped, *unavailable]))
    labels = (*versions(installed), "with and without flush to zero" if not any("flush" in s for s in skipped) else "")
    seconds = time.monotonic() - started
    return Report(model.name, tuple(filter(None, labels)), tuple(skipped), altered, *compared, seconds)
