"""The density of a Preisach operator from the weights of play operators: sign and roughness.

A Preisach operator with a density is the integral over r of g(r, z_r), whose slope in z is the density integrated over
the thresholds (Brokate and Sprekels, 1996, chapter 2.4). A play of half-width r_j represents an interval of r, so

    mu_m(r_j) = theta_mj / w_j,     w_j the width of the interval around r_j,  m = 1, 2, 3 for the play, T_2 and T_3

are samples of functions of r. The slope is not negative, and the functions are smooth in r: the weight of a wide play
that rarely moves in a record is interpolated between those of its neighbours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.model.terms.play_slopes import slopes

Floats = NDArray[np.float64]

LEVELS = 5
"""Points at which the slope of a play with polynomials is constrained; it is a parabola and may be negative between."""

STEEPEST = (1.0, 4.0, 9.0)
"""Largest slopes of x, T_2 and T_3 on [-1, 1], which scale their weights."""


def rising_rows(r_over_half: Floats, half_V: float, degree: int) -> Floats:
    """(LEVELS m, degree m) slopes g_j'(z) of every play at LEVELS points of its reach; 0 for a play of half-width 0.

    A play of half-width 0 is the past input and not part of the density; the small-gain condition bounds its slope.
    """
    x = (1.0 - r_over_half) * np.linspace(-1.0, 1.0, LEVELS)[:, None]
    each = slopes(x, np.ones(x.shape, dtype=bool), half_V)[:degree] * (r_over_half > 0.0)
    return np.vstack([np.hstack([np.diag(row) for row in at]) for at in each.transpose(1, 0, 2)])


def roughness_rows(r_over_half: Floats, half_V: float, degree: int) -> Floats:
    """(n, degree m): ||rows @ theta||^2 is sum_m of the integral over rho = r/half of (d^2 mu_m / d rho^2)^2.

    mu_m in the unit of theta_1: the weights of T_2 and T_3 are scaled by their largest slopes. Second divided
    differences over three neighbours; no rows for fewer than three plays with half-widths above 0.
    """
    m = r_over_half.size
    first = int(np.count_nonzero(r_over_half == 0.0))
    rho = r_over_half[first:]
    width = np.diff(np.concatenate([[0.0], 0.5 * (rho[1:] + rho[:-1]), [1.0]]))
    rows = []
    for i in range(rho.size - 2):
        near = rho[i : i + 3]
        apart = near[:, None] - near + np.eye(3)
        difference = 2.0 / apart.prod(axis=1) * np.sqrt(0.5 * (near[2] - near[0])) / width[i : i + 3]
        for power, steepest in enumerate(STEEPEST[:degree]):
            row = np.zeros(degree * m)
            row[power * m + first + i : power * m + first + i + 3] = difference * (
                steepest if power == 0 else steepest / half_V
            )
            rows.append(row)
    return np.array(rows).reshape(-1, degree * m)
