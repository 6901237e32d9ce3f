"""The free-run error over a record, with its gradient and Gauss-Newton Hessian in the parameters of a model.

    J(x) = sum_k t(k) (yhat(k; x) - y(k))^2 + sum_i kappa_i ||R_i x - d_i||^2

    yhat(k+1) = f(yhat(k), u(k); x) + w(k; x),   yhat(0) = y(0)

The quadratic penalties hold linear parameters that the scored part of a free run does not determine, see
`regularisation`. The run depends on the terms through w(k) = theta . phi(k) alone: the derivatives by a term's weights
are the columns phi(k), those by its shape parameters are dw/dshape, computed by central differences.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting.least_squares import Information
from hysgen.fitting.regularisation import Penalties, penalties_at
from hysgen.machine.cache import LruCache
from hysgen.machine.kernels import FreeRunSums, Rules, free_run_sums
from hysgen.model.model import Model
from hysgen.model.regression import Starts, Structure, Trust, drives_of, full_trust, structure_of, term_regressors
from hysgen.model.terms import Drive, Term
from hysgen.record import Record

Floats = NDArray[np.float64]

BURN_IN_TRUST = 0.03
"""Weight of samples that still depend on the terms' unknown initial state: it holds rules that only they visit."""

SHAPE_STEP = 1e-4
"""Step of the central differences; shape parameters are logarithms, or numbers of the order of 1."""


@dataclass(frozen=True)
class Criterion:
    """J, half its gradient (p,), half its Gauss-Newton Hessian (p, p), and the rms error of the free run."""

    value: float
    gradient: Floats
    hessian: Floats
    rms_um: float


@dataclass(frozen=True)
class FreeRunError:
    """J over a record, for models of one structure.

    trust: weight of each sample, by segment; 0 where it is not scored.
    shaped: kinds of terms whose shape parameters are varied, in the order of the model's terms.
    columns: cache of phi over each segment, which depends on shape parameters only.
    """

    record: Record
    drives: tuple[Drive, ...]
    trust: tuple[Floats, ...]
    shaped: frozenset[str] = frozenset()
    penalties: Penalties = ()
    columns: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(1))

    def penalised(self, model: Model, one_step: Information) -> FreeRunError:
        """The same error with penalties, scaled by the free-run error of `model`."""
        return dataclasses.replace(self, penalties=penalties_at(model, self.sums(model).square_um2, one_step))

    def criterion(self, model: Model) -> Criterion:
        """J and its derivatives at a model; x is model.parameters followed by the shapes of the `shaped` terms."""
        sums = self.sums(model)
        value, gradient, hessian = sums.square_um2, sums.gradient, sums.hessian
        size = model.parameters.size
        for kappa, form in self.penalties:
            value += kappa * form.square(model.parameters)
            gradient[:size] += kappa * form.R.T @ (form.R @ model.parameters - form.d)
            hessian[:size, :size] += kappa * form.R.T @ form.R
        return Criterion(value, gradient, hessian, sums.rms_um)

    def sums(self, model: Model) -> FreeRunSums:
        """Sums over the free run of all segments, without the penalties."""
        rules = Rules(structure_of(model).range_um, model.consequents)
        columns = self.columns.get(model.terms, lambda: [term_regressors(model.terms, drive) for drive in self.drives])
        total: FreeRunSums | None = None
        for segment, drive, trust, phi in zip(self.record.segments, self.drives, self.trust, columns, strict=True):
            extra = np.column_stack([phi, *self._shape_columns(model, drive)]) if self.shaped else phi
            part = free_run_sums(rules, drive.u_V, phi @ model.weights, extra, segment.y_um, trust)
            total = part if total is None else total + part
        assert total is not None
        return total

    def moved(self, model: Model, step: Floats) -> Model:
        """`model` at x + step; shape parameters are clipped to their bounds."""
        size = model.parameters.size
        parameters = model.parameters + step[:size]
        terms, at = [], size
        for term in model.terms:
            if term.kind in self.shaped:
                count = term.shape().size
                low, high = self._bounds(term)
                term = term.with_shape(np.clip(term.shape() + step[at : at + count], low, high))
                at += count
            terms.append(term)
        return dataclasses.replace(model, terms=tuple(terms)).with_parameters(parameters)

    def _bounds(self, term: Term) -> tuple[Floats, Floats]:
        longest = max(self.drives, key=lambda drive: drive.u_V.size)
        return term.shape_bounds(longest)

    def _shape_columns(self, model: Model, drive: Drive) -> list[Floats]:
        """dw/dshape, one (n,) column per varied shape parameter."""
        columns, start = [], 0
        for term in model.terms:
            theta = model.weights[start : start + term.size]
            start += term.size
            if term.kind not in self.shaped:
                continue
            shape = term.shape()
            low, high = self._bounds(term)
            for i in range(shape.size):
                ends = [shape.copy(), shape.copy()]
                ends[0][i] = max(shape[i] - SHAPE_STEP, low[i])
                ends[1][i] = min(shape[i] + SHAPE_STEP, high[i])
                runs = [term.with_shape(end).regressors(drive) @ theta for end in ends]
                columns.append((runs[1] - runs[0]) / (ends[1][i] - ends[0][i]))
        return columns


def free_run_error(
    record: Record,
    structure: Structure,
    settle: int | None = None,
    trust: Trust | None = None,
    starts: Starts | None = None,
    shaped: Sequence[str] = (),
) -> FreeRunError:
    """The free-run error over a record for models with this structure.

    settle: burn-in in samples, not scored. None: samples have the weight BURN_IN_TRUST until the terms no longer depend
    on their initial state, but at most for a quarter of the segment. shaped: kinds whose shape parameters are varied.
    """
    drives = drives_of(record, structure, starts)
    weights = []
    for drive, weight in zip(drives, trust or full_trust(record), strict=True):
        scored = weight.copy()
        if settle is not None:
            scored[:settle] = 0.0
        else:
            # At most a quarter: a term that keeps its initial state for ever must not take the weight of all samples.
            forgotten = max((term.burn_in(drive) for term in structure.terms), default=0)
            scored[: min(forgotten, drive.u_V.size // 4)] *= BURN_IN_TRUST
        weights.append(scored)
    return FreeRunError(record, tuple(drives), tuple(weights), frozenset(shaped))
