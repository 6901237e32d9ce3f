"""Operation counts of generated C along the most expensive path of its syntax tree, calls and loops expanded.

The counts are those of code without optimisation: a value that is used twice is loaded twice. Local variables, and
pointers to local variables, count as registers; the minus of a negative constant is not counted.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

from pycparser import c_ast

from hysgen.codegen.operations.text import (
    FLOAT,
    INTEGER,
    Array,
    Pointer,
    Scalar,
    StructType,
    Type,
    Types,
    constant,
    words,
)
from hysgen.errors import HysgenError


@dataclass(frozen=True)
class Counts:
    """Operations of one call.

    add: float32 additions and subtractions; multiply: float32 multiplications; compare: float32 comparisons;
    convert: conversions between float32 and integer; integer: integer operations except those of addresses, and
    conditional moves `c ? a : b`; load, store: 32-bit words of the caller's structs and of constant tables (local
    variables count as registers); branch: branches of if statements and loops.
    """

    add: int = 0
    multiply: int = 0
    compare: int = 0
    convert: int = 0
    integer: int = 0
    load: int = 0
    store: int = 0
    branch: int = 0

    def __add__(self, other: Self) -> Counts:
        return Counts(*map(operator.add, vars(self).values(), vars(other).values()))

    def times(self, count: int) -> Counts:
        """The counts multiplied by `count`."""
        return Counts(*(count * number for number in vars(self).values()))

    @property
    def total(self) -> int:
        """Sum over all kinds."""
        return sum(vars(self).values())

    def to_json(self) -> dict[str, int]:
        """The counts by kind and their total, as JSON values."""
        return {**vars(self), "total": self.total}

    def describe(self) -> str:
        """The counts that are not zero, in one line of text."""
        words = {
            "add": "float +-",
            "multiply": "float *",
            "compare": "float comparisons",
            "convert": "conversions",
            "integer": "integer",
            "load": "loads",
            "store": "stores",
            "branch": "branches",
        }
        named = ((getattr(self, field), word) for field, word in words.items())
        return ", ".join(f"{number} {word}" for number, word in named if number)


def worse(first: Counts, second: Counts) -> Counts:
    """The argument with the larger total."""
    return first if first.total >= second.total else second


_NOTHING = Counts()
_LOAD, _STORE, _INTEGER = Counts(load=1), Counts(store=1), Counts(integer=1)
_COMPARISONS = frozenset({"<", ">", "<=", ">=", "==", "!="})


@dataclass(frozen=True)
class Value:
    """Value of an expression: its type, and whether it is stored in memory or points to memory."""

    type: Type
    in_memory: bool = False


@dataclass
class Scope:
    """Variables by name. indices: values of the indices of enclosing loops that decide the length of a loop inside."""

    names: dict[str, Value] = field(default_factory=dict)
    indices: dict[str, int] = field(default_factory=dict)

    def inner(self) -> Scope:
        """A scope inside of this one."""
        return Scope(dict(self.names), dict(self.indices))


class Program:
    """A translation unit whose public functions can be counted."""

    def __init__(self, tree: c_ast.FileAST) -> None:
        self.types = Types()
        self._functions: dict[str, c_ast.FuncDef] = {}
        self._calls: dict[tuple[str | bool, ...], Counts] = {}
        self._globals = Scope()
        self.constant_words = 0
        for node in tree.ext:
            match node:
                case c_ast.Typedef():
                    self.types.define(node)
                    self._globals.names |= dict.fromkeys(_enumerators(node), Value(INTEGER))
                case c_ast.FuncDef():
                    self._functions[node.decl.name] = node
                case c_ast.Decl() if not isinstance(node.type, c_ast.FuncDecl):
                    kind = self.types.of(node.type)
                    self._globals.names[node.name] = Value(kind, in_memory=True)
                    self.constant_words += words(kind)

    def public(self) -> list[str]:
        """Names of the functions with external linkage."""
        return [name for name, node in self._functions.items() if "static" not in node.decl.storage]

    def count(self, name: str) -> Counts:
        """Operations of the most expensive path through function `name`; its arguments are in memory."""
        function = self._functions[name]
        arguments = [Value(self.types.of(p.type), in_memory=True) for p in _parameters(function)]
        return self._called(function, arguments)

    def _called(self, function: c_ast.FuncDef, arguments: Sequence[Value]) -> Counts:
        """Operations of a call; they depend on the function and on which of its arguments are in memory."""
        key = (function.decl.name, *(value.in_memory for value in arguments))
        if key not in self._calls:
            self._calls[key] = self._followed(function, arguments)
        return self._calls[key]

    def _followed(self, function: c_ast.FuncDef, arguments: Sequence[Value]) -> Counts:
        scope = Scope(dict(self._globals.names))
        for parameter, value in zip(_parameters(function), arguments, strict=True):
            kind = self.types.of(parameter.type)
            # A scalar is passed in a register; a pointer keeps the location of its target.
            scope.names[parameter.name] = Value(kind, value.in_memory and not isinstance(kind, Scalar))
        return self._block(function.body.block_items or [], scope)[0]

    def _block(self, statements: Sequence[c_ast.Node], scope: Scope) -> tuple[Counts, bool]:
        """Operations of the most expensive path through `statements`, and whether every path ends in a return."""
        total = _NOTHING
        for k, statement in enumerate(statements):
            if isinstance(statement, c_ast.If):
                total += self._expression(statement.cond, scope)[0] + Counts(branch=1)
                rest = self._block(statements[k + 1 :], scope)
                paths = [self._statement(side, scope) for side in (statement.iftrue, statement.iffalse)]
                whole = [cost if returns else cost + rest[0] for cost, returns in paths]
                return total + worse(*whole), all(returns or rest[1] for _, returns in paths)
            cost, returns = self._statement(statement, scope)
            total += cost
            if returns:
                return total, True
        return total, False

    def _statement(self, node: c_ast.Node | None, scope: Scope) -> tuple[Counts, bool]:
        match node:
            case None | c_ast.EmptyStatement() | c_ast.Pragma() | c_ast.Break():
                return _NOTHING, False
            case c_ast.Compound():
                return self._block(node.block_items or [], scope.inner())
            case c_ast.If():
                return self._block([node], scope)
            case c_ast.Return():
                return (self._expression(node.expr, scope)[0] if node.expr else _NOTHING), True
            case c_ast.Decl():
                scope.names[node.name] = Value(self.types.of(node.type))
                return self._initialised(node, scope), False
            case c_ast.DeclList():
                parts = [self._statement(decl, scope)[0] for decl in node.decls]
                return sum(parts, _NOTHING), False
            case c_ast.For():
                return self._loop(node, scope), False
            case c_ast.Switch():
                return self._switch(node, scope), False
            case c_ast.While() | c_ast.DoWhile() | c_ast.Goto() | c_ast.Label() | c_ast.Continue():
                raise HysgenError(f"{node.coord}: {type(node).__name__} has no fixed cost; generated C does not use it")
        return self._expression(node, scope)[0], False

    def _initialised(self, node: c_ast.Decl, scope: Scope) -> Counts:
        if node.init is None:
            return _NOTHING
        cost, value = self._expression(node.init, scope)
        kind = scope.names[node.name].type
        if isinstance(kind, Pointer):
            scope.names[node.name] = Value(kind, value.in_memory)
        return cost

    def _loop(self, node: c_ast.For, scope: Scope) -> Counts:
        inner = scope.inner()
        start = self._statement(node.init, inner)[0]
        index, passes = _passes(node, scope.indices)
        turn = self._expression(node.cond, inner)[0] + Counts(branch=1)
        step = self._expression(node.next, inner)[0]
        if _decides(index, node.stmt):
            bodies = [
                self._statement(node.stmt, Scope(inner.names, {**inner.indices, index: value}))[0] for value in passes
            ]
            return start + turn + (turn + step).times(len(passes)) + sum(bodies, _NOTHING)
        return start + turn + (turn + self._statement(node.stmt, inner)[0] + step).times(len(passes))

    def _switch(self, node: c_ast.Switch, scope: Scope) -> Counts:
        """Operations of the most expensive case; every case of generated C ends in a break or return."""
        cases = [self._block(case.stmts or [], scope.inner())[0] for case in node.stmt.block_items]
        costliest = _NOTHING
        for case in cases:
            costliest = worse(costliest, case)
        return self._expression(node.cond, scope)[0] + Counts(integer=len(cases), branch=1) + costliest

    def _expression(self, node: c_ast.Node, scope: Scope) -> tuple[Counts, Value]:
        """Operations of evaluating an expression, and its value."""
        match node:
            case c_ast.Constant():
                return _NOTHING, Value(FLOAT if "float" in node.type or "double" in node.type else INTEGER)
            case c_ast.ID() | c_ast.ArrayRef() | c_ast.StructRef():
                cost, place = self._place(node, scope)
                return cost + _moved(place, _LOAD), place
            case c_ast.BinaryOp():
                return self._binary(node, scope)
            case c_ast.UnaryOp():
                return self._unary(node, scope)
            case c_ast.Assignment():
                return self._assignment(node, scope)
            case c_ast.FuncCall():
                return self._call(node, scope)
            case c_ast.Cast():
                cost, value = self._expression(node.expr, scope)
                kind = self.types.of(node.to_type)
                changes = isinstance(kind, Scalar) and isinstance(value.type, Scalar) and kind != value.type
                void = getattr(node.to_type.type.type, "names", None) == ["void"]
                return cost + Counts(convert=int(changes and not void)), Value(kind, value.in_memory)
            case c_ast.TernaryOp():
                condition = self._expression(node.cond, scope)[0]
                (true, value), (false, _) = (self._expression(side, scope) for side in (node.iftrue, node.iffalse))
                # A choice between two values without operations compiles to a conditional move, not to a branch.
                chosen = _INTEGER if true.total == false.total == 0 else Counts(branch=1)
                return condition + chosen + worse(true, false), value
            case c_ast.InitList():
                parts = [self._expression(part, scope)[0] for part in node.exprs]
                return sum(parts, _NOTHING), Value(INTEGER)
            case c_ast.NamedInitializer():
                return self._expression(node.expr, scope)
            case c_ast.ExprList():
                costs = [self._expression(part, scope) for part in node.exprs]
                return sum((cost for cost, _ in costs), _NOTHING), costs[-1][1]
        raise HysgenError(f"{node.coord}: {type(node).__name__} is not an expression of generated C")

    def _place(self, node: c_ast.Node, scope: Scope) -> tuple[Counts, Value]:
        """Operations of computing the address of an lvalue, without a load, and its value."""
        match node:
            case c_ast.ID():
                return _NOTHING, scope.names[node.name]
            case c_ast.StructRef():
                cost, base = self._place(node.name, scope)
                kind = base.type
                if node.type == "->":
                    assert isinstance(kind, Pointer)
                    kind = kind.to
                assert isinstance(kind, StructType)
                return cost, Value(kind.members[node.field.name], base.in_memory)
            case c_ast.ArrayRef():
                cost, base = self._place(node.name, scope)
                index = self._expression(node.subscript, scope)[0]
                assert isinstance(base.type, Array | Pointer)
                element = base.type.of if isinstance(base.type, Array) else base.type.to
                return cost + index, Value(element, base.in_memory)
            case c_ast.UnaryOp(op="*"):
                cost, base = self._expression(node.expr, scope)
                assert isinstance(base.type, Pointer | Array)
                element = base.type.of if isinstance(base.type, Array) else base.type.to
                return cost, Value(element, base.in_memory)
        raise HysgenError(f"{node.coord}: {type(node).__name__} is not an lvalue of generated C")

    def _binary(self, node: c_ast.BinaryOp, scope: Scope) -> tuple[Counts, Value]:
        (left, a), (right, b) = (self._expression(side, scope) for side in (node.left, node.right))
        floating = FLOAT in (a.type, b.type)
        if node.op in _COMPARISONS:
            return left + right + (Counts(compare=1) if floating else _INTEGER), Value(INTEGER)
        if isinstance(a.type, Pointer | Array):
            return left + right, a
        if not floating:
            return left + right + _INTEGER, Value(INTEGER)
        if node.op not in ("+", "-", "*"):
            raise HysgenError(f"{node.coord}: float32 {node.op} is not part of the arithmetic of generated C")
        return left + right + (Counts(multiply=1) if node.op == "*" else Counts(add=1)), Value(FLOAT)

    def _unary(self, node: c_ast.UnaryOp, scope: Scope) -> tuple[Counts, Value]:
        if node.op == "&":
            cost, place = self._place(node.expr, scope)
            return cost, Value(Pointer(place.type), place.in_memory)
        if node.op == "*":
            cost, place = self._place(node, scope)
            return cost + _moved(place, _LOAD), place
        if node.op in ("++", "--", "p++", "p--"):
            cost, place = self._place(node.expr, scope)
            return cost + _INTEGER + _moved(place, _LOAD) + _moved(place, _STORE), place
        cost, value = self._expression(node.expr, scope)
        if isinstance(node.expr, c_ast.Constant):
            return cost, value
        # The negation of a float also counts as an integer operation, as it changes the sign bit.
        return cost + _INTEGER, Value(value.type)

    def _assignment(self, node: c_ast.Assignment, scope: Scope) -> tuple[Counts, Value]:
        cost, value = self._expression(node.rvalue, scope)
        address, place = self._place(node.lvalue, scope)
        if isinstance(place.type, Pointer) and isinstance(node.lvalue, c_ast.ID):
            scope.names[node.lvalue.name] = Value(place.type, value.in_memory)
        cost += address + _moved(place, _STORE)
        if node.op == "=":
            return cost, place
        operation = Counts(multiply=1) if node.op == "*=" else Counts(add=1)
        return cost + _moved(place, _LOAD) + (operation if place.type == FLOAT else _INTEGER), place

    def _call(self, node: c_ast.FuncCall, scope: Scope) -> tuple[Counts, Value]:
        function = self._functions.get(node.name.name)
        if function is None:
            raise HysgenError(f"{node.coord}: {node.name.name} is not defined in the generated source")
        evaluated = [self._expression(part, scope) for part in (node.args.exprs if node.args else [])]
        cost = sum((part for part, _ in evaluated), _NOTHING)
        result = Value(self.types.of(function.decl.type.type))
        return cost + self._called(function, [value for _, value in evaluated]), result


def _parameters(function: c_ast.FuncDef) -> list[c_ast.Decl]:
    declared = function.decl.type.args
    return [p for p in (declared.params if declared else []) if isinstance(p, c_ast.Decl)]


def _enumerators(node: c_ast.Typedef) -> list[str]:
    """Names of the constants of `typedef enum { ... } name;`; none for another typedef."""
    kind = getattr(node.type, "type", None)
    return [constant.name for constant in kind.values.enumerators] if isinstance(kind, c_ast.Enum) else []


def _moved(place: Value, counts: Counts) -> Counts:
    """Loads or stores (`one` each) of the value at `place`: one per word; none for registers, addresses and arrays."""
    if not place.in_memory or isinstance(place.type, Pointer | Array):
        return _NOTHING
    return counts.times(words(place.type))


def _passes(node: c_ast.For, indices: Mapping[str, int]) -> tuple[str, range]:
    """Index and its values in a loop `for (i = a; i < b; ++i)` or `for (i = a; i < b; i += c)`.

    indices: values of variables that a and b may contain, by name.
    """
    first = node.init.decls[0] if isinstance(node.init, c_ast.DeclList) else node.init
    name, start = (first.name, first.init) if isinstance(first, c_ast.Decl) else (first.lvalue.name, first.rvalue)
    if not isinstance(node.cond, c_ast.BinaryOp) or node.cond.op != "<":
        raise HysgenError(f"{node.coord}: a generated loop runs while its index is below a constant")
    step = constant(node.next.rvalue) if isinstance(node.next, c_ast.Assignment) else 1
    return name, range(constant(start, indices), constant(node.cond.right, indices), step)


def _decides(index: str, body: c_ast.Node) -> bool:
    """Whether the length of a loop in `body` depends on the variable `index`."""
    if isinstance(body, c_ast.For):
        ends = [body.init, body.cond.right]
        if any(_mentions(index, end) for end in ends):
            return True
    return any(_decides(index, child) for _, child in body.children())


def _mentions(index: str, node: c_ast.Node) -> bool:
    if isinstance(node, c_ast.ID) and node.name == index:
        return True
    return any(_mentions(index, child) for _, child in node.children())
