"""Quadratic penalties on the linear parameters, added to the free-run error where a record leaves a choice.

    V(q) = mean over y and over both ends w of the range of  sum_l p_l (v_l - f)^2

    v_l = q_l1 y + q_l2 w + q_l3,    f = sum_l p_l v_l

*Disagreement of the rules*, V: overlapping rules with linear consequents represent the same function f in many ways.
Without V, least squares may choose consequents of hundreds of um that cancel in f, and float32 loses the difference.
*One-step error*: holds the rules that a record visits only during the burn-in, which the free-run error weighs little.
"""

from __future__ import annotations

import numpy as np

from hysgen.fitting.least_squares import Information
from hysgen.machine.kernels import triangularise
from hysgen.model.membership import memberships
from hysgen.model.model import Model
from hysgen.model.regression import Structure, structure_of

POINTS_PER_RULE = 8

ONE_STEP_SHARE = 0.1
"""Penalty of the one-step error at the start, as a part of the free-run error."""

DISAGREEMENT_SHARE = 1e-3
"""Penalty of rules that disagree by one step of the grid (rms), as a part of the free-run error."""

DISAGREEMENT_SHARE_ON_PATH = 1.0
"""The same behind a response of the path (hysteresis, creep, modes). There, rules that disagree overfit: they lower the
error of the identification record and raise the error of the next record."""

Penalties = tuple[tuple[float, Information], ...]
"""(kappa, form) each: the penalty kappa ||form.R q - form.d||^2."""


def penalties_at(model: Model, free_run_um2: float, one_step: Information) -> Penalties:
    """The penalties of a refinement that starts at `model`, whose free run has the square error free_run_um2."""
    structure, single = structure_of(model), one_step.square(model.parameters)
    share = DISAGREEMENT_SHARE_ON_PATH if model.responds else DISAGREEMENT_SHARE
    forms = [(share * free_run_um2 / model.grid.step_um**2, disagreement(structure))]
    if single > 0.0:
        forms.append((ONE_STEP_SHARE * free_run_um2 / single, one_step))
    return tuple(forms)


def disagreement(structure: Structure) -> Information:
    """V(q) = ||R q||^2 in um^2 over all linear parameters; the columns of terms are zero."""
    grid = structure.grid
    y = np.linspace(grid.y_min_um, grid.y_max_um, POINTS_PER_RULE * (grid.rules - 1) + 1)
    p = memberships(y, grid)
    factor = np.zeros((structure.size, structure.size))
    for w in (structure.w_range.low, structure.w_range.high):
        local = np.stack([y, np.full_like(y, w), np.ones_like(y)], axis=1)
        for rule in range(grid.rules):
            # sqrt(p_l) (v_l - f) at every y: -p from f, and 1 from v_l.
            share = -p
            share[:, rule] += 1.0
            rows = np.zeros((y.size, structure.size))
            rows[:, : 3 * grid.rules] = (share[:, :, None] * local[:, None, :]).reshape(y.size, -1)
            rows *= np.sqrt(p[:, rule] / (2.0 * y.size))[:, None]
            triangularise(factor, rows)
    return Information(factor, np.zeros(structure.size), 0.0)
