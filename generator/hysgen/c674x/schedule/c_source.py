"""The parsed text of generated C: functions, types, enumerations and the words of the tables of constants."""

from __future__ import annotations

import re
from collections.abc import Mapping

from pycparser import c_ast

from hysgen.c674x.semantics import to_image
from hysgen.codegen.operations.text import concatenated, parsed
from hysgen.codegen.operations.types import Type, Types
from hysgen.errors import TargetError


class KernelRefusalError(TargetError):
    """A C function that cannot become a kernel; the message says why."""


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
                    if isinstance(kind := getattr(node.type, "type", None), c_ast.Enum):
                        self._enumerate(kind)
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
                following = literal(each.value)
            self.constants[each.name] = following
            following += 1


def _table_words(node: c_ast.Node) -> list[int]:
    if isinstance(node, c_ast.InitList):
        return [word for part in node.exprs for word in _table_words(part)]
    return [literal(node)]


def literal(node: c_ast.Node) -> int:
    """The 32 bits of a constant, with its sign."""
    match node:
        case c_ast.UnaryOp(op="-"):
            inner = literal(node.expr)
            floating = isinstance(node.expr, c_ast.Constant) and "float" in node.expr.type
            return inner ^ 0x8000_0000 if floating else -inner & 0xFFFF_FFFF
        case c_ast.Constant():
            if "float" in node.type or "double" in node.type:
                text = node.value.rstrip("fF")
                return to_image(float.fromhex(text) if "0x" in text.lower() else float(text))
            return int(re.sub("[uUlL]+$", "", node.value), 0) & 0xFFFF_FFFF
    raise KernelRefusalError(f"{node.coord}: not a constant")
