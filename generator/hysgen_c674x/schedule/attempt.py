"""State of one attempt at a schedule: instructions with and without a place, occupied packets, free registers.

What the instructions of each cycle occupy: units, the two cross paths, the two data paths, register ports.

Source: SPRUFE8, chapters 2 and 3.8.
"""

from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

from hysgen_c674x.schedule.frame import FrameInstruction
from hysgen_c674x.schedule.instructions import (
    GENERAL,
    PREDICATES,
    PRESERVED,
    Both,
    Node,
    Operand,
    Placement,
    Plan,
    Register,
    Selected,
    nodes_of,
)
from hysgen_c674x.schedule.precedence import Precedence, precedence

_READS: Final = 4
"""Readings of one register in one cycle."""

_READERS: Final = 2
"""Instructions that share what a cross path carries."""


@dataclass
class Occupancy:
    """Occupied parts of the machine, by cycle.

    units: of a cycle. ports: (unit, cycle in which it writes). paths: (cycle, data path of a load or store). reads: by
    cycle and register. crossing, crossed: by cycle and side, the register that a cross path carries and its readers.
    """

    units: dict[int, set[str]] = field(default_factory=lambda: defaultdict(set))
    ports: set[tuple[str, int]] = field(default_factory=set)
    paths: set[tuple[int, int]] = field(default_factory=set)
    reads: Counter[tuple[int, int, int]] = field(default_factory=Counter)
    crossing: dict[tuple[int, int], Register] = field(default_factory=dict)
    crossed: Counter[tuple[int, int]] = field(default_factory=Counter)

    def unit(self, node: Node, kinds: str, cycle: int, side: int, taken: Iterable[str] = ()) -> str | None:
        """A free unit of one of the kinds, whose result has a write port; taken: units that are spoken for."""
        for kind in kinds:
            unit = f"{kind}{side + 1}"
            if unit in self.units[cycle] or unit in taken:
                continue
            if kind != "D" and (unit, cycle + node.delay) in self.ports:
                continue
            return unit
        return None

    def exhausted(self, node: Node, cycle: int) -> bool:
        """Whether no unit is left in a cycle for instructions of this kind."""
        sides = (0, 1) if node.side is None or node.memory else (node.side,)
        return not any(self.unit(node, node.units, cycle, side) for side in sides)

    def cross_free(self, cycle: int, side: int, register: Register) -> bool:
        """Whether the cross path to a side can carry a register."""
        carried = self.crossing.get((cycle, side))
        return carried is None or (carried == register and self.crossed[cycle, side] < _READERS)

    def readable(self, cycle: int, operands: Iterable[Register | int]) -> bool:
        """Whether the registers among the operands have a read port each."""
        wanted = [register for register in operands if not isinstance(register, int)]
        return all(self.reads[cycle, *register] + wanted.count(register) <= _READS for register in wanted)

    def occupy(self, placement: Placement) -> None:
        """Enter the units, cross paths and ports of an instruction; a data path is entered by `carry`."""
        node, cycle, side = placement.node, placement.cycle, placement.side
        for unit, _, operand, cross in placement.moves:
            self._write(unit, cycle)
            self._read(cycle, side, [operand], [operand] if cross else [])
        if placement.moves:
            return
        if node.memory:
            self.units[cycle].add(placement.unit)
        else:
            self._write(placement.unit, cycle, node.delay)
        far = [each for each in placement.operands if not isinstance(each, int) and each[0] != side]
        self._read(cycle, side, placement.operands, [] if node.memory else far)

    def carry(self, cycle: int, path: int) -> None:
        """Enter the data path of a load or store."""
        self.paths.add((cycle, path))

    def _write(self, unit: str, cycle: int, delay: int = 0) -> None:
        self.units[cycle].add(unit)
        self.ports.add((unit, cycle + delay))

    def _read(
        self, cycle: int, side: int, operands: Iterable[Register | int], crossing: Iterable[Register | int]
    ) -> None:
        for register in crossing:
            assert not isinstance(register, int)
            self.crossing[cycle, side] = register
            self.crossed[cycle, side] += 1
        for register in operands:
            if not isinstance(register, int):
                self.reads[cycle, *register] += 1


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
