"""Compiled float64 kernels for recurrences that would take minutes in Python; here those of the model over a record.

Each C file beside this one is written by hand in float64 and shares no code with the generated float32 C, which is
tested against it. `hysgen.machine.native` compiles a file once per machine and keeps the library in its cache.

    operators     limiters, plays, linear states, Preisach and Duhem columns, filters
    here          free run (with sensitivities), one step ahead, error over the horizon, rules' regressors; recursive
                  and orthogonal least squares, and the innovations of a Kalman filter

`call` compiles and opens the C file of a kernel, and passes NumPy arrays to it as pointers. The kernels of the model
take the partition as (y_min, y_max, step, first centre) in um, the consequents as (L, 3), and the sum of the terms
w(k) = theta . phi(k) in um as one array (n,), because w does not depend on y.
"""

from __future__ import annotations

import functools
import math
import re
from dataclasses import dataclass
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


Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Rules:
    """The rules as arguments of a kernel: (y_min, y_max, step, first centre) in um, and the consequents (L, 3)."""

    range_um: tuple[float, float, float, float]
    consequents: Floats

    @property
    def arguments(self) -> tuple[int, Floats, Floats]:
        """The first three C arguments: number of rules, range and consequents q."""
        return len(self.consequents), np.array(self.range_um), np.ascontiguousarray(self.consequents)


def free_run(rules: Rules, u_V: Floats, w_um: Floats, y0_um: float) -> tuple[Floats, int]:
    """y(0) = y0, y(k+1) = f(y(k), u(k)) + w(k). u, w: (n,). Returns y (n,) and the number of clamped samples."""
    out = np.empty_like(u_V)
    clamped = call("run.c", "hysgen_free_run", *rules.arguments, u_V.size, u_V, w_um, y0_um, out)
    return out, int(clamped)


def one_step(rules: Rules, u_V: Floats, w_um: Floats, measured_um: Floats) -> tuple[Floats, int]:
    """out(0) = y(0), out(k+1) = f(y(k), u(k)) + w(k) measured y: (n,). Returns out and the number of clamped y."""
    out = np.empty_like(u_V)
    clamped = call("run.c", "hysgen_one_step", *rules.arguments, u_V.size, u_V, w_um, measured_um, out)
    return out, int(clamped)


@dataclass(frozen=True, eq=False)
class HorizonInputs:
    """Arrays (n,): voltage, sum of the terms, bias held from the start of each run, measured displacement."""

    u_V: Floats
    w_um: Floats
    held_um: Floats
    measured_um: Floats


def horizon_errors(rules: Rules, inputs: HorizonInputs, stride: int, horizons: Integers) -> tuple[Floats, Floats, int]:
    """Errors after h steps, for each of the rising `horizons` h, of runs started at measured y(0), y(stride), ...

    Returns the sum of squares and the largest magnitude per horizon, and the number of starts.
    """
    square, largest, starts = np.zeros(horizons.size), np.zeros(horizons.size), np.zeros(1, dtype=np.int64)
    call(
        "run.c",
        "hysgen_horizon",
        *rules.arguments,
        inputs.u_V.size,
        inputs.u_V,
        inputs.w_um,
        inputs.held_um,
        inputs.measured_um,
        stride,
        horizons.size,
        horizons,
        square,
        largest,
        starts,
    )
    return square, largest, int(starts[0])


def rule_rows(range_um: tuple[float, float, float, float], rules: int, y_um: Floats, u_V: Floats, out: Floats) -> None:
    """Write [p_1 y, p_1 u, p_1, p_2 y, ...] for every sample into the first 3 L columns of `out`, (n, >= 3 L)."""
    call(
        "run.c",
        "hysgen_regressors",
        rules,
        np.array(range_um),
        u_V.size,
        u_V,
        y_um,
        out.shape[1],
        out,
    )


@dataclass(frozen=True)
class FreeRunSums:
    """Sums over a free run for a Gauss-Newton step, with e = y - measured, weights t and S = dy/d(parameters).

    hessian: sum t S S', (p, p) symmetric; gradient: sum t S e, (p,); square_um2: sum t e^2; weight: sum t.
    """

    hessian: Floats
    gradient: Floats
    square_um2: float
    weight: float
    clamped: int

    @property
    def rms_um(self) -> float:
        """sqrt(sum t e^2 / sum t) in um; 0 if no sample has weight."""
        return math.sqrt(self.square_um2 / self.weight) if self.weight > 0.0 else 0.0

    def __add__(self, other: FreeRunSums) -> FreeRunSums:
        return FreeRunSums(
            self.hessian + other.hessian,
            self.gradient + other.gradient,
            self.square_um2 + other.square_um2,
            self.weight + other.weight,
            self.clamped + other.clamped,
        )


def free_run_sums(
    rules: Rules, u_V: Floats, w_um: Floats, extra: Floats, measured_um: Floats, trust: Floats
) -> FreeRunSums:
    """Free run of one segment from y(0) = measured_um[0], with exact sensitivities S to every linear parameter.

        S(k+1) = df/dy S(k) + [p_1 y, p_1 u, p_1, p_2 y, ..., extra(k)]

    u, w, measured, trust: (n,); extra: (n, E) further columns that enter y(k+1) directly. A sample of trust 0 is
    simulated but not scored. Parameters in the order of Model.parameters: p = 3 L + E.
    """
    size = rules.consequents.size + extra.shape[1]
    hessian, gradient, sums = np.zeros((size, size)), np.zeros(size), np.zeros(2)
    clamped = call(
        "sensitivity.c",
        "hysgen_sensitivity",
        *rules.arguments,
        u_V.size,
        u_V,
        w_um,
        extra.shape[1],
        extra,
        measured_um,
        trust,
        np.empty(size),
        hessian,
        gradient,
        sums,
    )
    full = np.triu(hessian) + np.triu(hessian, 1).T
    return FreeRunSums(full, gradient, float(sums[0]), float(sums[1]), int(clamped))


def rls_updates(regressors: Floats, target: Floats, forgetting: float, q: Floats, P: Floats) -> None:
    """One update by Eq. (10) per row. regressors: (n, p); target: (n,); q (p,), P (p, p): updated in place."""
    call("rls.c", "hysgen_rls", target.size, q.size, regressors, target, forgetting, q, P, np.empty(2 * q.size))


def triangularise(factor: Floats, rows: Floats) -> None:
    """Update a QR factor by new rows: R'^T R' = R^T R + rows^T rows, by Householder reflections.

    factor: R, (m, m) upper triangular, updated in place; rows: (n, m), overwritten. Unlike LAPACK's, the result does
    not depend on the number of threads.
    """
    size = len(factor)
    call("triangular.c", "hysgen_triangular", len(rows), size, factor, rows, np.empty(size))


def innovation_gains(keep: Floats, observed: Floats, misfit: float, noise: float) -> tuple[Floats, Floats]:
    """Gains and innovation variances, (n,) each, of the Kalman filter for z = m + white noise.

        m(k) = keep(k) m(k-1) + sqrt(misfit (1 - keep(k)^2)) w(k)

    keep: (n,) 0 to 1; observed: (n,) 1 where z(k) is measured, else 0; misfit, noise: variances of m and of the noise.
    """
    gain, variance = np.empty(keep.size), np.empty(keep.size)
    call("innovation.c", "hysgen_gains", keep.size, keep, observed, misfit, noise, gain, variance)
    return gain, variance


def innovations(signals: Floats, keep: Floats, gain: Floats, variance: Floats) -> Floats:
    """Innovations of each row of `signals`, (rows, n), over their standard deviations; gain, variance: (n,) each."""
    out = np.array(signals, dtype=np.float64, order="C")
    weight = 1.0 / np.sqrt(variance)
    call("innovation.c", "hysgen_innovations", *out.shape, keep, gain, weight, out)
    return out
