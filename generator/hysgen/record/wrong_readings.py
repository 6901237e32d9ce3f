"""Single wrong readings of displacement and voltage, found from the record alone and bridged.

    r(k) = y(k) - a1 y(k-2) - a2 y(k-1) - a3 y(k+1) - a4 y(k+2) - sum_j b_j u(k-j) - c

a, b, c by least squares on the rows that are not far off; at the ends of a run, where neighbours are missing, r is the
distance from a parabola through three rows. A row is ordinary if |r| is at most FAR robust standard deviations of the
rows around it, or LEAST of the stroke. One row, or two side by side, are wrong readings if bridging them leaves LEFT of
|r| around them: a step, a knock with an echo or a vibration leave more. What follows a step of the voltage is a motion.
Many such rows are the character of a signal, and stay.

Rows of the voltage are wrong if it leaves and returns as it moves nowhere else, and the displacement does not answer:

    y(k) = a1 y(k-1) + a2 y(k-2) + sum_j b_j u(k-j) + c,   least squares on the rows apart from such moves

holds there, until DELAYED rows later, with the voltage bridged, and does not hold with the voltage as it was written.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hysgen.record.segment import Segment, part_of
from hysgen.record.series import MEDIAN_TO_DEVIATION, resolution_um

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

FAR, LEAST = 10.0, 0.02
"""Robust standard deviations, and share of the stroke, from which on a row is not ordinary."""

BLOCK = 32
"""Rows over which the scatter is taken; that of a row is the largest of its block and the two beside it."""

FEWEST = 64
"""Rows of a run that show what is ordinary."""

MOST = 0.01
"""Share of rows from which on rows that stand alone are the character of a signal."""

RARE = 1e-3
"""Share of wrong readings up to which they are accidents of one log, and none of the next."""

SAID = 5
"""Wrong readings that are named; the number of the others is."""

FITTED = 20_000
"""Rows to which the coefficients are fitted, spread evenly."""

DELAYED, BEYOND = 50, 0.2
"""Rows before, within which a step of the voltage explains what the displacement does. A displacement that leaves the
stroke of the other rows by this share is explained only by a voltage that leaves its own."""

LEFT = 0.15
"""Share of the largest |r| that may be left around a wrong reading once it is bridged; of a step, a fifth is left."""

COARSE = 3.0
"""Steps of the sensor's resolution within which a row is ordinary."""

SURE = 10.0
"""Limits of an ordinary row that a wrong voltage exceeds; half of one is what the displacement may do instead."""

BESIDE = 4
"""Rows on either side that a wrong reading moves."""


@dataclass(frozen=True)
class WrongReading:
    """row: from 0. value, bridged: what was read, and what stands between the neighbours, in um or V."""

    row: int
    value: float
    bridged: float
    voltage: bool = False

    @property
    def unit(self) -> str:
        return "V" if self.voltage else "um"


def wrong_readings(run: Segment) -> list[WrongReading]:
    """The wrong readings of a run, in order, those of the voltage first."""
    wrong = [
        WrongReading(row, float(run.u_V[row]), float(value), voltage=True)
        for start, stop in unanswered(run, 2)
        for row, value in zip(range(start, stop), _between(run.u_V, start, stop)[start:stop], strict=True)
    ]
    return wrong + _wrong_displacements(bridged(run, wrong))


def unanswered(run: Segment, widest: int = DELAYED) -> list[tuple[int, int]]:
    """[start, stop) of up to `widest` rows that hold a wrong voltage."""
    u, y = run.u_V, run.y_um
    moves = np.diff(u)
    usual, n = np.abs(moves[moves != 0.0]), u.size
    if n < FEWEST or not usual.size or not np.isfinite(u).all() or not np.isfinite(y).all():
        return []
    jumps = np.flatnonzero(np.abs(moves) > max(FAR * np.quantile(usual, 0.95), LEAST * np.ptp(u))) + 1
    pairs = [(a, b) for a, b in pairwise(jumps.tolist()) if b - a <= widest and moves[a - 1] * moves[b - 1] < 0.0]
    apart = np.ones(n, dtype=bool)
    for row in jumps if pairs else ():
        apart[max(row - 1, 0) : row + DELAYED] = False
    apart[:4] = False
    rows = np.flatnonzero(apart)[:: max(1, np.count_nonzero(apart) // FITTED)]
    if rows.size < FEWEST or not pairs:
        return []
    middle, centre, scale = float(np.median(y)), float(u.mean()), float(np.ptp(y)) / float(np.ptp(u)) or 1.0

    def terms(drive_V: Floats, at: Rows) -> Floats:
        drive = (drive_V - centre) * scale
        return np.stack(
            [y[at - 1] - middle, y[at - 2] - middle, *(drive[at - lag] for lag in range(5)), 0.0 * at + 1.0]
        )

    A, target = terms(u, rows), y[rows] - middle
    # On a smooth voltage the b_j are alike: their sum is what the rows tell.
    weights = np.linalg.solve(A @ A.T + 1e-9 * np.trace(A @ A.T) * np.eye(len(A)), A @ target)
    ordinary = FAR * MEDIAN_TO_DEVIATION * float(np.median(np.abs(target - weights @ A)))
    limit = max(ordinary, COARSE * resolution_um(y), 1e-9 * float(np.ptp(y)))
    found: list[tuple[int, int]] = []
    for start, stop in pairs:
        at = np.arange(max(start, 4), min(stop + DELAYED, n))
        written, without = (
            float(np.abs(y[at] - middle - weights @ terms(drive, at)).max()) for drive in (u, _between(u, start, stop))
        )
        if written > SURE * limit and without <= 0.5 * limit and (not found or start > found[-1][1]):
            found.append((start, stop))
    return found


def _between(values: Floats, start: int, stop: int) -> Floats:
    """The values with rows start .. stop - 1 on the cubic through two rows on either side."""
    beside = [at for at in (start - 2, start - 1, stop, stop + 1) if 0 <= at < values.size]
    cubic = np.polyfit(np.subtract(beside, start), values[beside], min(len(beside) - 1, 3))
    made = values.copy()
    made[start:stop] = np.polyval(cubic, np.arange(stop - start))
    return made


def _wrong_displacements(run: Segment) -> list[WrongReading]:
    y, u = run.y_um.copy(), run.u_V
    n = y.size
    if n < FEWEST or not np.isfinite(y).all():
        return []
    low_um, high_um = (float(end) for end in np.quantile(y, (0.005, 0.995)))
    stroke = high_um - low_um
    if not stroke > 0.0:
        return []
    bend = np.abs(np.diff(y, 2))
    if not float(bend.max()) > LEAST * stroke:
        return []
    predictor = _predictor(u, y, stroke)
    off = np.abs(predictor.residual(y))
    limit = np.maximum(FAR * _scatter(off), LEAST * stroke)
    rough = FAR * MEDIAN_TO_DEVIATION * float(np.median(np.abs(np.diff(y, 3))))
    limit[[0, 1, -2, -1]] = np.maximum([rough, rough / 3.0] * 2, np.repeat([BEYOND, LEAST], 2) * stroke)[[0, 1, 3, 2]]
    suspect = np.flatnonzero(off > limit)
    if not suspect.size or suspect.size > 5 * max(MOST * n, 2.0):
        return []
    limit = np.maximum(limit, COARSE * resolution_um(y))
    suspect = suspect[off[suspect] > limit[suspect]]
    stepped, outside_V = _steps(u), _beyond(u, *np.quantile(u, (0.005, 0.995)))
    outside_um = _beyond(y, low_um, high_um)
    found: list[WrongReading] = []
    for cluster in filter(np.size, np.split(suspect, np.flatnonzero(np.diff(suspect) > BESIDE) + 1)):
        rows, bridge = _culprits(y, predictor, limit, int(cluster[0]), int(cluster[-1]))
        before = slice(max(int(cluster[0]) - DELAYED, 0), int(cluster[-1]) + 2)
        # A transient at the start of a record looks like a wrong second row.
        explained = outside_V[before].any() if outside_um[rows].all() else stepped[before].any() or (rows == 1).any()
        if not explained:
            found += [
                WrongReading(int(row), float(y[row]), float(value)) for row, value in zip(rows, bridge, strict=True)
            ]
    return found if len(found) <= max(MOST * n, 2.0) else []


def sound(runs: Sequence[Segment]) -> list[Segment]:
    """The runs without wrong readings, for checks of all others."""
    return [bridged(run, wrong_readings(run)) for run in runs]


def bridged_segments(segments: Sequence[Segment], Ts_s: float) -> tuple[list[Segment], list[WrongReading]]:
    """The segments and their pasts without wrong readings, and those outside the pasts by the row of the record."""
    made, found, first = [], [], 0
    for segment in segments:
        whole, past = segment.whole(), segment.past_samples
        wrong = wrong_readings(whole)
        mended = bridged(whole, wrong)
        made.append(segment if not wrong else mended.rows(past, whole.samples, Ts_s) if past else mended)
        found += [replace(one, row=first + one.row - past) for one in wrong if one.row >= past]
        first += segment.samples
    return made, found


def lines_of(source: str, found: Sequence[WrongReading]) -> tuple[str, ...]:
    """A line for each wrong reading of a record; rows are those of the whole record, also for a part "a.csv[20:80]"."""
    name, first = part_of(source)
    lines = [
        f"{name}: row {first + one.row}: the {'voltage' if one.voltage else 'displacement'} is {one.value:.6g} "
        f"{one.unit}, {abs(one.value - one.bridged):.4g} {one.unit} off its neighbours: a wrong reading, left out"
        for one in found[:SAID]
    ]
    if len(found) > SAID:
        lines.append(f"{name}: {len(found) - SAID} more wrong readings are left out, to row {first + found[-1].row}")
    return tuple(lines)


def are_frequent(rows: Sequence[int] | Rows, samples: int) -> bool:
    """Whether wrong readings are more than RARE of the samples, and stand in two tenths of them that do not touch."""
    tenths = {10 * int(row) // samples for row in rows}
    return len(rows) > RARE * samples and max(tenths, default=0) - min(tenths, default=0) > 1


def bridged(run: Segment, found: Sequence[WrongReading]) -> Segment:
    """The run with the wrong readings replaced by what stands between their neighbours."""
    u_V, y_um = run.u_V.copy(), run.y_um.copy()
    for one in found:
        (u_V if one.voltage else y_um)[one.row] = one.bridged
    return replace(run, u_V=u_V, y_um=y_um) if found else run


@dataclass(frozen=True, eq=False)
class _Predictor:
    """neighbours: a1 .. a4. rest: (n,) what voltage and constant add in every row."""

    neighbours: Floats
    rest: Floats

    def residual(self, y: Floats, first: int = 0, stop: int | None = None) -> Floats:
        """r of the rows first .. stop - 1, (stop - first,)."""
        n = y.size
        stop = n if stop is None else stop
        padded = np.pad(y[max(first - 2, 0) : stop + 2], (max(2 - first, 0), max(stop + 2 - n, 0)))
        count = stop - first
        a1, a2, a3, a4 = self.neighbours
        predicted = a1 * padded[:count] + a2 * padded[1 : count + 1] + a3 * padded[3 : count + 3] + a4 * padded[4:]
        off = y[first:stop] - predicted - self.rest[first:stop]
        for row, weights in ((0, (1.0, -3.0, 3.0, -1.0)), (1, (-1.0 / 3.0, 1.0, -1.0, 1.0 / 3.0))):
            if first <= row < stop:
                off[row - first] = float(np.dot(weights, y[:4]))
            if first <= n - 1 - row < stop:
                off[n - 1 - row - first] = float(np.dot(weights, y[: n - 5 : -1]))
        return np.asarray(off)


LAGS = range(-1, 4)
"""Rows by which the voltage that explains a row is earlier."""


def _predictor(u: Floats, y: Floats, stroke: float) -> _Predictor:
    """The coefficients by least squares on rows that are not far off, from those of a cubic on."""
    n = y.size
    middle, centre, scale = float(np.median(y)), float(u.mean()), stroke / (float(np.ptp(u)) or 1.0)
    drive = (np.pad(u, (max(LAGS), -min(LAGS)), mode="edge") - centre) * scale
    places = np.arange(2, n - 2)
    places = places[:: max(1, places.size // FITTED)]
    beside = [y[places + shift] - middle for shift in (-2, -1, 1, 2)]
    X = np.stack([*beside, *(drive[places + max(LAGS) - lag] for lag in LAGS), np.full(places.size, stroke)])
    target = y[places] - middle
    weights = np.concatenate([np.array([-1.0, 4.0, 4.0, -1.0]) / 6.0, np.zeros(len(X) - 4)])
    for _ in range(3):
        off = np.abs(target - weights @ X)
        near = off <= 6.0 * MEDIAN_TO_DEVIATION * float(np.median(off)) + 1e-9 * stroke
        if np.count_nonzero(near) < 4 * weights.size:
            break
        A, ridge = X[:, near], 1e-9 * np.count_nonzero(near) * stroke * stroke
        weights = np.linalg.solve(A @ A.T + ridge * np.eye(weights.size), A @ target[near] + ridge * weights)
    rest = np.full(n, weights[-1] * stroke + middle * (1.0 - float(weights[:4].sum())))
    for weight, lag in zip(weights[4:-1], LAGS, strict=True):
        rest += weight * drive[max(LAGS) - lag : max(LAGS) - lag + n]
    return _Predictor(weights[:4], rest)


def _scatter(off: Floats) -> Floats:
    """(n,) robust standard deviation around each row: the largest of its block, the two beside it and the record."""
    count = max(off.size // BLOCK, 1)
    blocks = np.median(off[: count * BLOCK].reshape(count, -1), axis=1)
    around = np.maximum(np.maximum(blocks, [*blocks[1:], 0.0]), [0.0, *blocks[:-1]])
    ends = np.minimum(np.arange(off.size) // BLOCK, count - 1)
    return np.asarray(MEDIAN_TO_DEVIATION * np.maximum(around[ends], float(np.median(off))))


def _culprits(y: Floats, predictor: _Predictor, limit: Floats, first: int, last: int) -> tuple[Rows, Floats]:
    """The one row, or the two side by side, without which all rows around are ordinary, and their bridge; or none."""
    low, high = max(first - BESIDE, 0), min(last + BESIDE + 1, y.size)
    before = float((np.abs(predictor.residual(y, low, high)) / limit[low:high]).max())
    best, best_rows = min(1.0, LEFT * before), np.zeros(0, dtype=np.intp)
    best_bridge: Floats = np.zeros(0)
    for width in (1, 2):
        for row in range(max(first - 1, 0), min(last + 2, y.size) - width + 1):
            rows = np.arange(row, row + width)
            bridge = _between(y, row, row + width)[rows]
            kept, y[rows] = y[rows], bridge
            left = float((np.abs(predictor.residual(y, low, high)) / limit[low:high]).max())
            y[rows] = kept
            if left < best:
                best, best_rows, best_bridge = left, rows, bridge
        if best_rows.size:
            break
    return best_rows, best_bridge


def _beyond(values: Floats, low: float, high: float) -> NDArray[np.bool_]:
    """(n,) values that leave low .. high by BEYOND of it."""
    return np.asarray(np.maximum(low - values, values - high) > BEYOND * (high - low))


def _steps(u: Floats) -> NDArray[np.bool_]:
    """(n,) rows before which the voltage moves as it rarely does."""
    moves = np.abs(np.diff(u, prepend=u[0]))
    return np.asarray(moves > 3.0 * float(np.quantile(moves, 0.9)) + 1e-9 * float(np.ptp(u)))
