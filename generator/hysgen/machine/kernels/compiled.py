"""Compiling and opening the C file of a kernel, and passing NumPy arrays to it as pointers."""

from __future__ import annotations

import functools
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from hysgen.machine.kernel_build import OPTIMISATION, library_name
from hysgen.machine.native import Library, Toolchain, build, default_toolchain


@functools.lru_cache(maxsize=32)
def kernel(file: str, declarations: str, *headers: str) -> Library:
    """The library of `file` and the `headers` that it includes: the one of the wheel, or else compiled here.

    Raises BuildError if there is neither a library nor a compiler.
    """
    folder = Path(str(resources.files(__package__)))
    shipped = folder / library_name(folder)
    if shipped.exists():
        ffi = FFI()
        ffi.cdef(declarations)
        return Library(ffi, ffi.dlopen(str(shipped)), shipped)
    sources = [(name, (folder / name).read_text(encoding="utf-8")) for name in (file, *headers)]
    return build(sources, declarations, Toolchain(default_toolchain().command, OPTIMISATION))


def doubles(library: Library, array: NDArray[np.float64]) -> Any:
    """A `double *` into `array`, C-contiguous float64. No copy is made, because the kernel may write to it."""
    if array.dtype != np.float64 or not array.flags.c_contiguous:
        raise ValueError("a kernel takes C-contiguous float64 arrays")
    return library.ffi.from_buffer("double *", array)


def integers(library: Library, array: NDArray[np.int64]) -> Any:
    """An `int64_t *` into `array`, C-contiguous."""
    if array.dtype != np.int64 or not array.flags.c_contiguous:
        raise ValueError("a kernel takes C-contiguous int64 arrays")
    return library.ffi.from_buffer("int64_t *", array)
