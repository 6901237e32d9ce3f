"""The generated C on other instruction sets, both orders of bytes: every result and every state, bit for bit.

The comparison is that of `hysgen verify` (equality of whole runs by induction, against the float32 reference), with the
machines of `machines` as builds beside the host's.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

from hysgen.checking.bits.builds import Build
from hysgen.checking.bits.closed_loop import LEAST_UPDATES, Followed, HostSide, follow
from hysgen.checking.bits.committing import compare_commit
from hysgen.checking.bits.comparison import START_SAMPLES, Task, compare_selftest, compare_task, tasks
from hysgen.checking.bits.inputs import SHARES
from hysgen.checking.bits.report import Mismatch, Report, Run
from hysgen.checking.host import Host
from hysgen.checking.proof.emulated.machines import MACHINES, STRICT, Machine
from hysgen.checking.proof.emulated.program import Emulated
from hysgen.errors import BuildError
from hysgen.machine.native import Toolchain, compiler_version
from hysgen.model.model import Model

LEARNING_SHARE: Final = 0.1
"""Part of the samples that learning gets: its state is some hundred words, each of them compared after every sample."""
FOLLOWED_SHARE: Final = 0.01
"""Updates of the learner that follows a stage and commits, for each of the samples."""

SHADOWS_FROM: Final = 10_000
"""Samples from which on it is worth while to commit hundreds of shadows as well."""


@dataclass(frozen=True)
class EmulatedReport:
    """comparison: with the reference. followed: this machine and the others behind one stage, commits among it; empty
    for a model that does not learn.
    """

    comparison: Report
    followed: tuple[Followed, ...]

    @property
    def equal(self) -> bool:
        """Every bit of everything."""
        return self.comparison.equal and all(row.equal for row in self.followed)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        # asdict would take a Counter for a list of its items.
        followed = [dataclasses.asdict(row) | {"answers": dict(row.answers)} for row in self.followed]
        return self.comparison.to_json() | {"equal": self.equal, "followed": followed}

    def lines(self) -> list[str]:
        """For people."""
        return [*self.comparison.lines(), *(str(row) for row in self.followed[1:])]


def equality(
    model: Model,
    texts: Mapping[str, str],
    *,
    samples: int = 1_000_000,
    machines: Sequence[Machine] = MACHINES,
    flags: Sequence[str] = STRICT,
    seed: int = 1,
    progress: Callable[[float, str], None] | None = None,
) -> EmulatedReport:
    """Compare the C in `texts` on every machine whose compiler and emulator are installed.

    samples: per function and machine, LEARNING_SHARE of them for learning. Learners follow a stage for FOLLOWED_SHARE
    of so many updates, or LEAST_UPDATES, and commit; from SHADOWS_FROM samples on, shadows near and far are committed
    besides. flags: how to compile.
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
    if host.host.commits and samples >= SHADOWS_FROM:
        if progress is not None:
            progress(0.0, f"committing shadows on {len(builds)} instruction sets, some minutes")
        run, wrong = compare_commit(model, [host, *builds], seed)
        runs.append(run)
        mismatches.extend(wrong)
    for task in todo:
        run, wrong = compare_task(model, [host, *builds], task, _share(task, samples), seed, advance)
        runs.append(run)
        mismatches.extend(wrong)
    followed: list[Followed] = []
    if host.host.commits:
        if progress is not None:
            progress(1.0, f"learning and committing on {len(builds)} instruction sets")
        sides = [
            HostSide("this machine", host.host),
            *(HostSide(m.name, b.host) for m, b in zip(there, builds, strict=True)),
        ]
        updates = max(LEAST_UPDATES, math.ceil(FOLLOWED_SHARE * samples))
        followed = follow(model, sides, host.host, updates, seed)
    labels = tuple(f"{machine.name}: {compiler_version(machine.compiler)}, {' '.join(flags)}" for machine in there)
    seconds = time.monotonic() - started
    report = Report(model.name, labels, tuple(skipped), (), tuple(runs), tuple(mismatches), seconds)
    return EmulatedReport(report, tuple(followed))


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
