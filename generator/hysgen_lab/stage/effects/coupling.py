"""Coupling: other measured channels move this axis."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, require

BANK_RANGE = 30.0
"""Standard deviation, roughly, of the bank's further channels, in their unit."""


@dataclass(frozen=True)
class CouplingEffect(Effect):
    """Other measured channels bend this axis, through the same mechanics: um per unit of each named channel."""

    um_per_unit: Mapping[str, float]

    name = "coupling"
    rank = 9
    bank_index = 9
    needs_channel = True

    def __post_init__(self) -> None:
        require(len(self.um_per_unit) > 0, "coupling: no channel named; give a mapping such as {'axis2_V': 0.004}")
        for name, gain in self.um_per_unit.items():
            require(math.isfinite(gain), f"coupling: gain {gain} of channel {name} is not finite; give a real number")
        object.__setattr__(self, "um_per_unit", MappingProxyType(dict(self.um_per_unit)))

    def __hash__(self) -> int:
        return hash(tuple(self.um_per_unit.items()))

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.um_per_unit)

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        gains = np.array([gain for coupling in present for gain in coupling.um_per_unit.values()], dtype=np.float64)
        return {"channels": len(gains), "coupling_um": gains, "channel": np.zeros(len(gains))}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """A coupling of either sign to the first further channel."""
        return cls({setting.channels[0]: float(rng.choice([-1, 1])) * setting.share * setting.span_um / BANK_RANGE})

    def true_parameters(self) -> dict[str, float]:
        return {f"coupling.{name}_um_per_unit": gain for name, gain in self.um_per_unit.items()}


EFFECT = CouplingEffect
