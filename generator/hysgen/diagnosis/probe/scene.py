"""Data of a fit of the probe: the channels of a record and its training rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.chain import COMMON, Chain, Driven, Moments, Trace, lagged, respond
from hysgen.fitting.operator import LONG_PATH, Operator
from hysgen.machine.cache import LruCache, Steps
from hysgen.model.part import Extent, Part

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

HYSTERESES, PARTS = 6, 64
"""Entries of the caches of a scene: a chain and its forward differences, also in an excerpt of many runs."""

HYSTERESES_BYTES = 50_000_000
"""Size up to which more hystereses are cached: on a short record a search asks half of them two or three times. Four
times as much saves 1 % of them in a search of 12 000 samples."""

WIDEST_LOOP = 0.2
"""Opening of a loop of soft ceramics, as a share of its range."""

CURVE_ALONE = 15
"""Degree of the curve of a chain without plays."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Runs at one sampling period, their training rows, and the expansion of the hysteresis.

    rows: training rows of the joined runs.
    lost: samples at which the sensor was at the end of its range; they are never training rows.
    thinned_from: the rows before thinning, None if the rows are not thinned (`dense`).
    known_ranges: lowest and highest value of auxiliary channels over all rows that will be simulated; for a channel
    without an entry, the range in the runs is used.
    kept: fits of an interrupted search (`solve.refine`); None: no fit is kept.
    The columns of at least the last HYSTERESES settings of the amplifier, and of the last PARTS parts of a run that add
    columns, are cached; those of the parts on the training rows alone, too.
    """

    runs: tuple[Trace, ...]
    Ts_s: float
    rows: Rows
    operator: Operator
    known_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lost: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    thinned_from: Rows | None = None
    kept: Steps | None = field(default=None, repr=False)
    _hysteresis: LruCache[list[Driven]] = field(
        default_factory=lambda: LruCache(HYSTERESES, HYSTERESES_BYTES), repr=False
    )
    _parts: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(PARTS), repr=False)
    _on_rows: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(PARTS), repr=False)

    @property
    def samples(self) -> int:
        return sum(len(run.u_V) for run in self.runs)

    @property
    def y_um(self) -> Floats:
        """(n,) measured displacement of all runs."""
        return np.concatenate([run.y_um for run in self.runs])

    def range_of(self, name: str) -> tuple[float, float]:
        """Lowest and highest value of an auxiliary channel."""
        if name in self.known_ranges:
            return self.known_ranges[name]
        seen = np.concatenate([run.aux[name] for run in self.runs])
        return float(seen.min()), float(seen.max())

    @property
    def span_s(self) -> float:
        """Length of the longest segment in s."""
        return max(run.whole for run in self.runs) * self.Ts_s

    @property
    def time_s(self) -> Floats:
        """(n,) time since the start of each segment."""
        return np.concatenate([run.time_s(self.Ts_s) for run in self.runs])

    @property
    def commands(self) -> list[tuple[Floats, float]]:
        """Command, (n_i,), and time between two samples in s, of each run: the arguments of `Chain.amplified`."""
        return [(run.u_V, self.Ts_s * run.stride) for run in self.runs]

    @property
    def extent(self) -> Extent:
        """The quantities on which bounds and steps of the chain's parameters depend."""
        return Extent(self.Ts_s, self.span_s, self.operator.low_V, self.operator.high_V)

    def using(self, rows: Rows, thinned_from: Rows | None = None) -> Scene:
        """The scene with other training rows and the same columns. thinned_from: the rows before thinning."""
        return dataclasses.replace(self, rows=rows, thinned_from=thinned_from, _on_rows=LruCache(PARTS))

    def bare(self) -> Scene:
        """The scene with empty caches."""
        empty: LruCache[list[Driven]] = LruCache(HYSTERESES, HYSTERESES_BYTES)
        return dataclasses.replace(self, _hysteresis=empty, _parts=LruCache(PARTS), _on_rows=LruCache(PARTS))

    @property
    def dense(self) -> Rows:
        """The rows before thinning: consecutive samples except at the ends of blocks and at unused samples."""
        return self.rows if self.thinned_from is None else self.thinned_from

    def _path(self, run: Trace, chain: Chain, evaluated: Callable[[Floats], Floats]) -> Floats:
        """(m, k + n) signals of h: k of the history, then those of the run, averaged over each sampling period.

        evaluated: the signals, (m, l), along a voltage, (l,).
        """
        past, v_V = len(run.history), chain.amplified(run.u_V, self.Ts_s * run.stride)
        if not past:
            return self._averaged(evaluated(v_V), v_V, run, chain)
        before_V = run.history.u_V
        for part in chain.amplifier:
            before_V = part.apply_held(before_V, run.history.held, self.Ts_s)
        signals = evaluated(np.concatenate([before_V, v_V]))
        if chain.amplifier:
            signals[:, past:] = self._averaged(signals[:, past:].copy(), v_V, run, chain)
        return signals

    def _averaged(self, columns: Floats, v_V: Floats, run: Trace, chain: Chain) -> Floats:
        for part in chain.amplifier if run.stride == 1 else ():
            columns = part.averaged(columns, v_V, self.Ts_s)
        return columns

    def hysteresis_size(self, chain: Chain) -> int:
        """Number of columns of h; they come first among the columns."""
        return self._operator(chain).size

    def _operator(self, chain: Chain) -> Operator:
        if chain.memory:
            return dataclasses.replace(self.operator, relaxation=chain.relaxation)
        return dataclasses.replace(self.operator, hats=0, reaches=(), curve=CURVE_ALONE if chain.curve else 1)

    def hysteresis(self, chain: Chain) -> list[Driven]:
        """Columns of h for each run, (operator.size, k_i + n_i) with its history, for the chain's amplifier."""
        operator = self._operator(chain)

        def columns(run: Trace) -> Driven:
            return Driven.of(run, self._path(run, chain, lambda v_V: operator.columns(v_V, run.start)))

        return self._hysteresis.get(
            (chain.memory, chain.curve, chain.amplifier), lambda: [columns(run) for run in self.runs]
        )

    def columns(self, chain: Chain) -> Floats:
        """(p, n) columns of the linear parameters: chain's response to the columns of h, then `added_columns`."""
        size = self.hysteresis_size(chain)
        out = np.empty((size + self._added_size(chain), self.samples))
        out[size:] = self.added_columns(chain)
        first = 0
        for i, (run, h) in enumerate(zip(self.runs, self.hysteresis(chain), strict=True)):
            out[:size, first : first + len(run.u_V)] = respond(run, h, chain, self.Ts_s)
            self._fade(out[:size, first : first + len(run.u_V)], i, chain, h.before[:, 0])
            self._age(out[:size, first : first + len(run.u_V)], run.time_s(self.Ts_s), chain)
            first += len(run.u_V)
        return out

    def training_columns(self, chain: Chain) -> Floats:
        """(p, r) the training rows of `columns`, computed without the other rows.

        In Fortran order, as an array indexed by rows is: sums over the rows depend on the order in their last bits.
        """
        every = slice(0, self.hysteresis_size(chain))
        return self._training_columns(chain, ([(every, h)] for h in self.hysteresis(chain)))

    def training_columns_once(self, chain: Chain) -> Floats:
        """`training_columns`; columns of h are formed a few at a time and not kept."""
        groups = list(self._operator(chain).groups())

        def few(run: Trace) -> Iterator[tuple[slice, Driven]]:
            for at, formed in groups:
                yield at, Driven.of(run, self._path(run, chain, partial(formed, start=run.start)))

        return self._training_columns(chain, map(few, self.runs))

    def _training_columns(self, chain: Chain, h_of_runs: Iterable[Iterable[tuple[slice, Driven]]]) -> Floats:
        """`training_columns` from some columns of h after the other, of each run, and their places."""
        size = self.hysteresis_size(chain)
        out, start = np.empty((len(self.rows), size + self._added_size(chain))).T, np.empty(size)
        for i, (run, parts) in enumerate(zip(self.runs, h_of_runs, strict=True)):
            here, inside = self._rows_of(i)
            for at, h in parts:
                out[at, here] = respond(run, h, chain, self.Ts_s, inside)
                start[at] = h.before[:, 0]
            self._fade(out[:size, here], i, chain, start, inside)
            self._age(out[:size, here], run.time_s(self.Ts_s, inside), chain)
            out[size, here] = 1.0
            for row, column in zip(out[size + 1 :, here], self._added_on_rows(i, inside, chain), strict=True):
                row[:] = column
        return out

    @property
    def complete(self) -> bool:
        """Whether every run is a whole segment with all of its samples."""
        return all(run.stride == 1 and not len(run.history) and run.segment in (0, len(run.u_V)) for run in self.runs)

    def _rows_of(self, i: int) -> tuple[slice, Rows]:
        """Places of the training rows of run i among all of them, and their samples in the run."""
        first = sum(len(run.u_V) for run in self.runs[:i])
        low, high = np.searchsorted(self.rows, (first, first + len(self.runs[i].u_V)))
        return slice(low, high), self.rows[low:high] - first

    def _fade(
        self,
        seen: Floats,
        i: int,
        chain: Chain,
        start: Floats,
        samples: Rows | None = None,
        weights: Floats | None = None,
    ) -> None:
        """Adds what the slow states hold of the level before the segment of run i to `seen`, (m, n), in place.

        amount (h(past) - h(0)) sum_i exp(-(since + t) / tau_i)       start: h(0), (m,)
        """
        run = self.runs[i]
        slow = None if chain.past is None else chain.slow_states(run.whole * self.Ts_s)
        if chain.past is None or slow is None:
            return
        past_V, since_s = chain.past
        level = self._operator(chain).at(past_V)
        moved = (level if weights is None else weights @ level) - start

        def course() -> list[Floats]:
            t_s = since_s + run.time_s(self.Ts_s, samples)
            return [np.sum([np.exp(rate * t_s) for rate in np.log1p(-slow.rates(self.Ts_s)) / self.Ts_s], axis=0)]

        cache = self._parts if samples is None else self._on_rows
        (fading,) = cache.get((i, "past", slow, since_s), course)
        seen += np.multiply.outer(moved, slow.amount * fading)

    def first_level_V(self, chain: Chain, weights: Floats) -> float | None:
        """Voltage at which the stage stood at the first reading, None if that may be where the record starts.

        A record may start while the voltage jumps, as where a controller is switched on: y(0) tells the level before.
        weights: of the linear parameters of a fit. Of both branches of a loop the level has the mean: it counts from a
        distance on that is as wide as the loops of ceramics.
        """
        operator, run = self._operator(chain), self.runs[0]
        h_um, constant_um = weights[: operator.size], float(weights[operator.size])
        levels_V = np.linspace(operator.low_V, operator.high_V, 101)
        levels_um = np.array([h_um @ operator.at(float(v_V)) for v_V in levels_V]) + constant_um
        level_V = float(levels_V[np.argmin(np.abs(levels_um - run.y_um[0]))])
        moved = abs(level_V - run.u_V[0]) > WIDEST_LOOP * (operator.high_V - operator.low_V)
        return level_V if moved and not len(run.history) else None

    def responses(self, paths: Sequence[Floats], chain: Chain) -> list[Floats]:
        """Response of the linear part of the chain, from rest, to `paths` (`Scene.paths`), (n_i,) for each run."""
        return [
            respond(run, Driven.of(run, path[None]), chain, self.Ts_s)[0]
            for run, path in zip(self.runs, paths, strict=True)
        ]

    def paths(self, chain: Chain, weights: Floats) -> list[Floats]:
        """h of every run, (k_i + n_i,) with its history, for the weights of a fit: the input of the linear part."""
        return [weights[: len(h.signals)] @ h.signals for h in self.hysteresis(chain)]

    def moved_paths(self, chain: Chain, weights: Floats) -> list[Floats]:
        """`paths` of a chain whose columns of h nobody else needs: they are not formed."""
        operator = self._operator(chain)

        def path(run: Trace) -> Floats:
            own = weights[: operator.size]
            return np.asarray(self._path(run, chain, lambda v_V: operator.path(v_V, own, run.start)[None])[0])

        return [path(run) for run in self.runs]

    def seen(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        """(n,) the prediction: response of the linear part of the chain to `paths`, and the added columns."""
        size = self.hysteresis_size(chain)
        parts = self.responses(paths, chain)
        for i, (run, path, part) in enumerate(zip(self.runs, paths, parts, strict=True)):
            self._fade(part[None], i, chain, path[:1], weights=weights[:size])
            self._age(part, run.time_s(self.Ts_s), chain, weights[:size])
        return np.concatenate(parts) + self._added_um(chain, weights[size:])

    def seen_on_rows(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        """(r,) the training rows of `seen`, computed without the other rows."""
        size = self.hysteresis_size(chain)
        out = np.full(len(self.rows), weights[size])
        for i, (run, path) in enumerate(zip(self.runs, paths, strict=True)):
            here, inside = self._rows_of(i)
            part = respond(run, Driven.of(run, path[None]), chain, self.Ts_s, inside)[0]
            self._fade(part[None], i, chain, path[:1], inside, weights[:size])
            self._age(part, run.time_s(self.Ts_s, inside), chain, weights[:size])
            out[here] += part
            for weight, column in zip(weights[size + 1 :], self._added_on_rows(i, inside, chain), strict=True):
                out[here] += weight * column
        return out

    def zero_um(self, chain: Chain, weights: Floats) -> float:
        """Displacement at 0 V in um, mean of both branches of the major loop."""
        size = self.hysteresis_size(chain)
        return float(weights[:size] @ self._operator(chain).at(0.0) + weights[size])

    def _age(self, seen: Floats, t_s: Floats, chain: Chain, weights: Floats | None = None) -> None:
        """Applies the change of the gain about the displacement at 0 V to `seen`, (m, n), in place; t_s: (n,)."""
        change = chain.gain_change(t_s)
        if not np.any(change):
            return
        rest = self._operator(chain).at(0.0)
        zero = rest[:, None] if weights is None else weights @ rest
        seen += change * (seen - zero)

    def curve_columns(self, chain: Chain) -> slice:
        """Places of the columns of the sensor's curve among all columns."""
        first = self.hysteresis_size(chain) + 1
        return slice(first, first + COMMON - 1)

    def column_of(self, chain: Chain, kind: type[Part]) -> int:
        """Place of a part's first added column among all columns, and of its weight among the weights of a fit."""
        return self.hysteresis_size(chain) + chain.first_column(kind)

    def _added_size(self, chain: Chain) -> int:
        """Number of added columns."""
        return COMMON + sum(part.added for part in chain.parts)

    def added_columns(self, chain: Chain) -> Floats:
        """(q, n) a constant, the columns of the sensor's curve, then those that the parts of the chain add in order."""
        out = np.empty((self._added_size(chain), self.samples))
        out[0], first = 1.0, 0
        for i, run in enumerate(self.runs):
            for row, column in zip(out[1:], self._added_to(i, chain), strict=True):
                row[first : first + len(run.u_V)] = column
            first += len(run.u_V)
        return out

    def _added_um(self, chain: Chain, weights: Floats) -> Floats:
        """(n,) weights @ `added_columns`, for weights, (q,); of a long path column by column."""
        if self.samples <= LONG_PATH:
            return np.asarray(weights @ self.added_columns(chain))
        parts = []
        for i, run in enumerate(self.runs):
            parts.append(np.full(len(run.u_V), weights[0]))
            for weight, column in zip(weights[1:], self._added_to(i, chain), strict=True):
                parts[-1] += weight * column
        return np.concatenate(parts)

    def _added_to(self, i: int, chain: Chain) -> list[Floats]:
        """The added columns of run i behind the constant, (n_i,) each; do not modify them."""
        run, curve = self.runs[i], (i, chain.amplifier, chain.lag_s, chain.delay)
        columns = self._parts.get(curve, lambda: self._curve_columns(run, chain, None))
        return [
            *columns,
            *(column for part in chain.parts if part.added for column in self._columns_of(part, i, chain)),
        ]

    def _columns_of(self, part: Part, i: int, chain: Chain) -> list[Floats]:
        """The columns that a part adds to run i, (n_i,) each."""
        run = self.runs[i]
        return self._parts.get(
            (i, part.cause, part.columns_depend_on(chain.lag_s, chain.delay)),
            lambda: part.columns(run, self.extent, lambda signal: lagged(run, signal[None], chain, self.Ts_s)[0]),
        )

    def _added_on_rows(self, i: int, inside: Rows, chain: Chain) -> list[Floats]:
        """`_added_to` at the training rows of run i, (r_i,) each; inside: their samples in the run."""
        run, curve = self.runs[i], (i, chain.amplifier, chain.lag_s, chain.delay)

        def on_rows(part: Part) -> list[Floats]:
            if part.timed:
                return part.columns(Moments(run, inside), self.extent, lambda signal: signal)
            return [column[inside] for column in self._columns_of(part, i, chain)]

        found = list(self._on_rows.get(curve, lambda: self._curve_columns(run, chain, inside)))
        for part in chain.parts:
            if part.added:
                key = (i, part.cause, part.columns_depend_on(chain.lag_s, chain.delay))
                found += self._on_rows.get(key, lambda part=part: on_rows(part))  # type: ignore[misc]
        return found

    def _curve_columns(self, run: Trace, chain: Chain, rows: Rows | None) -> list[Floats]:
        """COMMON - 1 columns, (n,) each, of a sensor with a curve: what it shows of a lag behind the ceramic's curve.

            L(v)^2 - L(v^2),   L(v) L(v^2) - L(v^3)

        v: the voltage, -1 .. 1 over the range; L: lag and delay. A quadratic curve of the sensor makes L(f)^2 of a
        displacement L(f), where f = v + a v^2 of the ceramic; at rest, the curve of the operator holds both.
        rows: samples of the result; None for all.
        """
        v = (chain.amplified(run.u_V, self.Ts_s * run.stride) - self.extent.middle_V) / self.extent.half_V
        first, second, third = lagged(run, np.stack([v, v * v, v * v * v]), chain, self.Ts_s, rows)
        return [first * first - second, first * second - third]
