"""Stick-slip: dry friction in the guide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, require, require_finite


@dataclass(frozen=True)
class StickSlipEffect(Effect):
    """Friction: the table sticks until pulled by about `breakaway_um`, then jumps and sticks again.

    left: share of the pull that remains after a jump. scatter: relative spread of the breakaway from jump to jump.
    """

    breakaway_um: float
    left: float = 0.2
    scatter: float = 0.3

    name = "stick_slip"
    in_vocabulary = False
    rank = 10
    bank_index = 13
    longest_substep_s = 100e-6

    def __post_init__(self) -> None:
        require_finite(self)
        require(self.breakaway_um > 0, "stick_slip.breakaway_um: nothing sticks; give a displacement above 0")
        require(0 <= self.left < 1 and 0 <= self.scatter < 1, "stick_slip: left and scatter must lie from 0 to below 1")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        if not present:
            return {}
        (slip,) = present
        return {"stick_um": slip.breakaway_um, "stick_left": slip.left, "stick_scatter": slip.scatter}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """Friction of 2 to 6 % of the stroke."""
        return cls(float(rng.uniform(0.02, 0.06)) * setting.span_um)


EFFECT = StickSlipEffect
