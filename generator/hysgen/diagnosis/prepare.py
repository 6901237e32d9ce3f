"""The rows of a record: training rows and held-out rows, without burn-in.

The rows before `cut` are the identification part; the held-out rows from `cut` on only score. The input, the channels
and the clock of the whole record are known in advance, so a segment that contains the cut is simulated from its start;
only its displacement from the cut on is hidden.

Burn-in: the state of the stage before a segment is unknown. Hysteresis forgets it once the input has covered its range,
the lag forgets it exponentially after that.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.excerpt import excerpt
from hysgen.diagnosis.extension import Correction, corrected
from hysgen.diagnosis.probe import Operator, Scene, Trace
from hysgen.errors import RecordError
from hysgen.fitting.path import LATEST_COVERED, PathColumns
from hysgen.machine.cache import LruCache
from hysgen.machine.kernels.operators import lag_states, play_operators
from hysgen.model.residual import EDGE
from hysgen.record import Record, Segment
from hysgen.record.checks import at_end
from hysgen.record.series import COVERED, first_covering

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

IDENTIFY = 0.65
"""Share of a single record that is used for identification."""

FEWEST = 400
"""Samples that the identification part must have."""

ASSUMED_COVERED = 0.03
"""If the input covers its range only after LATEST_COVERED of a segment, this share is taken as burn-in."""

MODEL_LAGS, PROBE_LAGS, MOST_LAGS = 3.0, 8.0, 0.03
"""Burn-in of the lag in time constants: for a model, which has to learn the end of the range from the first stroke, and
for the probe (exp(-8) = 1/3000 of a stroke, the noise of a good sensor). Both are at most this share of a segment."""

REMEMBERED = 0.1
"""Share of a held-out segment from which its initial state is estimated, and which is not scored: creep from before the
segment fades over decades of time, and a tenth of the segment shows all but the last."""

FADING_TRUST = 0.3
"""Weight of a fading row in the fit of a model: no other row may lie as near to the end of the range."""

LAGS = 0.3 * 1.5 ** np.arange(18.0)
"""Candidate time constants of the quasi-static fit in samples."""

LAG_ROWS = 20_000
"""Rows on which the time constants are compared: their residuals differ by far more than a scatter of 1 %."""

HALF_WIDTHS = np.array([0.15, 0.4, 0.8])
"""Plays of the quasi-static fit in half ranges: for small, medium and full strokes."""

FORGETTING_WIDTHS = np.linspace(0.0, 1.0, 41)
"""Plays of `_past_forgotten` in half ranges."""

FORGOTTEN = 1e-3
"""Difference of two pasts that no longer counts, in half ranges."""

LATEST = 0.8
"""Largest share of a held-out segment that is not scored because of its unknown past."""

PATHS, PATHS_BYTES = 1, 60_000_000
"""Cached columns of paths, some 50 for every sample of the windows; more of them up to this size."""

MOST_CHECKED = 100
"""Cached cross-validation errors; a diagnosis needs about 50."""


class Use(IntEnum):
    """The use of a row, in rising order: a PROBE row is also a MODEL row."""

    LOST = 0
    """The sensor is at the end of its range: no use."""
    UNKNOWN_PAST = 1
    """The hysteresis still depends on the unknown initial state: no use."""
    FADING = 2
    """The lag still depends on the unknown initial state: fitted by a model with the weight FADING_TRUST."""
    MODEL = 3
    """Fitted by a model, or scored."""
    PROBE = 4
    """Fitted by the probe too."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """A record, or several joined, with the use of each row; the rows before `cut` are the identification part.

    use: (n,) one `Use` per row, all segments in order. lag: time constant in samples, of a quasi-static fit.
    checked: cache of cross-validation errors by terms and settings; paths: cache of the columns of paths by extensions.
    """

    record: Record
    cut: int
    use: NDArray[np.int8]
    lag: float
    checked: LruCache[tuple[Rows, Floats]] = field(default_factory=lambda: LruCache(MOST_CHECKED))
    paths: LruCache[PathColumns] = field(default_factory=lambda: LruCache(PATHS, PATHS_BYTES))

    @cached_property
    def training_rows(self) -> Rows:
        """Rows of the identification part that a model is fitted to with full weight."""
        return np.flatnonzero(self.trust == 1.0)

    @cached_property
    def trust(self) -> Floats:
        """(n,) weights in the fit of a model: 1, FADING_TRUST while the past fades, 0 for burn-in and held-out rows.

        The last EDGE rows of a segment have weight 0, because a corrupted sample is not recognised there.
        """
        weights = np.where(self.use >= Use.MODEL, 1.0, np.where(self.use >= Use.FADING, FADING_TRUST, 0.0))
        weights[self.cut :] = 0.0
        ends = np.cumsum([segment.samples for segment in self.identification().segments])
        for back in range(1, EDGE + 1):
            weights[ends - back] = 0.0
        return weights

    @property
    def held_rows(self) -> Rows:
        """Rows of the held-out part that are scored."""
        return self.cut + np.flatnonzero(self.use[self.cut :] >= Use.MODEL)

    @property
    def y_um(self) -> Floats:
        """(n,) displacement of all segments."""
        return self.record.y_um

    @property
    def u_V(self) -> Floats:
        """(n,) command of all segments."""
        return self.record.u_V

    def identification(self) -> Record:
        """The part of the record before the cut."""
        return self.record if self.cut == self.record.samples else self.record.rows(0, self.cut)

    @cached_property
    def predicted_range_um(self) -> tuple[float, float]:
        """Range of the displacement over the whole command, predicted from the training rows."""
        return _widened(*self._quasi_static)

    @cached_property
    def _quasi_static(self) -> tuple[Floats, float]:
        return _quasi_static(self.record, self.training_rows, self.lag)

    def without(self, corrections: Sequence[Correction]) -> Prepared:
        """The same without changes of the displacement, whose time counts from the start of the first segment."""
        if not corrections:
            return self
        first, *others = self.record.segments
        segments = [corrected(first, corrections, self.record.Ts_s), *others]
        record = Record.from_segments(segments, self.record.Ts_s, self.record.source)
        return Prepared(record, self.cut, self.use, self.lag)

    def excerpt(self) -> Scene:
        """The scene, or the blocks of its rows to which the search looks (`excerpt`)."""

        def left_um() -> Floats:
            return (self.y_um - self._quasi_static[0])[: self.cut]

        return excerpt(self.scene(), self.lag, left_um)

    def scene(self, whole: bool = False) -> Scene:
        """The identification part, as the probe is fitted to it. whole: with the held-out rows."""
        part = self.record if whole else self.identification()
        runs = tuple(Trace(s.u_V, s.y_um, dict(s.aux)) for s in part.segments)
        # Ranges over the whole record, because the probe must not extrapolate to inputs that are known in advance.
        low_V, high_V = self.record.u_range_V
        rows = np.concatenate([self.training_rows, self.held_rows]) if whole else self.training_rows
        rows = rows[self.use[rows] == Use.PROBE]
        lost = np.flatnonzero(self.use[: part.samples] == Use.LOST)
        return Scene(runs, self.record.Ts_s, rows, Operator(low_V, high_V), self.record.aux_ranges, lost)


def predicted_range_um(record: Record, rows: Rows, lag: float) -> tuple[float, float]:
    """Range of the displacement over the whole command of a record, predicted by a fit to its rows `rows`.

        y(k) = g(x(k)) + sum_i c_i play_i(x(k)),   g a cubic,   x of `_lagged`, lag in samples

    The range of the quasi-static fit, widened at both ends by twice the rms of its residual. The displacement measured
    on `rows` is not enough: a later plateau can lie beyond it, and a model is undefined outside its grid.
    """
    return _widened(*_quasi_static(record, rows, lag))


def _widened(y_um: Floats, residual_um: float) -> tuple[float, float]:
    return float(y_um.min()) - 2.0 * residual_um, float(y_um.max()) + 2.0 * residual_um


def _quasi_static(record: Record, rows: Rows, lag: float) -> tuple[Floats, float]:
    """The fit of `predicted_range_um` to the rows `rows`: (n,) of the whole record, and rms of its residual there."""
    columns = _quasi_static_columns(_lagged(record, lag))
    weights, residual_um = _fitted(columns[:, rows], record.y_um[rows])
    return weights @ columns, residual_um


def quasi_static_lag(record: Record, rows: Rows) -> float:
    """The lag of LAGS with which the fit of `predicted_range_um` has the least residual on at most LAG_ROWS of `rows`.

    x and the plays follow the whole command whatever rows are compared.
    """
    # A constant stride would alias with a periodic command.
    few = rows if len(rows) <= LAG_ROWS else np.sort(np.random.default_rng(0).choice(rows, LAG_ROWS, replace=False))
    y_um = record.y_um[few]

    def residual_um(lag: float) -> float:
        return _fitted(_quasi_static_columns(_lagged(record, lag), few), y_um)[1]

    return float(min(LAGS.tolist(), key=residual_um))


def _fitted(columns: Floats, y_um: Floats) -> tuple[Floats, float]:
    """Weights of columns, (p, r), by least squares, and the rms of the residual."""
    weights, *_ = np.linalg.lstsq(columns.T, y_um)
    return np.asarray(weights), float(np.sqrt(np.mean((y_um - weights @ columns) ** 2)))


def _lagged(record: Record, lag: float) -> list[Floats]:
    """The command of each segment behind a lag of `lag` samples, scaled to -1 to 1.

    x(k+1) = x(k) + (1 - exp(-Ts/tau)) (u(k) - x(k))
    """
    rate = np.array([-np.expm1(-1.0 / lag)])
    lagged = [lag_states(s.u_V, rate, s.u_V[:1].copy())[:, 0] for s in record.segments]
    low, high = min(x.min() for x in lagged), max(x.max() for x in lagged)
    return [(2.0 * x - (low + high)) / max(high - low, 1e-300) for x in lagged]


def _quasi_static_columns(lagged: Sequence[Floats], rows: Rows | slice = slice(None)) -> Floats:
    """(4 + p, r) powers and plays of the lagged command on some rows of all segments."""
    x = np.concatenate(lagged)
    plays = np.concatenate([play_operators(part, HALF_WIDTHS, np.full(HALF_WIDTHS.size, part[0])) for part in lagged])
    x, plays = x[rows], plays[rows]
    return np.vstack([x**0, x, x**2, x**3, plays.T])


def prepare(record: Record, holdout: Record | None = None, identify: float = IDENTIFY) -> Prepared:
    """Split a record at the share `identify`, or join it with a held-out one, and find the use of each row.

    A held-out record that was cut from the same segment right behind `record` makes one record with it. The known past
    of other held-out segments is simulated and not scored; that of `record` is not used.
    Raises RecordError if the identification part is too short or consists of burn-in, or the records' periods differ.
    """
    cut = record.samples if holdout is not None else round(identify * record.samples)
    past = [0] * len(record.segments)
    if holdout is None:
        joined = record
    elif _continues(record, holdout):
        last, rest = record.segments[-1].whole(), holdout.segments[0]
        start = record.segments[-1].past_samples
        whole = rest.whole().rows(start, last.samples + rest.samples, record.Ts_s)
        parts = [*record.segments[:-1], whole, *holdout.segments[1:]]
        joined = Record.from_segments(parts, record.Ts_s, record.source, record.said)
        past += [0] * (len(holdout.segments) - 1)
    else:
        joined = Record.joined(record, holdout.whole())
        past += holdout.past_samples
    if cut < FEWEST:
        raise RecordError(
            f"{record.source}: {cut} samples to identify from, a diagnosis needs {FEWEST}; "
            "record longer, or use more rows"
        )
    covered = [_range_covered(segment) for segment in joined.segments]
    for at, segment in enumerate(joined.segments):
        # In the first segment, a play that its rows do not move is a constant of the fit; after a pause it is not.
        if at and not past[at]:
            covered[at] = max(covered[at], _past_forgotten(segment, joined.u_range_V))
    known_past = _rows_from(joined, covered)
    rows = np.flatnonzero(known_past[:cut])
    if rows.size < FEWEST // 2:
        raise RecordError(
            f"{record.source}: {rows.size} of the {cut} samples to identify from come after the input has run through "
            f"its range, a diagnosis needs {FEWEST // 2}; identify from more"
        )
    lag = quasi_static_lag(joined, rows)
    most = [int(MOST_LAGS * one.samples) for one in joined.segments]
    use = np.where(known_past, Use.FADING, Use.UNKNOWN_PAST).astype(np.int8)
    for lags, reached in ((MODEL_LAGS, Use.MODEL), (PROBE_LAGS, Use.PROBE)):
        use[_rows_from(joined, np.add(covered, np.minimum(math.ceil(lags * lag), most)))] = reached
    use[_rows_of_remembrance(joined, cut, past)] = Use.UNKNOWN_PAST
    # A record may be accepted with its sensor at the end of its range; these samples are no displacement of the stage.
    use[np.concatenate(at_end(joined.segments))] = Use.LOST
    return Prepared(joined, cut, use, lag)


def _continues(record: Record, holdout: Record) -> bool:
    """Whether `holdout` begins right behind the last row of `record` in the same segment."""
    last, past = record.segments[-1], holdout.segments[0].past
    if past is None or past.samples + past.past_samples != last.samples + last.past_samples:
        return False
    before, now = past.whole(), last.whole()
    return bool(np.array_equal(before.u_V, now.u_V) and np.array_equal(before.y_um, now.y_um))


def _rows_of_remembrance(record: Record, cut: int, past: Sequence[int]) -> NDArray[np.bool_]:
    """(n,) the first rows of segments that are only scored: from them, the state before the segment is estimated.

    past: rows of each segment that are its known past; then these are the rows.
    """
    firsts = np.cumsum([0, *(segment.samples for segment in record.segments)])[:-1]
    return np.concatenate(
        [
            (np.arange(one.samples) < (known or REMEMBERED * one.samples)) & (first >= cut)
            for first, one, known in zip(firsts, record.segments, past, strict=True)
        ]
    )


def _rows_from(record: Record, firsts: Iterable[int]) -> NDArray[np.bool_]:
    """(n,) True from the given sample of each segment on."""
    return np.concatenate([np.arange(one.samples) >= first for first, one in zip(firsts, record.segments, strict=True)])


def _past_forgotten(segment: Segment, range_V: tuple[float, float]) -> int:
    """First sample at which a hysteresis over the range `range_V` has forgotten what its segment can make it forget.

    Plays of evenly spaced widths follow the segment from where the lowest and from where the highest input leaves
    them; d(k) is their mean difference, which the segment lowers to d(n-1), zero if it covers the range. The result is
    the first k with d <= d(n-1) + FORGOTTEN from k on, and at most the share LATEST of the segment.
    """
    low_V, high_V = range_V
    x = (2.0 * segment.u_V - (low_V + high_V)) / (high_V - low_V)
    low, high = (
        play_operators(np.concatenate([[end], x]), FORGETTING_WIDTHS, np.full(FORGETTING_WIDTHS.size, -end))[1:]
        for end in (-1.0, 1.0)
    )
    later = np.maximum.accumulate(np.abs(high - low).mean(axis=1)[::-1])[::-1]
    return min(int(np.argmax(later <= later[-1] + FORGOTTEN)), int(LATEST * x.size))


def _range_covered(segment: Segment) -> int:
    """First sample at which the input has covered the share COVERED of its range, or the assumed burn-in.

    Where the input rests from there on, the move that covered it is all that the rows show of the stage.
    """
    n, first = segment.samples, first_covering(segment.u_V)
    if first > LATEST_COVERED * n:
        return int(ASSUMED_COVERED * n)
    rests = np.ptp(segment.u_V[first:]) <= (1.0 - COVERED) * np.ptp(segment.u_V)
    return int(ASSUMED_COVERED * n / 3) if rests else max(first, int(ASSUMED_COVERED * n / 3))
