"""The generated C on other instruction sets, both orders of bytes: every result and every state, bit for bit.

The comparison is that of `hysgen verify` (equality of whole runs by induction, against the float32 reference), with the
machines of `machines` as builds beside the host's.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Final, cast

from hysgen.errors import BuildError
from hysgen.host import Host
from hysgen.model import Model
from hysgen.native import Toolchain, compiler_version
from hysgen.proof.emulated.machines import MACHINES, STRICT, Machine
from hysgen.proof.emulated.program import Emulated
from hysgen.verify.builds import Build
from hysgen.verify.comparison import START_SAMPLES, Task, compare_selftest, compare_task, tasks
from hysgen.verify.inputs import SHARES
from hysgen.verify.report import Mismatch, Report, Run

LEARNING_SHARE: Final = 0.01
"""Part of the samples that learning gets: its state is some hundred words, each of them compared after every sample."""


def equality(
    model: Model,
    texts: Mapping[str, str],
    *,
    samples: int = 1_000_000,
    machines: Sequence[Machine] = MACHINES,
    flags: Sequence[str] = STRICT,
    seed: int = 1,
    progress: Callable[[float, str], None] | None = None,
) -> Report:
    """Compare the C in `texts` on every machine whose compiler and emulator are installed.

    samples: per function and machine, LEARNING_SHARE of them for learning. flags: how to compile.
    Raises BuildError if no machine is there, or a compiler refuses the C.
    """
    started = time.monotonic()
    there = [machine for machine in machines if not machine.missing]
    skipped = [_missing(machine) for machine in machines if machine.missing]
    if not there:
        raise BuildError(f"no other instruction set: {skipped[0]}")
    if progress is not None:
        progress(0.0, "compiling for " + ", ".join(machine.name for machine in there))
    builds = [_build(model, texts, machine, flags) for machine in there]
    # The host's record is proved by the reference; where a machine's is the same, it is proved with it.
    host = Build(Toolchain("gcc", ("-O2",)), False, Host(model.name, texts))
    todo = tasks(host)
    total, done = sum(_share(task, samples) for task in todo), 0
    runs: list[Run] = []
    mismatches: list[Mismatch] = []

    def advance(compared: int) -> None:
        nonlocal done
        done += compared
        if progress is not None:
            progress(min(1.0, done / total), f"comparing {model.name} on {len(builds)} instruction sets")

    if host.host.selftested:
        run, mismatches = compare_selftest(model, [host, *builds])
        runs.append(run)
    for task in todo:
        run, wrong = compare_task(model, [host, *builds], task, _share(task, samples), seed, advance)
        runs.append(run)
        mismatches.extend(wrong)
    labels = tuple(f"{machine.name}: {compiler_version(machine.compiler)}, {' '.join(flags)}" for machine in there)
    return Report(model.name, labels, tuple(skipped), (), tuple(runs), tuple(mismatches), time.monotonic() - started)


def _share(task: Task, samples: int) -> int:
    """Samples of one function under one style."""
    if task.function == "init":
        return min(samples, START_SAMPLES)
    return math.ceil(SHARES[task.style] * samples * (LEARNING_SHARE if task.function == "learn" else 1.0))


def _build(model: Model, texts: Mapping[str, str], machine: Machine, flags: Sequence[str]) -> Build:
    # An emulated program offers what a comparison uses of a Host.
    program = cast(Host, Emulated(model.name, texts, machine, flags))
    return Build(Toolchain(machine.compiler, tuple(flags)), False, program)


def _missing(machine: Machine) -> str:
    return f"{machine.name}: {', '.join(machine.missing)} not installed; apt-get install {' '.join(machine.packages)}"
