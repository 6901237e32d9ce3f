"""The stack frame of an attempt: units of the saving packets, saved registers, and their restoring at the end."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from hysgen_c674x.schedule import frame
from hysgen_c674x.schedule.attempt import Attempt
from hysgen_c674x.schedule.frame import FrameInstruction, Pair
from hysgen_c674x.schedule.instructions import LOAD_DELAY
from hysgen_c674x.schedule.placement import PACKET


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
