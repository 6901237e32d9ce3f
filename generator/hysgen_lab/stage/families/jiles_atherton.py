"""Jiles-Atherton hysteresis with a susceptibility that is never negative."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.effects.base import require
from hysgen_lab.stage.effects.memory import KIND_JILES_ATHERTON
from hysgen_lab.stage.families.base import Family


@dataclass(frozen=True)
class JilesAtherton(Family):
    """w = slope u + height m, with the magnetisation m of jiles_atherton.c over the field u - centre_V.

    shape_V: of the Langevin curve. pinning_V: of the domain walls. coupling_V: field that m = 1 adds to the field.
    reversible: share of the anhysteretic curve in m. dm/du is bounded and not negative if
    coupling (reversible / (3 shape) + 2 (1 - reversible) / pinning) < 1.
    Source: Jiles and Atherton (1986).
    """

    centre_V: float = 50.0
    shape_V: float = 25.0
    pinning_V: float = 20.0
    coupling_V: float = 5.0
    reversible: float = 0.2

    kind = KIND_JILES_ATHERTON

    def __post_init__(self) -> None:
        steepest = self.reversible / (3 * self.shape_V) + 2 * (1 - self.reversible) / self.pinning_V
        require(self.coupling_V * steepest < 1, "JilesAtherton.coupling_V: the magnetisation jumps; choose less")

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        span_V = high_V - low_V
        shape_V, pinning_V = span_V * float(rng.uniform(0.1, 0.3)), span_V * float(rng.uniform(0.1, 0.35))
        return cls(
            low_V,
            high_V,
            centre_V=low_V + span_V * float(rng.uniform(0.35, 0.65)),
            shape_V=shape_V,
            pinning_V=pinning_V,
            coupling_V=float(rng.uniform(0.05, 0.35)) * pinning_V,
            reversible=float(rng.uniform(0.05, 0.4)),
        )

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        scalars = {
            "grid_low_V": self.low_V - 0.2 * (self.high_V - self.low_V),
            "ja_centre_V": self.centre_V,
            "ja_shape_V": self.shape_V,
            "ja_coupling_V": self.coupling_V,
            "ja_pinning_V": self.pinning_V,
            "ja_reversible": self.reversible,
            "ja_height_um": self.height_um,
        }
        return scalars, {}
