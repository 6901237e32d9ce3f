"""The scalar words of a generated struct, from the text of its header."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from cffi import FFI

from hysgen.checking.host import declarations


@dataclass(frozen=True)
class Word:
    """A scalar of a struct: its C path and its type, `float` or `uint32_t`."""

    path: str
    type: str


def words(header: str, struct: str) -> list[Word]:
    """Every scalar of `struct` in the order of its declaration."""
    ffi = FFI()
    ffi.cdef(declarations(header))
    return list(_walk(ffi.typeof(struct), ""))


def _walk(kind: Any, path: str) -> Iterator[Word]:
    if kind.kind == "struct":
        for field, member in kind.fields:
            yield from _walk(member.type, f"{path}.{field}" if path else field)
    elif kind.kind == "array":
        for i in range(kind.length):
            yield from _walk(kind.item, f"{path}[{i}]")
    else:
        yield Word(path, kind.cname)
