"""One step of a path from a given state, in numbers that are handed in: what float32 adds to w in that step.

    Real       w in real arithmetic, from the state in which the float32 mirrors are
    Bounded    the bound of its error, over every input and every state (`step_numbers`)

Both start from the same state, as a step of the rules starts from the same y.
"""

import functools
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from hysgen.float32.coefficients import coefficients
from hysgen.float32.reference.enclosed import Enclosed, Floats, Interval, Tape, largest_error
from hysgen.float32.reference.step_numbers import CELLS, Bounded, Number, Numbers, Real, every
from hysgen.machine.reproducible import expm1
from hysgen.model.float32_arithmetic import Floats32, flushed
from hysgen.model.model import Model
from hysgen.model.path.base import InputBlock
from hysgen.model.path.chain import ChainMirror
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.hysteresis_mirror import LOG2_E, horner, power_coefficients, series_value
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.loop import MIDDLE, Loop
from hysgen.model.path.modes import Modes
from hysgen.model.path.softening import ENDS, MOST, Softening
from hysgen.model.path.softening_mirror import SHARES

_LOOP: Final = {"box": "box_um"}


@functools.singledispatch
def output(block: InputBlock, x: Number, n: Numbers, Ts_s: float) -> Number:
    """Output of a block for the input x, in the numbers n."""
    raise NotImplementedError


@output.register
def _(block: Saturation, x: Number, n: Numbers, Ts_s: float) -> Number:
    low, high = (
        n.exact(float(rounded)) if level is None else n.constant(level, rounded)
        for level, (rounded,) in zip((block.low_V, block.high_V), block.constants(Ts_s).values(), strict=True)
    )
    return n.limited(x, low, high)


@output.register
def _(block: Slew, x: Number, n: Numbers, Ts_s: float) -> Number:
    (rise,), (fall,) = block.constants(Ts_s).values()
    last = n.last()
    low, high = n.constant(block.fall_V_s * Ts_s, fall), n.constant(block.rise_V_s * Ts_s, rise)
    return n.limited(x, last - low, last + high)


@output.register
def _(block: Delay, x: Number, n: Numbers, Ts_s: float) -> Number:
    late, later = n.past(block.whole, x), n.past(block.whole + 1, x)
    return late + n.constant(block.part, block.constants(Ts_s)["part"][0]) * (later - late)


@output.register
def _(block: Hysteresis, v: Number, n: Numbers, Ts_s: float) -> Number:
    number, series = block.numbers, block.series
    middle = n.constant(0.5 * (block.low_V + block.high_V), number.middle)
    per_half = n.constant(2.0 / (block.high_V - block.low_V), number.per_half)
    unit = n.exact(1.0)
    x = n.flushed(n.limited((v - middle) * per_half, n.exact(-1.0), unit))
    curve, powers = _series_powers(block)
    size = float(2.0**block.curve_degree * (np.abs(series.curve).sum() + np.abs(series.plays).sum()))
    curved = series_value(x, [n.constant(*pair, size) for pair in zip(curve, number.curve[0, 0], strict=True)])
    sums, parts = [], []
    for j in reversed(range(block.plays)):
        # The end in float32 may lie a rounding further out.
        z = n.pulled(j, (1.0 + 2.0**-20) * block.ends[j], x, n.constant(series.half_width[j], number.play[j, 0]))
        pairs = zip(powers[j, 1:], number.play[j, 1:], strict=True)
        sums.append(z * horner(z, [n.constant(*pair, size) for pair in pairs]))
    h: Number = curved + summed(sums) if sums else curved
    if not block.states:
        return h
    way, lefts = n.moved(x, block.states)
    e = n.decayed(way, n.constant(-LOG2_E / block.reach, number.rate))
    for start, exact, rounded in zip(lefts, series.duhem, number.duhem, strict=True):
        parts.append(n.duhem(unit - start * e, *(n.constant(float(exact[k]), rounded[k]) for k in range(2))))
        e = e * e
    return n.sided(h, summed(parts))


@functools.lru_cache(maxsize=4)
def _series_powers(block: Hysteresis) -> tuple[Floats, Floats]:
    return power_coefficients(block.series)


@output.register
def _(block: Creep, x: Number, n: Numbers, Ts_s: float) -> Number:
    constants = block.constants(Ts_s)
    (states,) = n.lags(x, ("high",), constants["rate"].astype(np.float64))
    return x + n.constant(block.amount, constants["amount"][0]) * summed(states)


@functools.lru_cache(maxsize=4)
def _mode_numbers(block: Modes, Ts_s: float) -> tuple[Mapping[str, Floats32], tuple[Floats, Floats], float]:
    return block.constants(Ts_s), block.weights(Ts_s), block.direct(Ts_s)


@output.register
def _(block: Modes, x: Number, n: Numbers, Ts_s: float) -> Number:
    constants, weights, direct = _mode_numbers(block, Ts_s)
    size = 1.0 + float(np.abs(weights).sum())
    named = zip(weights, (constants["of_position"], constants["of_velocity"]), strict=True)
    factors = [[n.constant(*pair, size) for pair in zip(*both, strict=True)] for both in named]
    states = n.lags(x, ("position", "velocity"), constants["real"] + 1j * constants["imag"])
    parts = [a * position + b * velocity for a, b, position, velocity in zip(*factors, *states, strict=True)]
    return n.constant(direct, constants["direct"][0], size) * x + summed(parts)


@output.register
def _(block: Loop, x: Number, n: Numbers, Ts_s: float) -> Number:
    constants = block.constants(Ts_s)
    step, rate = complex(block.mode.steps(Ts_s / block.parts)[0]), -expm1(-Ts_s / block.lag_s)
    keep, rises, per_rate = (
        n.constant(*pair) for pair in zip((1.0 - rate, rate, 1.0 / rate), constants["lag"], strict=True)
    )
    real, imag = (n.constant(*pair) for pair in zip((step.real, step.imag), constants["mode"], strict=True))
    names = ("force", "quadrature", "loading", "unloading", "box")
    columns = [zip(getattr(block, _LOOP.get(name, name)), constants[name], strict=True) for name in names]
    shapes = list(zip(*([n.constant(*pair) for pair in column] for column in columns), strict=True))
    forces = np.array(block.force) + 1j * np.array(block.quadrature)
    (position,), (velocity,) = n.modes(np.array([1.0 - step]), forces[None], np.array(block.box_um))
    h = [n.stored("h", r + 1, -end, end)[r] for r, end in enumerate(block.box_um)]
    ends = (x.value.low.min(), x.value.high.max()) if isinstance(x, Enclosed) else (0.0, 0.0)
    past = n.stored("y", 3, *(1.000001 * end for end in ends))
    before = n.high(position)
    y, zeta = n.flushed(keep * past[0] + rises * x), past[0] + before
    for part in range(block.parts):
        at, speed = n.high(position), n.high(velocity)
        pushes = [
            [factor * state for factor, state in zip(column, h, strict=True)]
            for column in list(zip(*shapes, strict=True))[:2]
        ]
        forward = summed([n.exact(0.0) - (real * at + imag * speed), *pushes[0]])
        turn = summed([imag * at - real * speed, *pushes[1]])
        position, velocity = n.moved_on(position, forward), n.moved_on(velocity, turn)
        if part + 1 < block.parts:
            first, second, third, fourth = (n.exact(weight) for weight in MIDDLE)
            middle = (first * y + second * past[0]) + (third * past[1] + fourth * past[2])
            d = n.flushed((middle + n.high(position)) - zeta)
            h = [n.followed(d, state, *shape[2:]) for shape, state in zip(shapes, h, strict=True)]
    return x + (n.high(position) - keep * before) * per_rate


@output.register
def _(block: Softening, x: Number, n: Numbers, Ts_s: float) -> Number:
    constants, numbers, drives = block.constants(Ts_s), block.numbers(Ts_s), 1 + len(block.channels)
    rate, modes = -expm1(-Ts_s / block.lag_s), len(block.f_Hz)
    keep, per_rate = (n.constant(*pair) for pair in zip((1.0 - rate, 1.0 / rate), constants["lag"], strict=True))
    rise, level = (
        n.constant(block.rate(Ts_s), constants["of_amplitude"][0]),
        n.constant(block.level_um, constants["level"][0]),
    )
    rounded = [constants[name].reshape(shape) for name, shape in (("fall", (2, modes)), ("seen", (2, modes)))]
    poles = [
        [n.constant(*pair, 1.0) for pair in zip(*both, strict=True)]
        for both in ((1.0 - numbers[:, 0], constants["real"]), (-numbers[:, 1], constants["imag"]))
    ]
    falls, seen = (
        [[n.constant(*pair) for pair in zip(numbers[:, at + i], of[i], strict=True)] for i in range(2)]
        for at, of in ((2, rounded[0]), (4, rounded[1]))
    )
    shares = [
        [
            [
                n.constant(*pair)
                for pair in zip(numbers[m, at : at + drives], constants[name].reshape(modes, -1)[m], strict=True)
            ]
            for m in range(modes)
        ]
        for at, name in zip(range(6, 6 + 4 * drives, drives), SHARES, strict=True)
    ]
    own = n.flushed(x - level)
    v = [own, *(n.heard(channel, 0) for channel in range(drives - 1))]
    most = np.array([float(value.value.size.max()) if isinstance(value, Enclosed) else 0.0 for value in v])
    ends = np.array([block.poles(Ts_s, s) for s in ENDS]).T
    Q, R = (numbers[:, at : at + drives] + 1j * numbers[:, at + drives : at + 2 * drives] for at in (6, 6 + 2 * drives))
    pushed = np.abs(1.0 - ends)[:, None, :] * np.abs(Q)[:, :, None] + 2.0 * ENDS[1] * np.abs(R)[:, :, None]
    positions, velocities = n.modes(ends, pushed, most)
    last = [n.stored("last", j + 1, -end, end)[j] for j, end in enumerate(most.tolist())]
    (env,) = n.stored("env", 1, 0.0, MOST)
    at, speed = [n.high(position) for position in positions], [n.high(velocity) for velocity in velocities]
    zeta = summed([a * x - b * y for a, b, x, y in zip(*seen, at, speed, strict=True)])
    env = n.flushed(n.limited(env + rise * (n.size(zeta) - env), n.exact(0.0), n.exact(MOST)))
    s = n.flushed(n.saturated(env))
    ways = [n.flushed(now - before) for now, before in zip(v, last, strict=True)]
    moved = []
    for m, position in enumerate(positions):
        real, imag = (poles[part][m] - s * falls[part][m] for part in range(2))
        of = [summed([weight * value for weight, value in zip(shares[part][m], v, strict=True)]) for part in range(2)]
        swing = summed([weight * way for weight, way in zip(shares[2][m], ways, strict=True)])
        forward = (real * (of[0] - at[m]) - imag * (of[1] - speed[m])) + s * swing
        moved.append(n.high(n.moved_on(position, forward)))
    return level + (summed(moved) - keep * summed(at)) * per_rate


def summed(parts: Sequence[Number]) -> Number:
    return functools.reduce(lambda total, part: total + part, parts)


def traced(model: Model) -> bool:
    """Whether every kind of block of the path has an `output` here."""
    return all(output.dispatch(type(block)) is not output.dispatch(InputBlock) for block in model.blocks)


def real_w(model: Model, chain: ChainMirror, u_V: Floats32, *, stage: bool = False) -> Floats:
    """w of the inputs u_V, (lanes,), in real arithmetic, from the float32 state of `chain`, which stays.

    stage: only the responses of the stage, whose input is u_V. The blocks are `traced`.
    """
    w = u_V.astype(np.float64)
    for block, mirror in zip(model.blocks, chain.blocks, strict=True):
        if block.responds or not stage:
            w = output(block, w, Real(mirror), model.Ts_s)
    return np.clip(w, model.w_range.low, model.w_range.high) if model.responds else w


def w_error(model: Model) -> float:
    """Bound of |w_float32 - w_real| of one step, whatever the input and the state; infinite where there is none."""
    if not traced(model):
        return np.inf
    numbers, tape, off = coefficients(model), Tape(), 0.0
    x: Number = None
    span = every(float(numbers.u_min_V), float(numbers.u_max_V))
    for block in model.blocks:
        if block.responds and x is None:
            # The input of the responses is divided; a delay ends a rounding beyond its own input.
            span = Interval.over(span.low, span.high, apart=2.0**-20)
            ends, tape = np.linspace(float(span.low[0]), float(span.high[0]), CELLS + 1), Tape()
            x = tape.number(Interval(ends[:-1], ends[1:]), rounding=off)
        result = output(block, x or tape.number(span, rounding=off), Bounded(tape, block, span), model.Ts_s)
        if block.responds:
            x = flushed(result)
        else:
            off = float(largest_error(result).max())
            span = Interval(np.maximum(span.low, result.value.low), np.minimum(span.high, result.value.high))
    if x is not None:
        ends_w = (model.w_range.low, numbers.w_min), (model.w_range.high, numbers.w_max)
        limited = Bounded(tape, block, span).limited(x, *(tape.constant(*end) for end in ends_w))
        off = float(largest_error(limited).max())
    return off if np.isfinite(off) else np.inf
