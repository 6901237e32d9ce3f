"""Poles of the inverse filter (b + T)^-1 and the 1-norm of its impulse response, correctly rounded.

With D(z) = det(zI - A) and M(z) = theta C adj(zI - A) B the terms are T(z) = M/D, and

    (b + T)^-1 = D / (b N),    N(z) = D(z) + M(z)/b                N has the roots eig(A - B theta C/b)
               = 1/b + sum_i r_i / (z - p_i),    r_i = D(p_i) / (b N'(p_i))        where the roots p_i are simple

LAPACK's eigenvalues differ in the last digits from processor to processor, and for poles 1e-6 from the unit circle
|r_i|/(1 - |p_i|) loses 6 further digits. Here LAPACK gives only the initial values of Aberth's iteration in decimal
arithmetic. The iteration converges so closely that its result, rounded to float64, does not depend on them.
Sources: Faddeev and Faddeeva, Computational Methods of Linear Algebra (1963), section 47, for D and adj(zI - A);
Aberth, Math. Comp. 27 (1973) 339-344, for the roots.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = tuple[Decimal, Decimal]

DIGITS: Final = 120
"""Precision of every decimal operation. Slow states have ten or more roots within 1e-4 of 1, which costs 40 digits."""

CLOSE: Final = Decimal("1e-45")
"""Step of the iteration below which the roots are exact in float64; convergence is cubic."""

MOST_STEPS: Final = 60
PERTURBATION: Final = 1e-10
"""Perturbation of the initial values: equal roots would stay equal, and a conjugate pair would not become two real."""


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
        rows = [[(j, Decimal(float(a))) for j, a in enumerate(row) if a != 0.0] for row in A]
        b, c = ([Decimal(float(x)) for x in vector] for vector in (B, theta_C))
        D, M = [Decimal(1)], []
        # adj(zI - A) = sum_k G_k z^(m-k), G_1 = I, G_(k+1) = A G_k + d_k I, and d_k = -trace(A G_k)/k.
        adjugate = [[Decimal(0)] * m for _ in range(m)]
        for k in range(1, m + 1):
            adjugate = _times(rows, adjugate)
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
        roots, converged = _roots(N, [complex(p) for p in start])
        moduli = [_modulus(p) for p in roots]
        radius = float(max(moduli))
        if radius >= 1.0 or not converged:
            return radius, math.inf
        size = 1 / abs(gain)
        for p, modulus in zip(roots, moduli, strict=True):
            residue = _modulus(_over(_value(terms.D, p), _value(_derivative(N), p))) / abs(gain)
            size += residue / (1 - modulus)
        return radius, float(size)


def _roots(N: Sequence[Decimal], start: Sequence[complex]) -> tuple[list[Complex], bool]:
    """All roots of a polynomial by Aberth's iteration from initial values, and whether the iteration converged."""
    slope = _derivative(N)
    apart = [PERTURBATION * (k + 1) for k in range(len(start))]
    roots = [(Decimal(p.real + by), Decimal(p.imag + by / 3.0)) for p, by in zip(start, apart, strict=True)]
    for _ in range(MOST_STEPS):
        largest = Decimal(0)
        for i, p in enumerate(roots):
            value = _value(N, p)
            if not any(value):
                continue
            # The step N/(N' - N sum 1/(p - p_j)): Newton's step for N divided by the factors of the other roots.
            others = [(p[0] - q[0], p[1] - q[1]) for j, q in enumerate(roots) if j != i]
            if not all(map(any, others)):
                return roots, False
            real, imag = (sum(part, Decimal(0)) for part in zip((Decimal(0),) * 2, *map(_inverse, others), strict=True))
            lean, pull = _value(slope, p), _times_complex(value, (real, imag))
            below = (lean[0] - pull[0], lean[1] - pull[1])
            if not any(below):
                return roots, False
            step = _over(value, below)
            roots[i] = (p[0] - step[0], p[1] - step[1])
            largest = max(largest, _modulus(step))
        if largest < CLOSE:
            return roots, True
    return roots, False


def _times(rows: Sequence[Sequence[tuple[int, Decimal]]], matrix: list[list[Decimal]]) -> list[list[Decimal]]:
    """Product of a sparse matrix, given by (column, element) of its rows, and a dense matrix."""
    width = range(len(matrix))
    return [[sum((a * matrix[j][k] for j, a in row), Decimal(0)) for k in width] for row in rows]


def _derivative(polynomial: Sequence[Decimal]) -> list[Decimal]:
    degree = len(polynomial) - 1
    return [c * (degree - k) for k, c in enumerate(polynomial[:-1])]


def _value(polynomial: Sequence[Decimal], z: Complex) -> Complex:
    real, imag = Decimal(0), Decimal(0)
    for c in polynomial:
        real, imag = real * z[0] - imag * z[1] + c, real * z[1] + imag * z[0]
    return real, imag


def _times_complex(a: Complex, b: Complex) -> Complex:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _inverse(a: Complex) -> Complex:
    square = a[0] * a[0] + a[1] * a[1]
    return a[0] / square, -a[1] / square


def _over(a: Complex, b: Complex) -> Complex:
    return _times_complex(a, _inverse(b))


def _modulus(a: Complex) -> Decimal:
    return (a[0] * a[0] + a[1] * a[1]).sqrt()
