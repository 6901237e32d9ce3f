"""Opening a kernel's C file as a compiled library, and handing NumPy arrays to it."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.native import Library, Toolchain, build, default_toolchain


@functools.lru_cache(maxsize=32)
def kernel(file: str, declarations: str, *headers: str) -> Library:
    """The library compiled from `file` and the `headers` it includes. Raises BuildError if no compiler is there."""
    folder = resources.files(__package__)
    sources = [(name, folder.joinpath(name).read_text(encoding="utf-8")) for name in (file, *headers)]
    # Vector instructions keep the order of every sum (the strict flags forbid more), so they cost no reproducibility.
    return build(sources, declarations, Toolchain(default_toolchain().command, ("-O3",)))


def doubles(library: Library, array: NDArray[np.float64]) -> Any:
    """A `double *` into `array`, C-contiguous float64: a silent copy would lose what the kernel writes."""
    if array.dtype != np.float64 or not array.flags.c_contiguous:
        raise ValueError("a kernel takes C-contiguous float64 arrays")
    return library.ffi.from_buffer("double *", array)


def integers(library: Library, array: NDArray[np.int64]) -> Any:
    """An `int64_t *` into `array`, C-contiguous."""
    if array.dtype != np.int64 or not array.flags.c_contiguous:
        raise ValueError("a kernel takes C-contiguous int64 arrays")
    return library.ffi.from_buffer("int64_t *", array)
