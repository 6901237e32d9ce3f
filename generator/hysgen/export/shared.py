"""A shared library with a flat C interface: LabVIEW, ctypes, a DLL import; the caller owns the memory."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

from hysgen.errors import BuildError
from hysgen.export.base import Export, Samples, Words, Written, make
from hysgen.model.model import Model

README = """\
    make && make example   # lib{{ name }}.so and a run through ctypes
    cmake -S . -B build && cmake --build build    # Windows, macOS

LabVIEW: Call Library Function nodes on `{{ name }}_shared_start` and `{{ name }}_shared_run`; a component is a U32
array of `{{ name }}_shared_bytes() / 4` elements, passed as array data pointer, as are y_um, input, result (SGL) and
status (U32). All numbers are passed by value with their 32-bit types; thread: any, if each component is used by one
at a time. LabVIEW was not run.
"""


def run_shared(model: Model, folder: Path, samples: Samples) -> Words:
    """The library through ctypes."""
    library = ctypes.CDLL(str((folder / f"lib{model.name}.so").resolve()))
    start, run = (getattr(library, f"{model.name}_shared_{name}") for name in ("start", "run"))
    start.argtypes = [ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_float, ctypes.c_float]
    run.argtypes = [ctypes.c_void_p, ctypes.c_int32, *[ctypes.c_void_p] * 6]
    memory = np.zeros(getattr(library, f"{model.name}_shared_bytes")() // 4, np.uint32)
    if start(memory.ctypes.data, memory.nbytes, samples.mode.number, samples.y0_um, samples.u0_V):
        raise BuildError(f"{model.name}: the shared library has no mode {samples.mode.name}")
    n = len(samples.rows)
    out = np.empty((2, n), np.uint32)
    columns = [samples.column(0), samples.column(1), samples.aux, samples.commit]
    run(memory.ctypes.data, n, *(column.ctypes.data for column in columns), out[0].ctypes.data, out[1].ctypes.data)
    return out.T


def finish(written: Written) -> list[str]:
    """Build the library. Raises BuildError without make or a compiler."""
    library = f"lib{written.draft.model.name}.so"
    make(written.folder, library)
    return [library]


EXPORT = Export(
    "shared",
    "Shared library",
    files={
        "{name}_shared.h": "shared.h",
        "{name}_shared.c": "shared.c",
        "Makefile": "shared_Makefile",
        "CMakeLists.txt": "shared_CMakeLists.txt",
        "example.py": "shared_example.py",
    },
    readme=README,
    ways={"ctypes": run_shared},
    finish=finish,
)
