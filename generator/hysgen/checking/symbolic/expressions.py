"""Values and addresses of C expressions whose operands are symbolic, and the operators of C."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from pycparser import c_ast

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.memory import Branches, Place, SymbolicMemory, Value, size_of
from hysgen.checking.symbolic.source import KernelRefusalError, Source, literal
from hysgen.codegen.operations.text import FLOAT, Array, Pointer, Scalar, StructType, Type

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


def operation(graph: Graph, node: c_ast.Node, op: str, a: Op, b: Op, floating: bool) -> Op:
    """The value of `a op b`: of floats if `floating`, else of uint32_t; a comparison gives 0 or 1.

    Raises KernelRefusalError with the place of `node` for an operator outside the subset.
    """
    if op in ("&&", "||"):
        truths = [each if each.truth else negated(graph, graph.op("cmpeq", each, graph.const(0))) for each in (a, b)]
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
                return negated(graph, graph.op("cmpeqsp", a, b))
        raise KernelRefusalError(f"{node.coord}: {op} of floats")
    if op in _INTEGER_BINARY:
        return graph.op(_INTEGER_BINARY[op], a, b)
    if op == "/" and b.kind == "const" and b.number & (b.number - 1) == 0 < b.number:
        return graph.op("shru", a, graph.const(b.number.bit_length() - 1))
    match op:
        case "<" if b.kind == "const" and b.number == 0xFFFF_FFFF:
            return negated(graph, graph.op("cmpeq", a, b))
        case ">" if b.kind == "const" and b.number == 0:
            return negated(graph, graph.op("cmpeq", a, b))
        case "<":
            return graph.op("cmpltu", a, b)
        case ">":
            return graph.op("cmpgtu", a, b)
        case ">=" if b.kind == "const" and b.number:
            return graph.op("cmpgtu", a, graph.const(b.number - 1))
        case ">=":
            return negated(graph, graph.op("cmpltu", a, b))
        case "<=":
            return negated(graph, graph.op("cmpgtu", a, b))
        case "==":
            return graph.op("cmpeq", a, b)
        case "!=":
            return negated(graph, graph.op("cmpeq", a, b))
    raise KernelRefusalError(f"{node.coord}: operator {op}")


def negated(graph: Graph, truth: Op) -> Op:
    """1 if `truth` is 0, else 0."""
    return graph.op("xor", truth, graph.const(1))


@dataclass
class Expressions:
    """Evaluation of expressions in a scope, the places of the local variables by name.

    call: the value of a call of a function, by its name and arguments.
    """

    source: Source
    graph: Graph
    memory: SymbolicMemory
    branches: Branches
    call: Callable[[str, Sequence[Value]], Value]

    def word(self, node: c_ast.Node, scope: dict[str, Place]) -> Op:
        """The value of an expression that is a number."""
        value = self.value(node, scope)
        if not isinstance(value, Op):
            raise KernelRefusalError(f"{node.coord}: a number is expected")
        return value

    def value(self, node: c_ast.Node, scope: dict[str, Place]) -> Value:
        """The value of an expression. Raises KernelRefusalError if it is outside the subset."""
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
                arguments = [self.value(each, scope) for each in (node.args.exprs if node.args else [])]
                return self.call(node.name.name, arguments)
            case c_ast.Cast():
                return self._cast(node, scope)
            case c_ast.TernaryOp():
                condition = self.word(node.cond, scope)
                if condition.kind == "const":
                    return self.value(node.iftrue if condition.number else node.iffalse, scope)
                return self.branches.either(
                    condition,
                    self._evaluated_if(condition, True, node.iftrue, scope),
                    self._evaluated_if(condition, False, node.iffalse, scope),
                )
            case c_ast.ExprList():
                return [self.value(each, scope) for each in node.exprs][-1]
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
                return self._element(base, element, extent, self.word(node.subscript, scope))
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
            old = self.word(node.expr, scope)
            new = graph.op("add", old, graph.const(1 if "+" in node.op else -1))
            self.memory.put(place, new)
            return old if node.op.startswith("p") else new
        value = self.word(node.expr, scope)
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
        a = self.word(node.left, scope)
        if node.op in ("&&", "||"):
            b = self._evaluated_if(a, node.op == "&&", node.right, scope)
            assert isinstance(b, Op), f"{node.coord}: a truth is a word"
            return operation(self.graph, node, node.op, a, b, False)
        b = self.word(node.right, scope)
        floating = self._floating(node.left, scope) or self._floating(node.right, scope)
        return operation(self.graph, node, node.op, a, b, floating)

    def _evaluated_if(self, condition: Op, holds: bool, node: c_ast.Node, scope: dict[str, Place]) -> Value:
        """The value of `node`, whose side effects happen only if the condition holds (or, `holds` false, fails)."""
        before = self.memory.state
        after, value = self.branches.execute(before, lambda: self.value(node, scope))
        self.memory.state = self.branches.merged(condition, *((after, before) if holds else (before, after)))
        return value

    def _assign(self, node: c_ast.Assignment, scope: dict[str, Place]) -> Value:
        value = self.value(node.rvalue, scope)
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
        value = self.value(node.expr, scope)
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


def _is_float(kind: Type) -> bool:
    return isinstance(kind, Scalar) and kind == FLOAT
