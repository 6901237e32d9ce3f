"""Numbers of an interval as C literals."""

from __future__ import annotations

import numpy as np


def hexadecimal(x: float) -> str:
    """A float32 as a C literal without loss of digits.

    >>> hexadecimal(-0.75)
    '-0x1.8p-1f'
    """
    mantissa, exponent = float(np.float32(x)).hex().split("p")
    return f"{mantissa.rstrip('0').rstrip('.') if '.' in mantissa else mantissa}p{int(exponent)}f"
