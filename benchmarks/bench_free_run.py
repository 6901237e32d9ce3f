"""How long a compiled free run takes, against the length of the record and against the number of rules.

Run:  python benchmarks/bench_free_run.py [LARGEST]      (largest record in samples, default 1e7)
The limit to hold: 0.3 s for 1e6 samples and 6 rules on two cores. The kernel visits at most 19 rules per sample, so its
time stops growing with their number.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from hysgen.display import table
from hysgen.model.disturbances import Drive
from hysgen.model.model import Grid, Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.simulate import simulate

LENGTHS = (10_000, 100_000, 1_000_000, 10_000_000)
RULES = (3, 4, 6, 10, 15, 19, 20, 30, 40, 50)
REPEATS = 3
TS_S = 2e-5


def smooth(rules: int, plays: int = 0) -> Model:
    """A stable lag over 0 .. 10 um whose rules change smoothly, with play operators or without."""
    place = np.linspace(0.0, 1.0, rules)
    consequents = np.column_stack([0.97 + 0.01 * place, np.full(rules, 0.002), 0.02 * place])
    r = np.arange(1, plays + 1) / (plays + 1.0)
    block = Hysteresis(0.0, 120.0, (4.0, 4.0), tuple(r.tolist()), tuple(np.full(plays, 1.0 / max(plays, 1)).tolist()))
    if plays:
        consequents[:, 1] = 0.03
    return Model("smooth", TS_S, Grid(0.0, 10.0, rules), consequents, 0.0, 120.0, blocks=(block,) if plays else ())


def seconds(model: Model, samples: int) -> str:
    """Shortest of some runs, terms included."""
    t_s = TS_S * np.arange(samples)
    drive = Drive(60.0 + 50.0 * np.sin(2 * np.pi * 100.0 * t_s) * np.sin(2 * np.pi * 3.3 * t_s), TS_S)
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        simulate(model, drive, 5.0)
        times.append(time.perf_counter() - start)
    return f"{min(times):.4f}"


def main() -> None:
    """Print two tables."""
    largest = int(float(sys.argv[1])) if len(sys.argv) > 1 else LENGTHS[-1]
    simulate(smooth(3, 1), Drive(np.zeros(9), TS_S), 5.0)  # compiles the kernels
    lengths = [n for n in LENGTHS if n <= largest]
    rows = [[f"{n:.0e}", seconds(smooth(6), n), seconds(smooth(6, 10), n)] for n in lengths]
    print(table(["samples, 6 rules", "free run s", "with 10 plays s"], rows))
    samples = min(1_000_000, largest)
    print()
    print(
        table([f"rules, {samples:.0e} samples", "free run s"], [[str(n), seconds(smooth(n), samples)] for n in RULES])
    )


if __name__ == "__main__":
    main()
