"""Input checks over lanes, and the sums over the rules in Eq. (4), with one exponential per sample.

S(y) = sum_l v_l q_l1,   O(y) = sum_l v_l q_l3,   G(y) = sum_l v_l q_l2,   W(y) = sum_l v_l,   p_l = v_l / W
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from hysgen.float32.coefficients import OCTAVES_PER_STEP, WINDOW, Bank, Coefficients
from hysgen.model.float32_arithmetic import (
    INFINITY_BITS,
    LEAST_BITS,
    MAGNITUDE_BITS,
    ROUNDING,
    Floats32,
    Words,
    bits_of,
    float_of,
    power_of_two,
    reciprocal,
)

_ONE = np.float32(1.0)
_OCTAVES = np.float32(OCTAVES_PER_STEP)


@dataclass(frozen=True)
class RuleSums:
    """S [1], O [um], G [um/V] and W [1] as slope, offset, gain and weight, (lanes,) each."""

    slope: Floats32
    offset: Floats32
    gain: Floats32
    weight: Floats32


def rule_sums(numbers: Coefficients, bank: Bank, y_um: Floats32) -> RuleSums:
    """S, O, G, W of `bank` at y_um, (lanes,), within the displacement range."""
    if numbers.windowed:
        first, strengths = window(numbers, y_um)
        return RuleSums(
            slope=pairwise([v * bank.slope[first + np.uint32(j)] for j, v in enumerate(strengths)]),
            offset=pairwise([v * bank.offset[first + np.uint32(j)] for j, v in enumerate(strengths)]),
            gain=pairwise([v * bank.gain[first + np.uint32(j)] for j, v in enumerate(strengths)]),
            weight=pairwise([v * numbers.present[first + np.uint32(j)] for j, v in enumerate(strengths)]),
        )
    r = ratio(numbers, y_um)
    return RuleSums(
        slope=polynomial(bank.slope, r),
        offset=polynomial(bank.offset, r),
        gain=polynomial(bank.gain, r),
        weight=polynomial(numbers.strength, r),
    )


def next_displacement(sums: RuleSums, y_um: Floats32, w: Floats32) -> Floats32:
    """y(k+1) of the rules, (y S + O + w G) / W, (lanes,)."""
    return ((y_um * sums.slope + sums.offset) + w * sums.gain) * reciprocal(sums.weight)


def wanted_input(sums: RuleSums, y_um: Floats32, y_next_um: Floats32) -> Floats32:
    """The w that takes y to y(k+1), Eq. (11): (y(k+1) W - (y S + O)) / G, (lanes,)."""
    return (y_next_um * sums.weight - (y_um * sums.slope + sums.offset)) * reciprocal(sums.gain)


def ratio(numbers: Coefficients, y_um: Floats32) -> Floats32:
    """r = exp((y - middle)/h) of the dense layout, (lanes,); v_l = w_l r^l."""
    return power_of_two((y_um - numbers.origin_um) * numbers.per_step)


def window(numbers: Coefficients, y_um: Floats32) -> tuple[Words, list[Floats32]]:
    """Index n of the nearest rule, (lanes,), and v_j = w_j r^j of rows n .. n + 10 of the padded tables."""
    steps = (y_um - numbers.origin_um) * numbers.per_step
    shifted = steps + ROUNDING
    t = steps - (shifted - ROUNDING)
    nearest = bits_of(shifted) - bits_of(np.asarray(ROUNDING))
    r = powers(power_of_two(t * _OCTAVES), WINDOW)
    return nearest, [w * power for w, power in zip(numbers.strength, r, strict=True)]


def strengths(numbers: Coefficients, y_um: Floats32) -> list[Floats32]:
    """v_l = w_l r^l of the dense layout, (lanes,) for each rule."""
    r = powers(ratio(numbers, y_um), numbers.rules)
    return [w * power for w, power in zip(numbers.strength, r, strict=True)]


def powers(r: Floats32, count: int) -> list[Floats32]:
    """r^0 .. r^(count-1) by r^k = r^(k//2) r^(k - k//2), the fewest multiplications in sequence."""
    values = [np.full_like(r, _ONE), r]
    for k in range(2, count):
        values.append(values[k // 2] * values[k - k // 2])
    return values[:count]


def polynomial(c: Floats32, r: Floats32) -> Floats32:
    """sum_k c_k r^k by Estrin's scheme: neighbours combine as a + b r, the results with r^2, then r^4, and so on."""
    parts: list[Floats32 | np.float32] = list(c)
    power = r
    while len(parts) > 1:
        joined = [parts[k] + parts[k + 1] * power for k in range(0, len(parts) - 1, 2)]
        parts = [*joined, *parts[2 * len(joined) :]]
        power = power * power
    return cast("Floats32", parts[0])


def pairwise(parts: list[Floats32]) -> Floats32:
    """The sum of `parts` by pairwise summation, in the order of the generated C."""
    while len(parts) > 1:
        joined = [parts[k] + parts[k + 1] for k in range(0, len(parts) - 1, 2)]
        parts = [*joined, *parts[2 * len(joined) :]]
    return parts[0]


def finite(x: Floats32, held: Floats32) -> tuple[Floats32, Words]:
    """`x` where it is finite, `held` where it is NaN or infinite; magnitudes below 2^-40 become +0.

    Returns the numbers, and 1 where `x` was replaced by `held`, else 0. The bit patterns are compared, not the floats,
    so that no float comparison has a NaN operand.
    """
    magnitude = bits_of(x) & np.uint32(MAGNITUDE_BITS)
    rejected = magnitude >= np.uint32(INFINITY_BITS)
    chosen = np.where(magnitude < LEAST_BITS, np.uint32(0), bits_of(x))
    return float_of(np.where(rejected, bits_of(held), chosen)), rejected.astype(np.uint32)


def limited(x: Floats32, low: Floats32 | np.float32, high: Floats32 | np.float32) -> tuple[Floats32, Words]:
    """`x` limited to [low, high], and 1 where the limit changed it, else 0."""
    below, above = x < low, x > high
    return np.where(below, low, np.where(above, high, x)), (below | above).astype(np.uint32)
