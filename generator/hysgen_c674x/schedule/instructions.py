"""Instructions of the C674x as nodes of a graph: mnemonic, units, latency, operands.

Source: SPRUFE8, chapter 4.

A schedule and its parts: where each instruction is placed, with which settings, in which registers.

A plan uses the registers that a function may change (A0-A9, A16-A31, B0-B2, B4-B9, B16-B31), or all but B3 and B15 with
a stack frame (`frame`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from hysgen.errors import TargetError
from hysgen_c674x.schedule.frame import FrameInstruction

WORD: Final = 4
REACH: Final = 31 * WORD
"""Largest offset of a load or store, in bytes, in either direction."""

# mnemonic: units, delay slots. The second source of all of them can come over the cross path.
UNITS: Final = {
    "addsp": ("LS", 3),
    "subsp": ("LS", 3),
    "mpysp": ("M", 3),
    "mpy32": ("M", 3),
    "intspu": ("L", 3),
    "cmpeqsp": ("S", 0),
    "cmpgtsp": ("S", 0),
    "cmpltsp": ("S", 0),
    "cmpeq": ("L", 0),
    "cmpgtu": ("L", 0),
    "cmpltu": ("L", 0),
    "add": ("DLS", 0),
    "sub": ("DLS", 0),
    "and": ("DLS", 0),
    "or": ("DLS", 0),
    "xor": ("DLS", 0),
    "shl": ("S", 0),
    "shru": ("S", 0),
    "clr": ("S", 0),
    "mv": ("DLS", 0),
    "mvk": ("S", 0),
    "mvkl": ("S", 0),
    "mvkh": ("S", 0),
}
LOAD_DELAY: Final = 4
MIRRORED: Final = {"cmpgtsp": "cmpltsp", "cmpltsp": "cmpgtsp", "cmpgtu": "cmpltu", "cmpltu": "cmpgtu"}


@dataclass(eq=False)
class Node:
    """One instruction, or a choice of two moves.

    operands: values read, or 5-bit constants. side: 0 or 1 if fixed. register: index 0..31 if fixed. predicate: whether
    the result must be in a register that predicates can test. in_place: the result replaces operand 0. guard: the
    instruction is executed only if this value is not 0. before: (node, cycles) pairs; this node is issued at least that
    many cycles after it. source: no operand depends on data of the kernel. word: of a load or store, the index of its
    word behind an address that is a multiple of 8. second: of a load of two words, the value of the second one.
    pair: the value beside which this one is stored, and 0 or 1: the place of this one in the pair of registers.
    """

    mnemonic: str
    operands: list[Operand]
    units: str
    delay: int
    order: int
    number: int = 0
    symbol: str = ""
    side: int | None = None
    register: int | None = None
    predicate: bool = False
    in_place: bool = False
    guard: Node | None = None
    before: list[tuple[Node, int]] = field(default_factory=list)
    source: bool = False
    word: int | None = None
    second: Node | None = None
    pair: tuple[Node, int] | None = None

    @property
    def memory(self) -> bool:
        return self.mnemonic in ("ldw", "stw", "lddw", "stdw")

    @property
    def load(self) -> bool:
        return self.mnemonic in ("ldw", "lddw", "second")

    @property
    def writes(self) -> bool:
        return self.mnemonic not in ("stw", "stdw")

    def values(self) -> list[Value]:
        """The values read."""
        found: list[Value] = [each for each in self.operands if not isinstance(each, int)]
        return [*found, self.guard] if self.guard else found


@dataclass(frozen=True, eq=False)
class Both:
    """The same value in a register of each side."""

    sides: tuple[Node, Node]


Value: TypeAlias = Node | Both
Operand: TypeAlias = Node | Both | int


@dataclass(frozen=True)
class Selected:
    """The instructions of a kernel, operands before users; `parameters` are in their registers at the start.

    stack: bytes of the stack that values take.
    """

    nodes: Sequence[Node]
    parameters: Sequence[Node]
    result: Node | None
    stack: int = 0


ARGUMENTS: Final = ((0, 4), (1, 4), (0, 6), (1, 6), (0, 8), (1, 8))
"""Side and register of the arguments of a function, by the C6000 EABI (SPRAB89, chapter 3)."""


def nodes_of(value: Value) -> tuple[Node, ...]:
    """The node of a value, or the nodes of both its sides."""
    return value.sides if isinstance(value, Both) else (value,)


PREDICATES: Final[tuple[tuple[int, ...], tuple[int, ...]]] = ((0, 1, 2), (0, 1, 2))
"""Registers that predicates can test, of each side."""

GENERAL: Final = ((*range(3, 10), *range(16, 32)), (*range(4, 10), *range(16, 32)))
PRESERVED: Final = (tuple(range(10, 16)), tuple(range(10, 15)))
BRANCH_SLOTS: Final = 5
PACKET: Final = 8
"""Instructions of one cycle."""

Register: TypeAlias = tuple[int, int]
"""Side and index."""


class OutOfRegistersError(TargetError):
    """No instruction can be placed, for want of registers."""


class TooLongError(TargetError):
    """A shorter schedule is known already."""


@dataclass(frozen=True)
class Placement:
    """Where one instruction is: cycle, unit, side of unit and register; cross: whether an operand crosses.

    moves: of a select, the predicated moves as (unit, when zero, operand, cross).
    """

    node: Node
    cycle: int
    unit: str
    side: int
    data_side: int
    register: int | None
    operands: tuple[Register | int, ...]
    cross: bool
    guard: Register | None
    moves: tuple[tuple[str, bool, Register | int, bool], ...] = ()

    @property
    def slots(self) -> int:
        """Instructions of the packet that the placement takes."""
        return max(1, len(self.moves))


@dataclass(frozen=True)
class Schedule:
    """All placements in the order of their cycles, the cycle of the return branch, and the cycles of a call."""

    placements: Sequence[Placement]
    branch: int
    cycles: int
    frame: Sequence[FrameInstruction] = ()


@dataclass(frozen=True)
class Plan:
    """Settings of one attempt.

    window: instructions in the order of the C text among which to choose. lead: cycles that loads and constants may
    come before their first use needs them. reserve: registers of a side that only the oldest instructions may take.
    For an attempt without limits on registers: growth: what the window is at least, for each computed value less than
    `room` that is alive.
    For the instructions of `spilling`: taper: registers of a side that an instruction must leave free, for each
    instruction between the oldest one and it; ahead: window of loads and constants; tested: of loads of conditions,
    which have six registers only; patience: cycles for which the oldest instruction is kept from its place before an
    operand of it is moved to the other side, 0 if it may wait as long as others are issued.
    """

    window: int
    lead: int
    reserve: int
    slope: float
    stretch: float = 0.0
    saved: bool = False
    taper: float = 0.0
    ahead: int = 1 << 30
    tested: int = 1 << 30
    patience: int = 0
    room: int = 0
    growth: int = 0
