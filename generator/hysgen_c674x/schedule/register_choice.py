"""A register for a result: one that an operand leaves, or a free one that no older instruction needs more."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from hysgen_c674x.schedule.attempt import Attempt, source
from hysgen_c674x.schedule.instructions import Node, Operand
from hysgen_c674x.schedule.placement import PREDICATES
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
