"""Eq. (10) as printed, in float32: how long its covariance stays one."""

from __future__ import annotations

from importlib import resources

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.native import build
from hysgen.model.membership import rule_regressors
from hysgen.model.model import Grid

Floats = NDArray[np.float64]

_DECLARATION = """
uint64_t printed_run(size_t rows, size_t size, const float *regressors, const float *target, float lambda, float *P,
    float *q);
"""


def dies_at(y_um: Floats, u_V: Floats, grid: Grid, forgetting: float, alpha: float) -> int | None:
    """First sample after which P has a diagonal element <= 0, or anything is not finite; None if none has.

        K = P x/(lambda + x' P x),   q <- q + K (y(k+1) - x' q),   P <- (I - K x') P/lambda,   P(0) = alpha I, q(0) = 0

    y_um, u_V: (n,). Everything in float32, regressors of Eq. (9) not scaled.
    """
    text = resources.files(__package__).joinpath("printed.c").read_text(encoding="utf-8")
    library = build([("printed.c", text)], _DECLARATION)
    x = np.ascontiguousarray(rule_regressors(y_um[:-1], u_V[:-1], grid), dtype=np.float32)
    target = np.ascontiguousarray(y_um[1:], dtype=np.float32)
    size = x.shape[1]
    P, q = np.float32(alpha) * np.eye(size, dtype=np.float32), np.zeros(size, dtype=np.float32)
    floats = [library.ffi.from_buffer("float *", array) for array in (x, target, P, q)]
    died = int(library.lib.printed_run(x.shape[0], size, *floats[:2], forgetting, *floats[2:]))
    return died or None
