"""One step of a path from a given state, in numbers that are handed in: what float32 adds to w in that step.

    Real       float64 over lanes: w in real arithmetic, from the state in which the float32 mirrors are
    Bounded    numbers with their errors (`rounding`), over every input and every state of the box

Both start from the same state, as a step of the rules starts from the same y. The box of a state is that of its block;
of creep and modes it is what any past of inputs leaves, part by part,

    |c - middle| <= (S + t) half width of x,   S = sum_k |s (1 - s)^k|,   t: what the roundings of all steps add

A play is the middle of z, x - r and x + r, a limit that of x and its ends: whichever it is, its error is at most the
largest of the three. A state of two words is their sum; the output takes the higher.
"""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hysgen.float32.coefficients import coefficients
from hysgen.float32.reference import rounding
from hysgen.float32.reference.rounding import HALF_BIT, LIBRARY, Enclosed, Floats, Interval, Tape, largest_error
from hysgen.model.float32_arithmetic import Floats32, flushed, power_of_two
from hysgen.model.model import Model
from hysgen.model.path.base import BlockMirror, InputBlock
from hysgen.model.path.chain import ChainMirror
from hysgen.model.path.creep import Creep
from hysgen.model.path.delay import Delay
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.path.hysteresis_mirror import LOG2_E, horner, power_coefficients, series_value
from hysgen.model.path.limits import Saturation, Slew
from hysgen.model.path.modes import Modes

Number = Any
"""A float64 number, an array of them over lanes, or an `Enclosed`."""

CELLS: Final = 256
"""Parts of the range of the input of the responses."""
LOST: Final = 16.0
"""Roundings of |s| (|x| + |c|) by which a step of a mode is off at most: seven, and what the lower word loses."""


class Real:
    """float64 numbers over lanes, from the state of a float32 mirror."""

    def __init__(self, mirror: BlockMirror) -> None:
        self._mirror: Any = mirror

    def constant(self, exact: float, rounded: np.float32, size: float = 0.0) -> Number:
        return exact

    def exact(self, value: float) -> Number:
        return value

    def past(self, samples: int, x: Number) -> Number:
        return self._mirror.past(samples - 1).astype(np.float64) if samples else x

    def last(self) -> Number:
        return self._mirror.last_V.astype(np.float64)

    def lags(self, x: Number, words: Sequence[str], steps: Floats) -> list[list[Number]]:
        low = "low" if words == ("high",) else "{}_low"
        return [[self._word(word, j) + self._word(low.format(word), j) for j in range(len(steps))] for word in words]

    def limited(self, x: Number, low: Number, high: Number) -> Number:
        return np.clip(x, low, high)

    def flushed(self, x: Number) -> Number:
        return x

    def pulled(self, play: int, end: float, x: Number, r: Number) -> Number:
        low = self._word("play_low", play) if hasattr(self._mirror, "play_low") else 0.0
        return np.clip(self._word("play", play) + low, x - r, x + r)

    def moved(self, x: Number, states: int) -> tuple[Number, list[Number]]:
        last, turn = (word.astype(np.float64) for word in (self._mirror.last, self._mirror.turn))
        falls = np.where(x == last, last < turn, x < last)
        turned = falls ^ (last < turn)
        self._side = np.where(falls, -1.0, 1.0)
        lefts = [np.where(turned, self._word("back", i), self._word("left", i)) for i in range(states)]
        return np.abs(x - np.where(turned, last, turn)), lefts

    def decayed(self, way: Number, rate: Number) -> Number:
        return np.exp2(way * rate)

    def duhem(self, d: Number, b: Number, c: Number) -> Number:
        return d * (b + c * np.abs(d))

    def sided(self, h: Number, duhem: Number) -> Number:
        return h + self._side * duhem

    def _word(self, name: str, place: int) -> Floats:
        return np.asarray(getattr(self._mirror, name)[place], dtype=np.float64)


class Bounded:
    """Numbers with their errors on a tape, over all inputs and states; span: that of the input of a delay or slew."""

    def __init__(self, tape: Tape, block: InputBlock, span: Interval) -> None:
        self._span, self.constant = span, tape.constant
        self._tape, self._relaxes = tape, isinstance(block, Hysteresis) and block.relaxes

    def exact(self, value: float) -> Number:
        return self._tape.number(_every(value, value))

    def past(self, samples: int, x: Enclosed) -> Number:
        return self.last() if samples else x

    def last(self) -> Number:
        return self._tape.number(self._span)

    def lags(self, x: Enclosed, words: Sequence[str], steps: Floats) -> list[list[Number]]:
        """States of c <- c + s (x - c), by word: the reach of the real ones, and twice what their roundings add."""
        low, high = float(x.value.low.min()), float(x.value.high.max())
        states: list[list[Number]] = [[] for _ in words]
        for step in steps.astype(np.complex128).tolist():
            reach, fading = 0.5 * (high - low) * _reach(step), 1.0 - abs(1.0 - step)
            most = max(abs(low), abs(high)) + float(reach.sum())
            off = ((LOST * HALF_BIT * abs(step) + 2.0**-44) * most + 2.0**-58) / fading if fading > 0.0 else np.inf
            off = 2.0 * off if off < most else np.inf
            for of_word, middle, around in zip(states, (0.5 * (low + high), 0.0), reach.tolist(), strict=False):
                of_word.append(self._two_words(_every(middle - around - off, middle + around + off)))
        return states

    def limited(self, x: Enclosed, low: Enclosed, high: Enclosed) -> Number:
        value = Interval(*(np.clip(end, low.value.low, high.value.high) for end in (x.value.low, x.value.high)))
        of_ends = np.maximum(largest_error(low), largest_error(high))
        return x.then("limited", value, [(x, _every(0.0, 1.0)), (low, _every(0.0, 0.0))], of_ends)

    def flushed(self, x: Enclosed) -> Number:
        return flushed(x)  # type: ignore[arg-type]

    def pulled(self, play: int, end: float, x: Enclosed, r: Enclosed) -> Number:
        value = Interval(np.maximum((x.value + -r.value).low, -end), np.minimum((x.value + r.value).high, end))
        z = [(self._two_words(_every(-end, end)), _every(0.0, 1.0))] if self._relaxes else []
        return x.then("play", value, [*z, (x, _every(0.0, 1.0)), (r, _every(-1.0, 1.0))])

    def moved(self, x: Enclosed, states: int) -> tuple[Number, list[Number]]:
        way = x.then("way", Interval(np.zeros(1), 1.0 + x.value.size), [(x, _every(-1.0, 1.0))])
        return way, [self._tape.number(_every(0.0, 2.0)) for _ in range(states)]

    def decayed(self, way: Enclosed, rate: Enclosed) -> Number:
        return self.limited(power_of_two(way * rate), self.exact(0.0), self.exact(1.0))  # type: ignore[arg-type]

    def duhem(self, d: Enclosed, b: Enclosed, c: Enclosed) -> Number:
        """The rounding of x may turn the input: d then starts from the other side of the turn, and both are rounded."""
        d = d.then("turned", d.value, [(d, 1)], largest_error(d).max() + 4.0 * HALF_BIT)
        return d * (b + c * d.then("||", Interval(np.zeros(1), d.value.size), [(d, _every(-1.0, 1.0))], 0.0))

    def sided(self, h: Enclosed, duhem: Enclosed) -> Number:
        both = Interval(-duhem.value.size, duhem.value.size)
        return h.then("sided", h.value + both, [(h, 1), (duhem, _every(-1.0, 1.0))])

    def _two_words(self, value: Interval) -> Enclosed:
        return self._tape.number(value, rounding=2.0 * HALF_BIT * value.size)


Numbers = Real | Bounded
"""The numbers of a step of one block."""


def _every(low: float, high: float) -> Interval:
    return Interval(np.full(1, low), np.full(1, high))


@functools.lru_cache(maxsize=256)
def _reach(step: complex) -> Floats:
    """(2,) bounds of the sums of |Re s (1 - s)^k| and of |Im s (1 - s)^k|."""
    pole = 1.0 - step
    if step.imag == 0.0 or abs(pole) >= 1.0:
        return np.array([1.0, 0.0]) if abs(pole) < 1.0 else np.full(2, np.inf)
    samples = min(int(-12.0 / np.log(abs(pole))) + 2, 1_000_000)
    impulse = step * pole ** np.arange(samples)
    rest = 1.01 * abs(step) * abs(pole) ** samples / (1.0 - abs(pole))
    return np.asarray((1.0 + LIBRARY * samples) * np.abs([impulse.real, impulse.imag]).sum(axis=1) + rest)


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
    h: Number = curved + _sum(sums) if sums else curved
    if not block.states:
        return h
    way, lefts = n.moved(x, block.states)
    e = n.decayed(way, n.constant(-LOG2_E / block.reach, number.rate))
    for start, exact, rounded in zip(lefts, series.duhem, number.duhem, strict=True):
        parts.append(n.duhem(unit - start * e, *(n.constant(float(exact[k]), rounded[k]) for k in range(2))))
        e = e * e
    return n.sided(h, _sum(parts))


@functools.lru_cache(maxsize=4)
def _series_powers(block: Hysteresis) -> tuple[Floats, Floats]:
    return power_coefficients(block.series)


@output.register
def _(block: Creep, x: Number, n: Numbers, Ts_s: float) -> Number:
    constants = block.constants(Ts_s)
    (states,) = n.lags(x, ("high",), constants["rate"].astype(np.float64))
    return x + n.constant(block.amount, constants["amount"][0]) * _sum(states)


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
    return n.constant(direct, constants["direct"][0], size) * x + _sum(parts)


def _sum(parts: Sequence[Number]) -> Number:
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
    span = _every(float(numbers.u_min_V), float(numbers.u_max_V))
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


@dataclass(frozen=True)
class ProvedErrors:
    """Proved bounds of one step from any state.

    predict_um: of y(k+1) for every y and u in their ranges. path: part of w in it, in its unit. inverse_V: of the
    inverse's u(k) without responses of the stage. inverse_um: with them, of y(k+1) in real arithmetic against its
    reference, unless a limit acts, has led a mode astray, or the C says that the path is missed; behind a delay of
    a fraction, for the voltage that it wants at the stage.
    """

    predict_um: float
    path: float
    inverse_V: float | None
    inverse_um: float | None


def proved_errors(model: Model, *, inverse: bool) -> ProvedErrors | None:
    """The bounds of `model`; None for a windowed layout, where disturbances are added, and of a path without a bound.

    The box of the inverse reaches beyond the range of w, where its limits act.
    """
    numbers, path = coefficients(model), w_error(model)
    if numbers.windowed or model.terms or path == np.inf:
        return None
    bounds = [np.inf, np.inf]
    if inverse and all(block.solves(model.Ts_s) for block in model.blocks):
        # The C compares the w that its path reaches with the one it wants.
        missed = path + 1.001 * float(numbers.w_tolerance) if model.responds else None
        bounds[int(model.responds)] = rounding.worst(model, 0.0, inverse=True, missed=missed)
    finite = (bound if np.isfinite(bound) else None for bound in bounds)
    return ProvedErrors(rounding.worst(model, path), path, *finite)
