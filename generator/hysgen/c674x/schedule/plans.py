"""Search for the shortest schedule of a kernel: several plans for each of two selections of its instructions.

No plan is best for every kernel: a long chain of latencies wants the instructions by height, independent columns want
them in the order of the C text, and many values alive want loads and constants late. The plans below were each the best
one for some function of the shipped models and of those under test.
"""

from __future__ import annotations

from typing import Final

from hysgen.c674x.schedule.dataflow import Kernel
from hysgen.c674x.schedule.scheduler import OutOfRegistersError, Plan, Schedule, TooLongError, planned, unlimited
from hysgen.c674x.schedule.selection import select

LONG: Final = 700
"""Instructions of a kernel from which on only the plans for long kernels are tried, to stay below 10 s."""

_GOOD_ENOUGH: Final = 1.02
"""Cycles, as a multiple of those without limits on registers, at which no further plan is tried."""

_ALL: Final = 1 << 20
_FOREVER: Final = 1 << 20

_SHORT_PLANS: Final = tuple(
    Plan(window, lead, 2, slope, stretch, saved)
    for saved in (False, True)
    for window, lead, slope, stretch in (
        (_ALL, 2, 0.0, 0.0),
        (_ALL, 8, 0.0, 1.0),
        (_ALL, 2, 0.1, 1.0),
        (_ALL, 8, 2.0, 1.0),
        (200, 2, 0.5, 1.0),
        (80, 8, 0.1, 1.0),
    )
)
_LONG_PLANS: Final = (
    Plan(_ALL, 8, 2, 2.0, 1.0, saved=True),
    Plan(200, 8, 2, 0.5, 1.0, saved=True),
    Plan(200, 8, 2, 0.0, 1.0, saved=True),
    Plan(80, 8, 2, 0.1, 1.0, saved=True),
    Plan(_ALL, 2, 2, 0.0, 0.0, saved=True),
)
FRAMED: Final = tuple(plan for plan in _SHORT_PLANS if plan.saved)
"""Plans with a stack frame."""


def shortest(kernel: Kernel) -> Schedule:
    """The shortest schedule found. Raises OutOfRegistersError if no plan has enough registers."""
    best: Schedule | None = None
    instructions = 0
    for near in (_FOREVER, 40):
        selected = select(kernel, near)
        if len(selected.nodes) == instructions:
            break  # no constant is made anew: the same instructions
        instructions = len(selected.nodes)
        issue = unlimited(selected)
        enough = _GOOD_ENOUGH * max(issue.values())
        for plan in _LONG_PLANS if len(selected.nodes) > LONG else _SHORT_PLANS:
            try:
                found = planned(selected, plan, issue, best.cycles if best else _FOREVER)
            except (OutOfRegistersError, TooLongError):
                continue
            if best is None or found.cycles < best.cycles:
                best = found
            if best.cycles <= enough:
                return best
    if best is None:
        raise OutOfRegistersError("no schedule with the registers of the C674x")
    return best
