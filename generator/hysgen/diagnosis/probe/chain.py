"""The probe's chain: a hypothesis about the parts between command and sensor; its linear part, exact for a held input.

    u -> amplifier -> h(u) -> slow states -> modes -> 1/(lag s + 1) -> delay -> (1 + gain change)  + added columns

h is linear in its coefficients (`operator`), and the chain behind h is linear: for given shape parameters, all other
parameters follow from linear least squares. Each part belongs to a cause and is declared in the file of the cause.

Unbroken runs of a record, and the command of their segment before them.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from hysgen.machine.kernels.operators import Branch, LinearPart, linear_response, linear_response_rows
from hysgen.model.part import Extent, Mode, Part, ShapeParameter, SlowStates

Floats = NDArray[np.float64]
P = TypeVar("P", bound=Part)

FASTEST = 0.05
"""Frequency of a mode times the distance of two samples from which on the mode responds at once: 1 % early."""

LAG = ShapeParameter("lag_s", "s", lambda extent: (0.02 * extent.Ts_s, 0.3 * extent.span_s), logarithm=True)


COMMON = 3
"""Added columns of every chain: a constant, and those of the sensor's curve."""


@dataclass(frozen=True)
class Chain:
    """One hypothesis about the stage.

    lag_s: time constant of the first-order lag that every chain has.
    parts: at most one of each cause, in their order. memory: whether h is a hysteresis operator or single-valued.
    curve: whether a single-valued h may bend; a hysteresis always may.
    """

    lag_s: float
    parts: tuple[Part, ...] = ()
    memory: bool = True
    curve: bool = True

    def __post_init__(self) -> None:
        parts = tuple(sorted((part.behind(self.lag_s) for part in self.parts), key=lambda part: part.place))
        if len({part.cause for part in parts}) < len(parts):
            raise ValueError("a chain holds at most one part of each cause")
        object.__setattr__(self, "parts", parts)

    def get(self, kind: type[P]) -> P | None:
        """The part of a kind, None if the chain has none."""
        return next((part for part in self.parts if isinstance(part, kind)), None)

    def of(self, kind: type[P]) -> P:
        """The part of a kind. Raises LookupError if the chain has none."""
        part = self.get(kind)
        if part is None:
            raise LookupError(f"the chain has no {kind.__name__}")
        return part

    def having(self, part: Part) -> Chain:
        """The chain with this part, in place of that of its cause if there is one."""
        return dataclasses.replace(self, parts=(*self.without(part.cause).parts, part))

    def without(self, cause: str) -> Chain:
        """The chain without its part of a cause."""
        return dataclasses.replace(self, parts=tuple(part for part in self.parts if part.cause != cause))

    @property
    def parameters(self) -> tuple[tuple[str, ShapeParameter], ...]:
        """Name and table entry of every free shape parameter: the lag's, then those of the parts in their order."""
        return (("lag_s", LAG), *(named for part in self.parts for named in part.parameters))

    def names(self) -> tuple[str, ...]:
        """Names of the coordinates, in their order: "lag_s", or "cause.field"."""
        return tuple(name for name, _ in self.parameters)

    def coordinates(self) -> Floats:
        """Coordinates of the free shape parameters: ln(value) if `ShapeParameter.logarithm`, otherwise the value."""
        values = (self.lag_s, *(value for part in self.parts for value in part.values))
        return np.array([one.coordinate(value) for (_, one), value in zip(self.parameters, values, strict=True)])

    def at(self, coordinates: Sequence[float] | Floats) -> Chain:
        """The chain of the same structure with other shape parameters; inverse of `coordinates`."""
        values = iter([one.value(float(x)) for (_, one), x in zip(self.parameters, coordinates, strict=True)])
        lag_s = next(values)
        parts = tuple(part.with_values([next(values) for _ in part.values]) for part in self.parts)
        return dataclasses.replace(self, lag_s=lag_s, parts=parts)

    def bounded(self, coordinates: Floats, extent: Extent) -> Chain:
        """The chain at `coordinates`, each clamped to its bounds."""
        entries = [one for _, one in self.parameters]
        return self.at([one.bounded(float(x), extent) for one, x in zip(entries, coordinates, strict=True)])

    def steps(self, extent: Extent) -> Floats:
        """Step of the forward difference in each coordinate."""
        return np.array([one.step(extent) for _, one in self.parameters])

    @property
    def amplifier(self) -> tuple[Part, ...]:
        """The parts before the hysteresis."""
        return tuple(part for part in self.parts if part.amplifies)

    def amplified(self, u_V: Floats, Ts_s: float) -> Floats:
        """(n,) voltage behind the amplifier for the commands u_V."""
        for part in self.amplifier:
            u_V = part.apply(u_V, Ts_s)
        return u_V

    @property
    def relaxation(self) -> float:
        """Relaxation of the plays in half-widths, 0 for plays that do not relax."""
        return max((part.relaxation for part in self.parts), default=0.0)

    def slow_states(self, span_s: float) -> SlowStates | None:
        """The slow states behind the hysteresis for a segment of span_s; None if no part has them."""
        candidates = (part.slow_states(span_s) for part in self.parts)
        return next((block for block in candidates if block is not None), None)

    @property
    def past(self) -> tuple[float, float] | None:
        """What the slow states hold of the time before a segment (`Part.past`)."""
        return next((part.past for part in self.parts if part.past is not None), None)

    @property
    def modes(self) -> tuple[Mode, ...]:
        """Second-order modes behind the hysteresis."""
        return tuple(mode for part in self.parts for mode in part.modes)

    @property
    def delay(self) -> float:
        """Delay in samples, whole or fractional, beyond the one sample that sampling costs; negative where the
        channels of the record are not aligned."""
        return math.fsum(part.late for part in self.parts)

    def gain_change(self, t_s: Floats) -> Floats | float:
        """(n,) relative change of the gain at times t_s after the start of the segment, or 0."""
        return sum((part.gain_change(t_s) for part in self.parts), 0.0)

    def first_column(self, kind: type[Part]) -> int:
        """Place of the first added column of a part among all added columns; behind the COMMON ones of every chain."""
        count = COMMON
        for part in self.parts:
            if isinstance(part, kind):
                break
            count += part.added
        return count


def respond(run: Trace, h: Driven, chain: Chain, Ts_s: float, rows: Rows | None = None) -> Floats:
    """(m, n) response of slow states, modes, lag and delay to h of a run; in Fortran order on some rows, (m, r).

    y(k) depends on h(k-1), h(k-2), ..., and h(k) = h(0) for k < 0: every record has one sample of delay.
    """
    slow = chain.slow_states(run.whole * Ts_s)
    branches, whole = _branches(chain.lag_s, chain.delay, chain.modes, run.stride, Ts_s)
    if slow is None or slow.amount == 0.0:
        return _response(h.h, LinearPart(0.0, np.zeros(0), branches, whole), rows)
    keep, coarse = 1.0 - slow.rates(Ts_s), run.stride > 1
    seen = _response(h.h, LinearPart(2.0 * slow.amount, np.zeros(0) if coarse else keep, branches, whole), rows)
    if not coarse and not len(run.history):
        return seen
    # The response of the slow states to their history is added behind the lag, which is much faster.
    started, late = h.h[:, :1], 0.0
    if coarse:
        # Their response is straight over the time of the lag and is only late.
        late, started = (chain.lag_s / Ts_s + chain.delay + 0.5) / run.stride, h.mean[:, :1]
        taps, whole = _between(Branch(1.0, np.array([1.0, 0.0]), np.array([1.0, 0.0])), -late), math.ceil(late) - 1
        seen += _response(h.mean, LinearPart(2.0 * slow.amount, keep**run.stride, [taps], whole, direct=0.0), rows)
        seen -= started
    ages, later = _fading(run, tuple(keep.tolist()), late)
    moved = h.before[:, 1:] @ ages[:-1] + h.before[:, :1] * ages[-1] - started
    seen += ((later if rows is None else later[:, rows]).T @ (slow.amount * moved).T).T
    seen += slow.amount * len(keep) * (started - h.before[:, :1])
    return seen


@functools.lru_cache(maxsize=32)
def _fading(run: Trace, keep: tuple[float, ...], late: float) -> tuple[Floats, Floats]:
    """(a + 1, s) weights of h in the states s(k+1) = keep s(k) + (1 - keep) h(k) at the start of a run, for the ages
    of its history and the time before the segment. And (s, n) what is left of the states at each sample, less late.
    """
    log_keep = np.log(keep)
    left = _decayed(log_keep, run.history.ages).T
    at = np.maximum(np.arange(len(run.u_V)) - late, 0.0)
    return np.vstack([left[:-1] - left[1:], left[-1:]]), _decayed(run.stride * log_keep, at)


def _decayed(rates: Floats, at: Floats | Samples) -> Floats:
    """(m, k) exp(rate at), not below exp(-100): products of the smallest numbers of float64 take 100 times as long."""
    return np.asarray(np.exp(np.maximum(np.multiply.outer(rates, at), -100.0)))


def lagged(run: Trace, signals: Floats, chain: Chain, Ts_s: float, rows: Rows | None = None) -> Floats:
    """(m, n) response of the lag and the delay alone to signals, (m, n), constant before their first sample.

    rows: (r,) rising samples of the result, (m, r); None for all.
    """
    branches, whole = _branches(chain.lag_s, chain.delay, (), run.stride, Ts_s)
    return _response(signals, LinearPart(0.0, np.zeros(0), branches, whole), rows)


def _response(signals: Floats, linear: LinearPart, rows: Rows | None) -> Floats:
    return linear_response(signals, linear) if rows is None else linear_response_rows(signals, linear, rows)


@functools.lru_cache(maxsize=64)
def _branches(
    lag_s: float, delay: float, modes: tuple[Mode, ...], stride: int, Ts_s: float
) -> tuple[tuple[Branch, ...], int]:
    """Branches (lag with the share of no mode, lag with each mode) and the whole delay, for samples a stride apart.

    Between the samples of a coarse run h is a straight line, modes above FASTEST respond at once, and the input at
    sample k, held for a stride, is h at k + ahead, which makes the response to a ramp exact:

        ahead = 1 / (1 - a) + 1 / ln a - (delay + 1/2) / stride,    a = exp(-stride Ts / lag)

    1/2: an input that is held for a period is half a period behind the ramp.
    """
    period_s, whole = stride * Ts_s, math.floor(delay)
    late = delay - whole
    if stride > 1:
        modes, late = tuple(mode for mode in modes if mode.f_Hz * period_s < FASTEST), 0.0
    stiff = 1.0 - sum(mode.share for mode in modes)
    branches = [Branch(stiff, *_lag(lag_s, None, period_s, late))]
    branches += [Branch(mode.share, *_lag(lag_s, mode, period_s, late)) for mode in modes]
    if stride > 1:
        steps = period_s / lag_s
        ahead = -1.0 / math.expm1(-steps) - 1.0 / steps - (delay + 0.5) / stride
        branches, whole = [_between(branch, ahead) for branch in branches], -math.floor(ahead) - 1
    return tuple(branches), whole


def _between(branch: Branch, ahead: float) -> Branch:
    """The branch, whose last numerator is 0, for an input at k + ahead by straight lines, less floor(ahead) + 1."""
    share = ahead - math.floor(ahead)
    numerator = np.convolve(branch.numerator, [share, 1.0 - share])[: len(branch.numerator)]
    return Branch(branch.share, numerator, branch.denominator)


@functools.lru_cache(maxsize=64)
def _lag(lag_s: float, mode: Mode | None, Ts_s: float, late: float) -> tuple[Floats, Floats]:
    """Transfer function in z of lag (and mode) behind a zero-order hold, late by `late` < 1 samples.

    Over one period the older held value acts for late * Ts, then the newer one:
        x(k+1) = Phi x(k) + G_new h(k) + G_old h(k-1),   y = c x
    """
    if mode is None:
        a, a_new = math.exp(-Ts_s / lag_s), math.exp(-(1.0 - late) * Ts_s / lag_s)
        # The older value acts for the first late * Ts of the period and decays until the end.
        return np.array([0.0, 1.0 - a_new, a_new - a]), np.array([1.0, -a, 0.0])
    w = 2.0 * math.pi * mode.f_Hz
    A = np.array(
        [[-1.0 / lag_s, 1.0 / lag_s, mode.early_s / lag_s], [0.0, 0.0, 1.0], [0.0, -w * w, -2.0 * mode.zeta * w]]
    )
    b = np.array([0.0, 0.0, w * w])
    whole, part = _held(A, b, Ts_s), _held(A, b, (1.0 - late) * Ts_s)
    phi, g_new = whole[0], part[1]
    g_old = whole[1] - g_new
    denominator = np.real(np.poly(np.linalg.eigvals(phi)))
    numerator = np.zeros(5)
    for g, step in ((g_new, 0), (g_old, 1)):
        # Markov parameters of (phi, g, c) times the denominator give the numerator.
        pulse, state = np.zeros(3), g
        for i in range(3):
            pulse[i] = state[0]
            state = phi @ state
        numerator[1 + step : 4 + step] += np.convolve(pulse, denominator)[:3]
    return numerator, np.append(denominator, 0.0)


def _held(A: Floats, b: Floats, t_s: float) -> tuple[Floats, Floats]:
    """(exp(A t), integral of exp(A s) b ds over 0..t)."""
    size = len(b)
    block = np.zeros((size + 1, size + 1))
    block[:size, :size], block[:size, size] = A, b
    e = np.asarray(expm(block * t_s))
    return e[:size, :size], e[:size, size]


Rows = NDArray[np.intp]
Samples = NDArray[np.int64]


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


_NONE: Samples = np.zeros(0, dtype=np.int64)
NO_HISTORY = History(np.zeros(0), _NONE, np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.intp))


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

    def time_s(self, Ts_s: float, samples: Rows | None = None) -> Floats:
        """(n,) time since the start of the segment; of some samples, (k,), if they are given."""
        at = np.arange(len(self.u_V)) if samples is None else samples
        return np.asarray(Ts_s * (self.history.samples + self.stride * at.astype(np.float64)))


@dataclass(frozen=True, eq=False)
class Driven:
    """Signals of h that drive the linear part in a run.

    signals: (m, k + n) in k samples of the history and in the run; h: (m, n) in the run. before: (m, 1 + a) at the
    start of the segment, where h was constant until then, and at the samples that stand for the intervals of ages.
    mean: (m, n) from each sample to the next, of a coarse run.
    """

    signals: Floats
    h: Floats
    before: Floats
    mean: Floats

    @classmethod
    def of(cls, run: Trace, signals: Floats) -> Driven:
        h, before = np.ascontiguousarray(signals[:, len(run.history) :]), signals[:, :1]
        if len(run.history):
            before = signals[:, np.append(0, run.history.stand_for)]
        mean = h if run.stride == 1 else h + run.share * np.diff(h, axis=1, append=h[:, -1:])
        return cls(signals, h, before, mean)

    @property
    def nbytes(self) -> int:
        """Size of the arrays."""
        return sum(array.nbytes for array in {id(array): array for array in vars(self).values()}.values())


@dataclass(frozen=True, eq=False)
class Moments:
    """Some samples of a run, (k,): the argument of `Part.columns` where they depend on time alone (`Part.timed`)."""

    run: Trace
    samples: Rows

    @property
    def u_V(self) -> Floats:
        return self.run.u_V[self.samples]

    @property
    def aux(self) -> Mapping[str, Floats]:
        return {name: channel[self.samples] for name, channel in self.run.aux.items()}

    @property
    def whole(self) -> int:
        return self.run.whole

    @property
    def stride(self) -> int:
        return self.run.stride

    def time_s(self, Ts_s: float) -> Floats:
        """(k,) time since the start of the segment."""
        return self.run.time_s(Ts_s, self.samples)
