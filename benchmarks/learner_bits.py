"""Long chains of updates of the compiled learner, compared with its NumPy reference: 6 to 36 parameters, every build.

Every word of the learner's state after every sample is compared, by induction (`hysgen.checking.bits.functions`), at
gcc and clang, -O0, -O2 and -O3, with and without flush to zero. The plant is the model with 5 % less gain, and noise;
its input is constant for a fifth of the time.

Run:  python benchmarks/learner_bits.py [UPDATES [PARAMETERS ...]]

UPDATES: approximate number of consecutive updates, default 1e6. PARAMETERS: sizes to compare, default all.
"""

from __future__ import annotations

import sys
import time

from smooth_model import smooth

from hysgen.checking import LEVELS, Host, compiled, host_compilers, toolchains
from hysgen.checking.bits.comparison import Task, compare_task
from hysgen.checking.bits.functions import LEARNER, chunks
from hysgen.codegen import Options, generate
from hysgen.display import table
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model

SIZES = {6: (2, 0), 18: (6, 0), 24: (8, 0), 30: (10, 10), 36: (12, 0)}
"""Parameters -> rules and plays."""

UPDATING_SHARE = 0.7
"""Least share of samples that update: one fifth has a constant input, some innovations lie in the dead zone."""

SEED = 1


def counted(model: Model, texts: dict[str, str], samples: int) -> tuple[int, int]:
    """Updates and restarts of the compared chain."""
    host = Host(model.name, texts)
    learner = LEARNER.create(host)
    for columns in chunks(model, "smooth", LEARNER.functions["learn"], samples, SEED, LEARNER.chunk):
        host.run("learn", learner, columns)
    return int(learner.updates), int(learner.restarts)


def main() -> int:
    """Print one row per size; exit code 1 if a bit differs."""
    samples = round(float(sys.argv[1] if len(sys.argv) > 1 else "1e6") / UPDATING_SHARE)
    found, skipped = toolchains(host_compilers(), LEVELS)
    rows, differences = [], []
    sizes = [int(size) for size in sys.argv[2:]] or list(SIZES)
    for parameters in sizes:
        started = time.monotonic()
        rules, plays = SIZES[parameters]
        model = smooth(f"learn_{parameters}", rules, plays, LearnerSettings())
        texts = generate(model, Options(clock_Hz=1e10))
        builds, unable = compiled(model.name, texts, found)
        skipped += [reason for reason in unable if reason not in skipped]
        _, wrong = compare_task(model, builds, Task(LEARNER, "learn", "smooth"), samples, SEED, lambda done: None)
        differences += wrong
        updates, restarts = counted(model, texts, samples)
        result = f"{len(wrong)} differ" if wrong else "equal"
        seconds = f"{time.monotonic() - started:.0f}"
        rows.append((str(parameters), str(samples), str(updates), str(restarts), str(len(builds)), result, seconds))
        print(f"{parameters} parameters, {updates} updates, {len(builds)} builds: {result}", file=sys.stderr)
    print(table(("parameters", "samples", "updates", "restarts", "builds", "bits", "s"), rows))
    for line in (*(f"NOT COMPARED: {reason}" for reason in skipped), *map(str, differences)):
        print(line)
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
