"""`<name>_commit` over lanes: the check of a shadow against `hysgen.float32.coefficients`, and its activation."""

import copy
from collections.abc import Mapping

import numpy as np

from hysgen.float32.coefficients import CommitNumbers
from hysgen.float32.reference.learner import Learner, Mask, magnitude
from hysgen.float32.struct_words import Commit, Phase
from hysgen.model.float32_arithmetic import Floats32, Words, bits_of

_HALF = np.float32(0.5)
_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_GROUPS = ("slope", "offset", "gain", "weight")


class Committer:
    """The candidates of (lanes,) learners, and both banks of the instances.

    bank: the candidate's numbers, (rows, lanes) for each group slope, offset, gain, weight. banks: both banks of the
    instance, (2, rows, lanes) for each group. active: (lanes,) index of the bank in use. phase: (lanes,) 0 to 4.
    """

    def __init__(self, numbers: CommitNumbers, learner: Learner) -> None:
        self.numbers, self.learner = numbers, learner
        lanes = learner.theta.shape[1]
        self.phase, self.point, self.active = (np.zeros(lanes, np.uint32) for _ in range(3))
        self.gain_remainder_um_per_V: Floats32 = np.zeros(lanes, np.float32)
        self.slope_remainder: Floats32 = np.zeros((2, lanes), np.float32)
        base = {group: np.repeat(getattr(learner.base, group)[:, None], lanes, axis=1) for group in _GROUPS}
        self.bank: dict[str, Floats32] = {group: np.zeros_like(rows) for group, rows in base.items()}
        self.banks: dict[str, Floats32] = {group: np.stack([rows, rows]) for group, rows in base.items()}

    def commit(self) -> Words:
        """One call in every lane; returns the values of `Commit`, (lanes,)."""
        phase = self.phase
        answer = np.full(phase.size, np.uint32(Commit.BUSY))
        answer = self._snapshot(phase == Phase.IDLE, answer)
        for _ in range(self.numbers.settings.points_per_call):
            where = (phase == Phase.CHECK) & (self.phase == Phase.CHECK) & (answer == Commit.BUSY)
            answer = np.where(where, self._answer_at_point(), answer)
            self.point = self.point + where.astype(np.uint32)
            self.phase = np.where(where & (self.point >= self.numbers.points), np.uint32(Phase.TRIAL), self.phase)
        answer = self._judge_trial(phase == Phase.TRIAL, answer)
        self.phase = np.where((phase == Phase.CHECK) & (answer != Commit.BUSY), np.uint32(Phase.IDLE), self.phase)
        writing, switching = phase == Phase.WRITE, phase == Phase.SWITCH
        for group, rows in self.bank.items():
            for number in range(2):
                idle = writing & (self.active != number)
                self.banks[group][number] = np.where(idle, rows, self.banks[group][number])
        self.active = np.where(switching, np.uint32(1) - self.active, self.active)
        self.learner.reference = np.where(switching, self.learner.trial, self.learner.reference)
        self.phase = np.where(writing, np.uint32(Phase.SWITCH), np.where(switching, np.uint32(Phase.IDLE), self.phase))
        return np.where(switching, np.uint32(Commit.COMMITTED), answer)

    def verdict(self) -> Words:
        """The final return values, (lanes,), for the candidates being checked: all check points evaluated at once."""
        points, lanes = self.numbers.points, self.point.size
        wide = copy.copy(self)
        wide.point = np.repeat(np.arange(points, dtype=np.uint32), lanes)
        wide.bank = {group: np.tile(rows, points) for group, rows in self.bank.items()}
        wide.gain_remainder_um_per_V, wide.slope_remainder = (
            np.tile(self.gain_remainder_um_per_V, points),
            np.tile(self.slope_remainder, points),
        )
        answers = wide._answer_at_point().reshape(points, lanes)
        refused = answers != Commit.BUSY
        first = answers[refused.argmax(axis=0), np.arange(lanes)]
        return np.where(refused.any(axis=0), first, np.uint32(Commit.COMMITTED))

    def words(self) -> Mapping[str, Words]:
        """The bit patterns of `<name>_candidate_t` by C path, in the order of the struct, (lanes,) each."""
        named = {
            "phase": self.phase,
            "point": self.point,
            "gain_remainder_um_per_V": bits_of(self.gain_remainder_um_per_V),
        }
        named |= {f"slope_remainder[{i}]": bits_of(row) for i, row in enumerate(self.slope_remainder)}
        for group, rows in self.bank.items():
            named |= {f"bank.{group}[{i}]": bits_of(row) for i, row in enumerate(rows)}
        return named

    def _snapshot(self, where: Mask, answer: Words) -> Words:
        """Copy theta for a trial; refuse too few updates and numbers above the limit."""
        learner, numbers = self.learner, self.numbers
        young = where & (learner.age < numbers.settings.mature)
        where = where & ~young
        learner.trial = np.where(where, learner.theta, learner.trial)
        self._fold(where)
        beyond = where & (bits_of(magnitude(learner.trial)) >= bits_of(np.asarray(learner.numbers.limit_um))).any(
            axis=0
        )
        answer = np.where(young, np.uint32(Commit.REFUSED_YOUNG), answer)
        answer = np.where(beyond, np.uint32(Commit.REFUSED_LIMIT), answer)
        where = where & ~beyond
        self._bound_remainders(where)
        learner.begin_trial(where, self.numbers.trial)
        self.point = np.where(where, np.uint32(0), self.point)
        self.phase = np.where(where, np.uint32(Phase.CHECK), self.phase)
        return answer

    def _judge_trial(self, where: Mask, answer: Words) -> Words:
        """TRYING before the last sample of the trial; then REFUSED_WORSE, or on to WRITE."""
        learner = self.learner
        done = learner.trying == 0
        worse = done & (learner.trial_error > learner.trial_reference_error)
        following = np.where(worse, np.uint32(Phase.IDLE), np.where(done, np.uint32(Phase.WRITE), self.phase))
        self.phase = np.where(where, following, self.phase)
        judged = np.where(worse, np.uint32(Commit.REFUSED_WORSE), np.where(done, answer, np.uint32(Commit.TRYING)))
        return np.where(where, judged, answer)

    def _fold(self, where: Mask) -> None:
        """Compute the candidate's bank from the copy; what is not learned comes from the learner's base bank."""
        learner = self.learner
        for group, rows in self.bank.items():
            base = getattr(learner.base, group)[:, None]
            self.bank[group] = np.where(where, base, rows)
        for i, parameter in enumerate(learner.numbers.parameters):
            if parameter.group == "bias":
                offset = learner.base.offset[:, None] + learner.trial[0] * learner.model_numbers.strength[:, None]
                self.bank["offset"] = np.where(where, offset, self.bank["offset"])
                continue
            rows = self.bank[parameter.group]
            number = learner.trial[i] * learner.numbers.per_scale[i]
            rows[parameter.index] = np.where(where, number, rows[parameter.index])

    def _half_span(self, y: np.float32, u: np.float32, unit: np.float32) -> Floats32:
        """R(g) = (max_l g_l - min_l g_l)/2 of g = y q1 + u q2 + unit q3, (lanes,)."""
        unfold = self.numbers.unfold[:, None]
        v = ((y * self.bank["slope"] + u * self.bank["gain"]) + unit * self.bank["offset"]) * unfold
        return np.asarray(_HALF * (v.max(axis=0) - v.min(axis=0)), np.float32)

    def _bound_remainders(self, where: Mask) -> None:
        """Bounds of the Taylor remainders of gain and slope within half a cell of a check point."""
        numbers, model = self.numbers, self.learner.model_numbers
        common = numbers.slope_remainder_1 * self._half_span(_ONE, _ZERO, _ZERO)
        for end, u in enumerate((model.w_min, model.w_max)):
            corners = [self._half_span(y, u, _ONE) for y in (model.y_min_um, model.y_max_um)]
            rest = common + numbers.slope_remainder_3 * np.maximum(*corners)
            self.slope_remainder[end] = np.where(where, rest, self.slope_remainder[end])
        gain = numbers.gain_remainder * self._half_span(_ZERO, _ONE, _ZERO)
        self.gain_remainder_um_per_V = np.where(where, gain, self.gain_remainder_um_per_V)

    def _answer_at_point(self) -> Words:
        """REFUSED_GAIN, REFUSED_SLOPE or, within the limits, BUSY for each lane at its check point."""
        numbers, model = self.numbers, self.learner.model_numbers
        at = np.minimum(self.point, numbers.points - 1)
        y, rows = numbers.y_um[at], numbers.table[at].reshape(at.size, 3, -1)
        a, b, c = (self._weighted_sums(rows, self.bank[group]) for group in ("slope", "gain", "offset"))
        away = numbers.half_um * magnitude(b[1]) + self.gain_remainder_um_per_V
        gain = numbers.sign * b[0]
        weak = (gain - away <= numbers.gain_floor) | (gain + away >= numbers.gain_ceiling)
        slope, curve = (a[0] + a[1] * y) + c[1], ((a[1] + a[1]) + a[2] * y) + c[2]
        steep = np.zeros(at.size, np.bool_)
        for end, u in enumerate((model.w_min, model.w_max)):
            near = numbers.half_um * magnitude(curve + b[2] * u)
            change = magnitude(slope + b[1] * u) + (near + self.slope_remainder[end])
            steep = steep | (change >= numbers.slope_limit)
        steep_or_not = np.where(steep, np.uint32(Commit.REFUSED_SLOPE), np.uint32(Commit.BUSY))
        return np.where(weak, np.uint32(Commit.REFUSED_GAIN), steep_or_not)

    @staticmethod
    def _weighted_sums(rows: Floats32, numbers: Floats32) -> list[Floats32]:
        """sum_l p_l g_l, sum_l p_l' g_l, sum_l p_l'' g_l, (lanes,) each, summed in ascending order of l."""
        sums = []
        for order in range(3):
            total = np.zeros_like(numbers[0])
            for rule, number in enumerate(numbers):
                total = total + rows[:, order, rule] * number
            sums.append(total)
        return sums
