"""Platforms that run the generated C under qemu: instruction sets, and the Debian packages of their compilers."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from typing import Final, Literal

STRICT: Final = ("-O2", "-ffp-contract=off")
"""Default scheduling, no multiplication fused with an addition."""


@dataclass(frozen=True)
class Platform:
    """A processor and the commands that compile and run C for it.

    emulator: empty for this machine. order: byte order in NumPy's notation. packages: of Debian. flags: needed to run a
    program under the emulator and to evaluate float in float. fused: flags that enable the fused multiply-add, empty if
    the compiler has it by default.
    """

    name: str
    compiler: str
    emulator: str
    order: Literal["<", ">"]
    packages: tuple[str, ...]
    flags: tuple[str, ...] = ()
    fused: tuple[str, ...] = ()

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
    replace(_platform("armhf", "arm-linux-gnueabihf", "arm", "<", "armhf"), fused=("-mfpu=neon-vfpv4",)),
    _platform("aarch64", "aarch64-linux-gnu", "aarch64", "<", "arm64"),
    _platform("riscv64", "riscv64-linux-gnu", "riscv64", "<", "riscv64"),
    _platform("powerpc", "powerpc-linux-gnu", "ppc", ">", "powerpc"),
    # With -std=c99 alone gcc evaluates float as double on s390x, for an old ABI; the generated C rejects that.
    replace(_platform("s390x", "s390x-linux-gnu", "s390x", ">", "s390x"), flags=("-static", "-fexcess-precision=fast")),
)
