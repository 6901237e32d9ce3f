"""The certified box: an interval for every float of a generated instance that no call leaves.

The proof assumes the box of the state before a call and demands it after the call; by induction it holds for every
sequence of calls. The box consists of those of the terms and input blocks (`Term.box`, `InputBlock.box`), and of the
interval of y_um by the convexity of Eq. (4),

    min_l (q_l1 y + q_l2 v + q_l3)  <=  sum_l p_l (q_l1 y + q_l2 v + q_l3)  <=  max_l (q_l1 y + q_l2 v + q_l3)

widened by WIDENED for rounding and for the excess of interval arithmetic. Flags, counters and phases may have
any value.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.float32.coefficients import coefficients
from hysgen.model import disturbances
from hysgen.model.intervals import Interval
from hysgen.model.model import Model
from hysgen.model.twofloat import LIMIT

WIDENED: Final = 0.75
"""Part of its width by which the interval of a sum over the rules is widened at either end."""

KEPT: Final = float(LIMIT)
"""Limit of the magnitude of accumulated states in the generated code."""


@dataclass(frozen=True)
class PartsBox:
    """The boxes of the terms and the input blocks of a model.

    floats: C path in `<name>_t` -> interval; integers: C path -> largest value, of the integers that have one.
    applied: input of the rules. command_V: voltage commanded by the caller or by the inverse.
    regressors: largest magnitude of the regressors of every term, term by term.
    """

    floats: Mapping[str, Interval]
    integers: Mapping[str, int]
    applied: Interval
    command_V: Interval
    regressors: tuple[tuple[float, ...], ...]


def instance_box(model: Model) -> dict[str, Interval]:
    """C path in `<name>_t` -> interval, for every float outside the banks.

    Raises ModelError for a kind of term or block that gives no box.
    """
    parts = parts_box(model)
    sizes = [size for regressors in parts.regressors for size in regressors]
    extra = sum(abs(w) * size for w, size in zip(model.weights, sizes, strict=True))
    rules = _rules(model, parts.applied)
    y = rules.outwards(WIDENED * rules.width + 1.01 * extra)
    numbers = coefficients(model)
    range_V = Interval(float(numbers.u_min_V), float(numbers.u_max_V))
    limits = {"low_V": range_V, "high_V": range_V, "step_V": Interval(0.0, float(numbers.u_step_max_V))}
    return {"y_um": y, "u_V": parts.command_V, **limits, **parts.floats}


def parts_box(model: Model) -> PartsBox:
    """The box of all blocks, in the order in which the input passes through them, and of all terms behind them.

    Raises ModelError for a kind of term or block that gives no box.
    """
    numbers = coefficients(model)
    applied = command = Interval(float(numbers.u_min_V), float(numbers.u_max_V))
    floats: dict[str, Interval] = {}
    integers: dict[str, int] = {}
    for block in model.blocks:
        passed = block.box(applied, model.Ts_s)
        floats |= {f"inputs.{block.kind}.{path}": interval for path, interval in passed.floats.items()}
        integers |= {f"inputs.{block.kind}.{path}": largest for path, largest in passed.integers.items()}
        applied = passed.through
        if not block.responds:
            floats["inputs.v_V"] = applied
            command = command.hull(passed.solved)
    if model.responds:
        floats.setdefault("inputs.v_V", command)
        applied = Interval(float(numbers.w_min), float(numbers.w_max))
    regressors: list[tuple[float, ...]] = []
    for term in model.terms:
        box = disturbances.box_of(term, model.Ts_s)
        floats |= {f"terms.{term.kind}.{path}": interval for path, interval in box.floats.items()}
        integers |= {f"terms.{term.kind}.{path}": largest for path, largest in box.integers.items()}
        regressors.append(box.regressors)
    return PartsBox(floats, integers, applied, command, tuple(regressors))


def regressor_sizes(model: Model) -> list[float]:
    """Largest magnitude of every term's regressors, in their order."""
    return [size for regressors in parts_box(model).regressors for size in regressors]


def _rules(model: Model, applied: Interval) -> Interval:
    """Extremes of the rules' consequents over the ranges of y and v; an affine function has them at the corners."""
    y = np.array([model.grid.y_min_um, model.grid.y_max_um])
    v = np.array([applied.low, applied.high])
    q = model.consequents
    values = q[:, 0, None, None] * y[:, None] + q[:, 1, None, None] * v + q[:, 2, None, None]
    return Interval(float(values.min()), float(values.max()))
