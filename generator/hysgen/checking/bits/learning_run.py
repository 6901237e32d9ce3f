"""Comparison of a learning run on several machines: learners update, shadows are committed, banks change.

The plant is the weaker stage of `inputs`. The model's inverse computes the voltages from a reference of four sines. The
parameter error makes updated shadows better than the active bank, so commits succeed. Every word of the learner is
compared after every sample; every word of both structs, and the answer, after every call of commit; then the
predictions of the active bank. Each sample of the first side is also compared with one step of the NumPy reference
from the same state (`functions`).
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from hysgen.checking import Host
from hysgen.checking.bits.functions import LEARNER, MODEL, CallTrace, Lanes, first_difference, weaker_stage
from hysgen.float32.struct_words import Commit
from hysgen.model.model import Model

Words = NDArray[np.uint32]

UPDATES_BETWEEN_COMMITS: Final = 512
LEAST_UPDATES: Final = 4096
"""After fewer updates a shadow with usual settings is too young to be committed, or still on trial."""
PREDICTED_AFTER_COMMIT: Final = 16
SINES: Final = ((0.3, 3001.0), (0.25, 409.0), (0.15, 53.0), (0.1, 17.0))
"""Reference: (share of half the displacement range, period in samples); the fast sines excite the terms' weights."""


class Side(Protocol):
    """An instance and its learner on one machine."""

    name: str

    def learn(self, y: Words, u: Words) -> Words:
        """The learner's words after each sample, (n, words)."""
        ...

    def commit(self) -> int:
        """The answer of one call of commit."""
        ...

    def predict(self, y: Words, u: Words) -> Words:
        """The results of chained predictions, (n,)."""
        ...

    def words(self) -> Words:
        """Every word of the instance, then every word of the learner."""
        ...


class HostSide:
    """A side on a Host, or on an object with the interface of Host."""

    def __init__(self, name: str, host: Host) -> None:
        self.name, self.host = name, host
        self._instance: Any = MODEL.create(host)
        self._learner: Any = LEARNER.create(host)
        self._size = host.words_of(self._learner).size

    def learn(self, y: Words, u: Words) -> Words:
        return self.host.run("learn", self._learner, [y, u], first=0, words=self._size)[1]

    def commit(self) -> int:
        return self.host.commit(self._instance, self._learner)

    def predict(self, y: Words, u: Words) -> Words:
        channels = [np.zeros_like(y)] * self.host.channels
        return self.host.run("predict", self._instance, [y, u, *channels])[0]

    def words(self) -> Words:
        return np.concatenate([self.host.words_of(self._instance), self.host.words_of(self._learner)])


@dataclass
class LearningResult:
    """The learning run of one side, compared with the first side.

    samples: learned from. calls: of commit. answers: how often commit gave each answer other than BUSY. switches:
    changes of the active bank in this side's own memory. learnt_wrong: samples after which a word of the learner
    differs; of the first side, chunks of samples in which a word differs from the reference. committed_wrong: calls of
    commit, or predictions after them, that differ. first: where the first difference is.
    """

    side: str
    samples: int = 0
    calls: int = 0
    answers: Counter[str] = field(default_factory=Counter)
    switches: int = 0
    learnt_wrong: int = 0
    committed_wrong: int = 0
    first: str | None = None

    @property
    def committed(self) -> int:
        """Number of COMMITTED answers."""
        return self.answers[Commit.COMMITTED.name]

    @property
    def equal(self) -> bool:
        """Whether every compared word equals the first side's."""
        return self.learnt_wrong == 0 and self.committed_wrong == 0

    def __str__(self) -> str:
        verdict = "equal in every bit" if self.equal else f"DIFFERENT, first: {self.first}"
        accepted = f"{self.committed} shadows became active" if self.committed else "NOTHING WAS COMMITTED"
        return f"{self.side}: learned from {self.samples} samples, {self.calls} calls of commit, {accepted}: {verdict}"

    def record_difference(self, where: str) -> None:
        """Keep `where` if it is the first difference."""
        self.first = self.first or where


def compare_learning(
    model: Model, sides: Sequence[Side], host: Host, updates: int, seed: int = 1
) -> list[LearningResult]:
    """Run learning on all `sides`, with a commit every UPDATES_BETWEEN_COMMITS updates; one result per side.

    host: computes the voltages and gives the layout of the structs. updates: number of covariance updates, refreshes of
    the prior included; each takes one sample. The model must have a learner.
    """
    results = [LearningResult(side.name) for side in sides]
    active = host.layout(f"{host.name}_t")["active"]
    reference = _Reference(LEARNER.reference(model), host.layout(f"{host.name}_learner_t")[LEARNER.first_word])
    y, u = stage_record(model, host, updates, seed)
    for start in range(0, y.size, UPDATES_BETWEEN_COMMITS):
        stop = start + UPDATES_BETWEEN_COMMITS
        _learn(sides, results, reference, (y[start:stop], u[start:stop]))
        answer = int(Commit.BUSY)
        while answer == Commit.BUSY:
            answer = _commit(sides, results, active)
        last = slice(max(0, stop - PREDICTED_AFTER_COMMIT), stop)
        _predict(sides, results, y[last], u[last])
    return results


def stage_record(model: Model, host: Host, samples: int, seed: int) -> tuple[Words, Words]:
    """Bits of y(k) measured at the weaker stage and of u(k) computed by the model's inverse, (samples,) each."""
    rng = np.random.default_rng(seed)
    middle, half = 0.5 * (model.grid.y_max_um + model.grid.y_min_um), 0.5 * (model.grid.y_max_um - model.grid.y_min_um)
    k = np.arange(samples + 1)
    sines = [share * np.sin(2.0 * np.pi * k / period) for share, period in SINES]
    reference = (middle + half * np.sum(sines, axis=0)).astype(np.float32).view(np.uint32)
    channels = [np.zeros(samples, np.uint32)] * host.channels
    u, _ = host.run("inverse", host.instance(middle, 0.0), [reference[:-1], reference[1:], *channels])
    return weaker_stage(model, u, rng), u


@dataclass(frozen=True)
class _Reference:
    """The NumPy reference of the learner, and the index of its first word in the C struct."""

    lanes: Lanes
    first: int

    def difference(self, y: Words, u: Words, states: Words) -> str | None:
        """The first difference between a learner's words after each sample and the reference; None if all are equal.

        states: (n + 1, words), the words before the first sample and after each of n samples.
        """
        words = states[:, self.first : self.first + len(self.lanes.words())]
        trace = CallTrace([y, u], [], words[:-1], np.zeros(y.size, np.uint32), words[1:])
        found = first_difference(self.lanes, "learn", trace)
        return None if found is None else f"word {found.place} of the reference, sample {found.sample} of the chunk"


def _learn(
    sides: Sequence[Side], results: Sequence[LearningResult], reference: _Reference, columns: tuple[Words, Words]
) -> None:
    y, u = columns
    before = sides[0].words()
    expected = sides[0].learn(y, u)
    difference = reference.difference(y, u, np.vstack([before[-expected.shape[1] :], expected]))
    if difference is not None:
        results[0].record_difference(f"{difference} behind sample {results[0].samples}")
        results[0].learnt_wrong += 1
    for place, (side, result) in enumerate(zip(sides, results, strict=True)):
        found = expected if place == 0 else side.learn(y, u)
        wrong = np.flatnonzero((found != expected).any(axis=1))
        if wrong.size:
            result.record_difference(f"learner after sample {result.samples + wrong[0]}")
        result.samples += y.size
        result.learnt_wrong += wrong.size


def _commit(sides: Sequence[Side], results: Sequence[LearningResult], active: int) -> int:
    """One call of commit on every side; returns the first side's answer."""
    answers = []
    states = []
    for side, result in zip(sides, results, strict=True):
        before = side.words()[active]
        answers.append(side.commit())
        states.append(side.words())
        result.calls += 1
        result.switches += int(states[-1][active] != before)
        if answers[-1] != Commit.BUSY:
            result.answers[Commit(answers[-1]).name] += 1
        if answers[-1] != answers[0] or not np.array_equal(states[-1], states[0]):
            result.committed_wrong += 1
            result.record_difference(f"call {result.calls} of commit, after sample {result.samples}")
    return answers[0]


def _predict(sides: Sequence[Side], results: Sequence[LearningResult], y: Words, u: Words) -> None:
    """Compare predictions with the active bank."""
    expected = sides[0].predict(y, u)
    for side, result in zip(sides[1:], results[1:], strict=True):
        if not np.array_equal(side.predict(y, u), expected):
            result.committed_wrong += 1
            result.record_difference(f"predictions after sample {result.samples}")
