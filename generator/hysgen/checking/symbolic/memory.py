"""Memory of a C function that is executed with symbolic values, and both sides of a branch from the same state.

A word of the caller's struct is loaded when it is first read and kept as a value; it is stored when the function has
ended, or before an access at an address that depends on data and may meet it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias, TypeVar

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.source import KernelRefusalError
from hysgen.codegen.operations.text import INTEGER, Array, StructType, Type, words

WORD: Final = 4
MOST_CHOICES: Final = 64
"""Words of an array whose elements are selected by an index that depends on data."""


@dataclass(frozen=True)
class Place:
    """An address: byte `offset` in an object, plus the value of `index`, which stays within [low, high).

    memory: name of the object: `*parameter`, a table, or a local variable with its number.
    """

    memory: str
    offset: int
    kind: Type
    index: Op | None = None
    low: int = 0
    high: int = 0
    stride: int = WORD

    def at(self, offset: int, kind: Type) -> Place:
        return replace(self, offset=self.offset + offset, kind=kind)


Leaf: TypeAlias = Op | Place


@dataclass(frozen=True)
class Whole:
    """A struct by value: its words by byte offset."""

    leaves: Mapping[int, Leaf]


Value: TypeAlias = Op | Place | Whole | None


@dataclass
class State:
    """Values of words by object and offset; `dirty`: words of the caller's memory that differ from it."""

    cells: dict[tuple[str, int], Leaf] = field(default_factory=dict)
    dirty: set[tuple[str, int]] = field(default_factory=set)

    def copy(self) -> State:
        return State(dict(self.cells), set(self.dirty))


@dataclass(frozen=True)
class Access:
    """A load or store of the caller's memory that was emitted: bytes [low, high) of the object."""

    op: Op
    memory: str
    low: int
    high: int

    def meets(self, memory: str, low: int, high: int) -> bool:
        return self.memory == memory and self.low < high and low < self.high


def size_of(kind: Type) -> int:
    """Bytes of a value of this type."""
    return WORD * words(kind)


@dataclass
class SymbolicMemory:
    """All words that a function can read or write.

    tables: types and words of the constant tables. bases: addresses of the objects that are not local. accesses,
    stores: loads and stores so far. conditional: number of `if` statements around the present statement.
    """

    graph: Graph
    tables: Mapping[str, tuple[Type, tuple[int, ...]]]
    state: State = field(default_factory=State)
    bases: dict[str, Op] = field(default_factory=dict)
    accesses: list[Access] = field(default_factory=list)
    stores: list[Access] = field(default_factory=list)
    conditional: int = 0

    def finish(self) -> tuple[Op, ...]:
        """All stores; those of changed words of the caller's memory in the order in which their values were made."""
        for memory, offset in sorted(self.state.dirty, key=self._made):
            self.flush(memory, offset)
        return tuple(each.op for each in self.stores)

    def _made(self, cell: tuple[str, int]) -> tuple[int, str, int]:
        """Sorting key of a word of memory: when its value was computed."""
        value = self.state.cells[cell]
        return value.order if isinstance(value, Op) else 0, *cell

    def _base(self, memory: str) -> Op:
        if memory not in self.bases:
            self.bases[memory] = self.graph.symbol(memory)
        return self.bases[memory]

    def _external(self, memory: str) -> bool:
        return memory.startswith("*")

    def flush(self, memory: str, offset: int) -> None:
        """Store the word of the caller's memory."""
        value = self.state.cells[memory, offset]
        if isinstance(value, Place):
            raise KernelRefusalError(f"{memory}: a pointer is stored")
        self._store(memory, offset, offset + WORD, self._base(memory), offset, value)

    def _store(self, memory: str, low: int, high: int, address: Op, offset: int, value: Op) -> None:
        before = [each.op for each in self.stores if each.meets(memory, low, high)]
        beside = [each.op for each in self.accesses if each.meets(memory, low, high)]
        if value.kind == "load" and value.args[0] is address and value.number == offset and not before:
            return
        op = self.graph.store(address, offset, value, before, beside)
        self.stores.append(Access(op, memory, low, high))

    def settled(self, cell: tuple[str, int], value: Leaf) -> Leaf:
        """A load of the word behind the store of `value`, if `value` is a choice between a new word and the old one."""
        memory, offset = cell
        if not self._external(memory) or not isinstance(value, Op) or value.kind != "select":
            return value
        there = value.args[2]
        if there.kind != "load" or there.args[0] is not self._base(memory) or there.number != offset:
            return value
        self._store(memory, offset, offset + WORD, self._base(memory), offset, value)
        return self._load(memory, offset, offset + WORD, self._base(memory), offset)

    def read(self, place: Place) -> Leaf:
        """The word at a place."""
        key = place.memory, place.offset
        if place.index is None:
            if key in self.state.cells:
                return self.state.cells[key]
            if place.memory in self.tables:
                return self.graph.const(self.tables[place.memory][1][place.offset // WORD])
            if not self._external(place.memory):
                return self.graph.const(0)  # an uninitialised local of a path that does not use it
            value = self._load(place.memory, place.offset, place.offset + WORD, self._base(place.memory), place.offset)
            self.state.cells[key] = value
            return value
        if place.memory in self.tables:
            address = self.graph.op("add", self._base(place.memory), place.index)
            return self.graph.load(address, place.offset)
        changed = any(m == place.memory and place.low <= at < place.high for m, at in self.state.dirty)
        if not self._external(place.memory) or (changed and self.conditional):
            return self._chosen(place)
        self._settle(place)
        address = self.graph.op("add", self._base(place.memory), place.index)
        return self._load(place.memory, place.low, place.high, address, place.offset)

    def _load(self, memory: str, low: int, high: int, address: Op, offset: int) -> Op:
        after = [each.op for each in self.stores if each.meets(memory, low, high)]
        value = self.graph.load(address, offset, after)
        self.accesses.append(Access(value, memory, low, high))
        return value

    def _chosen(self, place: Place) -> Op:
        """The word at an index that depends on data, by choices between all words of the array."""
        size, count = self._elements(place)
        shift = place.offset - place.low
        leaves = [self.read(Place(place.memory, place.low + shift % size + size * k, INTEGER)) for k in range(count)]
        if not all(isinstance(leaf, Op) for leaf in leaves):
            raise KernelRefusalError(f"{place.memory}: pointers indexed by data")
        values = [leaf for leaf in leaves if isinstance(leaf, Op)]
        index, bit = self._number(place, size, shift), 1
        while len(values) > 1:
            condition = self.graph.op("and", index, self.graph.const(bit))
            pairs = [values[k : k + 2] for k in range(0, len(values), 2)]
            values = [self.graph.select(condition, *reversed(pair)) if len(pair) == 2 else pair[0] for pair in pairs]
            bit *= 2
        return values[0]

    def _elements(self, place: Place) -> tuple[int, int]:
        """Bytes and number of the elements of the array that a place is in."""
        if place.index is None or place.high - place.low > WORD * MOST_CHOICES:
            raise KernelRefusalError(f"{place.memory}: an array of unknown or large size, indexed by data")
        return place.stride, (place.high - place.low) // place.stride

    def _number(self, place: Place, size: int, shift: int) -> Op:
        """The index of the element."""
        assert place.index is not None
        if size & (size - 1) or shift // size:
            raise KernelRefusalError(f"{place.memory}: elements of {size} bytes, indexed by data")
        return self.graph.op("shru", place.index, self.graph.const(size.bit_length() - 1))

    def _settle(self, place: Place) -> None:
        """Store the words in the range of an address that depends on data."""
        for memory, offset in sorted(self.state.dirty):
            if memory == place.memory and place.low <= offset < place.high:
                if self.conditional:
                    raise KernelRefusalError(f"{memory}+{offset}: changed, then indexed by data inside an if")
                self.flush(memory, offset)
                self.state.dirty.discard((memory, offset))

    def write(self, place: Place, value: Leaf) -> None:
        key = place.memory, place.offset
        if place.index is None:
            self.state.cells[key] = value
            if self._external(place.memory):
                self.state.dirty.add(key)
            return
        if isinstance(value, Place):
            raise KernelRefusalError(f"{place.memory}: a pointer stored at an address that depends on data")
        if not self._external(place.memory) or self.conditional:
            size, count = self._elements(place)
            index = self._number(place, size, place.offset - place.low)
            for k in range(count):
                target = Place(place.memory, place.low + (place.offset - place.low) % size + size * k, INTEGER)
                here = self.graph.op("cmpeq", index, self.graph.const(k))
                old = self.read(target)
                if not isinstance(old, Op):
                    raise KernelRefusalError(f"{place.memory}: pointers indexed by data")
                self.write(target, self.graph.select(here, value, old))
            return
        self._settle(place)
        for cell in [c for c in self.state.cells if c[0] == place.memory and place.low <= c[1] < place.high]:
            del self.state.cells[cell]
        address = self.graph.op("add", self._base(place.memory), place.index)
        self._store(place.memory, place.low, place.high, address, place.offset, value)

    def get(self, place: Place) -> Value:
        """The value at a place: a word, a struct by value, or the place itself for an array."""
        match place.kind:
            case Array():
                return place
            case StructType():
                return Whole(
                    {offset: self.read(place.at(offset, INTEGER)) for offset in range(0, size_of(place.kind), WORD)}
                )
        return self.read(place)

    def put(self, place: Place, value: Value) -> None:
        match value:
            case Whole():
                for offset, leaf in value.leaves.items():
                    self.write(place.at(offset, INTEGER), leaf)
            case None:
                raise KernelRefusalError("a void value is assigned")
            case _:
                self.write(place, value)


Result = TypeVar("Result")


@dataclass
class Branches:
    """Execution under conditions. memory: its state is that of the side that is being executed."""

    graph: Graph
    memory: SymbolicMemory

    def execute(self, before: State, side: Callable[[], Result]) -> tuple[State, Result]:
        """Execute code that runs under a condition, from a copy of the state; the state behind it and the result."""
        self.memory.state = before.copy()
        self.memory.conditional += 1
        result = side()
        self.memory.conditional -= 1
        return self.memory.state, result

    def merged(self, condition: Op, yes: State, no: State) -> State:
        """The state behind a branch: of every word in which the sides differ, the one that the condition chooses."""
        merged = State({}, yes.dirty | no.dirty)
        for key, value in {**yes.cells, **no.cells}.items():
            if yes.cells.get(key) is no.cells.get(key):
                merged.cells[key] = value
                continue
            leaves = []
            for side in (yes, no):
                self.memory.state = side
                leaves.append(self.memory.read(Place(key[0], key[1], INTEGER)))
            leaves[1] = self._stored_before(key, leaves[0], leaves[1])
            chosen = self.either(condition, leaves[0], leaves[1])
            assert isinstance(chosen, Op | Place)
            merged.cells[key] = chosen
        return merged

    def either(self, condition: Op, yes: Value, no: Value) -> Value:
        """The value that the condition chooses.

        Raises KernelRefusalError for two pointers that differ.
        """
        match yes, no:
            case Op(), Op():
                return self.graph.select(condition, yes, no)
            case Whole(), Whole():
                return Whole({k: self.either(condition, yes.leaves[k], no.leaves[k]) for k in yes.leaves})  # type: ignore[misc]
            case Place(), Place() if yes == no:
                return yes
            case None, None:
                return None
            case (Place(), _) | (_, Place()):
                return yes if isinstance(yes, Place) else no  # a pointer of one side only
        raise KernelRefusalError("the two sides of an if leave different pointers")

    def assumed(self, state: State, condition: Op) -> State:
        """The state where a condition holds: choices that it decides are made."""
        known = _facts(condition, True)
        cells = {
            key: self._decided(value, known) if isinstance(value, Op) else value for key, value in state.cells.items()
        }
        return State(cells, set(state.dirty))

    def _decided(self, value: Op, known: Mapping[int, bool]) -> Op:
        if value.kind != "select":
            return value
        condition, yes, no = value.args
        if id(condition) in known:
            return self._decided(yes if known[id(condition)] else no, known)
        conjuncts = _conjuncts(condition)
        left = [each for each in conjuncts if not known.get(id(each), False)]
        if any(known.get(id(each)) is False for each in left):
            return self._decided(no, known)
        if len(left) == len(conjuncts):
            return value
        yes = self._decided(yes, known)
        if not left:
            return yes
        condition = left[0]
        for each in left[1:]:
            condition = self.graph.op("and", condition, each)
        return self.graph.select(condition, yes, no)

    def _stored_before(self, key: tuple[str, int], new: Leaf, old: Leaf) -> Leaf:
        """The word as a load, if an earlier `if` may have changed it.

        The earlier value is stored at once. Both stores become stores under a condition, and the earlier value leaves
        its register.
        """
        if self.memory.conditional or not isinstance(new, Op) or new is old:
            return old
        return self.memory.settled(key, old)


def _facts(condition: Op, holds: bool) -> dict[int, bool]:
    """Which values, by their ids, are known to be other than 0 (True) or 0 (False) where a condition holds or fails."""
    found: dict[int, bool] = {}
    pending = [(condition, holds)]
    while pending:
        op, here = pending.pop()
        found[id(op)] = here
        zeros = [arg.kind == "const" and not arg.number for arg in op.args]
        match op.kind:
            case "and" if here and all(arg.truth for arg in op.args):
                pending += [(arg, True) for arg in op.args]
            case "or" if not here:
                pending += [(arg, False) for arg in op.args]
            case "xor" if op.truth and op.args[1].kind == "const" and op.args[1].number:
                pending.append((op.args[0], not here))
            case "cmpeq" if zeros[1]:
                pending.append((op.args[0], not here))
            case "select" if here and zeros[1]:
                pending += [(op.args[0], False), (op.args[2], True)]
            case "select" if here and zeros[2]:
                pending += [(op.args[0], True), (op.args[1], True)]
    return found


def _conjuncts(condition: Op) -> list[Op]:
    """The truths that all hold if the condition holds."""
    if condition.kind == "and" and all(arg.truth for arg in condition.args):
        return [each for arg in condition.args for each in _conjuncts(arg)]
    return [condition]
