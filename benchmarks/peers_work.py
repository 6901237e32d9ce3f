"""Tasks that `peers` times on the 18 parameters of Appendix A: batch fit, recursive updates, free run.

Every task is a function of a package's name that prepares its data and returns what is timed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from peers_models import narx

from hysgen.fitting import FitSettings, fit
from hysgen.model.file import load_model
from hysgen.model.simulate import free_run
from hysgen.record import Record

Floats = NDArray[np.float64]
PARAMETERS, UPDATES, SAMPLES = 18, 20_000, 200_000
SLOW_UPDATES = 2_000
"""Updates that are timed of a package that takes tens of microseconds for one."""


def rule_record(samples: int = SAMPLES) -> Record:
    """Appendix A under two beating sines, with 0.5 nm of noise."""
    model = load_model("appendix_a")
    t_s = model.Ts_s * np.arange(samples)
    u_V = 50.0 + 20.0 * np.sin(2 * np.pi * 100.0 * t_s) * (1.0 + 0.9 * np.sin(2 * np.pi * 3.3 * t_s))
    quiet = Record.from_arrays(u_V, np.full(samples, 2.2), model.Ts_s, source="peers", accept=("constant",))
    y_um = free_run(model, quiet)[0].y_um + 0.0005 * np.random.default_rng(0).normal(size=samples)
    return Record.from_arrays(u_V, y_um, model.Ts_s, source="peers")


def regressors(samples: int = SAMPLES) -> tuple[Floats, Floats]:
    """(n, 18) regressors p_l y, p_l u, p_l of Eq. (9) and (n,) target y(k+1)."""
    record, model = rule_record(samples), load_model("appendix_a")
    y, u = record.segments[0].y_um, record.segments[0].u_V
    centres = model.grid.centres_um
    v = np.exp(-((y[:, None] - centres) ** 2) / (2.0 * (0.5 * (centres[1] - centres[0])) ** 2))
    p = v / v.sum(axis=1, keepdims=True)
    return np.stack([p * y[:, None], p * u[:, None], p], axis=2).reshape(len(y), PARAMETERS)[:-1], y[1:]


def batch(package: str) -> Callable[[], Any]:
    """A least-squares fit of 18 parameters to SAMPLES rows; hysgen from the record, the others from the regressors."""
    if package == "hysgen":
        record = rule_record()
        fit(rule_record(2000), FitSettings(method="batch"))
        return lambda: fit(record, FitSettings(method="batch")).consequents
    rows, target = regressors()
    if package == "numpy":
        return lambda: np.linalg.lstsq(rows, target, rcond=None)[0]
    if package == "scipy":
        from scipy.linalg import lstsq

        return lambda: lstsq(rows, target)[0]
    from sysidentpy.parameter_estimation import LeastSquares

    return lambda: LeastSquares().optimize(rows, target.reshape(-1, 1))


def updates(package: str) -> Callable[[], int]:
    """Recursive updates of 18 parameters, one after the other; returns their number."""
    if package == "hysgen C":
        import dataclasses

        from hysgen.checking import Host
        from hysgen.codegen import generate
        from hysgen.model.learner_settings import LearnerSettings

        record = rule_record(UPDATES)
        model = dataclasses.replace(load_model("appendix_a"), learner=LearnerSettings())
        host = Host(model.name, generate(model))
        learner = host.struct(f"{model.name}_learner_t")
        host.call("learn_init", learner, host.instance(2.2, 50.0))
        segment = record.segments[0]
        columns = [np.asarray(x, np.float32).view(np.uint32) for x in (segment.y_um, segment.u_V)]

        def learned() -> int:
            host.run("learn", learner, columns)
            return int(learner.updates)

        return learned
    rows, target = regressors(UPDATES + 1 if package == "numpy" else SLOW_UPDATES + 1)
    if package == "padasip":
        import padasip

        rls = padasip.filters.FilterRLS(n=PARAMETERS, mu=0.999, eps=1e-3)

        def adapted() -> int:
            for x, y in zip(rows, target, strict=True):
                rls.adapt(y, x)
            return len(target)

        return adapted
    if package == "filterpy":
        from filterpy.kalman import KalmanFilter

        kalman = KalmanFilter(dim_x=PARAMETERS, dim_z=1)
        kalman.P *= 1e3

        def filtered() -> int:
            for x, y in zip(rows, target, strict=True):
                kalman.update(y, H=x[None, :])
            return len(target)

        return filtered
    theta, P = np.zeros(PARAMETERS), 1e3 * np.eye(PARAMETERS)

    def recursive() -> int:
        nonlocal theta, P
        for x, y in zip(rows, target, strict=True):
            Px = P @ x
            gain = Px / (0.999 + x @ Px)
            theta = theta + gain * (y - x @ theta)
            P = (P - np.outer(gain, Px)) / 0.999
        return len(target)

    return recursive


def runs(package: str) -> Callable[[], int]:
    """A free run; returns the number of its samples."""
    if package == "hysgen":
        record, model = rule_record(), load_model("appendix_a")
        free_run(model, record)

        def simulated() -> int:
            return int(free_run(model, record)[0].y_um.size)

        return simulated
    count = 5_000
    record = rule_record(count)
    u, y = record.segments[0].u_V, record.segments[0].y_um
    if package == "sysidentpy":
        model = narx(u, y, lags=2)

        def predicted() -> int:
            return int(np.size(model.predict(X=u[:, None], y=y[:, None])))

        return predicted
    paper = load_model("appendix_a")
    centres, q = paper.grid.centres_um, paper.consequents
    width = 2.0 * (0.5 * (centres[1] - centres[0])) ** 2

    def looped() -> int:
        value = y[0]
        for voltage in u:
            v = np.exp(-((value - centres) ** 2) / width)
            value = (v @ (q[:, 0] * value + q[:, 1] * voltage + q[:, 2])) / v.sum()
        return count

    return looped
