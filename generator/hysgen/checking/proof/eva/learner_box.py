"""The box of a learner: for every float of it that decides anything, the interval that it never leaves.

The covariance is left out: U, D and what one update keeps of them (U' x, D U' x, the lower words of the parameters) may
hold any 32 bits, NaN among them. Intervals cannot see why a covariance stays positive; the generated code does not rely
on it either, but looks for what has gone wild and starts again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.checking.proof.eva.banks import committed_box
from hysgen.checking.proof.eva.boxes import parts_box
from hysgen.checking.proof.eva.intervals import hexadecimal
from hysgen.float32.coefficients import coefficients
from hysgen.float32.learner_numbers import FAST, learner_numbers
from hysgen.float32.learner_words import LearnerWords
from hysgen.float32.struct_words import Holds
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.model import Model

WILD: Final = tuple(member.name for member in LearnerWords.described() if member.any_bits)
"""Words that may hold any bits: the covariance, and what is derived from it."""

PARAMETERS: Final = tuple(member.name for member in LearnerWords.described() if member.parameter)
"""Words that hold a parameter each, finite and within its limit."""

REMAINDERS: Final = 1e12
"""Larger than what commit may keep of a candidate between its calls, far from what overflows."""

FIRING: Final = 16.0
"""A rule's regressors stay below this many times their typical size, as an analysis by intervals sees them."""


RATIO: Final = 32.0
"""Of the ends of a piece that a level is looked at in: in one step it loses at most RATIO * FAST of its lower end."""


@dataclass(frozen=True)
class Level:
    """A running level: it stays below `most`, and its box is a little wider, for what intervals cannot see.

    least: of what it follows, where the level must not become negative, for it multiplies its own limit.
    """

    path: str
    most: float
    least: float = 0.0

    @property
    def box(self) -> Interval:
        return Interval(0.5 * self.least if self.least else -self.most / 64.0, 1.02 * self.most).outwards()

    @property
    def borders(self) -> tuple[str, ...]:
        """Between them the step towards the newest value goes one way, or is a small part of the level."""
        count = math.ceil(math.log(self.most / self.least, RATIO)) if self.least else 0
        sizes = [self.least * RATIO**piece for piece in range(count)]
        ends = [f"self->{self.path} < {hexadecimal(size)}" for size in sizes or [0.0]]
        return (*ends, f"self->{self.path} <= {hexadecimal(self.most)}")


@dataclass(frozen=True)
class LearnerBox:
    """floats and integers by C path in `<name>_learner_t`: interval, and largest value. levels: those among them."""

    floats: Mapping[str, Interval]
    integers: Mapping[str, int]
    levels: tuple[Level, ...]


def learner_box(model: Model) -> LearnerBox:
    """Every word of the learner that is not WILD, not of its candidate and not constant."""
    numbers = learner_numbers(model, coefficients(model))
    instance = committed_box(model)
    limit = float(numbers.limit_um)
    y = Interval(float(numbers.y_low_um), float(numbers.y_high_um)).hull(instance["y_um"])
    u = Interval(model.u_min_V, model.u_max_V).outwards().hull(instance["u_V"])
    # Largest |x_j| that learning writes, or putting back the prior: in whose turn, intervals cannot tell.
    regressor = max(FIRING, 1.01 * float(numbers.refresh.max()))
    error = 2.0 * (y.magnitude + numbers.size * regressor * limit) + instance["y_um"].magnitude
    moved = 2.0 * y.magnitude + 1.0
    levels = (
        Level("scale_um", 1.01 * error + 1.0, float(numbers.floor_um)),
        Level("moving_um", moved),
        Level("error", 1.01 * error**2),
        Level("reference_error", 1.01 * error**2),
        Level("step_error", 1.01 * moved**2),
    )
    floats = {f"x[{j}]": symmetric(regressor).outwards() for j in range(numbers.size)}
    floats |= {f"{name}[{j}]": symmetric(limit) for name in PARAMETERS for j in range(numbers.size)}
    floats |= {
        "inflate": Interval(1.0, float(max(numbers.inflate, numbers.inflate_first))),
        "innovation_um": symmetric(error).outwards(),
        "fixed_um": symmetric(instance["y_um"].magnitude),
        "y_um": y,
        "u_V": u,
        "mean_u_V": u.outwards(2.0 * FAST * u.width),
    }
    floats |= {level.path: level.box for level in levels}
    floats |= {path: box for path, box in instance.items() if path.startswith(("terms.", "inputs."))}
    integers = {**parts_box(model).integers, "turn": numbers.size - 1}
    integers |= {member.name: 1 for member in LearnerWords.described() if member.holds is Holds.FLAG}
    return LearnerBox(floats, integers, levels)
