"""Preisach hysteresis with a continuous density that is no product, integrated on a mesh of the Preisach plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hysgen_lab.stage.effects.memory import KIND_MESH
from hysgen_lab.stage.families.base import Family

Floats = NDArray[np.float64]

CELLS = 560
MARGIN = 0.2
"""Cells of the mesh along each axis, over the voltage range and this share of it beyond each end."""


@dataclass(frozen=True)
class MeshPreisach(Family):
    """Preisach density of groups of relays in coercive voltage h and bias c, alpha = c + h, beta = c - h:

        mu(alpha, beta) = sum_g weight_g exp(-(c - bias_g - tilt_g h)^2 / (2 width_g^2)) f_g(h / coercive_g)

    f_g(s) = exp(-ln(s)^2 / (2 spread_g^2)) / s, a log-normal density, or 1 / (1 + s^2)^2 if spread_g = 0. A tilt makes
    wide relays stand elsewhere than narrow ones. groups: (weight, bias_V, width_V, tilt, coercive_V, spread) of each.
    Source: Mayergoyz, Mathematical Models of Hysteresis, chapter 1; Della Torre for the coordinates.
    """

    groups: tuple[tuple[float, float, float, float, float, float], ...] = ()

    kind = KIND_MESH

    @classmethod
    def drawn(cls, rng: np.random.Generator, low_V: float, high_V: float, Ts_s: float) -> Self:
        span_V = high_V - low_V
        groups = []
        for shape in (0.0, *rng.uniform(0.3, 0.8, rng.integers(1, 4))):
            bias_V, width_V = low_V + span_V * rng.uniform(0.2, 0.8), span_V * rng.uniform(0.15, 0.5)
            tilt, coercive_V = rng.uniform(-0.6, 0.6), span_V * np.exp(rng.uniform(np.log(0.05), np.log(0.25)))
            weight = rng.uniform(0.4, 1.0) / (width_V * coercive_V)
            groups.append((float(weight), float(bias_V), width_V, float(tilt), float(coercive_V), float(shape)))
        return cls(low_V, high_V, groups=tuple(groups))

    def density(self, alpha_V: Floats, beta_V: Floats) -> Floats:
        """mu at each point, mirrored beyond the diagonal of the plane: the shape of alpha_V."""
        c, h = (alpha_V + beta_V) / 2, np.abs(alpha_V - beta_V) / 2
        total = np.zeros(np.shape(h))
        for weight, bias_V, width_V, tilt, coercive_V, spread in self.groups:
            s = h / coercive_V + 1e-9
            sizes = np.exp(-(np.log(s) ** 2) / (2 * spread**2)) / s if spread else (1 + s**2) ** -2
            total += weight * np.exp(-((c - bias_V - tilt * h) ** 2) / (2 * width_V**2)) * sizes
        return total

    def equation(self) -> tuple[dict[str, float], dict[str, NDArray[Any]]]:
        span_V = self.high_V - self.low_V
        step_V = span_V * (1 + 2 * MARGIN) / CELLS
        first_V = self.low_V - MARGIN * span_V
        # Four points in each cell.
        at_V = first_V + step_V * (np.arange(2 * CELLS) + 0.5) / 2
        mass = self.density(at_V[:, None], at_V).reshape(CELLS, 2, CELLS, 2).mean(axis=(1, 3)) * step_V**2
        corner = np.zeros((CELLS + 1, CELLS + 1))
        corner[1:, 1:] = self.height_um * mass.cumsum(axis=0).cumsum(axis=1)
        i = np.arange(CELLS)
        rise = corner[i + 1, i] - corner[i, i] + 0.5 * self.height_um * np.diag(mass)
        diagonal = np.concatenate(([0.0], np.cumsum(rise)))
        scalars = {"grid_low_V": first_V, "grid_step_V": step_V, "grid_n": CELLS + 1}
        return scalars, {"corner": corner, "diagonal": diagonal}
