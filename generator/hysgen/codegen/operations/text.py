"""Syntax tree of generated C, with a preprocessor for the directives that generated C uses, and its types.

Code within include guards is kept, and code under `#ifdef` of a known macro. Of `#if` the `#else` branch is kept, which
is the portable one. Macros without parameters are replaced by their definitions.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from pycparser import CParser, c_ast

from hysgen.errors import HysgenError

_PRELUDE = "typedef unsigned int uint32_t; typedef int int32_t; typedef unsigned long long uint64_t;\n"
_DIRECTIVE = re.compile(r"\s*#\s*(\w+)\s*(.*)")
_DEFINE = re.compile(r"(\w+)(\(\))?\s*(.*)")


def concatenated(texts: Mapping[str, str], names: tuple[str, ...], defined: tuple[str, ...] = ()) -> str:
    """The preprocessed text of the files `names`; the macros of a file are defined in the files after it.

    defined: macros without a value that are defined in every file.
    """
    macros: dict[str, str] = {"UINT32_MAX": "4294967295u", **dict.fromkeys(defined, "")}
    return "".join(preprocessed(texts[name], macros) for name in names)


def parsed(text: str, name: str) -> c_ast.FileAST:
    """The syntax tree of a preprocessed text."""
    return CParser().parse(_PRELUDE + text, filename=name)


def preprocessed(text: str, macros: dict[str, str]) -> str:
    """`text` without comments and directives, macros replaced; adds the macros that `text` defines to `macros`."""
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL).replace("\\\n", " ")
    lines_of_code: list[str] = []
    open_branches: list[bool] = []
    for line in text.splitlines():
        directive = _DIRECTIVE.fullmatch(line)
        if directive is None:
            if all(open_branches):
                lines_of_code.append(_replaced(line, macros))
            continue
        word, rest = directive[1], directive[2].strip()
        if word in ("if", "ifdef", "ifndef"):
            open_branches.append((rest in macros) == (word == "ifdef") and word != "if")
        elif word in ("elif", "else"):
            open_branches[-1] = word == "else" and not open_branches[-1]
        elif word == "endif":
            open_branches.pop()
        elif word == "define" and all(open_branches):
            _define(rest, macros)
        elif word not in ("include", "error", "pragma", "define", "undef"):
            raise HysgenError(f"#{word}: generated C does not use this directive; only generated files can be counted")
    return "\n".join(lines_of_code) + "\n"


def _define(rest: str, macros: dict[str, str]) -> None:
    parts = _DEFINE.fullmatch(rest)
    if parts is None:
        raise HysgenError(f"#define {rest}: generated C does not use macros with parameters")
    name, call, value = parts[1], parts[2] or "", parts[3].strip()
    macros[name + call] = _replaced(value, macros)


def _replaced(line: str, macros: Mapping[str, str]) -> str:
    def replacement(match: re.Match[str]) -> str:
        return macros.get(match[0], macros.get(match[1], match[1]) + match[2])

    return re.sub(r"\b([A-Za-z_]\w*)\b((?:\(\))?)", replacement, line)


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
