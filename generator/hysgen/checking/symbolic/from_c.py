"""Dataflow of a generated C function: its syntax tree is executed with symbolic values.

Calls are expanded, loops of constant length unrolled, local variables, structs and pointers to them resolved. Both
sides of an `if` are evaluated and their results selected, so a kernel has no branch. A word of the caller's struct is
loaded once and stored once, at the end.

A function outside this subset (loops that depend on data, calls that are not in the text, signed integers, stores at
an address that depends on data inside an `if`) is refused with KernelRefusalError; it stays in C.

Memory whose words are all values: an element at an index that depends on data is an operation of the whole array.

`element` reads and `replaced` writes; neither says where the index lies. That it lies inside the array is shown
elsewhere (Frama-C), so two programs with equal operations compute equal words wherever both indices do.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from pycparser import c_ast

from hysgen.checking.symbolic.dataflow import Graph, Kernel, Op
from hysgen.checking.symbolic.expressions import Expressions
from hysgen.checking.symbolic.memory import WORD, Branches, Leaf, Place, SymbolicMemory, Value, Whole, size_of
from hysgen.checking.symbolic.source import KernelRefusalError, Source
from hysgen.codegen.operations.text import INTEGER, Array, Pointer, StructType, Type


def element(graph: Graph, words: Sequence[Op], distance: Op, offset: int = 0) -> Op:
    """The word at byte `offset` + distance of an array of words."""
    if distance.kind == "const":
        return words[(offset + distance.number) // WORD]
    return graph.indexed(words, distance, offset)


def replaced(
    graph: Graph, words: Sequence[Op], distance: Op, value: Op, offset: int = 0, stride: int = WORD
) -> list[Op]:
    """The words of an array after a store at byte `offset` + distance, a multiple of `stride`."""
    changed = list(words)
    for at in range(offset % stride, WORD * len(words), stride):
        here = graph.op("cmpeq", distance, graph.const(at - offset))
        changed[at // WORD] = graph.select(here, value, words[at // WORD])
    return changed


@dataclass
class IndexedMemory(SymbolicMemory):
    """All words that a function can read or write, none of them outside.

    arrays: those that an index that depends on data was in, by object and byte offset.
    """

    arrays: dict[tuple[str, int], Place] = field(default_factory=dict)

    def read(self, place: Place) -> Leaf:
        if place.index is None:
            return super().read(place)
        return element(self.graph, self._array(place), place.index, place.offset - place.low)

    def write(self, place: Place, value: Leaf) -> None:
        if place.index is None:
            super().write(place, value)
            return
        if not isinstance(value, Op):
            raise KernelRefusalError(f"{place.memory}: a pointer stored at an index that depends on data")
        words = replaced(self.graph, self._array(place), place.index, value, place.offset - place.low, place.stride)
        for k, word in enumerate(words):
            super().write(Place(place.memory, place.low + WORD * k, INTEGER), word)

    def _array(self, place: Place) -> list[Op]:
        if place.high - place.low >= 1 << 29:
            raise KernelRefusalError(f"{place.memory}: an array of unknown size, indexed by data")
        self.arrays[place.memory, place.offset] = place
        places = (Place(place.memory, at, INTEGER) for at in range(place.low, place.high, WORD))
        leaves = [super(IndexedMemory, self).read(word) for word in places]
        if not all(isinstance(leaf, Op) for leaf in leaves):
            raise KernelRefusalError(f"{place.memory}: pointers indexed by data")
        return [leaf for leaf in leaves if isinstance(leaf, Op)]


MOST_OPERATIONS: Final = 12_000
"""Operations of a kernel, bounded because a schedule's time and code grow with them."""


def kernel(source: Source, function: str) -> Kernel:
    """The dataflow of `function`, named with the model's prefix. Raises KernelRefusalError."""
    graph = Graph()
    return _Execution(source, graph, SymbolicMemory(graph, source.tables)).run(function)


@dataclass(frozen=True)
class Decision:
    """The condition of an `if`, and the conditions around it with the side of each that the `if` stands on."""

    condition: Op
    around: tuple[tuple[Op, bool], ...]


@dataclass(frozen=True)
class Outcome:
    """What a call leaves: the words of each struct behind a pointer parameter, by its name, and the returned word.

    decisions: the `if` statements that depend on data, in their order. arrays: of structs and tables, those with an
    element at an index that depends on data, by name and byte offset.
    """

    structs: Mapping[str, tuple[Op, ...]]
    result: Op | None
    decisions: tuple[Decision, ...]
    arrays: Mapping[tuple[str, int], Place]


def outcome(source: Source, graph: Graph, function: str, arguments: Sequence[Op | Sequence[Op]]) -> Outcome:
    """The words that `function` leaves, of arguments that are words, or the words of the struct that a pointer is to.

    No two pointers may be to the same struct. Raises KernelRefusalError for C outside the subset.
    """
    return _Execution(source, graph, IndexedMemory(graph, source.tables), math.inf).outcome(function, arguments)


@dataclass
class _Execution:
    source: Source
    graph: Graph
    memory: SymbolicMemory
    most_operations: float = MOST_OPERATIONS
    locals: int = 0
    decisions: list[Decision] = field(default_factory=list)
    around: tuple[tuple[Op, bool], ...] = ()

    def __post_init__(self) -> None:
        self.branches = Branches(self.graph, self.memory)
        self.expressions = Expressions(self.source, self.graph, self.memory, self.branches, self._call)

    def run(self, function: str) -> Kernel:
        node = self.source.functions[function]
        arguments: list[Value] = []
        aligned: set[int] = set()
        parameters = node.decl.type.args.params if node.decl.type.args else []
        for index, parameter in enumerate(parameters):
            kind = self.source.types.of(parameter.type)
            word = self.graph.param(index)
            if isinstance(kind, Pointer):
                memory = f"*{parameter.name}"
                self.memory.bases[memory] = word
                arguments.append(Place(memory, 0, kind.to))
                if self.source.aligned(parameter.type):
                    aligned.add(index)
            else:
                arguments.append(word)
        several = sum(isinstance(argument, Place) for argument in arguments) > 1
        if several and not self.source.pointers_are_separate(function):
            raise KernelRefusalError(f"{function}: two pointers, whose memory may overlap")
        result = self._call(function, arguments)
        stores = self.memory.finish()
        if isinstance(result, Place | Whole):
            raise KernelRefusalError(f"{function}: returns a pointer or a struct")
        tables = {name: self.source.tables[name][1] for name in self.memory.bases if name in self.source.tables}
        return Kernel(function, len(arguments), stores, result, tables, frozenset(aligned))

    def outcome(self, function: str, arguments: Sequence[Op | Sequence[Op]]) -> Outcome:
        node = self.source.functions[function]
        values: list[Value] = []
        structs: dict[str, tuple[str, int]] = {}
        for parameter, given in zip(node.decl.type.args.params, arguments, strict=True):
            if isinstance(given, Op):
                values.append(given)
                continue
            kind = self.source.types.of(parameter.type)
            assert isinstance(kind, Pointer | Array), f"{function}: {parameter.name} is no pointer"
            place = self._local(parameter.name, kind.to if isinstance(kind, Pointer) else kind.of)
            for k, word in enumerate(given):
                self.memory.write(place.at(WORD * k, INTEGER), word)
            structs[parameter.name] = place.memory, len(given)
            values.append(place)
        result = self._call(function, values)
        behind: dict[str, tuple[Op, ...]] = {}
        for name, (memory, count) in structs.items():
            words = [self.memory.read(Place(memory, WORD * k, INTEGER)) for k in range(count)]
            assert all(isinstance(word, Op) for word in words), f"{function}: {name} holds a pointer"
            behind[name] = tuple(word for word in words if isinstance(word, Op))
        names = {memory: name for name, (memory, _) in structs.items()} | {name: name for name in self.source.tables}
        indexed = self.memory.arrays.items() if isinstance(self.memory, IndexedMemory) else ()
        arrays = {(names[memory], at): place for (memory, at), place in indexed if memory in names}
        return Outcome(behind, result if isinstance(result, Op) else None, tuple(self.decisions), arrays)

    def _call(self, function: str, arguments: Sequence[Value]) -> Value:
        name = self.source.name
        if function in (f"{name}_bits", f"{name}_float"):
            return arguments[0]
        node = self.source.functions.get(function)
        if node is None:
            raise KernelRefusalError(f"{function}: called, but not in the text")
        scope: dict[str, Place] = {}
        parameters = node.decl.type.args.params if node.decl.type.args else []
        for parameter, value in zip(parameters, arguments, strict=True):
            kind = self.source.types.of(parameter.type)
            if isinstance(kind, Array):
                kind = Pointer(kind.of)
            scope[parameter.name] = self._local(parameter.name, kind)
            self.memory.put(scope[parameter.name], value)
        returned, value = self._block(node.body.block_items or [], scope)
        return value if returned else None

    def _local(self, name: str, kind: Type) -> Place:
        self.locals += 1
        return Place(f"{name}.{self.locals}", 0, kind)

    def _block(self, statements: Sequence[c_ast.Node], scope: dict[str, Place]) -> tuple[bool, Value]:
        """Execute; whether it returned, and the value."""
        if self.graph.count > self.most_operations:
            raise KernelRefusalError(f"more than {self.most_operations} operations")
        for k, statement in enumerate(statements):
            match statement:
                case c_ast.If():
                    returned, value, done = self._if(statement, statements[k + 1 :], scope)
                    if done:
                        return returned, value
                case c_ast.Return():
                    return True, (self.expressions.value(statement.expr, scope) if statement.expr else None)
                case c_ast.Compound():
                    returned, value = self._block(statement.block_items or [], dict(scope))
                    if returned:
                        return True, value
                case c_ast.For():
                    self._for(statement, scope)
                case c_ast.Switch():
                    self._switch(statement, scope)
                case c_ast.Break() if statement is statements[-1]:
                    pass
                case c_ast.DeclList():
                    for each in statement.decls:
                        self._declare(each, scope)
                case c_ast.Decl():
                    self._declare(statement, scope)
                case c_ast.EmptyStatement() | c_ast.Pragma():
                    pass
                case _:
                    self.expressions.value(statement, scope)
        return False, None

    def _if(self, node: c_ast.If, rest: Sequence[c_ast.Node], scope: dict[str, Place]) -> tuple[bool, Value, bool]:
        """Both sides, then the rest if a side returns; the last answer: whether the rest was executed."""
        condition = self.expressions.word(node.cond, scope)
        sides = [[] if side is None else [side] for side in (node.iftrue, node.iffalse)]
        if condition.kind == "const":
            returned, value = self._block(sides[condition.number == 0], dict(scope))
            return returned, value, returned
        outside = self.around
        self.decisions.append(Decision(condition, outside))
        before = self.memory.state
        returns = any(_returns(side) for side in sides)
        executed = [[*side, *rest] if returns else side for side in sides]
        assumed = self.branches.assumed(before, condition)
        self.around = (*outside, (condition, True))
        taken, (one, yes) = self.branches.execute(assumed, lambda: self._block(executed[0], dict(scope)))
        taken.cells |= {key: before.cells[key] for key, value in assumed.cells.items() if taken.cells[key] is value}
        self.around = (*outside, (condition, False))
        passed, (other, no) = self.branches.execute(before, lambda: self._block(executed[1], dict(scope)))
        self.around = outside
        self.memory.state = self.branches.merged(condition, taken, passed)
        if not returns:
            return False, None, False
        if one != other:
            raise KernelRefusalError(f"{node.coord}: only one side returns")
        return one, self.branches.either(condition, yes, no), True

    def _for(self, node: c_ast.For, scope: dict[str, Place]) -> None:
        inner = dict(scope)
        if isinstance(node.init, c_ast.DeclList):
            for each in node.init.decls:
                self._declare(each, inner)
        elif node.init is not None:
            self.expressions.value(node.init, inner)
        while True:
            condition = self.expressions.word(node.cond, inner)
            if condition.kind != "const":
                raise KernelRefusalError(f"{node.coord}: the length of a loop depends on data")
            if not condition.number:
                return
            body = node.stmt.block_items or [] if isinstance(node.stmt, c_ast.Compound) else [node.stmt]
            if self._block(body, dict(inner))[0]:
                raise KernelRefusalError(f"{node.coord}: a return inside a loop")
            self.expressions.value(node.next, inner)

    def _switch(self, node: c_ast.Switch, scope: dict[str, Place]) -> None:
        """The case of a constant; each case ends in a break."""
        condition = self.expressions.word(node.cond, scope)
        if condition.kind != "const":
            raise KernelRefusalError(f"{node.coord}: the case of a switch depends on data")
        for case in node.stmt.block_items:
            if isinstance(case, c_ast.Default) or self.expressions.word(case.expr, scope) is condition:
                if self._block(case.stmts or [], dict(scope))[0]:
                    raise KernelRefusalError(f"{node.coord}: a return inside a switch")
                return

    def _declare(self, node: c_ast.Decl, scope: dict[str, Place]) -> None:
        place = scope[node.name] = self._local(node.name, self.source.types.of(node.type))
        if node.init is None:
            return
        if isinstance(node.init, c_ast.InitList):
            self._initialise(place, node.init, scope)
        else:
            self.memory.put(place, self.expressions.value(node.init, scope))

    def _initialise(self, place: Place, node: c_ast.InitList, scope: dict[str, Place]) -> None:
        parts = node.exprs
        kinds = _parts(place.kind)
        for k, part in enumerate(parts):
            if isinstance(part, c_ast.NamedInitializer):
                raise KernelRefusalError(f"{node.coord}: a designated initialiser")
            offset, kind = kinds[k]
            target = place.at(offset, kind)
            if isinstance(part, c_ast.InitList):
                self._initialise(target, part, scope)
            else:
                self.memory.put(target, self.expressions.value(part, scope))


def _parts(kind: Type) -> list[tuple[int, Type]]:
    """Offsets and types of the members or elements of a type."""
    if isinstance(kind, Array):
        return [(k * size_of(kind.of), kind.of) for k in range(kind.length)]
    assert isinstance(kind, StructType)
    offset, parts = 0, []
    for member in kind.members.values():
        parts.append((offset, member))
        offset += size_of(member)
    return parts


def _returns(statements: Sequence[c_ast.Node]) -> bool:
    for statement in statements:
        match statement:
            case c_ast.Return():
                return True
            case c_ast.Compound() if _returns(statement.block_items or []):
                return True
            case c_ast.If() if _returns([each for each in (statement.iftrue, statement.iffalse) if each]):
                return True
    return False
