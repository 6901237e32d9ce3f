"""A model's learner on the simulated C674x, as one side of `hysgen.checking.bits.learning_run`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.functions import LEARNER, MODEL
from hysgen.checking.host import Host
from hysgen_c674x.machine import CallOutcomes, Machine

Words = NDArray[np.uint32]


class CycleRange:
    """Fewest and most cycles of all added calls."""

    def __init__(self) -> None:
        self.least, self.most = 1 << 62, 0

    def add(self, cycles: NDArray[np.int64]) -> None:
        self.least, self.most = min(self.least, int(cycles.min())), max(self.most, int(cycles.max()))

    @property
    def range(self) -> tuple[int, int]:
        return self.least, self.most


class SimulatedSide:
    """An instance and its learner in the memory of `machine`, with the host's initial states.

    learning, committing: cycles of the calls of learn and of commit.
    """

    name = "c674x"

    def __init__(self, host: Host, machine: Machine) -> None:
        self._machine, self._prefix, self._channels = machine, host.name, host.channels
        self.learning, self.committing = CycleRange(), CycleRange()
        starts = [host.words_of(MODEL.create(host)).copy(), host.words_of(LEARNER.create(host)).copy()]
        self._sizes = [start.size for start in starts]
        self._instance, self._learner = (machine.allocate(size) for size in self._sizes)
        machine.write(self._instance, starts[0])
        machine.write(self._learner, starts[1])

    def learn(self, y: Words, u: Words) -> Words:
        outcomes = self._map("learn", self._learner, y, u, self._sizes[1])
        self.learning.add(outcomes.cycles)
        return outcomes.memory[self._learner]

    def commit(self) -> int:
        outcome = self._machine.call(f"{self._prefix}_commit", self._instance, self._learner)
        self.committing.add(np.array([outcome.cycles]))
        return outcome.bits

    def predict(self, y: Words, u: Words) -> Words:
        bits = np.empty_like(y)
        channels = self._machine.allocate(self._channels) if self._channels else 0
        for k in range(y.size):
            if self._channels:
                self._machine.call(f"{self._prefix}_aux", self._instance, channels)
            bits[k] = self._map("predict", self._instance, y[k : k + 1], u[k : k + 1], 0).bits[0]
        return bits

    def words(self) -> Words:
        places = zip((self._instance, self._learner), self._sizes, strict=True)
        return np.concatenate([self._machine.read(place, size, np.uint32) for place, size in places])

    def _map(self, function: str, struct: int, y: Words, u: Words, words: int) -> CallOutcomes:
        columns = [column.view(np.float32) for column in (y, u)]
        return self._machine.map(f"{self._prefix}_{function}", struct, *columns, read={struct: words} if words else {})
