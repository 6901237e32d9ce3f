"""Refinement of the free-run error: its gradient and Hessian, and Gauss-Newton steps inside the certified set.

    min over x of  J(x) = sum_k t(k) (yhat(k; x) - y(k))^2 + sum_i kappa_i ||R_i x - d_i||^2

    yhat(k+1) = f(yhat(k), u(k); x) + w(k; x),   yhat(0) = y(0);   x: the linear parameters

A step d minimises g'd + d'H d/2 + mu d'D d/2 with H = sum t S S', g = sum t S e from exact sensitivities S (Levenberg
and Marquardt: D = diag H, mu grows until J falls), subject to the half-spaces of `certified`. A step is accepted if it
lowers J and keeps every certificate that held. J also contains penalties, so the free-run error may rise between steps,
by at most a tenth of its value at the start. If it ends above the start, the refinement is repeated with no rise
allowed: the result is never worse than the start.

The quadratic penalties hold linear parameters that the scored part of a free run does not determine, see
`least_squares`. The derivatives of the added w(k) = theta . phi(k) by the weights are the columns phi(k).
"""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from hysgen.certify.certificates import certify
from hysgen.fitting.least_squares import (
    CertifiedSet,
    HalfSpaces,
    Information,
    Penalties,
    least_squares_inside,
    penalties_at,
    windows,
)
from hysgen.machine.cache import LruCache
from hysgen.machine.kernels import FreeRunSums, Rules, free_run_sums
from hysgen.model.disturbances import Drive
from hysgen.model.model import Model
from hysgen.model.regression import Starts, Structure, Trust, drives_of, full_trust, structure_of, term_regressors
from hysgen.record import Record

Floats = NDArray[np.float64]

BURN_IN_TRUST = 0.03
"""Weight of samples that still depend on the terms' unknown initial state: it holds rules that only they visit."""


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
    columns: cache of phi over each segment, by the terms.
    """

    record: Record
    drives: tuple[Drive, ...]
    trust: tuple[Floats, ...]
    penalties: Penalties = ()
    columns: LruCache[list[Floats]] = field(default_factory=lambda: LruCache(1))

    def penalised(self, model: Model, one_step: Information) -> FreeRunError:
        """The same error with penalties, scaled by the free-run error of `model`."""
        return dataclasses.replace(self, penalties=penalties_at(model, self.sums(model).square_um2, one_step))

    def criterion(self, model: Model) -> Criterion:
        """J and its derivatives at a model; x is model.parameters."""
        sums = self.sums(model)
        value, gradient, hessian = sums.square_um2, sums.gradient, sums.hessian
        for kappa, form in self.penalties:
            value += kappa * form.square(model.parameters)
            gradient += kappa * form.R.T @ (form.R @ model.parameters - form.d)
            hessian += kappa * form.R.T @ form.R
        return Criterion(value, gradient, hessian, sums.rms_um)

    def sums(self, model: Model) -> FreeRunSums:
        """Sums over the free run of all segments, without the penalties.

        Of a long record, windows are run (`least_squares.windows`), each from the displacement measured at its start;
        the terms run through the whole record.
        """
        rules = Rules(structure_of(model).range_um, model.consequents)
        columns = self.columns.get(model.terms, lambda: [term_regressors(model.terms, drive) for drive in self.drives])
        total: FreeRunSums | None = None
        for segment, drive, trust, phi in zip(self.record.segments, self.drives, self.trust, columns, strict=True):
            added = phi @ model.weights
            for at in windows(len(trust), self.record.samples):
                part = free_run_sums(rules, drive.u_V[at], added[at], phi[at], segment.y_um[at], trust[at])
                total = part if total is None else total + part
        assert total is not None
        return total


def free_run_error(
    record: Record,
    structure: Structure,
    settle: int | None = None,
    trust: Trust | None = None,
    starts: Starts | None = None,
) -> FreeRunError:
    """The free-run error over a record for models with this structure.

    settle: burn-in in samples, not scored. None: samples have the weight BURN_IN_TRUST until the terms no longer depend
    on their initial state, but at most for a quarter of the segment.
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
    return FreeRunError(record, tuple(drives), tuple(weights))


Progress = Callable[[float, str], None]

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-9, 1e7
MOST_WORSE = 1.1
"""Largest free-run error between start and result, as a multiple of the error at the start."""
LEAST_FALL = 1e-6
"""Relative fall of J below which the refinement ends."""


@dataclass(frozen=True)
class Refined:
    """The refined model, its criterion, and the number of accepted steps."""

    model: Model
    criterion: Criterion
    steps: int


def refine(
    model: Model,
    error: FreeRunError,
    allowed: CertifiedSet | None,
    iterations: int = 40,
    progress: Progress | None = None,
) -> Refined:
    """Minimise J from `model` on.

    allowed: the set of certified parameters to stay in, or None for no constraint. iterations: largest number of steps.
    progress: called with the fraction done and one line of text after each step.
    """
    task = _Task(error, allowed, iterations, progress)
    start = error.criterion(model)
    refined = _descend(task, model, start, MOST_WORSE)
    if refined.criterion.rms_um > start.rms_um:
        refined = _descend(task, model, start, 1.0)
    return refined


@dataclass(frozen=True, eq=False)
class _Task:
    """The arguments of `refine` that do not change between its steps."""

    error: FreeRunError
    allowed: CertifiedSet | None
    iterations: int
    progress: Progress | None


def _descend(task: _Task, model: Model, start: Criterion, most_worse: float) -> Refined:
    """Steps from `model`, whose criterion is `start`; the free-run error stays below `most_worse` times the start's."""
    error, allowed = task.error, task.allowed
    now = start
    held = _holding(model, allowed)
    damping = FIRST_DAMPING
    edges: HalfSpaces | None = None
    steps = 0
    for iteration in range(task.iterations):
        moved: tuple[Model, Criterion] | None = None
        while moved is None and damping <= MOST_DAMPING:
            step, edges = _step(now, damping, allowed, model.parameters, edges)
            candidate = model.with_parameters(model.parameters + step)
            trial = error.criterion(candidate)
            better = trial.value < now.value and trial.rms_um <= most_worse * start.rms_um
            if better and all(map(operator.ge, _holding(candidate, allowed), held)):
                moved = candidate, trial
            else:
                damping *= 10.0
        if moved is None:
            break
        fall = 1.0 - moved[1].value / now.value
        model, now = moved
        damping = max(damping / 10.0, LEAST_DAMPING)
        steps += 1
        if task.progress is not None:
            task.progress((iteration + 1) / task.iterations, f"free run {now.rms_um:.4g} um rms after {steps} steps")
        if fall < LEAST_FALL:
            break
    return Refined(model, now, steps)


def _step(
    now: Criterion, damping: float, allowed: CertifiedSet | None, parameters: Floats, edges: HalfSpaces | None
) -> tuple[Floats, HalfSpaces | None]:
    """d = -(H + mu D)^-1 g, constrained to the set; 0 for a parameter that the run does not depend on.

    edges: active half-spaces of the last step. Returns d and the active half-spaces of d.
    """
    scale = np.sqrt(np.diag(now.hessian))
    scale[scale == 0.0] = 1.0
    normal = now.hessian / np.outer(scale, scale) + damping * np.eye(scale.size)
    R = cholesky(normal)
    d = -solve_triangular(R, now.gradient / scale, trans="T")
    if allowed is None:
        return np.asarray(solve_triangular(R, d) / scale), None
    inside = least_squares_inside(R * scale, d, allowed.violated, parameters, edges)
    return inside.x, inside.edges


def _holding(model: Model, allowed: CertifiedSet | None) -> tuple[bool, ...]:
    """Which certificates of the set hold for a model: gain, contraction; () without a set."""
    if allowed is None:
        return ()
    found = certify(model)
    return found.gain_holds, found.contraction_holds
