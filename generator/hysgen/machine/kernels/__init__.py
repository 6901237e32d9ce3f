"""Compiled float64 kernels for recurrences that would take minutes in Python.

Each C file beside this one is written by hand in float64 and shares no code with the generated float32 C, which is
tested against it. `hysgen.machine.native` compiles a file once per machine and keeps the library in its cache.

    operators     limiters, plays, linear states, Preisach and Duhem columns, filters
    run           the model over a record; recursive and orthogonal least squares, Kalman innovations

`call` compiles and opens the C file of a kernel, and passes NumPy arrays to it as pointers.
"""

import functools
import re
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI
from numpy.typing import NDArray

from hysgen.machine.kernel_build import OPTIMISATION, library_name
from hysgen.machine.native import Library, Toolchain, build, default_toolchain

ENTRY = re.compile(r"^(?:WIDEST )?((?:void|int64_t) hysgen_\w+\([^)]*\))(?=\s*\{)", re.MULTILINE)
"""Head of a function that Python calls, up to its body."""


@functools.lru_cache(maxsize=32)
def kernel(file: str) -> Library:
    """The library of `file` and the headers that it includes: the one of the wheel, or else compiled here.

    Raises BuildError if there is neither a library nor a compiler.
    """
    folder = Path(str(resources.files(__package__)))
    text = (folder / file).read_text(encoding="utf-8")
    declarations = "".join(f"{head};\n" for head in ENTRY.findall(text))
    shipped = folder / library_name(folder)
    if shipped.exists():
        ffi = FFI()
        ffi.cdef(declarations)
        return Library(ffi, ffi.dlopen(str(shipped)), shipped)
    headers = [(name, (folder / name).read_text(encoding="utf-8")) for name in re.findall(r'#include "(.+)"', text)]
    return build([(file, text), *headers], declarations, Toolchain(default_toolchain().command, OPTIMISATION))


_FFI = FFI()
POINTERS = {
    np.dtype(number): _FFI.typeof(pointer)
    for number, pointer in (
        (np.float64, "double *"),
        (np.float32, "float *"),
        (np.int64, "int64_t *"),
        (np.uintp, "size_t *"),
    )
}
"""Pointers that a kernel takes, by the type of the array."""


def call(file: str, function: str, *arguments: Any) -> Any:
    """Call a function of a kernel. An array is passed as a pointer into it, without a copy: the kernel may write to it.

    Raises ValueError for an array that is not C-contiguous, or of another type than in POINTERS.
    """
    library = kernel(file)
    return getattr(library.lib, function)(
        *(_pointer(value) if isinstance(value, np.ndarray) else value for value in arguments)
    )


def _pointer(array: NDArray[Any]) -> Any:
    if array.dtype not in POINTERS or not array.flags.c_contiguous:
        raise ValueError("a kernel takes C-contiguous arrays of float64, float32, int64 or size_t")
    return _FFI.from_buffer(POINTERS[array.dtype], array)
