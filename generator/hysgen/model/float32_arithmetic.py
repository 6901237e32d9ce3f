"""Float32 2^x, 1/x, flush to zero and bit patterns over lanes; coefficients: hysgen.model.float32_constants."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.model import float32_constants as number

Floats32 = NDArray[np.float32]
Words = NDArray[np.uint32]

LEAST_BITS = number.LEAST.view(np.uint32)

_ONE = np.float32(1.0)
_TWO = np.float32(2.0)


def bits_of(x: Floats32) -> Words:
    """The bit patterns of float32 numbers."""
    return np.ascontiguousarray(x, dtype=np.float32).view(np.uint32)


def float_of(bits: Words) -> Floats32:
    """The float32 numbers with the given bit patterns."""
    return bits.view(np.float32)


def power_of_two(x: Floats32) -> Floats32:
    """2^x = 2^n ((1 + c1 f) + (f^2 (c2 + c3 f) + f^4 ((c4 + c5 f) + c6 f^2))),   n = round(x),  f = x - n

    x: lanes with |x| <= POWER_LIMIT. Relative error at most POWER_RELATIVE_ERROR.
    """
    c1, c2, c3, c4, c5, c6 = number.POWER_COEFFICIENTS
    shifted = x + number.ROUNDING
    f = x - (shifted - number.ROUNDING)
    square = f * f
    fourth = square * square
    low = _ONE + c1 * f
    middle = c2 + c3 * f
    high = (c4 + c5 * f) + c6 * square
    mantissa = low + (square * middle + fourth * high)
    # The low bits of `shifted` hold n; the shift moves them into the exponent field and discards the high bits.
    return float_of(bits_of(mantissa) + (bits_of(shifted) << np.uint32(number.MANTISSA_BITS)))


def reciprocal(x: Floats32) -> Floats32:
    """1/x by an integer initial value and Newton steps y <- y (2 - x y); x may be negative.

    x: lanes with RECIPROCAL_LEAST <= |x| <= RECIPROCAL_MOST. Relative error at most RECIPROCAL_RELATIVE_ERROR.
    """
    y = float_of(np.uint32(number.RECIPROCAL_SEED) - bits_of(x))
    for _ in range(number.NEWTON_STEPS):
        y = y * (_TWO - x * y)
    return y


def flushed(x: Floats32) -> Floats32:
    """`x` with magnitudes below 2^-40 replaced by +0, applied to every result before it is returned or stored."""
    bits = bits_of(x)
    return float_of(np.where((bits & np.uint32(number.MAGNITUDE_BITS)) < LEAST_BITS, np.uint32(0), bits))
