"""Intervals of the numbers of a bank: the model's own, and all that a learner may commit in their place.

commit accepts parameters within their limit (`bank_box`) whose gain lies between floor and ceiling over the whole
range; it evaluates the gain at check points, with Taylor bounds between them (`commit_numbers.py`). The limit is proved
of the generated C. The bounds of the gain are a theorem that an interval analysis cannot derive; the proof assumes them
(`committed_gain_annotation`), less a bound of the rounding errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.checking.proof.eva.boxes import instance_box, regressor_sizes
from hysgen.checking.proof.eva.intervals import hexadecimal
from hysgen.errors import ModelError
from hysgen.float32.coefficients import Floats32, coefficients
from hysgen.float32.commit_numbers import commit_numbers
from hysgen.float32.learner_numbers import learner_numbers
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.model import Model

INTERVAL_EXCESS: Final = 4.0
"""Ratio of the magnitude that an interval analysis gives for an output to its largest magnitude."""

ROUNDINGS: Final = 64.0 * 2.0**-24
"""Bound of the rounding error of a sum over the rules or of a check point, per largest number of the bank."""


def bank_box(model: Model) -> dict[str, Interval]:
    """Every number of a bank of a model that learns, by C path."""
    numbers = learner_numbers(model, coefficients(model))
    bank = coefficients(model).bank
    groups = {"slope": bank.slope, "offset": bank.offset, "gain": bank.gain, "weight": bank.weight}
    box = {f"{group}[{i}]": _at(x) for group, values in groups.items() for i, x in enumerate(values)}
    for parameter, per_scale in zip(numbers.parameters, numbers.per_scale, strict=True):
        reach = symmetric(float(numbers.limit_um) * float(per_scale))
        if parameter.group == "bias":
            for i in range(len(bank.offset)):
                box[f"offset[{i}]"] = reach.hull(box[f"offset[{i}]"]).outwards(reach.high)
        else:
            path = f"{parameter.group}[{parameter.index}]"
            box[path] = reach.hull(box[path]).outwards()
    return box


def committed_box(model: Model) -> dict[str, Interval]:
    """`instance_box` of a model that learns: the interval of y_um is wider, because any bank may be active."""
    box, banks, numbers = instance_box(model), bank_box(model), coefficients(model)
    most = {group: _most(banks, group, numbers.strength) for group in ("slope", "offset", "gain")}
    y = max(abs(model.grid.y_min_um), abs(model.grid.y_max_um))
    u = model.w_range.magnitude
    extra = sum(banks[f"weight[{j}]"].magnitude * size for j, size in enumerate(regressor_sizes(model)))
    reach = INTERVAL_EXCESS * (most["slope"] * y + most["offset"] + most["gain"] * u + extra)
    return box | {"y_um": symmetric(reach).hull(box["y_um"]).outwards()}


def state_box(model: Model) -> dict[str, Interval]:
    """The box of the instance: with the model's own bank, or with any that its learner may commit."""
    return committed_box(model) if model.learner else instance_box(model)


def committed_gain(model: Model) -> Interval:
    """Interval of sum v_l q_l2 / sum v_l, times its sign, in float32 over the range, for all banks that commit accepts.

    Raises ModelError if the bound of the rounding errors exceeds the floor of the gain.
    """
    numbers = commit_numbers(model, coefficients(model), certify(model))
    lost = ROUNDINGS * _most(bank_box(model), "gain", coefficients(model).strength)
    if lost >= float(numbers.gain_floor):
        raise ModelError(f"{model.name}: rounding of a gain ({lost:.2g}) hides commit's floor {numbers.gain_floor:.2g}")
    return Interval(float(numbers.gain_floor) - lost, float(numbers.gain_ceiling) + lost)


def committed_gain_annotation(model: Model) -> str:
    """`committed_gain` as an assumption in ACSL, for the hook where the inverse divides by the gain."""
    sign = float(commit_numbers(model, coefficients(model), certify(model)).sign)
    gain, signed = committed_gain(model), "sums.gain" if sign > 0 else "-sums.gain"
    low, high = (hexadecimal(end)[:-1] for end in (gain.low, gain.high))
    return f"    //@ admit committed: {low} * sums.weight <= {signed} <= {high} * sums.weight;"


def _most(banks: Mapping[str, Interval], group: str, strength: Floats32) -> float:
    """Largest magnitude of a number of `group` divided by the strength of its rule, a bound of every convex sum."""
    return max(banks[f"{group}[{i}]"].magnitude / float(w) for i, w in enumerate(strength))


def _at(x: float | np.float32) -> Interval:
    return Interval(float(x), float(x)).outwards()
