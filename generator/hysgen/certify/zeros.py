"""Poles of the inverse filter (b + T)^-1 and the 1-norm of its impulse response, correctly rounded.

With D(z) = det(zI - A) and M(z) = theta C adj(zI - A) B the terms are T(z) = M/D, and

    (b + T)^-1 = D / (b N),    N(z) = D(z) + M(z)/b                N has the roots eig(A - B theta C/b)
               = 1/b + sum_i r_i / (z - p_i),    r_i = D(p_i) / (b N'(p_i))        where the roots p_i are simple

For poles 1e-6 from the unit circle |r_i|/(1 - |p_i|) loses 6 digits more than the poles, which are computed in
decimal arithmetic (`machine/eigenvalues.py`).
Source: Faddeev and Faddeeva, Computational Methods of Linear Algebra (1963), section 47, for D and adj(zI - A).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext

import numpy as np
from numpy.typing import NDArray

from hysgen.machine.eigenvalues import DIGITS, derivative, modulus, quotient, roots, sparse, times, value

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Rational:
    """D (degree m) and M (lower degree), coefficients of falling powers, and the matrices A, B, theta C."""

    A: Floats
    B: Floats
    theta_C: Floats
    D: tuple[Decimal, ...]
    M: tuple[Decimal, ...]


def rational(A: Floats, B: Floats, theta_C: Floats) -> Rational:
    """D and M of the linear terms A, B, theta C."""
    m = len(B)
    with localcontext(Context(prec=DIGITS)):
        rows = sparse(A)
        b, c = ([Decimal(float(x)) for x in vector] for vector in (B, theta_C))
        D, M = [Decimal(1)], []
        # adj(zI - A) = sum_k G_k z^(m-k), G_1 = I, G_(k+1) = A G_k + d_k I, and d_k = -trace(A G_k)/k.
        adjugate = [[Decimal(0)] * m for _ in range(m)]
        for k in range(1, m + 1):
            adjugate = times(rows, adjugate)
            for i in range(m):
                adjugate[i][i] += D[-1]
            M.append(sum((c[i] * adjugate[i][j] * b[j] for i in range(m) for j in range(m)), Decimal(0)))
            trace = sum((a * adjugate[j][i] for i, row in enumerate(rows) for j, a in row), Decimal(0))
            D.append(-trace / k)
    return Rational(A, B, theta_C, tuple(D), tuple(M))


def zeros(terms: Rational, b: float) -> tuple[float, float]:
    """Largest |p_i|, and 1/|b| + sum |r_i|/(1 - |p_i|): infinite if a |p_i| is 1 or above, or if roots coincide."""
    with localcontext(Context(prec=DIGITS)):
        gain = Decimal(b)
        N = [terms.D[0], *(d + m / gain for d, m in zip(terms.D[1:], terms.M, strict=True))]
        start = np.linalg.eigvals(terms.A - np.outer(terms.B, terms.theta_C) / b)
        poles, converged = roots(N, [complex(p) for p in start])
        moduli = [modulus(p) for p in poles]
        radius = float(max(moduli))
        if radius >= 1.0 or not converged:
            return radius, math.inf
        size = 1 / abs(gain)
        for p, distance in zip(poles, moduli, strict=True):
            residue = modulus(quotient(value(terms.D, p), value(derivative(N), p))) / abs(gain)
            size += residue / (1 - distance)
        return radius, float(size)
