"""This project beside other Python packages: time, memory and free-run error, all in one run.

Run:  pip install -e '.[peers]' && python benchmarks/peers.py [--seed 0] [--families ...] [--out docs]

Writes docs/peers.md and docs/peers.png. Each task runs in a process of its own; its memory is the growth of the peak
resident size during the task (Linux). Without HYSGEN_DATA the measured record is left out, and the page says so.

NARX     sysidentpy, FROLS: polynomial of degree 2 in y and u, terms and their number chosen by BIC; inputs (u) or
         (u, du, sign du), sample period times 1 or 8: the one with the least free-run error on the last quarter of the
         identification record
P-I      Prandtl-Ishlinskii, 20 plays, least squares (hysgen.model.rivals, section 4.1 of the paper)
Bouc-Wen y = c + d u + e z, dz/du = (1 - (b sign(z du) + 1 - b) |z|^n) / reach; c, d, e by least squares inside of
         scipy.optimize.least_squares over reach, b, n from nine starts
hysgen   hysgen.fit with memory: 12 plays, two Duhem states, rules behind the path
"""

from __future__ import annotations

import argparse
import importlib.metadata
import multiprocessing
import os
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import hysgen  # noqa: F401  before NumPy, whose BLAS reads once how many threads it may have

# isort: split
import numpy as np
from numpy.typing import NDArray

from hysgen.fitting import FitSettings, PathSize, estimate_starts, fit
from hysgen.model.file import load_model
from hysgen.model.rivals import fit_prandtl_ishlinskii
from hysgen.model.simulate import free_run
from hysgen.record import Record, load_record
from hysgen.stage.families import FAMILIES, plant, records

Floats = NDArray[np.float64]
PACKAGES = ("hysgen", "numpy", "scipy", "sysidentpy", "padasip", "filterpy")
PARAMETERS, UPDATES, SAMPLES = 18, 20_000, 200_000
SLOW_UPDATES = 2_000
"""Updates that are timed of a package that takes tens of microseconds for one."""
ROWS_TO_FIT = 5000
"""Of the measured record dbo/ramps.csv; the rest is scored."""


@dataclass(frozen=True)
class Done:
    """Result of a task. seconds: of the task; MB: growth of the peak resident size of its process."""

    value: Any
    seconds: float
    MB: float


def alone(task: Callable[..., Any], *arguments: Any) -> Done:
    """Run `task` in a new process."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        return pool.submit(_timed, task, arguments).result()


def _timed(task: Callable[..., Any], arguments: Sequence[Any]) -> Done:
    warnings.simplefilter("ignore")
    prepared = task(*arguments)
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")  # The peak becomes the present size.
    before = _peak_MB()
    begun = time.perf_counter()
    value = prepared()
    seconds = time.perf_counter() - begun
    return Done(value, seconds, _peak_MB() - before)


def _peak_MB() -> float:
    """The peak resident size of this process [MB]; Linux only."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return float(status.partition("VmHWM:")[2].split()[0]) / 1024


# ---- Batch fit, updates, free run of the same 18 parameters ----------------------------------------------------------


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

        from hysgen.checking.host import Host
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


# ---- Free-run error --------------------------------------------------------------------------------------------------


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


def hysgen_run(record: Record, fresh: Record, unscored: int) -> Callable[[], Floats]:
    """The free run of the fitted model, its state estimated from the rows that are not scored."""

    def task() -> Floats:
        model = fit(record, FitSettings(method="batch", memory=PathSize()))
        return free_run(model, fresh, estimate_starts(model, fresh, [unscored]))[0].y_um

    return task


MODELS = ("NARX", "P-I", "Bouc-Wen", "hysgen")


def compared(record: Record, fresh: Record) -> dict[str, tuple[float, Done]]:
    """Free-run error [nm rms] and cost by model.

    The first third of `fresh` is not scored; it gives every model an offset and this project's its start.
    """
    u, y = record.segments[0].u_V, record.segments[0].y_um
    u_new, y_new = fresh.segments[0].u_V, fresh.segments[0].y_um
    third = len(u_new) // 3
    done = {
        "NARX": alone(narx_run, u, y, u_new, y_new),
        "P-I": alone(play_run, record, fresh),
        "Bouc-Wen": alone(bouc_wen_run, u, y, u_new, y_new),
        "hysgen": alone(hysgen_run, record, fresh, third),
    }
    found = {}
    for name, each in done.items():
        error = each.value - y_new
        error = error - np.mean(error[third // 2 : third])
        found[name] = 1e3 * float(np.sqrt(np.mean(error[third:] ** 2))), each
    return found


# ---- The page --------------------------------------------------------------------------------------------------------


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table."""
    return "\n".join(f"| {' | '.join(row)} |" for row in (header, ["---"] * len(header), *rows))


def work_table(title: str, tasks: Sequence[tuple[str, Callable[..., Any], str, float]]) -> str:
    """Time of one element of each task, and its ratio to the first row, this project's."""
    rows, first = [], 0.0
    for name, task, package, unit in tasks:
        done = alone(task, package)
        count = done.value if isinstance(done.value, int) else 1
        each = done.seconds / count * unit
        first = first or each
        rows.append([name, f"{each:.3g}", f"{each / first:.2g}", f"{done.MB:.0f}"])
        print(title, rows[-1], flush=True)
    return table([title, {1.0: "s", 1e6: "us each"}[tasks[0][3]], "times this project's", "MB"], rows)


def picture(errors: dict[str, dict[str, float]], path: Path) -> None:
    """Free-run errors as bars on a logarithmic axis, one group for each stage."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8.0, 3.6), layout="constrained")
    for k, name in enumerate(MODELS):
        places = np.arange(len(errors)) + 0.2 * (k - 1.5)
        axes.bar(places, [found[name] for found in errors.values()], 0.19, label=name)
    axes.set_yscale("log")
    axes.set_xticks(np.arange(len(errors)), list(errors))
    axes.set_ylabel("free-run error [nm rms]")
    axes.legend(ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.16), frameon=False)
    axes.grid(axis="y", alpha=0.3)
    figure.savefig(path, dpi=120)


def main() -> None:
    """Measure, print, and write the page and its picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0, help="stage of each family")
    parser.add_argument("--families", nargs="*", choices=tuple(FAMILIES), default=list(FAMILIES), metavar="FAMILY")
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs", help="folder of the page")
    asked = parser.parse_args()
    stages: dict[str, tuple[Record, Record]] = {}
    for family in asked.families:
        hidden = plant(family, "memory", asked.seed)
        pair = [
            Record.from_arrays(u, y, hidden.Ts_s, source=family, accept=("constant", "saturation"))
            for u, y in records(hidden)
        ]
        stages[family] = pair[0], pair[1]
    missing = ""
    if "HYSGEN_DATA" in os.environ:
        stages["dbo ramps"] = load_record(Path(os.environ["HYSGEN_DATA"]) / "dbo" / "ramps.csv").split_at(ROWS_TO_FIT)
    else:
        missing = "\nThe measured record was NOT compared: HYSGEN_DATA was not set.\n"
    work = [
        work_table(
            f"batch fit of {PARAMETERS} parameters to {SAMPLES:.0e} rows",
            [
                ("hysgen, from the record, certificates included", batch, "hysgen", 1.0),
                ("numpy.linalg.lstsq, from the regressors", batch, "numpy", 1.0),
                ("scipy.linalg.lstsq, from the regressors", batch, "scipy", 1.0),
                ("sysidentpy LeastSquares, from the regressors", batch, "sysidentpy", 1.0),
            ],
        ),
        work_table(
            f"one update of {PARAMETERS} parameters",
            [
                ("hysgen, generated C (float32, UD, protections)", updates, "hysgen C", 1e6),
                ("NumPy, Eq. (10) in float64", updates, "numpy", 1e6),
                ("padasip FilterRLS", updates, "padasip", 1e6),
                ("filterpy KalmanFilter", updates, "filterpy", 1e6),
            ],
        ),
        work_table(
            "one sample of a free run",
            [
                ("hysgen, six rules", runs, "hysgen", 1e6),
                ("NumPy, the same model in a loop", runs, "numpy", 1e6),
                ("sysidentpy NARX, degree 2", runs, "sysidentpy", 1e6),
            ],
        ),
    ]
    errors, rows, costs = {}, [], []
    for name, (record, fresh) in stages.items():
        found = compared(record, fresh)
        errors[name] = {model: error for model, (error, _) in found.items()}
        others = min(error for model, error in errors[name].items() if model != "hysgen")
        rows.append(
            [name, *(f"{errors[name][model]:.3g}" for model in MODELS), f"{others / errors[name]['hysgen']:.2g}"]
        )
        costs.append([name, *(f"{found[m][1].seconds:.3g} s, {found[m][1].MB:.0f} MB" for m in MODELS)])
        print(rows[-1], costs[-1], flush=True)
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in PACKAGES if name != "hysgen")
    page = [
        "# Beside other packages",
        "`python benchmarks/peers.py` (packages: the extra `peers`) measured everything on this page in one run and "
        f"wrote it: {versions}; one process for each task, MB is the growth of its peak memory.",
        *work,
        "## Free-run error",
        "Models identified from one record and simulated over another; the first third of that record is not scored, "
        "and gives every model its offset. nm rms; last column: the best of the others over this project's. The stages "
        "have a lag beside their hysteresis, which P-I and Bouc-Wen, static in time, do not describe."
        f"\n{missing}",
        table(["stage", *MODELS, "best other / hysgen"], rows),
        "![Free-run error of four models](peers.png)",
        "Time and memory of identification and simulation:",
        table(["stage", *MODELS], costs),
        "What each model is: the head of `benchmarks/peers.py`.",
    ]
    picture(errors, asked.out / "peers.png")
    (asked.out / "peers.md").write_text("\n\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
