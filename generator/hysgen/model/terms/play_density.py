"""What weights of play operators say about the density of a Preisach operator, and what a density is like.

A Preisach operator with a density is the integral over r of g(r, z_r), whose slope in z is the density integrated over
the thresholds (Brokate and Sprekels, 1996, chapter 2.4). Plays of half-widths r_j stand for the r around them, so

    mu_m(r_j) = theta_mj / w_j,     w_j the width of the interval around r_j,  m = 1, 2, 3 for the play, T_2 and T_3

are samples of functions of r. The slope is nowhere negative, and neighbouring r are alike: where a record hardly ever
moves a wide play, what its neighbours do is the best that is known of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.model.terms.play_slopes import slopes

Floats = NDArray[np.float64]

LEVELS = 5
"""Places at which the slope of a bent play is kept from turning; it is a parabola, so a little room is left between."""

STEEPEST = (1.0, 4.0, 9.0)
"""Steepest slopes of x, T_2 and T_3 on [-1, 1]: what a weight of each counts, over half the range."""


def rising_rows(r_over_half: Floats, half_V: float, degree: int) -> Floats:
    """(LEVELS m, degree m) slopes g_j'(z) of every play at LEVELS places of its reach; 0 for a play of half-width 0.

    The latter is no part of the density: it is the input itself, and its slope is bounded with the sums of all.
    """
    x = (1.0 - r_over_half) * np.linspace(-1.0, 1.0, LEVELS)[:, None]
    each = slopes(x, np.ones(x.shape, dtype=bool), half_V)[:degree] * (r_over_half > 0.0)
    return np.vstack([np.hstack([np.diag(row) for row in at]) for at in each.transpose(1, 0, 2)])


def roughness_rows(r_over_half: Floats, half_V: float, degree: int) -> Floats:
    """(n, degree m): ||rows @ theta||^2 is sum_m of the integral over rho = r/half of (d^2 mu_m / d rho^2)^2.

    mu_m in the unit of theta_1, the weights of T_2 and T_3 taken by their steepest slopes. Second divided differences
    over three neighbours at a time; fewer than three plays above half-width 0 have no rows.
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
