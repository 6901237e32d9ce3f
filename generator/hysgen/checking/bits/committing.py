"""Comparing `<name>_commit` with its reference: shadows of every kind, in every build, every word after every call."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.checking.bits.builds import Build
from hysgen.checking.bits.functions import START_UM, START_V
from hysgen.checking.bits.report import Mismatch, Run
from hysgen.checking.host import Host
from hysgen.float32.commit_numbers import commit_numbers
from hysgen.float32.learner_numbers import MOST_PARAMETERS
from hysgen.float32.learner_status import Commit
from hysgen.float32.reference.commit import Committer
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.learner import Learner
from hysgen.model.model import Model

Words = NDArray[np.uint32]
Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

SHADOWS: Final = MOST_PARAMETERS + 16
"""Shadows that are committed side by side, each in an instance and a learner of its own."""

CHANGES: Final = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 1e3)
"""How far shadows lie from the model's parameters, as a share of each parameter's typical size."""

HALVINGS: Final = 30
"""Of the way from a shadow that is committed to one that is not: until they differ in few last bits."""

WHOLE: Final = "commit"


@dataclass(frozen=True)
class Shadows:
    """What is committed: theta (2, n, shadows) and age (2, shadows), the second ones from call `every` on."""

    theta: Floats32
    age: Words
    every: int
    calls: int


def compare_commit(model: Model, builds: Sequence[Build], seed: int) -> tuple[Run, list[Mismatch]]:
    """The answers, candidates, both banks and reference parameters of SHADOWS commits; a difference per build."""
    committer = committer_of(model)
    shadows = _shadows(committer, seed)
    paths, expected = _expected(committer, shadows)
    found: list[Mismatch] = []
    for build in builds:
        got = _of_build(build, shadows, paths)
        wrong = np.argwhere(got != expected)
        if wrong.size:
            call, lane, word = wrong[0]
            found.append(
                Mismatch(
                    model=model.name,
                    function=WHOLE,
                    style=f"shadow {lane}",
                    build=str(build),
                    sample=int(call),
                    word=(*paths, "result")[word],
                    got=int(got[call, lane, word]),
                    expected=int(expected[call, lane, word]),
                    inputs=(),
                )
            )
    return Run(model.name, WHOLE, "shadows", shadows.calls * SHADOWS, len(builds)), found


def committer_of(model: Model, lanes: int = SHADOWS) -> Committer:
    """The reference, every lane at the model's own parameters and old enough to be committed."""
    start = Instance(model, np.full(lanes, START_UM), np.full(lanes, START_V))
    numbers = commit_numbers(model, start.numbers, certify(model))
    learner = Learner(model, start)
    learner.age = np.full(lanes, numbers.settings.mature, np.uint32)
    return Committer(numbers, learner)


def answers(committer: Committer, theta: Floats32) -> Words:
    """What commit answers to shadows theta (n, lanes) in the end; the committer stays as it was."""
    own = copy.deepcopy(committer)
    own.learner.theta = theta
    with np.errstate(all="ignore"):
        refused = own.commit()
        return np.where(refused == Commit.BUSY, own.verdict(), refused).astype(np.uint32)


def border(committer: Committer, direction: Floats) -> tuple[Floats32, Floats32]:
    """The last shadows that are committed and the first ones that are refused, (n, lanes) each, along `direction`."""
    own = committer.learner.theta.astype(np.float64)
    inside, outside = np.full(own.shape[1], 1e-9), np.full(own.shape[1], 1e6)
    for _ in range(HALVINGS):
        middle = np.where(outside > 4.0 * inside, np.sqrt(inside * outside), 0.5 * (inside + outside))
        committed = answers(committer, (own + middle * direction).astype(np.float32)) == Commit.COMMITTED
        inside, outside = np.where(committed, middle, inside), np.where(committed, outside, middle)
    return (own + inside * direction).astype(np.float32), (own + outside * direction).astype(np.float32)


def directions(committer: Committer, rng: np.random.Generator) -> Floats:
    """(n, lanes) ways to leave the model's parameters: one alone, all, those of a group in step, those of a group."""
    learner = committer.learner
    own = learner.theta.astype(np.float64)
    size, lanes = own.shape
    groups = [parameter.group for parameter in learner.numbers.parameters]
    kinds = list(dict.fromkeys(groups))
    lane = np.arange(lanes)
    one = np.arange(size)[:, None] == rng.integers(0, size, lanes)
    group = np.array(groups)[:, None] == np.array(kinds)[(lane // 8) % len(kinds)]
    typical = np.maximum(np.abs(own), 0.1 * np.abs(own).mean(axis=0)) + 1e-6
    drawn = typical * rng.standard_normal(own.shape)
    # In step: down to nothing in some lanes, up without end in the others.
    in_step = np.where(lane % 8 < 4, -1.0, 1.0) * own
    ways = [typical * np.sign(drawn) * one, drawn, in_step * group, drawn * group]
    return np.asarray(np.choose(lane % 4, ways))


def _shadows(committer: Committer, seed: int) -> Shadows:
    """Shadows near and far, with each parameter broken in turn, some too young; then some from both sides of the border
    of what is committed. They change while a candidate of theirs is being checked.
    """
    rng = np.random.default_rng([seed, *WHOLE.encode()])
    numbers, own = committer.numbers, committer.learner.theta
    whole = -(-numbers.points // numbers.settings.points_per_call) + 4
    lane = np.arange(SHADOWS)
    far = np.where(lane < SHADOWS - MOST_PARAMETERS, np.array(CHANGES)[lane % len(CHANGES)], 0.0)
    typical = np.maximum(np.abs(own), np.abs(own).mean())
    drawn = (own + typical * far * rng.standard_normal(own.shape)).astype(np.float32)
    broken = np.arange(own.shape[0])[:, None] == SHADOWS - 1 - lane
    drawn[broken] = rng.choice(np.array([np.nan, np.inf, -np.inf, 1e30], np.float32), int(broken.sum()))
    last, first = border(committer, directions(committer, rng))
    theta = np.stack([drawn, np.where(lane // 4 % 2, last, first)])
    young = rng.random((2, SHADOWS)) < 0.1
    age = np.where(young, numbers.settings.mature // 2, numbers.settings.mature).astype(np.uint32)
    return Shadows(theta, age, whole - 2, 2 * whole)


def _expected(committer: Committer, shadows: Shadows) -> tuple[list[str], Words]:
    """C paths of the words that are compared, and their values, (calls, shadows, words + 1): the answer comes last."""
    rows = []
    paths: list[str] = []
    with np.errstate(all="ignore"):
        for call in range(shadows.calls):
            if call in (0, shadows.every):
                committer.learner.theta = shadows.theta[call // shadows.every]
                committer.learner.age = shadows.age[call // shadows.every]
            answer = committer.commit()
            words = _words(committer)
            paths = list(words)
            rows.append(np.stack([*words.values(), answer], axis=1).astype(np.uint32))
    return paths, np.stack(rows)


def _words(committer: Committer) -> dict[str, Words]:
    """By C path: `candidate.` and `reference` in the learner, `active` and `bank` in the instance."""
    named = {f"candidate.{path}": word for path, word in committer.words().items()}
    named |= {f"reference[{i}]": row.view(np.uint32) for i, row in enumerate(committer.learner.reference)}
    named["active"] = committer.active
    for group, rows in committer.banks.items():
        for bank in range(2):
            named |= {f"bank[{bank}].{group}[{i}]": row.view(np.uint32) for i, row in enumerate(rows[bank])}
    return named


def _of_build(build: Build, shadows: Shadows, paths: Sequence[str]) -> Words:
    """The same words of the compiled C."""
    trace = np.empty((shadows.calls, SHADOWS, len(paths) + 1), dtype=np.uint32)
    for lane in range(SHADOWS):
        pair = _Pair(build.host, paths)
        for call in range(shadows.calls):
            if call in (0, shadows.every):
                change = call // shadows.every
                pair.learn(shadows.theta[change, :, lane], shadows.age[change, lane])
            trace[call, lane] = pair.commit(flush=build.flush)
    return trace


class _Pair:
    """An instance and its learner in C."""

    def __init__(self, host: Host, paths: Sequence[str]) -> None:
        self.host = host
        self.instance = host.instance(float(START_UM), float(START_V))
        self.learner: Any = host.struct(f"{host.name}_learner_t")
        host.call("learn_init", self.learner, self.instance)
        layout = host.layout(f"{host.name}_learner_t")
        self.theta, self.age = layout["theta[0]"], layout["age"]
        self.mine = np.array([layout[path] for path in paths if path in layout], dtype=np.int64)
        others = host.layout(f"{host.name}_t")
        self.others = np.array([others[path] for path in paths if path not in layout], dtype=np.int64)

    def learn(self, theta: Floats32, age: np.uint32) -> None:
        """Put a shadow in place of the learner's."""
        words = self.host.words_of(self.learner)
        words[self.theta : self.theta + theta.size] = theta.view(np.uint32)
        words[self.age] = age

    def commit(self, *, flush: bool) -> Words:
        """One call: the compared words, and the answer behind them."""
        answer = self.host.commit(self.instance, self.learner, flush=flush)
        mine, others = self.host.words_of(self.learner), self.host.words_of(self.instance)
        return np.concatenate([mine[self.mine], others[self.others], [np.uint32(answer)]])
