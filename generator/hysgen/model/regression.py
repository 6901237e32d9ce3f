"""The model as a linear regression: memberships, inputs over a record, and regressors in chunks of rows.

    y(k+1) = x(k)' theta,   x(k) = [p_1 y, p_1 u, p_1, p_2 y, ..., phi_1(k), phi_2(k), ...]

with p_l at the measured y(k), Eq. (9), and phi the regressors of the terms. A pair (k, k+1) never spans two segments.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import RecordError
from hysgen.machine.kernels import rule_rows
from hysgen.machine.reproducible import exponential, total
from hysgen.model.disturbances import Drive, Term
from hysgen.model.intervals import Interval
from hysgen.model.path import InputBlock, applied, path_range
from hysgen.record import Record, Segment

if TYPE_CHECKING:
    from hysgen.model.model import Grid, Model


Floats = NDArray[np.float64]
Trust = Sequence[Floats]
"""One array per segment: the weight of each sample; 0 excludes it."""

Starts = Sequence[Mapping[str, Floats]]
"""One mapping per segment: the state of a term before sample 0, by its kind; other terms start at rest."""

ROWS_PER_CHUNK = 8192
"""Rows per chunk: a few megabytes, independent of the length of the record."""


@dataclass(frozen=True)
class Rows:
    """Consecutive rows of the regression: regressors (m, p), target y(k+1) (m,) in um, and weights (m,)."""

    regressors: Floats
    target_um: Floats
    trust: Floats


@dataclass(frozen=True)
class Structure:
    """A model without its linear parameters: partition, input range, terms and input blocks."""

    grid: Grid
    u_min_V: float
    u_max_V: float
    terms: tuple[Term, ...] = ()
    blocks: tuple[InputBlock, ...] = ()

    @property
    def size(self) -> int:
        """Number of linear parameters, 3 L + T."""
        return 3 * self.grid.rules + sum(term.size for term in self.terms)

    @property
    def w_range(self) -> Interval:
        """Range of w, the input of the rules behind all blocks, see `path_range`."""
        return path_range(self.blocks, Interval(self.u_min_V, self.u_max_V))

    @property
    def range_um(self) -> tuple[float, float, float, float]:
        """The partition as an argument of the kernels: y_min, y_max, step and first centre."""
        return (self.grid.y_min_um, self.grid.y_max_um, self.grid.step_um, self.grid.ends_um[0])


def structure_of(model: Model) -> Structure:
    """The structure of `model`."""
    return Structure(model.grid, model.u_min_V, model.u_max_V, model.terms, model.blocks)


def drive_of(segment: Segment, Ts_s: float, structure: Structure, start: Mapping[str, Floats] | None = None) -> Drive:
    """The inputs of rules and terms over a segment: the input after the blocks, the channels, and the time.

    The input is limited to the model's range and passed through its blocks, from rest under u(0).
    start: states of terms before the first sample, where they are known.
    Raises RecordError if a sample is not finite.
    """
    if not (np.isfinite(segment.u_V).all() and np.isfinite(segment.y_um).all()):
        raise RecordError(f"segment {segment.name}: holds numbers that are not finite; cut those rows out")
    u_V = np.clip(segment.u_V, structure.u_min_V, structure.u_max_V)
    v_V = np.ascontiguousarray(applied(structure.blocks, u_V, Ts_s, structure.w_range, start, segment.aux))
    return Drive(v_V, Ts_s, segment.aux, first=round(segment.start_s / Ts_s), start=start or {})


def drives_of(record: Record, structure: Structure, starts: Starts | None = None) -> list[Drive]:
    """`drive_of` for every segment of a record; the blocks have passed through the known past of a segment."""
    known = starts or [{}] * len(record.segments)
    drives = []
    for segment, start in zip(record.segments, known, strict=True):
        drive = drive_of(segment.whole(), record.Ts_s, structure, start)
        past = segment.past_samples
        if past:
            aux = {key: values[past:] for key, values in drive.aux.items()}
            drive = replace(drive, u_V=drive.u_V[past:].copy(), aux=aux, first=drive.first + past)
        drives.append(drive)
    return drives


def term_regressors(terms: Sequence[Term], drive: Drive) -> Floats:
    """(n, T) regressors phi_j(k) of all terms side by side, C-contiguous. They act on y(k+1)."""
    out = np.empty((drive.u_V.size, sum(term.size for term in terms)))
    start = 0
    for term in terms:
        out[:, start : start + term.size] = term.regressors(drive)
        start += term.size
    return out


def term_output(model: Model, drive: Drive, kinds: Collection[str] | None = None) -> Floats:
    """w(k) = sum_j theta_j phi_j(k) in um, (n,), of all terms or of those of the given kinds; w(k) adds to y(k+1)."""
    total = np.zeros(drive.u_V.size)
    start = 0
    for term in model.terms:
        if kinds is None or term.kind in kinds:
            total += term.regressors(drive) @ model.weights[start : start + term.size]
        start += term.size
    return total


def full_trust(record: Record) -> list[Floats]:
    """Weight 1 for every sample of the record."""
    return [np.ones(segment.samples) for segment in record.segments]


def regression_rows(
    record: Record,
    structure: Structure,
    trust: Trust | None = None,
    starts: Starts | None = None,
    chunk: int = ROWS_PER_CHUNK,
) -> Iterator[Rows]:
    """The regression of the whole model over a record, `chunk` rows at a time, segment after segment.

    trust: the weight of a row is the product of the weights of its two samples.
    Raises RecordError if a segment is not finite.
    """
    rules = structure.grid.rules
    weights = trust or full_trust(record)
    for segment, weight, drive in zip(record.segments, weights, drives_of(record, structure, starts), strict=True):
        phi = term_regressors(structure.terms, drive)
        for first in range(0, segment.samples - 1, chunk):
            rows = slice(first, min(first + chunk, segment.samples - 1))
            ahead = slice(rows.start + 1, rows.stop + 1)
            regressors = np.empty((rows.stop - rows.start, structure.size))
            rule_rows(structure.range_um, rules, segment.y_um[rows], drive.u_V[rows], regressors)
            regressors[:, 3 * rules :] = phi[rows]
            yield Rows(regressors, segment.y_um[ahead], weight[rows] * weight[ahead])


def memberships(y_um: Floats, grid: Grid) -> Floats:
    """Normalised firing strengths, Eqs (2) and (3).

        p_l(y) = mu_l(y) / sum_j mu_j(y),   mu_l(y) = exp(-(y - c_l)^2 / (2 sigma^2))

    y_um: (n,) displacement, clamped to the grid. Returns (n, L); rows sum to 1.
    """
    distance = (grid.clamp(y_um)[:, None] - grid.centres_um) / grid.step_um
    # The nearest rule has a strength of at least exp(-1/8) inside the grid, so the sum is not zero.
    strength = exponential(-0.5 * distance * distance)
    return np.asarray(strength / total(strength)[:, None])


def membership_slopes(y_um: Floats, grid: Grid) -> Floats:
    """Derivatives dp_l/dy inside the grid, (n, L) in 1/um; rows sum to 0.

    dp_l/dy = p_l (g_l - sum_j p_j g_j),   g_l = -(y - c_l)/sigma^2
    """
    p = memberships(y_um, grid)
    g = -(grid.clamp(y_um)[:, None] - grid.centres_um) / grid.step_um**2
    return np.asarray(p * (g - total(p * g)[:, None]))


def rule_regressors(y_um: Floats, u_V: Floats, grid: Grid) -> Floats:
    """Regressors of the consequents, Eq. (9): [p_1 y, p_1 u, p_1, p_2 y, ...].

    y_um, u_V: (n,). Returns (n, 3 L); y is clamped to the grid here too, so the model is constant in y outside it.
    """
    p = memberships(y_um, grid)
    y = grid.clamp(y_um)
    return np.stack([p * y[:, None], p * u_V[:, None], p], axis=2).reshape(len(y), 3 * grid.rules)
