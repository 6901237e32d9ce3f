"""Preisach hysteresis by single relays, each finer than the noise of the sensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.effects.memory import KIND_RELAYS
from hysgen_lab.stage.families.base import Family, scattered

RELAYS = 60_000
"""Number of relays: each moves the output by less than half the rms of the noise."""


@dataclass(frozen=True)
class RandomRelays(Family):
    """Relays that switch on at bias + coercive and off at bias - coercive, in V, with random weights.

    bias: Kumaraswamy-distributed over the range, exponents `bias_shape`. coercive: Weibull-distributed, scale
    coercive_V, exponent `coercive_shape`, narrower by the share `pinched` at the ends of the range. weights: uniform,
    0.3 to 1.7 of their mean. seed: of thresholds and weights.
    Source: Preisach (1935).
    """

    bias_shape: tuple[float, float] = (1.5, 1.5)
    coercive_V: float = 10.0
    coercive_shape: float = 1.2
    pinched: float = 0.0
    seed: int = 0

    kind = KIND_RELAYS

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        return cls(
            low_V,
            high_V,
            bias_shape=(float(rng.uniform(1.0, 3.0)), float(rng.uniform(1.0, 3.0))),
            coercive_V=(high_V - low_V) * float(rng.uniform(0.06, 0.25)),
            coercive_shape=float(rng.uniform(0.8, 2.0)),
            pinched=float(rng.uniform(0.0, 0.7)),
            seed=int(rng.integers(2**31)),
        )

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        rng = np.random.default_rng(self.seed)
        unit = scattered(rng, RELAYS, 2)
        place = (1 - (1 - unit[:, 0]) ** (1 / self.bias_shape[1])) ** (1 / self.bias_shape[0])
        width = self.coercive_V * (-np.log1p(-unit[:, 1])) ** (1 / self.coercive_shape)
        width *= 1 - self.pinched * (2 * place - 1) ** 2
        bias_V = self.low_V + (self.high_V - self.low_V) * (1.2 * place - 0.1)
        up_V, down_V = bias_V + width, bias_V - width
        weight_um = self.height_um * rng.uniform(0.3, 1.7, RELAYS) / RELAYS
        order = np.argsort(up_V, kind="stable")
        down_V = down_V[order]
        arrays: dict[str, NDArray[Any]] = {
            "up_V": up_V[order],
            "down_V": down_V,
            "weight_um": weight_um,
            "down_order": np.argsort(down_V, kind="stable").astype(np.int32),
            "on": np.zeros(RELAYS, dtype=np.uint8),
        }
        return {"relays": RELAYS}, arrays
