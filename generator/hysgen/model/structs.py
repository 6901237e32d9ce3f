"""C structs as data: their members, the 32-bit words that they consist of, and the bits of the status word.

Every scalar of a generated struct has 32 bits, so a struct is the row of its words, without gaps.
"""

from __future__ import annotations

import enum
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, Self, TypeAlias, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import ModelError

Scalar: TypeAlias = Literal["float", "uint32_t"]

BYTES_PER_WORD = 4

Bits: TypeAlias = NDArray[np.uint32]
LaneWords: TypeAlias = NDArray[np.float32] | Bits


@dataclass(frozen=True)
class Word:
    """A scalar of a struct: its C path, as `inputs.hysteresis.play[2]`, and its type."""

    path: str
    type: Scalar


@dataclass(frozen=True)
class Axis:
    """What the index of an array runs over: the physical value that belongs to each element."""

    name: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Quantity:
    """The meaning of a number of the generated C, and its unit; "" for a pure number and for mixed units."""

    meaning: str
    unit: str = ""


INPUT_UNIT: Final = "input"
"""Unit of a member of an input block that has the unit of the block's input; `codegen.structs` replaces it."""


@dataclass(frozen=True)
class Member:
    """`type name[sizes];  /**< meaning [unit]remark */`.

    type: of the scalar, or the struct that the member is. sizes: of an array, none for anything else. extents: the
    sizes as the header writes them; numbers unless given. axis: of the index of an array of one size, if the elements
    belong to physical values. Raises ModelError for another type or for more sizes.
    """

    name: str
    type: Scalar | Struct
    meaning: str
    sizes: tuple[int, ...] = ()
    extents: tuple[str, ...] = ()
    unit: str = ""
    remark: str = ""
    axis: Axis | None = None

    def __deepcopy__(self, made: dict[int, Any]) -> Member:
        """Itself, for it cannot change: mirrors are copied often."""
        return self

    def __post_init__(self) -> None:
        if len(self.sizes) > 2 or not (isinstance(self.type, Struct) or self.type in get_args(Scalar)):
            raise ModelError(
                f"{self.name}: a member of a generated struct is a float or a uint32_t, alone or with up to two sizes"
            )

    @property
    def comment(self) -> str:
        """The comment in the header: meaning, unit and remark as a sentence."""
        return sentence(self.meaning + (f" [{self.unit}]" if self.unit else "") + self.remark)

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
        """The typedef as C, with numeric sizes and without comments, for cffi."""
        members = "".join(f"    {member.declaration(sized=True)};\n" for member in self.members)
        return f"typedef struct {{\n{members}}} {self.name};\n"


class MirroredStruct:
    """State of a mirror: one attribute per member of a C struct, with the member's name.

    A scalar is (lanes,), an array a list of them, an array of two sizes a list of lists.
    """

    members: tuple[Member, ...] = ()

    def state(self) -> list[LaneWords]:
        """Every 32-bit word of the C struct, in its order, (lanes,) each; compared bit for bit."""
        return [word for member in self.members for word in _flat(getattr(self, member.name), len(member.sizes))]

    def restore(self, words: Sequence[Bits]) -> None:
        """Set the state: the bits of every word in the order of `state`, (lanes,) each, for any number of lanes."""
        remaining = iter(words)
        for member in self.members:
            setattr(self, member.name, _nested(remaining, member.type, member.sizes))


def sentence(text: str) -> str:
    """`text` with a capital first letter and a full stop.

    >>> sentence("last output [um]")
    'Last output [um].'
    """
    return text[:1].upper() + text[1:].removesuffix(".") + "."


def _flat(value: Any, depth: int) -> list[LaneWords]:
    return [value] if depth == 0 else [word for item in value for word in _flat(item, depth - 1)]


def _nested(remaining: Iterator[Bits], kind: Scalar | Struct, sizes: tuple[int, ...]) -> Any:
    if sizes:
        return [_nested(remaining, kind, sizes[1:]) for _ in range(sizes[0])]
    return next(remaining).view(np.float32) if kind == "float" else next(remaining)


@dataclass(frozen=True)
class Counter:
    """A counter of a struct that stops at its largest value.

    meaning: its comment. flag: bit of the status word that is set with it, 0 for none. written_by: kinds of functions
    of a learner's update that step it, see `hysgen.float32.struct_words`.
    """

    meaning: str
    flag: int = 0
    written_by: tuple[str, ...] = ()


Meant = TypeVar("Meant", bound="MeantEnum | MeantFlag")


def _member(cls: type[Meant], value: int, meaning: str) -> Meant:
    member = int.__new__(cls, value)
    member._value_, member.meaning = value, meaning
    return member


class MeantEnum(enum.IntEnum):
    """Integers with a sentence each: NAME = value, meaning."""

    meaning: str

    def __new__(cls, value: int, meaning: str = "") -> Self:
        return _member(cls, value, meaning)


class MeantFlag(enum.IntFlag):
    """Bits with a sentence each: NAME = bit, meaning."""

    meaning: str

    def __new__(cls, value: int, meaning: str = "") -> Self:
        return _member(cls, value, meaning)


class Status(MeantFlag):
    """Bits of `status`: set at the first occurrence, cleared by the caller or by `_init`."""

    Y_CLAMPED = 1, "A displacement lay outside the identified range and was limited to it."
    U_CLAMPED = 2, "A voltage lay outside the input range and was limited to it."
    Y_REJECTED = 4, "A displacement was not finite; the last good one was used."
    U_REJECTED = 8, "A voltage was not finite; the last good one was used."
    REFERENCE_CLAMPED = 16, "A reference lay more than one range away and was limited."
    UNREACHABLE = 32, "The input that would reach the reference lay beyond what can be applied."
    AUX_CLAMPED = 64, "An auxiliary channel lay outside its range and was limited to it."
    AUX_REJECTED = 128, "An auxiliary channel was not finite; its last good sample was used."
    INVERSE_RESIDUAL = 256, "The voltage leaves more than the stated tolerance of the input of the rules."

    @classmethod
    def of(cls, responds: bool) -> list[Self]:
        """Those of a model. responds: whether a block of its path does, which alone leaves a residual."""
        return [flag for flag in cls if responds or flag is not cls.INVERSE_RESIDUAL]


COUNTERS = {
    "y_clamped": Counter(
        "number of calls with y outside its range; every counter stops at its largest value", Status.Y_CLAMPED
    ),
    "u_clamped": Counter("number of calls with u outside its range", Status.U_CLAMPED),
    "y_rejected": Counter("number of calls with y not finite", Status.Y_REJECTED),
    "u_rejected": Counter("number of calls with u not finite", Status.U_REJECTED),
}
"""The counters of the struct in its order; each stops at its largest value."""
