"""The regressors of a path: what its hysteresis, offset and terms add to the displacement, for each coefficient.

    u -> limits, slew, delay -> columns of h -> creep, modes -> lag

A long record is held in windows; the lag, which is searched, is applied to them last.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting.least_squares import windows
from hysgen.fitting.operator import PathSize
from hysgen.machine.kernels.operators import lag_of_signals
from hysgen.machine.reproducible import exp
from hysgen.model.disturbances import Drive, Term
from hysgen.model.intervals import Interval
from hysgen.model.model import Grid
from hysgen.model.path import InputBlock
from hysgen.model.path.creep import Creep
from hysgen.record import Record, Segment

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class PathTask:
    """What a path is fitted to.

    blocks: all blocks but the hysteresis. lags_s: starting values for the lag of the rules; modes bring their own.
    past, rising: as of `FitSettings`.
    whole: record of all commands that are known in advance; the grid covers the response to them.
    """

    record: Record
    whole: Record
    grid: Grid
    input_range_V: tuple[float, float]
    blocks: tuple[InputBlock, ...]
    terms: tuple[Term, ...]
    lags_s: tuple[float, ...]
    size: PathSize
    past: tuple[float, float] | None = None
    rising: bool = True
    name: str = "stage"


@dataclass(frozen=True, eq=False)
class HeldWindow:
    """On a window: columns of h behind creep and modes, (size, n), and of offset and terms, (q, n)."""

    columns: Floats
    extra: Floats


def held_windows(task: PathTask) -> list[HeldWindow]:
    """The regressors of every window of the record before the lag.

    The columns of h are formed along whole segments, a few at a time, and the windows of each are kept.
    """
    Ts_s, operator = task.record.Ts_s, task.size.operator(*passed_V(task))
    held = []
    for segment in task.record.segments:
        u_V = np.clip(segment.u_V, *task.input_range_V)
        for block in task.blocks:
            if not block.responds:
                u_V = block.apply(u_V, Ts_s)
        drive = Drive(u_V, Ts_s, segment.aux, first=round(segment.start_s / Ts_s))
        extra = [column for term in task.terms for column in term.regressors(drive).T]
        places = windows(segment.samples, task.record.samples)
        columns = [np.empty((operator.size, at.stop - at.start)) for at in places]
        for rows, formed in operator.groups():
            group = formed(u_V)
            for block in task.blocks:
                for column in group if block.responds else ():
                    column[:] = block.linear_part(column, Ts_s)
            for at, part in zip(places, columns, strict=True):
                part[rows] = group[:, at]
        for at, part in zip(places, columns, strict=True):
            if task.past is not None:
                part += crept(task, segment, at)
            held.append(HeldWindow(part, np.stack([np.ones(at.stop - at.start), *(column[at] for column in extra)])))
    return held


def crept(task: PathTask, segment: Segment, at: slice = slice(None)) -> Floats:
    """(size, n) what creep adds to the columns of h, from the level before the segment: none for a stage at rest.

    at: the samples of the result.

    amount (h(past_V) - h(0)) sum_i exp(-(past_s + t) / tau_i)
    """
    operator = task.size.operator(*passed_V(task))
    creep = next((block for block in task.blocks if isinstance(block, Creep)), None)
    if task.past is None or creep is None:
        return np.zeros((operator.size, segment.u_V[at].size))
    past_V, past_s = task.past
    moved = operator.at(past_V) - operator.columns(np.clip(segment.u_V[:1], *task.input_range_V))[:, 0]
    t_s = past_s + task.record.Ts_s * np.arange(segment.samples, dtype=np.float64)[at]
    return np.asarray(np.multiply.outer(moved, creep.amount * np.sum(creep.free_responses(t_s), axis=0)))


def passed_V(task: PathTask) -> tuple[float, float]:
    """Range of the voltage behind limits, slew and delay."""
    passed = Interval(*task.input_range_V)
    for block in task.blocks:
        if not block.responds:
            passed = block.image(passed)
    return passed.low, passed.high


def added_um(task: PathTask, segment: Segment) -> Floats | float:
    """(n,) what blocks that are not linear add to the displacement, at the gain of their identification."""
    u_V, Ts_s = np.clip(segment.u_V, *task.input_range_V), task.record.Ts_s
    added: Floats | float = 0.0
    for block in task.blocks:
        added = added + block.added_um(u_V, segment.aux, Ts_s)
        u_V = block.linear_part(u_V, Ts_s)
    return added


def lagged(task: PathTask, held: HeldWindow, lag_s: float, rows: Rows) -> Floats:
    """(p, r) responses of the lag: to h with the static gain 1, to terms with the gain 1 in one sample.

    rows: (r,) rising, of the window.
    """
    Ts_s, extra = task.record.Ts_s, held.extra
    rate = 1.0 - exp(-Ts_s / lag_s)
    h, terms = lag_of_signals(held.columns, rate, rows), lag_of_signals(extra[1:], rate, rows) / rate
    return np.vstack([h, extra[:1, rows], terms])


def all_lagged(task: PathTask, held: Sequence[HeldWindow], lag_s: float) -> Floats:
    """(p, m) `lagged` of all rows of all windows."""
    ends = np.cumsum([0, *(window.extra.shape[1] for window in held)])
    out = np.empty((len(held[0].columns) + len(held[0].extra), ends[-1]))
    for window, first, end in zip(held, ends, ends[1:], strict=False):
        out[:, first:end] = lagged(task, window, lag_s, np.arange(end - first))
    return out
