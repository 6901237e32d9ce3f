"""Equality of bits on other instruction sets of both byte orders, and the effect of fused multiply-adds on them.

The method is that of `hysgen verify`, equality of whole runs by induction against the float32 reference. The builds are
the host's and those of the platforms of `emulated_program`.

A fused multiply-add rounds once where the C rounds twice. Compilers may form it by default; a guard in the generated C
forbids it to the compilers that accept this in the source. Every platform is compiled with fusing enabled: with the
guard no bit may change; without it, the changed results and the mismatches of the self-test are counted.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.bits.comparison import (
    SETUP,
    START_SAMPLES,
    Task,
    compare_commit,
    compare_selftest,
    compare_task,
    tasks,
)
from hysgen.checking.bits.functions import LEARNING_SHARE, MODEL, SHARES, chunks
from hysgen.checking.bits.learning_run import LEAST_UPDATES, HostSide, LearningResult, compare_learning
from hysgen.checking.bits.report import ComparedRun, Mismatch, Report
from hysgen.checking.host import Build, Host
from hysgen.checking.proof.emulated_program import PLATFORMS, STRICT, Emulated, Platform
from hysgen.checking.proof.sources import replaced
from hysgen.errors import BuildError
from hysgen.machine.native import Toolchain, compiler_version
from hysgen.model.model import Model

LEARNING_RUN_SHARE: Final = 0.01
"""Updates of the learning run, as a share of the samples."""

SHADOWS_FROM: Final = 10_000
"""Least number of samples with which shadows are committed against the reference; these commits take minutes."""


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
    if host.host.commits and samples >= SHADOWS_FROM:
        if progress is not None:
            progress(0.0, f"committing shadows on {len(builds)} instruction sets, some minutes")
        run, wrong = compare_commit(model, [host, *builds], chosen.seed)
        runs.append(run)
        mismatches.extend(wrong)
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


Words = NDArray[np.uint32]

FUSING: Final = ("-O2", "-ffp-contract=fast")


@dataclass(frozen=True)
class Fused:
    """Results of one platform compiled with fusing enabled, with or without the guard.

    differing: results of predict, out of `samples`, that differ from the host's. largest_um: the largest difference.
    selftest: mismatches counted by the generated self-test.
    """

    machine: str
    flags: str
    guarded: bool
    samples: int
    differing: int
    largest_um: float
    selftest: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self)


def contraction(
    model: Model,
    texts: Mapping[str, str],
    *,
    samples: int = 100_000,
    platforms: Sequence[Platform] = PLATFORMS,
    progress: Callable[[float, str], None] | None = None,
) -> list[Fused]:
    """Compile and run every installed platform with fusing enabled, with the guard and without it.

    Raises ModelError if the guard is not that of the templates, BuildError if no platform is installed.
    """
    expected, inputs = _expected(model, texts, samples)
    bare = unguarded(model, texts)
    results = []
    installed = [platform for platform in platforms if not platform.missing]
    if not installed:
        raise BuildError("no other instruction set is installed: qemu-user-static and a cross gcc are needed")
    for place, platform in enumerate(installed):
        if progress is not None:
            progress(place / len(installed), f"fusing on {platform.name}")
        for guarded, sources in ((True, texts), (False, bare)):
            flags = (*FUSING, *platform.fused)
            program = Emulated(model.name, sources, platform, flags)
            out = _results(program, inputs)
            difference = np.abs(out.view(np.float32).astype(np.float64) - expected.view(np.float32))
            selftest = int(program.call("selftest")) if program.selftested else 0
            differing = int(np.count_nonzero(out != expected))
            largest = float(difference.max())
            results.append(Fused(platform.name, " ".join(flags), guarded, samples, differing, largest, selftest))
    return results


def contraction_rows(results: Sequence[Fused]) -> tuple[list[str], list[list[str]]]:
    """Column heads and rows of a table."""
    header = ["machine", "flags", "guard", "predictions", "differ", "largest, um", "self-test"]
    rows = [
        [
            row.machine,
            row.flags,
            "there" if row.guarded else "taken out",
            f"{row.samples}",
            f"{row.differing}",
            f"{row.largest_um:.3g}",
            f"{row.selftest} mismatches",
        ]
        for row in results
    ]
    return header, rows


def unguarded(model: Model, texts: Mapping[str, str]) -> dict[str, str]:
    """`texts` without the guard against fusing. Raises ModelError if its lines are not those of the templates."""
    return replaced(model, texts, "guard: contraction", [])


def _expected(model: Model, texts: Mapping[str, str], samples: int) -> tuple[Words, list[Words]]:
    host = Host(model.name, texts)
    pieces = list(chunks(model, "random", MODEL.quantities("predict", host), samples, 1))
    inputs = [np.concatenate(column) for column in zip(*pieces, strict=True)]
    return _results(host, inputs), inputs


def _results(host: Host | Emulated, inputs: Sequence[Words]) -> Words:
    return host.run("predict", host.instance(0.0, 0.0), inputs)[0]
