"""Cost of the generated functions: operations per call by kind, counted in the C text, and bytes of memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pycparser import c_ast

from hysgen.codegen.operations.counting import Program
from hysgen.codegen.operations.counts import Counts
from hysgen.codegen.operations.text import syntax_tree
from hysgen.codegen.operations.types import Types, words

__all__ = ["Counts", "Figures", "figures"]

_BYTES = 4


@dataclass(frozen=True)
class Figures:
    """Operations and bytes of one model's C code.

    operations: counts of the most expensive path, by public function, named without the model's prefix.
    struct_bytes: size by public struct; constant_bytes: size of all tables of constants, initial banks included.
    """

    operations: Mapping[str, Counts]
    struct_bytes: Mapping[str, int]
    constant_bytes: int


def figures(name: str, texts: Mapping[str, str]) -> Figures:
    """The figures of model `name` with the generated `texts` by file name.

    Raises HysgenError if the C code contains a statement without a fixed cost.
    """
    program = Program(syntax_tree(texts, (f"{name}.h", f"{name}_params.h", f"{name}.c")))
    header = Types()
    for node in syntax_tree(texts, (f"{name}.h",)).ext:
        if isinstance(node, c_ast.Typedef):
            header.define(node)
    return Figures(
        operations={function.removeprefix(f"{name}_"): program.count(function) for function in program.public()},
        struct_bytes={struct: _BYTES * words(program.types[struct]) for struct in header.structs},
        constant_bytes=_BYTES * program.constant_words,
    )
