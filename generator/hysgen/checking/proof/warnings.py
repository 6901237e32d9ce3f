"""The warning wall: the flags of gcc and clang under which generated C compiles, every warning an error."""

import dataclasses
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from hysgen.checking.proof.sources import folder_of
from hysgen.codegen.manifest import c_files
from hysgen.errors import BuildError
from hysgen.machine.native import compiler_version

COMPILERS: Final = ("gcc", "clang")

BASIC: Final = ("-Wall", "-Wextra", "-Werror")
"""Warnings of the cross compilers, whose headers and versions differ."""

# fmt: off
COMMON: Final = (
    *BASIC, "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wfloat-conversion", "-Wdouble-promotion",
    "-Wfloat-equal", "-Wshadow", "-Wundef", "-Wunused", "-Wunused-macros", "-Wuninitialized", "-Winit-self",
    "-Wcast-qual", "-Wcast-align", "-Wpointer-arith", "-Wstrict-prototypes", "-Wmissing-prototypes",
    "-Wmissing-declarations", "-Wold-style-definition", "-Wnested-externs", "-Wredundant-decls",
    "-Wbad-function-cast", "-Wwrite-strings", "-Wvla", "-Wformat=2", "-Wswitch-default", "-Wswitch-enum",
    "-Wnull-dereference", "-Wstrict-overflow=2", "-Wstrict-aliasing=2", "-Wdisabled-optimization", "-Winline",
)
GCC_ONLY: Final = (
    "-Wlogical-op", "-Wduplicated-cond", "-Wduplicated-branches", "-Wjump-misses-init", "-Wstack-usage=8192",
)
# Declarations after statements are C99; padding is no fault.
CLANG_ONLY: Final = ("-Weverything", "-Wno-declaration-after-statement", "-Wno-padded")
# fmt: on


def wall_flags(compiler: str, level: str = "-O2") -> tuple[str, ...]:
    """Flags of the warning wall for gcc or clang at one optimisation level."""
    return ("-std=c99", level, *COMMON, *(CLANG_ONLY if "clang" in compiler else GCC_ONLY))


@dataclass(frozen=True)
class Walled:
    """Result of one file under one compiler; complaints: its warning and error lines."""

    compiler: str
    file: str
    complaints: tuple[str, ...]


@dataclass(frozen=True)
class Wall:
    """Results of every file under every installed compiler.

    flags: of all compilers together. skipped: compilers that are not installed.
    """

    model: str
    flags: tuple[str, ...]
    compilers: tuple[str, ...]
    skipped: tuple[str, ...]
    files: tuple[Walled, ...]

    @property
    def clean(self) -> bool:
        """Whether files were compiled and no compiler warned."""
        return bool(self.files) and not any(walled.complaints for walled in self.files)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dataclasses.asdict(self) | {"clean": self.clean}

    def lines(self) -> list[str]:
        """The report as text."""
        text = [f"{'; '.join(self.compilers)}: {len(self.flags)} flags, {len(self.files)} files compiled"]
        text += [f"NOT COMPILED: {reason}" for reason in self.skipped]
        text += [f"{walled.compiler}: {line}" for walled in self.files for line in walled.complaints]
        return [*text, f"{self.model}: {'no warning' if self.clean else 'WARNINGS'}"]


def wall(
    name: str,
    texts: Mapping[str, str],
    *,
    compilers: Sequence[str] = COMPILERS,
    progress: Callable[[float, str], None] | None = None,
) -> Wall:
    """Compile every C file of model `name` under the wall. Raises BuildError if no compiler is installed."""
    installed = [compiler for compiler in compilers if shutil.which(compiler)]
    if not installed:
        raise BuildError(f"none of {', '.join(compilers)} is installed; install one to check warnings with")
    skipped = tuple(f"{compiler}: not installed" for compiler in compilers if compiler not in installed)
    sources = sorted(file for file in c_files(texts) if file.endswith(".c"))
    runs = []
    with folder_of(texts) as scratch:
        for place, compiler in enumerate(installed):
            if progress is not None:
                progress(place / len(installed), f"warnings of {compiler}")
            runs += [_compile(compiler, file, scratch) for file in sources]
    flags = dict.fromkeys(flag for compiler in installed for flag in wall_flags(compiler))
    return Wall(name, tuple(flags), tuple(map(compiler_version, installed)), skipped, tuple(runs))


def _compile(compiler: str, file: str, folder: Path) -> Walled:
    call = [compiler, *wall_flags(compiler), "-c", "-o", "out.o", file]
    run = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    complaints = tuple(line for line in run.stderr.splitlines() if ": error:" in line or ": warning:" in line)
    if run.returncode != 0 and not complaints:
        complaints = (run.stderr.strip()[:200] or f"exit code {run.returncode}",)
    return Walled(compiler, file, complaints)
