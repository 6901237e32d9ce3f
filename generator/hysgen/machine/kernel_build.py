"""Compiling the float64 kernels to one shared library, which a wheel holds for machines without a compiler.

Standard library only: the build of the wheel (hatch_build.py) runs this file before any dependency is installed.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Collection
from pathlib import Path
from typing import Final

STRICT_FLAGS: Final = ("-std=c99", "-fPIC", "-ffp-contract=off", "-fno-fast-math")
"""No contraction into FMA, no value-changing optimisations: required for bit-for-bit equality."""

OPTIMISATION: Final = ("-O3",)
"""-O3 vectorises, but the strict flags forbid reordering sums: results are the same on every machine."""

KERNELS: Final = ("hysgen_*",)
"""Functions of the kernels that Python calls."""


def find_compiler() -> str | None:
    """The compiler that `CC` names, or the first of cc, gcc and clang that is installed; None without one."""
    return next((c for c in (os.environ.get("CC", ""), "cc", "gcc", "clang") if c and shutil.which(c)), None)


def export_flags(names: Collection[str], folder: Path) -> list[str]:
    """Flags that link a shared library which exports `names` (or patterns) alone; `folder`: for a file of the linker.

    No name of the process takes the place of one of the library: python3 may itself link zlib, whose crc32 comes first.
    """
    if sys.platform == "win32":
        return []  # names are looked up by library there
    if sys.platform == "darwin":
        return [f"-Wl,-exported_symbol,_{name}" for name in names]
    script = folder / "exports.map"
    script.write_text(f"{{ global: {' '.join(f'{name};' for name in names)} local: *; }};\n", encoding="utf-8")
    return ["-Wl,-Bsymbolic", f"-Wl,--version-script={script}"]


def library_name(folder: Path) -> str:
    """Name of the library of the C files in `folder`: it changes with every source and flag."""
    texts = [path.read_bytes() for path in sorted(folder.glob("*.[ch]"))]
    recipe = b"\0".join([" ".join((*STRICT_FLAGS, *OPTIMISATION, *KERNELS)).encode(), *texts])
    return f"kernels-{hashlib.sha256(recipe).hexdigest()[:32]}.so"


def build_kernels(folder: Path, compiler: str, target: Path) -> Path:
    """Compile all C files in `folder` to the library in the folder `target`. Returns its path.

    The environment variable ARCHFLAGS names the processor of a wheel for another one than this (macOS).
    Raises subprocess.CalledProcessError with the compiler's messages.
    """
    library = target / library_name(folder)
    target.mkdir(parents=True, exist_ok=True)
    sources = [str(path) for path in sorted(folder.glob("*.c"))]
    architecture = os.environ.get("ARCHFLAGS", "").split()
    with tempfile.TemporaryDirectory() as scratch:
        flags = [*architecture, *STRICT_FLAGS, *OPTIMISATION, *export_flags(KERNELS, Path(scratch))]
        command = [compiler, *flags, "-shared", "-o", str(library), *sources, "-lm"]
        subprocess.run(command, check=True, capture_output=True, text=True)
    return library
