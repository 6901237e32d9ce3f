"""The float32 numbers of a model, read by the generated C and by its NumPy reference.

Dense layout, up to 12 rules. With h the distance of the centres, t = (y - middle)/h, r = exp(t) = 2^(t log2 e) and
l' = l - (L-1)/2, the firing strength of rule l is
    p_l proportional to w_l r^l,   w_l = exp(-l'^2 / 2)
The bank holds the consequents multiplied by w_l, so that the sums over the rules are polynomials in r.

Windowed layout, above 12 rules. With n the nearest centre and t = (y - c_n)/h in [-1/2, 1/2], r as above, the firing
strength of rule n + j is
    p_{n+j} proportional to w_j r^(j+5),   w_j = exp(-j^2 / 2),   j = -5 .. 5
The tables are padded by 5 phantom rules of weight 0 at either end. The rules outside the window have less than 3e-7 of
the sum of all firing strengths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.reproducible import exp
from hysgen.model.float32_constants import LEAST
from hysgen.model.model import Model
from hysgen.model.path.base import TOLERANCE

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]

MOST_DENSE_RULES: Final = 12
# r = exp(t) is computed as 2^(t log2 e).
OCTAVES_PER_STEP: Final = 1.4426950408889634
WINDOW_REACH: Final = 5
WINDOW: Final = 2 * WINDOW_REACH + 1


@dataclass(frozen=True)
class Bank:
    """The C struct `<name>_bank_t`: w_l q_l1, w_l q_l3, w_l q_l2, (rows,) each, and the terms' weights theta, (T,)."""

    slope: Floats32
    offset: Floats32
    gain: Floats32
    weight: Floats32


@dataclass(frozen=True)
class Coefficients:
    """The float32 numbers of predict, simulate and inverse.

    strength: w of the layout, (L,) dense or (11,) windowed.
    present: (L + 10,) 1 for a rule, 0 for a phantom; empty in the dense layout.
    fold: (L,) factor of each rule's consequent in the bank; pad: number of phantoms before the first rule.
    origin_um: the middle of the centres (dense) or the lowest centre (windowed).
    per_step: log2(e)/h, octaves per um (dense), or 1/h, steps per um (windowed).
    reference_min_um, reference_max_um: limits of y(k+1) in the inverse, the displacement range extended by its own
    width at either end.
    u_step_max_V: initial and largest limit of the change of the inverse's voltage, twice the range of u: it never acts.
    w_min, w_max: range of w, the input of the rules (`Model.w_range`); that of u without responses of the stage.
    w_tolerance: largest |w' - w| that the inverse leaves unflagged, TOLERANCE of that range.
    rest_um, rest_V: replacements of a non-finite initial displacement and input.
    """

    windowed: bool
    rules: int
    y_min_um: np.float32
    y_max_um: np.float32
    u_min_V: np.float32
    u_max_V: np.float32
    u_step_max_V: np.float32
    w_min: np.float32
    w_max: np.float32
    w_tolerance: np.float32
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
        """Length of the bank's tables over the rules, phantoms included."""
        return self.rules + 2 * self.pad


def coefficients(model: Model) -> Coefficients:
    """The float32 numbers of `model`; q and w are rounded to float32 before their product, as in the C of a commit."""
    grid = model.grid
    windowed = grid.rules > MOST_DENSE_RULES
    away = np.arange(-WINDOW_REACH, WINDOW_REACH + 1) if windowed else np.arange(grid.rules) - (grid.rules - 1) / 2
    strength = np.array([exp(-0.5 * a * a) for a in away.tolist()]).astype(np.float32)
    pad = WINDOW_REACH if windowed else 0
    ones = np.ones(grid.rules, dtype=np.float32)
    fold = ones if windowed else strength
    span = grid.y_max_um - grid.y_min_um
    first, last = grid.ends_um
    w = model.w_range
    return Coefficients(
        windowed=windowed,
        rules=grid.rules,
        y_min_um=single(grid.y_min_um),
        y_max_um=single(grid.y_max_um),
        u_min_V=single(model.u_min_V),
        u_max_V=single(model.u_max_V),
        u_step_max_V=single(2.0 * (model.u_max_V - model.u_min_V)),
        w_min=single(w.low),
        w_max=single(w.high),
        w_tolerance=single(TOLERANCE * w.width),
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
    """The bank of consequents (L, 3) and weights (T,): w_l q_l in float32, with `pad` zeros at either end."""
    slope, gain, offset = (np.pad(fold * consequents[:, column], pad) for column in range(3))
    return Bank(slope=slope, offset=offset, gain=gain, weight=weights)


def single(value: float) -> np.float32:
    """`value` as float32; magnitudes below LEAST, which the float32 arithmetic flushes to zero, become zero."""
    return np.float32(0.0) if abs(value) < LEAST else np.float32(value)


def singles(values: Floats) -> Floats32:
    """`single` of every element."""
    return np.where(np.abs(values) < LEAST, 0.0, values).astype(np.float32)
