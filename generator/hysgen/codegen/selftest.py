"""Inputs and expected bit patterns of the self-test on the target, computed by the float32 reference."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import Certificates
from hysgen.float32.coefficients import commit_numbers
from hysgen.float32.reference.commit import Committer
from hysgen.float32.reference.instance import Instance
from hysgen.float32.reference.learner import Learner
from hysgen.float32.struct_words import Commit
from hysgen.machine.reproducible import drawn
from hysgen.model.model import Model
from hysgen.model.structs import COUNTERS

Words = NDArray[np.uint32]

ROWS: Final = 32
RAMP: Final = 16
"""Samples between the levels of a ramp."""
SEED: Final = 20120321
LEARNED_ROWS: Final = 64
NOISE: Final = 2e-4
"""Largest error of a learned reading, as a share of the displacement range."""
HASH_START: Final = 0x811C9DC5
HASH_FACTOR: Final = 0x01000193


@dataclass(frozen=True)
class CallSequence:
    """Successive calls of one function after `_init`.

    start: bit patterns of the arguments of `_init`. rows: bit patterns of arguments, channels and result of each call;
    comments: the same as decimal numbers. status, counters: expected words of the struct after the last call.
    """

    function: str
    start: tuple[int, int]
    rows: Sequence[tuple[Sequence[int], Sequence[int], int]]
    comments: Sequence[str]
    status: int
    counters: Sequence[tuple[str, int]]

    @property
    def columns(self) -> int:
        """Number of words in a row."""
        return len(self.rows[0][0]) + len(self.rows[0][1]) + 1


@dataclass(frozen=True)
class CommitCase:
    """A shadow that the self-test commits: bits of theta and age before, calls, answer and hash after.

    hash: of every word of instance and learner after the last call.
    """

    theta: Sequence[int]
    age: int
    calls: int
    answer: int
    hash: int


@dataclass(frozen=True)
class LearningSequence:
    """Successive samples of a learner after `_learn_init`, then commits of shadows that it accepts and refuses.

    start, rows, comments: as in CallSequence, with the hash of every word of the learner in place of the result.
    aged_at, age: the row before which the age of the shadow is set, past all waiting times of the learner.
    most_calls: larger than the number of calls of any commit.
    """

    start: tuple[int, int]
    rows: Sequence[tuple[Sequence[int], Sequence[int], int]]
    comments: Sequence[str]
    aged_at: int
    age: int
    cases: Sequence[CommitCase]
    most_calls: int

    @property
    def columns(self) -> int:
        """Number of words in a row."""
        return len(self.rows[0][0]) + len(self.rows[0][1]) + 1


def hashed(words: Sequence[int], start: int = HASH_START) -> int:
    """FNV-1a over 32-bit words: h <- (h xor word) HASH_FACTOR mod 2^32.

    Each step is invertible in h and in the word, so a single wrong word always changes the hash.
    """
    value = start
    for word in words:
        value = ((value ^ word) * HASH_FACTOR) & 0xFFFFFFFF
    return value


def learning(model: Model, certificates: Certificates) -> LearningSequence | None:
    """Samples of the learner and commits of shadows; None for a model without a learner.

    The readings are the model's own free run with an error of up to NOISE and, every ninth, a reading at a limit, out
    of range or not finite. The shadows: too young, the model's parameters, those just learned, two of which the first
    reading tells the better one, and each group of parameters scaled until a limit of the commit refuses it.
    """
    if model.learner is None:
        return None
    rng = np.random.default_rng(SEED)
    y0, u0 = np.float32(0.5 * (model.grid.y_min_um + model.grid.y_max_um)), np.float32(0.0)
    instance = Instance(model, np.full(1, y0), np.full(1, u0))
    plant = Instance(model, np.full(1, y0), np.full(1, u0))
    committer = Committer(commit_numbers(model, instance.numbers, certificates), Learner(model, instance))
    learner = committer.learner
    own, settings = learner.theta.copy(), model.learner
    low, high = np.float32(model.u_min_V), np.float32(model.u_max_V)
    u = drawn(rng, float(low), float(high), LEARNED_ROWS).astype(np.float32)
    error = drawn(rng, -NOISE, NOISE, LEARNED_ROWS) * (model.grid.y_max_um - model.grid.y_min_um)
    special_y = _column(rng, np.float32(model.grid.y_min_um), np.float32(model.grid.y_max_um))
    special_u = _column(rng, low, high)
    channels = [_column(rng, np.float32(-1.0), np.float32(40.0)) for _ in instance.channels]
    rows, comments = [], []
    aged_at, age = LEARNED_ROWS // 2, max(settings.window, settings.settle, settings.mature) + 1
    with np.errstate(all="ignore"):
        for k in range(LEARNED_ROWS):
            y_k = (plant.y_um + np.float32(error[k])).astype(np.float32)
            aux = [column[k % ROWS : k % ROWS + 1] for column in channels]
            if channels:
                plant.aux(aux)
                learner.aux(aux)
            plant.simulate(u[k : k + 1])
            y_k = special_y[k % ROWS : k % ROWS + 1] if k % 9 == 8 else y_k
            u_k = special_u[k % ROWS : k % ROWS + 1] if k % 16 == 15 else u[k : k + 1]
            learner.age = np.full(1, age, np.uint32) if k == aged_at else learner.age
            learner.learn(y_k, u_k)
            rows.append((_bits([y_k, u_k], 0), _bits(aux, 0), hashed(_learner_words(committer))))
            comments.append(", ".join(f"{number[0]:.6g}" for number in (y_k, u_k, *aux)))
        reading = np.array(rows[0][0], np.uint32).view(np.float32)
        cases = [_committed(committer, instance, reading, *shadow) for shadow in _shadows(learner, own, age)]
    return LearningSequence(
        start=(int(y0.view(np.uint32)), int(u0.view(np.uint32))),
        rows=rows,
        comments=comments,
        aged_at=aged_at,
        age=age,
        cases=cases,
        most_calls=committer.numbers.points + 8,
    )


def _shadows(learner: Learner, own: NDArray[np.float32], age: int) -> list[tuple[NDArray[np.float32], int]]:
    """The shadows of the commits: theta (n, 1) and age."""
    learned = learner.theta.copy()
    shadows = [(learned, 0), (own, age), (learned, age)]
    groups = np.array([parameter.group for parameter in learner.numbers.parameters])[:, None]
    shift = np.where(groups == groups[-1], np.float32(1e-3) * learner.numbers.level_um, np.float32(0.0))
    shadows += [(own + shift, age), (own - shift, age)]
    for group, factor in (("gain", 0.02), ("gain", -1.0), ("slope", 1.3), ("slope", -1.3)):
        if (groups == group).any():
            shadows.append((np.where(groups == group, np.float32(factor) * own, own), age))
    shadows.append((np.full_like(own, 1e9), age))
    return shadows


def _committed(
    committer: Committer, instance: Instance, reading: NDArray[np.float32], theta: NDArray[np.float32], age: int
) -> CommitCase:
    """The calls of `_commit` until it answers; the trial is of one sample, `reading` twice."""
    learner = committer.learner
    learner.theta, learner.age = theta.copy(), np.full(1, age, np.uint32)
    answer, calls = Commit.BUSY, 0
    while answer in (Commit.BUSY, Commit.TRYING):
        answer, calls = Commit(int(committer.commit()[0])), calls + 1
        if answer == Commit.TRYING:
            learner.trying = np.ones(1, np.uint32)
            learner.learn(reading[:1], reading[1:])
    words = hashed(_learner_words(committer), hashed(_instance_words(committer, instance)))
    return CommitCase([int(word) for word in theta.view(np.uint32)[:, 0]], age, calls, int(answer), words)


def _learner_words(committer: Committer) -> list[int]:
    """Every word of `<name>_learner_t` in the order of the struct."""
    learner = committer.learner
    base = [getattr(learner.base, group).view(np.uint32) for group in ("slope", "offset", "gain", "weight")]
    words = [int(word[0]) for word in learner.words().values()]
    words += [int(word) for group in base for word in group]
    return words + [int(word[0]) for word in committer.words().values()]


def _instance_words(committer: Committer, instance: Instance) -> list[int]:
    """Every word of `<name>_t` in the order of the struct."""
    words = [int(committer.active[0]), *(int(word[0]) for word in instance.words().values())]
    for bank in range(2):
        words += [int(bits) for rows in committer.banks.values() for bits in rows[bank].view(np.uint32)[:, 0]]
    return words


def chains(model: Model, *, inverse: bool) -> list[CallSequence]:
    """One chain per function, with arguments in range, at its limits, outside, tiny, huge and not finite."""
    functions = ["predict", "simulate", *(["inverse"] if inverse else []), *(["correct"] if model.feedback else [])]
    return [_chain(model, function, seed) for seed, function in enumerate(functions, SEED)]


def _chain(model: Model, function: str, seed: int) -> CallSequence:
    rng = np.random.default_rng(seed)
    y0, u0 = np.float32(0.5 * (model.grid.y_min_um + model.grid.y_max_um)), np.float32(0.0)
    lane = Instance(model, np.full(1, y0), np.full(1, u0))
    y, u, y_next = (_column(rng, *limits) for limits in _limits(model))
    ordinary = np.arange(ROWS) % 3 != 2
    y_next[ordinary] = (_followed if model.responds else _reachable)(model, y, rng)[ordinary]
    residual = y - y0
    arguments = {"predict": [y, u], "simulate": [u], "inverse": [y, y_next], "correct": [residual]}[function]
    channels = [_column(rng, np.float32(-1.0), np.float32(40.0)) for _ in lane.channels]
    rows, comments = [], []
    with np.errstate(all="ignore"):
        for k in range(ROWS):
            if channels:
                lane.aux([column[k : k + 1] for column in channels])
            result = getattr(lane, function)(*(column[k : k + 1] for column in arguments))
            rows.append((_bits(arguments, k), _bits(channels, k), int(result.view(np.uint32)[0])))
            inputs = ", ".join(f"{column[k]:.6g}" for column in (*arguments, *channels))
            comments.append(f"{inputs} -> {result[0]:.6g}")
    return CallSequence(
        function=function,
        start=(int(y0.view(np.uint32)), int(u0.view(np.uint32))),
        rows=rows,
        comments=comments,
        status=int(lane.status[0]),
        counters=[(name, int(lane.counters[name][0])) for name in COUNTERS],
    )


def _reachable(model: Model, y: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Displacements y(k+1), (ROWS,), that random inputs in range reach from y, the terms in their initial state."""
    u = drawn(rng, model.u_min_V, model.u_max_V, ROWS).astype(np.float32)
    with np.errstate(all="ignore"):
        return Instance(model, y, np.zeros(ROWS, dtype=np.float32)).predict(y, u)


def _followed(model: Model, y: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Displacements y(k+1), (ROWS,), that the model predicts from y along a random ramp: what the path allows."""
    levels = np.append(0.0, drawn(rng, model.u_min_V, model.u_max_V, ROWS // RAMP))
    u = np.interp(np.arange(ROWS) / RAMP, np.arange(levels.size), levels).astype(np.float32)
    lane = Instance(model, y[:1], u[:1])
    with np.errstate(all="ignore"):
        return np.concatenate([lane.predict(y[k : k + 1], u[k : k + 1]) for k in range(ROWS)])


def _limits(model: Model) -> list[tuple[np.float32, np.float32]]:
    range_um = (np.float32(model.grid.y_min_um), np.float32(model.grid.y_max_um))
    return [range_um, (np.float32(model.u_min_V), np.float32(model.u_max_V)), range_um]


def _column(rng: np.random.Generator, low: np.float32, high: np.float32) -> NDArray[np.float32]:
    """(ROWS,) values: every third is a limit, outside, tiny, huge or not finite, the others are uniform in range."""
    column = drawn(rng, float(low), float(high), ROWS).astype(np.float32)
    special = [low, high, 2 * low - high, 2 * high - low, 0.0, -0.0, 1e-40, -1e30, np.inf, -np.inf, np.nan]
    column[2::3] = rng.permutation(np.array(special, dtype=np.float32))[: column[2::3].size]
    return column


def _bits(columns: Sequence[NDArray[np.float32]], k: int) -> list[int]:
    return [int(column[k : k + 1].view(np.uint32)[0]) for column in columns]
