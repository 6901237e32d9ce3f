"""Proved largest error of one step of the rules: float32 reference against real arithmetic, over a whole box.

The reference's own functions are called with numbers that carry their errors (`enclosed`) in place of float32 ones.
A quotient of sums n/d takes A of n - (n/d) d, in which numbers
that both share keep their signs, as n/d is a mean of the rules whose interval is known well:

    n_f/d_f - n/d = (e_n - (n/d) e_d) / d_f,   p_l = 1/sum_k exp((k - l) s - (k^2 - l^2)/2),   s: y in steps

The box is divided into cells, and the worst of them counts; float64 rounds outwards.

Above 12 rules a cell has one nearest rule n, and y reaches beyond the half way to the next by what may round it there.
Real arithmetic sums all rules, float32 those of the window; with p_l of all,

    y - y_window = sum_(l outside) p_l (q_l1 y + q_l2 w + q_l3 - y_window)

and the inverse is as if it were asked for as much more.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.coefficients import WINDOW_REACH, Bank, Coefficients, coefficients
from hysgen.float32.reference import instance
from hysgen.float32.reference.enclosed import (
    HALF_BIT,
    LIBRARY,
    Enclosed,
    Floats,
    Interval,
    Tape,
    counted,
    half_bit,
    quotient_error,
)
from hysgen.machine.reproducible import exp
from hysgen.model import float32_arithmetic as arithmetic
from hysgen.model.model import Model

CELLS: Final = (128, 4)
"""Parts of the range of y and of w, first."""
ENOUGH: Final = 1.04
"""Cells are divided while their bound is larger than that of the worst point of the first cells by this factor."""
DIVISIONS: Final = 4
"""Rounds of division of y in four parts; the bound of what is left then counts as it is."""
OF_RULE: Final = 8
ROUNDED_STEPS: Final = 1e-4
"""Of more than 12 rules: first parts of y nearest to one, and by how many steps float32 misses the half way."""
LARGEST_EXPONENT: Final = 300.0
BEYOND: Final = 0.01
"""Part of the range of w by which the box of the inverse reaches further: where its limits begin to act."""


@dataclass(frozen=True)
class _Table:
    """A table of the rules, (rules,) exact and rounded: a constant for each cell."""

    tape: Tape
    exact: Floats
    rounded: Any

    def __getitem__(self, places: NDArray[np.int64]) -> Enclosed:
        return self.tape.constant(self.exact[places], self.rounded[places])


@dataclass(frozen=True)
class Extra:
    """What is added to the rules: its largest magnitude and the bound of its error, in um."""

    size_um: float = 0.0
    error_um: float = 0.0


@dataclass(frozen=True)
class Banks:
    """Banks that a learner may commit: largest magnitudes of their numbers, (rules,) each, and ends of |df/dw|."""

    slope: Floats
    offset: Floats
    gain: Floats
    gain_ends: tuple[float, float]


def worst(
    model: Model,
    path: float,
    extra: Extra | None,
    *,
    inverse: bool = False,
    missed: float | None = None,
    banks: Banks | None = None,
) -> float:
    """The largest bound over all cells, which are divided until intervals add little to it.

    Of y(k+1), whose w is off by `path`; inverse: of the w that is found for y(k+1), or, if the path misses that w by up
    to `missed`, of the y(k+1) that is reached. extra: of the disturbances. banks: any of them, that of the model
    otherwise; real arithmetic starts from the float32 numbers of the bank then.
    """
    numbers = coefficients(model)
    low, high = float(numbers.w_min), float(numbers.w_max)
    past = BEYOND * (high - low) if inverse else 0.0
    y, w = _parts(model, numbers), np.linspace(low - past, high + past, CELLS[1] + 1)
    along = [np.repeat(end, w.size - 1) for end in y]
    cells = np.array([*along[:2], *(np.tile(end, y[0].size) for end in (w[:-1], w[1:])), along[2]])

    def bound(cells: Floats) -> Floats:
        with np.errstate(all="ignore"):
            error, gain = _step(model, cells, path, extra, banks, inverse=inverse)
            return counted(error if missed is None else gain.size * (error + missed))

    points = [np.array([*[0.5 * (cells[0] + cells[1])] * 2, end, end, cells[4]]) for end in cells[2:4]]
    enough = ENOUGH * float(bound(np.concatenate(points, axis=1)).max())
    worst = 0.0
    for _ in range(DIVISIONS):
        errors = bound(cells)
        dividing = errors > enough
        worst = max(worst, float(errors[~dividing].max(initial=0.0)))
        if not dividing.any():
            return worst
        low, high, *others = cells[:, dividing]
        ends = [low + (high - low) * k / 4 for k in range(4)] + [high]
        cells = np.concatenate([np.array([*ends[k : k + 2], *others]) for k in range(4)], axis=1)
    return max(worst, float(errors.max()))


def _parts(model: Model, numbers: Coefficients) -> Floats:
    """(3, parts) low and high ends of the first parts of the range of y, and the rule that is nearest to each."""
    low, high = float(numbers.y_min_um), float(numbers.y_max_um)
    if not numbers.windowed:
        ends = np.linspace(low, high, CELLS[0] + 1)
        return np.array([ends[:-1], ends[1:], np.zeros(CELLS[0])])
    parts = []
    for rule, centre in enumerate(model.grid.centres_um):
        reach = (0.5 + ROUNDED_STEPS) * model.grid.step_um
        ends = np.clip(np.linspace(centre - reach, centre + reach, OF_RULE + 1), low, high)
        parts.append(np.array([ends[:-1], ends[1:], np.full(OF_RULE, rule)]))
    whole = np.concatenate(parts, axis=1)
    return whole[:, whole[0] < whole[1]]


def _step(
    model: Model, cells: Floats, path: float, extra: Extra | None, banks: Banks | None, *, inverse: bool
) -> tuple[Floats, Interval]:
    """Bound of y(k+1) in every cell, or of the w that the inverse finds for y and y(k+1); df/dw.

    cells: (5, cells) low and high end of y and of w, and the nearest rule.
    """
    y, w, rule = Interval(*cells[:2]), Interval(*cells[2:4]), cells[4].astype(np.int64)
    tape, numbers, grid = Tape(rule), coefficients(model), model.grid
    reference: Any = instance

    def vector(exact: Any, rounded: Any) -> Any:
        if numbers.windowed:
            return _Table(tape, np.pad(exact, numbers.pad), rounded)
        return [tape.constant(*pair) for pair in zip(exact, rounded, strict=True)]

    # The model's range ends between two float32 numbers: beyond its end, the displacement counts as the end.
    past = Interval(np.minimum(y.low - grid.y_min_um, 0.0), np.maximum(y.high - grid.y_max_um, 0.0))
    y_number, w_number = tape.number(y, known=past), tape.number(w, rounding=path)
    away = np.arange(numbers.strength.size) - 0.5 * (numbers.strength.size - 1)
    weights = [exp(-0.5 * distance**2) for distance in away.tolist()]
    folds = np.ones(grid.rules) if numbers.windowed else np.array(weights)
    q1, q2, q3 = (folds * column for column in model.consequents.T)
    tables: Any
    if banks is None:
        tables = vector(q1, numbers.bank.slope), vector(q3, numbers.bank.offset), vector(q2, numbers.bank.gain)
    else:
        ends: Any = [[np.full(1, end) for end in group] for group in (banks.slope, banks.offset, banks.gain)]
        tables = tuple([tape.number(Interval(-end, end)) for end in group] for group in ends)
    slope, offset, per_w = tables
    bank = Bank(slope, offset, per_w, numbers.bank.weight)
    origin, octaves = grid.ends_um[0] if numbers.windowed else 0.5 * sum(grid.ends_um), 1.0 / np.log(2.0)
    exact: Any = {
        "origin_um": tape.constant(origin, numbers.origin_um),
        "per_step": tape.constant((1.0 if numbers.windowed else octaves) / grid.step_um, numbers.per_step),
        "octaves": tape.constant(octaves, numbers.octaves),
        "strength": [tape.constant(*pair) for pair in zip(weights, numbers.strength, strict=True)],
        "present": vector(folds, numbers.present) if numbers.windowed else numbers.present,
    }
    sums = reference.rule_sums(dataclasses.replace(numbers, **exact), bank, y_number)
    within, beyond = _memberships(model, numbers, cells)
    rows = [column[:, None] for column in model.consequents.T]
    if banks is None:
        own = Interval.over(*(rows[0] * at + rows[1] * under + rows[2] for at in cells[:2] for under in cells[2:4]))
        value, gain, least = _mean(within, own), _mean(within, Interval.over(rows[1])), np.zeros(1)
    else:
        rows = [size[:, None] / np.array(weights)[:, None] for size in (banks.slope, banks.gain, banks.offset)]
        most = (1.0 + LIBRARY) * (rows[0] * np.abs(cells[:2]).max(0) + rows[1] * np.abs(cells[2:4]).max(0) + rows[2])
        own = Interval(-most, most)
        value, gain = _mean(within, own), Interval(*(np.full(1, end) for end in banks.gain_ends))
        least = banks.gain_ends[0] * sums.weight.value.low
    outside = np.zeros(1)
    if numbers.windowed:
        off = np.maximum(np.abs(own.high - value.low), np.abs(own.low - value.high))
        outside = (1.0 + grid.rules * LIBRARY) * (beyond.high * off).sum(axis=0)
    if inverse:
        lost = 0.0 if extra is None else extra.error_um + 2.0 * HALF_BIT * (value.size + extra.size_um)
        asked = [float(end) for end in (numbers.reference_min_um, numbers.reference_max_um)]
        added = 0.0 if extra is None else extra.size_um
        value = Interval(np.maximum(value.low, asked[0] - added), np.minimum(value.high, asked[1] + added))
        wanted = tape.number(value, rounding=lost + outside)
        of_w = quotient_error(reference.wanted_input(sums, y_number, wanted), w, least)
        return np.where(value.low <= value.high, of_w, 0.0) + float(arithmetic.LEAST), gain
    error = quotient_error(reference.next_displacement(sums, y_number, w_number), value) + outside
    if extra is not None:
        error = error + extra.error_um
        error = error + half_bit(value.size + error + extra.size_um)
    return error + float(arithmetic.LEAST), gain


def _memberships(model: Model, numbers: Coefficients, cells: Floats) -> tuple[Interval, Interval]:
    """(rules, cells) p_l of the rules in float32 among themselves, and of those that it leaves out among all.

    Every exponent is linear in s, so its ends are those of the cell. A share below exp(-LARGEST_EXPONENT) counts as 0.
    """
    rule = np.arange(model.grid.rules, dtype=np.float64)
    ends = (cells[:2] - model.grid.ends_um[0]) / model.grid.step_um
    apart = LIBRARY * (1.0 + np.abs(ends).max())
    ends = np.array([ends[0] - apart, ends[1] + apart])
    inside = np.abs(rule[:, None] - cells[4]) <= (WINDOW_REACH if numbers.windowed else np.inf)
    sums: list[list[Floats]] = []
    for own in rule:
        exponents = [(rule[:, None] - own) * end - 0.5 * (rule**2 - own**2)[:, None] for end in ends]
        powers = [np.exp(np.minimum(exponent, LARGEST_EXPONENT)) for exponent in exponents]
        both = np.minimum(*powers), np.maximum(*powers)
        sums.append([1.0 / (power * among).sum(axis=0) for among in (inside, 1.0) for power in both])
    low, high = 1.0 - 2.0 * rule.size * LIBRARY, 1.0 + 2.0 * rule.size * LIBRARY
    most, least, of_all, of_all_least = np.array(sums).transpose(1, 0, 2)
    least = np.maximum(least - 2.0 * np.exp(-LARGEST_EXPONENT), 0.0)
    within = Interval(low * least * inside, high * most * inside)
    return within, Interval(low * of_all_least * ~inside, high * of_all * ~inside)


def _mean(shares: Interval, values: Interval) -> Interval:
    """sum_l p_l x_l in every cell, of shares that add up to 1: about the middle of those with a share."""
    least = np.where(shares.high > 0.0, values.low, np.inf).min(axis=0)
    most = np.where(shares.high > 0.0, values.high, -np.inf).max(axis=0)
    middle = (shares.high * 0.5 * (values.low + values.high)).sum(axis=0) / shares.high.sum(axis=0)
    products = shares * Interval.over(values.low - middle, values.high - middle)
    rounded = LIBRARY * (np.abs(least) + np.abs(most))
    low, high = middle + products.low.sum(axis=0) - rounded, middle + products.high.sum(axis=0) + rounded
    return Interval(np.maximum(low, least - rounded), np.minimum(high, most + rounded))
