"""The words of the learner over lanes, as `<name>_learner_t` keeps them: begun, counted, written out, taken over."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.learner_numbers import LearnerNumbers, learner_numbers
from hysgen.float32.learner_status import LEARNER_COUNTERS
from hysgen.float32.reference.arithmetic import Floats32, Words, bits_of
from hysgen.float32.reference.instance import Instance
from hysgen.float32.update_schedule import WRITTEN_OUT
from hysgen.model.model import Model
from hysgen.model.path.chain import ChainMirror
from hysgen.model.terms import Mirror

Mask = NDArray[np.bool_]

# The C struct in its order: vectors, single numbers, words.
_VECTORS = ("d", "x", "theta", "theta_low", "reference", "f", "g", "l", "k")
_NUMBERS = ("per_alpha", "inflate", "innovation_um", "fixed_um", "y_um", "u_V", "mean_u_V", "scale_um", "moving_um")
_ERRORS = ("error", "reference_error", "step_error")
_WORDS = ("phase", "fresh", "rested", "measuring", "since_refresh", "turn", "run", "age", "status")

LAST = np.uint32(0xFFFFFFFF)
"""Where a counter stops."""
_ONE, _ZERO = np.float32(1.0), np.float32(0.0)


class LearnerState:
    """State of (lanes,) learners, initialised as `<name>_learn_init(self, model)` does from those of `instance`.

    Matrices are (n, n, lanes), vectors (n, lanes), scalars (lanes,), named as in the C struct.
    """

    def __init__(self, model: Model, instance: Instance) -> None:
        self.numbers: LearnerNumbers = learner_numbers(model, instance.numbers)
        self.model_numbers = instance.numbers
        self.base = instance.bank
        n, lanes = self.numbers.size, instance.u_V.shape[0]
        vector, scalar = np.zeros((n, lanes), np.float32), np.zeros(lanes, np.float32)
        word = np.zeros(lanes, np.uint32)
        start = [self._number(i) * self.numbers.scale[i] for i in range(n)]
        self.reference: Floats32 = np.repeat(np.array(start, np.float32)[:, None], lanes, axis=1)
        self.x, self.f, self.g, self.l, self.k = (vector.copy() for _ in range(5))
        self.theta, self.theta_low, self.d = vector.copy(), vector.copy(), vector.copy()
        self.u: Floats32 = np.zeros((n, n, lanes), np.float32)
        self.per_alpha, self.inflate = scalar + _ONE, scalar + _ONE
        self.innovation_um, self.fixed_um = scalar.copy(), scalar.copy()
        self.y_um, self.u_V, self.mean_u_V = instance.y_um.copy(), instance.u_V.copy(), instance.u_V.copy()
        self.scale_um, self.moving_um = scalar.copy(), scalar.copy()
        self.error, self.reference_error, self.step_error = scalar.copy(), scalar.copy(), scalar.copy()
        self.phase, self.fresh, self.rested, self.measuring = (word.copy() for _ in range(4))
        self.since_refresh, self.turn, self.run, self.age = (word.copy() for _ in range(4))
        self.status: Words = word.copy()
        self.counters: dict[str, Words] = {name: word.copy() for name in LEARNER_COUNTERS}
        self.inputs, self.terms = copy.deepcopy(instance.inputs), copy.deepcopy(instance.terms)
        every = np.ones(lanes, np.bool_)
        self.restart(every)
        self.clear(every, 0, n)
        self.phase = word.copy()

    def words(self) -> Mapping[str, Words]:
        """Every word of the C struct before `base`, in its order; `Instance.words` says how they are named."""
        named: dict[str, Words] = {}
        for name in _VECTORS:
            named |= {f"{name}[{i}]": bits_of(row) for i, row in enumerate(getattr(self, name))}
        named |= {name: bits_of(getattr(self, name)) for name in _NUMBERS + _ERRORS}
        named |= {name: getattr(self, name) for name in _WORDS}
        named |= self.counters
        named |= {f"inputs[{i}]": word.view(np.uint32) for i, word in enumerate(self.inputs.state())}
        for place, term in enumerate(self.terms):
            named |= {f"terms[{place}][{i}]": word.view(np.uint32) for i, word in enumerate(term.state())}
        return named | {f"u[{i},{j}]": bits_of(self.u[i, j]) for i, j in self._stored()}

    def restore(self, words: Sequence[Words]) -> None:
        """Take over the states whose `words` are given, in their order, (lanes,) each, any number of lanes."""
        left = iter(words)
        for name in _VECTORS:
            setattr(self, name, np.stack([next(left) for _ in range(self.numbers.size)]).view(np.float32))
        for name in _NUMBERS + _ERRORS:
            setattr(self, name, next(left).view(np.float32))
        for name in _WORDS:
            setattr(self, name, next(left))
        self.counters = {name: next(left) for name in self.counters}
        mirrors: list[ChainMirror | Mirror] = [self.inputs, *self.terms]
        for mirror in mirrors:
            mirror.restore([next(left) for _ in mirror.state()])
        self.u = np.zeros((self.numbers.size, self.numbers.size, words[0].size), np.float32)
        for i, j in self._stored():
            self.u[i, j] = next(left).view(np.float32)

    def restart(self, where: Mask) -> None:
        """The reference parameters and the prior; U at once, or in the calls to come."""
        if not where.any():
            return
        numbers = self.numbers
        self.theta = np.where(where, self.reference, self.theta)
        self.theta_low = np.where(where, _ZERO, self.theta_low)
        self.d = np.where(where, numbers.prior[:, None], self.d)
        for name in ("scale_um", "moving_um"):
            setattr(self, name, np.where(where, numbers.level_um, getattr(self, name)))
        for name in _ERRORS:
            setattr(self, name, np.where(where, _ZERO, getattr(self, name)))
        for name in ("run", "age"):
            setattr(self, name, np.where(where, np.uint32(0), getattr(self, name)))
        if numbers.spread.at_once:
            self.clear(where, 0, numbers.size)
            self.phase = np.where(where, np.uint32(0), self.phase)
        else:
            self.phase = np.where(where, np.uint32(numbers.spread.clearing), self.phase)

    def clear(self, where: Mask, first: int, last: int) -> None:
        """U = I in columns first .. last - 1; packed columns have no diagonal."""
        columns = slice(first, last)
        self.u[:, columns] = np.where(where, _ZERO, self.u[:, columns])
        if self.numbers.size > WRITTEN_OUT:
            diagonal = np.arange(first, last)
            self.u[diagonal, diagonal] = np.where(where, _ONE, self.u[diagonal, diagonal])

    def note(self, event: str, happened: Mask) -> None:
        """Set the bit of `event` and step its counter up to its largest value."""
        if not happened.any():
            return
        bit = LEARNER_COUNTERS[event]
        self.status = self.status | np.where(happened, np.uint32(bit or 0), np.uint32(0))
        self.count(event, happened)

    def count(self, event: str, happened: Mask) -> None:
        """Step the counter of `event` where it happened."""
        count = self.counters[event]
        self.counters[event] = count + (happened & (count < LAST)).astype(np.uint32)

    def _stored(self) -> list[tuple[int, int]]:
        """(i, j) of every U_ij that the C keeps, in its order: packed columns, or whole ones."""
        n = self.numbers.size
        packed = n <= WRITTEN_OUT
        return [(i, j) for j in range(n) for i in range(j if packed else n)]

    def _number(self, i: int) -> np.float32:
        """What the bank holds of parameter i; 0 for the bias, which it does not hold."""
        parameter = self.numbers.parameters[i]
        table = {"slope": self.base.slope, "gain": self.base.gain, "offset": self.base.offset}
        table |= {"terms": self.base.weight, "bias": np.zeros(1, np.float32)}
        return np.float32(table[parameter.group][parameter.index])
