"""What a model leaves of a record, less what no model can know before the record: its own figure beside the cold one.

    y - yhat = sum over groups G of B_G a_G + what the model leaves        least squares on the scored rows of a segment

    past        1, the free responses of the path (`InputBlock.free_responses`)
    periodic    cos, sin of each line: its phase in this record
    drift       its courses, about their means        aging       t yhat, about its mean
    jump        1 from one row on                     gain step   1 and yhat from one row on
    outliers    rows that no motion explains (`outlier_flags`), which are not counted

Structure and parameters of the model are held. A group is limited to what the model or the diagnosis names (`Named`);
jumps, gain steps and outliers are named by the rows themselves. A group takes nothing out unless its evidence is at
least LEAST_EVIDENCE:

    evidence = N ln(S without / S with) - p ln N,    N = rows / `dispersion`

S: sum of squares, p: independent columns. A sudden change must also show at once: beside a straight line, the
prediction and its square, in the rows around it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.model.disturbances.drift import Drift
from hysgen.model.disturbances.periodic import Periodic
from hysgen.model.residual import BLOCKS, dispersion, outlier_flags, residual_noise
from hysgen.record.series import resolution_um

Floats = NDArray[np.float64]

LEAST_SHARE = 0.5
"""Least share of a sudden change that shows in the rows around it, and largest excess over it."""


def falls_from_each_row(effect: Floats, error: Floats, basis: Floats, barred: Iterable[int], least: float) -> Floats:
    """(n,) fall of the sum of squares by a change at each row; -1 within a block of either end and of `barred` rows.

    effect, error: (n,), the effect before it is cut off; basis: (p, n) orthonormal columns. A block is a 40th of the
    rows, because errors are judged by blocks of this length. least: of H P H, as a part of its largest value.
    """
    n = len(error)
    free = from_each_row(effect**2)
    for column in basis:
        free = free - from_each_row(effect * column) ** 2
    falls = from_each_row(effect * error) ** 2 / np.maximum(free, least * free.max() + 1e-300)
    for row in (0, n, *barred):
        falls[max(row - n // BLOCKS - 1, 0) : row + n // BLOCKS + 1] = -1.0
    return np.asarray(falls)


def from_each_row(values: Floats) -> Floats:
    """Sums of the last axis from each row to the end."""
    return np.asarray(np.cumsum(values[..., ::-1], axis=-1)[..., ::-1])


@dataclass(frozen=True)
class Near:
    """A change in the few rows around it.

    share: of the change of the whole fit. power_um2: sum of squares of what the smooth columns do not explain of it;
    left_um2: that of what the change leaves there, on `count` rows.
    """

    share: float
    power_um2: float
    left_um2: float
    count: int

    @classmethod
    def of(cls, effect: Floats, error: Floats, smooth: Floats) -> Self:
        """effect: (m,) of the change; error: (m,) without it; smooth: (p, m) columns that resemble no change."""
        columns = (smooth / (np.linalg.norm(smooth, axis=1, keepdims=True) + 1e-300)).T
        both = np.stack([effect, error], axis=1)
        own, rest = (both - columns @ np.linalg.lstsq(columns, both, rcond=None)[0]).T
        power = float(own @ own) + 1e-300
        share = float(own @ rest) / power
        rest = rest - share * own
        return cls(share, power, float(rest @ rest), len(rest))

    def evidence(self, noise_um: float) -> float:
        """2 ln of the likelihood ratio for the change by these rows alone; 0 where its size is not that of the fit."""
        if abs(self.share - 1.0) > LEAST_SHARE:
            return 0.0
        return self.count * math.log1p(self.share**2 * self.power_um2 / max(self.left_um2, self.count * noise_um**2))


if TYPE_CHECKING:
    from hysgen.model.model import Model
    from hysgen.model.path import InputBlock

Flags = NDArray[np.bool_]
Course = Callable[[Floats, Floats], Floats]
"""Courses of a slow change, (n,) or (p, n), of the time in the segment and of the prediction, (n,) each."""

LEAST_EVIDENCE = 2.0 * math.log(99.0)
"""Least evidence of a cause: odds of 99, so that one name in 100 is wrong if the odds are right."""

UNLIKELY = 18.4
"""2 ln of the odds against a sudden change before the record: once a day, in a record of ten seconds."""

MOST_CHANGES, FEWEST = 8, 200
"""Sudden changes of a segment that are searched for, and the least rows of a search."""

FEWEST_AROUND = 24
"""Least rows on each side of a sudden change, for four smooth columns and the change."""

DEPENDENT = 0.03
"""Singular value of columns of length 1 below which they do not count as independent."""


@dataclass(frozen=True)
class Named:
    """What may be taken out of the error of a model.

    blocks: its path, whose state before the record is unknown. lines_Hz: its disturbing lines. courses: the slow
    changes of the displacement, by the cause that names them. level: whether its level is that of the record it was
    fitted to, as that of a path is, and no state that the rules forget.
    """

    blocks: tuple[InputBlock, ...] = ()
    lines_Hz: tuple[float, ...] = ()
    courses: tuple[tuple[str, Course], ...] = ()
    level: bool = False

    @classmethod
    def of(cls, model: Model) -> Self:
        """What a model names itself."""
        lines = (term.f_Hz for term in model.terms if isinstance(term, Periodic))
        drifts = tuple(("drift", ramp) for term in model.terms if isinstance(term, Drift))
        blocks = tuple(block for block in model.blocks if block.responds)
        return cls(blocks, next(lines, ()), drifts, bool(blocks or drifts))

    def only(self, causes: Collection[str]) -> Named:
        """The part of some causes: what a better model of the same record shows no evidence of is misfit here, too."""
        courses = tuple((cause, course) for cause, course in self.courses if cause in causes)
        lines_Hz = self.lines_Hz if "periodic" in causes else ()
        return Named(self.blocks if "past" in causes else (), lines_Hz, courses, self.level and "past" in causes)


def ramp(t_s: Floats, predicted_um: Floats) -> Floats:
    """The course of a drift of constant rate."""
    return t_s


@dataclass(frozen=True)
class Taken:
    """What was taken out of one segment: its cause, a description, and its rms over the scored rows.

    rows: places of wrong readings in the segment, which are not counted; empty for any other cause.
    """

    cause: str
    text: str
    segment: int
    rms_um: float
    rows: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Remaining:
    """Per segment: error_um, (n,) yhat - y without what was taken out; counted, (n,) flags of the rows that count.

    sudden_um: (n,) course of the jumps and steps of the gain among what was taken out.
    """

    error_um: tuple[Floats, ...]
    counted: tuple[Flags, ...]
    sudden_um: tuple[Floats, ...]
    taken: tuple[Taken, ...]

    @property
    def rms_um(self) -> float:
        """Rms of the error on the rows that count; NaN if there are none."""
        left = np.concatenate([error[rows] for error, rows in zip(self.error_um, self.counted, strict=True)])
        return math.sqrt(float(np.mean(left * left))) if left.size else math.nan


@dataclass(frozen=True, eq=False)
class _Group:
    """Columns, (p, r) on the scored rows. at: row of a sudden change."""

    cause: str
    label: str
    columns: Floats
    at: int | None = None

    @property
    def orders(self) -> int:
        """Number of independent columns, and one for the row of a sudden change."""
        lengths = np.linalg.norm(self.columns, axis=1, keepdims=True) + 1e-300
        independent = int(np.linalg.matrix_rank(self.columns / lengths, tol=DEPENDENT))
        return independent + (self.at is not None)

    def text(self, amounts: Floats) -> str:
        """The description with its size. amounts: (p,) weights of the columns."""
        course_um = amounts @ self.columns
        if self.cause == "past":
            return f"{self.label}: {course_um[0]:.3g} um on the first scored row, {course_um[-1]:.3g} um on the last"
        if self.cause == "periodic":
            return f"{self.label}: {float(np.hypot(*amounts)):.3g} um off the model's"
        if self.at is None:
            return f"{self.label}: {float(np.ptp(course_um)):.3g} um over the scored rows"
        return f"{self.label} by {amounts[0]:+.3g} um" if len(amounts) == 1 else f"{self.label} by {amounts[1]:+.2%}"


def take_out(
    error_um: Sequence[Floats],
    y_um: Sequence[Floats],
    scored: Sequence[Flags],
    Ts_s: float,
    named: Named,
    beside: Remaining | None = None,
) -> Remaining:
    """What a model leaves of every segment without what no model can know before it.

    error_um: (n,) yhat - y; y_um: (n,) measured; scored: (n,) its scored rows, of each segment. Other rows keep their
    error and do not count. beside: what another model leaves of the same rows; its wrong readings and sudden changes
    are those of the record, and no others are searched for.
    """
    parts = [
        _left_of_segment(number, error, measured_um, rows, Ts_s, named, beside)
        for number, (error, measured_um, rows) in enumerate(zip(error_um, y_um, scored, strict=True))
    ]
    return Remaining(
        tuple(part.error_um[0] for part in parts),
        tuple(part.counted[0] for part in parts),
        tuple(part.sudden_um[0] for part in parts),
        tuple(taken for part in parts for taken in part.taken),
    )


def _left_of_segment(
    number: int, error: Floats, measured_um: Floats, rows: Flags, Ts_s: float, named: Named, beside: Remaining | None
) -> Remaining:
    """`take_out` of one segment."""
    own, counts, sudden, taken = error.copy(), rows.copy(), np.zeros(error.size), list[Taken]()
    at = np.flatnonzero(rows)
    if at.size < FEWEST:
        return Remaining((own,), (counts,), (sudden,), ())
    if beside is None:
        wrong = at[outlier_flags(error[at], resolution_um(measured_um[at]), (measured_um + error)[at])]
    else:
        wrong = at[~beside.counted[number][at]]
        sudden = beside.sudden_um[number]
        own += sudden
    counts[wrong] = False
    at = np.flatnonzero(counts)
    if wrong.size:
        rms_um = math.sqrt(float(error[wrong] @ error[wrong]) / (at.size + wrong.size))
        taken.append(Taken("outliers", f"{wrong.size} wrong readings", number, rms_um, tuple(wrong.tolist())))
    t_s: Floats = Ts_s * at.astype(np.float64)
    left_um, predicted_um = -own[at], (measured_um + error)[at]
    groups = _supported(left_um, _groups(named, t_s, predicted_um), t_s, predicted_um, beside is None)
    for group, part in zip(groups, _amounts(left_um, groups), strict=True):
        course = part @ group.columns
        own[at] += course
        if group.at is not None:
            sudden[at] += course
        text = group.text(part) + (f" (segment {number})" if number else "")
        taken.append(Taken(group.cause, text, number, float(np.sqrt(np.mean(course * course)))))
    return Remaining((own,), (counts,), (sudden,), tuple(taken))


def _groups(named: Named, t_s: Floats, predicted_um: Floats) -> list[_Group]:
    """The groups of columns that are named, on rows at t_s after the start of a segment."""
    groups = []
    if named.level:
        # The sensor's zero may have moved; a free response that fades within a row shows nothing.
        past = [np.ones(t_s.size), *(column for block in named.blocks for column in block.free_responses(t_s))]
        shown = [column for column in past if np.abs(column).sum() > 1.0]
        groups.append(_Group("past", "state before the first row", np.stack(shown)))
    for f_Hz in named.lines_Hz:
        turn = 2.0 * np.pi * f_Hz * t_s
        groups.append(_Group("periodic", f"line at {f_Hz:.6g} Hz", np.stack([np.cos(turn), np.sin(turn)])))
    for cause, course in named.courses:
        columns = np.atleast_2d(course(t_s, predicted_um))
        groups.append(_Group(cause, cause, columns - columns.mean(axis=1, keepdims=True)))
    return groups


def _supported(y_um: Floats, groups: list[_Group], t_s: Floats, predicted_um: Floats, changes: bool) -> list[_Group]:
    """The groups with evidence, and, if `changes`, the sudden changes that the rows show beside them."""
    for _ in range(MOST_CHANGES if changes else 0):
        change = _best_change(y_um, groups, t_s, predicted_um)
        if change is None:
            break
        groups = [*groups, change]
    while groups:
        whole = _left(y_um, groups)
        falls = [
            evidence(_left(y_um, [other for other in groups if other is not group]), whole, group.orders)
            for group in groups
        ]
        least = int(np.argmin(falls))
        if falls[least] >= LEAST_EVIDENCE:
            break
        groups = [group for i, group in enumerate(groups) if i != least]
    return groups


def evidence(without_um: Floats, with_um: Floats, orders: int) -> float:
    """N ln(S without / S with) - p ln N of two errors, (n,) each, the second with `orders` parameters more."""
    independent = max(len(with_um) / dispersion(with_um, without_um - with_um), 2.0)
    ratio = (float(without_um @ without_um) + 1e-300) / (float(with_um @ with_um) + 1e-300)
    return independent * math.log(ratio) - orders * math.log(independent)


def _amounts(y_um: Floats, groups: Sequence[_Group]) -> list[Floats]:
    """The weights of the columns of each group, by least squares."""
    if not groups:
        return []
    columns = np.concatenate([group.columns for group in groups])
    scale = np.sqrt(np.einsum("ij,ij->i", columns, columns)) + 1e-100
    gram = columns @ columns.T / np.outer(scale, scale)
    solved = np.linalg.lstsq(gram, columns @ y_um / scale, rcond=1e-10)[0] / scale
    return np.split(solved, np.cumsum([len(group.columns) for group in groups])[:-1])


def _left(y_um: Floats, groups: Sequence[_Group]) -> Floats:
    """(r,) what the groups do not explain."""
    explained = [part @ group.columns for part, group in zip(_amounts(y_um, groups), groups, strict=True)]
    return np.asarray(y_um - np.sum(explained, axis=0)) if explained else y_um


def _best_change(y_um: Floats, groups: Sequence[_Group], t_s: Floats, predicted_um: Floats) -> _Group | None:
    """The sudden change that lowers the error most beside the groups; None if it is not evident and at once."""
    for at in _candidates(y_um, groups, predicted_um):
        later = (np.arange(t_s.size) >= at).astype(np.float64)
        jump = _Group("jump", f"the displacement jumps at {t_s[at]:.4g} s", later[None], at)
        step = _Group("gain step", f"the gain changes at {t_s[at]:.4g} s", np.stack([later, later * predicted_um]), at)
        by_jump, by_step = (_left(y_um, [*groups, change]) for change in (jump, step))
        change = step if evidence(by_jump, by_step, 1) > LEAST_EVIDENCE else jump
        if _at_once(y_um, [*groups, change], at, predicted_um):
            return change
    return None


def _candidates(y_um: Floats, groups: Sequence[_Group], predicted_um: Floats) -> Iterator[int]:
    """Rows of the jump and of the gain step that lower the sum of squares most, (H e)^2 / (H P H) each.

    No row within a block of either end, or of another change (`falls_from_each_row`).
    """
    error, n = _left(y_um, groups), y_um.size
    columns = np.concatenate([group.columns for group in groups]) if groups else np.zeros((0, n))
    columns /= np.linalg.norm(columns, axis=1, keepdims=True) + 1e-300
    basis = np.linalg.qr(columns.T)[0].T if len(columns) else columns
    barred = [group.at for group in groups if group.at is not None]
    for direction in (np.ones(n), predicted_um - predicted_um.mean()):
        falls = falls_from_each_row(direction, error, basis, barred, 1e-3)
        if falls.max() > 0.0:
            yield int(np.argmax(falls))


def _at_once(y_um: Floats, groups: Sequence[_Group], at: int, predicted_um: Floats) -> bool:
    """Whether the last group, a change at row `at`, shows as large in the rows around it, where no bend resembles it.

    Beside a straight line, the prediction and its square; the likelihood must outweigh the choice of the row, and that
    sudden changes are rare.
    """
    error, change = _left(y_um, groups), _amounts(y_um, groups)[-1] @ groups[-1].columns
    n, noise_um = y_um.size, max(residual_noise(error), 1e-300)
    most = n // (2 * BLOCKS)
    size_um = float(np.abs(change[at : at + most]).max(initial=1e-300))
    half = int(min(8.0 * (6.0 * noise_um / size_um) ** 2 + FEWEST_AROUND, most))
    near = slice(max(at - half, 0), at + half)
    effect, found = change[near], error[near] + change[near]
    moved = predicted_um[near] - predicted_um[near].mean()
    smooth = np.stack([np.ones(effect.size), np.linspace(-1.0, 1.0, effect.size), moved, moved**2])
    likelihood = Near.of(effect, found, smooth).evidence(noise_um)
    return likelihood > 2.0 * math.log(n) + UNLIKELY + LEAST_EVIDENCE
