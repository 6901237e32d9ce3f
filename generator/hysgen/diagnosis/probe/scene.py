"""Data of a fit of the probe: the channels of a record and its training rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.dynamics import lagged, respond, respond_into
from hysgen.diagnosis.probe.part import Extent, Part
from hysgen.fitting.operator import Operator
from hysgen.machine.cache import LruCache

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

CURVE_ALONE = 7
"""Degree of the curve of a chain without plays."""


@dataclass(frozen=True, eq=False)
class Trace:
    """One unbroken run: u_V, y_um (n,), auxiliary channels, initial state of the plays (`Operator.columns`)."""

    u_V: Floats
    y_um: Floats
    aux: Mapping[str, Floats]
    start: float = 0.0


@dataclass(frozen=True, eq=False)
class Scene:
    """Runs at one sampling period, their training rows, and the expansion of the hysteresis.

    rows: training rows of the joined runs.
    lost: samples at which the sensor was at the end of its range; they are never training rows.
    thinned_from: the rows before thinning, None if the rows are not thinned (`dense`).
    known_ranges: lowest and highest value of auxiliary channels over all rows that will be simulated; for a channel
    without an entry, the range in the runs is used.
    The columns of the last 3 settings of the amplifier and of the last 6 sets of added columns are cached.
    """

    runs: tuple[Trace, ...]
    Ts_s: float
    rows: Rows
    operator: Operator
    known_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lost: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    thinned_from: Rows | None = None
    _hysteresis: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(3), repr=False)
    _added: LruCache[Floats] = field(default_factory=lambda: LruCache(6), repr=False)

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
        """Length of the longest run in s."""
        return max(len(run.u_V) for run in self.runs) * self.Ts_s

    @property
    def extent(self) -> Extent:
        """The quantities on which bounds and steps of the chain's parameters depend."""
        return Extent(self.Ts_s, self.span_s, self.operator.low_V, self.operator.high_V)

    def using(self, rows: Rows, thinned_from: Rows | None = None) -> Scene:
        """The scene with other training rows and the same cache. thinned_from: the rows before thinning."""
        return dataclasses.replace(self, rows=rows, thinned_from=thinned_from)

    @property
    def dense(self) -> Rows:
        """The rows before thinning: consecutive samples except at the ends of blocks and at unused samples."""
        return self.rows if self.thinned_from is None else self.thinned_from

    def _path(self, run: Trace, chain: Chain) -> Floats:
        """(size, n) columns of h, averaged over each sampling period."""
        v_V = chain.amplified(run.u_V, self.Ts_s)
        columns = self._operator(chain).columns(v_V, run.start)
        for part in chain.amplifier:
            columns = part.averaged(columns, v_V, self.Ts_s)
        return columns

    def hysteresis_size(self, chain: Chain) -> int:
        """Number of columns of h; they come first among the columns."""
        return self._operator(chain).size

    def _operator(self, chain: Chain) -> Operator:
        if chain.memory:
            return self.operator
        return dataclasses.replace(self.operator, hats=0, reaches=(), curve=CURVE_ALONE)

    def hysteresis(self, chain: Chain) -> list[Floats]:
        """Columns of h for each run, (operator.size, n_i), for the chain's amplifier."""
        return self._hysteresis.get(
            (chain.memory, chain.amplifier), lambda: [self._path(run, chain) for run in self.runs]
        )

    def columns(self, chain: Chain) -> Floats:
        """(p, n) columns of the linear parameters: chain's response to the columns of h, then `added_columns`."""
        size, below = self.hysteresis_size(chain), self.added_columns(chain)
        out = np.empty((size + len(below), self.samples))
        out[size:] = below
        first = 0
        for h in self.hysteresis(chain):
            respond_into(out[:size], first, h, chain, self.Ts_s)
            self._age(out[:size, first : first + h.shape[1]], chain)
            first += h.shape[1]
        return out

    def paths(self, chain: Chain, weights: Floats) -> list[Floats]:
        """h of every run, (n_i,), for the weights of a fit: the input of the linear part."""
        return [weights[: len(h)] @ h for h in self.hysteresis(chain)]

    def seen(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        """(n,) the prediction: response of the linear part of the chain to `paths`, and the added columns."""
        size = self.hysteresis_size(chain)
        parts = [respond(path, chain, self.Ts_s) for path in paths]
        for part in parts:
            self._age(part, chain, weights[:size])
        return np.concatenate(parts) + weights[size:] @ self.added_columns(chain)

    def zero_um(self, chain: Chain, weights: Floats) -> float:
        """Displacement at 0 V in um, mean of both branches of the major loop."""
        size = self.hysteresis_size(chain)
        return float(weights[:size] @ self._operator(chain).at(0.0) + weights[size])

    def _age(self, seen: Floats, chain: Chain, weights: Floats | None = None) -> None:
        """Applies the gain 1 + gain_per_s t about the displacement at 0 V to `seen`, in place; t: time in the run."""
        if chain.gain_per_s == 0.0:
            return
        rest = self._operator(chain).at(0.0)
        zero = rest[:, None] if weights is None else weights @ rest
        seen += chain.gain_per_s * self.Ts_s * np.arange(seen.shape[-1]) * (seen - zero)

    def column_of(self, chain: Chain, kind: type[Part]) -> int:
        """Place of a part's first added column among all columns, and of its weight among the weights of a fit."""
        return self.hysteresis_size(chain) + chain.first_column(kind)

    def added_columns(self, chain: Chain) -> Floats:
        """(q, n) a constant, then the columns that the parts of the chain add in their order."""
        adding = [part for part in chain.parts if part.added]
        key: Hashable = tuple(part.columns_depend_on(chain.lag_s, chain.delay) for part in adding)
        return self._added.get(key, lambda: np.hstack([self._added_to(run, chain) for run in self.runs]))

    def _added_to(self, run: Trace, chain: Chain) -> Floats:
        """(q, n_i) `added_columns` of one run."""
        columns: list[Floats] = [np.ones(len(run.u_V))]
        for part in chain.parts:
            columns.extend(
                part.columns(run, self.extent, lambda signal: lagged(signal, chain.lag_s, chain.delay, self.Ts_s))
            )
        return np.stack(columns)
