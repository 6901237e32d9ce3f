"""The free-run error over a record, with its gradient and Gauss-Newton Hessian in the parameters of a model.

    J(x) = sum_k t(k) (yhat(k; x) - y(k))^2 + sum_i kappa_i ||R_i x - d_i||^2

    yhat(k+1) = f(yhat(k), u(k); x) + w(k; x),   yhat(0) = y(0)

The quadratic penalties hold linear parameters that the scored part of a free run does not determine, see
`regularisation`. The derivatives of the added w(k) = theta . phi(k) by the weights are the columns phi(k).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hysgen.fitting.least_squares import Information
from hysgen.fitting.regularisation import Penalties, penalties_at
from hysgen.fitting.windows import windows
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

        Of a long record, windows are run (`windows`), each from the displacement measured at its start; the terms run
        through the whole record.
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
