"""State of one attempt at a schedule: instructions with and without a place, occupied packets, free registers."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from hysgen_c674x.schedule.frame import FrameInstruction
from hysgen_c674x.schedule.instructions import Both, Node, Operand, Selected, nodes_of
from hysgen_c674x.schedule.occupancy import Occupancy
from hysgen_c674x.schedule.placement import GENERAL, PREDICATES, PRESERVED, Placement, Plan, Register
from hysgen_c674x.schedule.precedence import Precedence, precedence

_STACK_READY: Final = 2
"""Cycle from which the new stack pointer can be read, over a cross path too."""


@dataclass
class Registers:
    """free: of each side. general: those for values that no predicate tests, of each side, the preferred first.

    reserved: by instruction, the register kept beside that of the value with which its own is stored. extra: registers
    beyond those of the machine, taken by an attempt without limits.
    """

    free: tuple[set[int], set[int]]
    general: tuple[tuple[int, ...], tuple[int, ...]]
    reserved: dict[int, Register] = field(default_factory=dict)
    extra: int = 100


@dataclass
class Attempt:
    """One attempt.

    unlimited: whether there are as many registers as one likes. placed: by id of the instruction. result: placements in
    the order in which they were made. conditions: values that predicates test and that have no register yet; testable:
    ids of those that have one. oldest: position of the oldest instruction without a place; urgent: ids of the oldest
    ones, for which registers are reserved. alive: ids of computed values with users that have no place. made:
    instructions of this attempt's own, kept alive because they are known by their ids.
    """

    selected: Selected
    plan: Plan
    unlimited: bool
    order: Precedence
    registers: Registers
    conditions: deque[Node]
    occupancy: Occupancy = field(default_factory=Occupancy)
    placed: dict[int, Placement] = field(default_factory=dict)
    result: list[Placement] = field(default_factory=list)
    testable: list[int] = field(default_factory=list)
    frame: list[FrameInstruction] = field(default_factory=list)
    made: list[Node] = field(default_factory=list)
    oldest: int = 0
    urgent: set[int] = field(default_factory=set)
    alive: set[int] = field(default_factory=set)

    def operand(self, operand: Operand, side: int) -> Register | int:
        """The register of an operand for a unit of one side, or the constant."""
        node = source(operand, side)
        if node is None:
            assert isinstance(operand, int)
            return operand
        placement = self.placed[id(node)]
        assert placement.register is not None
        return placement.data_side, placement.register

    def crossable(self, node: Node, cycle: int) -> bool:
        """Whether a value may be read over a cross path in a cycle without a stall."""
        placement = self.placed[id(node)]
        return node.load or node.mnemonic == "param" or cycle > placement.cycle + node.delay + 1

    def distance(self, node: Node) -> float:
        """Instructions in the order of the C text between the oldest one without a place and this one."""
        return self.order.position[id(node)] - self.oldest

    def reach(self, node: Node) -> float:
        """Instructions, from the oldest one without a place on, among which an instruction must stand."""
        plan = self.plan
        if self.unlimited:
            return plan.ahead if node.source else max(plan.window, plan.growth * (plan.room - len(self.alive)))
        if not node.source and not (plan.taper and node.load):
            return plan.window
        return min(plan.ahead, plan.tested) if node.predicate and node.load else plan.ahead

    def count_alive(self, node: Node) -> None:
        """Enter a computed value behind its instruction, and take out those that it was the last to read."""
        if node.writes and not node.source:
            self.alive.add(id(node))
        for value in node.values():
            self.alive -= {id(each) for each in nodes_of(value) if self.order.uses[id(each)] <= 0}

    def read(self, node: Node) -> None:
        """Count a reading of a value; behind the last one its register is free."""
        self.order.uses[id(node)] -= 1
        placement = self.placed[id(node)]
        if not self.order.uses[id(node)] and placement.register is not None and placement.register < 32:
            self.registers.free[placement.data_side].add(placement.register)


def source(operand: Operand, side: int) -> Node | None:
    """The instruction that makes an operand for a unit of one side; None for a constant."""
    if isinstance(operand, int):
        return None
    return operand.sides[side] if isinstance(operand, Both) else operand


def begun(selected: Selected, plan: Plan, issue: Mapping[int, int] | None, unlimited: bool) -> Attempt:
    """An attempt before its first cycle, with the parameters in their registers.

    issue: cycles of an attempt without limits on registers, for the release of loads and constants.
    """
    nodes = selected.nodes
    tests = any(node.predicate for node in nodes)
    general = [GENERAL[s] if tests else (*PREDICATES[s], *GENERAL[s]) for s in (0, 1)]
    if plan.saved:
        general = [(*general[s], *PRESERVED[s]) for s in (0, 1)]
    free = [{*PREDICATES[s], *GENERAL[s]} for s in (0, 1)]
    conditions = deque(node for node in sorted(nodes, key=lambda node: node.order) if node.predicate)
    order = precedence(nodes, plan, issue)
    registers = Registers((free[0], free[1]), (general[0], general[1]))
    attempt = Attempt(selected, plan, unlimited, order, registers, conditions)
    for parameter in selected.parameters:
        side, register = parameter.side, parameter.register
        assert side is not None
        assert register is not None
        attempt.placed[id(parameter)] = Placement(parameter, -9, "", side, side, register, (), False, None)
        if order.uses[id(parameter)]:
            registers.free[side].discard(register)
        for follower, _ in order.followers[id(parameter)]:
            order.waiting[id(follower)] -= 1
    for node in nodes:
        if any(each.register == 15 for value in node.values() for each in nodes_of(value)):
            order.ready_at[id(node)] = _STACK_READY
    for node in nodes:
        if not order.waiting[id(node)]:
            order.await_cycle(node)
    return attempt
