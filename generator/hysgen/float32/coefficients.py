"""The float32 numbers of a model: what the generated C and its NumPy reference both take as data.

Dense layout, up to 12 rules. With t = (y - middle)/h and r = exp(t) = 2^(t log2 e), the rule at l' = l - (L-1)/2 steps
from the middle fires with
    p_l proportional to w_l r^l,   w_l = exp(-l'^2 / 2)
so w_l is folded into the consequents once and the sums over the rules are polynomials in r.

Windowed layout, above 12 rules. With n the nearest centre, t = (y - c_n)/h in [-1/2, 1/2], rule n + j fires with
    p_{n+j} proportional to w_j r^(j+5),   w_j = exp(-j^2 / 2),   j = -5 .. 5
The tables are padded by 5 phantom rules of weight 0 on either side. What the window drops is below 3e-7 of the whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.reproducible import exp
from hysgen.model.float32_constants import LEAST
from hysgen.model.model import Model

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

MOST_DENSE_RULES: Final = 12
# r = exp(t) is computed as 2^(t log2 e).
OCTAVES_PER_STEP: Final = 1.4426950408889634
WINDOW_REACH: Final = 5
WINDOW: Final = 2 * WINDOW_REACH + 1


@dataclass(frozen=True)
class Bank:
    """Folded parameters, the C struct `<name>_bank_t`: slope, offset, gain (rows,) over the rules, weight (T,)."""

    slope: Floats32
    offset: Floats32
    gain: Floats32
    weight: Floats32


@dataclass(frozen=True)
class Coefficients:
    """Every float32 number that predict, simulate and inverse need.

    strength: w of the layout, (L,) dense or (11,) windowed.
    present: (L + 10,) 1 for a rule, 0 for a phantom; windowed only.
    fold: (L,) factor of each rule's consequent in the bank; pad: phantoms before the first rule.
    origin_um: the middle of the centres (dense) or the lowest centre (windowed).
    per_step: octaves per um, log2(e)/h (dense), or steps per um, 1/h (windowed).
    reference_min_um, reference_max_um: where the inverse limits y(k+1): the range and its own width beyond it.
    rest_um, rest_V: what a non-finite initial value is replaced by.
    """

    windowed: bool
    rules: int
    y_min_um: np.float32
    y_max_um: np.float32
    u_min_V: np.float32
    u_max_V: np.float32
    reference_min_um: np.float32
    reference_max_um: np.float32
    rest_um: np.float32
    rest_V: np.float32
    origin_um: np.float32
    per_step: np.float32
    strength: Floats32
    present: Floats32
    fold: Floats32
    pad: int
    bank: Bank

    @property
    def bank_rules(self) -> int:
        """Length of the bank's rule tables, phantoms included."""
        return self.rules + 2 * self.pad


def coefficients(model: Model) -> Coefficients:
    """The float32 numbers of `model`; folding rounds q and w to float32 first, as the C does when it commits."""
    grid = model.grid
    windowed = grid.rules > MOST_DENSE_RULES
    away = np.arange(-WINDOW_REACH, WINDOW_REACH + 1) if windowed else np.arange(grid.rules) - (grid.rules - 1) / 2
    strength = np.array([exp(-0.5 * a * a) for a in away.tolist()]).astype(np.float32)
    pad = WINDOW_REACH if windowed else 0
    ones = np.ones(grid.rules, dtype=np.float32)
    fold = ones if windowed else strength
    span = grid.y_max_um - grid.y_min_um
    first, last = grid.ends_um
    return Coefficients(
        windowed=windowed,
        rules=grid.rules,
        y_min_um=single(grid.y_min_um),
        y_max_um=single(grid.y_max_um),
        u_min_V=single(model.u_min_V),
        u_max_V=single(model.u_max_V),
        reference_min_um=single(grid.y_min_um - span),
        reference_max_um=single(grid.y_max_um + span),
        rest_um=single(0.5 * (grid.y_min_um + grid.y_max_um)),
        rest_V=single(min(max(0.0, model.u_min_V), model.u_max_V)),
        origin_um=single(first if windowed else 0.5 * (first + last)),
        per_step=single((1.0 if windowed else OCTAVES_PER_STEP) / grid.step_um),
        strength=strength,
        present=np.pad(ones, pad) if windowed else np.zeros(0, dtype=np.float32),
        fold=fold,
        pad=pad,
        bank=folded(singles(model.consequents), singles(model.weights), fold, pad),
    )


def folded(consequents: Floats32, weights: Floats32, fold: Floats32, pad: int) -> Bank:
    """The bank of consequents (L, 3) and weights (T,): one rounding each, phantoms of weight 0 around."""
    slope, gain, offset = (np.pad(fold * consequents[:, column], pad) for column in range(3))
    return Bank(slope=slope, offset=offset, gain=gain, weight=weights)


def single(value: float) -> np.float32:
    """`value` as float32; magnitudes that the arithmetic counts as zero become zero."""
    return np.float32(0.0) if abs(value) < LEAST else np.float32(value)


def singles(values: Floats) -> Floats32:
    """`single` over an array."""
    return np.where(np.abs(values) < LEAST, 0.0, values).astype(np.float32)
