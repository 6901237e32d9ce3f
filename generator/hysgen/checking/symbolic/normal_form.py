"""Normal forms of operations: what differs in the order of operands, in signs or in shifts becomes the same operation.

Every rule keeps the bits for all operands, a NaN result excepted, which stays a NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.expressions import negated
from hysgen.checking.symbolic.semantics import MASK, from_image
from hysgen.checking.symbolic.source import KernelRefusalError
from hysgen.checking.symbolic.vectors import COMPUTED

MOST_OPERANDS: Final = 64
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
            return graph.op("subsp" if op.kind == "addsp" else "addsp", args[0], args[1].args[0])
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
        total = graph.op(kind, total, operand)
    return total
