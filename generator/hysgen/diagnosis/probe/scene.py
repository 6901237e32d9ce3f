"""Data of a fit of the probe: the channels of a record and its training rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.chain import COMMON, Chain, Thinned
from hysgen.diagnosis.probe.dynamics import lagged, respond_into, respond_on_rows
from hysgen.diagnosis.probe.part import Extent, Part
from hysgen.fitting.operator import Operator
from hysgen.machine.cache import LruCache
from hysgen.machine.checkpoint import Steps
from hysgen.machine.kernels import lag_sums

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]
Samples = NDArray[np.int64]

HYSTERESES, ADDED, PARTS = 6, 16, 32
"""Entries of the caches of a scene: four threads that refine one chain each, with the chain and a changed parameter."""

HYSTERESES_BYTES = 200_000_000
"""Size up to which more hystereses are cached: on a short record a search asks half of them two or three times."""

CURVE_ALONE = 15
"""Degree of the curve of a chain without plays."""


@dataclass(frozen=True, eq=False)
class History:
    """The command of a segment before a run at selected samples: u_V, (k,); held: samples from each to the next.

    ages: (m + 1,) ends of intervals of ages in samples, counted back from the run. stand_for: (m,) the selected sample
    that stands for each interval. The selected samples contain every extreme that a hysteresis remembers, so the plays
    are exact.
    """

    u_V: Floats
    held: Samples
    ages: Samples
    stand_for: Rows

    def __len__(self) -> int:
        return len(self.u_V)

    @property
    def samples(self) -> int:
        """Samples of the segment before the run."""
        return int(self.held.sum())

    def slow_states(self, h: Floats, keep: Floats) -> Floats:
        """(m, s) states s(k+1) = keep s(k) + (1 - keep) h(k) at the start of the run, for h, (m, k).

        Before the segment h is constant.
        """
        left = np.exp(self.ages[:, None] * np.log(keep))
        return np.asarray(h[:, self.stand_for] @ (left[:-1] - left[1:]) + h[:, :1] * left[-1])


_NONE: Samples = np.zeros(0, dtype=np.int64)
NO_HISTORY = History(np.zeros(0), _NONE, _NONE, np.zeros(0, dtype=np.intp))


@dataclass(frozen=True, eq=False)
class Trace:
    """One unbroken run: u_V, y_um (n,), auxiliary channels, initial state of the plays (`Operator.columns`).

    history: the command of the same segment before the run. segment: samples of this segment; 0 for those of the run.
    stride: periods from each sample to the next; above 1, the signals are straight lines between fitted samples.
    share: (n,) share of the move from each sample to the next in the mean of the command between them; 1/2 for a line.
    """

    u_V: Floats
    y_um: Floats
    aux: Mapping[str, Floats]
    start: float = 0.0
    history: History = NO_HISTORY
    segment: int = 0
    stride: int = 1
    share: Floats = field(default_factory=lambda: np.full(1, 0.5))

    @property
    def whole(self) -> int:
        """Samples of the segment."""
        return self.segment or len(self.u_V)

    def time_s(self, Ts_s: float) -> Floats:
        """(n,) time since the start of the segment."""
        return np.asarray(Ts_s * (self.history.samples + self.stride * np.arange(len(self.u_V), dtype=np.float64)))

    def held(self, h: Floats, chain: Chain, Ts_s: float) -> tuple[Floats, Chain]:
        """Input, (m, n), of the part of the chain behind the hysteresis for h, (m, n), and this part (`Thinned`)."""
        if self.stride == 1:
            return h, chain
        thinned = chain.seen_every(self.stride, Ts_s)
        return thinned.input(h), thinned


@dataclass(frozen=True, eq=False)
class Scene:
    """Runs at one sampling period, their training rows, and the expansion of the hysteresis.

    rows: training rows of the joined runs.
    lost: samples at which the sensor was at the end of its range; they are never training rows.
    thinned_from: the rows before thinning, None if the rows are not thinned (`dense`).
    known_ranges: lowest and highest value of auxiliary channels over all rows that will be simulated; for a channel
    without an entry, the range in the runs is used.
    kept: fits of an interrupted search (`solve.refine`); None: no fit is kept.
    The columns of at least the last HYSTERESES settings of the amplifier, of the last ADDED sets of added columns and
    of the last PARTS parts of a run that add columns are cached.
    """

    runs: tuple[Trace, ...]
    Ts_s: float
    rows: Rows
    operator: Operator
    known_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lost: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    thinned_from: Rows | None = None
    kept: Steps | None = field(default=None, repr=False)
    _hysteresis: LruCache[list[Floats]] = field(
        default_factory=lambda: LruCache(HYSTERESES, HYSTERESES_BYTES), repr=False
    )
    _added: LruCache[Floats] = field(default_factory=lambda: LruCache(ADDED), repr=False)
    _parts: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(PARTS), repr=False)

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
        """The scene with other training rows and the same cache. thinned_from: the rows before thinning."""
        return dataclasses.replace(self, rows=rows, thinned_from=thinned_from)

    def bare(self) -> Scene:
        """The scene with empty caches."""
        empty: LruCache[list[Floats]] = LruCache(HYSTERESES, HYSTERESES_BYTES)
        return dataclasses.replace(self, _hysteresis=empty, _added=LruCache(ADDED), _parts=LruCache(PARTS))

    @property
    def dense(self) -> Rows:
        """The rows before thinning: consecutive samples except at the ends of blocks and at unused samples."""
        return self.rows if self.thinned_from is None else self.thinned_from

    def _path(self, run: Trace, chain: Chain) -> Floats:
        """(size, k + n) columns of h: k of the history, then those of the run, averaged over each sampling period."""
        past, v_V = len(run.history), chain.amplified(run.u_V, self.Ts_s * run.stride)
        if not past:
            columns = self._operator(chain).columns(v_V, run.start)
            return self._averaged(columns, v_V, run, chain)
        before_V = run.history.u_V
        for part in chain.amplifier:
            before_V = part.amplify_held(before_V, run.history.held, self.Ts_s)
        columns = self._operator(chain).columns(np.concatenate([before_V, v_V]), run.start)
        if chain.amplifier:
            columns[:, past:] = self._averaged(columns[:, past:].copy(), v_V, run, chain)
        return columns

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
        return dataclasses.replace(self.operator, hats=0, reaches=(), curve=CURVE_ALONE)

    def hysteresis(self, chain: Chain) -> list[Floats]:
        """Columns of h for each run, (operator.size, k_i + n_i) with its history, for the chain's amplifier."""
        return self._hysteresis.get(
            (chain.memory, chain.amplifier), lambda: [self._path(run, chain) for run in self.runs]
        )

    def columns(self, chain: Chain) -> Floats:
        """(p, n) columns of the linear parameters: chain's response to the columns of h, then `added_columns`."""
        size, below = self.hysteresis_size(chain), self.added_columns(chain)
        out = np.empty((size + len(below), self.samples))
        out[size:] = below
        first = 0
        for run, h in zip(self.runs, self.hysteresis(chain), strict=True):
            self._respond_into(out[:size], first, run, h, chain)
            self._age(out[:size, first : first + len(run.u_V)], run.time_s(self.Ts_s), chain)
            first += len(run.u_V)
        return out

    def training_columns(self, chain: Chain) -> Floats:
        """(p, r) the training rows of `columns`, computed without the other rows where no run has a history.

        In Fortran order, as an array indexed by rows is: sums over the rows depend on the order in their last bits.
        """
        if any(run.stride != 1 or len(run.history) or run.segment not in (0, len(run.u_V)) for run in self.runs):
            return self.columns(chain)[:, self.rows]
        size, below = self.hysteresis_size(chain), self.added_columns(chain)
        out = np.empty((len(self.rows), size + len(below))).T
        out[size:] = below[:, self.rows]
        first = 0
        for run, h in zip(self.runs, self.hysteresis(chain), strict=True):
            low, high = np.searchsorted(self.rows, (first, first + len(run.u_V)))
            inside = self.rows[low:high] - first
            out[:size, low:high] = respond_on_rows(h, chain, self.Ts_s, inside)
            self._age(out[:size, low:high], run.time_s(self.Ts_s)[inside], chain)
            first += len(run.u_V)
        return out

    def _respond_into(self, out: Floats, first: int, run: Trace, h: Floats, chain: Chain) -> None:
        """Response of the linear part to h, (m, k + n), on the samples of the run: out[:, first : first + n].

        The response of the slow states to their history is added behind the lag, which is much faster.
        """
        past, n = len(run.history), len(run.u_V)
        slow = chain.slow_states(run.whole, self.Ts_s)
        held, linear = run.held(h[:, past:], chain, self.Ts_s)
        held = np.ascontiguousarray(held)
        respond_into(out, first, held, linear, self.Ts_s * run.stride, run.whole)
        if slow.share == 0.0 or (run.stride == 1 and not past):
            return
        states = run.history.slow_states(h[:, :past], slow.keep) if past else np.tile(h[:, :1], len(slow.keep))
        if isinstance(linear, Thinned):
            rates = 1.0 - slow.keep**run.stride
            means = h[:, past:] + run.share * np.diff(h[:, past:], axis=1, append=h[:, -1:])
            crept = [lag_sums(mean, rates, start) for mean, start in zip(means, states, strict=True)]
            moved = linear.later(np.stack(crept))
        else:
            # `respond_into` starts from rest at h of the first sample and counts the slow states from there.
            rest = held[:, :1]
            moved = (states - rest) @ np.exp(np.log(slow.keep)[:, None] * np.arange(n)) + len(slow.keep) * rest
        out[:, first : first + n] += 0.5 * slow.share * (moved - len(slow.keep) * h[:, :1])

    def responses(self, paths: Sequence[Floats], chain: Chain) -> list[Floats]:
        """Response of the linear part of the chain to `paths` (`Scene.paths`), (n_i,) for each run."""
        found = []
        for run, path in zip(self.runs, paths, strict=True):
            out = np.empty((1, len(run.u_V)))
            self._respond_into(out, 0, run, path[None], chain)
            found.append(out[0])
        return found

    def paths(self, chain: Chain, weights: Floats) -> list[Floats]:
        """h of every run, (k_i + n_i,) with its history, for the weights of a fit: the input of the linear part."""
        return [weights[: len(h)] @ h for h in self.hysteresis(chain)]

    def seen(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        """(n,) the prediction: response of the linear part of the chain to `paths`, and the added columns."""
        size = self.hysteresis_size(chain)
        parts = self.responses(paths, chain)
        for run, part in zip(self.runs, parts, strict=True):
            self._age(part, run.time_s(self.Ts_s), chain, weights[:size])
        return np.concatenate(parts) + weights[size:] @ self.added_columns(chain)

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

    def added_columns(self, chain: Chain) -> Floats:
        """(q, n) a constant, the columns of the sensor's curve, then those that the parts of the chain add in order."""
        adding = [part for part in chain.parts if part.added]
        depends = tuple(part.columns_depend_on(chain.lag_s, chain.delay) for part in adding)
        key: Hashable = (chain.lag_s, chain.delay, chain.amplifier, depends)
        return self._added.get(key, lambda: np.hstack([self._added_to(i, chain) for i in range(len(self.runs))]))

    def _lagged(self, signal: Floats, run: Trace, chain: Chain) -> Floats:
        """(n,) a channel behind the lag and the delay of the chain."""
        held, linear = run.held(signal[None], chain, self.Ts_s)
        return lagged(held[0], linear.lag_s, linear.delay, self.Ts_s * run.stride)

    def _bend(self, run: Trace, chain: Chain) -> list[Floats]:
        """COMMON - 1 columns, (n,) each, of a sensor with a curve: what it shows of a lag behind the ceramic's curve.

            L(v)^2 - L(v^2),   L(v) L(v^2) - L(v^3)

        v: the voltage, -1 .. 1 over the range; L: lag and delay. A quadratic curve of the sensor makes L(f)^2 of a
        displacement L(f), where f = v + a v^2 of the ceramic; at rest, the curve of the operator holds both.
        """
        v = (chain.amplified(run.u_V, self.Ts_s * run.stride) - self.extent.middle_V) / self.extent.half_V
        first, second, third = (self._lagged(power, run, chain) for power in (v, v * v, v**3))
        return [first * first - second, first * second - third]

    def _added_to(self, i: int, chain: Chain) -> Floats:
        """(q, n_i) `added_columns` of run i."""
        run = self.runs[i]

        def columns_of(part: Part) -> list[Floats]:
            key = (i, part.cause, part.columns_depend_on(chain.lag_s, chain.delay))
            return self._parts.get(
                key, lambda: part.columns(run, self.extent, lambda signal: self._lagged(signal, run, chain))
            )

        adding = [part for part in chain.parts if part.added]
        common = [np.ones(len(run.u_V)), *self._bend(run, chain)]
        return np.stack([*common, *(column for part in adding for column in columns_of(part))])
