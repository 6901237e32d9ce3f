"""Recursive least squares over a record, as the paper prints it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import FitError
from hysgen.machine.kernels import rls_updates
from hysgen.model.regression import Starts, Structure, Trust, regression_rows
from hysgen.record import Record

Floats = NDArray[np.float64]


def recursive_least_squares(
    record: Record,
    structure: Structure,
    forgetting: float = 1.0,
    alpha: float = 1e6,
    epsilon: float = 0.0,
    trust: Trust | None = None,
    starts: Starts | None = None,
) -> Floats:
    """q after one pass over all pairs (k, k+1), Eq. (10), from P(0) = alpha I and q(0) = epsilon [1, 1, ...].

        K = P x/(lambda + x'P x),   q += K (y(k+1) - x'q),   P = (I - K x') P/lambda

    trust: rows of trust 0 are passed over, the others count fully, for Eq. (10) knows no weights.
    starts: states of the terms before each segment, where they are known.
    Returns (3 L + T,) parameters in the order of Model.parameters. Raises FitError if P lost what makes it a
    covariance.
    """
    q = np.full(structure.size, float(epsilon))
    P = alpha * np.eye(structure.size)
    for rows in regression_rows(record, structure, trust, starts):
        used = rows.trust > 0.0
        if used.all():
            rls_updates(rows.regressors, rows.target_um, forgetting, q, P)
        else:
            rls_updates(np.ascontiguousarray(rows.regressors[used]), rows.target_um[used], forgetting, q, P)
    if not np.isfinite(q).all() or (np.diag(P) < 0.0).any():
        raise FitError(
            f"{record.source}: recursive least squares with forgetting {forgetting:g} and alpha {alpha:g} lost its "
            "covariance; forget less, or fit in batch"
        )
    return q
