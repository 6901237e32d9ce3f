"""A unit and a register for one instruction in one cycle, if there are any.

A register for a result: one that an operand leaves, or a free one that no older instruction needs more.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from hysgen_c674x.schedule.attempt import Attempt, source
from hysgen_c674x.schedule.instructions import MIRRORED, PREDICATES, Both, Node, Operand, Placement, Register
from hysgen_c674x.schedule.splitting import split_load, split_store

_YOUNGER: Final = 2
"""Conditions in registers that stand behind a condition without a register, in the order of the instructions."""


def chosen(attempt: Attempt, node: Node, cycle: int, side: int, operands: Sequence[Operand] = ()) -> int | None:
    """The register for the result of an instruction; None if there is none. operands: those that it reads."""
    plan, registers = attempt.plan, attempt.registers
    sources = [each for operand in operands if (each := source(operand, side)) is not None]
    if node.in_place:
        return attempt.placed[id(sources[0])].register
    free = registers.free[side]
    dying = _left(attempt, sources, side)
    urgent = id(node) in attempt.urgent
    if node.pair is not None and not attempt.unlimited:
        return _beside(attempt, node, side, dying)
    if node.register is not None:
        return node.register if node.register in free | dying else None
    if plan.stretch and not dying and cycle < attempt.order.due[id(node)] and not urgent:
        return None
    if node.predicate and plan.taper and not _orderly(attempt, node):
        return None
    kinds = PREDICATES[side] if node.predicate else registers.general[side]
    choice = [r for r in kinds if r in free or r in dying]
    if not choice and urgent and not node.predicate:
        choice = [r for r in PREDICATES[side] if r in free][1:]
    if choice and not attempt.unlimited:
        reserve = 1 if node.predicate else plan.reserve
        if plan.taper:
            reserve = 0 if node.predicate else int(plan.taper * attempt.distance(node))
            choice.sort(key=lambda r: r not in dying and r ^ 1 in free)
        if urgent or dying:
            reserve = 0
        return choice[0] if len(choice) > reserve else None
    if attempt.unlimited:
        registers.extra += 1
        return registers.extra
    return None


def even(attempt: Attempt, node: Node, side: int) -> int | None:
    """The even one of two neighbouring registers for the words of a 64-bit load."""
    registers = attempt.registers
    if attempt.unlimited:
        registers.extra += 2
        return registers.extra & ~1
    free = [r for r in registers.general[side] if r in registers.free[side]]
    found: int | None = None
    if len(free) >= _reserve(attempt, node) + 2:
        found = next((r for r in free if r % 2 == 0 and r + 1 in free), None)
    if found is None and id(node) in attempt.urgent:
        split_load(attempt, node)
    return found


def _left(attempt: Attempt, sources: Iterable[Node], side: int) -> set[int]:
    """Registers of a side that the operands of an instruction leave, because it is the last to read them."""
    sources = list(sources)
    dying = set()
    for each in sources:
        if attempt.order.uses[id(each)] == sum(other is each for other in sources):
            placement = attempt.placed[id(each)]
            if placement.data_side == side and placement.register is not None and placement.register < 32:
                dying.add(placement.register)
    return dying


def _beside(attempt: Attempt, node: Node, side: int, dying: set[int]) -> int | None:
    """A register for a value of a 64-bit store; its neighbour is kept for the other value."""
    assert node.pair is not None
    registers = attempt.registers
    if id(node) in registers.reserved:
        reserved_side, register = registers.reserved[id(node)]
        return register if reserved_side == side else None
    other, odd = node.pair
    free = registers.free[side]
    general = [r for r in registers.general[side] if r in free]
    if len(general) >= _reserve(attempt, node) + 2:
        for register in registers.general[side]:
            if register % 2 == odd and register in free | dying and register ^ 1 in general:
                found: int = register
                registers.reserved[id(other)] = side, found ^ 1
                free.discard(found ^ 1)
                return found
    if not node.source:  # the zeros of a restart have many stores, and wait
        split_store(attempt, node, other)
    return None


def _reserve(attempt: Attempt, node: Node) -> int:
    """Registers of a side that an instruction must leave free."""
    return 0 if id(node) in attempt.urgent else int(attempt.plan.taper * attempt.distance(node))


def _orderly(attempt: Attempt, node: Node) -> bool:
    """Whether a condition may take one of the six registers before the conditions in front of it."""
    order, conditions = attempt.order, attempt.conditions
    while conditions and id(conditions[0]) in attempt.placed:
        conditions.popleft()
    first = order.position[id(conditions[0])]
    younger = sum(1 for key in attempt.testable if order.uses[key] > 0 and order.position[key] > first)
    return node is conditions[0] or younger < _YOUNGER


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
