"""The float32 numbers of a model's learner, read by the generated C and by its reference, and the banks it may commit.

With q a number of the bank and phi its regressor, the learner uses theta = scale q and x = phi/scale. Scales are powers
of two, so both conversions are exact, and the prior P(0) = alpha I of q becomes D(0) = alpha scale^2 of theta.
If q is a consequent multiplied by a rule's strength w, the prior is scaled by w^2: D(0) = alpha (w scale)^2.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.errors import ModelError
from hysgen.float32.coefficients import (
    Coefficients,
    Floats,
    Floats32,
    coefficients,
    commit_numbers,
    membership_derivatives,
    single,
)
from hysgen.machine.reproducible import power, total
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.learner_settings import BIAS, LearnerSettings
from hysgen.model.model import Model

# Regressors, U, gains and steps are rounded to multiples of these grids: 1.5 * 2^23 grid steps are added, then
# subtracted. A product of three grid steps is a normal number, so no stored word is denormal (docs/learning.md).
REGRESSOR_GRID: Final = 2.0**-30
FACTOR_GRID: Final = 2.0**-30
GAIN_GRID: Final = 2.0**-60
STEP_GRID: Final = 2.0**-45
LEAST_VARIANCE: Final = 2.0**-40

FAST: Final = 1.0 / 256.0
"""Rate per sample of the running means of the outlier gate: 5 ms at 50 kHz."""

SLOW: Final = 1.0 / 4096.0
"""Rate per sample of the running mean squares of the restart test: 80 ms at 50 kHz."""

ROUNDINGS: Final = 64.0 * 2.0**-24
"""Bound of the rounding error of a sum over the rules or of a check point, per largest number of the bank."""


@dataclass(frozen=True)
class Parameter:
    """A learned parameter: member `group` of the bank (or "bias") and index in it; scale: theta/q, a power of two."""

    group: str
    index: int
    scale: float


@dataclass(frozen=True)
class LearnerNumbers:
    """The float32 numbers of the learner and its list of parameters.

    scale, per_scale: theta/q and q/theta, (n,). prior, ceiling: D(0) and largest D, (n,).
    refresh: regressor w_j of the pseudo-measurement that restores the prior of parameter j, (n,).
    firing: (L,) power of two nearest to each rule's strength. per_y, per_u: 1/typical |y|, |u|, powers of two.
    inflate_first, inflate: 1/lambda inside the window and after it.
    largest_denominator: limit of alpha_n = 1 + x' P x, above which the learner restarts.
    rest_V: largest distance of the input from its running mean at which a sample is not used.
    floor_um, level_um: least and initial running mean of |innovation|. gate_floor_um, gate_ratio: outlier gate.
    carried: share of an error of the free run that is left one sample later.
    step_um, limit_um: limits of one step and of |theta|. worse, lost: limits of ratios of mean square errors.
    The fields that have a setting of the same name are described in `LearnerSettings`.
    """

    settings: LearnerSettings
    parameters: tuple[Parameter, ...]
    scale: Floats32
    per_scale: Floats32
    prior: Floats32
    ceiling: Floats32
    refresh: Floats32
    firing: Floats32
    per_y: np.float32
    per_u: np.float32
    inflate_first: np.float32
    inflate: np.float32
    largest_denominator: np.float32
    y_low_um: np.float32
    y_high_um: np.float32
    rest_V: np.float32
    floor_um: np.float32
    gate_floor_um: np.float32
    gate_ratio: np.float32
    dead_zone_um: np.float32
    level_um: np.float32
    step_um: np.float32
    limit_um: np.float32
    worse: np.float32
    lost: np.float32
    carried: np.float32

    @property
    def size(self) -> int:
        """Number n of learned parameters."""
        return len(self.parameters)

    def learns(self, group: str) -> bool:
        """Whether parameters of `group` are learned."""
        return group in self.settings.learned


def _carried(model: Model) -> np.float32:
    """Mean of df/dy over the range in the middle of the input of the rules, in steps of 2^-12 from 0 to below 1."""
    ends_um, q = np.array([model.grid.y_min_um, model.grid.y_max_um]), model.consequents
    lines = np.outer(ends_um, q[:, 0]) + q[:, 1] * 0.5 * (model.w_range.low + model.w_range.high) + q[:, 2]
    low, high = (membership_derivatives(ends_um, model.grid)[0] * lines).sum(axis=1)
    return np.float32(np.clip(np.rint(4096.0 * (high - low) / (ends_um[1] - ends_um[0])), 0.0, 4095.0) / 4096.0)


def factors(parameters: int) -> int:
    """Number of words of U in C: the elements above its diagonal, column by column."""
    return parameters * (parameters - 1) // 2


def learner_numbers(model: Model, numbers: Coefficients) -> LearnerNumbers:
    """The numbers of `model.learner`. Raises ModelError if the model has no learner or one that is not supported."""
    settings = model.learner
    if settings is None:
        raise ModelError(f"{model.name}: has no learner settings; choose them when fitting or generating")
    if numbers.windowed:
        raise ModelError(f"learner: {numbers.rules} rules; it learns models of up to 12 rules, fit with fewer")
    y_scale = _power_of_two(max(abs(model.grid.y_min_um), abs(model.grid.y_max_um)))
    u_scale = _power_of_two(model.w_range.magnitude)
    strengths = numbers.fold.astype(np.float64)
    firing = np.array([_power_of_two(w) for w in strengths])
    parameters, strength = _parameters(model, settings, y_scale, u_scale, strengths, firing)
    scale = np.array([parameter.scale for parameter in parameters])
    carried = strength * scale
    prior = settings.alpha * (carried * carried)
    forgetting = settings.forgetting if settings.forgetting < 1.0 else settings.sliding
    remaining = power(forgetting, len(parameters) * (settings.refresh - 1))
    if remaining < 1e-3:
        raise ModelError(
            f"learner: forgetting {forgetting} with {len(parameters)} parameters and refresh {settings.refresh}"
            " loses the prior between two refreshes; forget more slowly or refresh more often"
        )
    ceiling = 2.0 * prior / remaining
    span = model.grid.y_max_um - model.grid.y_min_um
    deviation = math.sqrt(settings.alpha)
    worse = settings.worse + 0.5 * len(parameters) * (1.0 - forgetting)
    return LearnerNumbers(
        settings=settings,
        parameters=parameters,
        scale=scale.astype(np.float32),
        per_scale=(1.0 / scale).astype(np.float32),
        prior=prior.astype(np.float32),
        ceiling=ceiling.astype(np.float32),
        refresh=_on_grid(np.sqrt((1.0 - remaining) / prior)),
        firing=firing.astype(np.float32),
        per_y=np.float32(1.0 / y_scale),
        per_u=np.float32(1.0 / u_scale),
        inflate_first=np.float32(1.0 / settings.forgetting),
        inflate=np.float32(1.0 / forgetting),
        largest_denominator=np.float32(16.0 * (1.0 + float(total(ceiling)) * (16.0 + 4.0 * len(parameters)))),
        y_low_um=single(model.grid.y_min_um - span),
        y_high_um=single(model.grid.y_max_um + span),
        rest_V=single(_default(settings.rest_V, (model.u_max_V - model.u_min_V) / 16384.0)),
        floor_um=np.float32(settings.noise_um / 8.0),
        gate_floor_um=np.float32(6.0 * settings.noise_um),
        gate_ratio=np.float32(settings.outlier_ratio),
        dead_zone_um=single(_default(settings.dead_zone_um, settings.noise_um / 2.0)),
        level_um=np.float32(span),
        step_um=np.float32(_default(settings.step_um, 0.25 * span * max(deviation, 1.0))),
        limit_um=np.float32(_default(settings.limit_um, 256.0 * span * max(deviation, 1.0))),
        worse=np.float32(worse * worse),
        lost=np.float32(settings.lost * settings.lost),
        carried=_carried(model),
    )


def learned_model(model: Model, numbers: Coefficients, learner: LearnerNumbers, theta: Floats) -> Model:
    """`model` with the learned parameters theta, (n,) float64, scaled as in the learner; the others are unchanged."""
    consequents = model.consequents.copy()
    column = {"slope": 0, "gain": 1, "offset": 2}
    for parameter, number in zip(learner.parameters, theta / learner.scale.astype(np.float64), strict=True):
        if parameter.group == "bias":
            consequents[:, 2] += number
        else:
            strength = float(numbers.fold[parameter.index])
            consequents[parameter.index, column[parameter.group]] = number / strength
    return model.with_parameters(np.concatenate([consequents.ravel(), model.weights]))


def _parameters(
    model: Model,
    settings: LearnerSettings,
    y_scale: float,
    u_scale: float,
    strengths: Floats,
    firing: Floats,
) -> tuple[tuple[Parameter, ...], Floats]:
    """The learned parameters in the order of Eq. (9), and the factor w of each in the bank, (n,)."""
    if settings.learned == BIAS:
        return (Parameter("bias", 0, 1.0),), np.ones(1)
    typical = {"slope": y_scale, "gain": u_scale, "offset": 1.0}
    learned: list[Parameter] = []
    carried: list[float] = []
    for rule in range(model.grid.rules):
        for group, magnitude in typical.items():
            if group in settings.learned:
                learned.append(Parameter(group, rule, magnitude / firing[rule]))
                carried.append(float(strengths[rule]))
    return tuple(learned), np.array(carried)


def _power_of_two(magnitude: float) -> float:
    """The power of two nearest to `magnitude` on a logarithmic scale."""
    significand, exponent = math.frexp(magnitude)
    return math.ldexp(1.0, exponent if significand > math.sqrt(0.5) else exponent - 1)


def _on_grid(regressors: Floats) -> Floats32:
    """Regressors rounded to multiples of REGRESSOR_GRID, at least one grid step."""
    steps = np.maximum(np.rint(regressors / REGRESSOR_GRID), 1.0)
    return (steps * REGRESSOR_GRID).astype(np.float32)


def _default(chosen: float | None, derived: float) -> float:
    return derived if chosen is None else chosen


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
