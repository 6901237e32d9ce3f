"""The rows of a long record to which the search looks: blocks of consecutive samples, and a coarse run.

Fast causes (delay, modes, limits) show in consecutive samples, slow ones (creep, drift, aging, memory of a slow
command) in blocks far apart in time and in a coarse run, whose samples are as far apart as the command stays straight
between them. Every run begins in the state of the whole record: its history holds the samples of the earlier command
that a hysteresis still remembers, and samples at ages in geometric progression for creep. Time is counted from the
start of the segment, so lines keep their phase from run to run.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from hysgen.diagnosis.probe import NO_HISTORY, History, Scene, Trace
from hysgen.record.series import turning_rows

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

_NO_ROWS: Rows = np.zeros(0, dtype=np.intp)

LONG, LONG_DRIVEN, MOST_SAMPLES = 100_000, 200_000, 14_000
"""Samples of a record above which the search looks at an excerpt, the same of one with several drives, and samples of
the excerpt; 8000 of them are fitted (`search.MOST_ROWS`). Seven blocks cannot hold everything that excites a record: an
excerpt of the bundled record misses its delay and its mode. So only records are shortened whose search would take
minutes. The modes of several drives are identified from whole segments alone (`causes.modes`)."""

FAST = 0.05
"""Least step of a channel between two samples, as a share of its spread (rms both), that makes it a drive: a line of
a hundredth of the sampling rate steps by 0.06. Temperatures and slow sensors stay below."""

BLOCKS = 7
"""Blocks of an excerpt: six are enough to tell a ramp from a course that slows down, one is where most is left."""

COARSE_SHARE = 0.5
"""Share of MOST_SAMPLES that a coarse run takes; the blocks are then shorter by this share."""

STRAIGHT = 2e-5
"""Largest distance of a command or channel from the straight line between two samples of a coarse run, as a share of
its range, at which the samples are fitted. The response is wrong by less, and the noise of a good sensor is larger; the
error has the sign of the curvature, so a larger one would be taken for a shorter lag."""

FEWEST_STRAIGHT = 0.5
"""Least share of the samples of a coarse run that are fitted; otherwise the samples must be closer together."""

FADING_LAGS = 8.0
"""Time constants of the lag at the start of a block that are not fitted: exp(-8) is 1/3000 of a stroke."""

LEAST_FADING = 0.05
"""Least share of a block that is not fitted, for modes, which ring longer than the lag."""

LONGEST_FADING = 1 / 3
"""A block is longer than MOST_SAMPLES / BLOCKS where this share of it is shorter than the fading of the lag."""

LEVELS, RATES = 10, 6
"""Classes of the command's level and of its rate (factors of 4 below the largest), in which blocks shall differ."""

INTERVALS = 1500
"""Intervals of ages in a history: 300 in each decade of a record of 1e5 samples. The creep of the past is then known to
6e-4 of its amount for a full stroke, below the noise of a good sensor."""

RECENT_TURNS, TURNS_WITHIN = 150, 30_000
"""Latest turning points in a history, for states that forget along the path: a dozen full strokes or more."""

MOST_REMEMBERED = 60
"""Extremes in a history that a hysteresis remembers; later ones differ by less than the noise of a converter."""


@dataclass(frozen=True)
class _Block:
    """Samples first to last (exclusive) of a segment; covers: classes of level and rate that its fitted rows have."""

    segment: int
    first: int
    last: int
    covers: frozenset[int]


def excerpt(scene: Scene, lag: float, left_um: Callable[[], Floats]) -> Scene:
    """The scene on parts of its samples; the scene itself if it has at most LONG. lag: in samples.

    left_um: what a quasi-static fit leaves, (samples,) of the scene; asked for if the record is long.
    The first and the last block are those of the first and last fitted rows, the third is that in which most is left
    that changes within a lag, as a mode does under a small chirp; each further one has the fastest classes of level and
    rate that the blocks before it lack, and of several such blocks it is the farthest from them.
    """
    length = max(MOST_SAMPLES // BLOCKS, math.ceil(FADING_LAGS * lag / LONGEST_FADING))
    if scene.samples <= max(LONG_DRIVEN if _driven(scene) else LONG, BLOCKS * length):
        return scene
    fading = max(math.ceil(FADING_LAGS * lag), math.ceil(LEAST_FADING * length))
    coarse = _coarse_run(scene, fading)
    if coarse is not None:
        length = max(round((1.0 - COARSE_SHARE) * length), math.ceil(fading / LONGEST_FADING))
    left = _blocks(scene, length, fading)
    chosen = [left.pop(0), left.pop(-1)]
    if left:
        error_um, firsts = left_um(), np.cumsum([0, *(len(run.u_V) for run in scene.runs)])
        chosen.append(max(left, key=lambda block: _moved_um(error_um[firsts[block.segment] :], block, lag)))
        left.remove(chosen[-1])
    while len(chosen) < BLOCKS and left:
        covered = frozenset[int]().union(*(block.covers for block in chosen))
        best = max(left, key=lambda block: (_worth(block.covers - covered), _distance(block, chosen)))
        left.remove(best)
        chosen.append(best)
    parts = [_part_of(scene, block, fading) for block in _joined(chosen)]
    return _scene_of(scene, [*parts, *([coarse] if coarse else [])])


def _driven(scene: Scene) -> bool:
    """Whether a channel moves as fast as a drive in every run."""
    courses = [[run.aux[name] for run in scene.runs] for name in scene.runs[0].aux]
    return any(all(0.0 < FAST * np.std(x) < np.std(np.diff(x)) for x in course) for course in courses)


@dataclass(frozen=True, eq=False)
class _Part:
    """A run of an excerpt, the samples of it that are fitted, and those at which the sensor was at its end."""

    run: Trace
    rows: Rows
    lost: Rows


def _coarse_run(scene: Scene, fading: int) -> _Part | None:
    """The longest segment, or the part of it that moves most, at as few samples as the command allows; None for none.

    Where the command, or a channel, leaves the straight line between two samples, they and those after them, while the
    lag fades, are not fitted. An extreme in between replaces the sample before it, because a hysteresis remembers it.
    """
    number = int(np.argmax([len(run.u_V) for run in scene.runs]))
    run, first = scene.runs[number], sum(len(run.u_V) for run in scene.runs[:number])
    n, count = len(run.u_V), round(COARSE_SHARE * MOST_SAMPLES)
    fitted = np.zeros(n, dtype=bool)
    fitted[scene.rows[(scene.rows >= first) & (scene.rows < first + n)] - first] = True
    stride = math.ceil(n / count)
    while stride > 1:
        strides = math.ceil(fading / stride) + 10
        bent = _bent([run.u_V, *run.aux.values()], stride)
        usable = ~maximum_filter1d(bent, strides, origin=(strides - 1) // 2) & fitted[: len(bent) * stride : stride]
        starts = np.unique(np.linspace(0, max(0, len(usable) - count), 9).astype(int))
        begin = max(starts.tolist(), key=lambda start: int(usable[start : start + count].sum()))
        usable = usable[begin : begin + count]
        if usable.sum() >= FEWEST_STRAIGHT * len(usable):
            return _Part(_strided(run, begin * stride, stride, len(usable)), np.flatnonzero(usable), _NO_ROWS)
        stride //= 2
    return None


def _bent(signals: list[Floats], stride: int) -> NDArray[np.bool_]:
    """(m,) whether a signal leaves the straight line before or after the sample m stride by more than STRAIGHT."""
    m = (len(signals[0]) - 1) // stride
    bent = np.zeros(m + 1, dtype=bool)
    for signal in signals:
        part = signal[: m * stride + 1]
        ends = part[::stride]
        line = ends[:-1, None] + np.outer(np.diff(ends), np.arange(stride) / stride)
        away = np.abs(part[:-1].reshape(m, stride) - line).max(axis=1) > STRAIGHT * np.ptp(signal)
        bent[:-1] |= away
        bent[1:] |= away
    return bent


def _strided(run: Trace, first: int, stride: int, count: int) -> Trace:
    """The run from the sample `first` on, at every `stride`-th sample or the extreme that follows it."""
    u_V = run.u_V[first : first + count * stride : stride].copy()
    whole = run.u_V[first : first + len(u_V) * stride]
    turns = turning_rows(whole, STRAIGHT * float(np.ptp(run.u_V)))
    u_V[turns // stride] = whole[turns]
    at = slice(first, first + count * stride, stride)
    aux = {name: values[at] for name, values in run.aux.items()}
    cells = np.lib.stride_tricks.sliding_window_view(np.append(run.u_V[first:], np.full(stride, run.u_V[-1])), stride)
    mean_V = cells[: count * stride : stride].mean(axis=1)[: len(u_V)]
    step_V = np.append(np.diff(u_V), 0.0)
    # A command that is held for a period is half a period behind the line.
    share = (mean_V - u_V) / np.where(step_V == 0.0, np.inf, step_V) + 0.5 / stride
    share = np.where(np.abs(step_V) > STRAIGHT * np.ptp(run.u_V), share.clip(0.0, 1.0), 0.5)
    return Trace(u_V, run.y_um[at], aux, run.start, history(run.u_V, first), len(run.u_V), stride, share)


def _blocks(scene: Scene, length: int, fading: int) -> list[_Block]:
    """All blocks of a scene that can be chosen, in order: those with fitted rows in half of their length or more."""
    fitted = np.zeros(scene.samples, dtype=bool)
    fitted[scene.rows] = True
    largest = max(float(np.abs(np.diff(run.u_V)).max(initial=0.0)) for run in scene.runs) + 1e-300
    span_V = scene.operator.high_V - scene.operator.low_V
    found, offset = [], 0
    for number, run in enumerate(scene.runs):
        rate_V = np.diff(run.u_V, prepend=run.u_V[0])
        level = np.clip(LEVELS * (run.u_V - scene.operator.low_V) / span_V, 0, LEVELS - 1).astype(int)
        speed = np.clip(RATES + 0.5 * np.log2(np.abs(rate_V) / largest + 1e-300), 0, RATES).astype(int)
        kind = level * (2 * RATES + 1) + RATES + np.sign(rate_V).astype(int) * speed
        n = len(run.u_V)
        usable = np.flatnonzero(fitted[offset : offset + n])
        if len(usable):
            begin = max(0, int(usable[0]) - fading)
            starts = np.linspace(begin, max(begin, n - length), max(2, 2 * (n - begin) // length)).astype(int)
            for first in np.unique(starts).tolist():
                last = min(n, first + length)
                rows = first + np.flatnonzero(fitted[offset + first : offset + last])
                rows = rows[(rows >= first + fading) | (first == 0)]
                if 2 * len(rows) >= last - first:
                    found.append(_Block(number, first, last, frozenset(kind[rows].tolist())))
        offset += n
    return found


def _moved_um(error_um: Floats, block: _Block, lag: float) -> float:
    """Median of how far an error, (n,) from the start of the segment, moves within a lag; a jump does not count."""
    samples = math.ceil(lag) + 1
    windows = (block.last - block.first) // samples
    part = error_um[block.first : block.first + windows * samples].reshape(windows, samples)
    return float(np.median(np.ptp(part, axis=1)))


def _worth(classes: frozenset[int]) -> float:
    """Sum of the rates of classes in powers of two: a step shows lag, delay and modes, and a plateau nothing fast."""
    return float(sum(2 ** abs(one % (2 * RATES + 1) - RATES) for one in classes))


def _distance(block: _Block, chosen: list[_Block]) -> float:
    """Samples from the nearest chosen block of the same segment; more than any record has if there is none."""
    near = [abs(block.first - other.first) for other in chosen if other.segment == block.segment]
    return float(min(near, default=10**12))


def _part_of(scene: Scene, block: _Block, fading: int) -> _Part:
    """The block as a run; its rows at the start, while the lag fades, are not fitted."""
    run, at = scene.runs[block.segment], slice(block.first, block.last)
    low = sum(len(run.u_V) for run in scene.runs[: block.segment]) + block.first
    begin, high = low if block.first == 0 else low + fading, low + block.last - block.first
    aux = {name: values[at] for name, values in run.aux.items()}
    past = history(run.u_V, block.first)
    return _Part(
        Trace(run.u_V[at], run.y_um[at], aux, run.start, past, len(run.u_V)),
        scene.rows[(scene.rows >= begin) & (scene.rows < high)] - low,
        scene.lost[(scene.lost >= low) & (scene.lost < high)] - low,
    )


def _scene_of(scene: Scene, parts: list[_Part]) -> Scene:
    """The scene of these runs."""
    offsets = np.cumsum([0, *(len(part.run.u_V) for part in parts)])[:-1]
    rows = np.concatenate([part.rows + offset for part, offset in zip(parts, offsets, strict=True)])
    lost = np.concatenate([part.lost + offset for part, offset in zip(parts, offsets, strict=True)])
    ranges = {name: scene.range_of(name) for name in scene.runs[0].aux}
    runs = tuple(part.run for part in parts)
    return Scene(runs, scene.Ts_s, rows.astype(np.intp), scene.operator, ranges, lost.astype(np.intp))


def _joined(blocks: list[_Block]) -> list[_Block]:
    """The blocks in their order, those that overlap or touch as one."""
    result: list[_Block] = []
    for block in sorted(blocks, key=lambda block: (block.segment, block.first)):
        if result and result[-1].segment == block.segment and result[-1].last >= block.first:
            result[-1] = _Block(block.segment, result[-1].first, max(result[-1].last, block.last), frozenset())
        else:
            result.append(block)
    return result


def history(u_V: Floats, first: int) -> History:
    """The command before sample `first`.

    The extremes that a hysteresis remembers, the latest turning points, and one sample of each interval of ages in
    geometric progression, the one nearest to the mean command of its interval.
    """
    if first == 0:
        return NO_HISTORY
    ages = np.unique(np.concatenate([[0], np.geomspace(1.0, first, INTERVALS).astype(np.int64)]))
    near = np.array([_nearest_to_mean(u_V, first - old, first - young) for young, old in itertools.pairwise(ages)])
    begin = max(0, first - TURNS_WITHIN)
    turns = begin + turning_rows(u_V[begin:first], 0.0)[-RECENT_TURNS:]
    chosen = np.unique(np.concatenate([[0], remembered(u_V[:first]), turns, near])).astype(np.intp)
    held = np.diff(chosen, append=first).astype(np.int64)
    return History(u_V[chosen], held, ages, np.searchsorted(chosen, near))


def _nearest_to_mean(u_V: Floats, low: int, high: int) -> int:
    """The sample in low .. high - 1 whose value is nearest to the mean."""
    part = u_V[low:high]
    return low + int(np.argmin(np.abs(part - part.mean())))


def remembered(u_V: Floats) -> Rows:
    """Extremes of a command, (n,), that a play remembers at its end: alternately highest and lowest since the last."""
    found: list[int] = []
    n, low = len(u_V), 0
    while low < n - 1 and len(found) < MOST_REMEMBERED:
        rest = u_V[low:][::-1]
        ends = sorted({n - 1 - int(np.argmax(rest)), n - 1 - int(np.argmin(rest))})
        found += ends
        low = ends[-1] + 1
        if len(ends) == 1:
            break
    return np.array(found, dtype=np.intp)
