"""Minimax polynomials by linear programming, the source of the coefficients in hysgen.model.float32_arithmetic.

    minimise  max_x |P(x) / f(x) - 1|     over the free coefficients of P, x on a Chebyshev grid

which is a linear programme in the coefficients and the bound. The coefficients are rounded to float32 one by one, the
lowest power first; after each rounding the remaining coefficients are fitted again and compensate the rounding error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import factorial, log

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

Floats = NDArray[np.float64]

GRID = 1501


def power_coefficients(degree: int = 6) -> tuple[tuple[np.float32, ...], float]:
    """c1 .. c<degree> of 2^f = 1 + c1 f + c2 f^2 + ..., |f| <= 1/2, and the largest relative error."""
    held, error = [1.0], 0.0
    for _ in range(degree):
        free, error = minimax(np.exp2, 0.5, held, _taylor(degree))
        held.append(float(np.float32(free[0])))
    return tuple(np.float32(c) for c in held[1:]), error


def minimax(
    f: Callable[[Floats], Floats], reach: float, held: Sequence[float], guess: Sequence[float]
) -> tuple[Floats, float]:
    """Coefficients of x^len(held), ..., that minimise the relative error on [-reach, reach], and the least error.

    held: fixed coefficients of the lowest powers; guess: all coefficients, near the solution. The programme is solved
    for the difference from `guess`, in units of the error of `guess`: differences of that size exceed the solver's
    tolerances.
    """
    x = reach * np.cos(np.pi * np.arange(GRID) / (GRID - 1))
    first, count = len(held), len(guess) - len(held)
    basis = np.array([(x / reach) ** k / f(x) for k in range(first, len(guess))]).T
    start = np.array([c * reach**k for k, c in enumerate(guess)])[first:]
    missing = 1.0 - sum(c * x**k for k, c in enumerate(held)) / f(x) - basis @ start
    unit = float(np.abs(missing).max())
    bound = -np.ones((GRID, 1))
    programme = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.block([[basis, bound], [-basis, bound]]),
        b_ub=np.concatenate([missing, -missing]) / unit,
        bounds=[(None, None)] * (count + 1),
        method="highs",
    )
    solution = np.asarray(programme.x)
    coefficients = (start + unit * solution[:-1]) / reach ** np.arange(first, len(guess))
    return coefficients, unit * float(solution[-1])


def _taylor(degree: int) -> list[float]:
    return [log(2.0) ** k / factorial(k) for k in range(degree + 1)]
