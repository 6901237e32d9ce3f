"""Joining signals with a limit on the jump from sample to sample, from rest and back to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import HysgenError

Floats = NDArray[np.float64]


class SignalError(HysgenError):
    """A signal does not exist at the sampling period, or jumps by more than allowed."""


def clock(Ts_s: float, duration_s: float) -> Floats:
    """Instants k Ts_s of the samples in [0, duration_s): (round(duration_s / Ts_s),) in s. Raises SignalError."""
    _require_period(Ts_s)
    if not (math.isfinite(duration_s) and duration_s >= Ts_s / 2):
        raise SignalError(f"duration_s: {duration_s} s holds no sample of {Ts_s} s; ask for a longer signal")
    return Ts_s * np.arange(round(duration_s / Ts_s), dtype=np.float64)


def require_resolved(Ts_s: float, f_Hz: float) -> None:
    """Raise SignalError unless a period of f_Hz has 4 samples; with fewer, no sample is near an extreme."""
    _require_period(Ts_s)
    if not (math.isfinite(f_Hz) and 0 < f_Hz <= 0.25 / Ts_s * (1 + 1e-9)):
        limit = 0.25 / Ts_s
        raise SignalError(f"f_Hz: {f_Hz} Hz is not resolved by samples of {Ts_s} s; choose above 0, up to {limit:g} Hz")


def travel(Ts_s: float, from_V: float, to_V: float, duration_s: float) -> Floats:
    """Half a period of a cosine from one level to another, (n,), without the last point; n may be 0."""
    steps = round(duration_s / Ts_s)
    share = np.arange(steps, dtype=np.float64) / max(steps, 1)
    return from_V + (to_V - from_V) * 0.5 * (1.0 - np.cos(math.pi * share))


def largest_jump(u_V: Floats) -> float:
    """Largest |u(k+1) - u(k)| in V of u_V (n,); 0 for a single sample."""
    return float(np.abs(np.diff(u_V)).max(initial=0.0))


def joined(parts: Sequence[Floats], largest_jump_V: float) -> Floats:
    """The parts in sequence, with a smooth transition where the jump between two exceeds largest_jump_V.

    parts: arrays (n_i,) in V. Use: records of several excitations. Raises SignalError without parts, or if a part
    itself jumps by more.
    """
    if not (math.isfinite(largest_jump_V) and largest_jump_V > 0):
        raise SignalError(f"largest_jump_V: {largest_jump_V} V allows no movement; give a voltage above 0")
    filled = [np.asarray(part, dtype=np.float64) for part in parts if len(part)]
    if not filled:
        raise SignalError("parts: nothing to join; give at least one signal with samples")
    for i, part in enumerate(filled):
        if largest_jump(part) > largest_jump_V:
            raise SignalError(f"part {i + 1}: jumps by {largest_jump(part):.4g} V, {largest_jump_V:g} V is allowed")
    whole = [filled[0]]
    for part in filled[1:]:
        from_V, to_V = float(whole[-1][-1]), float(part[0])
        # The cosine is steepest in its middle: pi/2 times the mean slope.
        steps = math.ceil(abs(to_V - from_V) / largest_jump_V * math.pi / 2)
        if abs(to_V - from_V) > largest_jump_V:
            whole.append(travel(1.0, from_V, to_V, steps)[1:])
        whole.append(part)
    return np.concatenate(whole)


def safe(u_V: Floats, rest_V: float, largest_jump_V: float) -> Floats:
    """u_V (n,) with transitions from and to rest_V: first and last sample are rest_V, no jump exceeds largest_jump_V.

    Raises SignalError if u_V itself jumps by more.
    """
    rest = np.array([rest_V], dtype=np.float64)
    return joined([rest, u_V, rest], largest_jump_V)


def _require_period(Ts_s: float) -> None:
    if not (math.isfinite(Ts_s) and Ts_s > 0):
        raise SignalError(f"Ts_s: {Ts_s} s is no sampling period; give a time above 0")
