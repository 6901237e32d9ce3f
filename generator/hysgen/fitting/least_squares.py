"""Least squares over a record, one step ahead: in batch, in square-root form, and recursively by Eq. (10) as printed.

    min over q of  sum_k lambda^(N-k) t(k) (y(k+1) - x(k)'q)^2 + lambda^N/alpha ||q - epsilon 1||^2

Both converge to the same q. The batch form keeps the triangular factor [R d; 0 e] of all rows [x' | y]: each chunk of
rows is appended to the factor and the stack is triangularised again. Memory does not grow with the record, and R has
the condition number of the regressors, not its square. Source: Bierman, Factorization Methods for Discrete Sequential
Estimation (1977), chapter IV.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from hysgen.errors import FitError
from hysgen.machine.kernels import rls_updates, triangularise
from hysgen.model.regression import Starts, Structure, Trust, regression_rows
from hysgen.record import Record

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Weighting:
    """How samples and prior count in a least-squares fit.

    forgetting: lambda; a row n places before the last one has the weight lambda^n. alpha: the prior has the weight
    1/alpha, i.e. P(0) = alpha I. epsilon: the prior mean, q(0) = epsilon [1, 1, ...].
    trust: weight t of each sample, one array per segment; 0 excludes a sample. starts: states of the terms before each
    segment, where they are known.
    """

    forgetting: float = 1.0
    alpha: float = 1e6
    epsilon: float = 0.0
    trust: Trust | None = None
    starts: Starts | None = None


UNIFORM = Weighting()
"""Every sample counts once, with the paper's prior."""


@dataclass(frozen=True)
class Information:
    """A sum of squares as a function of the parameters: ||R q - d||^2 + rest^2.

    R: (p, p) upper triangular and d: (p,), where it comes from a record; (n, p) and (n,), where it is a penalty.
    """

    R: Floats
    d: Floats
    rest: float

    def square(self, parameters: Floats) -> float:
        """The sum of squares at these parameters, (p,)."""
        away = self.R @ parameters - self.d
        return float(away @ away) + self.rest**2

    def solve(self) -> Floats:
        """The least-squares parameters, (p,)."""
        return np.asarray(solve_triangular(self.R, self.d))


def information(record: Record, structure: Structure, weighting: Weighting = UNIFORM) -> Information:
    """The square-root information of a record, including the prior."""
    size, forgetting = structure.size, weighting.forgetting
    prior = np.eye(size) / np.sqrt(weighting.alpha)
    factor = np.zeros((size + 1, size + 1))
    factor[:size, :size], factor[:size, size] = prior, weighting.epsilon * prior.sum(axis=1)
    for rows in regression_rows(record, structure, weighting.trust, weighting.starts):
        count = rows.target_um.size
        weight = np.sqrt(rows.trust * forgetting ** np.arange(count - 1.0, -1.0, -1.0))
        block = np.empty((count, size + 1))
        np.multiply(rows.regressors, weight[:, None], out=block[:, :size])
        np.multiply(rows.target_um, weight, out=block[:, size])
        factor *= forgetting ** (0.5 * count)
        triangularise(factor, block)
    return Information(factor[:size, :size].copy(), factor[:size, size].copy(), abs(float(factor[size, size])))


def recursive_least_squares(record: Record, structure: Structure, weighting: Weighting = UNIFORM) -> Floats:
    """q after one pass over all pairs (k, k+1), Eq. (10), from P(0) = alpha I and q(0) = epsilon [1, 1, ...].

        K = P x/(lambda + x'P x),   q += K (y(k+1) - x'q),   P = (I - K x') P/lambda

    Eq. (10) has no weights: rows of trust 0 are skipped, all others count fully.
    Returns (3 L + T,) parameters in the order of Model.parameters. Raises FitError if P is no longer a covariance
    (a negative variance), or if q is not finite.
    """
    q = np.full(structure.size, float(weighting.epsilon))
    P = weighting.alpha * np.eye(structure.size)
    for rows in regression_rows(record, structure, weighting.trust, weighting.starts):
        used = rows.trust > 0.0
        if used.all():
            rls_updates(rows.regressors, rows.target_um, weighting.forgetting, q, P)
        else:
            rls_updates(np.ascontiguousarray(rows.regressors[used]), rows.target_um[used], weighting.forgetting, q, P)
    if not np.isfinite(q).all() or (np.diag(P) < 0.0).any():
        raise FitError(
            f"{record.source}: recursive least squares with forgetting {weighting.forgetting:g} and alpha "
            f"{weighting.alpha:g} lost its covariance; forget less, or fit in batch"
        )
    return q
