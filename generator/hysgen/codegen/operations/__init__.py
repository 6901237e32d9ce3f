"""What a call of a generated function does: operations by kind, counted in the C text itself, and bytes."""

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
    """operations: of the worst path of each public function, by its name without the model's.

    struct_bytes: size of every public struct; constant_bytes: tables of constants, initial banks among them.
    """

    operations: Mapping[str, Counts]
    struct_bytes: Mapping[str, int]
    constant_bytes: int


def figures(name: str, texts: Mapping[str, str]) -> Figures:
    """Count the generated files of model `name`, given by file name.

    Raises HysgenError if they use C that has no fixed cost.
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
