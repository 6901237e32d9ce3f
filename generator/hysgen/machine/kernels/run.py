"""The model over whole records: free run, one step ahead, error against the horizon, and the rules' regressors.

All kernels take the partition as (y_min, y_max, step, first centre) in um, the consequents as (L, 3), and the terms'
share w(k) = theta . phi(k) in um as one array, because it does not depend on y: one kernel serves every term.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, integers, kernel
from hysgen.machine.native import Library

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_DECLARATION = """
int64_t hysgen_free_run(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                        const double *w, double y0, double *out);
int64_t hysgen_one_step(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                        const double *w, const double *measured, double *out);
void hysgen_horizon(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                    const double *w, const double *held, const double *measured, size_t stride, size_t count,
                    const int64_t *horizons, double *square, double *largest, int64_t *starts);
void hysgen_regressors(size_t rules, const double *range, size_t samples, const double *u, const double *y,
                       size_t columns, double *out);
"""


@dataclass(frozen=True)
class Rules:
    """The rules as a kernel sees them: (y_min, y_max, step, first centre) in um, and the consequents (L, 3)."""

    range_um: tuple[float, float, float, float]
    consequents: Floats

    def arguments(self, library: Library) -> tuple[Any, Any, Any]:
        """rules, range and q of every kernel that evaluates the model."""
        return (
            len(self.consequents),
            library.ffi.new("double[4]", list(self.range_um)),
            doubles(library, np.ascontiguousarray(self.consequents)),
        )


def free_run(rules: Rules, u_V: Floats, w_um: Floats, y0_um: float) -> tuple[Floats, int]:
    """y(0) = y0, y(k+1) = f(y(k), u(k)) + w(k). u, w: (n,). Returns y (n,) and how often y was clamped."""
    library = kernel("run.c", _DECLARATION, "rules.h")
    out = np.empty_like(u_V)
    u, w = doubles(library, u_V), doubles(library, w_um)
    clamped = library.lib.hysgen_free_run(*rules.arguments(library), u_V.size, u, w, y0_um, doubles(library, out))
    return out, int(clamped)


def one_step(rules: Rules, u_V: Floats, w_um: Floats, measured_um: Floats) -> tuple[Floats, int]:
    """out(0) = y(0), out(k+1) = f(y(k), u(k)) + w(k) from measured y, (n,). Returns out and how often y was clamped."""
    library = kernel("run.c", _DECLARATION, "rules.h")
    out = np.empty_like(u_V)
    u, w, y = doubles(library, u_V), doubles(library, w_um), doubles(library, measured_um)
    clamped = library.lib.hysgen_one_step(*rules.arguments(library), u_V.size, u, w, y, doubles(library, out))
    return out, int(clamped)


def horizon_errors(
    rules: Rules,
    u_V: Floats,
    w_um: Floats,
    held_um: Floats,
    measured_um: Floats,
    stride: int,
    horizons: Integers,
) -> tuple[Floats, Floats, int]:
    """Error at each of the rising `horizons` after starting from measured y at samples 0, stride, 2 stride, ...

    held: (n,) share of terms that are only known at the start and held from there on.
    Returns the sum of squares and the largest magnitude per horizon, and the number of starts.
    """
    library = kernel("run.c", _DECLARATION, "rules.h")
    square, largest, starts = np.zeros(horizons.size), np.zeros(horizons.size), np.zeros(1, dtype=np.int64)
    library.lib.hysgen_horizon(
        *rules.arguments(library),
        u_V.size,
        doubles(library, u_V),
        doubles(library, w_um),
        doubles(library, held_um),
        doubles(library, measured_um),
        stride,
        horizons.size,
        integers(library, horizons),
        doubles(library, square),
        doubles(library, largest),
        integers(library, starts),
    )
    return square, largest, int(starts[0])


def rule_rows(range_um: tuple[float, float, float, float], rules: int, y_um: Floats, u_V: Floats, out: Floats) -> None:
    """Write [p_1 y, p_1 u, p_1, p_2 y, ...] for every sample into the first 3 L columns of `out`, (n, >= 3 L)."""
    library = kernel("run.c", _DECLARATION, "rules.h")
    library.lib.hysgen_regressors(
        rules,
        library.ffi.new("double[4]", list(range_um)),
        u_V.size,
        doubles(library, u_V),
        doubles(library, y_um),
        out.shape[1],
        doubles(library, out),
    )
