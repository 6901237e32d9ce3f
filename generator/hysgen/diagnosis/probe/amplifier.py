"""The amplifier of the chain: it clips, and it limits the rate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hysgen.diagnosis.probe.chain import Chain
from hysgen.machine.kernels import rate_limited

Floats = NDArray[np.float64]


def amplified(u_V: Floats, chain: Chain, Ts_s: float) -> Floats:
    """What reaches the ceramic.

    c(k) = clamp(u(k), low, high),    v(k) = v(k-1) + clamp(c(k) - v(k-1), -rate Ts, rate Ts)
    """
    out = u_V
    if chain.low_V is not None or chain.high_V is not None:
        out = np.clip(u_V, chain.low_V, chain.high_V)
    if chain.rate_V_per_s is not None:
        out = rate_limited(out, chain.rate_V_per_s * Ts_s)
    return out
