"""A learner that follows a stage, on several machines side by side: it learns, its shadows are committed, banks change.

The stage is the model with gains that are 5 % weaker and a sensor with noise, driven by the model's own inverse along
sines: what is learnt pays, so shadows are accepted. Every word of the learner is compared after every sample; every
word of both structs, and the answer, after every call of commit; then the predictions of the bank in use.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.functions import LEARNER, MODEL
from hysgen.checking.host import Host
from hysgen.float32.learner_status import Commit
from hysgen.model.model import Model
from hysgen.model.simulate import simulate
from hysgen.model.terms import Drive, channels_of

Words = NDArray[np.uint32]

UPDATES_BETWEEN_COMMITS: Final = 512
LEAST_UPDATES: Final = 2560
"""Fewer leave a shadow no time to grow old enough to be committed, with a learner's usual settings."""
PREDICTED_AFTER_COMMIT: Final = 16
WEAKER: Final = 0.95
NOISE: Final = 1e-4
"""Of the displacement's range, rms."""
SINES: Final = ((0.3, 3001.0), (0.25, 409.0), (0.15, 53.0), (0.1, 17.0))
"""Of the reference: share of half the displacement's range, and period in samples; fast ones, for the weights."""


class Side(Protocol):
    """An instance and its learner on one machine."""

    name: str

    def learn(self, y: Words, u: Words) -> Words:
        """The words of the learner after each sample, (n, words)."""
        ...

    def commit(self) -> int:
        """One call: its answer."""
        ...

    def predict(self, y: Words, u: Words) -> Words:
        """The results of chained predictions, (n,)."""
        ...

    def words(self) -> Words:
        """Every word of the instance, then every word of the learner, as they are now."""
        ...


class HostSide:
    """Compiled for this machine, or for another one that offers what a Host does."""

    def __init__(self, name: str, host: Host) -> None:
        self.name, self.host = name, host
        self._instance: Any = MODEL.start(host)
        self._learner: Any = LEARNER.start(host)
        self._size = host.words_of(self._learner).size

    def learn(self, y: Words, u: Words) -> Words:
        return self.host.run("learn", self._learner, [y, u], first=0, words=self._size)[1]

    def commit(self) -> int:
        return self.host.commit(self._instance, self._learner)

    def predict(self, y: Words, u: Words) -> Words:
        silent = [np.zeros_like(y)] * self.host.channels
        return self.host.run("predict", self._instance, [y, u, *silent])[0]

    def words(self) -> Words:
        return np.concatenate([self.host.words_of(self._instance), self.host.words_of(self._learner)])


@dataclass
class Followed:
    """What became of one side.

    samples: that were learnt from; calls: of commit; answers: how often each of its answers other than BUSY came.
    switches: how often the bank in use changed in this side's own memory. learnt_wrong, committed_wrong: samples, and
    calls or predictions behind them, after which a word was not the first side's; first: where that began.
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
        """Shadows that commit said it made active."""
        return self.answers[Commit.COMMITTED.name]

    @property
    def equal(self) -> bool:
        """Whether every word was the first side's."""
        return self.learnt_wrong == 0 and self.committed_wrong == 0

    def __str__(self) -> str:
        verdict = "equal in every bit" if self.equal else f"DIFFERENT, first: {self.first}"
        accepted = f"{self.committed} shadows became active" if self.committed else "NOTHING WAS COMMITTED"
        return f"{self.side}: learned from {self.samples} samples, {self.calls} calls of commit, {accepted}: {verdict}"

    def note(self, where: str) -> None:
        """A difference."""
        self.first = self.first or where


def follow(model: Model, sides: Sequence[Side], host: Host, updates: int, seed: int = 1) -> list[Followed]:
    """Let `sides` learn, and commit every UPDATES_BETWEEN_COMMITS updates: what became of each, beside the first.

    host: on which the voltages are found, and the layout of the structs. updates: of the covariance, refreshes of the
    prior included; each takes the calls that the model's learner says. The model has a learner.
    """
    assert model.learner is not None
    told = [Followed(side.name) for side in sides]
    active = host.layout(f"{host.name}_t")["active"]
    calls = model.learner.calls_per_update
    y, u = stage(model, host, updates * calls, seed)
    piece = UPDATES_BETWEEN_COMMITS * calls
    for start in range(0, y.size, piece):
        _learn(sides, told, y[start : start + piece], u[start : start + piece])
        answer = int(Commit.BUSY)
        while answer == Commit.BUSY:
            answer = _commit(sides, told, active)
        last = slice(max(0, start + piece - PREDICTED_AFTER_COMMIT), start + piece)
        _predict(sides, told, y[last], u[last])
    return told


def stage(model: Model, host: Host, samples: int, seed: int) -> tuple[Words, Words]:
    """y(k) measured and u(k) applied, as bits: sines over the grid, through the model's inverse to the stage."""
    rng = np.random.default_rng(seed)
    middle, half = 0.5 * (model.grid.y_max_um + model.grid.y_min_um), 0.5 * (model.grid.y_max_um - model.grid.y_min_um)
    k = np.arange(samples + 1)
    sines = [share * np.sin(2.0 * np.pi * k / period) for share, period in SINES]
    wanted = (middle + half * np.sum(sines, axis=0)).astype(np.float32).view(np.uint32)
    silent = [np.zeros(samples, np.uint32)] * host.channels
    u, _ = host.run("inverse", host.instance(middle, 0.0), [wanted[:-1], wanted[1:], *silent])
    weaker = dataclasses.replace(model, consequents=model.consequents * [1.0, WEAKER, 1.0])
    aux = {channel: np.zeros(samples) for channel in channels_of(model.terms)}
    y_um = simulate(weaker, Drive(u.view(np.float32).astype(np.float64), model.Ts_s, aux), middle).y_um[:samples]
    measured = y_um + 2.0 * half * NOISE * rng.standard_normal(samples)
    return measured.astype(np.float32).view(np.uint32), u


def _learn(sides: Sequence[Side], told: Sequence[Followed], y: Words, u: Words) -> None:
    expected = sides[0].learn(y, u)
    for place, (side, row) in enumerate(zip(sides, told, strict=True)):
        found = expected if place == 0 else side.learn(y, u)
        wrong = np.flatnonzero((found != expected).any(axis=1))
        if wrong.size:
            row.note(f"learner after sample {row.samples + wrong[0]}")
        row.samples += y.size
        row.learnt_wrong += wrong.size


def _commit(sides: Sequence[Side], told: Sequence[Followed], active: int) -> int:
    """One call on every side: what the first one answers."""
    answers = []
    states = []
    for side, row in zip(sides, told, strict=True):
        before = side.words()[active]
        answers.append(side.commit())
        states.append(side.words())
        row.calls += 1
        row.switches += int(states[-1][active] != before)
        if answers[-1] != Commit.BUSY:
            row.answers[Commit(answers[-1]).name] += 1
        if answers[-1] != answers[0] or not np.array_equal(states[-1], states[0]):
            row.committed_wrong += 1
            row.note(f"call {row.calls} of commit, after sample {row.samples}")
    return answers[0]


def _predict(sides: Sequence[Side], told: Sequence[Followed], y: Words, u: Words) -> None:
    """With the parameters that are in use now."""
    expected = sides[0].predict(y, u)
    for side, row in zip(sides[1:], told[1:], strict=True):
        if not np.array_equal(side.predict(y, u), expected):
            row.committed_wrong += 1
            row.note(f"predictions after sample {row.samples}")
