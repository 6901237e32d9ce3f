"""Constants of the float32 power of two and reciprocal, with their error bounds.

2^x    n = round(x),  f = x - n (exact),  2^x = 2^n ((1 + c1 f) + (f^2 (c2 + c3 f) + f^4 ((c4 + c5 f) + c6 f^2)))
       |x| <= 8: relative error at most 1.2e-7 (polynomial 3.0e-9, the rest is rounding)
1/x    integer seed good to 5.1 %, three Newton steps y <- y (2 - x y)
       2^-120 <= |x| <= 2^120: relative error at most 1.5e-7

The exponential of the memberships is computed as a power of two; log2(e) is part of the grid's scale factor, so the
range reduction is exact and needs no split ln 2. Both routines use float32 `+ - *` and integers only, so C and NumPy
agree in every bit. tests/float32/test_arithmetic.py checks the bounds for every float32 of their intervals and computes
the coefficients again (hysgen.float32.minimax).
"""

from __future__ import annotations

from typing import Final

import numpy as np

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
