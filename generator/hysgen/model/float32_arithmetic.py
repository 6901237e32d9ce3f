"""Float32 arithmetic over lanes: 2^x, 1/x, flush to zero, bit patterns, sums in two words; constants, error bounds.

2^x    n = round(x),  f = x - n (exact),  2^x = 2^n ((1 + c1 f) + (f^2 (c2 + c3 f) + f^4 ((c4 + c5 f) + c6 f^2)))
       |x| <= 8: relative error at most 1.2e-7 (polynomial 3.0e-9, the rest is rounding)
1/x    integer seed good to 5.1 %, three Newton steps y <- y (2 - x y)
       2^-120 <= |x| <= 2^120: relative error at most 1.5e-7

The exponential of the memberships is computed as a power of two; log2(e) is part of the grid's scale factor, so the
range reduction is exact and needs no split ln 2. Both routines use float32 `+ - *` and integers only, so C and NumPy
agree in every bit. tests/float32/test_arithmetic.py checks the bounds for every float32 of their intervals and computes
the coefficients again (benchmarks/minimax.py).

    step = (delta + K) - K            K = 1.5 * 2^-37: steps below 2^-61 become 0
    t    = low + step
    sum  = high + t
    low' = t - (sum - high)           rounding error of the sum, exact for |t| <= |high|
    high' = sum, or 0 where |sum| >= LIMIT or not finite

A creep state of 10 s at 50 kHz moves by 2e-6 of its input per sample: below the last bit of one float, but not below
the last bit of `low`. A decaying state ends at 0 and not at a denormal number, since inputs and steps are multiples of
2^-63. For |t| > |high| (a zero crossing) the error is at most the last bit of t. Valid states are far below LIMIT; the
limit bounds the state after one sample even if memory was corrupted.
Source: Dekker, A floating-point technique for extending the available precision (1971), Fast2Sum.
"""

import functools
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hysgen.model.intervals import Interval, symmetric

# Adding 1.5 * 2^23 leaves a float32 whose last mantissa bits are the nearest integer, ties to even.
ROUNDING: Final = np.float32(12582912.0)
MANTISSA_BITS: Final = 23

# c1 .. c6: minimax of the relative error over |f| <= 1/2, rounded to float32 one after the other.
POWER_COEFFICIENTS: Final = (
    np.float32(0.6931471824645996),
    np.float32(0.24022647738456726),
    np.float32(0.05550359934568405),
    np.float32(0.009618505835533142),
    np.float32(0.0013390806270763278),
    np.float32(0.00015326471475418657),
)
POWER_LIMIT: Final = 8.0
POWER_RELATIVE_ERROR: Final = 1.2e-7

# Bits of the reciprocal's seed: subtracting the bits of x negates its exponent and, roughly, inverts its mantissa.
RECIPROCAL_SEED: Final = 0x7EF311C7
NEWTON_STEPS: Final = 3
RECIPROCAL_LEAST: Final = 2.0**-120
RECIPROCAL_MOST: Final = 2.0**120
RECIPROCAL_RELATIVE_ERROR: Final = 1.5e-7

MAGNITUDE_BITS: Final = 0x7FFFFFFF
INFINITY_BITS: Final = 0x7F800000
# Magnitudes below 2^-40 (1e-12 um, 1e-12 V) are set to zero. No denormal number then reaches a comparison or a result,
# and processors with and without flush-to-zero compute the same bits.
LEAST: Final = np.float32(2.0**-40)


Floats32 = NDArray[np.float32]
Words = NDArray[np.uint32]

LEAST_BITS = LEAST.view(np.uint32)

_ONE = np.float32(1.0)
_TWO = np.float32(2.0)


def bits_of(x: Floats32) -> Words:
    """The bit patterns of float32 numbers."""
    return np.ascontiguousarray(x, dtype=np.float32).view(np.uint32)


def float_of(bits: Words) -> Floats32:
    """The float32 numbers with the given bit patterns."""
    return bits.view(np.float32)


@functools.singledispatch
def power_of_two(x: Floats32) -> Floats32:
    """2^x = 2^n ((1 + c1 f) + (f^2 (c2 + c3 f) + f^4 ((c4 + c5 f) + c6 f^2))),   n = round(x),  f = x - n

    x: lanes with |x| <= POWER_LIMIT. Relative error at most POWER_RELATIVE_ERROR.
    """
    c1, c2, c3, c4, c5, c6 = POWER_COEFFICIENTS
    shifted = x + ROUNDING
    f = x - (shifted - ROUNDING)
    square = f * f
    fourth = square * square
    low = _ONE + c1 * f
    middle = c2 + c3 * f
    high = (c4 + c5 * f) + c6 * square
    mantissa = low + (square * middle + fourth * high)
    # The low bits of `shifted` hold n; the shift moves them into the exponent field and discards the high bits.
    return float_of(bits_of(mantissa) + (bits_of(shifted) << np.uint32(MANTISSA_BITS)))


@functools.singledispatch
def nearest(x: Floats32) -> tuple[Words, Floats32]:
    """The nearest integer n >= 0, as an index, and x - n, which is exact."""
    shifted = x + ROUNDING
    return bits_of(shifted) - bits_of(np.asarray(ROUNDING)), x - (shifted - ROUNDING)


@functools.singledispatch
def reciprocal(x: Floats32) -> Floats32:
    """1/x by an integer initial value and Newton steps y <- y (2 - x y); x may be negative.

    x: lanes with RECIPROCAL_LEAST <= |x| <= RECIPROCAL_MOST. Relative error at most RECIPROCAL_RELATIVE_ERROR.
    """
    y = float_of(np.uint32(RECIPROCAL_SEED) - bits_of(x))
    for _ in range(NEWTON_STEPS):
        y = y * (_TWO - x * y)
    return y


@functools.singledispatch
def flushed(x: Floats32) -> Floats32:
    """`x` with magnitudes below 2^-40 replaced by +0, applied to every result before it is returned or stored."""
    bits = bits_of(x)
    return float_of(np.where((bits & np.uint32(MAGNITUDE_BITS)) < LEAST_BITS, np.uint32(0), bits))


FLOOR: Final = np.float32(1.5 * 2.0**-37)
LIMIT: Final = np.float32(2.0**20)
FACTS: Final = {"floor": FLOOR, "limit": LIMIT}
KEPT: Final[Interval] = symmetric(float(LIMIT))
"""What `high` never leaves, in the unit of the state; and `low` neither, which is far smaller in truth."""

_MAGNITUDE: Final = np.uint32(0x7FFFFFFF)


def accumulate(high: Floats32, low: Floats32, delta: Floats32) -> tuple[Floats32, Floats32]:
    """(high, low) + delta, in the generated C's order; float32 throughout."""
    step = (delta + FLOOR) - FLOOR
    t = low + step
    total = high + t
    return _inside(total), t - (total - high)


def inside(x: Floats32) -> Floats32:
    """x, or 0 where |x| >= LIMIT or it is not finite; flushed."""
    return flushed(_inside(x))


def _inside(x: Floats32) -> Floats32:
    magnitude = np.ascontiguousarray(x).view(np.uint32) & _MAGNITUDE
    return np.where(magnitude < LIMIT.view(np.uint32), x, np.float32(0.0))
