"""Compiling C on the host, opening the library through cffi, and caching it on disk.

Used for the float64 kernels and for the generated float32 C under test. A library is named by the digest of all inputs
of its build (sources, flags, compiler and its version), so an outdated library is never opened.
"""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cffi import FFI

from hysgen.errors import BuildError
from hysgen.machine.files import digest


@dataclass(frozen=True)
class Toolchain:
    """A host C compiler and its flags; the flags may change the bits that the compiled code computes."""

    command: str = "cc"
    flags: tuple[str, ...] = ("-O2",)

    def __str__(self) -> str:
        return " ".join((self.command, *self.flags))


# No contraction into FMA, no value-changing optimisations: required for bit-for-bit equality.
STRICT_FLAGS = ("-std=c99", "-fPIC", "-shared", "-ffp-contract=off", "-fno-fast-math")


@dataclass(frozen=True)
class Library:
    """An open shared library: `lib.<function>` calls into it, `ffi` makes and casts its arguments."""

    ffi: FFI
    lib: Any
    path: Path = field(compare=False)


def default_toolchain() -> Toolchain:
    """The compiler that `CC` names, or the first of cc, gcc and clang that is installed."""
    for command in (os.environ.get("CC", ""), "cc", "gcc", "clang"):
        if command and shutil.which(command):
            return Toolchain(command)
    raise BuildError("no C compiler found: install gcc or clang, or point CC at one")


@functools.lru_cache(maxsize=64)
def compiler_version(command: str) -> str:
    """First line of `command --version`. Raises BuildError if the compiler is not installed."""
    if shutil.which(command) is None:
        raise BuildError(f"{command}: no such compiler; install it, or name another one")
    run = subprocess.run([command, "--version"], capture_output=True, text=True, check=False)
    return run.stdout.splitlines()[0] if run.stdout else command


def cache_folder() -> Path:
    """The folder of compiled libraries: HYSGEN_CACHE, else `hysgen` in the user's cache folder."""
    chosen = os.environ.get("HYSGEN_CACHE")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "hysgen"


def build(
    sources: Sequence[tuple[str, str]],
    declarations: str,
    toolchain: Toolchain | None = None,
    libraries: Sequence[str] = ("-lm",),
) -> Library:
    """Compile C texts to one shared library and open it.

    sources: (file name, text) pairs; headers among them are found by #include, `.c` files are compiled.
    declarations: the C declarations for cffi's `cdef`.
    Raises BuildError with the compiler's first error message.
    """
    chosen = toolchain or default_toolchain()
    version = compiler_version(chosen.command)
    flags = (*STRICT_FLAGS, *chosen.flags)
    recipe = "\0".join([chosen.command, version, *flags, *libraries, *(part for pair in sources for part in pair)])
    target = cache_folder() / f"{digest(recipe.encode())[:32]}.so"
    if not target.exists():
        _compile(sources, chosen.command, flags, libraries, target)
    ffi = FFI()
    ffi.cdef(declarations)
    return Library(ffi, ffi.dlopen(str(target)), target)


def _compile(
    sources: Sequence[tuple[str, str]], command: str, flags: Sequence[str], libraries: Sequence[str], target: Path
) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as scratch:
        for name, text in sources:
            Path(scratch, name).write_text(text, encoding="utf-8", newline="\n")
        units = [name for name, _ in sources if name.endswith(".c")]
        call = [command, *flags, "-o", "out.so", *units, *libraries]
        run = subprocess.run(call, cwd=scratch, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            message = next((line for line in run.stderr.splitlines() if "error" in line), run.stderr.strip()[:200])
            raise BuildError(f"{command} {' '.join(flags)}: {message}")
        # Two processes may build the same library at once: the atomic rename leaves one complete file.
        os.replace(Path(scratch, "out.so"), target)
