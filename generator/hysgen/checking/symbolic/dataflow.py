"""Dataflow graph of a straight-line kernel: operations on 32-bit words in single-assignment form.

Every operation fixes its operands, so the graph fixes the order of all float32 roundings; a schedule can change only
the time of an operation. Float32 numbers are their bit patterns. Equal operations are one node, and operations with
constant operands are evaluated.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeVar

from hysgen.checking.symbolic.semantics import FLOAT, INTEGER, MASK, FloatUnit

COMPARISONS: Final = frozenset(["cmpeq", "cmpgtu", "cmpltu", "cmpeqsp", "cmpgtsp", "cmpltsp"])
COMMUTATIVE: Final = frozenset(["addsp", "mpysp", "add", "and", "or", "xor", "mpy32", "cmpeq", "cmpeqsp"])
_AT_ONCE: Final = frozenset(["and", "or", "xor", "select", "cmpeq"])


@dataclass(frozen=True, eq=False)
class Op:
    """One value, or one store.

    kind: `const`, `param`, `symbol` (address of a table), `load`, `store`, `select` (condition, if true, if false), or
    a mnemonic of `semantics`. number: the constant, the index of the parameter, or the byte offset of a load or store,
    whose first operand is the address. after: loads and stores that must be issued in an earlier packet; beside: loads
    that must not be issued in a later packet.
    """

    kind: str
    args: tuple[Op, ...] = ()
    number: int = 0
    name: str = ""
    order: int = 0
    after: tuple[Op, ...] = ()
    beside: tuple[Op, ...] = ()

    @property
    def truth(self) -> bool:
        """Whether the value is 0 or 1."""
        match self.kind:
            case "const":
                return self.number in (0, 1)
            case "symbol":
                return self.number == 1
            case "and":
                return any(arg.truth for arg in self.args)
            case "or" | "xor":
                return all(arg.truth for arg in self.args)
            case "select":
                return all(arg.truth for arg in self.args[1:])
        return self.kind in COMPARISONS


T = TypeVar("T")


def bottom_up(op: Op, known: dict[int, T], made: Callable[[Op], T], leaves: Container[str] = ()) -> T:
    """known[id(op)], made for every operation that `op` needs, its operands first; those of kinds `leaves` need none.

    Without recursion: an expression may be deeper than Python's stack.
    """
    pending = [op]
    while pending:
        top = pending[-1]
        missing = [] if top.kind in leaves else [arg for arg in top.args if id(arg) not in known]
        if missing:
            pending += missing
            continue
        pending.pop()
        if id(top) not in known:
            known[id(top)] = made(top)
    return known[id(op)]


@dataclass(frozen=True)
class Kernel:
    """A function without branches: its stores, and its result or None.

    tables: words of the constant tables whose address is used, by symbol. aligned: parameters that are addresses of
    multiples of 8.
    """

    name: str
    parameters: int
    stores: tuple[Op, ...]
    result: Op | None
    tables: Mapping[str, tuple[int, ...]]
    aligned: frozenset[int] = frozenset()

    def operations(self) -> list[Op]:
        """All operations that the stores and the result need, in the order of the C text.

        A store, a choice or a logical operation stands behind its last operand.
        """
        found: dict[int, Op] = {}
        pending = [*self.stores, *([self.result] if self.result else [])]
        while pending:
            op = pending.pop()
            if id(op) not in found:
                found[id(op)] = op
                pending += [*op.args, *op.after]
        late = {id(op): 0.0 for op in found.values()}
        for op in sorted(found.values(), key=lambda each: each.order):
            late[id(op)] = float(op.order)
            if op.kind in _AT_ONCE and not all(arg.kind == "const" for arg in op.args):
                late[id(op)] = max(late[id(arg)] for arg in op.args if arg.kind != "const") + 1e-4
            if op.kind == "store":
                behind = (*op.args, *op.after, *(each for each in op.beside if id(each) in found))
                late[id(op)] = max(late[id(each)] for each in behind) + 0.5
        return sorted(found.values(), key=lambda op: (late[id(op)], op.order))


@dataclass
class Graph:
    """Builder of operations: folds constants, and returns the same node for the same operation.

    compared: of each largest value, by its id, the values of which it is the largest.
    """

    nodes: dict[tuple[object, ...], Op] = field(default_factory=dict)
    count: int = 0
    compared: dict[int, tuple[Op, ...]] = field(default_factory=dict)

    def _node(
        self,
        kind: str,
        args: tuple[Op, ...] = (),
        number: int = 0,
        name: str = "",
        after: tuple[Op, ...] = (),
        beside: tuple[Op, ...] = (),
    ) -> Op:
        key = (kind, tuple(map(id, args)), number, name, tuple(map(id, after)))
        found = self.nodes.get(key)
        if found is None:
            self.count += 1
            found = self.nodes[key] = Op(kind, args, number, name, self.count, after, beside)
        return found

    def const(self, number: int) -> Op:
        """The constant with these 32 bits."""
        return self._node("const", number=number & MASK)

    def param(self, index: int) -> Op:
        """The parameter `index` of the function, a word."""
        return self._node("param", number=index)

    def symbol(self, name: str, truth: bool = False) -> Op:
        """The address of a table of constants, or an unknown word; truth: one that is 0 or 1."""
        return self._node("symbol", number=int(truth), name=name)

    def load(self, address: Op, offset: int, after: Sequence[Op] = ()) -> Op:
        """The word at address + offset; `after`: earlier stores to the same place."""
        return self._node("load", (address,), offset, after=tuple(after))

    def indexed(self, words: Sequence[Op], distance: Op, offset: int) -> Op:
        """The word at byte offset + distance of an array of words (`indexed.element`)."""
        return self._node("element", (distance, *words), offset)

    def store(self, address: Op, offset: int, value: Op, after: Sequence[Op] = (), beside: Sequence[Op] = ()) -> Op:
        """The store of a word; it is never shared."""
        self.count += 1
        return Op("store", (address, value), offset, "", self.count, tuple(after), tuple(beside))

    def select(self, condition: Op, yes: Op, no: Op) -> Op:
        """`yes` if the condition is not 0, else `no`."""
        if condition.kind == "const":
            return yes if condition.number else no
        if yes is no or (condition.kind == "cmpeq" and condition.args == (no, yes)):
            return no
        if condition.kind == "xor" and condition.truth and condition.args[1].kind == "const":
            return self.select(condition.args[0], no, yes)
        if condition.kind == "cmpeq" and _is(condition.args[1], 0):
            return self.select(condition.args[0], no, yes)
        if condition.truth and yes.truth and yes.kind == "const" and no.kind == "const" and no.truth:
            return condition if yes.number else self.op("xor", condition, self.const(1))
        if condition.truth and yes.truth and no.truth:
            if _is(no, 0):
                return self.op("and", condition, yes)
            if _is(yes, 1):
                return self.op("or", condition, no)
        if condition.kind == "cmpgtu" and condition.args == (yes, no):
            return self._largest(yes, no)
        if no.kind == "select" and no.args[0] is condition:
            no = no.args[2]
        if yes.kind == "select" and yes.args[0] is condition:
            yes = yes.args[1]
        if yes.kind == "select" and yes.args[2] is no and condition.truth and yes.args[0].truth:
            return self.select(self.op("and", condition, yes.args[0]), yes.args[1], no)
        if yes.kind == "select" and yes.args[1] is no and condition.truth:
            fails = self.op("cmpeq", yes.args[0], self.const(0))
            return self.select(self.op("and", condition, fails), yes.args[2], no)
        return self._node("select", (condition, yes, no))

    def _largest(self, one: Op, other: Op) -> Op:
        """The larger one of two unsigned words; of many, by pairs, then pairs of pairs: a short chain of latencies."""
        values = (*self.compared.get(id(other), (other,)), *self.compared.get(id(one), (one,)))
        values = tuple(each for each in values if not _is(each, 0))
        left = list(values)
        while len(left) > 1:
            pairs = [left[k : k + 2] for k in range(0, len(left), 2)]
            left = [
                self._node("select", (self._node("cmpgtu", (pair[1], pair[0])), pair[1], pair[0]))
                if len(pair) == 2
                else pair[0]
                for pair in pairs
            ]
        self.compared[id(left[0])] = values
        return left[0]

    def op(self, kind: str, *args: Op) -> Op:
        """An operation of `semantics`, simplified where the bits stay the same for all operands."""
        if all(arg.kind == "const" for arg in args):
            return self.const(_computed(kind, [arg.number for arg in args]))
        if kind in COMMUTATIVE and args[0].kind == "const":
            args = (args[1], args[0])
        simpler = _RULES[kind](self, *args) if kind in _RULES else None
        return self._node(kind, tuple(args)) if simpler is None else simpler


def _computed(kind: str, images: Sequence[int]) -> int:
    return INTEGER[kind](*images) if kind in INTEGER else FLOAT[kind](FloatUnit(), *images)


def _is(op: Op, number: int) -> bool:
    return op.kind == "const" and op.number == number & MASK


def _mask_of(op: Op) -> Op | None:
    """The condition of a mask, all ones if it holds and else 0."""
    if op.kind == "sub" and _is(op.args[0], 0) and op.args[1].truth:
        return op.args[1]
    return None


def _and(graph: Graph, a: Op, b: Op) -> Op | None:
    zero = graph.const(0)
    if _is(b, 0) or _is(b, -1):
        return zero if _is(b, 0) else a
    if _is(b, 1) and a.truth:
        return a
    for mask, other in ((a, b), (b, a)):
        condition = _mask_of(mask)
        if condition is not None:
            return graph.select(condition, other, zero)
        if mask.kind == "xor" and _is(mask.args[1], -1):
            refused = _mask_of(mask.args[0])
            if refused is not None:
                return graph.select(refused, zero, other)
    return None


def _or(graph: Graph, a: Op, b: Op) -> Op | None:
    """Masks in a sum of products become choices: (q -> y else 0) | (p -> 0 else x) with q implying p."""
    if _is(b, 0):
        return a
    masks = [_mask_of(each) for each in (a, b)]
    if masks[0] is not None and masks[1] is not None:
        return graph.op("sub", graph.const(0), graph.op("or", masks[0], masks[1]))
    for left, right in ((a, b), (b, a)):
        if right.kind == "select" and _is(right.args[2], 0) and left.kind == "select":
            q, y, _ = right.args
            if _is(left.args[1], 0) and _implies(q, left.args[0]):
                return graph.select(q, y, left)
            # left is q' -> y' else (p -> 0 else x), and q implies p but excludes q'
            inner = left.args[2]
            if inner.kind != "select" or not _is(inner.args[1], 0) or not _implies(q, inner.args[0]):
                continue
            if _excludes(q, left.args[0]):
                other, z, _ = left.args
                whole = inner.args[0].kind == "or" and set(inner.args[0].args) == {q, other}
                return graph.select(q, y, graph.select(other, z, inner.args[2]) if whole else left)
    return None


def _implies(q: Op, p: Op) -> bool:
    return q is p or (p.kind == "or" and any(_implies(q, arg) for arg in p.args))


def _excludes(a: Op, b: Op) -> bool:
    """Whether a and b are x < low and x > high with constants low <= high."""
    pair = {a.kind: a, b.kind: b}
    if set(pair) != {"cmpltsp", "cmpgtsp"}:
        return False
    (x, low), (z, high) = pair["cmpltsp"].args, pair["cmpgtsp"].args
    if x is not z or low.kind != "const" or high.kind != "const":
        return False
    unit = FloatUnit()
    return unit.read(low.number) <= unit.read(high.number)


def _xor(graph: Graph, a: Op, b: Op) -> Op | None:
    if _is(b, 0):
        return a
    if b.kind == "const" and a.kind == "xor" and a.args[1].kind == "const":
        return graph.op("xor", a.args[0], graph.const(b.number ^ a.args[1].number))
    for x, chosen in ((a, b), (b, a)):  # x ^ (c ? x ^ z : 0) is c ? z : x
        if chosen.kind == "select" and _is(chosen.args[2], 0) and chosen.args[1].kind == "xor":
            pair = chosen.args[1].args
            if x in pair:
                return graph.select(chosen.args[0], pair[0] if pair[1] is x else pair[1], x)
    return None


def _add(graph: Graph, a: Op, b: Op) -> Op | None:
    if _is(b, 0):
        return a
    if b.kind == "const" and a.kind == "add" and a.args[1].kind == "const":
        return graph.op("add", a.args[0], graph.const(a.args[1].number + b.number))
    return None


def _cmpeq(graph: Graph, a: Op, b: Op) -> Op | None:
    return graph.op("xor", a, graph.const(1)) if a.truth and _is(b, 0) else None


def _mpy32(graph: Graph, a: Op, b: Op) -> Op | None:
    if b.kind == "const" and b.number & (b.number - 1) == 0:
        return graph.op("shl", a, graph.const(b.number.bit_length() - 1)) if b.number else b
    return None


def _shift(graph: Graph, a: Op, b: Op) -> Op | None:
    return a if _is(b, 0) else None


_RULES: Final[Mapping[str, Callable[..., Op | None]]] = {
    "and": _and,
    "or": _or,
    "xor": _xor,
    "add": _add,
    "mpy32": _mpy32,
    "cmpeq": _cmpeq,
    "shl": _shift,
    "shru": _shift,
}
