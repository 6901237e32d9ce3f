"""The certified box: an interval for every float of an instance, of its banks and of its learner that no call leaves.

The proof assumes the box of the state before a call and demands it after the call; by induction it holds for every
sequence of calls. The box consists of those of the terms and input blocks (`Term.box`, `InputBlock.box`), and of the
interval of y_um by the convexity of Eq. (4),

    min_l (q_l1 y + q_l2 v + q_l3)  <=  sum_l p_l (q_l1 y + q_l2 v + q_l3)  <=  max_l (q_l1 y + q_l2 v + q_l3)

widened by WIDENED for rounding and for the excess of interval arithmetic. Flags, counters and phases may have
any value.

commit accepts parameters within their limit (`bank_box`) whose gain lies between floor and ceiling over the whole
range; it evaluates the gain at check points, with Taylor bounds between them (`float32.coefficients`). The limit is
proved of the generated C. The bounds of the gain are a theorem that an interval analysis cannot derive; the proof
assumes them (`committed_gain_annotation`), less a bound of the rounding errors.

Of a learner the covariance is left out: U, D and what one update keeps of them (U' x, D U' x, the lower words of the
parameters) may hold any 32 bits, NaN among them. Intervals cannot see why a covariance stays positive; the generated
code does not rely on it either, but looks for what has gone wild and starts again.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.certify.certificates import certify
from hysgen.float32.coefficients import coefficients, commit_numbers
from hysgen.float32.learner_numbers import FAST, bank_box, committed_gain, learner_numbers, most_per_strength
from hysgen.float32.struct_words import Holds, LearnerWords
from hysgen.model import disturbances
from hysgen.model.float32_arithmetic import LIMIT
from hysgen.model.intervals import Interval, symmetric
from hysgen.model.model import Model
from hysgen.model.path.modes import astray_members, straying

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
    mode = straying(model.blocks, model.Ts_s)
    if mode is not None:
        floats |= dict.fromkeys((f"inputs.{w.path}" for m in astray_members(mode) for w in m.words()), symmetric(KEPT))
        asked = Interval(float(numbers.reference_min_um), float(numbers.reference_max_um))
        floats["inputs.asked_um"] = asked.hull(Interval(0.0, 0.0))
    if model.responds:
        floats.setdefault("inputs.v_V", command)
        applied = Interval(float(numbers.w_min), float(numbers.w_max))
    regressors: list[tuple[float, ...]] = []
    for term in model.terms:
        box = disturbances.box_of(term, model.Ts_s)
        floats |= {f"terms.{term.kind}.{path}": interval for path, interval in box.floats.items()}
        integers |= {f"terms.{term.kind}.{path}": largest for path, largest in box.integers.items()}
        regressors.append(box.regressors)
    if model.feedback:
        loop = model.feedback.box(float(numbers.reach_um), model.Ts_s)
        floats |= {f"loop.{path}": box for path, box in loop.items()}
    return PartsBox(floats, integers, applied, command, tuple(regressors))


def _rules(model: Model, applied: Interval) -> Interval:
    """Extremes of the rules' consequents over the ranges of y and v; an affine function has them at the corners."""
    y = np.array([model.grid.y_min_um, model.grid.y_max_um])
    v = np.array([applied.low, applied.high])
    q = model.consequents
    values = q[:, 0, None, None] * y[:, None] + q[:, 1, None, None] * v + q[:, 2, None, None]
    return Interval(float(values.min()), float(values.max()))


def hexadecimal(x: float) -> str:
    """A float32 as a C literal without loss of digits.

    >>> hexadecimal(-0.75)
    '-0x1.8p-1f'
    """
    mantissa, exponent = float(np.float32(x)).hex().split("p")
    return f"{mantissa.rstrip('0').rstrip('.') if '.' in mantissa else mantissa}p{int(exponent)}f"


INTERVAL_EXCESS: Final = 4.0
"""Ratio of the magnitude that an interval analysis gives for an output to its largest magnitude."""


def committed_box(model: Model) -> dict[str, Interval]:
    """`instance_box` of a model that learns: the interval of y_um is wider, because any bank may be active."""
    box, banks, numbers = instance_box(model), bank_box(model), coefficients(model)
    most = {group: most_per_strength(banks, group, numbers.strength) for group in ("slope", "offset", "gain")}
    y = max(abs(model.grid.y_min_um), abs(model.grid.y_max_um))
    u = model.w_range.magnitude
    sizes = [size for regressors in parts_box(model).regressors for size in regressors]
    extra = sum(banks[f"weight[{j}]"].magnitude * size for j, size in enumerate(sizes))
    reach = INTERVAL_EXCESS * (most["slope"] * y + most["offset"] + most["gain"] * u + extra)
    return box | {"y_um": symmetric(reach).hull(box["y_um"]).outwards()}


def state_box(model: Model) -> dict[str, Interval]:
    """The box of the instance: with the model's own bank, or with any that its learner may commit."""
    return committed_box(model) if model.learner else instance_box(model)


def committed_gain_annotation(model: Model) -> str:
    """`committed_gain` as an assumption in ACSL, for the hook where the inverse divides by the gain."""
    sign = float(commit_numbers(model, coefficients(model), certify(model)).sign)
    gain, signed = committed_gain(model), "sums.gain" if sign > 0 else "-sums.gain"
    low, high = (hexadecimal(end)[:-1] for end in (gain.low, gain.high))
    return f"    //@ admit committed: {low} * sums.weight <= {signed} <= {high} * sums.weight;"


WILD: Final = tuple(member.name for member in LearnerWords.described() if member.any_bits)
"""Words that may hold any bits: the covariance, and what is derived from it."""

PARAMETERS: Final = tuple(member.name for member in LearnerWords.described() if member.parameter)
"""Words that hold a parameter each, finite and within its limit."""

REMAINDERS: Final = 1e12
"""Larger than what commit may keep of a candidate between its calls, far from what overflows."""

FIRING: Final = 16.0
"""A rule's regressors stay below this many times their typical size, as an analysis by intervals sees them."""


RATIO: Final = 32.0
"""Of the ends of a piece that a level is looked at in: in one step it loses at most RATIO * FAST of its lower end."""


@dataclass(frozen=True)
class Level:
    """A running level: it stays below `most`, and its box is a little wider, for what intervals cannot see.

    least: of what it follows, where the level must not become negative, for it multiplies its own limit.
    """

    path: str
    most: float
    least: float = 0.0

    @property
    def box(self) -> Interval:
        return Interval(0.5 * self.least if self.least else -self.most / 64.0, 1.02 * self.most).outwards()

    @property
    def borders(self) -> tuple[str, ...]:
        """Between them the step towards the newest value goes one way, or is a small part of the level."""
        count = math.ceil(math.log(self.most / self.least, RATIO)) if self.least else 0
        sizes = [self.least * RATIO**piece for piece in range(count)]
        ends = [f"self->{self.path} < {hexadecimal(size)}" for size in sizes or [0.0]]
        return (*ends, f"self->{self.path} <= {hexadecimal(self.most)}")


@dataclass(frozen=True)
class LearnerBox:
    """floats and integers by C path in `<name>_learner_t`: interval, and largest value. levels: those among them."""

    floats: Mapping[str, Interval]
    integers: Mapping[str, int]
    levels: tuple[Level, ...]


def learner_box(model: Model) -> LearnerBox:
    """Every word of the learner that is not WILD, not of its candidate and not constant."""
    numbers = learner_numbers(model, coefficients(model))
    instance = committed_box(model)
    limit = float(numbers.limit_um)
    y = Interval(float(numbers.y_low_um), float(numbers.y_high_um)).hull(instance["y_um"])
    u = Interval(model.u_min_V, model.u_max_V).outwards().hull(instance["u_V"])
    # Largest |x_j| that learning writes, or putting back the prior: in whose turn, intervals cannot tell.
    regressor = max(FIRING, 1.01 * float(numbers.refresh.max()))
    error = 2.0 * (y.magnitude + numbers.size * regressor * limit) + instance["y_um"].magnitude
    moved = 2.0 * y.magnitude + 1.0
    gate = float(numbers.gate_ratio) * (error + 1.0) + 2.0 * moved + float(numbers.gate_floor_um)
    tried = 1.1 * gate / (1.0 - float(numbers.carried))
    levels = (
        Level("scale_um", 1.01 * error + 1.0, float(numbers.floor_um)),
        Level("moving_um", moved),
        Level("error", 1.01 * error**2),
        Level("reference_error", 1.01 * error**2),
        *(Level(path, 1.01 * tried**2) for path in ("trial_error", "trial_reference_error")),
        Level("step_error", 1.01 * moved**2),
    )
    floats = {f"x[{j}]": symmetric(regressor).outwards() for j in range(numbers.size)}
    floats |= {f"{name}[{j}]": symmetric(limit) for name in PARAMETERS for j in range(numbers.size)}
    floats |= {
        "inflate": Interval(1.0, float(max(numbers.inflate, numbers.inflate_first))),
        "innovation_um": symmetric(error).outwards(),
        "trial_um": symmetric(tried),
        "trial_reference_um": symmetric(tried),
        "fixed_um": symmetric(instance["y_um"].magnitude),
        "y_um": y,
        "u_V": u,
        "mean_u_V": u.outwards(2.0 * FAST * u.width),
    }
    floats |= {level.path: level.box for level in levels}
    floats |= {path: box for path, box in instance.items() if path.startswith(("terms.", "inputs."))}
    integers = {**parts_box(model).integers, "turn": numbers.size - 1}
    integers |= {member.name: 1 for member in LearnerWords.described() if member.holds is Holds.FLAG}
    return LearnerBox(floats, integers, levels)
