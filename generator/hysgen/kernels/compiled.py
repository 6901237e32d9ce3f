"""Opening a kernel's C file as a compiled library, and handing NumPy arrays to it."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.native import Library, build


@functools.lru_cache(maxsize=32)
def kernel(file: str, declarations: str) -> Library:
    """The library compiled from `file` in this package. Raises BuildError if no compiler is there."""
    text = resources.files(__package__).joinpath(file).read_text(encoding="utf-8")
    return build([(file, text)], declarations)


def doubles(library: Library, array: NDArray[np.float64]) -> Any:
    """A `double *` into `array`, C-contiguous float64: a silent copy would lose what the kernel writes."""
    if array.dtype != np.float64 or not array.flags.c_contiguous:
        raise ValueError("a kernel takes C-contiguous float64 arrays")
    return library.ffi.from_buffer("double *", array)
