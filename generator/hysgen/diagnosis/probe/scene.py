"""What the probe looks at: the channels of a record, and which of its rows may be used."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.amplifier import amplified
from hysgen.diagnosis.probe.chain import Chain
from hysgen.diagnosis.probe.dynamics import crept_step, respond, respond_into
from hysgen.diagnosis.probe.operator import Operator
from hysgen.machine.cache import LruCache

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

NUISANCE_DECAYS = (1 / 30, 1 / 8)
"""Time constants, as shares of the record's length, by which creep of an unknown past may fade."""

CURVE_ALONE = 7
"""Degree of the curve where it has no plays beside it."""


def drift_course(t_s: Floats | float, since_s: float | None) -> Floats:
    """How far a drift has come at time t, up to its size: t, or log10(1 + t / since) if it slows down."""
    return np.asarray(t_s, dtype=np.float64) if since_s is None else np.log10(1.0 + np.asarray(t_s) / since_s)


@dataclass(frozen=True, eq=False)
class Run:
    """One unbroken run: u_V, y_um (n,), auxiliary channels, and where the plays stood before it (-1 to 1)."""

    u_V: Floats
    y_um: Floats
    aux: Mapping[str, Floats]
    start: float = 0.0


@dataclass(frozen=True, eq=False)
class Scene:
    """Runs at one sampling period; rows of the joined runs used to fit (`rows`), and how hysteresis is expanded.

    lost: samples at which the sensor was at its end; none of them is among the rows.
    thinned_from: the rows before they were thinned out, if they were (`dense`).
    known_ranges: lowest and highest value of auxiliary channels over all that will be simulated; a channel that it does
    not hold has the range of its runs.
    The columns of the last few settings of the amplifier, and of the last few sets of disturbances, are kept.
    """

    runs: tuple[Run, ...]
    Ts_s: float
    rows: Rows
    operator: Operator
    known_ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lost: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    thinned_from: Rows | None = None
    _hysteresis: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(3), repr=False)
    _disturbances: LruCache[Floats] = field(default_factory=lambda: LruCache(6), repr=False)

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

    def using(self, rows: Rows, thinned_from: Rows | None = None) -> Scene:
        """The same runs, other rows; what was kept stays. thinned_from: more rows, of which these are some."""
        return dataclasses.replace(self, rows=rows, thinned_from=thinned_from)

    @property
    def dense(self) -> Rows:
        """The rows before they were thinned out: neighbours in time but where a block ends or a sample is not used."""
        return self.rows if self.thinned_from is None else self.thinned_from

    def _path(self, run: Run, chain: Chain) -> Floats:
        """(size, n) columns of h, averaged over each sampling period.

        A limited amplifier spends the share |dv| / (rate Ts) of a period on its way; the mean is that much behind.
        """
        v_V = amplified(run.u_V, chain, self.Ts_s)
        columns = self._operator(chain).columns(v_V, run.start)
        if chain.rate_V_per_s is None:
            return columns
        under_way = np.minimum(np.abs(np.diff(v_V)) / (chain.rate_V_per_s * self.Ts_s), 1.0)
        columns[:, 1:] -= 0.5 * under_way * np.diff(columns, axis=1)
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
        """(p, n) everything that is linear: hysteresis seen through the chain, then `disturbances`."""
        size, below = self.hysteresis_size(chain), self.disturbances(chain)
        out = np.empty((size + len(below), self.samples))
        out[size:] = below
        first = 0
        for h in self.hysteresis(chain):
            respond_into(out[:size], first, h, chain, self.Ts_s)
            self._age(out[:size, first : first + h.shape[1]], chain)
            first += h.shape[1]
        return out

    def paths(self, chain: Chain, weights: Floats) -> list[Floats]:
        """h of every run, (n_i,), with these weights: before the linear part."""
        return [weights[: len(h)] @ h for h in self.hysteresis(chain)]

    def seen(self, paths: Sequence[Floats], chain: Chain, weights: Floats) -> Floats:
        """(n,) what the linear part of the chain and the disturbances make of `paths`."""
        size = self.hysteresis_size(chain)
        parts = [respond(path, chain, self.Ts_s) for path in paths]
        for part in parts:
            self._age(part, chain, weights[:size])
        return np.concatenate(parts) + weights[size:] @ self.disturbances(chain)

    def zero_um(self, chain: Chain, weights: Floats) -> float:
        """Where the stage stands at 0 V in the middle of its loops."""
        size = self.hysteresis_size(chain)
        return float(weights[:size] @ self._operator(chain).at(0.0) + weights[size])

    def _age(self, seen: Floats, chain: Chain, weights: Floats | None = None) -> None:
        """Gives `seen` a gain 1 + aging t about where the stage stands at 0 V; t from the start of the run."""
        if chain.aging_per_s is None:
            return
        rest = self._operator(chain).at(0.0)
        zero = rest[:, None] if weights is None else weights @ rest
        seen += chain.aging_per_s * self.Ts_s * np.arange(seen.shape[-1]) * (seen - zero)

    def drift_column(self, chain: Chain) -> int:
        """Place of the ramp among the disturbances."""
        return 1 + (len(NUISANCE_DECAYS) + 1 if chain.creep is not None else 0)

    def line_column(self, chain: Chain) -> int:
        """Place of the first line's sine among the disturbances."""
        return self.drift_column(chain) + int(chain.drift)

    def disturbances(self, chain: Chain) -> Floats:
        """Constant, fading past (with creep), ramp, lines, and coupled channels seen through the lag: (q, n).

        The past fades like creep of a step at the start too: where the hysteresis stood before the record is unknown.
        """
        slow = None if chain.creep is None else chain.creep_from_s
        lag = (chain.lag_s, chain.delay, chain.taps) if chain.coupled else None
        key = (slow, chain.drift, chain.since_s, chain.lines_Hz, chain.coupled, lag)
        return self._disturbances.get(key, lambda: np.hstack([self._beside(run, chain) for run in self.runs]))

    def _beside(self, run: Run, chain: Chain) -> Floats:
        """(q, n_i) `disturbances` of one run."""
        t_s: Floats = self.Ts_s * np.arange(len(run.u_V), dtype=np.float64)
        columns: list[Floats] = [np.ones(len(t_s))]
        if chain.creep is not None:
            columns.extend(np.exp(-t_s / (share * self.span_s)) for share in NUISANCE_DECAYS)
            columns.append(crept_step(len(t_s), self.Ts_s, chain.creep_from_s))
        if chain.drift:
            columns.append(drift_course(t_s, chain.since_s) / drift_course(self.span_s, chain.since_s))
        for line_Hz in chain.lines_Hz:
            columns.extend((np.sin(2 * np.pi * line_Hz * t_s), np.cos(2 * np.pi * line_Hz * t_s)))
        bare = Chain(chain.lag_s, chain.delay)
        for name in chain.coupled:
            seen = respond(run.aux[name], bare, self.Ts_s)
            columns.extend(
                np.concatenate([np.full(tap, seen[0]), seen[: len(seen) - tap]]) for tap in range(chain.taps)
            )
        return np.stack(columns)
