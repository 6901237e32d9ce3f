"""An exported model run in its target, compared bit for bit with the generated C on this machine.

The reference is the component of templates/export/component.c.j2 around the C that the model generates now, compiled as
by `hysgen verify`: what stands in the folder has no part in it.
"""

from __future__ import annotations

import functools
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.codegen import Options
from hysgen.codegen.manifest import c_files
from hysgen.codegen.structs import interface
from hysgen.errors import BuildError
from hysgen.export import export_texts
from hysgen.export.component import MODES, Mode, modes_of
from hysgen.export.fmu import Variable, fmu_variables
from hysgen.float32.coefficients import coefficients
from hysgen.machine.native import Library, build
from hysgen.model.disturbances import channels_of
from hysgen.model.model import Model

Words = NDArray[np.uint32]
Progress = Callable[[float, str], None]

SEED: Final = 21
CORRUPTED: Final = (np.nan, np.inf, -np.inf, 1e30, -1e30, 1e-42, -0.0)
CORRUPTED_EVERY: Final = 97
"""One sample in so many is corrupted: often enough for every kind in each input within 10 000 samples."""

COMMITS: Final = 8
NOISE_UM: Final = 1e-4
"""Standard deviation of the noise of the displacement: small against the range of any stage, far above one ulp."""

SIMULATE: Final = MODES[1]
_HEADER_WORDS: Final = 4
"""Members of `<name>_component_t` before the model: mode, result, committing, answer."""


@dataclass(frozen=True)
class Samples:
    """Inputs of one mode. rows: (n, 3 + channels) bits of y_um, input, auxiliary channels, and the commit flag."""

    mode: Mode
    y0_um: np.float32
    u0_V: np.float32
    rows: Words

    def column(self, place: int) -> NDArray[np.float32]:
        """One column as contiguous float32."""
        return np.ascontiguousarray(self.rows[:, place]).view(np.float32)

    @property
    def commit(self) -> Words:
        return np.ascontiguousarray(self.rows[:, -1])

    @property
    def aux(self) -> NDArray[np.float32]:
        """(n, channels) auxiliary channels."""
        return np.ascontiguousarray(self.rows[:, 2:-1]).view(np.float32)


@dataclass(frozen=True)
class Compared:
    """Samples of one mode in one target, and how many of them have another result or another status word."""

    target: str
    mode: str
    samples: int
    differ: int

    def __str__(self) -> str:
        return f"{self.target:<14} {self.mode:<9} {self.samples} samples, {self.differ} differ"


def compare(
    model: Model, target: str, folder: Path, n: int, options: Options | None = None, progress: Progress | None = None
) -> list[Compared]:
    """Run the target in `folder` over n samples of every mode. Raises BuildError where a tool is missing or fails."""
    chosen = options or Options()
    runners = RUNNERS[target]
    modes = modes_of(model, chosen)
    component = Reference.compile(model, chosen)
    found = []
    for m, mode in enumerate(modes):
        samples = inputs(component, mode, n)
        expected = component.run(samples)
        for r, (name, runner) in enumerate(runners.items()):
            if progress is not None:
                progress((m + r / len(runners)) / len(modes), f"{name}, mode {mode.name}")
            given = runner(model, folder, samples)
            if given.shape != expected.shape:
                raise BuildError(f"{name}, mode {mode.name}: {len(given)} of {n} samples came back")
            found.append(Compared(name, mode.name, n, int(np.any(given != expected, axis=1).sum())))
    return found


@dataclass(frozen=True)
class Reference:
    """The component of a model, compiled on this machine. words: size of its state."""

    model: Model
    library: Library
    words: int

    @classmethod
    def compile(cls, model: Model, options: Options) -> Reference:
        """The component around the generated C. Raises BuildError without a compiler, and the errors of `generate`."""
        name = model.name
        texts = export_texts(model, "shared", options)
        sources = {
            Path(path).name: text for path, text in texts.items() if path.startswith(("model/", f"{name}_component"))
        }
        declared = (
            f"uint32_t {name}_component_start(void *, uint32_t, float, float);\n"
            f"void {name}_component_run(void *, uint32_t, const float *, const float *, const float *,"
            " const uint32_t *, float *, uint32_t *);\n"
        )
        del sources["main.c"]
        known = {struct.name: struct.size for struct in interface(model, inverse=options.inverse).structs}
        words = _HEADER_WORDS + known[f"{name}_t"] + known.get(f"{name}_learner_t", 0)
        return cls(model, build(list(c_files(sources).items()), declared, None, libraries=()), words)

    def run(self, samples: Samples) -> Words:
        """(n, 2) bits of results and status words. Raises BuildError if the component does not have the mode."""
        ffi, name = self.library.ffi, self.model.name
        start, run = (getattr(self.library.lib, f"{name}_component_{function}") for function in ("start", "run"))
        memory = ffi.new("uint32_t[]", self.words)
        if not start(memory, samples.mode.number, samples.y0_um, samples.u0_V):
            raise BuildError(f"{name}: has no mode {samples.mode.name}")
        out = np.empty((2, len(samples.rows)), np.uint32)
        columns = [samples.column(0), samples.column(1), samples.aux]
        floats = [ffi.from_buffer("float *", column) for column in columns]
        commit = ffi.from_buffer("uint32_t *", samples.commit)
        result = ffi.cast("float *", ffi.from_buffer(out[0]))
        run(memory, len(samples.rows), *floats, commit, result, ffi.from_buffer("uint32_t *", out[1]))
        return out.T


def inputs(component: Reference, mode: Mode, n: int) -> Samples:
    """Two sines over the range of the voltage, the model's free run as displacement, and corrupted samples.

    The displacement that a learner is given is 0.2 % larger than the model's, so that it learns and commits.
    """
    numbers = coefficients(component.model)
    random = np.random.default_rng(SEED + mode.number)
    low, high = float(numbers.u_min_V), float(numbers.u_max_V)
    k = np.arange(n + 1)
    wave = 0.6 * np.sin(2 * np.pi * k / 503.0) + 0.39 * np.sin(2 * np.pi * k / 8191.0 + 1.0)
    u = (0.5 * (low + high) + 0.5 * (high - low) * wave).astype(np.float32)
    u0 = np.float32(0.5 * (low + high))
    channels = len(channels_of(component.model.terms))
    rows = np.zeros((n + 1, 3 + channels), np.uint32)
    rows[:, 1] = u.view(np.uint32)
    free = component.run(Samples(SIMULATE, numbers.rest_um, u0, rows))[:, 0].copy().view(np.float32)
    y = np.concatenate([[numbers.rest_um], free[:-1]]) + NOISE_UM * random.standard_normal(n + 1)
    value = u[:-1]
    if mode.name == "inverse":
        value = y[1:].astype(np.float32)
    if mode.name == "learn":
        y = 1.002 * y
    columns = [y[:-1].astype(np.float32), value]
    columns += [random.standard_normal(n).astype(np.float32) for _ in range(channels)]
    for place, column in enumerate(columns):
        column = column.copy()
        bad = np.arange(CORRUPTED_EVERY * (place + 1), n, CORRUPTED_EVERY)
        column[bad] = np.array(CORRUPTED, np.float32)[random.integers(len(CORRUPTED), size=bad.size)]
        rows[:-1, place] = column.view(np.uint32)
    if mode.name == "learn":
        rows[n // COMMITS : -1 : max(1, n // COMMITS), -1] = 1
    return Samples(mode, numbers.rest_um, u0, rows[:-1])


def _run(call: list[str], folder: Path, data: bytes = b"") -> bytes:
    """Standard output of a command. Raises BuildError if the tool is missing or fails."""
    if shutil.which(call[0]) is None and not Path(call[0]).exists():
        raise BuildError(f"{call[0]} is not installed: this target was not compared")
    done = subprocess.run(call, cwd=folder, input=data, capture_output=True, check=False)
    if done.returncode != 0:
        message = (done.stderr or done.stdout).decode(errors="replace").strip().splitlines()
        raise BuildError(f"{' '.join(call[:3])}: {(message or [f'exit code {done.returncode}'])[-1]}")
    return done.stdout


def _three(data: bytes) -> Words:
    """Result and status of rows of result, status, answer."""
    return np.frombuffer(data, np.uint32).reshape(-1, 3)[:, :2]


def _start(samples: Samples) -> list[str]:
    return [str(samples.mode.number), repr(float(samples.y0_um)), repr(float(samples.u0_V))]


def run_standin(model: Model, folder: Path, samples: Samples) -> Words:
    """The S-function under the stand-in of simstruc.h."""
    _run(["make", "-s", "standin/run"], folder)
    return _three(_run([str((folder / "standin" / "run").resolve()), *_start(samples)], folder, samples.rows.tobytes()))


def run_octave(model: Model, folder: Path, samples: Samples) -> Words:
    """The MEX gateway in Octave."""
    row = 3 + len(channels_of(model.terms))
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        Path(scratch, "in.bin").write_bytes(samples.rows.tobytes())
        script = (
            f"addpath('{folder.resolve()}'); if ~exist('{model.name}_mex'), {model.name}_make(); rehash(); end\n"
            f"f = fopen('in.bin'); rows = fread(f, [{row}, Inf], 'uint32=>uint32'); fclose(f);\n"
            "g = @(r) reshape(typecast(reshape(r, [], 1), 'single'), size(r));\n"
            f"[result, status] = {model.name}_mex({samples.mode.number}, single([{_start(samples)[1]}, "
            f"{_start(samples)[2]}]), g(rows(1, :)), g(rows(2, :)), g(rows(3:{row - 1}, :)), rows({row}, :));\n"
            "f = fopen('out.bin', 'w');"
            " fwrite(f, [typecast(result, 'uint32')'; status'; status'], 'uint32'); fclose(f);\n"
        )
        _run(["octave-cli", "--no-gui", "--quiet", "--eval", script], Path(scratch))
        return _three(Path(scratch, "out.bin").read_bytes())


def run_cmake(model: Model, folder: Path, samples: Samples) -> Words:
    """The program run.c of the CMake package."""
    _run(["cmake", "-S", ".", "-B", "build"], folder)
    _run(["cmake", "--build", "build", "--target", f"{model.name}_run"], folder)
    program = (folder / "build" / f"{model.name}_run").resolve()
    return _three(_run([str(program), *_start(samples)], folder, samples.rows.tobytes()))


def run_shared(model: Model, folder: Path, samples: Samples) -> Words:
    """The shared library through ctypes."""
    import ctypes

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


def run_cortexm(model: Model, folder: Path, samples: Samples) -> Words:
    """The Cortex-M program under qemu."""
    _run(["make", "-s", f"{model.name}.elf"], folder)
    start = np.array([samples.y0_um, samples.u0_V], np.float32)
    header = np.array([samples.mode.number], np.uint32).tobytes() + start.tobytes()
    machine = ["-machine", "mps2-an386", "-display", "none", "-serial", "none", "-monitor", "none"]
    semihosting = ["-semihosting-config", "enable=on,target=native"]
    kernel = str((folder / f"{model.name}.elf").resolve())
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        Path(scratch, "input.bin").write_bytes(header + samples.rows.tobytes())
        _run(["qemu-system-arm", *machine, *semihosting, "-kernel", kernel], Path(scratch))
        return _three(Path(scratch, "output.bin").read_bytes())


def run_fmu(standard: int, model: Model, folder: Path, samples: Samples) -> Words:
    """An FMU in FMPy, one communication step per sample."""
    try:
        import fmpy
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave
    except ImportError as fault:
        raise BuildError("FMPy is not installed: pip install 'hysgen[export]'") from fault
    found = {variable.name: variable for variable in fmu_variables(model, options_of(folder))}
    path = str(folder / f"{model.name}_fmi{standard}.fmu")
    description = fmpy.read_model_description(path)
    with tempfile.TemporaryDirectory(prefix="hysgen-") as scratch:
        fmpy.extract(path, scratch)
        kind = FMU2Slave if standard == 2 else FMU3Slave
        fmu = kind(
            guid=description.guid,
            unzipDirectory=scratch,
            modelIdentifier=model.name,
            instanceName="check",
        )
        fmu.instantiate()
        try:
            return _stepped(standard, fmu, found, model, samples)
        finally:
            fmu.terminate()
            fmu.freeInstance()


def _stepped(standard: int, fmu: Any, found: Mapping[str, Variable], model: Model, samples: Samples) -> Words:
    """Results and status words of every sample of an instantiated FMU."""
    set_float, set_word, get_float, get_word = (
        (fmu.setReal, fmu.setInteger, fmu.getReal, fmu.getInteger)
        if standard == 2
        else (fmu.setFloat32, fmu.setUInt32, fmu.getFloat32, fmu.getUInt32)
    )
    inverts = samples.mode.name == "inverse"
    references = [found[name].reference for name in ("y_um", "y_next_um" if inverts else "u_V")]
    references += [variable.reference for variable in found.values() if variable.member.startswith("aux[")]
    result = [found["u_command_V" if inverts else "y_model_um"].reference]
    status = [found["status"].reference]
    if standard == 2:
        fmu.setupExperiment(startTime=0.0)
    set_word([found["mode"].reference], [samples.mode.number])
    set_float([found["y0_um"].reference, found["u0_V"].reference], [float(samples.y0_um), float(samples.u0_V)])
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    values = samples.rows[:, :-1].copy().view(np.float32).astype(float).tolist()
    commits = samples.commit.tolist()
    learns = samples.mode.name == "learn"
    out = np.empty((len(values), 2), np.uint32)
    results = np.empty(len(values), np.float32)
    for k, row in enumerate(values):
        set_float(references, row)
        if learns:
            fmu.setBoolean([found["commit"].reference], [bool(commits[k])])
        fmu.doStep(currentCommunicationPoint=k * model.Ts_s, communicationStepSize=model.Ts_s)
        results[k] = get_float(result)[0]
        out[k, 1] = get_word(status)[0] & 0xFFFFFFFF
    out[:, 0] = results.view(np.uint32)
    return out


def options_of(folder: Path) -> Options:
    """The options with which the C in a folder's model/ was generated."""
    from hysgen.codegen.manifest import read_folder

    return Options(inverse=bool(read_folder(folder / "model").facts["options"]["inverse"]))


Runner = Callable[[Model, Path, Samples], Words]

RUNNERS: Final[Mapping[str, Mapping[str, Runner]]] = {
    "sfunction": {"S-function": run_standin, "Octave": run_octave},
    "fmu": {"FMI 2.0": functools.partial(run_fmu, 2), "FMI 3.0": functools.partial(run_fmu, 3)},
    "cmake": {"CMake": run_cmake},
    "shared": {"ctypes": run_shared},
    "cortexm": {"Cortex-M qemu": run_cortexm},
}
"""Target -> name of a way to run it -> the function that does."""
