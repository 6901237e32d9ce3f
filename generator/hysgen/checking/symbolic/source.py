"""The parsed text of generated C: functions, types, enumerations and the words of the tables of constants."""

import re
from collections.abc import Mapping

from pycparser import c_ast

from hysgen.checking.symbolic.semantics import to_image
from hysgen.codegen.operations.text import Type, Types, concatenated, parsed
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

    @property
    def public(self) -> list[str]:
        """Names of the functions that a caller of the C may call, without the model's prefix."""
        called = [name for name, node in self.functions.items() if "static" not in node.decl.storage]
        return [name.removeprefix(f"{self.name}_") for name in called]

    def aligned(self, pointer: c_ast.Node) -> bool:
        """Whether a pointer is to the learner, which is aligned to 8 bytes where the kernels are used."""
        names = getattr(getattr(pointer.type, "type", None), "names", [])
        return names == [f"{self.name}_learner_t"]

    def pointers_are_separate(self, function: str) -> bool:
        """Whether the objects behind the pointer parameters of a static function never overlap.

        True if every call passes at most one pointer of the caller's own parameters and, for each other pointer, the
        address of a local variable or a local array of its own.
        """
        node = self.functions[function]
        if "static" not in node.decl.storage:
            return False
        pointers = [isinstance(parameter.type, c_ast.PtrDecl) for parameter in node.decl.type.args.params]
        calls = 0
        for caller in self.functions.values():
            own = {parameter.name for parameter in caller.decl.type.args.params} if caller.decl.type.args else set()
            finder = _Uses(function)
            finder.visit(caller.body)
            if finder.named != len(finder.calls):
                return False  # the address of the function is taken
            calls += len(finder.calls)
            for call in finder.calls:
                passed = [each for each, pointer in zip(call.args.exprs, pointers, strict=True) if pointer]
                objects = [_object(each) for each in passed]
                if None in objects or len(set(objects)) < len(objects):
                    return False
                given = [each for each in passed if isinstance(each, c_ast.ID) and each.name in own]
                local = [each for each in passed if _object(each) in finder.local]
                if len(given) > 1 or len(given) + len(local) != len(passed):
                    return False
        return calls > 0


class _Uses(c_ast.NodeVisitor):  # type: ignore[misc]
    """Calls of a function, the number of times that it is named, and the variables and arrays declared around them."""

    def __init__(self, function: str) -> None:
        self.function = function
        self.calls: list[c_ast.FuncCall] = []
        self.named = 0
        self.local: set[str] = set()

    def visit_FuncCall(self, node: c_ast.FuncCall) -> None:
        if node.name.name == self.function:
            self.calls.append(node)
        self.generic_visit(node)

    def visit_ID(self, node: c_ast.ID) -> None:
        self.named += node.name == self.function

    def visit_Decl(self, node: c_ast.Decl) -> None:
        if not isinstance(node.type, c_ast.PtrDecl):
            self.local.add(node.name)
        self.generic_visit(node)


def _object(argument: c_ast.Node) -> str | None:
    """Name of the variable whose address, or the pointer or array which, is passed."""
    match argument:
        case c_ast.UnaryOp(op="&", expr=c_ast.ID(name=str(name))) | c_ast.ID(name=str(name)):
            return name
    return None


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
