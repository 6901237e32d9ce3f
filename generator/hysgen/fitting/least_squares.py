"""Batch least squares over a record in square-root form: what Eq. (10) converges to, without squaring the condition.

    min over q of  sum_k lambda^(N-k) t(k) (y(k+1) - x(k)'q)^2 + lambda^N/alpha ||q - epsilon 1||^2

The triangular factor [R d; 0 e] of all rows [x' | y] seen so far stands for them; a chunk of rows is put under it and
the stack is triangularised again. Memory does not grow with the record, and R carries the condition of the
regressors, not its square. Source: Bierman, Factorization Methods for Discrete Sequential Estimation (1977), chapter
IV.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from hysgen.machine.kernels import triangularise
from hysgen.model.regression import Starts, Structure, Trust, regression_rows
from hysgen.record import Record

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Information:
    """What a record tells about the parameters: sum of squares = ||R q - d||^2 + rest^2.

    R: (p, p) upper triangular and d: (p,) of a record; (n, p) and (n,) of what is wanted besides.
    """

    R: Floats
    d: Floats
    rest: float

    def square(self, parameters: Floats) -> float:
        """The sum of squares at these parameters, (p,)."""
        away = self.R @ parameters - self.d
        return float(away @ away) + self.rest**2

    def solve(self) -> Floats:
        """The parameters of least squares, (p,)."""
        return np.asarray(solve_triangular(self.R, self.d))


def information(
    record: Record,
    structure: Structure,
    forgetting: float = 1.0,
    alpha: float = 1e6,
    epsilon: float = 0.0,
    trust: Trust | None = None,
    starts: Starts | None = None,
) -> Information:
    """The square-root information of a record, the prior of weight 1/alpha included.

    forgetting: lambda; a row n places before the last counts lambda^n. trust: weights of samples, by segment.
    starts: states of the terms before each segment, where they are known.
    """
    size = structure.size
    prior = np.eye(size) / np.sqrt(alpha)
    factor = np.zeros((size + 1, size + 1))
    factor[:size, :size], factor[:size, size] = prior, epsilon * prior.sum(axis=1)
    for rows in regression_rows(record, structure, trust, starts):
        count = rows.target_um.size
        weight = np.sqrt(rows.trust * forgetting ** np.arange(count - 1.0, -1.0, -1.0))
        block = np.empty((count, size + 1))
        np.multiply(rows.regressors, weight[:, None], out=block[:, :size])
        np.multiply(rows.target_um, weight, out=block[:, size])
        factor *= forgetting ** (0.5 * count)
        triangularise(factor, block)
    return Information(factor[:size, :size].copy(), factor[:size, size].copy(), abs(float(factor[size, size])))
