"""Aging: the ceramic's gain changes during the record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, require, require_finite


@dataclass(frozen=True)
class AgingEffect(Effect):
    """The ceramic's gain goes linearly from 1 to 1 + fraction in the first `over_s` of the record, then stays."""

    fraction: float
    over_s: float

    name = "aging"
    rank = 7
    bank_index = 7

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.over_s > 0, f"aging.over_s: {self.over_s} s is no time; give a span above 0")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        aging = present[0] if present else AgingEffect(0.0, 1.0)
        return {"age_fraction": aging.fraction, "age_s": aging.over_s}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A gain that rises or falls over the whole record."""
        return cls(float(rng.choice([-1, 1])) * 2.0 * setting.share, setting.span_s)

    def true_parameters(self) -> dict[str, float]:
        return {"aging.per_s": self.fraction / self.over_s}


EFFECT = AgingEffect
