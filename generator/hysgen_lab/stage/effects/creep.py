"""Creep: the output keeps moving after a step, by an equal share in every decade of time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import exp1

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, Tolerance, require, require_finite

NODES_PER_DECADE = 6  # quadrature of the spectrum: error below 1e-7 of the creep (tested)


@dataclass(frozen=True)
class CreepEffect(Effect):
    """Logarithmic creep: a continuous, flat spectrum of relaxation times in ln(tau) between two cut-offs.

        moved(t) = (per_decade / ln 10) * integral from tau_min to tau_max of (tau/tau_m)^p (1 - exp(-t/tau)) dtau/tau

    per_decade: share of a step's size by which the output moves on in every decade of time between the cut-offs.
    tau_min_s, tau_max_s: where the logarithmic law begins and ends. Movement counts from the rest before the record.
    exponent: p, of a power law (t/tau_m)^p about the geometric mean tau_m of the cut-offs; 0: logarithmic creep.
    Source: the usual law y0 (1 + g log10(t/t0)); Findley (1976) for the power law.
    """

    per_decade: float
    tau_min_s: float = 0.01
    tau_max_s: float = 1000.0
    exponent: float = 0.0

    name = "creep"
    rank = 4
    bank_index = 0
    longest_substep_s = 100e-6
    # from_s, the lower cut-off, is where the diagnosis starts a discrete spectrum: no number to compare.
    tolerances: ClassVar = {"creep.per_decade": Tolerance(0.15), "creep.from_s": None}

    def __post_init__(self) -> None:
        require_finite(self)
        require(0 < self.tau_min_s < self.tau_max_s, "creep: 0 < tau_min_s < tau_max_s must hold; widen the spectrum")

    @property
    def decades(self) -> float:
        """Width of the spectrum; the creep that is left to do after a step is per_decade * decades of its size."""
        return math.log10(self.tau_max_s / self.tau_min_s)

    def moved(self, t_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Share of a unit step that creep has added t_s > 0 after it, in closed form: shape of `t_s`.

        Raises StageError for a power law, which has no closed form here.
        """
        require(self.exponent == 0.0, "creep.moved: a power law has no closed form; choose exponent 0")
        late = exp1(t_s / self.tau_max_s) - exp1(t_s / self.tau_min_s)
        moved: NDArray[np.float64] = self.per_decade * (self.decades - late / math.log(10.0))
        return moved

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        """Gauss-Legendre quadrature, in ln(tau), of the continuous spectrum: n relaxations of constant weights."""
        if not present:
            return {}
        (creep,) = present
        count = max(6, math.ceil(NODES_PER_DECADE * creep.decades))
        place, weight = (np.asarray(part, dtype=np.float64) for part in np.polynomial.legendre.leggauss(count))
        tau_s = creep.tau_min_s * 10 ** (creep.decades * (place + 1) / 2)
        ratio = period.h_s[:, None] / tau_s
        gone = -np.expm1(-ratio)
        # Exact for an input linear in time: its begin counts gone/ratio - exp(-ratio), its end 1 - gone/ratio.
        g1 = 1 - gone / ratio
        return {
            "creeps": count,
            "creep_keep": np.exp(-ratio),
            "creep_g0": gone - g1,
            "creep_g1": g1,
            "creep_share": creep.per_decade
            * creep.decades
            * (weight / 2)
            * (tau_s / math.sqrt(creep.tau_min_s * creep.tau_max_s)) ** creep.exponent,
            "creep_x": np.zeros(count),
        }

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        """Creep that begins within the record and goes on long after it."""
        return cls(setting.share * 0.8, setting.span_s / 400.0, 1000.0 * setting.span_s)

    def true_parameters(self) -> dict[str, float]:
        return {"creep.per_decade": self.per_decade, "creep.from_s": self.tau_min_s} if self.exponent == 0.0 else {}


EFFECT = CreepEffect
