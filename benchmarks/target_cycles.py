"""Cycles on the C674x against the number of rules, of plays and of learned parameters, and those of Eq. (10).

Run:  python benchmarks/target_cycles.py      (a few minutes; needs firmware/toolchain/build_c674x.sh)
Cycles are stall-free worst cases, as printed by `hysgen cost --target c674x`. Those of Eq. (10), transcribed literally,
are simulated, because its divisions call the compiler's library.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from smooth_model import behind_path, smooth

from hysgen.codegen import Options, generate
from hysgen.codegen.operations import figures
from hysgen.codegen.operations.cycles import STEPS, estimated
from hysgen.display import table
from hysgen.model.learner_settings import BIAS, GROUPS, LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen_c674x import toolchain
from hysgen_c674x.footprint import footprint

PLAYS = (0, 4, 8, 12, 16, 24)
RULES = (3, 6, 9, 12, 20, 50)
# (rules, plays, learned groups)
LEARNERS = (
    (6, 0, BIAS),
    (6, 0, ("gain",)),
    (12, 0, ("gain",)),
    *((rules, 0, GROUPS) for rules in (2, 4, 6, 8, 9, 10, 11, 12)),
    (6, 18, GROUPS),
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


def against_plays() -> str:
    """Six rules behind plays, 2 Duhem states, 4 creep states and one mode; last column: with a delay of 0.4 samples."""
    rows = []
    for plays in PLAYS:
        model = behind_path("stage", plays)
        found, late = taken(model), taken(behind_path("stage", plays, 0.4))
        steps = next(block.steps for block in model.blocks if isinstance(block, Hysteresis))
        cycles = {name: found[name]["cycles"] for name in (*STEPS, "learn", "commit")}
        period = max(cycles[name] for name in STEPS) + cycles["learn"] + cycles["commit"]
        named = [cycles[name] for name in ("predict", "inverse", "learn", "commit")]
        rows.append([f"{n}" for n in (plays, steps, *named, period, late["inverse"]["cycles"])])
    header = ["plays", "Newton steps", "predict", "inverse", "learn", "commit", "one period", "inverse with delay"]
    return table(header, rows)


def against_parameters() -> str:
    """Learners; in brackets the estimate of the cycles of learn."""
    rows = []
    for rules, plays, learned in LEARNERS:
        texts = generate(smooth("smooth", rules, plays, LearnerSettings(learned=learned)), Options(clock_Hz=1e10))
        found = footprint("smooth", texts)
        guess = estimated(figures("smooth", texts).operations["learn"], "learn").value
        step = max(found[name]["cycles"] for name in STEPS)
        learn, commit = (found[name]["cycles"] for name in ("learn", "commit"))
        count = 1 if learned == BIAS else len(learned) * rules
        sizes = [f"{found['all']['code_bytes']}", f"{found['data']['struct_bytes']}"]
        cycles = [f"{learn} ({guess})", f"{commit}", f"{step}", f"{learn + commit + step}"]
        rows.append([f"{count}", f"{rules}", f"{plays}", *cycles, *sizes])
    return table(
        ["parameters", "rules", "plays", "learn", "commit", "dearest step", "one period", "code, B", "structs, B"], rows
    )


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
    print("\n" + against_plays(), flush=True)
    print("\n" + against_parameters())


if __name__ == "__main__":
    main()
