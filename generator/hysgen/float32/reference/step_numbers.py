"""The numbers in which a step of a path is computed (`path_rounding`), from a given state.

    Real       float64 over lanes, from the state in which the float32 mirrors are
    Bounded    numbers with their errors (`enclosed`), over every input and every state of the box

The box of a state is that of its block; of creep and modes it is what any past of inputs leaves, part by part,

    |c - middle| <= (S + t) half width of x,   S = sum_k |s (1 - s)^k|,   t: what the roundings of all steps add

and of modes whose pole lam moves, under inputs of d about their middles,

    |c| <= max (|1 - lam| |Q| + 2 s |R|) d / (1 - max |lam|)

A play is the middle of z, x - r and x + r, a limit that of x and its ends: whichever it is, its error is at most the
largest of the three. A state of two words is their sum; the output takes the higher.
"""

import functools
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.float32.reference.enclosed import HALF_BIT, LIBRARY, Enclosed, Floats, Interval, Tape, largest_error, slopes
from hysgen.model.float32_arithmetic import LEAST, RECIPROCAL_RELATIVE_ERROR, flushed, power_of_two
from hysgen.model.path.channels import Channels
from hysgen.model.path.hysteresis import Hysteresis

Complex = NDArray[np.complex128]
Number = Any
"""A float64 number, an array of them over lanes, or an `Enclosed`."""

CELLS: Final = 256
"""Parts of the range of the input of the responses."""
LIKELY: Final = 16.0
STARTS: Final = 64
"""Of a state in the loop: displacements in boxes up to which it may end inside, and parts of the box."""
LOST: Final = 16.0
"""Roundings of |s| (|x| + |c|) by which a step of a mode is off at most: seven, and what the lower word loses."""


class Real:
    """float64 numbers over lanes, from the state of a float32 mirror."""

    def __init__(self, mirror: object, heard: Sequence[Floats] = ()) -> None:
        """heard: the newest sample of every channel about its middle, where it is known better than the mirror's."""
        self._mirror: Any = mirror
        self._heard = heard

    def constant(self, exact: float, rounded: np.float32, size: float = 0.0) -> Number:
        return exact

    def exact(self, value: float) -> Number:
        return value

    def past(self, samples: int, x: Number) -> Number:
        return self._mirror.past(samples - 1).astype(np.float64) if samples else x

    def last(self) -> Number:
        return self._mirror.last_V.astype(np.float64)

    def lags(self, x: Number, words: Sequence[str], steps: Floats) -> list[list[Number]]:
        return [[self._words(word, j) for j in range(len(steps))] for word in words]

    def modes(self, poles: Complex, drives: NDArray[Any], most: Floats) -> list[list[Number]]:
        return [[self._words(word, m) for m in range(len(poles))] for word in ("position", "velocity")]

    def stored(self, name: str, places: int, low: float, high: float) -> list[Number]:
        return [self.word(name, place) for place in range(places)]

    def heard(self, channel: int, age: int) -> Number:
        if self._heard and age == 0:
            return self._heard[channel]
        return self._mirror.sample[channel][age].astype(np.float64)

    def bias(self, name: str, limit: float) -> Number:
        return self._words(name, 0)

    def high(self, state: Number) -> Number:
        return state

    def moved_on(self, state: Number, delta: Number) -> Number:
        return state + delta

    def limited(self, x: Number, low: Number, high: Number) -> Number:
        return np.clip(x, low, high)

    def flushed(self, x: Number) -> Number:
        return x

    def pulled(self, play: int, end: float, x: Number, r: Number) -> Number:
        low = self.word("play_low", play) if hasattr(self._mirror, "play_low") else 0.0
        return np.clip(self.word("play", play) + low, x - r, x + r)

    def size(self, x: Number) -> Number:
        return np.abs(x)

    def bent(self, w: Number, above: Number, below: Number) -> Number:
        return np.where(w > 0.0, above, below) * w

    def followed(self, d: Number, h: Number, loading: Number, unloading: Number, box: Number) -> Number:
        moved = heun(self, np.where(d < 0.0, -h, h), np.abs(d), loading, unloading)
        return np.where(d < 0.0, -1.0, 1.0) * np.clip(moved, -box, box)

    def saturated(self, env: Number) -> Number:
        return env / (1.0 + env)

    def moved(self, x: Number, states: int) -> tuple[Number, list[Number]]:
        last, turn = (word.astype(np.float64) for word in (self._mirror.last, self._mirror.turn))
        falls = np.where(x == last, last < turn, x < last)
        turned = falls ^ (last < turn)
        self._side = np.where(falls, -1.0, 1.0)
        lefts = [np.where(turned, self.word("back", i), self.word("left", i)) for i in range(states)]
        return np.abs(x - np.where(turned, last, turn)), lefts

    def decayed(self, way: Number, rate: Number) -> Number:
        return np.exp2(way * rate)

    def duhem(self, d: Number, b: Number, c: Number) -> Number:
        return d * (b + c * np.abs(d))

    def sided(self, h: Number, duhem: Number) -> Number:
        return h + self._side * duhem

    def word(self, name: str, place: int) -> Floats:
        word = getattr(self._mirror, name)
        return np.asarray(word[place] if isinstance(word, list) or word.ndim > 1 else word, dtype=np.float64)

    def _words(self, name: str, place: int) -> Floats:
        low = "low" if name == "high" else f"{name}_low"
        return self.word(name, place) + (self.word(low, place) if hasattr(self._mirror, low) else 0.0)


class Bounded:
    """Numbers with their errors on a tape, over all inputs and states; span: that of the input of a delay or slew."""

    def __init__(self, tape: Tape, part: object, span: Interval) -> None:
        self._span, self.constant, self._part = span, tape.constant, part
        self._moves: dict[int, float] = {}
        self._tape, self._relaxes = tape, isinstance(part, Hysteresis) and part.relaxes

    def exact(self, value: float) -> Number:
        return self._tape.number(every(value, value))

    def past(self, samples: int, x: Enclosed) -> Number:
        return self.last() if samples else x

    def last(self) -> Number:
        return self._tape.number(self._span)

    def lags(self, x: Enclosed, words: Sequence[str], steps: Floats) -> list[list[Number]]:
        """States of c <- c + s (x - c), by word: the reach of the real ones, and twice what their roundings add."""
        low, high = float(x.value.low.min()), float(x.value.high.max())
        states: list[list[Number]] = [[] for _ in words]
        for step in steps.astype(np.complex128).tolist():
            reach = 0.5 * (high - low) * _reach(step, step)
            most = max(abs(low), abs(high)) + float(reach.sum())
            ends = self._ends(abs(step), reach, most, 1.0 - abs(1.0 - step))
            for of_word, middle, end in zip(states, (0.5 * (low + high), 0.0), ends, strict=False):
                of_word.append(self.high(self._state(every(middle - end, middle + end), abs(step) * most)))
        return states

    def modes(self, poles: Complex, drives: NDArray[Any], most: Floats) -> list[list[Number]]:
        """States of c <- lam c + sum_j drives_j v_j, |v_j| <= most_j, by word: as `lags`.

        poles: (m,), or (m, 2) between which lam moves; drives: (m, j), or (m, j, 2).
        """
        states: list[list[Number]] = [[], []]
        for lam, given in zip(poles, drives, strict=True):
            if np.ndim(lam):
                fading = 1.0 - float(np.abs(lam).max())
                sizes = (np.abs(given) * most[:, None]).sum(axis=0)
                reach = np.full(2, float(sizes.max()) / fading if fading > 0.0 else np.inf)
            else:
                fading = 1.0 - abs(complex(lam))
                reach = sum(end * _reach(1.0 - complex(lam), complex(d)) for d, end in zip(given, most, strict=True))
            size = float(np.abs(1.0 - np.array(lam)).max())
            pushed = float((np.abs(given).reshape(len(most), -1).max(axis=1) * most).sum())
            whole = float(reach.sum()) + (1.0 + len(most)) * pushed / size
            for of_word, end in zip(states, self._ends(size, reach, whole, fading), strict=True):
                of_word.append(self._state(every(-end, end), size * whole))
        return states

    def _state(self, value: Interval, moves: float) -> Enclosed:
        """A sum of two words that moves by at most `moves` in a step."""
        state = self._tape.number(value)
        self._moves[state.place] = 1.01 * moves
        return state

    def _ends(self, size: float, reach: Floats, most: float, fading: float) -> list[float]:
        """Reach of the words of a state that moves by steps of up to `size` times `most`, roundings included."""
        off = ((LOST * HALF_BIT * size + 2.0**-44) * most + 2.0**-58) / fading if fading > 0.0 else np.inf
        return [end + (2.0 * off if off < most else np.inf) for end in reach.tolist()]

    def stored(self, name: str, places: int, low: float, high: float) -> list[Number]:
        return [self._tape.number(every(low, high)) for _ in range(places)]

    def bias(self, name: str, limit: float) -> Number:
        """A state that is limited, to which its lower word is added."""
        return self._tape.number(every(*(end * (1.0 + 4.0 * HALF_BIT) for end in (-limit, limit))))

    def rounded(self, value: Interval, rounding: float) -> Number:
        return self._tape.number(value, rounding=rounding)

    def heard(self, channel: int, age: int) -> Number:
        """A sample about its middle: `aux` limits it to the float32 numbers of its range, and subtracts."""
        assert isinstance(self._part, Channels)
        ends, middle = (self._part.low[channel], self._part.high[channel]), self._part.middle[channel]
        apart = max(abs(float(np.float32(end)) - end) for end in ends) + float(LEAST)
        away = Interval.over(*(np.full(1, end - middle) for end in ends))
        return self._tape.number(away, rounding=apart + 2.0 * HALF_BIT * away.size)

    def high(self, state: Enclosed) -> Number:
        """The higher word of a state: `accumulate` leaves half a bit of the sum and of the step in the lower one."""
        size = state.value.size
        lost = HALF_BIT * (size + np.minimum(2.0 * size, self._moves.get(state.place, np.inf)))
        return state.then("high", state.value, [(state, 1)], 1.01 * lost)

    def moved_on(self, state: Enclosed, delta: Enclosed) -> Number:
        """Both words of a state behind `accumulate`, which rounds the step twice, and the lower word once."""
        rounding = 4.0 * HALF_BIT * (delta.value.size + HALF_BIT * state.value.size) + 2.0**-59
        moved = state.then("moved on", state.value + delta.value, [(state, 1), (delta, 1)], rounding)
        self._moves[moved.place] = 2.0 * float(delta.value.size.max()) + float(HALF_BIT * state.value.size.max())
        return moved

    def limited(self, x: Enclosed, low: Enclosed, high: Enclosed) -> Number:
        value = Interval(*(np.clip(end, low.value.low, high.value.high) for end in (x.value.low, x.value.high)))
        of_ends = np.maximum(largest_error(low), largest_error(high))
        return x.then("limited", value, [(x, every(0.0, 1.0)), (low, every(0.0, 0.0))], of_ends)

    def flushed(self, x: Enclosed) -> Number:
        return flushed(x)  # type: ignore[arg-type]

    def pulled(self, play: int, end: float, x: Enclosed, r: Enclosed) -> Number:
        value = Interval(np.maximum((x.value + -r.value).low, -end), np.minimum((x.value + r.value).high, end))
        z = [(self.high(self._tape.number(every(-end, end))), every(0.0, 1.0))] if self._relaxes else []
        return x.then("play", value, [*z, (x, every(0.0, 1.0)), (r, every(-1.0, 1.0))])

    def size(self, x: Enclosed) -> Number:
        return x.then("||", Interval(np.zeros(1), x.value.size), [(x, every(-1.0, 1.0))], 0.0)

    def bent(self, w: Enclosed, above: Enclosed, below: Enclosed) -> Number:
        """above w for w > 0, below w otherwise: its slope is one of both, or lies between."""
        rises, falls = w.value.high > 0.0, w.value.low < 0.0
        ends = [
            np.where(rises, np.where(falls, pick(over, under), over), under)
            for pick, over, under in (
                (np.minimum, above.value.low, below.value.low),
                (np.maximum, above.value.high, below.value.high),
            )
        ]
        slope = Interval(*ends)
        off = np.maximum(largest_error(above), largest_error(below)) * w.value.size
        value = slope * w.value
        return w.then("bent", value, [(w, slope)], off + 2.0 * HALF_BIT * value.size)

    def followed(self, d: Enclosed, h: Enclosed, loading: Enclosed, unloading: Enclosed, box: Enclosed) -> Number:
        """Slopes and rounding are the largest of all parts of h and |d| from where h may end inside its box.

        The sign of d may be that of a rounding: where d is 0, h stays, whichever it is.
        """
        end, most = float(box.value.high.max()), float(d.value.size.max())
        inner = min(most, LIKELY * end)
        ways = np.unique([*np.linspace(0.0, inner, 4 * CELLS + 1), *np.geomspace(inner, most, CELLS)])
        starts = np.linspace(-end, end, STARTS + 1)
        n = Bounded(Tape(), self._part, self._span)
        w = n._tape.number(Interval(np.repeat(starts[:-1], ways.size - 1), np.repeat(starts[1:], ways.size - 1)))
        size = n._tape.number(Interval(np.tile(ways[:-1], STARTS), np.tile(ways[1:], STARTS)))
        rates = [n._tape.number(rate.value, known=rate.known) for rate in (loading, unloading)]
        moved = heun(n, w, size, *rates)
        ends = (moved.value.low <= end) & (moved.value.high >= -end)
        unit = np.ones_like(moved.value.low)
        by = slopes(n._tape, {moved.place: Interval(unit, unit)})
        of_h, of_d = (float(by[number.place].size[ends].max()) for number in (w, size))
        rounding = float(largest_error(moved)[ends].max()) + float(largest_error(box).max()) + float(LEAST)
        value = Interval(-box.value.size, box.value.size)
        return h.then("followed", value, [(h, every(-of_h, of_h)), (d, every(-of_d, of_d))], rounding)

    def saturated(self, env: Enclosed) -> Number:
        """env/(1 + env), which rises: the rounding of the sum, of 1/x and of the product."""
        least, most = (end / (1.0 + end) for end in (env.value.low, env.value.high))
        slope = Interval.over(1.0 / (1.0 + env.value.low) ** 2, 1.0 / (1.0 + env.value.high) ** 2, apart=LIBRARY)
        rounding = (3.0 * HALF_BIT + RECIPROCAL_RELATIVE_ERROR) * most
        return env.then("saturated", Interval.over(least, most, apart=LIBRARY), [(env, slope)], rounding)

    def moved(self, x: Enclosed, states: int) -> tuple[Number, list[Number]]:
        way = x.then("way", Interval(np.zeros(1), 1.0 + x.value.size), [(x, every(-1.0, 1.0))])
        return way, [self._tape.number(every(0.0, 2.0)) for _ in range(states)]

    def decayed(self, way: Enclosed, rate: Enclosed) -> Number:
        return self.limited(power_of_two(way * rate), self.exact(0.0), self.exact(1.0))  # type: ignore[arg-type]

    def duhem(self, d: Enclosed, b: Enclosed, c: Enclosed) -> Number:
        """The rounding of x may turn the input: d then starts from the other side of the turn, and both are rounded."""
        d = d.then("turned", d.value, [(d, 1)], largest_error(d).max() + 4.0 * HALF_BIT)
        return d * (b + c * self.size(d))

    def sided(self, h: Enclosed, duhem: Enclosed) -> Number:
        both = Interval(-duhem.value.size, duhem.value.size)
        return h.then("sided", h.value + both, [(h, 1), (duhem, every(-1.0, 1.0))])


Numbers = Real | Bounded
"""The numbers of a step of one block."""


def every(low: float, high: float) -> Interval:
    return Interval(np.full(1, low), np.full(1, high))


@functools.lru_cache(maxsize=256)
def _reach(step: complex, drive: complex) -> Floats:
    """(2,) bounds of the sums of |Re d (1 - s)^k| and of |Im d (1 - s)^k|."""
    pole = 1.0 - step
    if drive == step and (step.imag == 0.0 or abs(pole) >= 1.0):
        return np.array([1.0, 0.0]) if abs(pole) < 1.0 else np.full(2, np.inf)
    if abs(pole) >= 1.0:
        return np.full(2, np.inf)
    samples = min(int(-12.0 / np.log(abs(pole))) + 2, 1_000_000)
    impulse = drive * pole ** np.arange(samples)
    rest = 1.01 * abs(drive) * abs(pole) ** samples / (1.0 - abs(pole))
    return np.asarray((1.0 + LIBRARY * samples) * np.abs([impulse.real, impulse.imag]).sum(axis=1) + rest)


def heun(n: Numbers, w: Number, size: Number, loading: Number, unloading: Number) -> Number:
    """A state in the loop of a mode, w along the displacement, behind a step of Heun's method, before its box."""
    unit = n.exact(1.0)
    first = unit - n.bent(w, loading, unloading)
    second = unit - n.bent(w + size * first, loading, unloading)
    return w + (n.exact(0.5) * size) * (first + second)
