"""Whether any input tells two operations of a graph apart: Bitwuzla over 32-bit words, floats of free rounding.

Sums and products of floats are free variables to the solver: it decides selections, comparisons and bits, and equality
holds for whatever rounding the processor has. Comparisons of floats are those of IEEE 754.

Normal forms of operations: what differs in the order of operands, in signs or in shifts becomes the same operation.

Every rule keeps the bits for all operands, a NaN result excepted, which stays a NaN.
"""

from __future__ import annotations

import functools
import importlib
import itertools
import time
from collections.abc import Sequence
from typing import Any, Final

from hysgen.checking.symbolic.arrays import COMPUTED
from hysgen.checking.symbolic.dataflow import Graph, Op, bottom_up
from hysgen.checking.symbolic.expressions import negated
from hysgen.checking.symbolic.memory import WORD
from hysgen.checking.symbolic.semantics import MASK, from_image
from hysgen.checking.symbolic.source import KernelRefusalError

MOST_OPERANDS: Final = 64
MOST_OPENED: Final = 40
"""Operands of an element of an array that is opened to the choice of a word, where it is compared with one."""
_ANY_ORDER: Final = frozenset(["add", "and", "or", "xor"])
_ONE, _MINUS, _SIGN = 0x3F80_0000, 0xBF80_0000, 0x8000_0000


def _sign_of(op: Op) -> bool:
    """Whether a float is 1 or -1, as a condition says: a product with it changes a sign."""
    return op.kind == "select" and {arg.number for arg in op.args[1:] if arg.kind == "const"} == {_ONE, _MINUS}


def _is_negative(op: Op) -> bool:
    """Whether a float is -x: a + -x is a - x."""
    return op.kind == "xor" and op.args[1].kind == "const" and op.args[1].number == _SIGN


def _is_clamp(below: Op, low: Op, rest: Op) -> bool:
    """Whether x is limited to constants low <= high from below first: from above first, it is the same number."""
    if (below.kind, rest.kind) != ("cmpltsp", "select") or rest.args[0].kind != "cmpltsp":
        return False
    (above, high, x), ends = rest.args, (low, rest.args[1])
    return (
        below.args == (x, low)
        and above.args == (high, x)
        and all(end.kind == "const" for end in ends)
        and from_image(low.number) <= from_image(high.number)
    )


def rebuilt(graph: Graph, op: Op, args: Sequence[Op]) -> Op:
    """The operation of the kind of `op` with these operands, in its normal form. Raises KernelRefusalError."""
    match op.kind:
        case "const":
            return graph.const(op.number)
        case "param":
            return graph.param(op.number)
        case "symbol":
            return graph.symbol(op.name, op.truth)
        case "select" if _is_clamp(*args):
            (below, low, above), x = (*args[:2], args[2].args[0]), args[2].args[2]
            return graph.select(above, args[2].args[1], graph.select(below, low, x))
        case "select":
            return graph.select(*args)
        case "element":
            distance, offset = args[0], op.number
            if distance.kind == "add" and distance.args[1].kind == "const":
                distance, offset = distance.args[0], offset + distance.args[1].number & MASK
            return graph.indexed(args[1:], distance, offset)
        case "addsp" | "subsp" if _is_negative(args[1]):
            negative = args[0], args[1].args[0]
            return graph.op("subsp", *negative) if op.kind == "addsp" else graph.op("addsp", *_by_age(negative))
        case "sub" if args[1].kind == "const" and not args[1].number:
            return args[0]
        case "mpysp" if any(arg.kind == "const" and arg.number == _ONE for arg in args):
            return args[args[0].kind == "const" and args[0].number == _ONE]  # x 1 is x, a NaN another NaN
        case "mpysp" if any(_sign_of(arg) for arg in args):
            x, side = args if _sign_of(args[1]) else (args[1], args[0])
            flipped = graph.op("xor", x, graph.const(_SIGN))
            return graph.select(side.args[0], *((flipped, x) if side.args[1].number == _MINUS else (x, flipped)))
        case "cmpgtu" if args[1].kind == "const" and args[1].number < MASK:
            above = graph.const(args[1].number + 1)
            return negated(graph, graph.op("cmpltu", args[0], above))
        case "cmpltu" if args[0].kind == "const" and args[0].number < MASK:
            above = graph.const(args[0].number + 1)
            return negated(graph, graph.op("cmpltu", args[1], above))
        case "cmpgtu" | "cmpgtsp":
            return graph.op(op.kind.replace("gt", "lt"), args[1], args[0])
        case "shl" | "mpy32" if args[1].kind == "const":
            factor = 1 << args[1].number if op.kind == "shl" else args[1].number
            return _multiple(graph, args[0], factor) if factor <= MASK else graph.op(op.kind, *args)
        case kind if kind in _ANY_ORDER:
            return _in_order(graph, kind, args)
        case "addsp" | "mpysp" | "cmpeqsp":
            return graph.op(op.kind, *_by_age(args))
        case kind if kind in COMPUTED:
            return graph.op(kind, *args)
    raise KernelRefusalError(f"{op.kind} is not traced")


def _multiple(graph: Graph, op: Op, factor: int) -> Op:
    """A constant multiple of a word; of a sum, the sum of the multiples."""
    if op.kind in ("shl", "mpy32") and op.args[1].kind == "const":
        inner = 1 << op.args[1].number if op.kind == "shl" else op.args[1].number
        return _multiple(graph, op.args[0], inner * factor & MASK)
    if op.kind == "add":
        return _in_order(graph, "add", [_multiple(graph, arg, factor) for arg in op.args])
    return graph.op("mpy32", op, graph.const(factor))


def _in_order(graph: Graph, kind: str, args: Sequence[Op]) -> Op:
    """A sum, or another operation whose order and brackets do not matter, by age of its operands; x | x is x."""
    operands: list[Op] = []
    pending = list(args)
    while pending:
        top = pending.pop()
        if top.kind == kind and len(operands) + len(pending) < MOST_OPERANDS:
            pending += top.args
        elif kind not in ("and", "or") or all(top is not operand for operand in operands):
            operands.append(top)
    first, *others = _by_age(operands)
    return functools.reduce(lambda total, operand: graph.op(kind, total, operand), others, first)


def _by_age(operands: Sequence[Op]) -> list[Op]:
    """Operands whose order does not matter, constants last."""
    return sorted(operands, key=lambda operand: (operand.kind == "const", operand.order))


SOLVER: Final = "bitwuzla"
SOLVER_MS: Final = 60_000
_INFINITY: Final = 0x7F80_0000
_FREE: Final = frozenset(["addsp", "subsp", "mpysp", "intspu", "element", "symbol", "param"])


class Solver:
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
    def installed(cls) -> Solver | None:
        try:
            return cls(importlib.import_module(SOLVER))
        except ImportError:
            return None

    def know(self, facts: Sequence[Op]) -> None:
        """Use these truths wherever their variables occur, and the order of sums and differences."""
        for fact in facts:
            for op in variables(fact):
                self._facts.setdefault(id(op), []).append(fact)

    def equal(self, a: Op, b: Op) -> bool:
        """Whether no value of the variables tells a and b apart."""
        zero = self._terms.mk_bv_value(self._word, 0)
        self._solver.push(1)
        if self._facts:
            sums = [op for op in variables(a, b) if op.kind in ("addsp", "subsp")]
            met = variables(a, b, *(arg for op in sums for arg in op.args))
            for fact in {id(fact): fact for op in met for fact in self._facts.get(id(op), ())}.values():
                self._solver.assert_formula(self._is_not(fact, zero))
            for less, more in itertools.product(sums, sums):
                if (less.kind, more.kind) == ("subsp", "addsp") and less.args[0] in more.args:
                    self._solver.assert_formula(self._ordered(less, more))
        self._solver.assert_formula(self._terms.mk_term(self._b.Kind.DISTINCT, [self._opened(a), self._opened(b)]))
        begun = time.process_time()
        answer = self._solver.check_sat()
        # Bitwuzla's limit is of the clock: on a busy machine it is asked again until it has had as much of a processor.
        while answer == self._b.Result.UNKNOWN and time.process_time() - begun < 0.9e-3 * SOLVER_MS:
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

    def _opened(self, op: Op) -> Any:
        """The term of an operation; of an element of a short array, what it chooses."""
        if not _opens(op):
            return self._term(op)
        distance, *words = op.args
        chosen = self._term(words[-1])
        for k, word in enumerate(words[:-1]):
            at = self._terms.mk_bv_value(self._word, WORD * k - op.number & MASK)
            here = self._terms.mk_term(self._b.Kind.EQUAL, [self._term(distance), at])
            chosen = self._terms.mk_term(self._b.Kind.ITE, [here, self._term(word), chosen])
        return chosen

    def _term(self, op: Op) -> Any:
        return bottom_up(op, self._of, self._made, leaves=_FREE)

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


def _opens(op: Op) -> bool:
    return op.kind == "element" and len(op.args) <= MOST_OPENED


def variables(*ops: Op) -> list[Op]:
    """The operations that are variables to the solver and that it meets first on the way down from `ops`."""
    seen: dict[int, Op] = {}
    pending = [arg for op in ops for arg in (op.args if _opens(op) else (op,))]
    while pending:
        top = pending.pop()
        if id(top) not in seen:
            seen[id(top)] = top
            pending += () if top.kind in _FREE else top.args
    return [op for op in seen.values() if op.kind in _FREE]
