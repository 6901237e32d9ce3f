"""The error of the free run over a record, and how it changes with the parameters of a model.

    J(x) = sum_k t(k) (yhat(k; x) - y(k))^2 + sum_i kappa_i ||R_i x - d_i||^2

    yhat(k+1) = f(yhat(k), u(k); x) + w(k; x),   yhat(0) = y(0)

Quadratic forms in the linear parameters hold what the scored part of a free run leaves open: a little of the one-step
error as `least_squares` left it, for rules that were visited only while the state settled, the disagreement of the
rules, and how rough the densities are that terms stand for, see `spread`.

A run depends on the terms through w(k) = theta . phi(k) alone, so a term's weights enter by the columns phi(k), and its
shape parameters by dw/dshape, taken by central differences. `FreeRunError` keeps what does not change between steps.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting.least_squares import Information
from hysgen.fitting.preferences import roughness, spread
from hysgen.machine.cache import LruCache
from hysgen.machine.kernels import FreeRunSums, Rules, free_run_sums
from hysgen.model.model import Model
from hysgen.model.regression import Starts, Structure, Trust, drives_of, full_trust, structure_of, term_regressors
from hysgen.model.terms import Drive, Term
from hysgen.record import Record

Floats = NDArray[np.float64]

ONE_STEP_SHARE = 0.1
"""Part of the free-run error that the one-step error adds at the start."""

SPREAD_SHARE = 1e-3
"""Part of the free-run error that rules add which disagree by one step of the grid."""

SPREAD_BESIDE = 1.0
"""The same beside a term whose weights follow the level of the input: then rules that go ways of their own follow what
this record has, and leave the next one."""

ROUGH_SHARE = 2.5e-5
"""Part of the free-run error that a density over the half-widths adds whose curvature is the gain per half range."""

SETTLING_TRUST = 0.03
"""What a sample counts while the terms' unknown start still shows: enough to hold rules that are visited only then."""

SHAPE_STEP = 1e-4
"""Step of the central differences; shape parameters are logarithms or of that size."""


@dataclass(frozen=True)
class Criterion:
    """J, half its gradient (p,) and the Gauss-Newton half of its second derivative (p, p); rms_um: of the free run."""

    value: float
    gradient: Floats
    hessian: Floats
    rms_um: float


@dataclass(frozen=True)
class FreeRunError:
    """J over a record.

    trust: weight of each sample, by segment; 0 where it is not scored.
    shaped: kinds of terms whose shape parameters may move, in the order of the model's terms.
    held: quadratic forms that hold the linear parameters, with their weights kappa.
    columns: phi of the terms over each segment; only shape parameters change them.
    """

    record: Record
    drives: tuple[Drive, ...]
    trust: tuple[Floats, ...]
    shaped: frozenset[str] = frozenset()
    held: tuple[tuple[float, Information], ...] = ()
    columns: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(1))

    def held_near(self, model: Model, one_step: Information) -> FreeRunError:
        """The same error with the forms, weighted by the free-run error of `model`.

        There the one-step error makes up ONE_STEP_SHARE of it, rules that disagree by a step of the grid SPREAD_SHARE
        (SPREAD_BESIDE where a term follows the level), and densities as rough as the gain ROUGH_SHARE.
        """
        free, single = self.sums(model).square_um2, one_step.square(model.parameters)
        structure = structure_of(model)
        rough = roughness(structure)
        share = SPREAD_BESIDE if len(rough.R) else SPREAD_SHARE
        forms = [(share * free / model.grid.step_um**2, spread(structure))]
        if len(rough.R):
            forms.append((ROUGH_SHARE * free / float(np.mean(model.consequents[:, 1])) ** 2, rough))
        if single > 0.0:
            forms.append((ONE_STEP_SHARE * free / single, one_step))
        return dataclasses.replace(self, held=tuple(forms))

    def criterion(self, model: Model) -> Criterion:
        """J and its derivatives at a model; x holds model.parameters and then the shapes of the `shaped` terms."""
        sums = self.sums(model)
        value, gradient, hessian = sums.square_um2, sums.gradient, sums.hessian
        size = model.parameters.size
        for kappa, form in self.held:
            value += kappa * form.square(model.parameters)
            gradient[:size] += kappa * form.R.T @ (form.R @ model.parameters - form.d)
            hessian[:size, :size] += kappa * form.R.T @ form.R
        return Criterion(value, gradient, hessian, sums.rms_um)

    def sums(self, model: Model) -> FreeRunSums:
        """The free run's own sums over all segments."""
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
        """`model` with x changed by `step`; shapes stay between their bounds."""
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
        """dw/dshape, one (n,) column per shape parameter that may move."""
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
    """The error over a record of models with this structure.

    settle: samples at the start of each segment that are not scored. None: until the terms have forgotten how they
    started, but at most a quarter of the segment, samples count only SETTLING_TRUST.
    """
    drives = drives_of(record, structure, starts)
    weights = []
    for drive, weight in zip(drives, trust or full_trust(record), strict=True):
        scored = weight.copy()
        if settle is not None:
            scored[:settle] = 0.0
        else:
            # A term that never forgets must not silence the record.
            forgotten = max((term.settled(drive) for term in structure.terms), default=0)
            scored[: min(forgotten, drive.u_V.size // 4)] *= SETTLING_TRUST
        weights.append(scored)
    return FreeRunError(record, tuple(drives), tuple(weights), frozenset(shaped))
