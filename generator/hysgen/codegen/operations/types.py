"""C types of generated code: scalars, pointers, arrays, structs, and their sizes in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from pycparser import c_ast

from hysgen.errors import HysgenError


@dataclass(frozen=True)
class Scalar:
    """float, an integer type, or void."""

    floating: bool


@dataclass(frozen=True)
class Pointer:
    to: Type


@dataclass(frozen=True)
class Array:
    of: Type
    length: int


@dataclass(frozen=True)
class StructType:
    """Types of the members by name, in order of declaration; also a union, whose size is not used."""

    members: Mapping[str, Type]


Type: TypeAlias = Scalar | Pointer | Array | StructType

FLOAT = Scalar(True)
INTEGER = Scalar(False)


class Types:
    """The typedefs of a translation unit."""

    def __init__(self) -> None:
        self._named: dict[str, Type] = {}

    def define(self, node: c_ast.Typedef) -> None:
        """Add the typedef `node`; a typedef of an array is a static assertion and declares nothing."""
        if isinstance(node.type, c_ast.ArrayDecl):
            return
        self._named[node.name] = self.of(node.type)

    @property
    def structs(self) -> list[str]:
        """Names of the structs, in the order of their definition."""
        return [name for name, kind in self._named.items() if isinstance(kind, StructType)]

    def __getitem__(self, name: str) -> Type:
        return self._named[name]

    def of(self, node: c_ast.Node) -> Type:
        """The type of the type node of a declaration. Raises HysgenError for a type that generated C does not use."""
        match node:
            case c_ast.TypeDecl() | c_ast.Typename():
                return self.of(node.type)
            case c_ast.PtrDecl():
                return Pointer(self.of(node.type))
            case c_ast.ArrayDecl():
                return Array(self.of(node.type), constant(node.dim))
            case c_ast.Struct() | c_ast.Union():
                return StructType({member.name: self.of(member.type) for member in node.decls or []})
            case c_ast.Enum():
                return INTEGER
            case c_ast.IdentifierType():
                name = node.names[-1]
                return self._named[name] if name in self._named else Scalar(name == "float")
        raise HysgenError(f"{type(node).__name__} at {node.coord}: not a type that generated C uses")


def words(kind: Type) -> int:
    """32-bit words of a value of this type; every scalar and pointer of the target has 32 bits."""
    match kind:
        case Array():
            return kind.length * words(kind.of)
        case StructType():
            return sum(words(member) for member in kind.members.values())
    return 1


def constant(node: c_ast.Node, known: Mapping[str, int] | None = None) -> int:
    """The value of an integer expression of constants and the variables in `known`, by name.

    Raises HysgenError for any other expression.
    """
    match node:
        case c_ast.Constant():
            return int(node.value.rstrip("uUlL"), 0)
        case c_ast.ID() if known and node.name in known:
            return known[node.name]
        case c_ast.BinaryOp(op="+"):
            return constant(node.left, known) + constant(node.right, known)
        case c_ast.BinaryOp(op="-"):
            return constant(node.left, known) - constant(node.right, known)
        case c_ast.BinaryOp(op="*"):
            return constant(node.left, known) * constant(node.right, known)
        case c_ast.Cast():
            return constant(node.expr, known)
    raise HysgenError(f"{node.coord}: not an integer constant; generated loops and arrays have constant sizes")
