"""How long a diagnosis takes, against the length of the record: wall clock and processor time, ladder and all.

Processor time is that of all processes; memory is the largest of this one and the largest of its helpers, added.

Run:  python benchmarks/bench_diagnose.py [LARGEST]      (longest record in samples, default 50000)
The limits to hold on two idle cores: 6000 samples 5 s, 50 000 samples 12 s, 1e6 samples 60 s and 2 GB. The record hides
memory, creep and a line; above 100 000 samples the search looks at an excerpt, so only the simulation of the final
chain and of each rung grows with the length.
"""

from __future__ import annotations

import os
import resource
import sys
import time

import hysgen  # noqa: F401  before NumPy, whose BLAS reads once how many threads it may have

# isort: split
import numpy as np

from hysgen.diagnosis import diagnose
from hysgen.display import table
from hysgen.record import Record
from hysgen_lab.stage import Stage
from hysgen_lab.stage import run as measure
from hysgen_lab.studies.bank.scenario import good

LENGTHS = (6_000, 12_500, 25_000, 50_000, 200_000, 1_000_000)
TS_S = 1e-3


def record(samples: int) -> Record:
    """A stage of 10 um with memory, creep and hum, driven well."""
    stage = Stage.nominal().with_effects(creep=(0.02, 0.05, 1e4), periodic=(50.3, 0.05, 0.0))
    u_V = good(np.random.default_rng(1), samples, 0.0, 100.0)
    return Record.from_arrays(u_V, measure(stage, u_V, TS_S, seed=1).displacement_um, TS_S)


def main() -> None:
    """Print one table."""
    longest = int(float(sys.argv[1])) if len(sys.argv) > 1 else 50_000
    rows = []
    for samples in (length for length in LENGTHS if length <= longest):
        hidden = record(samples)
        wall, processor = time.perf_counter(), sum(os.times()[:4])
        found = diagnose(hidden)
        wall, processor = time.perf_counter() - wall, sum(os.times()[:4]) - processor
        of_each = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        memory = 1e-6 * sum(resource.getrusage(one).ru_maxrss for one in of_each)
        rows.append([str(samples), f"{wall:.1f}", f"{processor:.1f}", f"{memory:.2f}", ", ".join(found.names)])
        print(f"{samples} samples: {wall:.1f} s, processor {processor:.1f} s, {memory:.2f} GB", file=sys.stderr)
    print(table(["samples", "wall clock in s", "processor time in s", "largest memory in GB", "named"], rows))


if __name__ == "__main__":
    main()
