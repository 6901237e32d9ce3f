"""Cost of the generated functions: operations per call by kind, counted in the C text, and bytes of memory."""

from collections.abc import Mapping
from dataclasses import dataclass

from pycparser import c_ast

from hysgen.codegen.operations.counting import Counts, Program
from hysgen.codegen.operations.text import Types, concatenated, parsed, words
from hysgen.machine.cache import LruCache

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


_CACHE: LruCache[Figures] = LruCache(16)


def figures(name: str, texts: Mapping[str, str]) -> Figures:
    """The figures of model `name` with the generated `texts` by file name.

    Raises HysgenError if the C code contains a statement without a fixed cost.
    """
    header = concatenated(texts, (f"{name}.h",))
    source = concatenated(texts, (f"{name}.h", f"{name}_params.h", f"{name}.c"), (f"{name.upper()}_NUMBERS",))
    return _CACHE.get((name, header, source), lambda: _counted(name, header, source))


def _counted(name: str, header: str, source: str) -> Figures:
    program, declared = Program(parsed(source, f"{name}.c")), Types()
    for node in parsed(header, f"{name}.h").ext:
        if isinstance(node, c_ast.Typedef):
            declared.define(node)
    return Figures(
        operations={function.removeprefix(f"{name}_"): program.count(function) for function in program.public()},
        struct_bytes={struct: _BYTES * words(program.types[struct]) for struct in declared.structs},
        constant_bytes=_BYTES * program.constant_words,
    )
