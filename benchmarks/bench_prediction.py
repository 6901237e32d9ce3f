"""Cost of a prediction against the number of rules: operations of the C, estimated cycles, time on this machine.

Run:  python benchmarks/bench_prediction.py
"""

from __future__ import annotations

from smooth_model import smooth

from hysgen.checking.cost import Cost, cost_of_texts
from hysgen.codegen import generate
from hysgen.display import table

RULES = (3, 4, 6, 8, 10, 12, 13, 16, 20, 30, 40, 50)
FUNCTIONS = ("predict", "simulate", "inverse")


def measured(rules: int) -> Cost:
    """Cost of the generated C of a model with the given number of rules."""
    model = smooth(f"rules_{rules}", rules)
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
