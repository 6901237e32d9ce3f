"""What a fit prefers where the record leaves the choice: rules that agree where they fire together, smooth densities.

    V(q) = mean over y and over u in {u_min, u_max} of  sum_l p_l (v_l - f)^2,    v_l = q_l1 y + q_l2 u + q_l3,  f =
    sum_l p_l v_l

Overlapping rules with linear consequents describe the same function in many ways. Where a record leaves the choice
open, least squares may answer with consequents of hundreds of um that cancel in f, which a float32 layer loses; V
prefers those that agree. Likewise for weights that are samples of a density, see `terms.base.Shaped`.
"""

from __future__ import annotations

import numpy as np

from hysgen.fitting.least_squares import Information
from hysgen.machine.kernels import triangularise
from hysgen.model.membership import memberships
from hysgen.model.regression import Structure, rows_of_shaped

POINTS_PER_RULE = 8


def spread(structure: Structure) -> Information:
    """V(q) = ||R q||^2 as square-root information over all linear parameters, in um^2; terms do not enter it."""
    grid = structure.grid
    y = np.linspace(grid.y_min_um, grid.y_max_um, POINTS_PER_RULE * (grid.rules - 1) + 1)
    p = memberships(y, grid)
    factor = np.zeros((structure.size, structure.size))
    for u_V in (structure.u_min_V, structure.u_max_V):
        local = np.stack([y, np.full_like(y, u_V), np.ones_like(y)], axis=1)
        for rule in range(grid.rules):
            # sqrt(p_l) (v_l - f) at every y: f's part with p, and the rule's own.
            share = -p
            share[:, rule] += 1.0
            rows = np.zeros((y.size, structure.size))
            rows[:, : 3 * grid.rules] = (share[:, :, None] * local[:, None, :]).reshape(y.size, -1)
            rows *= np.sqrt(p[:, rule] / (2.0 * y.size))[:, None]
            triangularise(factor, rows)
    return Information(factor, np.zeros(structure.size), 0.0)


def roughness(structure: Structure) -> Information:
    """||roughness @ theta||^2 summed over the terms, as information over all linear parameters; (0, p) without any."""
    rows = rows_of_shaped(structure, lambda term: term.roughness())
    return Information(rows, np.zeros(len(rows)), 0.0)
