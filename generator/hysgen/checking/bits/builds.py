"""The builds of a verification: compilers, optimisation levels and floating-point modes available on this machine."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from hysgen.checking.host import Host
from hysgen.errors import BuildError
from hysgen.machine.native import Toolchain, compiler_version
from hysgen.machine.threads import in_threads

COMPILERS: Final = ("gcc", "clang")
LEVELS: Final = ("-O0", "-O2", "-O3")


@dataclass(frozen=True)
class Build:
    """Generated C compiled by one toolchain, run with or without flushing denormal numbers to zero."""

    toolchain: Toolchain
    flush: bool
    host: Host

    def __str__(self) -> str:
        return f"{self.toolchain}{', flush to zero' if self.flush else ''}"


def toolchains(compilers: Sequence[str], levels: Sequence[str]) -> tuple[list[Toolchain], list[str]]:
    """Every level of every installed compiler, and one line for each compiler that is not installed.

    levels: compiler flags; one string may hold several flags. Raises BuildError if no compiler is installed.
    """
    installed = [compiler for compiler in compilers if shutil.which(compiler)]
    missing = [f"{name}: not installed, nothing was compared with it" for name in compilers if name not in installed]
    if not installed:
        raise BuildError(f"none of {', '.join(compilers)} is installed; install one to verify with")
    return [Toolchain(compiler, tuple(level.split())) for compiler in installed for level in levels], missing


def compiled(name: str, texts: Mapping[str, str], chain: Sequence[Toolchain]) -> tuple[list[Build], list[str]]:
    """Every build of the texts, and one line if this machine cannot flush denormal numbers.

    Raises BuildError if a compiler rejects the generated C.
    """
    # The compilers run as processes of their own.
    hosts = list(zip(chain, in_threads(lambda toolchain: Host(name, texts, toolchain), chain), strict=True))
    flushes = all(host.flushes for _, host in hosts)
    modes = (False, True) if flushes else (False,)
    skipped = [] if flushes else ["flush to zero: hysgen knows no control for it on this machine"]
    return [Build(toolchain, flush, host) for toolchain, host in hosts for flush in modes], skipped


def versions(chain: Sequence[Toolchain]) -> list[str]:
    """One line per compiler: its version and its levels."""
    commands = dict.fromkeys(toolchain.command for toolchain in chain)
    return [
        f"{compiler_version(command)} ({', '.join(' '.join(t.flags) for t in chain if t.command == command)})"
        for command in commands
    ]
