"""The banks that a learner may commit: an interval of every number, and of the gain by the check points of `commit`."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.errors import ModelError
from hysgen.float32.coefficients import Floats32, coefficients, commit_numbers
from hysgen.float32.learner_numbers import learner_numbers
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.model import Model

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


def committed_gain(model: Model) -> Interval:
    """Interval of sum v_l q_l2 / sum v_l, times its sign, in float32 over the range, for all banks that commit accepts.

    Raises ModelError if the bound of the rounding errors exceeds the floor of the gain.
    """
    numbers = commit_numbers(model, coefficients(model), certify(model))
    lost = ROUNDINGS * most_per_strength(bank_box(model), "gain", coefficients(model).strength)
    if lost >= float(numbers.gain_floor):
        raise ModelError(f"{model.name}: rounding of a gain ({lost:.2g}) hides commit's floor {numbers.gain_floor:.2g}")
    return Interval(float(numbers.gain_floor) - lost, float(numbers.gain_ceiling) + lost)


def most_per_strength(banks: Mapping[str, Interval], group: str, strength: Floats32) -> float:
    """Largest magnitude of a number of `group` divided by the strength of its rule, a bound of every convex sum."""
    return max(banks[f"{group}[{i}]"].magnitude / float(w) for i, w in enumerate(strength))


def _at(x: float | np.float32) -> Interval:
    return Interval(float(x), float(x)).outwards()
