"""Cycles on the C674x against the number of rules, of plays and of learned parameters, and those of Eq. (10).

Run:  python benchmarks/target_cycles.py      (a few minutes; needs firmware/toolchain/build_c674x.sh)
      python benchmarks/target_cycles.py one   one call of the models that ship, by everything that says what it costs
Cycles are stall-free worst cases, as printed by `hysgen cost --target c674x`. Those of Eq. (10), transcribed literally,
are simulated, because its divisions call the compiler's library.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from smooth_model import behind_path, smooth

from hysgen.checking import Host
from hysgen.checking.bits.functions import COMPARED_STRUCTS, STYLES, chunks
from hysgen.checking.cost import nanoseconds
from hysgen.codegen import Options, generate
from hysgen.codegen.manifest import read_folder
from hysgen.codegen.operations import C674X, STEPS, estimated, figures
from hysgen.display import table
from hysgen.machine.native import default_toolchain
from hysgen.model.learner_settings import BIAS, GROUPS, LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path.hysteresis import Hysteresis
from hysgen.targets import target
from hysgen_c674x import toolchain
from hysgen_c674x.cycles import c_texts, footprint
from hysgen_c674x.machine import Machine
from hysgen_c674x.schedule.folder import kernels, with_kernels

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
CALLS = 400
"""Simulated calls of a function with each style of inputs."""


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


def simulated(machine: Machine, host: Host, model: Model, function: str) -> tuple[int, int]:
    """Cycles of one call on the simulator: the median over smooth inputs, and the most over every style of inputs."""
    compared = next(struct for struct in COMPARED_STRUCTS if function in struct.functions)
    words = host.words_of(compared.create(host)).copy()
    place, cycles = machine.allocate(words.size), {}
    for style in STYLES:
        machine.write(place, words)
        columns = next(chunks(model, style, compared.functions[function], CALLS, seed=1))
        floats = [column.view(np.float32) for column in columns]
        cycles[style] = machine.map(f"{model.name}_{function}", place, *floats).cycles
    return int(np.median(cycles["smooth"])), max(int(taken.max()) for taken in cycles.values())


def one_call(model: Model) -> str:
    """Models, counts and times of one call; a typical input, then the worst, where both were run."""
    portable = generate(model, Options(clock_Hz=1e10, aligned=True))
    texts = with_kernels(model.name, portable, kernels(model.name, portable))
    longest = {kind: footprint(model.name, files) for kind, files in (("gcc", portable), ("kernel", texts))}
    machines = [toolchain.compile(c_texts(files)).machine() for files in (portable, texts)]
    host, counted = Host(model.name, portable, default_toolchain()), figures(model.name, portable).operations
    times = {style: nanoseconds(host, model, style) for style in STYLES}
    cortex = [target(name, "weights").weights for name in ("cortex-m4", "cortex-m7")]
    rows = []
    for function in (*STEPS, "learn", "commit"):
        row = [function, *(f"{estimated(counted[function], function, w).value}" for w in (C674X, *cortex) if w)]
        for kind, machine in zip(("gcc", "kernel"), machines, strict=True):
            typical, most = simulated(machine, host, model, function) if function != "commit" else ("-", "-")
            row += [f"{typical}", f"{most}", f"{longest[kind][function]['cycles']}"]
        worst = max(times[style].get(function, 0.0) for style in STYLES)
        rows.append([*row, *(f"{ns:.0f}" if ns else "-" for ns in (times["smooth"].get(function, 0.0), worst))])
    header = ["estimate", "M4", "M7", "gcc: typical", "worst", "longest way", "kernel: typical", "worst", "longest way"]
    return table([model.name, *header, "host ns: typical", "worst"], rows)


def main() -> None:
    if sys.argv[1:] == ["one"]:
        for name in ("appendix_a", "extended"):
            print(one_call(read_folder(Path("firmware", "models", name)).model), end="\n\n", flush=True)
        return
    print(as_printed(), flush=True)
    print("\n" + against_rules(), flush=True)
    print("\n" + against_plays(), flush=True)
    print("\n" + against_parameters())


if __name__ == "__main__":
    main()
