"""The part of a record that may be looked at, and the part that only scores.

Identification: everything before the cut. Held out: everything from it on; no choice is ever made on it.
A segment that the cut goes through is simulated from its own beginning, because everything that drives a model over it
(input, channels, clock) is known; only its displacement behind the cut is hidden.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe import Operator, Scene, Trace
from hysgen.diagnosis.spikes import EDGE
from hysgen.errors import RecordError
from hysgen.machine.cache import LruCache
from hysgen.machine.kernels import lag_states, play_operators
from hysgen.record import Record, Segment
from hysgen.record.channels import Channels
from hysgen.record.plausibility import at_end

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

IDENTIFY = 0.65
"""Share of a single record that is used for identification."""

FEWEST = 400
"""Samples that the identification part must have."""

SETTLED_RANGE = 0.98
"""The first excursion has settled the memory once the input has run through this share of its range."""

FADED, FORGOTTEN, MOST_FADING = 3.0, 8.0, 0.03
"""Time constants of the lag after which it has let go of the unknown past: as far as a model can tell, which needs what
the first stroke shows of the far end of its range; and, for the probe, to 1/3000 of a stroke, the noise of a good
sensor. And the share of a segment that is given up for that at most."""

FADING_TRUST = 0.3
"""What a row counts in the fit of a model while the unknown past still fades: it may be the only one so far out."""

LAGS = 0.3 * 1.5 ** np.arange(18.0)
"""Time constants in samples among which the range that a command reaches is looked for."""

HALF_WIDTHS = np.array([0.15, 0.4, 0.8])
"""Plays beside the cubic, in half ranges: small loops, middle ones, and those that only full strokes move."""

MOST_CHECKED = 100
"""Fits whose errors are kept; a diagnosis makes some 50."""

LATEST_SETTLED, EARLIEST_SETTLED = 0.3, 0.03
"""If that takes longer than the first share of a segment, it counts as settled at the second, and the start guessed."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """All segments, in order, as one record; rows before `cut` identify.

    lost: (n,) rows at which the sensor is at its end; they are not among the others.
    swept: (n,) rows after the first excursion, whose plays know their past; what lags behind them may not.
    settled: (n,) rows on which a model's unknown past no longer counts; only they are scored.
    forgotten: (n,) rows on which the probe sees nothing of it either; it looks at no others.
    checked: errors on rows left out of a fit, by what was fitted: the same models are asked for more than once.
    """

    record: Record
    cut: int
    lost: NDArray[np.bool_]
    swept: NDArray[np.bool_]
    settled: NDArray[np.bool_]
    forgotten: NDArray[np.bool_]
    checked: LruCache[tuple[Rows, Floats]] = field(default_factory=lambda: LruCache(MOST_CHECKED))

    @cached_property
    def training_rows(self) -> Rows:
        """Rows of the identification part that count in full."""
        return np.flatnonzero(self.trust == 1.0)

    @cached_property
    def trust(self) -> Floats:
        """(n,) how much a row counts in the fit of a model: 1, less while the past fades, 0 before and held out.

        The last of a run do not count, for whether they are corrupted, nobody can tell.
        """
        counts = np.where(self.settled, 1.0, np.where(self.swept, FADING_TRUST, 0.0))
        counts[self.cut :] = 0.0
        runs = np.cumsum([segment.samples for segment in self.identification().segments])
        for back in range(1, EDGE + 1):
            counts[runs - back] = 0.0
        return counts

    @property
    def held_rows(self) -> Rows:
        """Rows of the held-out part that count."""
        return self.cut + np.flatnonzero(self.settled[self.cut :])

    @property
    def y_um(self) -> Floats:
        """(n,) displacement of all segments."""
        return np.concatenate([segment.y_um for segment in self.record.segments])

    @property
    def u_V(self) -> Floats:
        """(n,) command of all segments."""
        return np.concatenate([segment.u_V for segment in self.record.segments])

    def identification(self) -> Record:
        """The part of the record before the cut."""
        return self.record if self.cut == self.record.samples else self.record.rows(0, self.cut)

    @cached_property
    def predicted_range_um(self) -> tuple[float, float]:
        """The range of displacement that the whole command visits, foreseen from the identification part."""
        return predicted_range_um(self.record, self.training_rows)

    def scene(self) -> Scene:
        """What the probe may see: the identification part."""
        part = self.identification()
        runs = tuple(Trace(s.u_V, s.y_um, dict(s.aux)) for s in part.segments)
        # Ranges are those of the whole command and channels, known beforehand; the probe must not extrapolate.
        low_V, high_V = self.record.u_range_V
        rows = self.training_rows[self.forgotten[self.training_rows]]
        lost = np.flatnonzero(self.lost[: self.cut])
        return Scene(runs, self.record.Ts_s, rows, Operator(low_V, high_V), self.record.aux_ranges, lost)


def predicted_range_um(record: Record, rows: Rows) -> tuple[float, float]:
    """The range of displacement that the whole command of a record visits, as far as its rows `rows` tell.

    That of the quasi-static fit, and beyond its ends twice the rms it leaves. A model whose grid ends where the
    identification part ends could not follow a plateau that it only ever touched in passing.
    """
    fit = _quasi_static(record, rows)
    return float(fit.y_um.min()) - 2.0 * fit.left_um, float(fit.y_um.max()) + 2.0 * fit.left_um


@dataclass(frozen=True, eq=False)
class QuasiStatic:
    """Time constant in samples, displacement over the whole record, (n,), and the rms that it leaves on some rows."""

    lag: float
    y_um: Floats
    left_um: float


def _quasi_static(record: Record, rows: Rows) -> QuasiStatic:
    """A cubic and a few plays of the command behind a lag, as far as the rows `rows` tell.

        y(k) = g(x(k)) + sum_i c_i play_i(x(k)),   x(k+1) = x(k) + (1 - exp(-Ts/tau)) (u(k) - x(k)),   g a cubic

    g, c and tau by least squares on these rows, x and the plays from the whole command, which is known beforehand.
    """
    y_um = np.concatenate([segment.y_um for segment in record.segments])[rows]

    def at(lag: float) -> QuasiStatic:
        columns = _behind(record, lag)
        weights, *_ = np.linalg.lstsq(columns[:, rows].T, y_um)
        left_um = float(np.sqrt(np.mean((y_um - weights @ columns[:, rows]) ** 2)))
        return QuasiStatic(lag, weights @ columns, left_um)

    return min(map(at, LAGS.tolist()), key=lambda fit: fit.left_um)


def _behind(record: Record, lag: float) -> Floats:
    """(4 + p, n) powers and plays of the command behind a lag of so many samples, from -1 to 1."""
    rate = np.array([-np.expm1(-1.0 / lag)])
    behind = [lag_states(s.u_V, rate, s.u_V[:1].copy())[:, 0] for s in record.segments]
    low, high = min(x.min() for x in behind), max(x.max() for x in behind)
    behind = [(2.0 * x - (low + high)) / max(high - low, 1e-300) for x in behind]
    x = np.concatenate(behind)
    plays = np.concatenate([play_operators(x, HALF_WIDTHS, np.full(HALF_WIDTHS.size, x[0])) for x in behind])
    return np.vstack([x**0, x, x**2, x**3, plays.T])


def prepare(record: Record, holdout: Record | None = None, identify: float = IDENTIFY) -> Prepared:
    """Cut a record, or join it with a held-out one.

    Raises RecordError if the identification part is too short, or too little of it is settled, or the two records'
    periods differ.
    """
    joined = record if holdout is None else Record.joined(record, holdout)
    cut = record.samples if holdout is not None else round(identify * record.samples)
    if cut < FEWEST:
        raise RecordError(f"{record.source}: {cut} samples to identify from, a diagnosis needs {FEWEST}; record longer")
    firsts = [_swept(segment) for segment in joined.segments]
    swept = _from(joined, firsts)
    seen = np.flatnonzero(swept[:cut])
    if seen.size < FEWEST // 2:
        raise RecordError(
            f"{record.source}: {seen.size} of the {cut} samples to identify from come after the input has run through "
            f"its range, a diagnosis needs {FEWEST // 2}; identify from more"
        )
    lag = _quasi_static(joined, seen).lag
    most = [int(MOST_FADING * one.samples) for one in joined.segments]
    settled, forgotten = (
        _from(joined, np.add(firsts, np.minimum(math.ceil(lags * lag), most))) for lags in (FADED, FORGOTTEN)
    )
    # Accepted all the same: what a sensor says at its end is nothing that a stage has done.
    lost = np.concatenate(at_end([Channels.of_arrays(one.name, one.u_V, one.y_um, {}) for one in joined.segments]))
    return Prepared(joined, cut, lost, swept & ~lost, settled & ~lost, forgotten & ~lost)


def _from(record: Record, firsts: Iterable[int]) -> NDArray[np.bool_]:
    """(n,) True from the given sample of each segment on."""
    return np.concatenate([np.arange(one.samples) >= first for first, one in zip(firsts, record.segments, strict=True)])


def _swept(segment: Segment) -> int:
    """The sample at which the input has first run through most of its range; a guess if that takes long."""
    n = segment.samples
    swept = np.maximum.accumulate(segment.u_V) - np.minimum.accumulate(segment.u_V)
    first = int(np.argmax(swept >= SETTLED_RANGE * swept[-1]))
    return max(first, int(EARLIEST_SETTLED * n / 3)) if first <= LATEST_SETTLED * n else int(EARLIEST_SETTLED * n)
