"""Which operations of a graph are equal for every input: by their form, or by a solver where the form differs.

The graph is swept from its inputs to its outputs. An operation whose operands were replaced by their representatives
is the operation of that form that exists already, or a new one. A new one that had the bits of an earlier one in every
drawn sample is handed to the solver (Bitwuzla) together with it; if no input can tell them apart, the earlier one takes
its place, and what stands on both becomes equal by form. Sums and products of floats are free variables to the solver:
it decides selections, comparisons and bits, and equality holds for whatever rounding the processor has.

Comparisons of floats are those of IEEE 754. Source of the method: Kuehlmann, Krohm, Equivalence checking using cuts and
heaps (1997).
"""

from __future__ import annotations

import importlib
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.expressions import negated
from hysgen.checking.symbolic.from_c import Decision
from hysgen.checking.symbolic.semantics import MASK
from hysgen.checking.symbolic.source import KernelRefusalError

Words = NDArray[np.uint32]

SAMPLES: Final = 512
"""Drawn inputs: operations that differ in one of them are not handed to the solver."""
CANDIDATES: Final = 16
"""Earlier operations with the same bits that the solver is asked about."""
SOLVER_MS: Final = 60_000
MOST_ASKED: Final = 3000
"""Pairs that the solver is handed in one sweep; what is left then stays open."""
SOLVER: Final = "bitwuzla"
MOST_SPLIT: Final = 7
"""Operations of a disjunction whose parts, up to four, are cases. A longer one holds or fails as a whole."""


_ONE, _MINUS, _SIGN, _INFINITY = 0x3F80_0000, 0xBF80_0000, 0x8000_0000, 0x7F80_0000


def _sign_of(op: Op) -> bool:
    """Whether a float is 1 or -1, as a condition says: a product with it changes a sign."""
    return op.kind == "select" and {arg.number for arg in op.args[1:] if arg.kind == "const"} == {_ONE, _MINUS}


def _is_negative(op: Op) -> bool:
    """Whether a float is -x: a + -x is a - x."""
    return op.kind == "xor" and op.args[1].kind == "const" and op.args[1].number == _SIGN


def _truth(values: NDArray[np.bool_]) -> Words:
    return values.astype(np.uint32)


def _float(operation: Callable[..., Any]) -> Callable[..., Words]:
    def computed(*words: Words) -> Words:
        with np.errstate(all="ignore"):
            result = np.asarray(operation(*(word.view(np.float32) for word in words)))
        if result.dtype == np.bool_:
            return _truth(result)
        # Which NaN results is the processor's business.
        bits = result.astype(np.float32).view(np.uint32)
        return np.where(np.isnan(result), np.uint32(0x7FC0_0000), bits)

    return computed


_COMPUTED: Final[Mapping[str, Callable[..., Words]]] = {
    "addsp": _float(np.add),
    "subsp": _float(np.subtract),
    "mpysp": _float(np.multiply),
    "cmpeqsp": _float(np.equal),
    "cmpgtsp": _float(np.greater),
    "cmpltsp": _float(np.less),
    "intspu": lambda a: a.astype(np.float32).view(np.uint32),
    "add": np.add,
    "sub": np.subtract,
    "mpy32": np.multiply,
    "and": np.bitwise_and,
    "or": np.bitwise_or,
    "xor": np.bitwise_xor,
    "shl": lambda a, b: np.where(b < 32, a << (b & np.uint32(31)), np.uint32(0)),
    "shru": lambda a, b: np.where(b < 32, a >> (b & np.uint32(31)), np.uint32(0)),
    "cmpeq": lambda a, b: _truth(a == b),
    "cmpgtu": lambda a, b: _truth(a > b),
    "cmpltu": lambda a, b: _truth(a < b),
    "select": lambda c, a, b: np.asarray(np.where(c != 0, a, b), np.uint32),
}
_SOLVED: Final = frozenset(["select", "cmpeq", "cmpgtu", "cmpltu", "cmpeqsp", "cmpgtsp", "cmpltsp", "and", "or", "xor"])
_ANY_ORDER: Final = frozenset(["add", "and", "or", "xor"])
MOST_OPERANDS: Final = 64
_FREE: Final = frozenset(["addsp", "subsp", "mpysp", "intspu", "element", "symbol", "param"])


@dataclass
class Case:
    """A case of two programs. decided: by the id of a representative, its truth; of: representatives in this case."""

    decided: Mapping[int, int]
    of: dict[int, Op] = field(default_factory=dict)


def _atom(condition: Op) -> Op:
    """A truth that a condition depends on: no constant, conjunction, negation or short disjunction."""
    while condition.kind in ("and", "xor", "select", "cmpeq", "or") and condition.args[0].truth:
        if condition.kind == "or" and len(_decided(condition, 0)) > MOST_SPLIT:
            return condition
        condition = condition.args[0]
    return condition


def _decided(atom: Op, truth: int) -> dict[int, int]:
    """The truths that follow from one: where a disjunction fails, every part of it fails."""
    pending, known = [atom], {}
    while pending:
        op = pending.pop()
        known[id(op)] = truth
        pending += op.args if op.kind == "or" and not truth else ()
    return known


@dataclass
class Sweep:
    """Representatives of operations.

    drawn: SAMPLES values of an input, a `symbol` or a `param`. by_cases: whether the programs branch often. asked,
    decided: pairs that the solver was handed, and those that it found equal. side: 0 or 1, which of two programs the
    next operations belong to; within a program only selections are compared, such as limits that never act.
    """

    drawn: Callable[[Op], Words]
    facts: Sequence[Op] = ()
    graph: Graph = field(default_factory=Graph)
    by_cases: bool = False
    side: int = 0
    asked: int = 0
    decided: int = 0
    _of: dict[int, Op] = field(default_factory=dict)
    _merged: dict[int, Op] = field(default_factory=dict)
    _values: dict[int, Words] = field(default_factory=dict)
    _alike: dict[bytes, list[Op]] = field(default_factory=dict)
    _side: dict[int, int] = field(default_factory=dict)
    _held: list[Op] = field(default_factory=list)
    _solver: _Solver | None = None

    def __post_init__(self) -> None:
        self._solver = _Solver.installed()
        if self._solver is not None and self.facts:
            self._solver.know([self.representative(fact) for fact in self.facts])

    def representative(self, op: Op, case: Case | None = None) -> Op:
        """The operation that stands for every operation that is equal to `op`, in a case of the truths in it."""
        pending = [op]
        while pending:
            top = pending[-1]
            missing = [arg for arg in top.args if id(arg) not in self._of]
            if missing:
                pending += missing
                continue
            pending.pop()
            if id(top) not in self._of:
                self._held.append(top)
                self._of[id(top)] = self._placed(self._rebuilt(top, [self._of[id(arg)] for arg in top.args]))
        whole = self._of[id(op)]
        return whole if case is None or not case.decided else self._restricted(whole, case)

    def _restricted(self, op: Op, case: Case) -> Op:
        """A representative with the truths of a case in place of its conditions."""
        pending, known, begun = [op], case.of, set[int]()
        while pending:
            top = pending[-1]
            begun.add(id(top))
            missing = [arg for arg in top.args if id(arg) not in known]
            if id(top) in known:
                pending.pop()
            elif id(top) in case.decided:
                known[id(top)] = self._placed(self.graph.const(case.decided[id(top)]))
            elif missing:
                pending += missing
            else:
                args = [known[id(arg)] for arg in top.args]
                same = all(new is old for new, old in zip(args, top.args, strict=True))
                new = top if same else self._placed(self._rebuilt(top, args))
                if same or id(new) in known or id(new) in begun:
                    known[id(top)] = known.get(id(new), new)
                else:
                    pending.append(new)
        return known[id(op)]

    def pairs(self, programs: Sequence[tuple[Op, Op]], case: Case | None = None) -> list[tuple[Op, Op]]:
        """Representatives of the results of two programs, pair by pair."""
        made = []
        for side in (0, 1):
            self.side = side
            made.append([self.representative(pair[side], case) for pair in programs])
        return list(zip(*made, strict=True))

    def cases(self, decisions: Sequence[Decision], decided: Mapping[int, int] | None = None) -> Iterator[Case]:
        """All cases of the truths on which the decisions of the first program depend."""
        self.side = 0
        case = Case(decided or {})
        for place, decision in enumerate(decisions):
            around = [(self.representative(op, case), side) for op, side in decision.around]
            if any(op.kind == "const" and bool(op.number) != side for op, side in around):
                continue
            condition = self.representative(decision.condition, case)
            if condition.kind != "const":
                atom = _atom(condition)
                for truth in (0, 1):
                    yield from self.cases(decisions[place:], {**case.decided, **_decided(atom, truth)})
                return
        yield case

    def holds(self, case: Case) -> NDArray[np.bool_]:
        """The drawn samples that belong to a case."""
        met = np.ones(SAMPLES, np.bool_)
        for key, truth in case.decided.items():
            met &= self._values[key] == truth
        return met

    def values(self, op: Op) -> Words:
        """The drawn samples of a representative."""
        return self._values[id(op)]

    def _rebuilt(self, op: Op, args: Sequence[Op]) -> Op:
        match op.kind:
            case "const":
                return self.graph.const(op.number)
            case "param":
                return self.graph.param(op.number)
            case "symbol":
                return self.graph.symbol(op.name, op.truth)
            case "select":
                return self.graph.select(*args)
            case "element":
                distance, offset = args[0], op.number
                if distance.kind == "add" and distance.args[1].kind == "const":
                    distance, offset = distance.args[0], offset + distance.args[1].number & MASK
                return self.graph.indexed(args[1:], distance, offset)
            case "addsp" | "subsp" if _is_negative(args[1]):
                return self.graph.op("subsp" if op.kind == "addsp" else "addsp", args[0], args[1].args[0])
            case "sub" if args[1].kind == "const" and not args[1].number:
                return args[0]
            case "mpysp" if any(arg.kind == "const" and arg.number == _ONE for arg in args):
                return args[args[0].kind == "const" and args[0].number == _ONE]  # x 1 is x, a NaN another NaN
            case "mpysp" if any(_sign_of(arg) for arg in args):
                x, side = args if _sign_of(args[1]) else (args[1], args[0])
                flipped = self.graph.op("xor", x, self.graph.const(_SIGN))
                return self.graph.select(
                    side.args[0], *((flipped, x) if side.args[1].number == _MINUS else (x, flipped))
                )
            case "cmpgtu" if args[1].kind == "const" and args[1].number < MASK:
                above = self.graph.const(args[1].number + 1)
                return negated(self.graph, self.graph.op("cmpltu", args[0], above))
            case "cmpltu" if args[0].kind == "const" and args[0].number < MASK:
                above = self.graph.const(args[0].number + 1)
                return negated(self.graph, self.graph.op("cmpltu", args[1], above))
            case "cmpgtu" | "cmpgtsp":
                return self.graph.op(op.kind.replace("gt", "lt"), args[1], args[0])
            case "shl" | "mpy32" if args[1].kind == "const":
                factor = 1 << args[1].number if op.kind == "shl" else args[1].number
                return self._multiple(args[0], factor) if factor <= MASK else self.graph.op(op.kind, *args)
            case kind if kind in _ANY_ORDER:
                return self._in_order(kind, args)
            case kind if kind in _COMPUTED:
                return self.graph.op(kind, *args)
        raise KernelRefusalError(f"{op.kind} is not traced")

    def _multiple(self, op: Op, factor: int) -> Op:
        """A constant multiple of a word; of a sum, the sum of the multiples."""
        if op.kind in ("shl", "mpy32") and op.args[1].kind == "const":
            inner = 1 << op.args[1].number if op.kind == "shl" else op.args[1].number
            return self._multiple(op.args[0], inner * factor & MASK)
        if op.kind == "add":
            return self._in_order("add", [self._multiple(arg, factor) for arg in op.args])
        return self.graph.op("mpy32", op, self.graph.const(factor))

    def _in_order(self, kind: str, args: Sequence[Op]) -> Op:
        """A sum, or another operation whose order and brackets do not matter, in the order of its operands' age."""
        operands: list[Op] = []
        pending = list(args)
        while pending:
            top = pending.pop()
            if top.kind == kind and len(operands) + len(pending) < MOST_OPERANDS:
                pending += top.args
            else:
                operands.append(top)
        operands.sort(key=lambda operand: (operand.kind == "const", operand.order))
        total = operands[0]
        for operand in operands[1:]:
            total = self.graph.op(kind, total, operand)
        return total

    def _placed(self, op: Op) -> Op:
        """The representative of an operation of the sweep's own graph, whose operands may be new, too."""
        pending = [op]
        while pending:
            top = pending[-1]
            missing = [arg for arg in top.args if id(arg) not in self._merged]
            if missing:
                pending += missing
                continue
            pending.pop()
            if id(top) not in self._merged:
                self._merged[id(top)] = self._earlier(top)
        return self._merged[id(op)]

    def _earlier(self, op: Op) -> Op:
        """An operation with the same value for every input that was placed before, or the operation itself."""
        args = [self._merged[id(arg)] for arg in op.args]
        if any(new is not old for new, old in zip(args, op.args, strict=True)):
            return self._placed(self._rebuilt(op, args))
        bits = self._values[id(op)] = self._computed(op)
        alike = self._alike.setdefault(bits.tobytes(), [])
        if self._solver is not None and op.kind in _SOLVED and self.asked < MOST_ASKED and self._worth_asking(op):
            own = set(map(id, _variables(op)))
            candidates = [
                other for other in alike if self._side[id(other)] != self.side or op.kind == other.kind == "select"
            ]
            candidates.sort(key=lambda other: other.kind != op.kind)
            related = (other for other in candidates if _nested(own, set(map(id, _variables(other)))))
            for other in itertools.islice(related, CANDIDATES):
                self.asked += 1
                if self._solver.equal(op, other):
                    self.decided += 1
                    return other
        alike.append(op)
        self._side[id(op)] = self.side
        return op

    def _worth_asking(self, op: Op) -> bool:
        """With cases: whether the samples exercise it. A condition that they never meet is decided by a case."""
        moving = self._values[id(op.args[0] if op.kind == "select" else op)]
        return not self.by_cases or bool(moving.min() < moving.max())

    def _computed(self, op: Op) -> Words:
        inputs = [self._values[id(arg)] for arg in op.args]
        match op.kind:
            case "const":
                return np.full(SAMPLES, op.number, np.uint32)
            case "param" | "symbol":
                return self.drawn(op)
            case "element":
                table = np.stack(inputs[1:])
                place = (inputs[0].astype(np.int64) + op.number) // 4 % len(table)
                return table[place, np.arange(SAMPLES)]
        return np.asarray(_COMPUTED[op.kind](*inputs), np.uint32)


class _Solver:
    """Bitwuzla over 32-bit words; a float operation is a variable."""

    def __init__(self, library: Any) -> None:
        self._b = library
        self._terms: Any = library.TermManager()
        options = library.Options()
        options.set(library.Option.TIME_LIMIT_PER, SOLVER_MS)
        self._solver = library.Bitwuzla(self._terms, options)
        self._word = self._terms.mk_bv_sort(32)
        self._of: dict[int, Any] = {}
        self._facts: dict[int, list[Op]] = {}

    @classmethod
    def installed(cls) -> _Solver | None:
        try:
            return cls(importlib.import_module(SOLVER))
        except ImportError:
            return None

    def know(self, facts: Sequence[Op]) -> None:
        """Use these truths wherever their variables occur, and the order of sums and differences."""
        for fact in facts:
            for op in _variables(fact):
                self._facts.setdefault(id(op), []).append(fact)

    def equal(self, a: Op, b: Op) -> bool:
        """Whether no value of the variables tells a and b apart."""
        zero = self._terms.mk_bv_value(self._word, 0)
        self._solver.push(1)
        if self._facts:
            sums = [op for op in _variables(a, b) if op.kind in ("addsp", "subsp")]
            variables = {id(op): op for op in _variables(a, b, *(arg for op in sums for arg in op.args))}
            for fact in {id(fact): fact for key in variables for fact in self._facts.get(key, ())}.values():
                self._solver.assert_formula(self._is_not(fact, zero))
            for less, more in itertools.product(sums, sums):
                if (less.kind, more.kind) == ("subsp", "addsp") and less.args[0] in more.args:
                    self._solver.assert_formula(self._ordered(less, more))
        self._solver.assert_formula(self._is_not(a, self._term(b)))
        answer = self._solver.check_sat()
        self._solver.pop(1)
        return bool(answer == self._b.Result.UNSAT)

    def _is_not(self, op: Op, other: Any) -> Any:
        return self._terms.mk_term(self._b.Kind.DISTINCT, [self._term(op), other])

    def _ordered(self, less: Op, more: Op) -> Any:
        """a - b <= a + c for finite a, b >= 0 and c >= 0: rounding to nearest keeps the order of the exact results."""
        make, kinds = self._terms.mk_term, self._b.Kind
        added = more.args[1 - more.args.index(less.args[0])]
        low, high, a, b, c = (self._float(self._term(op)) for op in (less, more, *less.args, added))
        infinity, zero = (self._float(self._terms.mk_bv_value(self._word, bits)) for bits in (_INFINITY, 0))
        finite = [make(kinds.FP_LT, [make(kinds.FP_ABS, [term]), infinity]) for term in (a, b, c)]
        holds = make(kinds.AND, [*finite, make(kinds.FP_GEQ, [b, zero]), make(kinds.FP_GEQ, [c, zero])])
        return make(kinds.IMPLIES, [holds, make(kinds.FP_LEQ, [low, high])])

    def _float(self, word: Any) -> Any:
        return self._terms.mk_term(self._b.Kind.FP_TO_FP_FROM_BV, [word], [8, 24])

    def _term(self, op: Op) -> Any:
        pending = [op]
        while pending:
            top = pending[-1]
            missing = [] if top.kind in _FREE else [arg for arg in top.args if id(arg) not in self._of]
            if missing:
                pending += missing
                continue
            pending.pop()
            if id(top) not in self._of:
                self._of[id(top)] = self._made(top)
        return self._of[id(op)]

    def _made(self, op: Op) -> Any:
        make, kinds = self._terms.mk_term, self._b.Kind
        if op.kind == "const":
            return self._terms.mk_bv_value(self._word, op.number & MASK)
        if op.kind in _FREE:
            return self._terms.mk_const(self._word, f"v{len(self._of)}")
        a = [self._of[id(arg)] for arg in op.args]
        match op.kind:
            case "select":
                zero = self._terms.mk_bv_value(self._word, 0)
                return make(kinds.ITE, [make(kinds.DISTINCT, [a[0], zero]), a[1], a[2]])
            case "cmpeqsp" | "cmpgtsp" | "cmpltsp":
                floats = [self._float(self._term(arg)) for arg in op.args]
                name = {"cmpeqsp": kinds.FP_EQUAL, "cmpgtsp": kinds.FP_GT, "cmpltsp": kinds.FP_LT}[op.kind]
                return self._number(make(name, floats))
            case "cmpeq" | "cmpgtu" | "cmpltu":
                name = {"cmpeq": kinds.EQUAL, "cmpgtu": kinds.BV_UGT, "cmpltu": kinds.BV_ULT}[op.kind]
                return self._number(make(name, a))
        name = {
            "add": kinds.BV_ADD,
            "sub": kinds.BV_SUB,
            "mpy32": kinds.BV_MUL,
            "and": kinds.BV_AND,
            "or": kinds.BV_OR,
            "xor": kinds.BV_XOR,
            "shl": kinds.BV_SHL,
            "shru": kinds.BV_SHR,
        }[op.kind]
        return make(name, a)

    def _number(self, truth: Any) -> Any:
        yes, no = (self._terms.mk_bv_value(self._word, number) for number in (1, 0))
        return self._terms.mk_term(self._b.Kind.ITE, [truth, yes, no])


def _nested(some: set[int], others: set[int]) -> bool:
    return some <= others or others <= some


def _variables(*ops: Op) -> list[Op]:
    """The operations that are variables to the solver and that it meets first on the way down from `ops`."""
    seen: dict[int, Op] = {}
    pending = list(ops)
    while pending:
        top = pending.pop()
        if id(top) not in seen:
            seen[id(top)] = top
            pending += () if top.kind in _FREE else top.args
    return [op for op in seen.values() if op.kind in _FREE]
