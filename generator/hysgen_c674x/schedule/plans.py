"""Search for the shortest schedule of a kernel: several plans for each of two selections of its instructions.

No plan is best for every kernel: a long chain of latencies wants the instructions by height, independent columns want
them in the order of the C text, and many values alive want loads and constants late. The plans below were each the best
one for some function of the shipped models and of those under test.
"""

from collections.abc import Mapping
from typing import Final

from hysgen.checking.symbolic.dataflow import Kernel
from hysgen_c674x.schedule.instructions import OutOfRegistersError, Plan, Schedule, Selected, TooLongError
from hysgen_c674x.schedule.precedence import heights, ranked
from hysgen_c674x.schedule.scheduler import planned, unlimited
from hysgen_c674x.schedule.selection import select
from hysgen_c674x.schedule.spilling import OutOfSlotsError, limited

LONG: Final = 500
"""Instructions of a kernel from which on only the plans for long kernels are tried, to stay below 10 s."""

LONGEST_KEPT: Final = 1200
"""Instructions of a kernel from which on every attempt stores values on the stack."""

LONGEST: Final = 1200
"""Instructions of a kernel from which on the plans are those of `learn`, unless the kernel is a chain of latencies."""

_CHAIN: Final = 8
"""Instructions for each cycle of the longest chain of latencies, below which a kernel is such a chain."""

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
    (Plan(100, 0, 0, 4.0), 46, _LOOKAHEAD),
    (Plan(200, 0, 0, 4.0), 46, _LOOKAHEAD),
    (Plan(2000, 0, 0, 0.0), 48, Plan(400, 0, 3, 0.0, saved=True, taper=0.04, ahead=100)),
    (Plan(2000, 0, 0, 0.0), 48, Plan(400, 0, 3, 0.0, saved=True, taper=0.04, ahead=100, tested=60, patience=2)),
    (Plan(2000, 0, 0, 0.0), 50, Plan(600, 0, 3, 0.0, saved=True, taper=0.03, ahead=160, tested=60, patience=4)),
    (Plan(2000, 0, 0, 4.0), 46, Plan(200, 0, 3, 0.5, saved=True, taper=0.08, ahead=100)),
)
_SPILLED_LONGEST: Final = (
    (
        Plan(200, 0, 0, 6.0, room=50, growth=40),
        48,
        Plan(600, 0, 3, 2.0, saved=True, taper=0.02, ahead=100, tested=100, patience=2),
    ),
    (
        Plan(120, 0, 0, 3.0, room=60, growth=40),
        50,
        Plan(600, 0, 3, 4.0, saved=True, taper=0.03, ahead=160, tested=40, patience=8),
    ),
    (
        Plan(200, 0, 0, 6.0, room=50, growth=20),
        48,
        Plan(200, 0, 3, 4.0, saved=True, taper=0.03, ahead=160, tested=60, patience=4),
    ),
)
"""Plan of the order, registers, and plan of the attempts that store values on the stack. Those for the longest kernels
order stores of constants last. They are the three best of 370 random attempts for `learn` of 18 parameters, for six
rules, behind the largest path, and for 12 parameters; another model may gain less from them."""

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
    longest = len(selected.nodes) > max(LONGEST, _CHAIN * max(heights(selected.nodes).values()))
    selected = ranked(selected, constants_last=longest)
    orders: dict[Plan, Mapping[int, int]] = {}
    for order, registers, plan in _SPILLED_LONGEST if longest else _SPILLED:
        if order not in orders:
            orders[order] = unlimited(selected, order)
        try:
            best = _better(best, limited(selected, orders[order], registers), plan, None)
        except OutOfSlotsError:
            continue
    return best
