"""Bouc-Wen hysteresis with an exponent, whose output rises after every turn of the input."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.effects.memory import KIND_BOUC_WEN
from hysgen_lab.stage.families.base import Family


@dataclass(frozen=True)
class RisingBoucWen(Family):
    """w = slope u - z,  dz/du = (height / reach) (1 - (balance sign(z du) + 1 - balance) |z / height|^exponent).

    dw/du > 0 on every path if the slope exceeds (height / reach) max(1, 2 balance), the rate of z after a turn.
    With exponent 1 and balance 1 it would be a Duhem operator that decays with the path; neither is drawn.
    Source: Wen (1976); Low and Guo (1995) for piezo actuators.
    """

    reach_V: float = 20.0
    balance: float = 0.6
    exponent: float = 1.5

    kind = KIND_BOUC_WEN

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        span_V = high_V - low_V
        return cls(
            low_V,
            high_V,
            reach_V=span_V * float(np.exp(rng.uniform(np.log(0.08), np.log(0.4)))),
            balance=float(rng.uniform(0.5, 0.85)),
            exponent=float(rng.uniform(1.1, 2.0)),
        )

    @property
    def steepest_fall_um_per_V(self) -> float:
        return self.height_um / self.reach_V * max(1.0, 2 * self.balance)

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        first = self.height_um / self.reach_V
        total = first / self.height_um**self.exponent
        scalars = {
            "grid_low_V": self.low_V - 0.2 * (self.high_V - self.low_V),
            "bw_a": first,
            "bw_beta": self.balance * total,
            "bw_gamma": (1 - self.balance) * total,
            "bw_n": self.exponent,
        }
        return scalars, {}
