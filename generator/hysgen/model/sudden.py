"""A sudden change, by least squares: where it lowers an error most, and how much of it shows in the rows around it.

    sum of squares falls by (H e)^2 / (H P H)

e: error; H: the part of the change's effect from a row on; P: the projector off the columns that are fitted beside it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hysgen.record.series import BLOCKS

Floats = NDArray[np.float64]

LEAST_SHARE = 0.5
"""Least share of a sudden change that shows in the rows around it, and largest excess over it."""


def falls_from_each_row(effect: Floats, error: Floats, basis: Floats, barred: Iterable[int], least: float) -> Floats:
    """(n,) fall of the sum of squares by a change at each row; -1 within a block of either end and of `barred` rows.

    effect, error: (n,), the effect before it is cut off; basis: (p, n) orthonormal columns. A block is a 40th of the
    rows, because errors are judged by blocks of this length. least: of H P H, as a part of its largest value.
    """
    n = len(error)
    free = from_each_row(effect**2) - np.sum(from_each_row(effect * basis) ** 2, axis=0)
    falls = from_each_row(effect * error) ** 2 / np.maximum(free, least * free.max() + 1e-300)
    for row in (0, n, *barred):
        falls[max(row - n // BLOCKS - 1, 0) : row + n // BLOCKS + 1] = -1.0
    return np.asarray(falls)


def from_each_row(values: Floats) -> Floats:
    """Sums of the last axis from each row to the end."""
    return np.asarray(np.cumsum(values[..., ::-1], axis=-1)[..., ::-1])


@dataclass(frozen=True)
class Near:
    """A change in the few rows around it.

    share: of the change of the whole fit. power_um2: sum of squares of what the smooth columns do not explain of it;
    left_um2: that of what the change leaves there, on `count` rows.
    """

    share: float
    power_um2: float
    left_um2: float
    count: int

    @classmethod
    def of(cls, effect: Floats, error: Floats, smooth: Floats) -> Self:
        """effect: (m,) of the change; error: (m,) without it; smooth: (p, m) columns that resemble no change."""
        columns = (smooth / (np.linalg.norm(smooth, axis=1, keepdims=True) + 1e-300)).T
        both = np.stack([effect, error], axis=1)
        own, rest = (both - columns @ np.linalg.lstsq(columns, both, rcond=None)[0]).T
        power = float(own @ own) + 1e-300
        share = float(own @ rest) / power
        rest = rest - share * own
        return cls(share, power, float(rest @ rest), len(rest))

    def evidence(self, noise_um: float) -> float:
        """2 ln of the likelihood ratio for the change by these rows alone; 0 where its size is not that of the fit."""
        if abs(self.share - 1.0) > LEAST_SHARE:
            return 0.0
        return self.count * math.log1p(self.share**2 * self.power_um2 / max(self.left_um2, self.count * noise_um**2))
