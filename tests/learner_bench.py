"""Learners that the tests look at: sizes, a plant to learn from, and generated C beside its reference."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from generated_models import smooth
from numpy.typing import NDArray

from hysgen.emit import Options, generate
from hysgen.host import Host
from hysgen.learning import LearnerSettings
from hysgen.model import Model
from hysgen.native import Toolchain
from hysgen.reference.instance import Instance
from hysgen.reference.learner import Learner
from hysgen.terms.memory import Memory

Floats32 = NDArray[np.float32]

ANY_CLOCK = Options(clock_Hz=1e10)
"""The host is not bound to the DSP's budget."""

START_UM, START_V = np.float32(2.0), np.float32(30.0)

SIZES = {6: (2, 0), 18: (6, 0), 24: (8, 0), 40: (10, 10)}
"""Parameters -> rules and plays."""


def sized(parameters: int, **settings: Any) -> Model:
    """A model with so many parameters, all of them learned."""
    rules, plays = SIZES[parameters]
    model = smooth(rules, (Memory.uniform(plays, 60.0),) if plays else ())
    return dataclasses.replace(model, learner=LearnerSettings(**settings))


def texts_of(model: Model) -> dict[str, str]:
    return generate(model, ANY_CLOCK)


class Pair:
    """A compiled learner and its reference, side by side."""

    def __init__(
        self, model: Model, texts: Mapping[str, str] | None = None, toolchain: Toolchain | None = None
    ) -> None:
        self.model = model
        self.host = Host(model.name, texts or texts_of(model), toolchain)
        self.instance = self.host.instance(float(START_UM), float(START_V))
        self.learner = self.host.struct(f"{model.name}_learner_t")
        self.host.call("learn_init", self.learner, self.instance)
        self.lane = Learner(model, Instance(model, np.full(1, START_UM), np.full(1, START_V)))

    @property
    def words(self) -> int:
        """How many words of the struct are compared."""
        return len(self.lane.words())

    def run(self, y_um: Floats32, u_V: Floats32) -> NDArray[np.uint32]:
        """The compiled learner's compared words after each sample, (n, words)."""
        columns = [y_um.view(np.uint32), u_V.view(np.uint32)]
        return self.host.run("learn", self.learner, columns, words=self.words)[1]

    def expected(self) -> NDArray[np.uint32]:
        """The reference's words now."""
        return np.array([word[0] for word in self.lane.words().values()], dtype=np.uint32)

    def first_difference(self, y_um: Floats32, u_V: Floats32) -> str | None:
        """Sample and word at which the two part, or None."""
        for k, got in enumerate(self.run(y_um, u_V)):
            self.lane.learn(y_um[k : k + 1], u_V[k : k + 1])
            wrong = np.flatnonzero(got != self.expected())
            if wrong.size:
                return f"sample {k}: {list(self.lane.words())[wrong[0]]}"
        return None


def lagging(samples: int, seed: int = 1, noise_um: float = 5e-4) -> tuple[Floats32, Floats32]:
    """Displacement and voltage of a curved first-order lag under two beating sines, inside 0.5 .. 9 um."""
    rng = np.random.default_rng(seed)
    k = np.arange(samples)
    u = 50.0 + 40.0 * np.sin(2.0 * np.pi * k / 211.0) * np.sin(2.0 * np.pi * k / 1711.0)
    y, state = np.empty(samples), 3.0
    for i in range(samples):
        y[i] = state
        state += 0.03 * (0.6 + 0.07 * u[i] + 0.2 * np.sin(0.1 * u[i]) - state)
    return (y + noise_um * rng.standard_normal(samples)).astype(np.float32), u.astype(np.float32)


def corrupted(samples: int, seed: int = 1) -> tuple[Floats32, Floats32]:
    """`lagging` with everything in it that a learner has to survive."""
    y, u = lagging(samples, seed)
    y[101::397], y[205::331], u[57::433], u[88::517] = np.nan, 1e30, np.inf, 1e6
    y[77::211] += np.float32(0.7)
    y[samples // 3 : samples // 3 + 40] = 9.5
    rest = slice(samples // 2, samples // 2 + 300)
    u[rest] = u[rest.start]
    return y, u
