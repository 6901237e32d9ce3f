"""Equality of bits on other instruction sets of both byte orders.

The method is that of `hysgen verify`, equality of whole runs by induction against the float32 reference. The builds are
the host's and those of the platforms of `emulated_program`.
"""

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

from hysgen.checking.bits.comparison import SETUP, START_SAMPLES, Task, compare_selftest, compare_task, tasks
from hysgen.checking.bits.functions import LEARNING_SHARE, SHARES
from hysgen.checking.bits.learning_run import LEAST_UPDATES, HostSide, LearningResult, compare_learning
from hysgen.checking.bits.report import ComparedRun, Mismatch, Report
from hysgen.checking.host import Build, Host
from hysgen.checking.proof.emulated_program import PLATFORMS, STRICT, Emulated, Platform
from hysgen.errors import BuildError
from hysgen.machine.native import Toolchain, compiler_version
from hysgen.model.model import Model

LEARNING_RUN_SHARE: Final = 0.01
"""Updates of the learning run, as a share of the samples."""


@dataclass(frozen=True)
class EmulationSettings:
    """Extent of a comparison.

    samples: per function and platform; LEARNING_SHARE of them for `learn`. platforms: those whose compiler or emulator
    is not installed are skipped. flags: of the compilers.
    """

    samples: int = 1_000_000
    platforms: Sequence[Platform] = PLATFORMS
    flags: Sequence[str] = STRICT
    seed: int = 1


@dataclass(frozen=True)
class EmulatedReport:
    """comparison: with the reference. learning: the learning run on the host and on each platform; empty for a model
    without a learner.
    """

    comparison: Report
    learning: tuple[LearningResult, ...]

    @property
    def equal(self) -> bool:
        """Whether every compared bit is equal."""
        return self.comparison.equal and all(result.equal for result in self.learning)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        # asdict turns a Counter into a list of its items.
        learning = [dataclasses.asdict(result) | {"answers": dict(result.answers)} for result in self.learning]
        return self.comparison.to_json() | {"equal": self.equal, "followed": learning}

    def lines(self) -> list[str]:
        """The report as text."""
        return [*self.comparison.lines(), *(str(result) for result in self.learning[1:])]


def equality(
    model: Model,
    texts: Mapping[str, str],
    settings: EmulationSettings | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> EmulatedReport:
    """Compare the C in `texts` on every platform whose compiler and emulator are installed.

    A model with a learner also makes a learning run of LEARNING_RUN_SHARE of the samples, at least LEAST_UPDATES
    updates; from SHADOWS_FROM samples on, commit is compared with the reference.
    Raises BuildError if no platform is installed or a compiler rejects the C.
    """
    started = time.monotonic()
    chosen = settings or EmulationSettings()
    samples, flags = chosen.samples, chosen.flags
    installed = [platform for platform in chosen.platforms if not platform.missing]
    skipped = [_missing(platform) for platform in chosen.platforms if platform.missing]
    if not installed:
        raise BuildError(f"no other instruction set: {skipped[0]}")
    if progress is not None:
        progress(0.0, "compiling for " + ", ".join(platform.name for platform in installed))
    builds = [_build(model, texts, platform, flags) for platform in installed]
    # The host comes first: the reference proves the host's trace, and an equal trace of a platform is proved with it.
    host = Build(Toolchain("gcc", ("-O2",)), False, Host(model.name, texts))
    todo = tasks(host.host)
    total, done = sum(_share(task, samples) for task in todo), 0
    runs: list[ComparedRun] = []
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
        run, wrong = compare_task(model, [host, *builds], task, _share(task, samples), chosen.seed, advance)
        runs.append(run)
        mismatches.extend(wrong)
    learning: list[LearningResult] = []
    if host.host.commits:
        if progress is not None:
            progress(1.0, f"learning and committing on {len(builds)} instruction sets")
        sides = [
            HostSide("this machine", host.host),
            *(HostSide(platform.name, build.host) for platform, build in zip(installed, builds, strict=True)),
        ]
        updates = max(LEAST_UPDATES, math.ceil(LEARNING_RUN_SHARE * samples))
        learning = compare_learning(model, sides, host.host, updates, chosen.seed)
    labels = tuple(
        f"{platform.name}: {compiler_version(platform.compiler)}, {' '.join(flags)}" for platform in installed
    )
    seconds = time.monotonic() - started
    report = Report(model.name, labels, tuple(skipped), (), tuple(runs), tuple(mismatches), seconds)
    return EmulatedReport(report, tuple(learning))


def _share(task: Task, samples: int) -> int:
    """Samples of one function under one style."""
    if task.function in SETUP:
        return min(samples, START_SAMPLES)
    return math.ceil(SHARES[task.style] * samples * (LEARNING_SHARE if task.learns else 1.0))


def _build(model: Model, texts: Mapping[str, str], platform: Platform, flags: Sequence[str]) -> Build:
    # Emulated has the part of Host's interface that a comparison uses.
    program = cast(Host, Emulated(model.name, texts, platform, flags))
    return Build(Toolchain(platform.compiler, tuple(flags)), False, program)


def _missing(platform: Platform) -> str:
    packages = " ".join(platform.packages)
    return f"{platform.name}: {', '.join(platform.missing)} not installed; apt-get install {packages}"
