"""Memberships of the uniform Gaussian partition, their derivatives, and the regressors of the rules."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.reproducible import exponential, total
from hysgen.model.model import Grid

Floats = NDArray[np.float64]


def memberships(y_um: Floats, grid: Grid) -> Floats:
    """Normalised firing strengths, Eqs (2) and (3).

        p_l(y) = mu_l(y) / sum_j mu_j(y),   mu_l(y) = exp(-(y - c_l)^2 / (2 sigma^2))

    y_um: (n,) displacement, clamped to the grid. Returns (n, L); rows sum to 1.
    """
    distance = (grid.clamp(y_um)[:, None] - grid.centres_um) / grid.step_um
    # The nearest rule has a strength of at least exp(-1/8) inside the grid, so the sum is not zero.
    strength = exponential(-0.5 * distance * distance)
    return np.asarray(strength / total(strength)[:, None])


def membership_slopes(y_um: Floats, grid: Grid) -> Floats:
    """Derivatives dp_l/dy inside the grid, (n, L) in 1/um; rows sum to 0.

    dp_l/dy = p_l (g_l - sum_j p_j g_j),   g_l = -(y - c_l)/sigma^2
    """
    p = memberships(y_um, grid)
    g = -(grid.clamp(y_um)[:, None] - grid.centres_um) / grid.step_um**2
    return np.asarray(p * (g - total(p * g)[:, None]))


def rule_regressors(y_um: Floats, u_V: Floats, grid: Grid) -> Floats:
    """Regressors of the consequents, Eq. (9): [p_1 y, p_1 u, p_1, p_2 y, ...].

    y_um, u_V: (n,). Returns (n, 3 L); y is clamped to the grid here too, so the model is constant in y outside it.
    """
    p = memberships(y_um, grid)
    y = grid.clamp(y_um)
    return np.stack([p * y[:, None], p * u_V[:, None], p], axis=2).reshape(len(y), 3 * grid.rules)
