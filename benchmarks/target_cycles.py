"""Cycles on the C674x against the number of rules, learned parameters and calls per update, and those of Eq. (10).

Run:  python benchmarks/target_cycles.py      (a few minutes; needs firmware/toolchain/build_c674x.sh)
Cycles are stall-free worst cases, as printed by `hysgen cost --target c674x`. Those of Eq. (10), transcribed literally,
are simulated, because its divisions call the compiler's library.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from smooth_model import smooth

from hysgen.c674x import toolchain
from hysgen.c674x.footprint import footprint
from hysgen.codegen import Options, generate
from hysgen.codegen.operations import figures
from hysgen.codegen.operations.cycles import STEPS, estimated
from hysgen.display import table
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model

RULES = (3, 6, 9, 12, 20, 50)
RULE = ("slope", "gain", "offset")
# (rules, plays, learned groups): three parameters per rule, one per rule, the weights of the plays.
LEARNED = (
    (2, 4, ("offset", "terms")),
    (4, 0, RULE),
    (6, 0, RULE),
    (6, 18, ("offset", "terms")),
    (10, 0, RULE),
    (12, 4, (*RULE, "terms")),
)
# (rules, plays, calls per update); all parameters are learned. At 50 kHz a diagnosis chooses the last of each size.
SPREAD = (
    (6, 0, 2),
    (6, 0, 1),
    (6, 6, 2),
    (6, 6, 1),
    (6, 9, 2),
    (6, 9, 3),
    (6, 18, 4),
    (6, 18, 5),
    (6, 36, 6),
    (6, 36, 7),
    (9, 37, 8),
    (9, 37, 10),
)
PARAMETERS = 18


def taken(model: Model) -> dict[str, dict[str, int]]:
    """Cycles, code and stack of the model's C, generated for a clock that exceeds every budget."""
    return footprint(model.name, generate(model, Options(clock_Hz=1e10)))


def against_rules() -> str:
    rows = []
    for rules in RULES:
        found = taken(smooth("smooth", rules))
        steps = [f"{found[name]['cycles']}" for name in ("predict", "simulate", "inverse")]
        rows.append([f"{rules}", *steps, f"{found['predict']['code_bytes']}", f"{found['data']['constant_bytes']}"])
    return table(["rules", "predict", "simulate", "inverse", "code of predict, B", "constants, B"], rows)


def against_parameters() -> str:
    rows = []
    for rules, plays, learned in LEARNED:
        found = taken(smooth("smooth", rules, plays, LearnerSettings(learned=learned)))
        count = len(set(learned) & set(RULE)) * rules + (plays if "terms" in learned else 0)
        code, words = found["all"]["code_bytes"], found["data"]["struct_bytes"]
        cycles = [f"{found[name]['cycles']}" for name in ("learn", "commit")]
        rows.append([f"{count}", f"{rules}", f"{plays}", *cycles, f"{code}", f"{words}"])
    rows.sort(key=lambda row: int(row[0]))
    return table(["parameters", "rules", "plays", "learn", "commit", "code, B", "structs, B"], rows)


def against_calls() -> str:
    """Updates divided over several calls; in brackets the estimate of the cycles of learn."""
    rows = []
    for rules, plays, calls in SPREAD:
        model = smooth("smooth", rules, plays, LearnerSettings(calls_per_update=calls))
        texts = generate(model, Options(clock_Hz=1e10))
        found = footprint(model.name, texts)
        guess = estimated(figures(model.name, texts).operations["learn"], "learn").value
        step = max(found[name]["cycles"] for name in STEPS)
        learn, commit = (found[name]["cycles"] for name in ("learn", "commit"))
        n, code = model.parameters.size, found["all"]["code_bytes"]
        rows.append(
            [f"{n}", f"{calls}", f"{learn} ({guess})", f"{commit}", f"{step}", f"{learn + commit + step}", f"{code}"]
        )
    return table(["parameters", "calls", "learn", "commit", "step", "one period", "code, B"], rows)


def as_printed() -> str:
    """Simulated cycles of one update by Eq. (10), transcribed literally from the paper."""
    text = (Path(__file__).parent / "paper_update.c").read_text(encoding="utf-8")
    machine = toolchain.compile([("paper_update.c", text)]).machine()
    self, x = machine.allocate(PARAMETERS * (PARAMETERS + 1)), machine.allocate(PARAMETERS)
    start = np.concatenate([np.zeros(PARAMETERS), 100.0 * np.eye(PARAMETERS).ravel()]).astype(np.float32)
    machine.write(self, start)
    machine.write(x, np.cos(np.arange(PARAMETERS)).astype(np.float32))
    outcome = machine.call("paper_update", self, x, 0.5, 0.9999)
    return f"Eq. (10) as printed, {PARAMETERS} parameters: {outcome.cycles} cycles an update"


def main() -> None:
    print(as_printed(), flush=True)
    print("\n" + against_rules(), flush=True)
    print("\n" + against_parameters(), flush=True)
    print("\n" + against_calls())


if __name__ == "__main__":
    main()
