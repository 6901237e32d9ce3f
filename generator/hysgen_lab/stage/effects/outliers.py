"""Outliers: single corrupted samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from hysgen_lab.stage.effects.base import Constants, Effect, Period, Setting, require, require_finite


@dataclass(frozen=True)
class OutliersEffect(Effect):
    """Single corrupted samples: at `rate` per sample a reading jumps by 0.5 to 1.5 times `size_um`, up or down."""

    rate: float
    size_um: float

    name = "outliers"
    rank = 8
    bank_index = 8

    def __post_init__(self) -> None:
        require_finite(self)
        require(0 <= self.rate < 1, f"outliers.rate: {self.rate} is no probability; choose from 0 to below 1")

    @classmethod
    def constants(cls, present: Sequence[Self], period: Period) -> Constants:
        outliers = present[0] if present else OutliersEffect(0.0, 0.0)
        return {"outlier_rate": outliers.rate, "outlier_um": outliers.size_um}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Self:
        return cls(float(rng.uniform(1e-3, 5e-3)), 8.0 * setting.share * setting.span_um)


EFFECT = OutliersEffect
