"""Instructions of a kernel in a sequence that needs a limited number of registers.

The computing instructions keep a given order. Loads and constants are made in front of their first user, and again
after their register was taken. When too many values are alive, the value whose next user is the furthest leaves its
register (Belady, IBM Systems Journal 5, 1966): a load or constant is dropped, any other value is stored on the stack.
"""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from hysgen.errors import TargetError
from hysgen_c674x.schedule.instructions import (
    LOAD_DELAY,
    REACH,
    UNITS,
    WORD,
    Both,
    Node,
    Operand,
    Selected,
    Value,
    nodes_of,
)
from hysgen_c674x.schedule.pairing import with_wide_stores

MOST_SLOTS: Final = 128
"""Words of the stack for values."""

_TESTABLE: Final = 4
"""Values at a time in the six registers that a predicate can test."""

_TOGETHER: Final = 60
"""Instructions ahead within which the second word of a 64-bit load must have a user."""

_STORED: Final = 0.6
"""Factor of the distance to the next user of a value that has to be stored before it leaves its register."""


class OutOfSlotsError(TargetError):
    """More values are alive than the stack has slots for."""


def limited(selected: Selected, issue: Mapping[int, int], registers: int) -> Selected:
    """The instructions in the order of `issue`, with at most `registers` values at a time in registers.

    Raises OutOfSlotsError.
    """
    return _Walk(selected, registers).run(issue)


@dataclass(eq=False)
class _Unit:
    """A value of the kernel: where it is now. template: it can be made again; words: registers that it takes."""

    origin: Value
    template: bool
    words: int
    testable: bool
    pinned: bool = False
    uses: list[int] = field(default_factory=list)
    now: Value | None = None
    slot: int | None = None
    stored: Node | None = None
    lost: bool = False

    @property
    def fixed(self) -> bool:
        """Whether the value keeps its registers: arguments that are addresses, and addresses that depend on data."""
        return self.pinned or (isinstance(self.origin, Both) and not self.template)

    def next_use(self, at: int) -> int | None:
        """Position of the first user behind `at`, None if there is none."""
        k = bisect_right(self.uses, at)
        return self.uses[k] if k < len(self.uses) else None


@dataclass
class _Walk:
    selected: Selected
    registers: int
    units: dict[int, _Unit] = field(default_factory=dict)
    alive: dict[int, _Unit] = field(default_factory=dict)
    made: list[Node] = field(default_factory=list)
    placed: dict[int, Node] = field(default_factory=dict)
    copies: dict[int, list[Node]] = field(default_factory=lambda: defaultdict(list))
    slots: int = 0
    unused: list[int] = field(default_factory=list)
    last: dict[int, list[Node]] = field(default_factory=lambda: defaultdict(list))
    at: int = 0

    def run(self, issue: Mapping[int, int]) -> Selected:
        nodes = self.selected.nodes
        pointer = Node("param", [], "", 0, 0, side=1, register=15)
        copy = Node("mv", [pointer], *UNITS["mv"], 0, side=0, source=True)
        self.made.append(copy)
        self.near, self.far = Both((copy, pointer)), pointer
        index = {id(node): k for k, node in enumerate(nodes)}
        sequence = sorted(
            (node for node in nodes if not node.source), key=lambda node: (issue[id(node)], index[id(node)])
        )
        self._find_units([*self.selected.parameters, *nodes])
        self._find_neighbours(nodes)
        for at, node in enumerate(sequence):
            for value in node.values():
                self._used(value, at)
            for earlier, _ in node.before:
                if earlier.mnemonic == "ldw" and earlier.source:
                    self._used_address(earlier, at)
        for parameter in self.selected.parameters:
            unit = self._unit(parameter)
            unit.now = unit.origin
            self.placed[id(parameter)] = parameter
            if unit.pinned and isinstance(unit.origin, Both):
                unit.now = Both(tuple(self._again(side) for side in unit.origin.sides))  # type: ignore[arg-type]
            self.alive[id(unit)] = unit
        for self.at, node in enumerate(sequence):
            self._walk(node)
        self.made = with_wide_stores(self.made)
        for order, node in enumerate(self.made):
            node.order = order
        result = self.placed[id(self.selected.result)] if self.selected.result else None
        parameters = [*self.selected.parameters, pointer]
        return Selected(self.made, parameters, result, -(-self.slots * WORD // 8) * 8)

    def _find_neighbours(self, nodes: Sequence[Node]) -> None:
        """The other word of the 64 bits around each word that is loaded from a known address."""
        loads = {
            (id(node.operands[0]), node.word): node
            for node in nodes
            if node.mnemonic == "ldw" and node.source and node.word is not None
        }
        self.neighbour = {id(node): loads[b, w ^ 1] for (b, w), node in loads.items() if (b, w ^ 1) in loads}

    def _find_units(self, nodes: Sequence[Node]) -> None:
        boths = {id(v): v for node in nodes for v in node.values() if isinstance(v, Both)}
        for both in boths.values():
            members = both.sides
            unit = _Unit(both, all(each.source for each in members), 2, False)
            unit.pinned = any(each.mnemonic == "param" for each in members)
            for key in (both, *members):
                self.units[id(key)] = unit
        for node in nodes:
            if node.writes and id(node) not in self.units:
                self.units[id(node)] = _Unit(node, node.source, 1, node.predicate)

    def _unit(self, value: Value) -> _Unit:
        return self.units[id(value)]

    def _used(self, value: Value, at: int) -> None:
        unit = self._unit(value)
        if not unit.uses or unit.uses[-1] < at:
            unit.uses.append(at)
        for each in nodes_of(unit.origin):
            if each.source and each.mnemonic == "ldw":
                self._used_address(each, at)

    def _used_address(self, load: Node, at: int) -> None:
        for value in load.values():
            self._used(value, at)

    # ---- one instruction

    def _walk(self, node: Node) -> None:
        self._keep_overwritten(node)
        held = [self._unit(value) for value in node.values()]
        operands = [self._operand(operand, held) for operand in node.operands]
        guard = self._operand(node.guard, held) if node.guard else None
        assert guard is None or isinstance(guard, Node)
        copy = replace(node, operands=operands, guard=guard, before=self._before(node))
        self.made.append(copy)
        self.placed[id(node)] = copy
        for unit in held:
            if unit.next_use(self.at) is None:
                self._forget(unit)
        if node.writes:
            unit = self._unit(node)
            if isinstance(unit.origin, Both):
                own = [self.placed.get(id(side)) for side in unit.origin.sides]
                if None in own:
                    return
                unit.now = Both((own[0], own[1]))  # type: ignore[arg-type]
            else:
                unit.now = copy
            if unit.next_use(self.at) is not None:
                self.alive[id(unit)] = unit
                self._make_room([unit])

    def _keep_overwritten(self, node: Node) -> None:
        """Load words that this store overwrites and that are read later."""
        for earlier, _ in node.before:
            if earlier.mnemonic != "ldw" or not earlier.source:
                continue
            unit = self._unit(earlier)
            if unit.next_use(self.at - 1) is not None and not unit.lost:
                self._value(unit, [unit])
                unit.lost = True

    def _before(self, node: Node) -> list[tuple[Node, int]]:
        found: list[tuple[Node, int]] = []
        for earlier, cycles in node.before:
            copies = self.copies[id(earlier)] if earlier.source else [self.placed[id(earlier)]]
            found += [(each, cycles) for each in copies]
        return found

    def _operand(self, operand: Operand, held: list[_Unit]) -> Operand:
        if isinstance(operand, int):
            return operand
        unit = self._unit(operand)
        value = self._value(unit, held)
        if isinstance(operand, Node) and isinstance(value, Both):
            assert isinstance(unit.origin, Both)
            return value.sides[unit.origin.sides.index(operand)]
        return value

    def _value(self, unit: _Unit, held: list[_Unit]) -> Value:
        """The value in a register, made again or loaded from the stack if it is in none."""
        if unit.now is not None:
            return unit.now
        if unit.slot is not None:
            assert unit.stored is not None
            load = Node("ldw", [self._stack(unit.slot)], "D", LOAD_DELAY, 0, number=unit.slot * WORD)
            load.predicate = unit.testable
            load.before.append((unit.stored, 1))
            self.last[unit.slot].append(load)
            self.made.append(load)
            unit.now = load
        elif isinstance(unit.origin, Both):
            unit.now = Both((self._again(unit.origin.sides[0]), self._again(unit.origin.sides[1])))
        else:
            neighbour = self._neighbour(unit.origin)
            if neighbour is not None:
                self._both_words(unit, neighbour)
                self.alive[id(neighbour)] = neighbour
            else:
                unit.now = self._again(unit.origin)
        self.alive[id(unit)] = unit
        held.append(unit)
        self._make_room(held)
        assert unit.now is not None, "what is held keeps its register"
        return unit.now

    def _neighbour(self, node: Node) -> _Unit | None:
        """The other word of 64 bits, if it is to be loaded soon."""
        other = self.neighbour.get(id(node))
        if other is None or node.predicate or other.predicate:
            return None
        unit = self._unit(other)
        following = unit.next_use(self.at - 1)
        there = unit.now is None and unit.slot is None and not unit.lost and unit.testable == node.predicate
        written = all(id(earlier) in self.placed for earlier, _ in other.before)
        return unit if there and written and following is not None and following - self.at < _TOGETHER else None

    def _both_words(self, one: _Unit, other: _Unit) -> None:
        low, high = sorted((one, other), key=lambda unit: unit.origin.word)  # type: ignore[union-attr,arg-type,return-value]
        assert isinstance(low.origin, Node)
        assert isinstance(high.origin, Node)
        load = self._again(low.origin)
        load.mnemonic = "lddw"
        load.second = Node("second", [], "", LOAD_DELAY, 0, source=True)
        load.before += self._before(high.origin)
        self.copies[id(high.origin)].append(load)
        low.now, high.now = load, load.second

    def _again(self, node: Node) -> Node:
        """A new copy of a load, constant or address, behind copies of its operands."""
        if node.mnemonic == "param":
            return node
        operands: list[Operand] = []
        held: list[_Unit] = []
        for operand in node.operands:
            if isinstance(operand, Node) and self._unit(operand).origin is operand:
                operands.append(self._again(operand))
            else:
                operands.append(self._operand(operand, held))
        copy = replace(node, operands=operands, before=self._before(node))
        self.copies[id(node)].append(copy)
        self.made.append(copy)
        return copy

    # ---- registers

    def _make_room(self, held: Iterable[_Unit]) -> None:
        kept = set(map(id, held))
        while sum(unit.words for unit in self.alive.values()) > self.registers:
            self._evict([unit for key, unit in self.alive.items() if key not in kept and not unit.fixed])
        while sum(unit.testable for unit in self.alive.values()) > _TESTABLE:
            chosen = [unit for key, unit in self.alive.items() if key not in kept and unit.testable]
            if not chosen:
                break
            self._evict(chosen)

    def _evict(self, units: Sequence[_Unit]) -> None:
        def distance(unit: _Unit) -> float:
            following = unit.next_use(self.at - 1)
            if following is None:
                return float("inf")
            clean = (unit.template and not unit.lost) or unit.slot is not None
            return (following - self.at) * (1.0 if clean else _STORED)

        self._leave(max(units, key=distance))

    def _leave(self, unit: _Unit) -> None:
        """Take the register of a value; store the value if it cannot be made again."""
        if unit.next_use(self.at - 1) is not None and unit.slot is None and (not unit.template or unit.lost):
            assert isinstance(unit.now, Node), "both copies of a computed address leave their registers"
            if not self.unused and self.slots >= MOST_SLOTS:
                raise OutOfSlotsError
            if self.unused:
                unit.slot = self.unused.pop()
            else:
                self.slots += 1
                unit.slot = self.slots
            unit.stored = Node("stw", [self._stack(unit.slot), unit.now], "D", 0, 0, number=unit.slot * WORD)
            unit.stored.before += [(load, 0) for load in self.last.pop(unit.slot, [])]
            self.made.append(unit.stored)
        unit.now = None
        del self.alive[id(unit)]

    def _stack(self, slot: int) -> Value:
        """The stack pointer, on both sides if the offset of the copy on side A reaches the slot."""
        return self.near if slot * WORD <= REACH else self.far

    def _forget(self, unit: _Unit) -> None:
        if unit.pinned:
            return
        self.alive.pop(id(unit), None)
        unit.now = None
        if unit.slot is not None:
            self.unused.append(unit.slot)
            unit.slot = None
