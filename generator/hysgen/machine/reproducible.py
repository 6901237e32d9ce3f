"""Arithmetic with the same bits on every machine, for every number that generated files contain; eigenvalues.

IEEE 754 fixes the result of + - * / and sqrt to the last bit. It does not fix the order in which a sum is formed, nor
exp, sin or a power: a BLAS orders its sums by processor and number of threads, and a C library has several versions of
exp for several processors. Sums are therefore formed here in sequence, exp of an array is a polynomial, and functions
of single numbers are computed with `decimal`, whose results are standardised (General Decimal Arithmetic).

LAPACK's eigenvalues differ in the last digits from processor to processor. Here they are only the initial values of
Aberth's iteration in decimal arithmetic, on the characteristic polynomial. The iteration converges so closely that its
result, rounded to float64, does not depend on them.
Sources: Faddeev and Faddeeva, Computational Methods of Linear Algebra (1963), section 47; Aberth, Math. Comp. 27 (1973)
339-344.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal, localcontext
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DIGITS: Final = 50
"""Precision of decimal results before rounding to float64, which has 17 digits: enough for correct rounding."""

# ln 2 in two parts (fdlibm, e_exp.c): products of the first with whole numbers up to 2^20 are exact.
_LN_2_HIGH: Final = 6.93147180369123816490e-01
_LN_2_LOW: Final = 1.90821492927058770002e-10
_PER_LN_2: Final = 1.4426950408889634
# 1/k!, k = 13 .. 2: at |r| <= ln 2 / 2 the first omitted term is 4e-18.
_TAYLOR: Final = tuple(1.0 / math.factorial(k) for k in range(13, 1, -1))
_LEAST_EXPONENT: Final = -746.0


def total(x: Floats, axis: int = -1) -> Floats:
    """The sum over an axis, added from its first number to its last."""
    return functools.reduce(np.add, np.moveaxis(x, axis, 0), np.zeros(np.delete(x.shape, axis)))


def product(matrix: Floats, vector: Floats) -> Floats:
    """matrix @ vector, over the last axis of `matrix`, in a fixed order."""
    return total(matrix * vector)


def exponential(x: Floats) -> Floats:
    """exp(x) of an array, x up to 700: at most 1 unit of the last place from the exact value; 0 below -746."""
    reached = np.maximum(x, _LEAST_EXPONENT)
    n = np.rint(reached * _PER_LN_2)
    r = (reached - n * _LN_2_HIGH) - n * _LN_2_LOW
    series = np.full_like(r, _TAYLOR[0])
    for coefficient in _TAYLOR[1:]:
        series = series * r + coefficient
    return np.asarray(np.ldexp(1.0 + (r + r * r * series), n.astype(np.int32)))


def exp(x: float) -> float:
    """exp of one number, correctly rounded."""
    return float(Context(prec=DIGITS).exp(Decimal(x)))


def expm1(x: float) -> float:
    """exp(x) - 1 of one number above 1e-20 in magnitude, or 0, correctly rounded."""
    with localcontext(Context(prec=DIGITS)):
        return float(Decimal(x).exp() - 1)


def sine(x: float) -> float:
    """sin of one angle in rad, |x| <= 4, correctly rounded."""
    with localcontext(Context(prec=DIGITS)):
        angle = Decimal(x)
        square, term, value, k = -angle * angle, angle, angle, 1
        while abs(term) > Decimal(10) ** (-DIGITS) * abs(angle):
            term *= square / ((k + 1) * (k + 2))
            value, k = value + term, k + 2
        return float(value)


def power(base: float, exponent: int) -> float:
    """base^exponent for a whole exponent, correctly rounded."""
    return float(Context(prec=DIGITS).power(Decimal(base), exponent))


def drawn(rng: np.random.Generator, low: float, high: float, count: int) -> Floats:
    """`count` numbers between low and high, as `rng.uniform` gives them where it rounds both product and sum."""
    return np.asarray(low + (high - low) * rng.random(count))


def geometric(first: float, last: float, count: int) -> list[float]:
    """`count` numbers from `first` to `last`, both included and of one sign, with one ratio between neighbours."""
    with localcontext(Context(prec=DIGITS)):
        ratio = (Decimal(last) / Decimal(first)).ln() / (count - 1)
        return [first, *(float(Decimal(first) * (ratio * k).exp()) for k in range(1, count - 1)), last]


def rounded_up(x: float, digits: int) -> float:
    """The least number of `digits` significant decimal digits that is not below x."""
    return float(Context(prec=digits, rounding=ROUND_CEILING).create_decimal(x)) if math.isfinite(x) else x


def rounded_down(x: float, digits: int) -> float:
    """The largest number of `digits` significant decimal digits that is not above x."""
    return float(Context(prec=digits, rounding=ROUND_FLOOR).create_decimal(x)) if math.isfinite(x) else x


Complex = tuple[Decimal, Decimal]
SparseRows = Sequence[Sequence[tuple[int, Decimal]]]

EIGENVALUE_DIGITS: Final = 120
"""Precision of every decimal operation. Slow states have ten or more roots within 1e-4 of 1, which costs 40 digits."""

CLOSE: Final = Decimal("1e-45")
"""Step of the iteration below which the roots are exact in float64; convergence is cubic."""

MOST_STEPS: Final = 60
PERTURBATION: Final = 1e-10
"""Perturbation of the initial values: equal roots would stay equal, and a conjugate pair would not become two real."""


def spectral_radius(A: Floats) -> float:
    """Largest modulus of the eigenvalues of A, (m, m); infinite if the iteration does not converge."""
    with localcontext(Context(prec=EIGENVALUE_DIGITS)):
        values, converged = roots(characteristic(A), [complex(p) for p in np.linalg.eigvals(A)])
        return float(max(modulus(p) for p in values)) if converged else math.inf


def characteristic(A: Floats) -> list[Decimal]:
    """Coefficients of det(zI - A), falling powers of z, in the present decimal context."""
    m, rows = len(A), sparse(A)
    coefficients = [Decimal(1)]
    # adj(zI - A) = sum_k G_k z^(m-k), G_1 = I, G_(k+1) = A G_k + d_k I, and d_k = -trace(A G_k)/k.
    adjugate = [[Decimal(0)] * m for _ in range(m)]
    for k in range(1, m + 1):
        adjugate = times(rows, adjugate)
        for i in range(m):
            adjugate[i][i] += coefficients[-1]
        coefficients.append(-sum((a * adjugate[j][i] for i, row in enumerate(rows) for j, a in row), Decimal(0)) / k)
    return coefficients


def roots(polynomial: Sequence[Decimal], start: Sequence[complex]) -> tuple[list[Complex], bool]:
    """All roots of a polynomial by Aberth's iteration from initial values, and whether the iteration converged."""
    slope = derivative(polynomial)
    apart = [PERTURBATION * (k + 1) for k in range(len(start))]
    points = [(Decimal(p.real + by), Decimal(p.imag + by / 3.0)) for p, by in zip(start, apart, strict=True)]
    for _ in range(MOST_STEPS):
        largest = Decimal(0)
        for i, p in enumerate(points):
            at = value(polynomial, p)
            if not any(at):
                continue
            # The step N/(N' - N sum 1/(p - p_j)): Newton's step for N divided by the factors of the other roots.
            others = [(p[0] - q[0], p[1] - q[1]) for j, q in enumerate(points) if j != i]
            if not all(map(any, others)):
                return points, False
            real, imag = (sum(part, Decimal(0)) for part in zip((Decimal(0),) * 2, *map(_inverse, others), strict=True))
            lean, pull = value(slope, p), _product(at, (real, imag))
            below = (lean[0] - pull[0], lean[1] - pull[1])
            if not any(below):
                return points, False
            step = quotient(at, below)
            points[i] = (p[0] - step[0], p[1] - step[1])
            largest = max(largest, modulus(step))
        if largest < CLOSE:
            return points, True
    return points, False


def sparse(A: Floats) -> SparseRows:
    """(column, element) of the elements of each row that are not 0."""
    return [[(j, Decimal(float(a))) for j, a in enumerate(row) if a != 0.0] for row in A]


def times(rows: SparseRows, matrix: list[list[Decimal]]) -> list[list[Decimal]]:
    """Product of a sparse matrix and a dense matrix."""
    width = range(len(matrix))
    return [[sum((a * matrix[j][k] for j, a in row), Decimal(0)) for k in width] for row in rows]


def derivative(polynomial: Sequence[Decimal]) -> list[Decimal]:
    """Derivative of a polynomial, coefficients of falling powers."""
    degree = len(polynomial) - 1
    return [c * (degree - k) for k, c in enumerate(polynomial[:-1])]


def value(polynomial: Sequence[Decimal], z: Complex) -> Complex:
    """The polynomial at z."""
    real, imag = Decimal(0), Decimal(0)
    for c in polynomial:
        real, imag = real * z[0] - imag * z[1] + c, real * z[1] + imag * z[0]
    return real, imag


def quotient(a: Complex, b: Complex) -> Complex:
    """a / b."""
    return _product(a, _inverse(b))


def modulus(a: Complex) -> Decimal:
    """|a|."""
    return (a[0] * a[0] + a[1] * a[1]).sqrt()


def _product(a: Complex, b: Complex) -> Complex:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _inverse(a: Complex) -> Complex:
    square = a[0] * a[0] + a[1] * a[1]
    return a[0] / square, -a[1] / square
