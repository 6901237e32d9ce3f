"""Free run with exact sensitivities to every linear parameter, for Gauss-Newton steps through the simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.kernels.compiled import doubles, kernel
from hysgen.machine.kernels.run import Rules

Floats = NDArray[np.float64]

_DECLARATION = """
int64_t hysgen_sensitivity(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                           const double *w, size_t extras, const double *extra, const double *measured,
                           const double *trust, double *sensitivity, double *hessian, double *gradient, double *sums);
"""


@dataclass(frozen=True)
class FreeRunSums:
    """Sums over a free run, with e = y - measured, weights t and S = dy/d(parameters).

    hessian: sum t S S', (p, p) symmetric; gradient: sum t S e, (p,); square_um2: sum t e^2; weight: sum t.
    """

    hessian: Floats
    gradient: Floats
    square_um2: float
    weight: float
    clamped: int

    @property
    def rms_um(self) -> float:
        """sqrt(sum t e^2 / sum t) in um; 0 if nothing was scored."""
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
    """One segment, started at measured_um[0], which does not depend on the parameters.

        S(k+1) = df/dy S(k) + [p_1 y, p_1 u, p_1, p_2 y, ..., extra(k)]

    u, w, measured, trust: (n,); extra: (n, E) further columns that enter y(k+1) directly. A sample of trust 0 is passed
    through but not scored. Parameters in the order of Model.parameters: p = 3 L + E.
    """
    library = kernel("sensitivity.c", _DECLARATION, "rules.h")
    size = rules.consequents.size + extra.shape[1]
    hessian, gradient, sums = np.zeros((size, size)), np.zeros(size), np.zeros(2)
    clamped = library.lib.hysgen_sensitivity(
        *rules.arguments(library),
        u_V.size,
        doubles(library, u_V),
        doubles(library, w_um),
        extra.shape[1],
        doubles(library, extra),
        doubles(library, measured_um),
        doubles(library, trust),
        doubles(library, np.empty(size)),
        doubles(library, hessian),
        doubles(library, gradient),
        doubles(library, sums),
    )
    full = np.triu(hessian) + np.triu(hessian, 1).T
    return FreeRunSums(full, gradient, float(sums[0]), float(sums[1]), int(clamped))
