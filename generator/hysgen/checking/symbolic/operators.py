"""The operators of C as operations of a dataflow graph: float32 and uint32_t arithmetic, comparisons, logic."""

from __future__ import annotations

from typing import Final

from pycparser import c_ast

from hysgen.checking.symbolic.dataflow import Graph, Op
from hysgen.checking.symbolic.source import KernelRefusalError

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
