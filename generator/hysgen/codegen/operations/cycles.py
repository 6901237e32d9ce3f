"""Cycles of the TMS320C6748 and the budget of a sample period; what is not measured on the target is estimated.

    cycles = 60 + 0.75 operations + 20 branches          (stall-free, gcc 12.2 for the C674x)
    cycles = 200 + 0.45 operations + 20 branches         of a call of learn

Over 94 routines (predict, simulate and inverse of 32 structures, 2 to 50 rules, with and without terms and input
blocks, compiled as in hysgen.c674x) the cycles of the compiled code were 0.74 to 1.23 times the first estimate. The
constant is the latency of the chain exponential, sums, reciprocal; a branch costs its jump and the overlap that it
prevents. The elements of an update do not wait for each other: learners of 6 to 64 parameters, spread over 1 to 10
calls, took 0.78 to 1.2 times the second estimate (benchmarks/target_cycles.py). tests/c674x/test_cost.py holds both to
0.7 .. 1.3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hysgen.codegen.operations.counts import Counts

CLOCK_HZ: Final = 375e6
"""Clock of the paper's DSP."""

STEPS: Final = ("predict", "simulate", "inverse")
BESIDES: Final = ("learn", "commit")

_LATENCY, _PER_OPERATION, _PER_BRANCH = 60.0, 0.75, 20.0
_LEARN_LATENCY, _LEARN_PER_OPERATION = 200.0, 0.45


@dataclass(frozen=True)
class Cycles:
    """Stall-free cycles of one call; `measured` on the target's instruction set, or estimated from operations."""

    value: int
    measured: bool

    def __str__(self) -> str:
        return f"{self.value} cycles" if self.measured else f"about {self.value} cycles (estimate)"


def estimated(counts: Counts, function: str = "predict") -> Cycles:
    """The formula above for a call of `function`, its name without the model's."""
    straight = counts.total - counts.branch
    latency, each = (_LEARN_LATENCY, _LEARN_PER_OPERATION) if function == "learn" else (_LATENCY, _PER_OPERATION)
    return Cycles(round(latency + each * straight + _PER_BRANCH * counts.branch), measured=False)


def cycles_of(operations: Mapping[str, Counts], measured: Mapping[str, int] | None = None) -> dict[str, Cycles]:
    """Cycles of public functions, by their names without the model's: `measured` where known, else estimated."""
    known = measured or {}
    return {
        name: Cycles(known[name], measured=True) if name in known else estimated(counts, name)
        for name, counts in operations.items()
    }


def budget(Ts_s: float, clock_Hz: float = CLOCK_HZ) -> int:
    """Cycles in a sample period: 7500 at 50 kHz and 375 MHz."""
    return int(Ts_s * clock_Hz * (1.0 + 1e-12))


def per_sample(cycles: Mapping[str, Cycles]) -> Cycles:
    """One sample period of a controller: the dearest of STEPS, and all of BESIDES that there are."""
    step = max((cycles[name] for name in STEPS if name in cycles), key=lambda c: c.value)
    parts = [step, *(cycles[name] for name in BESIDES if name in cycles)]
    return Cycles(sum(part.value for part in parts), all(part.measured for part in parts))
