"""Cosine and sine of a 32-bit phase in float32: quadrant by integers, then polynomials.

    phase = quadrant * 2^30 + rest,   r = rest / 2^30 in [-1/2, 1/2)             r = 1 is a quarter of a turn
    sin(pi r / 2) = r ((s_0 + s_1 z) + z^2 (s_2 + s_3 z)),   z = r^2
    cos(pi r / 2) = 1 + z ((c_0 + c_1 z) + z^2 (c_2 + c_3 z))

Worst error against the exact functions, over all phases distinguished by the 23 bits of r: 1.9e-7, of which 1.0e-7 is
the quantisation of r. r is exact: its bits become the significand of a float in [1, 2), minus 1.5.
Coefficients: Chebyshev interpolation in r^2, rounded; tests/model/test_periodic.py computes them again.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from hysgen.model.disturbances.base import Bits, Floats32

SINE: Final = tuple(np.float32(s) for s in (1.57079637, -0.64596349, 0.0796802193, -0.00460214913))
COSINE: Final = tuple(np.float32(c) for c in (-1.23370051, 0.253669411, -0.0208615288, 0.000906739908))
# Half a quadrant, so that the quadrant is the nearest one, and half a step of r, so that r is rounded and not cut.
NEAREST: Final = np.uint32(0x20000040)
FACTS: Final = {"sine": SINE, "cosine": COSINE, "nearest": f"0x{int(NEAREST):08x}"}

_ONE, _ONE_AND_A_HALF = np.float32(1.0), np.float32(1.5)
_REST, _DROPPED_BITS, _ONE_BITS = np.uint32(0x3FFFFFFF), np.uint32(7), np.uint32(0x3F800000)


def cosine_sine(phase: Bits) -> tuple[Floats32, Floats32]:
    """cos and sin of 2 pi phase / 2^32 over lanes, in the generated C's order."""
    shifted = phase + NEAREST
    quadrant = shifted >> np.uint32(30)
    r = (((shifted & _REST) >> _DROPPED_BITS) | _ONE_BITS).view(np.float32) - _ONE_AND_A_HALF
    z = r * r
    zz = z * z
    sine = r * ((SINE[0] + SINE[1] * z) + (SINE[2] + SINE[3] * z) * zz)
    cosine = _ONE + z * ((COSINE[0] + COSINE[1] * z) + (COSINE[2] + COSINE[3] * z) * zz)
    odd = np.uint32(0) - (quadrant & np.uint32(1))
    s, c = sine.view(np.uint32), cosine.view(np.uint32)
    swap = (s ^ c) & odd
    c_sign = ((quadrant + np.uint32(1)) & np.uint32(2)) << np.uint32(30)
    s_sign = (quadrant & np.uint32(2)) << np.uint32(30)
    return ((c ^ swap) ^ c_sign).view(np.float32), ((s ^ swap) ^ s_sign).view(np.float32)
