"""Arithmetic with the same bits on every machine, for every number that generated files contain.

IEEE 754 fixes the result of + - * / and sqrt to the last bit. It does not fix the order in which a sum is formed, nor
exp, sin or a power: a BLAS orders its sums by processor and number of threads, and a C library has several versions of
exp for several processors. Sums are therefore formed here in sequence, exp of an array is a polynomial, and functions
of single numbers are computed with `decimal`, whose results are standardised (General Decimal Arithmetic).
"""

import functools
import math
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
    rows = x if axis == 0 else np.moveaxis(x, axis, 0)
    added = np.zeros(rows.shape[1:])
    for row in rows:
        added += row
    return added


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


@functools.lru_cache(1024)
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


def spectral_radius(A: Floats) -> float:
    """A bound of the moduli of the eigenvalues of A, (m, m), whose numbers are off by 8 units at most; with 9 digits.

    No eigenvalue exceeds |S^-1 A S| for any S (rows summed). S holds LAPACK's eigenvectors and X nearly its inverse:
    with |1 - X S| < 1 the norm is at most |X A S| / (1 - |1 - X S|). Sums of m complex products are off by 8 (m + 8)
    units of the sum of magnitudes at most. S = 1 where the eigenvectors are no basis: the bound is then a wide one.
    """
    unit = 2.0**-50 * (len(A) + 8)
    size = np.abs(A)
    bound = size.sum(axis=1).max() * (1.0 + unit)
    try:
        S = np.linalg.eig(A).eigenvectors
        X = np.linalg.inv(S)
    except np.linalg.LinAlgError:
        return rounded_up(float(bound), 9)
    lost = (np.abs(np.eye(len(A)) - X @ S) + unit * (np.abs(X) @ np.abs(S))).sum(axis=1).max()
    within = (np.abs(X @ A @ S) + 3.0 * unit * (np.abs(X) @ size @ np.abs(S))).sum(axis=1).max()
    return rounded_up(float(min(bound, within / (1.0 - lost)) if lost < 1.0 else bound), 9)
