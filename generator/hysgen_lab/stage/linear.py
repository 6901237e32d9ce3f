"""Linear systems, stepped exactly over substeps for an input that is linear in time within each.

The first-order hold of `scipy.signal.cont2discrete` puts the input into the state, which fits one step length only;
here the input at the begin and at the end of a substep keep weights of their own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Linear:
    """x' = A x + B v, y = c x + d v, stepped exactly over each substep for v linear over it.

    x(t + h) = phi x(t) + g0 v(t) + g1 v(t + h);  phi: (m, n, n), g0 and g1: (m, n), c and rest: (n,)
    rest is the state under a constant v = 1.
    """

    phi: Floats
    g0: Floats
    g1: Floats
    c: Floats
    rest: Floats
    d: float


def oscillator(f_Hz: float, zeta: float) -> tuple[Floats, Floats]:
    """x'' + 2 zeta w x' + w^2 x = w^2 v in the states (x, x'/w)."""
    w = 2 * math.pi * f_Hz
    return np.array([[0.0, w], [-w, -2 * zeta * w]]), np.array([0.0, w])


def exact_steps(A: Floats, B: Floats, c: Floats, d: float, h_s: Floats) -> Linear:
    """Step x' = A x + B v exactly: one matrix exponential per substep length of [A B 0; 0 0 1/h; 0 0 0]."""
    n = len(B)
    steps: dict[float, tuple[Floats, Floats, Floats]] = {}
    for h in {float(h) for h in h_s} if n else ():
        whole = np.zeros((n + 2, n + 2))
        whole[:n, :n], whole[:n, n] = A * h, B * h
        whole[n, n + 1] = 1.0
        power = expm(whole)
        steps[h] = (power[:n, :n], power[:n, n] - power[:n, n + 1], power[:n, n + 1])
    if not n:
        empty = np.zeros((len(h_s), 0))
        return Linear(np.zeros((len(h_s), 0, 0)), empty, empty, c, np.zeros(0), d)
    phi, g0, g1 = (np.stack([steps[float(h)][i] for h in h_s]) for i in range(3))
    rest: Floats = np.asarray(np.linalg.solve(A, -B), dtype=np.float64)
    return Linear(phi, g0, g1, c, rest, d)
