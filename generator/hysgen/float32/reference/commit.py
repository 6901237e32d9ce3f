"""`<name>_commit` over lanes: a shadow becomes active if its certificates hold (`hysgen.float32.commit_numbers`)."""

from __future__ import annotations

import copy
from collections.abc import Mapping

import numpy as np

from hysgen.float32.commit_numbers import CommitNumbers
from hysgen.float32.learner_status import Commit
from hysgen.float32.reference.arithmetic import Floats32, Words, bits_of
from hysgen.float32.reference.factorised import magnitude
from hysgen.float32.reference.learner import Learner
from hysgen.float32.reference.learner_state import Mask

_HALF = np.float32(0.5)
_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_GROUPS = ("slope", "offset", "gain", "weight")

_NONE, _CHECKED, _WRITTEN, _SWITCHED = (np.uint32(phase) for phase in range(4))
"""Phases: what the next call does with the candidate; 0 takes a new one."""


class Committer:
    """The candidates of (lanes,) learners and the banks of the instances they are committed to.

    bank, banks: by group slope, offset, gain, weight: the candidate's numbers (rows, lanes), and both banks of the
    instance, (2, rows, lanes). active: which of them is in use.
    """

    def __init__(self, numbers: CommitNumbers, learner: Learner) -> None:
        self.numbers, self.learner = numbers, learner
        n, lanes = learner.theta.shape
        self.phase, self.point, self.active = (np.zeros(lanes, np.uint32) for _ in range(3))
        self.theta: Floats32 = np.zeros((n, lanes), np.float32)
        self.gain_rest_um_per_V: Floats32 = np.zeros(lanes, np.float32)
        self.slope_rest: Floats32 = np.zeros((2, lanes), np.float32)
        base = {group: np.repeat(getattr(learner.base, group)[:, None], lanes, axis=1) for group in _GROUPS}
        self.bank: dict[str, Floats32] = {group: np.zeros_like(rows) for group, rows in base.items()}
        self.banks: dict[str, Floats32] = {group: np.stack([rows, rows]) for group, rows in base.items()}

    def commit(self) -> Words:
        """One call for every lane: its answers, (lanes,), of `Commit`."""
        phase = self.phase
        answer = np.full(phase.size, np.uint32(Commit.BUSY))
        answer = self._snapshot(phase == _NONE, answer)
        for _ in range(self.numbers.settings.points_per_call):
            where = (phase == _CHECKED) & (self.phase == _CHECKED) & (answer == Commit.BUSY)
            answer = np.where(where, self._checked(), answer)
            self.point = self.point + where.astype(np.uint32)
            self.phase = np.where(where & (self.point >= self.numbers.points), _WRITTEN, self.phase)
        self.phase = np.where((phase == _CHECKED) & (answer != Commit.BUSY), _NONE, self.phase)
        writing, switching = phase == _WRITTEN, phase == _SWITCHED
        for group, rows in self.bank.items():
            for number in range(2):
                idle = writing & (self.active != number)
                self.banks[group][number] = np.where(idle, rows, self.banks[group][number])
        self.active = np.where(switching, np.uint32(1) - self.active, self.active)
        self.learner.reference = np.where(switching, self.theta, self.learner.reference)
        self.phase = np.where(writing, _SWITCHED, np.where(switching, _NONE, self.phase))
        return np.where(switching, np.uint32(Commit.COMMITTED), answer)

    def verdict(self) -> Words:
        """What the calls to come will answer to the candidates that are being checked: every check point at once."""
        points, lanes = self.numbers.points, self.point.size
        wide = copy.copy(self)
        wide.point = np.repeat(np.arange(points, dtype=np.uint32), lanes)
        wide.bank = {group: np.tile(rows, points) for group, rows in self.bank.items()}
        wide.gain_rest_um_per_V, wide.slope_rest = (
            np.tile(self.gain_rest_um_per_V, points),
            np.tile(self.slope_rest, points),
        )
        found = wide._checked().reshape(points, lanes)
        refused = found != Commit.BUSY
        first = found[refused.argmax(axis=0), np.arange(lanes)]
        return np.where(refused.any(axis=0), first, np.uint32(Commit.COMMITTED))

    def words(self) -> Mapping[str, Words]:
        """Every word of the C struct of the candidate, in its order."""
        named = {"phase": self.phase, "point": self.point, "gain_rest_um_per_V": bits_of(self.gain_rest_um_per_V)}
        named |= {f"slope_rest[{i}]": bits_of(row) for i, row in enumerate(self.slope_rest)}
        named |= {f"theta[{i}]": bits_of(row) for i, row in enumerate(self.theta)}
        for group, rows in self.bank.items():
            named |= {f"bank.{group}[{i}]": bits_of(row) for i, row in enumerate(rows)}
        return named

    def _snapshot(self, where: Mask, answer: Words) -> Words:
        """Take theta where nothing forbids it: too few updates, numbers beyond their limit, weights moved too far."""
        learner, numbers = self.learner, self.numbers
        young = where & (learner.age < numbers.settings.mature)
        where = where & ~young
        self.theta = np.where(where, learner.theta, self.theta)
        self._fold(where)
        beyond = where & (bits_of(magnitude(self.theta)) >= bits_of(np.asarray(learner.numbers.limit_um))).any(axis=0)
        far = where & ~beyond & self._moved_far()
        answer = np.where(young, np.uint32(Commit.REFUSED_YOUNG), answer)
        answer = np.where(beyond, np.uint32(Commit.REFUSED_LIMIT), answer)
        answer = np.where(far, np.uint32(Commit.REFUSED_WEIGHTS), answer)
        where = where & ~beyond & ~far
        self._rests(where)
        self.point = np.where(where, np.uint32(0), self.point)
        self.phase = np.where(where, _CHECKED, self.phase)
        return answer

    def _fold(self, where: Mask) -> None:
        """The numbers of a bank from theta; those that are not learned are the learner's base."""
        learner = self.learner
        for group, rows in self.bank.items():
            base = getattr(learner.base, group)[:, None]
            self.bank[group] = np.where(where, base, rows)
        for i, parameter in enumerate(learner.numbers.parameters):
            if parameter.group == "bias":
                offset = learner.base.offset[:, None] + self.theta[0] * learner.model_numbers.strength[:, None]
                self.bank["offset"] = np.where(where, offset, self.bank["offset"])
                continue
            rows = self.bank["weight" if parameter.group == "terms" else parameter.group]
            number = self.theta[i] * learner.numbers.per_scale[i]
            rows[parameter.index] = np.where(where, number, rows[parameter.index])

    def _moved_far(self) -> Mask:
        """sum_j gamma_j |weight_j - that of the model| beyond the budget."""
        moved = np.zeros_like(self.gain_rest_um_per_V)
        if not self.learner.numbers.learns("terms"):
            return np.zeros(moved.size, np.bool_)
        for j, weight in enumerate(self.bank["weight"]):
            moved = moved + self.numbers.gammas[j] * magnitude(weight - self.numbers.weights[j])
        return np.asarray(moved > self.numbers.weight_budget)

    def _spread(self, y: np.float32, u: np.float32, one: np.float32) -> Floats32:
        """Half the spread over the rules of y q1 + u q2 + one q3."""
        unfold = self.numbers.unfold[:, None]
        v = ((y * self.bank["slope"] + u * self.bank["gain"]) + one * self.bank["offset"]) * unfold
        return np.asarray(_HALF * (v.max(axis=0) - v.min(axis=0)), np.float32)

    def _rests(self, where: Mask) -> None:
        """What Taylor's theorem leaves between the check points."""
        numbers, model = self.numbers, self.learner.model_numbers
        common = numbers.slope_rest_1 * self._spread(_ONE, _ZERO, _ZERO)
        for end, u in enumerate((model.u_min_V, model.u_max_V)):
            corners = [self._spread(y, u, _ONE) for y in (model.y_min_um, model.y_max_um)]
            rest = common + numbers.slope_rest_3 * np.maximum(*corners)
            self.slope_rest[end] = np.where(where, rest, self.slope_rest[end])
        gain = numbers.gain_rest * self._spread(_ZERO, _ONE, _ZERO)
        self.gain_rest_um_per_V = np.where(where, gain, self.gain_rest_um_per_V)

    def _checked(self) -> Words:
        """The answer of each lane at its check point."""
        numbers, model = self.numbers, self.learner.model_numbers
        at = np.minimum(self.point, numbers.points - 1)
        y, rows = numbers.y_um[at], numbers.table[at].reshape(at.size, 3, -1)
        a, b, c = (self._moments(rows, self.bank[group]) for group in ("slope", "gain", "offset"))
        away = numbers.half_um * magnitude(b[1]) + self.gain_rest_um_per_V
        gain = numbers.sign * b[0]
        weak = (gain - away <= numbers.gain_floor) | (gain + away >= numbers.gain_ceiling)
        slope, curve = (a[0] + a[1] * y) + c[1], ((a[1] + a[1]) + a[2] * y) + c[2]
        steep = np.zeros(at.size, np.bool_)
        for end, u in enumerate((model.u_min_V, model.u_max_V)):
            near = numbers.half_um * magnitude(curve + b[2] * u)
            steep |= magnitude(slope + b[1] * u) + (near + self.slope_rest[end]) >= numbers.slope_limit
        steep_or_not = np.where(steep, np.uint32(Commit.REFUSED_SLOPE), np.uint32(Commit.BUSY))
        return np.where(weak, np.uint32(Commit.REFUSED_GAIN), steep_or_not)

    @staticmethod
    def _moments(rows: Floats32, numbers: Floats32) -> list[Floats32]:
        """sum_l p_l g_l, sum_l p_l' g_l, sum_l p_l'' g_l of the lanes, in rising l."""
        sums = []
        for order in range(3):
            total = rows[:, order, 0] * numbers[0]
            for rule in range(1, len(numbers)):
                total = total + rows[:, order, rule] * numbers[rule]
            sums.append(total)
        return sums
