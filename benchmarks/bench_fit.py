"""How long a fit takes, against the length of the record and against the number of rules.

Run:  python benchmarks/bench_fit.py [LARGEST]      (largest record in samples, default 1e7)
The limit to hold: 2 s for a batch fit of 1e6 samples and 6 rules on two cores.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from hysgen.display import table
from hysgen.fitting import FitSettings, Method, PathSize, fit
from hysgen.model.disturbances import Drive
from hysgen.model.file import load_model
from hysgen.model.simulate import simulate
from hysgen.record import Record, Segment

LENGTHS = (10_000, 100_000, 1_000_000, 10_000_000)
LONGEST_REFINED = 1_000_000
RULES = (3, 6, 12, 20, 30, 50)


def record_of(samples: int) -> Record:
    """What Appendix A answers to two beating sines, with 0.5 nm of noise."""
    model = load_model("appendix_a")
    t_s = model.Ts_s * np.arange(samples)
    u_V = 50.0 + 20.0 * np.sin(2 * np.pi * 100.0 * t_s) * (1.0 + 0.9 * np.sin(2 * np.pi * 3.3 * t_s))
    y_um = simulate(model, Drive(u_V, model.Ts_s), 2.2).y_um
    y_um += 0.0005 * np.random.default_rng(0).normal(size=samples)
    return Record.from_segments([Segment("0", u_V, y_um)], model.Ts_s)


def seconds(record: Record, method: Method, rules: int, memory: bool = False) -> str:
    """Time of one fit, certificates included."""
    settings = FitSettings(method=method, rules=rules, memory=PathSize() if memory else None)
    start = time.perf_counter()
    fit(record, settings)
    return f"{time.perf_counter() - start:.2f}"


def main() -> None:
    """Print two tables."""
    largest = int(float(sys.argv[1])) if len(sys.argv) > 1 else LENGTHS[-1]
    fit(record_of(1000))  # compiles the kernels
    rows = []
    for samples in (n for n in LENGTHS if n <= largest):
        record = record_of(samples)
        refined = seconds(record, "refined", 6) if samples <= LONGEST_REFINED else "-"
        least_squares = [seconds(record, "batch", 6), seconds(record, "rls", 6)]
        rows.append([f"{samples:.0e}", *least_squares, seconds(record, "batch", 6, memory=True), refined])
    print(table(["samples, 6 rules", "batch s", "rls s", "batch s, with memory", "refined s"], rows))
    record = record_of(min(1_000_000, largest))
    rows = [[str(rules), seconds(record, "batch", rules)] for rules in RULES]
    print()
    print(table([f"rules, {record.samples:.0e} samples", "batch s"], rows))


if __name__ == "__main__":
    main()
