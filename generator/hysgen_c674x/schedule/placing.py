"""A unit and a register for one instruction in one cycle, if there are any."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from hysgen_c674x.schedule.attempt import Attempt, source
from hysgen_c674x.schedule.instructions import MIRRORED, Both, Node, Operand
from hysgen_c674x.schedule.placement import PREDICATES, Placement, Register
from hysgen_c674x.schedule.register_choice import chosen, even

_SWAPPED: Final = frozenset({"addsp", "mpysp", "add", "and", "or", "xor", "mpy32", "cmpeq", "cmpeqsp", *MIRRORED})
"""Instructions whose operands may be exchanged, those of some comparisons with another mnemonic."""


def place(attempt: Attempt, node: Node, cycle: int) -> Placement | None:
    """Place an instruction in a cycle; None if it does not fit."""
    sides: Sequence[int]
    reserved = attempt.registers.reserved.get(id(node))
    if node.in_place:
        (operand,) = node.operands
        assert isinstance(operand, Node)
        sides = (attempt.placed[id(operand)].data_side,)
    elif reserved is not None:
        sides = (reserved[0],)
    else:
        sides = (node.side,) if node.side is not None else _preferred(attempt, node)
    kind = _access if node.memory else _choice if node.mnemonic == "select" else _operation
    for side in sides:
        found = kind(attempt, node, cycle, side)
        if found is not None:
            return found
    return None


def _preferred(attempt: Attempt, node: Node) -> tuple[int, int]:
    """The sides, the better first: few crossing operands, near the partners of the users, with free registers."""
    cost = [0.0, 0.0]
    for operand in node.operands:
        if isinstance(operand, Node):
            cost[1 - attempt.placed[id(operand)].data_side] += 3.0
    for user in attempt.order.consumers[id(node)][:4]:
        if user.side is not None:
            cost[1 - user.side] += 2.0
        for partner in user.operands:
            if isinstance(partner, Node) and partner is not node and id(partner) in attempt.placed:
                cost[1 - attempt.placed[id(partner)].data_side] += 2.0
    for side in (0, 1):
        cost[side] += 0.08 * (23 - len(attempt.registers.free[side]))
    return (0, 1) if cost[0] <= cost[1] else (1, 0)


def _operation(attempt: Attempt, node: Node, cycle: int, side: int) -> Placement | None:
    """An instruction that neither loads nor stores, by a unit of one side."""
    operands = list(node.operands)
    own = [attempt.operand(operand, side) for operand in operands]
    crossing = [k for k, operand in enumerate(own) if not isinstance(operand, int) and operand[0] != side]
    kinds = node.units
    if len(crossing) > 1:
        return None
    if crossing:
        (k,) = crossing
        if node.mnemonic == "clr" or not _crosses(attempt, operands[k], own[k], cycle, side):
            return None
        if k == 0 and len(operands) > 1 and not isinstance(own[1], int):  # the second source crosses
            if node.mnemonic in ("sub", "subsp"):
                kinds = kinds.replace("D", "")
            elif node.mnemonic in _SWAPPED:
                own.reverse()
                operands.reverse()
            else:
                return None
    unit = attempt.occupancy.unit(node, kinds, cycle, side)
    if unit is None or not attempt.occupancy.readable(cycle, own):
        return None
    register = chosen(attempt, node, cycle, side, operands)
    if register is None:
        return None
    mirrored = operands != node.operands and node.mnemonic in MIRRORED
    entered = _mirrored(node) if mirrored else node
    placement = Placement(entered, cycle, unit, side, side, register, tuple(own), bool(crossing), None)
    _commit(attempt, node, placement, [source(operand, side) for operand in operands])
    return placement


def _access(attempt: Attempt, node: Node, cycle: int, preferred: int) -> Placement | None:
    """A load to, or a store from, the preferred side, by the unit of either side."""
    store = not node.writes
    value = source(node.operands[1], preferred) if store else None
    data = attempt.placed[id(value)].data_side if value is not None else preferred
    if (cycle, data) in attempt.occupancy.paths:
        return None
    guard: Register | None = None
    if node.guard is not None:
        tested = attempt.operand(node.guard, 0)
        assert not isinstance(tested, int)
        guard = tested
    for side in (data, 1 - data):
        base = node.operands[0]
        own = attempt.operand(base, side)
        unit = f"D{side + 1}"
        assert not isinstance(own, int)
        if own[0] != side or unit in attempt.occupancy.units[cycle]:
            continue
        operands: list[Register | int] = [own]
        sources = [source(base, side), value, node.guard]
        if value is not None:
            operands.append(attempt.operand(value, data))
        if node.mnemonic == "stdw":
            sources.append(source(node.operands[2], data))
            operands.append(attempt.operand(node.operands[2], data))
        if not attempt.occupancy.readable(cycle, operands):
            continue
        register = None
        if not store:
            register = even(attempt, node, data) if node.second else chosen(attempt, node, cycle, data)
        if register is None and not store:
            return None
        attempt.occupancy.carry(cycle, data)
        placement = Placement(node, cycle, unit, side, data, register, tuple(operands), False, guard)
        other = base.sides[1 - side] if isinstance(base, Both) else None
        _commit(attempt, node, placement, [*sources, other])
        if node.second is not None:
            assert register is not None
            attempt.placed[id(node.second)] = replace(placement, node=node.second, register=register + 1)
            attempt.registers.free[data].discard(register + 1)
        return placement
    return None


def _choice(attempt: Attempt, node: Node, cycle: int, side: int) -> Placement | None:
    """A choice as one predicated move onto the other operand, or as two moves to a register of its own."""
    condition, *choices = node.operands
    guard = attempt.operand(condition, side)
    assert not isinstance(guard, int)
    own = [attempt.operand(choice, side) for choice in choices]
    sources = [source(choice, side) for choice in choices]
    keep = next((k for k in (1, 0) if own[k] != guard and _stays(attempt, node, sources[k], side)), None)
    moving = [k for k in (0, 1) if k != keep]
    taken: list[str] = []
    moves: list[tuple[str, bool, Register | int, bool]] = []
    crossing: Register | None = None
    for k in moving:
        operand = own[k]
        cross = not isinstance(operand, int) and operand[0] != side
        if cross:
            assert not isinstance(operand, int)
            if not _crosses(attempt, choices[k], operand, cycle, side):
                return None
            if crossing is not None and (crossing != operand or attempt.occupancy.crossed[cycle, side]):
                return None
            crossing = operand
        unit = attempt.occupancy.unit(node, "DLS", cycle, side, taken)
        if unit is None:
            return None
        taken.append(unit)
        moves.append((unit, k == 1, operand, cross))
    if not attempt.occupancy.readable(cycle, [own[k] for k in moving]):
        return None
    kept = None if keep is None else sources[keep]
    if kept is None:
        target = chosen(attempt, node, cycle, side)
        if target is None:
            return None
    else:
        target = attempt.placed[id(kept)].register
        attempt.order.uses[id(kept)] = -1  # its register is now that of the result
    placement = Placement(node, cycle, taken[0], side, side, target, (), False, guard, tuple(moves))
    _commit(attempt, node, placement, [source(condition, side), *(sources[k] for k in moving)])
    return placement


def _stays(attempt: Attempt, node: Node, operand: Node | None, side: int) -> bool:
    """Whether a choice can leave its result in the register of an operand."""
    if operand is None or operand.mnemonic == "param" or node.pair is not None:
        return False
    placement = attempt.placed[id(operand)]
    testable = not node.predicate or placement.register in PREDICATES[0]
    return placement.data_side == side and attempt.order.uses[id(operand)] == 1 and testable


def _crosses(attempt: Attempt, operand: Operand, register: Register | int, cycle: int, side: int) -> bool:
    """Whether an operand can come over the cross path."""
    node = source(operand, side)
    assert node is not None
    assert not isinstance(register, int)
    return attempt.crossable(node, cycle) and attempt.occupancy.cross_free(cycle, side, register)


def _commit(attempt: Attempt, node: Node, placement: Placement, sources: Iterable[Node | None]) -> None:
    """Enter a placement; the values that it is the last to read leave their registers."""
    attempt.placed[id(node)] = placement
    attempt.result.append(placement)
    if node.predicate:
        attempt.testable.append(id(node))
    attempt.occupancy.occupy(placement)
    for each in sources:
        if each is not None:
            attempt.read(each)
    for operand in node.operands:
        if isinstance(operand, Both) and not node.memory:
            attempt.read(operand.sides[1 - placement.side])
    if placement.register is not None:
        attempt.registers.free[placement.data_side].discard(placement.register)
    if node.memory and node.mnemonic == "stw" and isinstance(node.operands[1], Both):
        attempt.read(node.operands[1].sides[1 - placement.data_side])


def _mirrored(node: Node) -> Node:
    """The comparison with exchanged operands."""
    return Node(MIRRORED[node.mnemonic], node.operands, node.units, node.delay, node.order)
