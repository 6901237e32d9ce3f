"""Dataflow of a generated C function: its syntax tree is executed with symbolic values.

Calls are expanded, loops of constant length unrolled, local variables, structs and pointers to them resolved. Both
sides of an `if` are evaluated and their results selected, so a kernel has no branch. A word of the caller's struct is
loaded once and stored once, at the end.

A function outside this subset (loops that depend on data, calls that are not in the text, signed integers, stores at
an address that depends on data inside an `if`) is refused with KernelRefusalError; it stays in C.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

from pycparser import c_ast

from hysgen.c674x.schedule.c_memory import Leaf, Place, State, SymbolicMemory, Value, Whole, size_of
from hysgen.c674x.schedule.c_operators import operation
from hysgen.c674x.schedule.c_source import KernelRefusalError, Source, literal
from hysgen.c674x.schedule.dataflow import Graph, Kernel, Op
from hysgen.codegen.operations.types import FLOAT, INTEGER, Array, Pointer, Scalar, StructType, Type

Result = TypeVar("Result")

MOST_OPERATIONS: Final = 12_000
"""Operations of a kernel, bounded because a schedule's time and code grow with them."""


def kernel(source: Source, function: str) -> Kernel:
    """The dataflow of `function`, named with the model's prefix. Raises KernelRefusalError."""
    graph = Graph()
    return _Execution(source, graph, SymbolicMemory(graph, source.tables)).run(function)


@dataclass
class _Execution:
    source: Source
    graph: Graph
    memory: SymbolicMemory
    locals: int = 0

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
        before = self.memory.state
        returns = any(_returns(side) for side in sides)
        executed = [[*side, *rest] if returns else side for side in sides]
        taken, (one, yes) = self._from(self._assumed(before, condition), lambda: self._block(executed[0], dict(scope)))
        passed, (other, no) = self._from(before, lambda: self._block(executed[1], dict(scope)))
        self.memory.state = self._merged(condition, taken, passed)
        if not returns:
            return False, None, False
        if one != other:
            raise KernelRefusalError(f"{node.coord}: only one side returns")
        return one, self._either(condition, yes, no), True

    def _assumed(self, state: State, condition: Op) -> State:
        """The state where a condition holds: choices by this condition, or by one that it implies, are made."""
        known = set(map(id, _conjuncts(condition)))
        cells = {
            key: self._decided(value, known) if isinstance(value, Op) else value for key, value in state.cells.items()
        }
        return State(cells, set(state.dirty))

    def _decided(self, value: Op, known: set[int]) -> Op:
        if value.kind != "select" or not value.args[0].truth:
            return value
        conjuncts = _conjuncts(value.args[0])
        left = [each for each in conjuncts if id(each) not in known]
        if len(left) == len(conjuncts):
            return value
        yes = self._decided(value.args[1], known)
        if not left:
            return yes
        condition = left[0]
        for each in left[1:]:
            condition = self.graph.op("and", condition, each)
        return self.graph.select(condition, yes, value.args[2])

    def _from(self, before: State, execute: Callable[[], Result]) -> tuple[State, Result]:
        """Execute code that runs under a condition, from a copy of the state; the state behind it and the result."""
        self.memory.state = before.copy()
        self.memory.conditional += 1
        result = execute()
        self.memory.conditional -= 1
        return self.memory.state, result

    def _merged(self, condition: Op, yes: State, no: State) -> State:
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
            chosen = self._either(condition, leaves[0], leaves[1])
            assert isinstance(chosen, Op | Place)
            merged.cells[key] = chosen
        return merged

    def _stored_before(self, key: tuple[str, int], new: Leaf, old: Leaf) -> Leaf:
        """The word as a load, if an earlier `if` may have changed it.

        The earlier value is stored at once. Both stores become stores under a condition, and the earlier value leaves
        its register.
        """
        if self.memory.conditional or not isinstance(new, Op) or new is old:
            return old
        return self.memory.settled(key, old)

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
            self.memory.put(place, self._value(node.init, scope))

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
                self.memory.put(target, self._value(part, scope))

    # ---- expressions

    def _word(self, node: c_ast.Node, scope: dict[str, Place]) -> Op:
        value = self._value(node, scope)
        if not isinstance(value, Op):
            raise KernelRefusalError(f"{node.coord}: a number is expected")
        return value

    def _value(self, node: c_ast.Node, scope: dict[str, Place]) -> Value:
        match node:
            case c_ast.Constant():
                return self.graph.const(literal(node))
            case c_ast.ID() if node.name in self.source.constants:
                return self.graph.const(self.source.constants[node.name])
            case c_ast.ID() | c_ast.ArrayRef() | c_ast.StructRef() | c_ast.UnaryOp(op="*"):
                return self.memory.get(self._place(node, scope))
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
                return self._either(
                    condition,
                    self._evaluated_if(condition, True, node.iftrue, scope),
                    self._evaluated_if(condition, False, node.iffalse, scope),
                )
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
                    offset += size_of(kind)
            case c_ast.ArrayRef():
                base = self._place(node.name, scope)
                if isinstance(base.kind, Pointer):
                    base = self._target(base, node)
                    element, extent = base.kind, None
                else:
                    assert isinstance(base.kind, Array)
                    element, extent = base.kind.of, size_of(base.kind)
                return self._element(base, element, extent, self._word(node.subscript, scope))
            case c_ast.UnaryOp(op="*"):
                return self._target(self._place(node.expr, scope), node)
        raise KernelRefusalError(f"{node.coord}: {type(node).__name__} is no place")

    def _target(self, pointer: Place, node: c_ast.Node) -> Place:
        target = self.memory.get(pointer)
        if not isinstance(target, Place):
            raise KernelRefusalError(f"{node.coord}: the target of the pointer is unknown")
        kind = pointer.kind
        if isinstance(target.kind, Array) and isinstance(kind, Pointer) and not isinstance(kind.to, Array):
            return replace(target, kind=target.kind.of)
        return target

    def _element(self, base: Place, element: Type, extent: int | None, index: Op) -> Place:
        size = size_of(element)
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
            self.memory.put(place, new)
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
        a = self._word(node.left, scope)
        if node.op in ("&&", "||"):
            b = self._evaluated_if(a, node.op == "&&", node.right, scope)
            assert isinstance(b, Op), f"{node.coord}: a truth is a word"
            return operation(self.graph, node, node.op, a, b, False)
        b = self._word(node.right, scope)
        floating = self._floating(node.left, scope) or self._floating(node.right, scope)
        return operation(self.graph, node, node.op, a, b, floating)

    def _evaluated_if(self, condition: Op, holds: bool, node: c_ast.Node, scope: dict[str, Place]) -> Value:
        """The value of `node`, whose side effects happen only if the condition holds (or, `holds` false, fails)."""
        before = self.memory.state
        after, value = self._from(before, lambda: self._value(node, scope))
        self.memory.state = self._merged(condition, *((after, before) if holds else (before, after)))
        return value

    def _assign(self, node: c_ast.Assignment, scope: dict[str, Place]) -> Value:
        value = self._value(node.rvalue, scope)
        place = self._place(node.lvalue, scope)
        if node.op != "=":
            old = self.memory.get(place)
            if not isinstance(old, Op) or not isinstance(value, Op):
                raise KernelRefusalError(f"{node.coord}: operator {node.op}")
            value = operation(self.graph, node, node.op[:-1], old, value, _is_float(place.kind))
        self.memory.put(place, value)
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


def _conjuncts(condition: Op) -> list[Op]:
    """The truths that all hold if the condition holds."""
    if condition.kind == "and" and all(arg.truth for arg in condition.args):
        return [each for arg in condition.args for each in _conjuncts(arg)]
    return [condition]


def _is_float(kind: Type) -> bool:
    return isinstance(kind, Scalar) and kind == FLOAT


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
