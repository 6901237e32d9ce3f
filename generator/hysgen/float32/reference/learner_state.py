"""The state of the learner over lanes: initialisation (`<name>_learn_init`), restart, status bits and counters."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.learner_numbers import LearnerNumbers, learner_numbers
from hysgen.float32.learner_words import LearnerWords
from hysgen.float32.reference.instance import Instance
from hysgen.float32.struct_words import Holds, Restart, Start
from hysgen.model.model import Model

Mask = NDArray[np.bool_]

LAST = np.uint32(0xFFFFFFFF)
"""Largest value of a counter."""
_ONE, _ZERO = np.float32(1.0), np.float32(0.0)


class LearnerState(LearnerWords):
    """State of `lanes` learners, initialised from `instance` like `<name>_learn_init(self, model)`."""

    def __init__(self, model: Model, instance: Instance) -> None:
        self.numbers: LearnerNumbers = learner_numbers(model, instance.numbers)
        self.model_numbers = instance.numbers
        self.base = instance.bank
        n, lanes = self.numbers.size, instance.u_V.shape[0]
        starts: dict[Start, Any] = {
            Start.ZERO: _ZERO,
            Start.ONE: _ONE,
            Start.MODEL_Y: instance.y_um,
            Start.MODEL_U: instance.u_V,
        }
        shapes = {Holds.VECTOR: (n, lanes), Holds.MATRIX: (n, n, lanes)}
        for member in self.described():
            if member.holds in (Holds.COUNTERS, Holds.INPUTS, Holds.TERMS):
                continue
            dtype = np.float32 if member.type == "float" else np.uint32
            start, shape = starts[member.start or Start.ZERO], shapes.get(member.holds, (lanes,))
            setattr(self, member.name, start.copy() if np.shape(start) else np.full(shape, start, dtype))
        own = [self._number(i) * self.numbers.scale[i] for i in range(n)]
        self.reference = np.repeat(np.array(own, np.float32)[:, None], lanes, axis=1)
        self.counters = {name: np.zeros(lanes, np.uint32) for name in self.COUNTERS}
        self.inputs, self.terms = copy.deepcopy(instance.inputs), copy.deepcopy(instance.terms)
        self.restart(np.ones(lanes, np.bool_))

    def restart(self, where: Mask) -> None:
        """Reset to the reference parameters and the prior, P = alpha I with U = I."""
        if not where.any():
            return
        numbers = self.numbers
        values: dict[Restart, Any] = {
            Restart.REFERENCE: self.reference,
            Restart.PRIOR: numbers.prior[:, None],
            Restart.LEVEL: numbers.level_um,
        }
        for member in self.described():
            if member.restart is not None:
                zero = _ZERO if member.type == "float" else np.uint32(0)
                value = values.get(member.restart, zero)
                setattr(self, member.name, np.where(where, value, getattr(self, member.name)))
        self.u = np.where(where, _ZERO, self.u)

    def count_event(self, event: str, happened: Mask) -> None:
        """Set the status bit of `event` and increment its counter where `happened`."""
        if not happened.any():
            return
        flag = np.uint32(self.COUNTERS[event].flag)
        self.status = self.status | np.where(happened, flag, np.uint32(0))
        self.count(event, happened)

    def count(self, event: str, happened: Mask) -> None:
        """Increment the counter of `event` where `happened`; counters saturate at LAST."""
        count = self.counters[event]
        self.counters[event] = count + (happened & (count < LAST)).astype(np.uint32)

    def stored(self) -> list[tuple[int, int]]:
        """(i, j) of every U_ij above the diagonal, in the order of the struct: column by column."""
        return [(i, j) for j in range(self.numbers.size) for i in range(j)]

    def _number(self, i: int) -> np.float32:
        """The initial bank number of parameter i; 0 for the bias, which is not part of the bank."""
        parameter = self.numbers.parameters[i]
        table = {"slope": self.base.slope, "gain": self.base.gain, "offset": self.base.offset}
        table |= {"bias": np.zeros(1, np.float32)}
        number: np.float32 = table[parameter.group][parameter.index]
        return number
