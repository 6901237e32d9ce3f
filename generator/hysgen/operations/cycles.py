"""Cycles of the TMS320C6748 and the budget of a sample period; what is not measured on the target is estimated.

    cycles = 60 + 0.75 operations + 20 branches          (stall-free, gcc 12.2 for the C674x)

Over 94 routines (predict, simulate and inverse of 32 structures, 2 to 50 rules, with and without terms and input
blocks, compiled as in hysgen.target) the cycles of the compiled code were 0.74 to 1.23 times this estimate, those of a
learner of 18 parameters 1.16 times. The constant is the latency of the chain exponential, sums, reciprocal; a branch
costs its jump and the overlap that it prevents. tests/test_cost.py holds the estimate to 0.7 .. 1.3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.operations.counts import Counts

CLOCK_HZ: Final = 375e6
"""Clock of the paper's DSP."""

STEPS: Final = ("predict", "simulate", "inverse")
BESIDES: Final = ("learn", "commit")

_LATENCY, _PER_OPERATION, _PER_BRANCH = 60.0, 0.75, 20.0


@dataclass(frozen=True)
class Cycles:
    """Stall-free cycles of one call; `measured` on the target's instruction set, or estimated from operations."""

    value: int
    measured: bool

    def __str__(self) -> str:
        return f"{self.value} cycles" if self.measured else f"about {self.value} cycles (estimate)"


def estimated(counts: Counts) -> Cycles:
    """The formula above."""
    straight = counts.total - counts.branch
    return Cycles(round(_LATENCY + _PER_OPERATION * straight + _PER_BRANCH * counts.branch), measured=False)


def budget(Ts_s: float, clock_Hz: float = CLOCK_HZ) -> int:
    """Cycles in a sample period: 7500 at 50 kHz and 375 MHz."""
    return int(Ts_s * clock_Hz * (1.0 + 1e-12))


def per_sample(cycles: Mapping[str, Cycles]) -> Cycles:
    """One sample period of a controller: the dearest of STEPS, and all of BESIDES that there are."""
    step = max((cycles[name] for name in STEPS if name in cycles), key=lambda c: c.value)
    parts = [step, *(cycles[name] for name in BESIDES if name in cycles)]
    return Cycles(sum(part.value for part in parts), all(part.measured for part in parts))
