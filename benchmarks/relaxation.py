"""Free run before and after plays that relax, on stages of thermally activated hysterons: rows that the fit never saw.

Run:  python benchmarks/relaxation.py [--seeds 700:710] [--hysterons 1024]

Each stage is that of the family `thermal` without other effects (`stage/families/__init__.py`): 32 000 rows to fit,
16 000 rows of another command to score, both after a movement that the records do not contain. `before`: the best, on
the scored rows, of the plays and Duhem states in the sizes of the cause `memory`, alone and with creep; `after`: plays
that relax, in the size `RELAXING`. The noise is subtracted from the powers of both in the last column.
"""

from __future__ import annotations

import argparse

import numpy as np

from hysgen.diagnosis.causes.hysteresis import SIZES
from hysgen.display import table
from hysgen.fitting import FitSettings, fit
from hysgen.fitting.operator import RELAXING
from hysgen.model.path.creep import Creep
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.model.scores import score
from hysgen.record import Record
from hysgen_lab.stage.families import IDENTIFY, laws, plant, records


def main() -> None:
    """Print one line for each stage, and the median and the worst ratio."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", default="700:710")
    parser.add_argument("--hysterons", type=int, default=laws.HYSTERONS, help="of each stage; more are smoother")
    parser.add_argument("--method", default="batch", choices=("batch", "refined"))
    chosen = parser.parse_args()
    laws.HYSTERONS = chosen.hysterons
    first, last = (int(number) for number in chosen.seeds.split(":"))
    rows, ratios = [], []
    for seed in range(first, last):
        stage = plant("thermal", "memory", seed)
        known, fresh = (Record.from_arrays(u, y, Ts_s=stage.Ts_s, source=f"{seed}") for u, y in records(stage))
        span_s = IDENTIFY * stage.Ts_s
        creep = Creep(0.005, tuple(float(tau) for tau in np.geomspace(30 * stage.Ts_s, span_s, 4)))
        before = {}
        for size in SIZES:
            for label, blocks in (("", ()), (" and creep", (creep,))):
                model = fit(known, FitSettings(method=chosen.method, memory=size, blocks=blocks))
                before[f"{size.plays} plays{label}"] = score(model, fresh).free_run.e_rms_um
        best = min(before, key=lambda label: before[label])
        model = fit(known, FitSettings(method=chosen.method, memory=RELAXING))
        after = score(model, fresh).free_run.e_rms_um
        block = next(block for block in model.blocks if isinstance(block, Hysteresis))
        beyond = [np.sqrt(max(value**2 - stage.noise_um**2, 0.0)) for value in (before[best], after)]
        ratios.append(beyond[0] / beyond[1])
        values = (1e3 * stage.noise_um, 1e3 * before[best], 1e3 * after)
        rows.append(
            [f"{seed}", f"{stage.stroke_um:.1f}"]
            + [f"{value:.2f}" for value in (*values, ratios[-1])]
            + [f"{block.relaxation:.4f}", best]
        )
        print("  ".join(rows[-1]), flush=True)
    heads = ["seed", "stroke um", "noise nm", "before nm", "after nm", "ratio", "relaxation", "before"]
    print(table(heads, rows))
    print(f"ratio beyond the noise: median {np.median(ratios):.2f}, least {min(ratios):.2f}")


if __name__ == "__main__":
    main()
