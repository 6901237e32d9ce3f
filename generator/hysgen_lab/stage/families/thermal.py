"""Hysterons that thermal activation switches: hysteresis that depends on the rate, and creep, out of one mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.effects.memory import KIND_THERMAL
from hysgen_lab.stage.families.base import Family, scattered

HYSTERONS = 1024


@dataclass(frozen=True)
class ThermalHysterons(Family):
    """Hysterons of random bias, coercive voltage and barrier; equations in thermal.c.

    bias: Kumaraswamy-distributed over the range, exponents `bias_shape`; coercive voltages: log-logistic of median
    coercive_V, standard deviation `coercive_spread` of the logarithm; barriers, in units of kT and without field:
    log-logistic of median `barrier`, standard deviation `barrier_spread`.
    attempt_per_s: attempts to leave a well per second. hold_s: how long each voltage of a path without time is held.
    substep_s: substep of the plant, within which the output is taken as linear in time.
    Source: Neel (1949); Brown (1963).
    """

    bias_shape: tuple[float, float] = (1.5, 1.5)
    coercive_V: float = 30.0
    coercive_spread: float = 0.5
    barrier: float = 70.0
    barrier_spread: float = 0.4
    attempt_per_s: float = 1e9
    hold_s: float = 1e-3
    substep_s: float = 1e-3
    seed: int = 0

    kind = KIND_THERMAL

    @property
    def longest_substep_s(self) -> float:  # type: ignore[override]
        return self.substep_s

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        return cls(
            low_V,
            high_V,
            bias_shape=(float(rng.uniform(1.0, 3.0)), float(rng.uniform(1.0, 3.0))),
            coercive_V=(high_V - low_V) * float(rng.uniform(0.15, 0.4)),
            coercive_spread=float(rng.uniform(0.3, 0.7)),
            barrier=float(np.exp(rng.uniform(np.log(45), np.log(150)))),
            barrier_spread=float(rng.uniform(0.2, 0.5)),
            attempt_per_s=10 ** float(rng.uniform(3, 6)) / Ts_s,
            hold_s=4 * Ts_s,
            substep_s=0.5 * Ts_s,
            seed=int(rng.integers(2**31)),
        )

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        rng = np.random.default_rng(self.seed)
        unit = scattered(rng, HYSTERONS, 3)
        place = (1 - (1 - unit[:, 0]) ** (1 / self.bias_shape[1])) ** (1 / self.bias_shape[0])
        logistic = np.log(unit[:, 1:] / (1 - unit[:, 1:])) * np.sqrt(3) / np.pi
        coercive_V = self.coercive_V * np.exp(self.coercive_spread * logistic[:, 0])
        arrays = {
            "bias_V": self.low_V + (self.high_V - self.low_V) * (1.2 * place - 0.1),
            "per_coercive_V": 1 / coercive_V,
            "barrier": self.barrier * np.exp(self.barrier_spread * logistic[:, 1]),
            "part_um": self.height_um * rng.uniform(0.3, 1.7, HYSTERONS) / HYSTERONS,
            "up": np.zeros(HYSTERONS),
        }
        return {"hysterons": HYSTERONS, "attempt_per_s": self.attempt_per_s, "dwell_s": self.hold_s}, arrays
