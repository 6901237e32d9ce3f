"""Equality of bits on other instruction sets of both byte orders.

The method is that of `hysgen verify`, equality of whole runs by induction against the float32 reference. The builds are
the host's and those of PLATFORMS: generated C as a program for another processor, run under qemu, with the interface of
`checking.Host` over pipes.
"""

import dataclasses
import math
import shutil
import subprocess
import tempfile
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, cast

import numpy as np
from numpy.typing import NDArray

from hysgen.checking import Build, Driven, Host
from hysgen.checking.bits import Report
from hysgen.checking.bits.comparison import SETUP, START_SAMPLES, Task, compare, tasks
from hysgen.checking.bits.functions import LEARNING_SHARE, SHARES
from hysgen.checking.bits.learning_run import LEAST_UPDATES, HostSide, LearningResult, compare_learning
from hysgen.checking.proof.static import BASIC
from hysgen.codegen.manifest import c_files
from hysgen.codegen.render import render
from hysgen.errors import BuildError
from hysgen.machine.native import Toolchain, compiler_version
from hysgen.model.model import Model

STRICT: Final = ("-O2", "-ffp-contract=off")
"""Default scheduling, no multiplication fused with an addition."""


@dataclass(frozen=True)
class Platform:
    """A processor and the commands that compile and run C for it.

    emulator: empty for this machine. order: byte order in NumPy's notation. packages: of Debian. flags: needed to run a
    program under the emulator and to evaluate float in float.
    """

    name: str
    compiler: str
    emulator: str
    order: Literal["<", ">"]
    packages: tuple[str, ...]
    flags: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """Commands that are not installed."""
        return tuple(command for command in self.commands if shutil.which(command) is None)

    @property
    def commands(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.compiler, self.emulator)))


def _platform(name: str, triplet: str, emulator: str, order: Literal["<", ">"], debian: str) -> Platform:
    packages = (f"gcc-{triplet}", f"libc6-dev-{debian}-cross", "qemu-user-static")
    return Platform(name, f"{triplet}-gcc", f"qemu-{emulator}-static", order, packages, ("-static",))


PLATFORMS: Final = (
    _platform("armhf", "arm-linux-gnueabihf", "arm", "<", "armhf"),
    _platform("aarch64", "aarch64-linux-gnu", "aarch64", "<", "arm64"),
    _platform("riscv64", "riscv64-linux-gnu", "riscv64", "<", "riscv64"),
    _platform("powerpc", "powerpc-linux-gnu", "ppc", ">", "powerpc"),
    # With -std=c99 alone gcc evaluates float as double on s390x, for an old ABI; the generated C rejects that.
    replace(_platform("s390x", "s390x-linux-gnu", "s390x", ">", "s390x"), flags=("-static", "-fexcess-precision=fast")),
)


Words = NDArray[np.uint32]


class Emulated(Driven):
    """A model's generated C, compiled for `platform` and run under its emulator until this object is deleted.

    texts: file name -> text, as `codegen.generate` returns them. flags: of the compiler, for arithmetic and scheduling.
    Structs are arrays of their 32-bit words. Raises BuildError if a command is missing or the compiler rejects the C.
    """

    flushes: Final = False

    def __init__(self, name: str, texts: Mapping[str, str], platform: Platform, flags: Sequence[str] = STRICT) -> None:
        if platform.missing:
            needed = " ".join(platform.packages)
            raise BuildError(f"{platform.name}: {', '.join(platform.missing)} not installed; apt-get install {needed}")
        super().__init__(name, texts)
        self.platform = platform
        self._scratch = tempfile.TemporaryDirectory(prefix="hysgen-")
        _compile(self.name, texts, platform, flags, self.facts, Path(self._scratch.name))
        self._stderr = Path(self._scratch.name) / "stderr"
        with self._stderr.open("wb") as stderr:
            self._process = subprocess.Popen(
                [*filter(None, [platform.emulator]), str(Path(self._scratch.name) / "program")],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stderr,
            )
        weakref.finalize(self, _close, self._process, self._scratch)

    def struct(self, name: str) -> Words:
        """A zeroed `<name>` owned by the caller."""
        return np.zeros(self.interface.struct(name).size, dtype=np.uint32)

    def instance(self, y_um: float, u_V: float) -> Words:
        """A new `<name>_t`, initialised at y_um and u_V."""
        self_t = self.struct(f"{self.name}_t")
        start = np.array([y_um, u_V], dtype=np.float32).view(np.uint32)
        aux = [np.zeros(1, dtype=np.uint32)] * self.channels
        self.run("init", self_t, [start[:1], start[1:], *aux])
        return self_t

    def call(self, function: str, *arguments: Any) -> Any:
        """`<name>_selftest()`, or `<name>_learn_init(learner, model)`."""
        if function == "selftest":
            self._send([0, 0, 0, 0, 0, 0])
            return int(self._receive(1)[0])
        if function == "learn_init":
            learner, model = arguments
            self._send([len(self.entries) + 1, 0, 0, 0, 0, model.size], model)
            learner[:] = self._receive(learner.size)
            return None
        raise BuildError(f"{self.name}_{function}: the driver for other processors does not have this function")

    def commit(self, instance: Words, learner: Words, *, flush: bool = False) -> int:
        """One call of `<name>_commit`: its answer."""
        self._send([len(self.entries) + 2, 0, 0, 0, 0, instance.size], instance, learner)
        answer = int(self._receive(1)[0])
        instance[:] = self._receive(instance.size)
        learner[:] = self._receive(learner.size)
        return answer

    def words_of(self, struct: Words) -> Words:
        """The 32-bit words of a struct, as a live view."""
        return struct

    def run(
        self,
        function: str,
        struct: Words,
        inputs: Sequence[Words],
        *,
        first: int = 0,
        words: int = 0,
        flush: bool = False,
    ) -> tuple[Words, Words]:
        """Step `struct` through samples, as `Host.run`."""
        n, place = len(inputs[0]), list(self.entries).index(function) + 1
        self._send([place, n, len(inputs), first, words, struct.size], struct, *inputs)
        struct[:] = self._receive(struct.size)
        out = self._receive(n)
        return out, self._receive(n * words).reshape(n, words)

    def _send(self, head: list[int], *arrays: Words) -> None:
        assert self._process.stdin is not None
        order = f"{self.platform.order}u4"
        try:
            for array in (np.array(head), *arrays):
                self._process.stdin.write(array.astype(order).tobytes())
            self._process.stdin.flush()
        except BrokenPipeError as fault:
            raise BuildError(self._end()) from fault

    def _receive(self, count: int) -> Words:
        assert self._process.stdout is not None
        data = self._process.stdout.read(4 * count)
        if len(data) != 4 * count:
            raise BuildError(self._end())
        return np.frombuffer(data, dtype=f"{self.platform.order}u4").astype(np.uint32)

    def _end(self) -> str:
        """The error text: exit code and first line of stderr of the ended program."""
        code = self._process.wait()
        message = next(iter(self._stderr.read_text(errors="replace").splitlines()), "no message")
        return f"{self.name} on {self.platform.name}: the program ended with {code}: {message}"


def _compile(
    name: str, texts: Mapping[str, str], platform: Platform, flags: Sequence[str], facts: dict[str, Any], folder: Path
) -> None:
    sources = c_files(texts)
    sources |= {"driver.c": render("driver.c.j2", facts), "main.c": render("proof/emulated.c.j2", facts)}
    for file, text in sources.items():
        (folder / file).write_text(text, encoding="utf-8", newline="\n")
    units = [file for file in sources if file.endswith(".c")]
    call = [platform.compiler, "-std=c99", *BASIC, *platform.flags, *flags, "-o", "program", *units]
    run = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        message = next((line for line in run.stderr.splitlines() if "error" in line), run.stderr.strip()[:200])
        raise BuildError(f"{platform.compiler} {' '.join(flags)}: {message}")


def _close(process: subprocess.Popen[bytes], scratch: tempfile.TemporaryDirectory[str]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
    process.wait()
    scratch.cleanup()


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
    updates, in place of a comparison of commit with the reference.
    Raises BuildError if no platform is installed or a compiler rejects the C.
    """
    started = time.monotonic()
    chosen, report = settings or EmulationSettings(), progress or (lambda fraction, step: None)
    samples, flags = chosen.samples, chosen.flags
    installed = [platform for platform in chosen.platforms if not platform.missing]
    skipped = [_missing(platform) for platform in chosen.platforms if platform.missing]
    if not installed:
        raise BuildError(f"no other instruction set: {skipped[0]}")
    report(0.0, "compiling for " + ", ".join(platform.name for platform in installed))
    builds = [_build(model, texts, platform, flags) for platform in installed]
    # The host comes first: the reference proves the host's trace, and an equal trace of a platform is proved with it.
    host = Build(Toolchain("gcc", ("-O2",)), False, Host(model.name, texts))
    planned = [(task, _share(task, samples)) for task in tasks(host.host)]
    comparing = f"comparing {model.name} on {len(builds)} instruction sets"
    compared = compare(model, [host, *builds], planned, chosen.seed, lambda done: report(done, comparing))
    learning: list[LearningResult] = []
    if host.host.commits:
        report(1.0, f"learning and committing on {len(builds)} instruction sets")
        names = ["this machine", *(platform.name for platform in installed)]
        sides = [HostSide(name, build.host) for name, build in zip(names, [host, *builds], strict=True)]
        updates = max(LEAST_UPDATES, math.ceil(LEARNING_RUN_SHARE * samples))
        learning = compare_learning(model, sides, host.host, updates, chosen.seed)
    labels = tuple(
        f"{platform.name}: {compiler_version(platform.compiler)}, {' '.join(flags)}" for platform in installed
    )
    seconds = time.monotonic() - started
    comparison = Report(model.name, labels, tuple(skipped), (), *compared, seconds)
    return EmulatedReport(comparison, tuple(learning))


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
