"""Compiling the float64 kernels to one shared library, which a wheel holds for machines without a compiler.

Standard library only: the build of the wheel (hatch_build.py) runs this file before any dependency is installed.
"""

import hashlib
import importlib.util
import os
import shlex
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


SYSTEM: Final = ("cc", "gcc", "clang")


def find_compiler() -> str | None:
    """The compiler that the environment variable CC names, or `cc`; None if neither is installed."""
    return next((command for command in (os.environ.get("CC", ""), "cc") if compiler_call(command)), None)


def compiler_call(command: str) -> list[str]:
    """Words that run the compiler `command`, which may hold arguments ("ccache gcc"); empty if it is not installed.

    `cc` is the compiler of this machine: the first of cc, gcc and clang, or else the clang in the Python package
    ziglang, which is the extra `compiler`.
    """
    words = shlex.split(command)
    if words == ["cc"]:
        program = next((name for name in SYSTEM if shutil.which(name)), None)
        return [program] if program else _packaged_call()
    return words if words and shutil.which(words[0]) else []


def _packaged_call() -> list[str]:
    """Words that run the compiler of the package ziglang; empty without that package."""
    package = importlib.util.find_spec("ziglang")
    folders = (package and package.submodule_search_locations) or []
    program = next((path for folder in folders if (path := shutil.which("zig", path=folder))), None)
    # Like other compilers: code for every processor of this kind, and no checks of the compiler's own in it.
    return [program, "cc", "-mcpu=baseline", "-fno-sanitize=undefined"] if program else []


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
        command = [*compiler_call(compiler), *flags, "-shared", "-o", str(library), *sources, "-lm"]
        subprocess.run(command, check=True, capture_output=True, text=True)
    return library
