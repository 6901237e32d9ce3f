"""Float32 numbers as C text that reads back to the same bits."""

from __future__ import annotations

import numpy as np


def literal(value: np.float32) -> str:
    """`value` with 9 significant digits and the suffix f.

    >>> literal(np.float32(0.1))
    '0.100000001f'

    Raises ValueError if the text would not read back to the same bits, or the value is not finite.
    """
    text = f"{float(value):.9g}"
    if "." not in text and "e" not in text:
        text += ".0"
    if not np.isfinite(value) or bits(np.float32(text)) != bits(value):
        raise ValueError(f"{value!r} has no float32 literal")
    return text + "f"


def bits(value: np.float32) -> str:
    """The bit pattern of `value`.

    >>> bits(np.float32(1.0))
    '0x3f800000'
    """
    return f"0x{int(np.float32(value).view(np.uint32)):08x}"
