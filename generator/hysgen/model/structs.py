"""C structs as data: their members, and the 32-bit words that they consist of.

Every scalar of a generated struct has 32 bits, so a struct is the row of its words, without gaps.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

Scalar: TypeAlias = Literal["float", "uint32_t"]

BYTES_PER_WORD = 4


@dataclass(frozen=True)
class Word:
    """A scalar of a struct: its C path, as `terms.memory.play[2]`, and its type."""

    path: str
    type: Scalar


@dataclass(frozen=True)
class Member:
    """`type name[sizes];  /**< meaning */`.

    type: of the scalar, or the struct that the member is. sizes: of an array, none for anything else. extents: the
    sizes as the header writes them; numbers unless given.
    """

    name: str
    type: Scalar | Struct
    meaning: str
    sizes: tuple[int, ...] = ()
    extents: tuple[str, ...] = ()

    @property
    def type_name(self) -> str:
        """The type as C writes it."""
        return self.type.name if isinstance(self.type, Struct) else self.type

    def declaration(self, *, sized: bool = False) -> str:
        """The declaration as C, without semicolon; sized: with numbers for sizes that have names."""
        extents = self.sizes if sized or not self.extents else self.extents
        return f"{self.type_name} {self.name}" + "".join(f"[{extent}]" for extent in extents)

    def words(self, before: str = "") -> Iterator[Word]:
        """Every scalar of the member; before: path of the struct it belongs to, with its dot."""
        for place in itertools.product(*(range(size) for size in self.sizes)):
            path = f"{before}{self.name}" + "".join(f"[{i}]" for i in place)
            if isinstance(self.type, Struct):
                yield from self.type.words(f"{path}.")
            else:
                yield Word(path, self.type)


@dataclass(frozen=True)
class Struct:
    """`typedef struct { members } name;`"""

    name: str
    members: tuple[Member, ...]

    def words(self, before: str = "") -> Iterator[Word]:
        """Every scalar in the order of the declaration."""
        for member in self.members:
            yield from member.words(before)

    @property
    def size(self) -> int:
        """Number of words."""
        return sum(1 for _ in self.words())

    @property
    def bytes(self) -> int:
        """Size in memory."""
        return BYTES_PER_WORD * self.size

    def declaration(self) -> str:
        """The typedef as C, every size a number and without comments: what cffi has to be told."""
        members = "".join(f"    {member.declaration(sized=True)};\n" for member in self.members)
        return f"typedef struct {{\n{members}}} {self.name};\n"


@dataclass(frozen=True)
class Counter:
    """A counter of a struct that stops at its largest value.

    meaning: its comment. flag: bit of the status word that is set with it, 0 for none. written_by: kinds of functions
    of a learner's update that step it, see `hysgen.float32.struct_words`.
    """

    meaning: str
    flag: int = 0
    written_by: tuple[str, ...] = ()
