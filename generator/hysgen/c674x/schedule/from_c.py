"""Dataflow of a generated C function: its syntax tree is executed with symbolic values.

Calls are expanded, loops of constant length unrolled, local variables, structs and pointers to them resolved. Both
sides of an `if` are evaluated and their results selected, so a kernel has no branch. A word of the caller's struct is
loaded once and stored once, at the end.

A function outside this subset (loops that depend on data, calls that are not in the text, signed integers, stores at
an address that depends on data inside an `if`) is refused with KernelRefusalError; it stays in C.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias

from pycparser import c_ast

from hysgen.c674x.schedule.dataflow import Graph, Kernel, Op
from hysgen.c674x.semantics import to_image
from hysgen.codegen.operations.text import concatenated, parsed
from hysgen.codegen.operations.types import FLOAT, INTEGER, Array, Pointer, Scalar, StructType, Type, Types, words
from hysgen.errors import TargetError

WORD: Final = 4
MOST_OPERATIONS: Final = 12_000
"""Operations of a kernel, bounded because a schedule's time and code grow with them."""

MOST_CHOICES: Final = 64
"""Words of an array whose elements are selected by an index that depends on data."""

_FLOAT_BINARY: Final = {"+": "addsp", "-": "subsp", "*": "mpysp"}
_INTEGER_BINARY: Final = {
    "+": "add",
    "-": "sub",
    "*": "mpy32",
    "&": "and",
    "|": "or",
    "^": "xor",
    "<<": "shl",
    ">>": "shru",
}


class KernelRefusalError(TargetError):
    """A C function that cannot become a kernel; the message says why."""


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
class _State:
    """Values of words by object and offset; `dirty`: words of the caller's memory that differ from it."""

    cells: dict[tuple[str, int], Leaf] = field(default_factory=dict)
    dirty: set[tuple[str, int]] = field(default_factory=set)

    def copy(self) -> _State:
        return _State(dict(self.cells), set(self.dirty))


@dataclass(frozen=True)
class _Access:
    """A load or store of the caller's memory that was emitted: bytes [low, high) of the object."""

    op: Op
    memory: str
    low: int
    high: int

    def meets(self, memory: str, low: int, high: int) -> bool:
        return self.memory == memory and self.low < high and low < self.high


class Source:
    """The parsed text of generated C: functions, types and tables of constants."""

    def __init__(self, name: str, texts: Mapping[str, str]) -> None:
        names = (f"{name}.h", f"{name}_params.h", f"{name}.c")
        tree = parsed(concatenated(texts, names, (f"{name.upper()}_NUMBERS",)), f"{name}.c")
        self.name = name
        self.types = Types()
        self.functions: dict[str, c_ast.FuncDef] = {}
        self.tables: dict[str, tuple[Type, tuple[int, ...]]] = {}
        self.constants: dict[str, int] = {}
        for node in tree.ext:
            match node:
                case c_ast.Typedef():
                    self.types.define(node)
                case c_ast.FuncDef():
                    self.functions[node.decl.name] = node
                case c_ast.Decl() if node.init is not None and not isinstance(node.type, c_ast.FuncDecl):
                    kind = self.types.of(node.type)
                    self.tables[node.name] = kind, tuple(_table_words(node.init))
                case c_ast.Decl() if isinstance(node.type, c_ast.Enum):
                    self._enumerate(node.type)

    def _enumerate(self, node: c_ast.Enum) -> None:
        following = 0
        for each in node.values.enumerators:
            if each.value is not None:
                following = _literal(each.value)
            self.constants[each.name] = following
            following += 1


def _table_words(node: c_ast.Node) -> list[int]:
    if isinstance(node, c_ast.InitList):
        return [word for part in node.exprs for word in _table_words(part)]
    return [_literal(node)]


def _literal(node: c_ast.Node) -> int:
    """The 32 bits of a constant, with its sign."""
    match node:
        case c_ast.UnaryOp(op="-"):
            inner = _literal(node.expr)
            floating = isinstance(node.expr, c_ast.Constant) and "float" in node.expr.type
            return inner ^ 0x8000_0000 if floating else -inner & 0xFFFF_FFFF
        case c_ast.Constant():
            if "float" in node.type or "double" in node.type:
                text = node.value.rstrip("fF")
                return to_image(float.fromhex(text) if "0x" in text.lower() else float(text))
            return int(re.sub("[uUlL]+$", "", node.value), 0) & 0xFFFF_FFFF
    raise KernelRefusalError(f"{node.coord}: not a constant")


def kernel(source: Source, function: str) -> Kernel:
    """The dataflow of `function`, named with the model's prefix. Raises KernelRefusalError."""
    return _Execution(source).run(function)


@dataclass
class _Execution:
    source: Source
    graph: Graph = field(default_factory=Graph)
    state: _State = field(default_factory=_State)
    bases: dict[str, Op] = field(default_factory=dict)
    accesses: list[_Access] = field(default_factory=list)
    stores: list[_Access] = field(default_factory=list)
    locals: int = 0
    conditional: int = 0

    def run(self, function: str) -> Kernel:
        node = self.source.functions[function]
        arguments: list[Value] = []
        parameters = node.decl.type.args.params if node.decl.type.args else []
        for index, parameter in enumerate(parameters):
            kind = self.source.types.of(parameter.type)
            word = self.graph.param(index)
            if isinstance(kind, Pointer):
                memory = f"*{parameter.name}"
                self.bases[memory] = word
                arguments.append(Place(memory, 0, kind.to))
            else:
                arguments.append(word)
        if sum(isinstance(argument, Place) for argument in arguments) > 1:
            raise KernelRefusalError(f"{function}: two pointers, whose memory may overlap")
        result = self._call(function, arguments)
        for memory, offset in sorted(self.state.dirty, key=self._made):
            self._flush(memory, offset)
        if isinstance(result, Place | Whole):
            raise KernelRefusalError(f"{function}: returns a pointer or a struct")
        tables = {name: self.source.tables[name][1] for name in self.bases if name in self.source.tables}
        return Kernel(function, len(arguments), tuple(each.op for each in self.stores), result, tables)

    def _made(self, cell: tuple[str, int]) -> tuple[int, str, int]:
        """Sorting key of a word of memory: when its value was computed."""
        value = self.state.cells[cell]
        return value.order if isinstance(value, Op) else 0, *cell

    # ---- memory

    def _base(self, memory: str) -> Op:
        if memory not in self.bases:
            self.bases[memory] = self.graph.symbol(memory)
        return self.bases[memory]

    def _external(self, memory: str) -> bool:
        return memory.startswith("*")

    def _flush(self, memory: str, offset: int) -> None:
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
        self.stores.append(_Access(op, memory, low, high))

    def _read(self, place: Place) -> Leaf:
        """The word at a place."""
        key = place.memory, place.offset
        if place.index is None:
            if key in self.state.cells:
                return self.state.cells[key]
            if place.memory in self.source.tables:
                return self.graph.const(self.source.tables[place.memory][1][place.offset // WORD])
            if not self._external(place.memory):
                return self.graph.const(0)  # an uninitialised local of a path that does not use it
            value = self._load(place.memory, place.offset, place.offset + WORD, self._base(place.memory), place.offset)
            self.state.cells[key] = value
            return value
        if place.memory in self.source.tables:
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
        self.accesses.append(_Access(value, memory, low, high))
        return value

    def _chosen(self, place: Place) -> Op:
        """The word at an index that depends on data, by choices between all words of the array."""
        size, count = self._elements(place)
        shift = place.offset - place.low
        leaves = [self._read(Place(place.memory, place.low + shift % size + size * k, INTEGER)) for k in range(count)]
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
                self._flush(memory, offset)
                self.state.dirty.discard((memory, offset))

    def _write(self, place: Place, value: Leaf) -> None:
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
                old = self._read(target)
                chosen = self._either(here, value, old)
                assert isinstance(chosen, Op)
                self._write(target, chosen)
            return
        self._settle(place)
        for cell in [c for c in self.state.cells if c[0] == place.memory and place.low <= c[1] < place.high]:
            del self.state.cells[cell]
        address = self.graph.op("add", self._base(place.memory), place.index)
        self._store(place.memory, place.low, place.high, address, place.offset, value)

    def _get(self, place: Place) -> Value:
        """The value at a place: a word, a struct by value, or the place itself for an array."""
        match place.kind:
            case Array():
                return place
            case StructType():
                return Whole(
                    {offset: self._read(place.at(offset, INTEGER)) for offset in range(0, _size(place.kind), WORD)}
                )
        return self._read(place)

    def _put(self, place: Place, value: Value) -> None:
        match value:
            case Whole():
                for offset, leaf in value.leaves.items():
                    self._write(place.at(offset, INTEGER), leaf)
            case None:
                raise KernelRefusalError("a void value is assigned")
            case _:
                self._write(place, value)

    # ---- statements

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
            self._put(scope[parameter.name], value)
        returned, value = self._block(node.body.block_items or [], scope)
        return value if returned else None

    def _local(self, name: str, kind: Type) -> Place:
        self.locals += 1
        return Place(f"{name}.{self.locals}", 0, kind)

    def _block(self, statements: Sequence[c_ast.Node], scope: dict[str, Place]) -> tuple[bool, Value]:
        """Execute; whether it returned, and the value."""
        if self.graph.count > MOST_OPERATIONS:
            raise KernelRefusalError(f"more than {MOST_OPERATIONS} operations")
        for k, statement in enumerate(statements):
            match statement:
                case c_ast.If():
                    returned, value, done = self._if(statement, statements[k + 1 :], scope)
                    if done:
                        return returned, value
                case c_ast.Return():
                    return True, (self._value(statement.expr, scope) if statement.expr else None)
                case c_ast.Compound():
                    returned, value = self._block(statement.block_items or [], dict(scope))
                    if returned:
                        return True, value
                case c_ast.For():
                    self._for(statement, scope)
                case c_ast.DeclList():
                    for each in statement.decls:
                        self._declare(each, scope)
                case c_ast.Decl():
                    self._declare(statement, scope)
                case c_ast.EmptyStatement() | c_ast.Pragma():
                    pass
                case _:
                    self._value(statement, scope)
        return False, None

    def _if(self, node: c_ast.If, rest: Sequence[c_ast.Node], scope: dict[str, Place]) -> tuple[bool, Value, bool]:
        """Both sides, then the rest if a side returns; the last answer: whether the rest was executed."""
        condition = self._word(node.cond, scope)
        sides = [[] if side is None else [side] for side in (node.iftrue, node.iffalse)]
        if condition.kind == "const":
            returned, value = self._block(sides[condition.number == 0], dict(scope))
            return returned, value, returned
        before = self.state
        self.conditional += 1
        ends: list[tuple[_State, bool, Value]] = []
        returns = any(_returns(side) for side in sides)
        for side in sides:
            self.state = before.copy()
            returned, value = self._block([*side, *rest] if returns else side, dict(scope))
            ends.append((self.state, returned, value))
        self.conditional -= 1
        self.state = self._merged(condition, ends[0][0], ends[1][0])
        if not returns:
            return False, None, False
        (_, one, yes), (_, other, no) = ends
        if one != other:
            raise KernelRefusalError(f"{node.coord}: only one side returns")
        return one, self._either(condition, yes, no), True

    def _merged(self, condition: Op, yes: _State, no: _State) -> _State:
        merged = _State({}, yes.dirty | no.dirty)
        for key in {**yes.cells, **no.cells}:
            leaves = []
            for side in (yes, no):
                self.state = side
                leaves.append(self._read(Place(key[0], key[1], INTEGER)))
            chosen = self._either(condition, leaves[0], leaves[1])
            assert isinstance(chosen, Op | Place)
            merged.cells[key] = chosen
        return merged

    def _either(self, condition: Op, yes: Value, no: Value) -> Value:
        match yes, no:
            case Op(), Op():
                return self.graph.select(condition, yes, no)
            case Whole(), Whole():
                return Whole({k: self._either(condition, yes.leaves[k], no.leaves[k]) for k in yes.leaves})  # type: ignore[misc]
            case Place(), Place() if yes == no:
                return yes
            case None, None:
                return None
            case (Place(), _) | (_, Place()):
                return yes if isinstance(yes, Place) else no  # a pointer of one side only
        raise KernelRefusalError("the two sides of an if leave different pointers")

    def _for(self, node: c_ast.For, scope: dict[str, Place]) -> None:
        inner = dict(scope)
        if isinstance(node.init, c_ast.DeclList):
            for each in node.init.decls:
                self._declare(each, inner)
        elif node.init is not None:
            self._value(node.init, inner)
        while True:
            condition = self._word(node.cond, inner)
            if condition.kind != "const":
                raise KernelRefusalError(f"{node.coord}: the length of a loop depends on data")
            if not condition.number:
                return
            body = node.stmt.block_items or [] if isinstance(node.stmt, c_ast.Compound) else [node.stmt]
            if self._block(body, dict(inner))[0]:
                raise KernelRefusalError(f"{node.coord}: a return inside a loop")
            self._value(node.next, inner)

    def _declare(self, node: c_ast.Decl, scope: dict[str, Place]) -> None:
        place = scope[node.name] = self._local(node.name, self.source.types.of(node.type))
        if node.init is None:
            return
        if isinstance(node.init, c_ast.InitList):
            self._initialise(place, node.init, scope)
        else:
            self._put(place, self._value(node.init, scope))

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
                self._put(target, self._value(part, scope))

    # ---- expressions

    def _word(self, node: c_ast.Node, scope: dict[str, Place]) -> Op:
        value = self._value(node, scope)
        if not isinstance(value, Op):
            raise KernelRefusalError(f"{node.coord}: a number is expected")
        return value

    def _value(self, node: c_ast.Node, scope: dict[str, Place]) -> Value:
        match node:
            case c_ast.Constant():
                return self.graph.const(_literal(node))
            case c_ast.ID() if node.name in self.source.constants:
                return self.graph.const(self.source.constants[node.name])
            case c_ast.ID() | c_ast.ArrayRef() | c_ast.StructRef() | c_ast.UnaryOp(op="*"):
                return self._get(self._place(node, scope))
            case c_ast.UnaryOp(op="&"):
                return self._place(node.expr, scope)
            case c_ast.UnaryOp():
                return self._unary(node, scope)
            case c_ast.BinaryOp():
                return self._binary(node, scope)
            case c_ast.Assignment():
                return self._assign(node, scope)
            case c_ast.FuncCall():
                arguments = [self._value(each, scope) for each in (node.args.exprs if node.args else [])]
                return self._call(node.name.name, arguments)
            case c_ast.Cast():
                return self._cast(node, scope)
            case c_ast.TernaryOp():
                condition = self._word(node.cond, scope)
                if condition.kind == "const":
                    return self._value(node.iftrue if condition.number else node.iffalse, scope)
                return self._either(condition, self._value(node.iftrue, scope), self._value(node.iffalse, scope))
            case c_ast.ExprList():
                return [self._value(each, scope) for each in node.exprs][-1]
        raise KernelRefusalError(f"{node.coord}: {type(node).__name__} is not supported")

    def _place(self, node: c_ast.Node, scope: dict[str, Place]) -> Place:
        match node:
            case c_ast.ID():
                if node.name in scope:
                    return scope[node.name]
                if node.name in self.source.tables:
                    return Place(node.name, 0, self.source.tables[node.name][0])
                raise KernelRefusalError(f"{node.coord}: {node.name} is unknown")
            case c_ast.StructRef():
                base = self._place(node.name, scope)
                if node.type == "->":
                    base = self._target(base, node)
                assert isinstance(base.kind, StructType)
                offset = 0
                for member, kind in base.kind.members.items():
                    if member == node.field.name:
                        return base.at(offset, kind)
                    offset += _size(kind)
            case c_ast.ArrayRef():
                base = self._place(node.name, scope)
                if isinstance(base.kind, Pointer):
                    base = self._target(base, node)
                    element, extent = base.kind, None
                else:
                    assert isinstance(base.kind, Array)
                    element, extent = base.kind.of, _size(base.kind)
                return self._element(base, element, extent, self._word(node.subscript, scope))
            case c_ast.UnaryOp(op="*"):
                return self._target(self._place(node.expr, scope), node)
        raise KernelRefusalError(f"{node.coord}: {type(node).__name__} is no place")

    def _target(self, pointer: Place, node: c_ast.Node) -> Place:
        target = self._get(pointer)
        if not isinstance(target, Place):
            raise KernelRefusalError(f"{node.coord}: the target of the pointer is unknown")
        kind = pointer.kind
        if isinstance(target.kind, Array) and isinstance(kind, Pointer) and not isinstance(kind.to, Array):
            return replace(target, kind=target.kind.of)
        return target

    def _element(self, base: Place, element: Type, extent: int | None, index: Op) -> Place:
        size = _size(element)
        if index.kind == "const":
            signed = index.number - (1 << 32) if index.number >> 31 else index.number
            return base.at(signed * size, element)
        distance = self.graph.op("mpy32", index, self.graph.const(size))
        if base.index is not None:
            return replace(base, kind=element, index=self.graph.op("add", base.index, distance))
        low = base.offset if extent is not None else 0
        high = base.offset + extent if extent is not None else 1 << 30
        return Place(base.memory, base.offset, element, distance, low, high, size)

    def _unary(self, node: c_ast.UnaryOp, scope: dict[str, Place]) -> Value:
        graph = self.graph
        if node.op in ("++", "p++", "--", "p--"):
            place = self._place(node.expr, scope)
            old = self._word(node.expr, scope)
            new = graph.op("add", old, graph.const(1 if "+" in node.op else -1))
            self._put(place, new)
            return old if node.op.startswith("p") else new
        value = self._word(node.expr, scope)
        floating = self._floating(node.expr, scope)
        match node.op:
            case "-" if floating:
                return graph.op("xor", value, graph.const(0x8000_0000))
            case "-":
                return graph.op("sub", graph.const(0), value)
            case "~":
                return graph.op("xor", value, graph.const(-1))
            case "!":
                return graph.op("cmpeq", value, graph.const(0))
            case "+":
                return value
        raise KernelRefusalError(f"{node.coord}: operator {node.op}")

    def _binary(self, node: c_ast.BinaryOp, scope: dict[str, Place]) -> Value:
        a, b = self._word(node.left, scope), self._word(node.right, scope)
        floating = self._floating(node.left, scope) or self._floating(node.right, scope)
        return self._operation(node, node.op, a, b, floating)

    def _operation(self, node: c_ast.Node, op: str, a: Op, b: Op, floating: bool) -> Op:
        graph = self.graph
        if op in ("&&", "||"):
            truths = [each if each.truth else _not(graph, graph.op("cmpeq", each, graph.const(0))) for each in (a, b)]
            return graph.op("and" if op == "&&" else "or", *truths)
        if floating:
            if op in _FLOAT_BINARY:
                return graph.op(_FLOAT_BINARY[op], a, b)
            match op:
                case "<":
                    return graph.op("cmpltsp", a, b)
                case ">":
                    return graph.op("cmpgtsp", a, b)
                case "<=":
                    return graph.op("or", graph.op("cmpltsp", a, b), graph.op("cmpeqsp", a, b))
                case ">=":
                    return graph.op("or", graph.op("cmpgtsp", a, b), graph.op("cmpeqsp", a, b))
                case "==":
                    return graph.op("cmpeqsp", a, b)
                case "!=":
                    return _not(graph, graph.op("cmpeqsp", a, b))
            raise KernelRefusalError(f"{node.coord}: {op} of floats")
        if op in _INTEGER_BINARY:
            return graph.op(_INTEGER_BINARY[op], a, b)
        match op:
            case "<" if b.kind == "const" and b.number == 0xFFFF_FFFF:
                return _not(graph, graph.op("cmpeq", a, b))
            case ">" if b.kind == "const" and b.number == 0:
                return _not(graph, graph.op("cmpeq", a, b))
            case "<":
                return graph.op("cmpltu", a, b)
            case ">":
                return graph.op("cmpgtu", a, b)
            case ">=" if b.kind == "const" and b.number:
                return graph.op("cmpgtu", a, graph.const(b.number - 1))
            case ">=":
                return _not(graph, graph.op("cmpltu", a, b))
            case "<=":
                return _not(graph, graph.op("cmpgtu", a, b))
            case "==":
                return graph.op("cmpeq", a, b)
            case "!=":
                return _not(graph, graph.op("cmpeq", a, b))
        raise KernelRefusalError(f"{node.coord}: operator {op}")

    def _assign(self, node: c_ast.Assignment, scope: dict[str, Place]) -> Value:
        value = self._value(node.rvalue, scope)
        place = self._place(node.lvalue, scope)
        if node.op != "=":
            old = self._get(place)
            if not isinstance(old, Op) or not isinstance(value, Op):
                raise KernelRefusalError(f"{node.coord}: operator {node.op}")
            value = self._operation(node, node.op[:-1], old, value, _is_float(place.kind))
        self._put(place, value)
        return value

    def _cast(self, node: c_ast.Cast, scope: dict[str, Place]) -> Value:
        names = getattr(node.to_type.type.type, "names", [""])
        value = self._value(node.expr, scope)
        if names == ["void"] or not isinstance(value, Op):
            return value
        if names[-1] not in ("uint32_t", "float"):
            raise KernelRefusalError(f"{node.coord}: a cast to {' '.join(names)}")
        floating = self._floating(node.expr, scope)
        if floating == (names[-1] == "float"):
            return value
        if floating:
            raise KernelRefusalError(f"{node.coord}: a float becomes an integer")
        return self.graph.op("intspu", value)

    def _floating(self, node: c_ast.Node, scope: dict[str, Place]) -> bool:
        """Whether the type of an expression is float."""
        match node:
            case c_ast.Constant():
                return "float" in node.type or "double" in node.type
            case c_ast.ID() if node.name in self.source.constants:
                return False
            case c_ast.ID() | c_ast.ArrayRef() | c_ast.StructRef() | c_ast.UnaryOp(op="*"):
                return _is_float(self._place(node, scope).kind)
            case c_ast.UnaryOp(op=op):
                return op != "!" and self._floating(node.expr, scope)
            case c_ast.BinaryOp(op=op):
                if op in ("<", ">", "<=", ">=", "==", "!=", "&&", "||"):
                    return False
                return self._floating(node.left, scope) or self._floating(node.right, scope)
            case c_ast.Cast():
                return bool(getattr(node.to_type.type.type, "names", [""])[-1] == "float")
            case c_ast.TernaryOp():
                return self._floating(node.iftrue, scope)
            case c_ast.Assignment():
                return self._floating(node.lvalue, scope)
            case c_ast.FuncCall():
                declared = self.source.functions.get(node.name.name)
                return declared is not None and _is_float(
                    self.source.types.of(self.source.functions[node.name.name].decl.type.type)
                )
        raise KernelRefusalError(f"{node.coord}: {type(node).__name__} has no type here")


def _not(graph: Graph, truth: Op) -> Op:
    return graph.op("xor", truth, graph.const(1))


def _is_float(kind: Type) -> bool:
    return isinstance(kind, Scalar) and kind == FLOAT


def _size(kind: Type) -> int:
    return WORD * words(kind)


def _parts(kind: Type) -> list[tuple[int, Type]]:
    """Offsets and types of the members or elements of a type."""
    if isinstance(kind, Array):
        return [(k * _size(kind.of), kind.of) for k in range(kind.length)]
    assert isinstance(kind, StructType)
    offset, parts = 0, []
    for member in kind.members.values():
        parts.append((offset, member))
        offset += _size(member)
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
