"""This project beside other Python packages: time, memory and free-run error, all in one run.

Run:  pip install -e '.[peers]' && python benchmarks/peers.py [--seed 0] [--families ...] [--out docs]

Writes docs/peers.md and docs/peers.png. Each task (`peers_work`, `peers_models`) runs in a process of its own; its
memory is the growth of the peak resident size during the task (Linux). Without HYSGEN_DATA the measured record is left
out, and the page says so.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import hysgen  # noqa: F401  before NumPy, whose BLAS reads once how many threads it may have

# isort: split
import numpy as np
from own_process import alone
from peers_models import MODELS, compared
from peers_work import PARAMETERS, SAMPLES, batch, runs, updates

from hysgen.record import Record, load_record
from hysgen_lab.stage.families import FAMILIES, plant, records

PACKAGES = ("hysgen", "numpy", "scipy", "sysidentpy", "padasip", "filterpy")
ROWS_TO_FIT = 5000
"""Of the measured record dbo/ramps.csv; the rest is scored."""


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
        "What each model is: the head of `benchmarks/peers_models.py`.",
    ]
    picture(errors, asked.out / "peers.png")
    (asked.out / "peers.md").write_text("\n\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
