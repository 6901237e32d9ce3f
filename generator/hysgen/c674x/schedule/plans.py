"""Search for the shortest schedule of a kernel: several plans for each of two selections of its instructions.

No plan is best for every kernel: a long chain of latencies wants the instructions by height, independent columns want
them in the order of the C text, and many values alive want loads and constants late. The plans below were each the best
one for some function of the shipped models and of those under test.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from hysgen.c674x.schedule.dataflow import Kernel
from hysgen.c674x.schedule.instructions import Selected
from hysgen.c674x.schedule.ordering import ranked
from hysgen.c674x.schedule.placement import OutOfRegistersError, Plan, Schedule, TooLongError
from hysgen.c674x.schedule.scheduler import planned, unlimited
from hysgen.c674x.schedule.selection import select
from hysgen.c674x.schedule.spilling import OutOfSlotsError, limited

LONG: Final = 500
"""Instructions of a kernel from which on only the plans for long kernels are tried, to stay below 10 s."""

LONGEST_KEPT: Final = 1200
"""Instructions of a kernel from which on every attempt stores values on the stack."""

LONGEST: Final = 2500
"""Instructions of a kernel from which on the plans are those of `learn`, which is not a chain of latencies."""

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
_FRAMED_LONG: Final = (
    Plan(_ALL, 8, 2, 2.0, 1.0, saved=True),
    Plan(200, 8, 2, 0.5, 1.0, saved=True),
    Plan(200, 8, 2, 0.0, 1.0, saved=True),
    Plan(80, 8, 2, 0.1, 1.0, saved=True),
    Plan(_ALL, 2, 2, 0.0, 0.0, saved=True),
)
_LOOKAHEAD: Final = Plan(400, 0, 3, 0.1, saved=True, taper=0.04, ahead=160)
_SPILLED: Final = (
    (100, 4.0, 46, _LOOKAHEAD),
    (200, 4.0, 46, _LOOKAHEAD),
    (2000, 0.0, 48, Plan(400, 0, 3, 0.0, saved=True, taper=0.04, ahead=100)),
    (2000, 4.0, 46, Plan(200, 0, 3, 0.5, saved=True, taper=0.08, ahead=100)),
)
_SPILLED_LONGEST: Final = (
    (200, 1.5, 48, Plan(600, 0, 3, 2.0, saved=True, taper=0.06, ahead=300)),
    (200, 6.0, 50, Plan(600, 0, 3, 0.5, saved=True, taper=0.03, ahead=200)),
    (100, 4.0, 46, _LOOKAHEAD),
)
"""Window and slope of the order, registers and plan of the attempts that store values on the stack. Those for the
longest kernels order stores of constants last; the first two are the shortest of up to 60 random attempts for the
`learn` of one model each, so another model may gain less from them."""

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
        if instructions > LONG:
            break
        instructions = len(selected.nodes)
        if instructions > LONGEST_KEPT:
            continue
        issue = unlimited(selected)
        enough = _GOOD_ENOUGH * max(issue.values())
        for plan in _FRAMED_LONG if instructions > LONG else _SHORT_PLANS:
            best = _better(best, selected, plan, issue)
            if best is not None and best.cycles <= enough:
                return best
    if instructions > LONG:
        best = _with_spilling(kernel, best)
    if best is None:
        raise OutOfRegistersError("no schedule with the registers of the C674x")
    return best


def _better(best: Schedule | None, selected: Selected, plan: Plan, issue: Mapping[int, int] | None) -> Schedule | None:
    try:
        return planned(selected, plan, issue, best.cycles if best else _FOREVER)
    except (OutOfRegistersError, TooLongError):
        return best


def _with_spilling(kernel: Kernel, best: Schedule | None) -> Schedule | None:
    """The shortest schedule, among them those of instructions with a limited number of values alive."""
    selected = select(kernel, far=_FOREVER)
    longest = len(selected.nodes) > LONGEST
    selected = ranked(selected, constants_last=longest)
    orders: dict[tuple[int, float], Mapping[int, int]] = {}
    for window, slope, registers, plan in _SPILLED_LONGEST if longest else _SPILLED:
        if longest and best is not None and plan is _LOOKAHEAD:
            break  # one attempt more takes a second, and was not the shortest of the two models tried
        if (window, slope) not in orders:
            orders[window, slope] = unlimited(selected, window, slope)
        try:
            best = _better(best, limited(selected, orders[window, slope], registers), plan, None)
        except OutOfSlotsError:
            continue
    return best
