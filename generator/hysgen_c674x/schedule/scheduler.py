"""List scheduling: a cycle, a unit and a register for every instruction of a kernel.

Cycle by cycle, the instructions whose operands are ready are placed by the longest latency that follows them. A
register is taken when an instruction is issued and returned when the last reader is, so at most one result for it is in
flight: an interrupt between any two packets, after which all results have arrived, changes nothing. A register that was
written in the cycle before is not read over a cross path, which would stall.

The stack frame of an attempt: units of the saving packets, saved registers, and their restoring at the end.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from itertools import count
from typing import Final, TypeAlias

from hysgen_c674x.schedule import frame
from hysgen_c674x.schedule.attempt import Attempt, begun
from hysgen_c674x.schedule.frame import FrameInstruction, Pair
from hysgen_c674x.schedule.instructions import (
    BRANCH_SLOTS,
    LOAD_DELAY,
    PACKET,
    Node,
    OutOfRegistersError,
    Plan,
    Schedule,
    Selected,
    TooLongError,
)
from hysgen_c674x.schedule.placing import place
from hysgen_c674x.schedule.splitting import moved_over


def open_frame(attempt: Attempt) -> None:
    """Take the units and registers that open the stack frame."""
    attempt.frame = frame.entry(attempt.selected.stack)
    occupancy = attempt.occupancy
    for each in attempt.frame:
        occupancy.units[each.cycle].add(each.unit)
        if each.path is None:
            occupancy.ports.add((each.unit, each.cycle))
        else:
            occupancy.carry(each.cycle, each.path)
    occupancy.crossing[0, 0], occupancy.crossed[0, 0] = (1, 15), 2
    side, register = frame.POINTER
    attempt.registers.free[side].discard(register)


def release_saved(attempt: Attempt, cycle: int) -> None:
    """Free the registers that the stores of this cycle have saved."""
    stack = attempt.selected.stack
    for pair in frame.PAIRS:
        if frame.saved_at(pair, stack) == cycle:
            attempt.registers.free[pair.side].update(pair.registers)
    if cycle == _all_saved(stack):
        side, register = frame.POINTER
        attempt.registers.free[side].add(register)


def close_frame(attempt: Attempt, counts: Counter[int]) -> int:
    """Restore each pair behind the last instruction that reads or writes it; the cycle in which all is there.

    counts: instructions of each cycle.
    """
    stack, occupancy = attempt.selected.stack, attempt.occupancy
    quiet = _last_touched(attempt)

    def free_from(pair: Pair) -> int:
        return max(_all_saved(stack) + 1, *(quiet.get((pair.side, each), 0) for each in pair.registers))

    def place(entry: FrameInstruction) -> FrameInstruction:
        while (
            entry.unit in occupancy.units[entry.cycle]
            or (entry.cycle, entry.path) in occupancy.paths
            or (entry.path is None and (entry.unit, entry.cycle) in occupancy.ports)
            or counts[entry.cycle] >= PACKET
        ):
            entry = replace(entry, cycle=entry.cycle + 1)
        occupancy.units[entry.cycle].add(entry.unit)
        if entry.path is not None:
            occupancy.carry(entry.cycle, entry.path)
        counts[entry.cycle] += 1
        attempt.frame.append(entry)
        return entry

    pairs = sorted(frame.PAIRS, key=free_from)
    loads = [place(load) for pair in pairs for load in frame.restored(pair, free_from(pair), stack)]
    end = max(entry.cycle for entry in loads)
    used = max((each.cycle for each in attempt.result if (1, 15) in each.operands), default=0)
    closing = place(frame.closed(max(end, used), stack))
    occupancy.ports.add((closing.unit, closing.cycle))
    return max(end + LOAD_DELAY + 1, closing.cycle + 1)


def _all_saved(stack: int) -> int:
    return max(frame.saved_at(pair, stack) for pair in frame.PAIRS)


def _last_touched(attempt: Attempt) -> dict[tuple[int, int], int]:
    """The last cycle in which each register is read or written."""
    quiet: dict[tuple[int, int], int] = {}
    for each in attempt.result:
        touched = [(each.cycle, operand) for operand in each.operands]
        touched += [(each.cycle, operand) for _, _, operand, _ in each.moves]
        if each.register is not None:
            touched.append((each.cycle + each.node.delay + 1, (each.data_side, each.register)))
        for cycle, register in touched:
            if not isinstance(register, int):
                quiet[register] = max(quiet.get(register, 0), cycle)
    return quiet


_URGENT: Final = 8
"""Oldest instructions, in the order of the C text, for which registers are reserved."""

_CHECKED: Final = 4
"""Cycles between two comparisons of an attempt with the shortest schedule known, which take time."""

_STUCK: Final = 2
"""Cycles without an instruction after which an operand of the oldest one is moved to the other side."""

_PATIENCE: Final = 16
"""Cycles without an instruction after which a schedule has run out of registers."""

_OPENING: Final = 4
"""Cycles at the start in which an instruction may wait for the frame."""

_BY_HEIGHT: Final = Plan(1 << 30, 0, 0, 0.0)

Ready: TypeAlias = tuple[float, float, int, Node]
"""Urgency by height, position in the C text, number of the arrival, instruction."""


def unlimited(selected: Selected, plan: Plan = _BY_HEIGHT) -> dict[int, int]:
    """The cycle of every instruction, by its id, if there were as many registers as one likes."""
    attempt = begun(selected, plan, None, unlimited=True)
    _run(attempt)
    return {key: placement.cycle for key, placement in attempt.placed.items()}


def planned(selected: Selected, plan: Plan, issue: Mapping[int, int] | None, below: int = 1 << 30) -> Schedule:
    """The schedule of one plan; issue: the cycles of `unlimited`, None if loads and constants are in their places.

    Instructions from `spilling` are changed: each list of them serves for one call.

    Raises OutOfRegistersError, and TooLongError if the schedule would take `below` cycles or more.
    """
    attempt = begun(selected, plan, issue, unlimited=False)
    if plan.saved:
        open_frame(attempt)
    _run(attempt, below)
    schedule = _finished(attempt)
    if schedule.cycles >= below:
        raise TooLongError("a shorter schedule is known")
    return schedule


def _run(attempt: Attempt, below: int = 1 << 30) -> None:
    """Place all instructions, cycle by cycle."""
    order, plan = attempt.order, attempt.plan
    by_order = sorted(attempt.selected.nodes, key=lambda node: node.order)
    arrivals = count()

    def entry(node: Node) -> Ready:
        position = order.position[id(node)]
        return plan.slope * position - order.height[id(node)], position, next(arrivals), node

    ready: list[Ready] = []
    cycle, idle, blocked = 0, 0, 0
    oldest: Node | None = None
    while order.left:
        if cycle + 1 >= below:
            raise TooLongError("a shorter schedule is known")
        if plan.saved:
            release_saved(attempt, cycle)
        ready += map(entry, order.arrived(cycle))
        while attempt.oldest < len(by_order) and id(by_order[attempt.oldest]) in attempt.placed:
            attempt.oldest += 1
        attempt.urgent = {id(node) for node in by_order[attempt.oldest : attempt.oldest + _URGENT]}
        if cycle % _CHECKED == 0 and any(cycle + order.height[id(each[-1])] >= below for each in ready):
            raise TooLongError("a shorter schedule is known")
        ready.sort()
        issued, ready = _packet(attempt, cycle, ready)
        idle = 0 if issued or cycle < _OPENING else idle + 1
        stuck = min(ready, key=lambda each: each[1], default=None)
        blocked = blocked + 1 if stuck is not None and stuck[-1] is oldest else 0
        oldest = stuck[-1] if stuck is not None else None
        move = None
        # blocked: cycles for which the oldest instruction has been ready.
        waits = (idle > _STUCK and not order.pending) or (plan.patience > 0 < blocked and blocked % plan.patience == 0)
        if stuck is not None and plan.taper and waits:
            move = moved_over(attempt, stuck[-1], cycle)
        if stuck is not None and move is not None:
            ready.remove(stuck)
            ready.append(entry(move))
            idle = 0
        if idle > _PATIENCE and not (order.pending and order.pending[0][0] > cycle):
            raise OutOfRegistersError("out of registers")
        cycle += 1


def _packet(attempt: Attempt, cycle: int, ready: list[Ready]) -> tuple[int, list[Ready]]:
    """Fill one packet; the number of its instructions, those of the frame among them, and what is still ready."""
    kept: list[Ready] = []
    issued = sum(each.cycle == cycle for each in attempt.frame)
    exhausted: set[tuple[str, int, int | None]] = set()
    for k, candidate in enumerate(ready):
        if issued >= PACKET:
            return issued, kept + ready[k:]
        node = candidate[-1]
        kind = node.units, node.delay, node.side
        placement = None
        if kind not in exhausted and candidate[1] - attempt.oldest < attempt.reach(node):
            placement = place(attempt, node, cycle)
            if placement is None and attempt.occupancy.exhausted(node, cycle):
                exhausted.add(kind)
        if placement is None:
            kept.append(candidate)
        else:
            issued += placement.slots
            attempt.order.issued(node, cycle)
            if attempt.unlimited:
                attempt.count_alive(node)
    return issued, kept


def _finished(attempt: Attempt) -> Schedule:
    """The schedule with its return branch, which takes effect when every result has arrived."""
    result = attempt.result
    last = max((each.cycle for each in result), default=0)
    landed = max((each.cycle + each.node.delay + 1 for each in result), default=0)
    counts = Counter[int]()
    for each in result:
        counts[each.cycle] += each.slots
    for entry in attempt.frame:
        counts[entry.cycle] += 1
    if attempt.plan.saved:
        landed = max(landed, close_frame(attempt, counts))
    branch = max(0, last - BRANCH_SLOTS, landed - BRANCH_SLOTS - 1)
    while "S2" in attempt.occupancy.units[branch] or counts[branch] >= PACKET:
        branch += 1
    placements = sorted(result, key=lambda each: each.cycle)
    return Schedule(placements, branch, branch + BRANCH_SLOTS + 1, attempt.frame)
