"""The repeatability of a stage, from the levels that a record holds more than once.

A hold is a voltage that stays constant for HOLD_S or longer; its position is the mean of its last half. Two holds
repeat each other if both have the same voltage and the holds before both have the same voltage, too: other visits of a
level differ by the hysteresis of the stage. With y_ij the position of visit j of n_i that repeat each other,

    s^2 = sum_i sum_j (y_ij - mean_j y_ij)^2 / sum_i (n_i - 1)
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from hysgen.record import Record

HOLD_S: Final = 0.01
"""Shortest hold: several time constants of the lag of a stage, and 20 samples at 2 kHz."""

FEWEST_SAMPLES: Final = 16
_SAME_LEVEL: Final = 1e-3
"""Voltages within this part of the range are one level."""


@dataclass(frozen=True)
class Hold:
    """One hold: voltage, mean position; from_V: voltage of the hold before, if any."""

    u_V: float
    y_um: float
    from_V: float | None


@dataclass(frozen=True)
class Repeatability:
    """spread_um: s above with `freedom` degrees of freedom, None if no visit repeats another."""

    spread_um: float | None
    freedom: int
    holds: int

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return dict(vars(self))


def repeatability(record: Record) -> Repeatability:
    """The repeatability of the levels of a record."""
    held = holds(record)
    volts = [hold.u_V for hold in held]
    tolerance_V = max(_SAME_LEVEL * (max(volts) - min(volts)), 1e-9) if volts else 1e-9
    visits: dict[tuple[int, int], list[float]] = defaultdict(list)
    for hold in held:
        if hold.from_V is not None:
            visits[round(hold.from_V / tolerance_V), round(hold.u_V / tolerance_V)].append(hold.y_um)
    repeated = [np.asarray(y) for y in visits.values() if len(y) > 1]
    freedom = sum(y.size - 1 for y in repeated)
    power = sum(float(((y - y.mean()) ** 2).sum()) for y in repeated)
    return Repeatability(float(np.sqrt(power / freedom)) if freedom else None, freedom, len(held))


def holds(record: Record) -> list[Hold]:
    """Every hold of a record, in its order."""
    least = max(FEWEST_SAMPLES, round(HOLD_S / record.Ts_s))
    held: list[Hold] = []
    for segment in record.segments:
        last: float | None = None
        edges = np.flatnonzero(np.diff(segment.u_V)) + 1
        for start, stop in itertools.pairwise([0, *edges.tolist(), segment.samples]):
            if stop - start >= least:
                level = float(segment.u_V[start])
                held.append(Hold(level, float(segment.y_um[start + (stop - start) // 2 : stop].mean()), last))
                last = level
    return held
