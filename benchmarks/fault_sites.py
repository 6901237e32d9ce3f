"""Where a source can be made wrong: Python, C, templates of C. Used by planted_faults.py, whose help lists the ways."""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Iterator, Mapping
from typing import Any, Final

SWAPS: Final[Mapping[str, tuple[str, ...]]] = {
    **{"+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "//": ("/",), "%": ("//",), "**": ("*",)},
    **{"&": ("|",), "|": ("&",), "^": ("&",), "<<": (">>",), ">>": ("<<",)},
    **{"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",)},
    **{"in": ("not in",), "not in": ("in",), "is": ("is not",), "is not": ("is",), "and": ("or",), "or": ("and",)},
}
IN_C: Final[Mapping[str, tuple[str, ...]]] = {**SWAPS, "%": ("/",), "&&": ("||",), "||": ("&&",)}

SYMMETRIC: Final = {"isinstance", "max", "maximum", "min", "minimum", "hypot"}
"""Calls whose arguments are not swapped: with them in the other order, the result is the same or none."""

Site = tuple[int, int, str, str]
"""Begin and end in the text, what takes this place, and the operator."""


# Python


def python_sites(text: str) -> Iterator[Site]:
    """Every change of a Python source; positions count bytes of UTF-8."""
    data = text.encode()
    starts = [0, *(place + 1 for place, byte in enumerate(data) if byte == 10)]

    def begin(node: Any) -> int:
        return starts[node.lineno - 1] + int(node.col_offset)

    def end(node: Any) -> int:
        return starts[node.end_lineno - 1] + int(node.end_col_offset)

    def between(left: int, right: int, kind: str) -> Iterator[Site]:
        """Changes of the operator between two operands."""
        gap = re.sub(rb"#[^\n]*", lambda found: b" " * len(found[0]), data[left:right])
        operator = re.search(rb"(?:not\s+in|is\s+not|\w+|[^\w\s()\\]+)", gap)
        if operator:
            for new in SWAPS.get(" ".join(operator[0].decode().split()), ()):
                yield left + operator.start(), left + operator.end(), new, kind

    def of(node: ast.AST, guarded: bool) -> Iterator[Site]:
        match node:
            case ast.BinOp() if not any(_is_text(side) for side in (node.left, node.right)):
                yield from between(end(node.left), begin(node.right), "binary")
            case ast.AugAssign():
                sign = data.index(b"=", end(node.target))
                operator = data[end(node.target) : sign].decode().strip()
                for new in SWAPS.get(operator, ()):
                    yield sign - len(operator), sign, new, "binary"
                yield begin(node), end(node), "pass", "dropped"
            case ast.Compare():
                sides = [node.left, *node.comparators]
                for left, right in itertools.pairwise(sides):
                    yield from between(end(left), begin(right), "comparison")
            case ast.BoolOp():
                for left, right in itertools.pairwise(node.values):
                    yield from between(end(left), begin(right), "logic")
            case ast.UnaryOp(op=ast.Not()):
                yield begin(node), begin(node.operand), "", "logic"
            case ast.Constant(value=bool()):
                yield begin(node), end(node), str(not node.value), "constant"
            case ast.Constant(value=int()):
                yield begin(node), end(node), str(node.value + 1), "constant"
            case ast.Constant(value=float()):
                yield begin(node), end(node), repr(10.0 * node.value or 1.0), "constant"
            case ast.If():
                for new in ("True", "False"):
                    yield begin(node.test), end(node.test), new, "condition"
            case ast.While() if not (isinstance(node.test, ast.Constant)):
                yield begin(node.test), end(node.test), "False", "condition"
            case ast.Expr(value=ast.Call()) | ast.Raise() | ast.Break() | ast.Continue():
                yield begin(node), end(node), "pass", "dropped"
            case ast.Return() if guarded:
                yield begin(node), end(node), "pass", "dropped"
            case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
                yield begin(node), end(node), "pass", "dropped"
            case ast.Call() if ast.unparse(node.func).rpartition(".")[2] not in SYMMETRIC:
                for left, right in itertools.pairwise(node.args):
                    texts = [data[begin(side) : end(side)].decode() for side in (left, right)]
                    if texts[0] != texts[1] and not any(isinstance(side, ast.Starred) for side in (left, right)):
                        gap = data[end(left) : begin(right)].decode()
                        yield begin(left), end(right), f"{texts[1]}{gap}{texts[0]}", "swapped"

    def walk(node: ast.AST, guarded: bool = False) -> Iterator[Site]:
        if isinstance(node, ast.JoinedStr | ast.Assert) or _guards_the_writer(node):
            return
        yield from of(node, guarded)
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "type_params"):
                continue
            inside = guarded if isinstance(node, ast.With | ast.For | ast.While | ast.Try) else isinstance(node, ast.If)
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from walk(child, inside)

    yield from walk(ast.parse(text))


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str | bytes))


def _guards_the_writer(node: ast.AST) -> bool:
    match node:
        case ast.keyword(arg="strict"):
            return True
        case ast.If(test=ast.Name(id="TYPE_CHECKING")) | ast.Assign(targets=[ast.Name(id="__all__")]):
            return True
        case ast.Assign(value=ast.Subscript(value=ast.Name(id="Literal" | "NDArray" | "Callable"))):
            return True
    return False


# C and templates of C

NOT_CODE: Final = re.compile(
    r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|\{#.*?#\}|\{%.*?%\}|(?P<value>\{\{.*?\}\})"
    r"|^[ \t]*\#(?:[^\n]*\\\n)*[^\n]*",
    re.DOTALL | re.MULTILINE,
)
OPERATOR: Final = re.compile(r"(?<=\s)(<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^<>])(?==?\s)")
NUMBER: Final = re.compile(
    r"(?<![\w.])(0[xX][0-9a-fA-F]+|\d+\.\d*(?:[eE][-+]?\d+)?|\d+(?:[eE][-+]?\d+)?)([uUlLfF]*)(?![\w.])"
)
PLACE: Final = r"[ \t]+\*?[A-Za-z_][\w.]*(?:->[\w.]+|\[[^\]\n]*\][\w.]*)*"
STATEMENT: Final = re.compile(
    rf"^(?:{PLACE} (?:[-+*/%&|^]|<<|>>)?= [^;{{}}]*;|[ \t]+[A-Za-z_]\w*\([^;{{}}]*\);|[ \t]{{8,}}return\b[^;{{}}]*;"
    r"|[ \t]+continue;)[ \t]*$",
    re.MULTILINE,
)
CONDITION: Final = re.compile(r"\bif \((.*)\) \{[ \t]*$", re.MULTILINE)
CALL: Final = re.compile(r"\w\(")


def c_sites(text: str) -> Iterator[Site]:
    """Every change of a C source or of a template of one."""

    def blank(found: re.Match[str]) -> str:
        # A value of Jinja may be an operand; nothing else that is not code is changed.
        return re.sub(r"[^\n]", "J" if found["value"] else " ", found[0])

    code = NOT_CODE.sub(blank, text)
    for found in OPERATOR.finditer(code):
        operator = found[1]
        if code[found.end()] == "=" and operator in ("<", ">", "=", "!"):
            continue
        kind = "comparison" if operator[0] in "<>=!" and operator not in ("<<", ">>") else "binary"
        for new in IN_C.get(operator, ()):
            yield *found.span(1), new, "logic" if operator in ("&&", "||") else kind
    for found in re.finditer(r"(?<![\w!])!(?=[\w(])", code):
        yield *found.span(), "", "logic"
    for found in NUMBER.finditer(code):
        number, suffix = found.groups()
        if number[:2].lower() == "0x":
            new = hex(int(number, 16) + 1)
        elif re.search(r"[.eE]", number):
            new = repr(10.0 * float(number) or 1.0)
        else:
            new = str(int(number) + 1)
        yield *found.span(), new + suffix, "constant"
    for found in CONDITION.finditer(code):
        for new in ("1", "0"):
            yield *found.span(1), new, "condition"
    for found in STATEMENT.finditer(code):
        begin = found.start() + len(found[0]) - len(found[0].lstrip())
        if text[begin : found.end()].strip():
            yield begin, found.end(), ";", "dropped"
    for found in CALL.finditer(code):
        if code[code.rfind("\n", 0, found.start()) + 1].isspace():
            yield from _swaps_in_c(text, code, found.end())


def _swaps_in_c(text: str, code: str, begin: int) -> Iterator[Site]:
    """Swaps of the arguments that begin behind a bracket."""
    depth, spans = 0, [begin]
    for place in range(begin, min(begin + 400, len(code))):
        character = code[place]
        if character in ";{}" or (character in ")]" and depth == 0):
            spans.append(place)
            break
        depth += (character in "([") - (character in ")]")
        if character == "," and depth == 0:
            spans.append(place)
    else:
        return
    for first, second in itertools.pairwise(itertools.pairwise(spans)):
        a, b = text[slice(*first)].lstrip(", \n"), text[slice(*second)].lstrip(", \n")
        if a != b and a.strip() and b.strip():
            yield first[1] - len(a), second[1], f"{b}, {a}", "swapped"
