"""Compiling the float64 kernels to one shared library, which a wheel holds for machines without a compiler.

Standard library only: the build of the wheel (hatch_build.py) runs this file before any dependency is installed.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from pathlib import Path
from typing import Final

STRICT_FLAGS: Final = ("-std=c99", "-fPIC", "-ffp-contract=off", "-fno-fast-math")
"""No contraction into FMA, no value-changing optimisations: required for bit-for-bit equality."""

OPTIMISATION: Final = ("-O3",)
"""-O3 vectorises, but the strict flags forbid reordering sums: results are the same on every machine."""


def find_compiler() -> str | None:
    """The compiler that `CC` names, or the first of cc, gcc and clang that is installed; None without one."""
    return next((c for c in (os.environ.get("CC", ""), "cc", "gcc", "clang") if c and shutil.which(c)), None)


def library_name(folder: Path) -> str:
    """Name of the library of the C files in `folder`: it changes with every source and flag."""
    texts = [path.read_bytes() for path in sorted(folder.glob("*.[ch]"))]
    recipe = b"\0".join([" ".join((*STRICT_FLAGS, *OPTIMISATION)).encode(), *texts])
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
    command = [compiler, *architecture, *STRICT_FLAGS, *OPTIMISATION, "-shared", "-o", str(library), *sources, "-lm"]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return library
