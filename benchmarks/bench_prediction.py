"""What a prediction costs against the number of rules: operations of the C, estimated cycles, time on this machine.

Run:  python benchmarks/bench_prediction.py
"""

from __future__ import annotations

import numpy as np

from hysgen.cost import Cost, cost_of_texts
from hysgen.emit import generate
from hysgen.model import Grid, Model
from hysgen.tables import table

RULES = (3, 4, 6, 8, 10, 12, 13, 16, 20, 30, 40, 50)
FUNCTIONS = ("predict", "simulate", "inverse")


def smooth(rules: int) -> Model:
    """A stable lag whose rules change smoothly over 0.5 .. 9 um."""
    place = np.linspace(0.0, 1.0, rules)
    columns = [0.9 + 0.05 * place, 1.5e-3 + 5e-4 * place, 0.02 + 0.5 * place * (1.0 - place)]
    return Model(f"rules_{rules}", 2e-5, Grid(0.5, 9.0, rules), np.column_stack(columns), -20.0, 120.0)


def measured(rules: int) -> Cost:
    """Costs of the generated C of `smooth(rules)`."""
    model = smooth(rules)
    return cost_of_texts(model, generate(model))


def main() -> None:
    """Print one table over the numbers of rules."""
    rows = []
    for rules in RULES:
        found = measured(rules)
        by_name = {f.name: f for f in found.functions}
        row = [str(rules)]
        for name in FUNCTIONS:
            f = by_name[name]
            row += [str(f.operations.total), f"~{f.cycles.value}", f"{f.host_ns:.1f}"]
        rows.append([*row, str(found.struct_bytes[f"rules_{rules}_t"]), str(found.constant_bytes)])
    heads = [f"{name} {what}" for name in FUNCTIONS for what in ("operations", "C674x cycles", "host ns")]
    print(table(["rules", *heads, "state bytes", "constant bytes"], rows))
    print("~ estimated from the operations; host ns: median on this machine, compiled with", found.host)


if __name__ == "__main__":
    main()
