"""A schedule and its parts: where each instruction is placed, with which settings, in which registers.

A plan uses the registers that a function may change (A0-A9, A16-A31, B0-B2, B4-B9, B16-B31), or all but B3 and B15 with
a stack frame (`frame`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from hysgen.errors import TargetError
from hysgen_c674x.schedule.frame import FrameInstruction
from hysgen_c674x.schedule.instructions import Node

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
