"""Models that `peers` identifies and simulates freely.

NARX     sysidentpy, FROLS: polynomial of degree 2 in y and u, terms and their number chosen by BIC; inputs (u) or
         (u, du, sign du), sample period times 1 or 8: the one with the least free-run error on the last quarter of the
         identification record
P-I      Prandtl-Ishlinskii, 20 plays, least squares (hysgen.model.rivals, section 4.1 of the paper)
Bouc-Wen y = c + d u + e z, dz/du = (1 - (b sign(z du) + 1 - b) |z|^n) / reach; c, d, e by least squares inside of
         scipy.optimize.least_squares over reach, b, n from nine starts
hysgen   hysgen.fit with memory: 12 plays, two Duhem states, rules behind the path
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from own_process import Done, alone

from hysgen.fitting import FitSettings, PathSize, fit
from hysgen.model.rivals import fit_prandtl_ishlinskii
from hysgen.model.simulate import free_run
from hysgen.record import Record

Floats = NDArray[np.float64]


def narx(inputs: Floats, y: Floats, lags: int) -> Any:
    """A polynomial NARX of sysidentpy whose terms FROLS chooses; inputs: (n,) or (n, m)."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    X = inputs.reshape(len(y), -1)
    each = list(range(1, lags + 1))
    model = FROLS(
        order_selection=True,
        n_info_values=15,
        info_criteria="bic",
        ylag=lags,
        xlag=lags if X.shape[1] == 1 else [each] * X.shape[1],
        estimator=LeastSquares(),
        basis_function=Polynomial(degree=2),
    )
    model.fit(X=X, y=y.reshape(-1, 1))
    return model


def narx_run(u: Floats, y: Floats, u_new: Floats, y_new: Floats) -> Callable[[], Floats]:
    """The free run of the best of four NARX models; NaN where it diverges."""

    def inputs_of(u: Floats, kind: str) -> Floats:
        du = np.diff(u, prepend=u[0])
        return u[:, None] if kind == "u" else np.column_stack([u, du, np.sign(du)])

    def task() -> Floats:
        best: tuple[float, Floats] = (np.inf, np.full(len(u_new), np.nan))
        part = 3 * len(u) // 4
        for step in (1, 8):
            for kind in ("u", "u, du, sign du"):
                known, fresh = inputs_of(u[::step], kind), inputs_of(u_new[::step], kind)
                y_step, y_fresh = y[::step], y_new[::step]
                model = narx(known[: part // step], y_step[: part // step], lags=2)
                held = model.predict(X=known[part // step :], y=y_step[part // step :, None])[:, 0]
                error = float(np.std(held - y_step[part // step :][-len(held) :]))
                if np.isfinite(error) and error < best[0]:
                    run = model.predict(X=fresh, y=y_fresh[:, None])[:, 0]
                    rows = np.arange(len(u_new))
                    best = error, np.interp(rows, rows[::step][-len(run) :], run)
        return best[1]

    return task


def bouc_wen_run(u: Floats, y: Floats, u_new: Floats, _y: Floats) -> Callable[[], Floats]:
    """The free run of the fitted Bouc-Wen model."""
    from scipy.optimize import least_squares

    span = float(np.ptp(u))

    def states(u: Floats, reach: float, balance: float, exponent: float) -> Floats:
        z, out = 0.0, np.empty(len(u))
        steps = (np.diff(u, prepend=u[0]) / (reach * span)).tolist()
        for k, step in enumerate(steps):
            turn = balance if z * step > 0.0 else -balance
            z = min(1.0, max(-1.0, z + step * (1.0 - (turn + 1.0 - balance) * abs(z) ** exponent)))
            out[k] = z
        return out

    def columns(u: Floats, shape: Floats) -> Floats:
        return np.column_stack([np.ones(len(u)), u, states(u, *shape)])

    def misfit(shape: Floats) -> Floats:
        rows = columns(u[::4], shape)
        return np.asarray(rows @ np.linalg.lstsq(rows, y[::4], rcond=None)[0] - y[::4])

    def task() -> Floats:
        bounds = ((0.01, 0.4, 1.0), (2.0, 1.0, 3.0))
        starts = [(reach, balance, 1.5) for reach in (0.05, 0.2, 0.6) for balance in (0.5, 0.7, 0.9)]
        found = min(
            (least_squares(misfit, start, bounds=bounds, max_nfev=20) for start in starts), key=lambda each: each.cost
        )
        rows = columns(u, found.x)
        return columns(u_new, found.x) @ np.linalg.lstsq(rows, y, rcond=None)[0]

    return task


def play_run(record: Record, fresh: Record) -> Callable[[], Floats]:
    """The free run of the fitted Prandtl-Ishlinskii model."""
    return lambda: fit_prandtl_ishlinskii(record).free_run(fresh)[0]


def hysgen_run(record: Record, fresh: Record) -> Callable[[], Floats]:
    """The free run of the fitted model."""

    def task() -> Floats:
        model = fit(record, FitSettings(method="batch", memory=PathSize()))
        return free_run(model, fresh)[0].y_um

    return task


MODELS = ("NARX", "P-I", "Bouc-Wen", "hysgen")


def compared(record: Record, fresh: Record) -> dict[str, tuple[float, Done]]:
    """Free-run error [nm rms] and cost by model.

    The first third of `fresh` is not scored; it gives every model an offset.
    """
    u, y = record.segments[0].u_V, record.segments[0].y_um
    u_new, y_new = fresh.segments[0].u_V, fresh.segments[0].y_um
    third = len(u_new) // 3
    done = {
        "NARX": alone(narx_run, u, y, u_new, y_new),
        "P-I": alone(play_run, record, fresh),
        "Bouc-Wen": alone(bouc_wen_run, u, y, u_new, y_new),
        "hysgen": alone(hysgen_run, record, fresh),
    }
    found = {}
    for name, each in done.items():
        error = each.value - y_new
        error = error - np.mean(error[third // 2 : third])
        found[name] = 1e3 * float(np.sqrt(np.mean(error[third:] ** 2))), each
    return found
