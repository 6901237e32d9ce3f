"""Compiling C on the host, opening the library through cffi, and caching it on disk.

Used for the float64 kernels and for the generated float32 C under test. A library is named by the digest of all inputs
of its build (sources, flags, compiler and its version), and sealed by its own: neither an outdated library nor a
damaged one is opened.
"""

import functools
import os
import re
import subprocess
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from cffi import FFI

from hysgen.errors import BuildError, HysgenError
from hysgen.machine.files import digest, unsealed, write_sealed
from hysgen.machine.kernel_build import STRICT_FLAGS, compiler_call, export_flags, find_compiler

INSTALL: Final = "install gcc or clang, or point CC at one; or, with pip alone, `pip install 'hysgen[compiler]'`"
"""What to do on a machine without a C compiler."""


@dataclass(frozen=True)
class Toolchain:
    """A host C compiler and its flags; the flags may change the bits that the compiled code computes."""

    command: str = "cc"
    flags: tuple[str, ...] = ("-O2",)

    def __str__(self) -> str:
        return " ".join((self.command, *self.flags))

    @property
    def call(self) -> list[str]:
        """Words that run the compiler, without the flags; empty if it is not installed."""
        return compiler_call(self.command)


_INCLUDE = re.compile(r"""^\s*#\s*include\s*["<]([^">]+)[">]""", re.MULTILINE)


@dataclass(frozen=True)
class Library:
    """An open shared library: `lib.<function>` calls into it, `ffi` makes and casts its arguments."""

    ffi: FFI
    lib: Any
    path: Path = field(compare=False)


def default_toolchain() -> Toolchain:
    """The compiler of `find_compiler`. Raises BuildError without one."""
    command = find_compiler()
    if command is None:
        raise BuildError(f"no C compiler found: {INSTALL}")
    return Toolchain(command)


@functools.lru_cache(maxsize=64)
def compiler_version(command: str) -> str:
    """First line of `command --version`. Raises BuildError if the compiler is not installed."""
    call = compiler_call(command)
    if not call:
        raise BuildError(f"{command}: no such compiler; install it, or name another one")
    run = subprocess.run([*call, "--version"], capture_output=True, text=True, check=False)
    return run.stdout.splitlines()[0] if run.stdout else command


def cache_folder() -> Path:
    """The folder of compiled libraries: HYSGEN_CACHE, else `hysgen` in the user's cache folder.

    If that cannot be written (a read-only home, a full disk), a folder of this user among the temporary files.
    Raises HysgenError if HYSGEN_CACHE is set and cannot be written, or none of them can.
    """
    chosen = os.environ.get("HYSGEN_CACHE")
    if chosen:
        folder = _usable(Path(chosen))
        if folder is None:
            raise HysgenError(f"HYSGEN_CACHE={chosen}: cannot be written; name another folder")
        return folder
    try:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    except RuntimeError:  # a user without a home
        base = tempfile.gettempdir()
    own = Path(tempfile.gettempdir()) / f"hysgen-{os.getuid() if hasattr(os, 'getuid') else 'cache'}"
    for folder in (_usable(Path(base) / "hysgen"), _usable(own)):
        if folder is not None:
            return folder
    raise HysgenError(f"{base}: cannot be written, nor can {own}; point HYSGEN_CACHE at a folder with room")


@functools.lru_cache(maxsize=8)
def _usable(folder: Path) -> Path | None:
    """The folder, made if missing, if a file can be written there and nobody else can replace it; else None."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as trial:
            trial.write(bytes(4096))
            trial.flush()
        if hasattr(os, "getuid") and folder.parent == Path(tempfile.gettempdir()):
            # A library that another user has put into a shared folder must not be opened.
            state = folder.lstat()
            if state.st_uid != os.getuid() or state.st_mode & 0o022 or folder.is_symlink():
                return None
    except OSError:
        return None
    return folder


def build(
    sources: Sequence[tuple[str, str]],
    declarations: str,
    toolchain: Toolchain | None = None,
    libraries: Sequence[str] = ("-lm",),
    called: Sequence[str] = (),
) -> Library:
    """Compile C texts to one shared library and open it.

    sources: (file name, text) pairs; headers among them are found by #include, `.c` files are compiled.
    declarations: the C declarations for cffi's `cdef`. called: the names that the library exports and no others;
    the functions and variables that `declarations` declare, if not given.
    Raises BuildError with the compiler's first error message.
    """
    chosen = toolchain or default_toolchain()
    version = compiler_version(chosen.command)
    flags = (*STRICT_FLAGS, *chosen.flags)
    names = called or externals(declarations)
    recipe = "\0".join(
        [chosen.command, version, *flags, *libraries, *names, *(part for pair in sources for part in pair)]
    )
    target = cache_folder() / f"{digest(recipe.encode())[:32]}.so"
    if unsealed(target) is None:
        _build(dict(sources), chosen.command, flags, libraries, names, target)
    ffi = FFI()
    ffi.cdef(declarations)
    return Library(ffi, ffi.dlopen(str(target)), target)


def externals(declarations: str) -> list[str]:
    """Names of the functions and `extern` variables among C declarations for cffi, sorted."""
    flat = re.sub(r"/\*.*?\*/|//.*?$|^\s*#.*?$", "", declarations, flags=re.DOTALL | re.MULTILINE)
    while flat != (flat := re.sub(r"\{[^{}]*\}", "", flat)):
        pass
    names: set[str] = set()
    for text in flat.split(";"):
        first = text.split()[:1]
        if first == ["extern"] and "(" not in text:
            names.update(re.findall(r"(\w+)\s*(?:\[[^]]*\]\s*)*(?:,|$)", text))
        elif first != ["typedef"]:
            names.update(re.findall(r"^[^(]*?(\w+)\s*\(", text))
    return sorted(names)


def cached_object(
    unit: str, texts: Mapping[str, str], recipe: Sequence[str], compile_to: Callable[[Path], None]
) -> Path:
    """The object file of `unit`, compiled if the cache does not hold it.

    texts: C texts by file name. recipe: compiler, its version and flags. The object is named by the digest of the
    recipe, the unit and the headers that it includes. compile_to: writes the object to a path in the cache folder.
    """
    parts = [part for name in sorted(_included(unit, texts)) for part in (name, texts[name])]
    target = cache_folder() / f"{digest(chr(0).join([*recipe, unit, *parts]).encode())[:32]}.o"
    if unsealed(target) is None:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent) as scratch:
            compile_to(Path(scratch, "unit.o"))
            # Two processes may compile the same unit at once: one complete file is left.
            write_sealed(target, Path(scratch, "unit.o").read_bytes())
    return target


def _included(name: str, texts: Mapping[str, str]) -> set[str]:
    """The file and all of `texts` that it includes, directly and through other files."""
    included: set[str] = set()
    todo = [name]
    while todo:
        file = todo.pop()
        if file in texts and file not in included:
            included.add(file)
            todo += _INCLUDE.findall(texts[file])
    return included


def _build(
    texts: Mapping[str, str],
    command: str,
    flags: Sequence[str],
    libraries: Sequence[str],
    names: Sequence[str],
    target: Path,
) -> None:
    """Compile the units among `texts` and link them to the shared library `target`, which exports `names`."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent) as scratch:
        for name, text in texts.items():
            Path(scratch, name).write_text(text, encoding="utf-8", newline="\n")

        def run(*arguments: str) -> None:
            call = [*compiler_call(command), *arguments]
            done = subprocess.run(call, cwd=scratch, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                message = next(
                    (line for line in done.stderr.splitlines() if "error" in line), done.stderr.strip()[:200]
                )
                raise BuildError(f"{command} {' '.join(flags)}: {message}")

        def compiled(unit: str) -> str:
            recipe = [command, compiler_version(command), *flags]
            return str(cached_object(unit, texts, recipe, lambda path: run(*flags, "-c", "-o", str(path), unit)))

        objects = [compiled(name) for name in texts if name.endswith(".c")]
        run(*flags, *export_flags(names, Path(scratch)), "-shared", "-o", "out.so", *objects, *libraries)
        write_sealed(target, Path(scratch, "out.so").read_bytes())
