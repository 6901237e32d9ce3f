"""The zeros of the inverse and the sum of the moduli of its impulse response, correctly rounded.

With D(z) = det(zI - A) and M(z) = theta C adj(zI - A) B the terms are T(z) = M/D, and

    (b + T)^-1 = D / (b N),    N(z) = D(z) + M(z)/b                N has the roots eig(A - B theta C/b)
               = 1/b + sum_i r_i / (z - p_i),    r_i = D(p_i) / (b N'(p_i))        where the roots p_i are simple

LAPACK's eigenvalues differ in their last digits from processor to processor, and with poles 1e-6 from the circle
|r_i|/(1 - |p_i|) loses 6 digits more. Here they only start Aberth's iteration in decimal numbers: what it ends with,
rounded to float64, is the same whatever it was started from.
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
"""Of every decimal operation. Slow states put ten and more roots within 1e-4 of 1: they cost 40 digits and more."""

CLOSE: Final = Decimal("1e-45")
"""Last step of the roots, whose next one would be below the cube of it; float64 sees 1e-17."""

MOST_STEPS: Final = 60
APART: Final = 1e-10
"""How far the starts are moved apart: equal ones would stay equal, and conjugate ones never become two real ones."""


@dataclass(frozen=True)
class Rational:
    """D and M as coefficients of falling powers, D of degree m, M below it; and the matrices they come from."""

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
        roots, settled = _roots(N, [complex(p) for p in start])
        moduli = [_modulus(p) for p in roots]
        radius = float(max(moduli))
        if radius >= 1.0 or not settled:
            return radius, math.inf
        size = 1 / abs(gain)
        for p, modulus in zip(roots, moduli, strict=True):
            residue = _modulus(_over(_value(terms.D, p), _value(_derivative(N), p))) / abs(gain)
            size += residue / (1 - modulus)
        return radius, float(size)


def _roots(N: Sequence[Decimal], start: Sequence[complex]) -> tuple[list[Complex], bool]:
    """All roots of a polynomial from places nearby, by Aberth's iteration, and whether they came to rest."""
    slope = _derivative(N)
    apart = [APART * (k + 1) for k in range(len(start))]
    roots = [(Decimal(p.real + by), Decimal(p.imag + by / 3.0)) for p, by in zip(start, apart, strict=True)]
    for _ in range(MOST_STEPS):
        largest = Decimal(0)
        for i, p in enumerate(roots):
            value = _value(N, p)
            if not any(value):
                continue
            # The step N/(N' - N sum 1/(p - p_j)): Newton's, with the other roots divided out.
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
    """A matrix given by what is not 0 in its rows, times another one."""
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
