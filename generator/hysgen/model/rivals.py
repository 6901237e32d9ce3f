"""Rival models of the paper, fitted and scored on the same records by the same functions as the model.

    Prandtl-Ishlinskii (section 4.1)   yhat(k) = c + sum_j w_j z_j(k),  z_j plays, half-widths uniform in [0, max(u)/2]
    proportional (section 4.3)         yhat(k) = u(k)/K + c;  its inverse u = K (y - c) is the proportional feed-forward
    ARX                                yhat(k) = sum_i a_i yhat(k-i) + sum_j b_j u(k-j-d) + c

All parameters by least squares, those of ARX on the one-step error. All scores are of free runs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import FitError
from hysgen.machine.kernels.operators import play_operators
from hysgen.model.scores import Score, score_prediction
from hysgen.record import Record

Floats = NDArray[np.float64]

PAPER_PLAYS = 20


class Rival(Protocol):
    """A fitted rival model."""

    @property
    def name(self) -> str:
        """Its name in tables."""
        ...

    def free_run(self, record: Record) -> list[Floats]:
        """The free run over every segment, (n,) each."""
        ...


@dataclass(frozen=True)
class PrandtlIshlinskii:
    """yhat = offset + sum_j weights_j play_j(u); thresholds_V, weights_um_per_V: (n,)."""

    thresholds_V: Floats
    weights_um_per_V: Floats
    offset_um: float

    @property
    def name(self) -> str:
        return f"Prandtl-Ishlinskii, {self.thresholds_V.size} plays"

    def free_run(self, record: Record) -> list[Floats]:
        return [
            self.offset_um
            + _plays(segment.whole().u_V, self.thresholds_V)[segment.past_samples :] @ self.weights_um_per_V
            for segment in record.segments
        ]


@dataclass(frozen=True)
class Proportional:
    """yhat = u/K + c; its inverse is a feed-forward without hysteresis."""

    K_V_per_um: float
    offset_um: float

    @property
    def name(self) -> str:
        return "proportional"

    def free_run(self, record: Record) -> list[Floats]:
        return [segment.u_V / self.K_V_per_um + self.offset_um for segment in record.segments]

    def inverse(self, y_um: Floats) -> Floats:
        """u = K (y - c) in V for a wanted displacement, (n,)."""
        return self.K_V_per_um * (y_um - self.offset_um)


@dataclass(frozen=True)
class Arx:
    """yhat(k) = sum_i a_i yhat(k-i) + sum_j b_j u(k-j-delay) + c; a: (na,), i >= 1; b: (nb,) um/V, j >= 1."""

    a: Floats
    b_um_per_V: Floats
    offset_um: float
    delay: int

    @property
    def name(self) -> str:
        return f"ARX({self.a.size},{self.b_um_per_V.size},{self.delay})"

    @property
    def first(self) -> int:
        """First predicted sample; the samples before are measured ones."""
        return max(self.a.size, self.b_um_per_V.size + self.delay)

    def free_run(self, record: Record) -> list[Floats]:
        from scipy.signal import lfilter, lfiltic  # imports scipy.stats, which takes half a second

        runs = []
        for segment in record.whole().segments:
            n, first = segment.samples, self.first
            drive = np.full(n - first, self.offset_um)
            for j, b in enumerate(self.b_um_per_V, start=1):
                drive += b * segment.u_V[first - j - self.delay : n - j - self.delay]
            denominator = np.concatenate([[1.0], -self.a])
            state = lfiltic([1.0], denominator, segment.y_um[:first][::-1])
            run, _ = lfilter([1.0], denominator, drive, zi=state)
            runs.append(np.concatenate([segment.y_um[:first], run]))
        return [run[past:] for run, past in zip(runs, record.past_samples, strict=True)]


def fit_prandtl_ishlinskii(record: Record, plays: int = PAPER_PLAYS) -> PrandtlIshlinskii:
    """The paper's rival: `plays` half-widths uniform in [0, max(u)/2], weights and an offset by least squares.

    Plays wider than the largest half-amplitude never move; the minimum-norm solution is taken for them.
    Raises FitError if max(u) is not positive: the range of half-widths is empty.
    """
    top = record.u_range_V[1]
    if top <= 0.0:
        raise FitError(f"{record.source}: the voltage is never positive, so [0, max(u)/2] holds no thresholds")
    thresholds = np.linspace(0.0, 0.5 * top, plays)
    rows = np.vstack([_plays(segment.whole().u_V, thresholds)[segment.past_samples :] for segment in record.segments])
    solution = _least_squares(np.column_stack([rows, np.ones(len(rows))]), record.y_um)
    return PrandtlIshlinskii(thresholds, solution[:-1], float(solution[-1]))


def fit_proportional(record: Record) -> Proportional:
    """The straight line y = u/K + c through a record. Raises FitError if the displacement does not rise with u."""
    u = record.u_V
    slope, offset = _least_squares(np.column_stack([u, np.ones(u.size)]), record.y_um)
    if slope == 0.0:
        raise FitError(f"{record.source}: the displacement does not follow the voltage; there is no gain to invert")
    return Proportional(1.0 / float(slope), float(offset))


def fit_arx(record: Record, na: int = 2, nb: int = 2, delay: int = 0) -> Arx:
    """A linear ARX model by least squares one step ahead.

    na, nb >= 1: past outputs and inputs; delay >= 0: further samples before the input acts.
    Raises FitError if the orders are out of range or a segment is shorter than they need.
    """
    first = max(na, nb + delay)
    if min(na, nb) < 1 or delay < 0:
        raise FitError(f"ARX orders {na}, {nb} and delay {delay}: choose na >= 1, nb >= 1, delay >= 0")
    if min(segment.samples for segment in record.segments) <= first + na + nb + 1:
        raise FitError(f"{record.source}: a segment is too short for ARX({na},{nb},{delay}); choose lower orders")
    rows, targets = [], []
    for segment in record.segments:
        n = segment.samples
        past = [segment.y_um[first - i : n - i] for i in range(1, na + 1)]
        drive = [segment.u_V[first - j - delay : n - j - delay] for j in range(1, nb + 1)]
        rows.append(np.column_stack([*past, *drive, np.ones(n - first)]))
        targets.append(segment.y_um[first:])
    solution = _least_squares(np.vstack(rows), np.concatenate(targets))
    return Arx(solution[:na], solution[na : na + nb], float(solution[-1]), delay)


def fit_rivals(record: Record, plays: int = PAPER_PLAYS, arx: tuple[int, int, int] = (2, 2, 0)) -> list[Rival]:
    """All rivals, fitted to one record. Raises FitError as the single fits do."""
    return [fit_prandtl_ishlinskii(record, plays), fit_proportional(record), fit_arx(record, *arx)]


def score_rivals(rivals: Sequence[Rival], record: Record, settle: int | Sequence[int] = 0) -> list[tuple[str, Score]]:
    """Name and free-run score of each rival on a record. settle: as for `score_prediction`."""
    return [(rival.name, score_prediction(record, rival.free_run(record), settle)) for rival in rivals]


def _plays(u_V: Floats, thresholds_V: Floats) -> Floats:
    """(n, m) play outputs after u(k) acts, initially centred on u(0)."""
    return play_operators(u_V, thresholds_V, np.full(thresholds_V.size, u_V[0]))


def _least_squares(rows: Floats, target: Floats) -> Floats:
    """The minimum-norm least-squares solution, (p,)."""
    return np.asarray(np.linalg.lstsq(rows, target, rcond=None)[0], dtype=np.float64)
