"""The instruction sets that the generated C is run on through qemu, and the compilers that Debian builds for them."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from typing import Final, Literal

STRICT: Final = ("-O2", "-ffp-contract=off")
"""Default scheduling, no multiplication fused with an addition."""


@dataclass(frozen=True)
class Machine:
    """A processor that compiled C can be run on.

    compiler, emulator: commands; no emulator: it runs here. packages: of Debian. order: of bytes, as NumPy writes it.
    flags: what a program needs to run there, and to evaluate float as float. fused: flags under which the compiler has
    a fused multiply-add, none if it has one by default.
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


def _machine(
    name: str,
    triplet: str,
    emulator: str,
    order: Literal["<", ">"],
    debian: str,
    *,
    flags: tuple[str, ...] = (),
    fused: tuple[str, ...] = (),
) -> Machine:
    packages = (f"gcc-{triplet}", f"libc6-dev-{debian}-cross", "qemu-user-static")
    return Machine(name, f"{triplet}-gcc", f"qemu-{emulator}-static", order, packages, ("-static", *flags), fused)


MACHINES: Final = (
    _machine("armhf", "arm-linux-gnueabihf", "arm", "<", "armhf", fused=("-mfpu=neon-vfpv4",)),
    _machine("aarch64", "aarch64-linux-gnu", "aarch64", "<", "arm64"),
    _machine("riscv64", "riscv64-linux-gnu", "riscv64", "<", "riscv64"),
    _machine("powerpc", "powerpc-linux-gnu", "ppc", ">", "powerpc"),
    # With -std=c99 alone gcc evaluates float as double there, as its ABI once said; the generated C refuses that.
    _machine("s390x", "s390x-linux-gnu", "s390x", ">", "s390x", flags=("-fexcess-precision=fast",)),
)
