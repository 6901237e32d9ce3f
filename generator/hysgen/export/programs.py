"""Simulink: a C MEX S-function with a masked block, and a MEX gateway for MATLAB and Octave.

CMake: a package for `find_package`, and a project that uses it.

A Cortex-M4F: start-up, linker script and a program that qemu runs.

A shared library with a flat C interface: LabVIEW, ctypes, a DLL import; the caller owns the memory.
"""

import ctypes
import tempfile
from pathlib import Path

import numpy as np

from hysgen.errors import BuildError
from hysgen.export.base import Export, Samples, Words, Written, make, output_of, results
from hysgen.model.model import Model

SFUNCTION_README = """\
    {{ name }}_make(true)     % MATLAB: builds {{ name }}_sfun and {{ name }}_mex, opens a model with the masked block
    make octave            # Octave: builds {{ name }}_mex and runs {{ name }}_example.m
    make check             # no MATLAB: the S-function against standin/simstruc.h

Ports carry their units. State is DWork, so Simulink's save and restore of simulation state works. **MATLAB and
Simulink were not run**: the S-function is compiled and run against the stand-in, the MEX gateway in Octave. The
Simulink block is not inlined (no TLC file); code generation for a target needs support for non-inlined S-functions.
"""


def run_standin(model: Model, folder: Path, samples: Samples) -> Words:
    """The S-function under the stand-in of simstruc.h."""
    output_of(["make", "-s", "standin/run"], folder)
    program = (folder / "standin" / "run").resolve()
    return results(output_of([str(program), *samples.start], folder, samples.rows.tobytes()))


def run_octave(model: Model, folder: Path, samples: Samples) -> Words:
    """The MEX gateway in Octave."""
    row = 3 + len(model.channels)
    mode, y0_um, u0_V = samples.start
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        Path(scratch, "in.bin").write_bytes(samples.rows.tobytes())
        script = (
            f"addpath('{folder.resolve()}'); if ~exist('{model.name}_mex'), {model.name}_make(); rehash(); end\n"
            f"f = fopen('in.bin'); rows = fread(f, [{row}, Inf], 'uint32=>uint32'); fclose(f);\n"
            "g = @(r) reshape(typecast(reshape(r, [], 1), 'single'), size(r));\n"
            f"[result, status] = {model.name}_mex({mode}, single([{y0_um}, "
            f"{u0_V}]), g(rows(1, :)), g(rows(2, :)), g(rows(3:{row - 1}, :)), rows({row}, :));\n"
            "f = fopen('out.bin', 'w');"
            " fwrite(f, [typecast(result, 'uint32')'; status'; status'], 'uint32'); fclose(f);\n"
        )
        output_of(["octave-cli", "--no-gui", "--quiet", "--eval", script], Path(scratch))
        return results(Path(scratch, "out.bin").read_bytes())


SFUNCTION = Export(
    "sfunction",
    "Simulink S-function and MEX gateway",
    files={
        "{name}_sfun.c": "sfunction.c",
        "{name}_mex.c": "mex.c",
        "{name}_make.m": "sfunction_make.m",
        "{name}_example.m": "sfunction_example.m",
        "Makefile": "sfunction_Makefile",
        "standin/simstruc.h": "simstruc.h",
        "standin/cg_sfun.h": "cg_sfun.h",
        "standin/run.c": "standin.c",
    },
    readme=SFUNCTION_README,
    ways={"S-function": run_standin, "Octave": run_octave},
)


CMAKE_README = """\
    cmake -S . -B build -DCMAKE_INSTALL_PREFIX=$PWD/install && cmake --build build
    ctest --test-dir build && cmake --install build
    cmake -S consumer -B consumer/build -DCMAKE_PREFIX_PATH=$PWD/install && cmake --build consumer/build
    consumer/build/consumer

Your project: `find_package({{ name }} REQUIRED)`, `target_link_libraries(yours PRIVATE {{ name }}::{{ name }})`.
"""


def run_cmake(model: Model, folder: Path, samples: Samples) -> Words:
    """The program run.c of the package."""
    output_of(["cmake", "-S", ".", "-B", "build"], folder)
    output_of(["cmake", "--build", "build", "--target", f"{model.name}_run"], folder)
    program = (folder / "build" / f"{model.name}_run").resolve()
    return results(output_of([str(program), *samples.start], folder, samples.rows.tobytes()))


CMAKE = Export(
    "cmake",
    "CMake package",
    files={
        "CMakeLists.txt": "cmake_CMakeLists.txt",
        "consumer/CMakeLists.txt": "cmake_consumer.txt",
        "run.c": "run.c",
    },
    readme=CMAKE_README,
    ways={"CMake": run_cmake},
)


CORTEXM_README = """\
    make run               # arm-none-eabi-gcc and qemu-system-arm: the self-test, and input.bin if there is one

A Cortex-M4F of qemu (mps2-an386). For a board of your own keep `model/` and {{ name }}_component.c and replace
start.c, link.ld and main.c. main.c prints the fewest and the most cycles of a step in each mode, by the cycle counter
of the core (DWT->CYCCNT), which qemu does not have: the estimates in model/{{ name }}.h are of the C674x. State what
your board prints: `hysgen generate MODEL --clock HZ --budget CYCLES --cycles predict=N,...`.
"""


def run_cortexm(model: Model, folder: Path, samples: Samples) -> Words:
    """The program under qemu."""
    output_of(["make", "-s", f"{model.name}.elf"], folder)
    start = np.array([samples.y0_um, samples.u0_V], np.float32)
    header = np.array([samples.mode.number], np.uint32).tobytes() + start.tobytes()
    machine = ["-machine", "mps2-an386", "-display", "none", "-serial", "none", "-monitor", "none"]
    semihosting = ["-semihosting-config", "enable=on,target=native"]
    kernel = str((folder / f"{model.name}.elf").resolve())
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        Path(scratch, "input.bin").write_bytes(header + samples.rows.tobytes())
        output_of(["qemu-system-arm", *machine, *semihosting, "-kernel", kernel], Path(scratch))
        return results(Path(scratch, "output.bin").read_bytes())


CORTEXM = Export(
    "cortexm",
    "Cortex-M example",
    files={
        "main.c": "cortexm_main.c",
        "start.c": "cortexm_start.c",
        "link.ld": "cortexm_link.ld",
        "Makefile": "cortexm_Makefile",
    },
    readme=CORTEXM_README,
    ways={"Cortex-M qemu": run_cortexm},
)


SHARED_README = """\
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


SHARED = Export(
    "shared",
    "Shared library",
    files={
        "{name}_shared.h": "shared.h",
        "{name}_shared.c": "shared.c",
        "Makefile": "shared_Makefile",
        "CMakeLists.txt": "shared_CMakeLists.txt",
        "example.py": "shared_example.py",
    },
    readme=SHARED_README,
    ways={"ctypes": run_shared},
    finish=finish,
)
