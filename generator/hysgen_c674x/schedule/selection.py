"""Instruction selection: instructions for the operations of a kernel.

Source: SPRUFE8, chapter 4. A constant of 5 bits is part of an instruction; other constants, and addresses further than
an offset reaches, are values of their own. Values that many instructions of both sides read exist once on each side.
"""

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from hysgen.checking.symbolic.dataflow import COMMUTATIVE, Kernel, Op
from hysgen_c674x.schedule.instructions import (
    ARGUMENTS,
    LOAD_DELAY,
    MIRRORED,
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

_WINDOW: Final = 62 * WORD
FAR: Final = 80
"""Operations of the C text after which a word is loaded again rather than kept in a register."""

NEAR: Final = 40
_SHARED: Final = 5
"""A constant with this many users, each at most NEAR operations behind the one before, is kept in a register of each
side; others are made anew for every user."""

_SHORT: Final = range(-16, 16)


def select(kernel: Kernel, near: int = NEAR, far: int = FAR) -> Selected:
    """Instructions for a kernel, in the order of the C text. near, far: see NEAR, FAR."""
    return _Selection(kernel, near, far).run()


@dataclass
class _Selection:
    kernel: Kernel
    near: int
    far: int
    nodes: list[Node] = field(default_factory=list)
    values: dict[int, Value] = field(default_factory=dict)
    constants: dict[tuple[int, int], Both] = field(default_factory=dict)
    windows: dict[tuple[int, int], Value] = field(default_factory=dict)
    users: dict[int, list[int]] = field(default_factory=lambda: defaultdict(list))
    loads: dict[int, list[Node]] = field(default_factory=dict)
    stores: dict[int, Node] = field(default_factory=dict)
    used: dict[int, int] = field(default_factory=dict)
    overwritten: set[int] = field(default_factory=set)
    order: int = 0

    def run(self) -> Selected:
        operations = self._guarded(self.kernel.operations())
        addresses: Counter[int] = Counter()
        tested: set[int] = set()
        for order, op in enumerate(operations):
            for arg in self._inputs(op):
                self.users[id(arg)].append(order)
            if op.kind in ("load", "store"):
                addresses[id(op.args[0])] += 1
            if op.kind == "select":
                tested.add(id(op.args[0]))
            if op.kind == "store" and (guard := self.guards.get(id(op))) is not None:
                tested.add(id(guard[0]))
        parameters = []
        for self.order, op in enumerate(operations):
            match op.kind:
                case "const":
                    continue
                case "param":
                    side, register = ARGUMENTS[op.number]
                    node = Node("param", [], "", 0, self.order, side=side, register=register)
                    parameters.append(node)
                    self.values[id(op)] = node
                    if addresses[id(op)]:
                        copy = self._add(Node("mv", [node], *UNITS["mv"], self.order, side=1 - side, source=True))
                        self.values[id(op)] = Both((node, copy) if side == 0 else (copy, node))
                case "symbol":
                    self.values[id(op)] = Both(tuple(self._symbol(op.name, side) for side in (0, 1)))  # type: ignore[arg-type]
                case "load":
                    self._load(op).predicate = id(op) in tested
                case "store":
                    self._store(op)
                case "select":
                    operands = [self._value(op.args[0]), self._short(op.args[1]), self._short(op.args[2])]
                    node = self._add(Node("select", operands, "DLS", 0, self.order))
                    self.values[id(op)] = node
                    node.predicate = id(op) in tested
                case _:
                    many = addresses[id(op)] > 3
                    made = [self._computed(op, side if many else None) for side in ((0, 1) if many else (0,))]
                    for node in made:
                        node.predicate = id(op) in tested
                    self.values[id(op)] = Both((made[0], made[1])) if many else made[0]
        result = None
        if self.kernel.result is not None:
            self.order += 1
            value = self._value(self.kernel.result)
            result = self._add(Node("mv", [value], *UNITS["mv"], self.order, side=0, register=4))
        return Selected(self.nodes, parameters, result)

    def _inputs(self, op: Op) -> tuple[Op, ...]:
        """The operands, of a store under a condition its address, condition and new value."""
        return (op.args[0], *self.guards[id(op)]) if id(op) in self.guards else op.args

    def _guarded(self, operations: list[Op]) -> list[Op]:
        """Stores of a choice between a new value and the word that is there become stores under a condition.

        Such a store stands behind its new value and its condition, not behind the end of the `if`: the new value leaves
        its register early.
        """
        self.guards: dict[int, tuple[Op, Op]] = {}
        for op in operations:
            if op.kind == "store" and op.args[1].kind == "select":
                condition, yes, no = op.args[1].args
                here = no.kind == "load" and no.args[0] is op.args[0] and no.number == op.number
                if here and set(no.after) == set(op.after):
                    self.guards[id(op)] = condition, yes
        needed: set[int] = set()
        for op in reversed(operations):
            if op.kind == "store" or op is self.kernel.result or id(op) in needed:
                needed.add(id(op))
                needed |= {id(arg) for arg in self._inputs(op)}
        place = {id(op): float(k) for k, op in enumerate(operations)}
        for op in operations:
            if id(op) in self.guards:
                behind = (
                    op.args[0],
                    *self.guards[id(op)],
                    *op.after,
                    *(load for load in op.beside if id(load) in needed),
                )
                place[id(op)] = max(place[id(each)] for each in behind) + 0.5
        return sorted((op for op in operations if id(op) in needed), key=lambda op: place[id(op)])

    def _add(self, node: Node) -> Node:
        self.nodes.append(node)
        return node

    def _symbol(self, name: str, side: int) -> Node:
        low = self._add(Node("mvkl", [], *UNITS["mvkl"], self.order, symbol=name, side=side, source=True))
        return self._add(
            Node("mvkh", [low], *UNITS["mvkh"], self.order, symbol=name, side=side, in_place=True, source=True)
        )

    def _constant(self, number: int, side: int | None) -> Node:
        signed = number - (1 << 32) if number >> 31 else number
        if signed in _SHORT:
            return self._add(Node("mvk", [], "DLS", 0, self.order, number=signed, side=side, source=True))
        if -0x8000 <= signed < 0x8000:
            return self._add(Node("mvk", [], "S", 0, self.order, number=signed, side=side, source=True))
        low = self._add(Node("mvkl", [], *UNITS["mvkl"], self.order, number=number, side=side, source=True))
        high = Node("mvkh", [low], *UNITS["mvkh"], self.order, number=number, side=side, in_place=True, source=True)
        return self._add(high)

    def _value(self, op: Op) -> Value:
        if op.kind == "load":
            return self._loaded(op)
        if op.kind != "const":
            return self.values[id(op)]
        first, users = self._cluster(self.users[id(op)])
        if users < _SHARED:
            return self._constant(op.number, None)
        key = op.number, first
        if key not in self.constants:
            self.constants[key] = Both((self._constant(op.number, 0), self._constant(op.number, 1)))
        return self.constants[key]

    def _cluster(self, users: Sequence[int]) -> tuple[int, int]:
        """First of the users around the present one that follow each other closely, and their number."""
        here = bisect_left(users, self.order)
        first = last = min(here, len(users) - 1)
        while first > 0 and users[first] - users[first - 1] <= self.near:
            first -= 1
        while last + 1 < len(users) and users[last + 1] - users[last] <= self.near:
            last += 1
        return users[first], last + 1 - first

    def _short(self, op: Op) -> Operand:
        """A constant of 5 bits as such, any other value in a register."""
        if op.kind == "const":
            signed = op.number - (1 << 32) if op.number >> 31 else op.number
            if signed in _SHORT:
                return signed
        return self._value(op)

    def _computed(self, op: Op, side: int | None) -> Node:
        kind, args = op.kind, list(op.args)
        units, delay = UNITS[kind]
        if kind == "and" and args[1].kind == "const" and args[1].number == 0x7FFF_FFFF:
            return self._add(Node("clr", [self._value(args[0]), 31, 31], "S", 0, self.order, side=side))
        if kind in ("shl", "shru") and args[1].kind == "const" and args[1].number < 32:
            return self._add(Node(kind, [self._value(args[0]), args[1].number], "S", 0, self.order, side=side))
        if args[1:] and args[1].kind == "const" and kind in COMMUTATIVE | set(MIRRORED) and kind not in ("mpy32",):
            args.reverse()
            kind = MIRRORED.get(kind, kind)
        first: Operand
        allowed = {"add": "LS", "sub": "LS", "and": "DLS", "or": "DLS", "xor": "DLS", "cmpeq": "L"}
        if kind in allowed and isinstance(short := self._short(args[0]), int):
            first, units = short, allowed[kind]
        elif kind in ("cmpgtu", "cmpltu") and args[0].kind == "const" and args[0].number < 16:
            first = args[0].number
        else:
            first = self._value(args[0])
        return self._add(
            Node(kind, [first, *(self._value(arg) for arg in args[1:])], units, delay, self.order, side=side)
        )

    def _address(self, op: Op, offset: int) -> tuple[Value, int]:
        """A value near the address and the remaining offset in bytes."""
        base = self._value(op)
        if -REACH <= offset <= REACH:
            return base, offset
        window = (offset + REACH) // _WINDOW
        key = id(op), window
        if key not in self.windows:
            sides = []
            for side in (0, 1):
                distance = self._constant(window * _WINDOW, side)
                own = base.sides[side] if isinstance(base, Both) else base
                sides.append(self._add(Node("add", [distance, own], *UNITS["add"], self.order, side=side)))
                sides[-1].source = own.source or own.mnemonic == "param"
            self.windows[key] = Both((sides[0], sides[1]))
        return self.windows[key], offset - window * _WINDOW

    def _word(self, op: Op) -> int | None:
        address = op.args[0]
        known = address.kind == "param" and address.number in self.kernel.aligned
        return op.number // WORD if known else None

    def _loaded(self, op: Op) -> Value:
        """The value of a load; it is loaded again for a user far behind the last one, to save a register meanwhile."""
        far = self.order - self.used.get(id(op), self.order) > self.far
        value = self.values[id(op)]
        assert isinstance(value, Node)
        if far and id(op) not in self.overwritten and not value.predicate:
            value = self._load(op)
        self.used[id(op)] = self.order
        return value

    def _load(self, op: Op) -> Node:
        base, offset = self._address(op.args[0], op.number)
        node = Node("ldw", [base], "D", LOAD_DELAY, self.order, number=offset)
        node.source = all(each.source or each.mnemonic == "param" for each in nodes_of(base))
        node.word = self._word(op)
        node.before += [(self.stores[id(store)], 1) for store in op.after]
        self.values[id(op)] = self._add(node)
        self.loads.setdefault(id(op), []).append(node)
        return node

    def _store(self, op: Op) -> None:
        condition, value = self.guards.get(id(op), (None, op.args[1]))
        base, offset = self._address(op.args[0], op.number)
        node = Node("stw", [base, self._value(value)], "D", 0, self.order, number=offset)
        node.word = self._word(op)
        if condition is not None:
            guard = self._value(condition)
            assert isinstance(guard, Node)
            node.guard = guard
        node.before += [(self.stores[id(store)], 1) for store in op.after]
        for load in op.beside:
            node.before += [(found, 0) for found in self.loads.get(id(load), [])]
            self.overwritten.add(id(load))
        self.stores[id(op)] = self._add(node)
