"""Stack frame of a kernel that uses the registers that a function preserves: A10-A15 and B10-B14.

The stack pointer moves in the first packet and the pairs are saved in the three packets behind it, while the kernel
begins. Each pair is restored when its last reader has been issued. Stores and loads are of 64 bits: the stack pointer
is a multiple of 8 (C6000 EABI, SPRAB89).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

BYTES: Final = 56
POINTER: Final = (0, 3)
"""A3, the old stack pointer for the unit of side A, until the last pair is saved."""


@dataclass(frozen=True)
class FrameInstruction:
    """An instruction of the frame: cycle, unit, data path of a load or store (0, 1) or None, text."""

    cycle: int
    unit: str
    path: int | None
    text: str


@dataclass(frozen=True)
class Pair:
    """Registers of one side that are saved together, at 8 `slot` bytes above the stack pointer."""

    side: int
    registers: tuple[int, ...]
    slot: int
    cycle: int

    @property
    def text(self) -> str:
        """The registers as an operand, the high one first."""
        return ":".join(f"{'ab'[self.side]}{register}" for register in reversed(self.registers))

    @property
    def wide(self) -> bool:
        return len(self.registers) == 2


PAIRS: Final = (
    Pair(0, (10, 11), 4, 1),
    Pair(1, (10, 11), 1, 1),
    Pair(0, (12, 13), 5, 2),
    Pair(1, (12, 13), 2, 2),
    Pair(0, (14, 15), 6, 3),
    Pair(1, (14,), 3, 3),
)


def entry() -> list[FrameInstruction]:
    """The instructions that open the frame."""
    found = [
        FrameInstruction(0, "S2", None, f"addk .s2 -{BYTES}, b15"),
        FrameInstruction(0, "L1", None, "mv .l1x b15, a3"),
    ]
    for pair in PAIRS:
        kind = "stdw" if pair.wide else "stw"
        slots_below = BYTES // 8 - pair.slot
        where = f"*-a3[{slots_below}]" if pair.side == 0 else f"*+b15[{pair.slot * (1 if pair.wide else 2)}]"
        side = pair.side + 1
        found.append(
            FrameInstruction(pair.cycle, f"D{side}", pair.side, f"{kind} .d{side}t{side} {pair.text}, {where}")
        )
    return found


def restored(pair: Pair, cycle: int) -> FrameInstruction:
    """The load of a pair, by the unit of side B."""
    kind, index = ("lddw", pair.slot) if pair.wide else ("ldw", 2 * pair.slot)
    return FrameInstruction(cycle, "D2", pair.side, f"{kind} .d2t{pair.side + 1} *+b15[{index}], {pair.text}")


def closed(cycle: int) -> FrameInstruction:
    """The stack pointer's return."""
    return FrameInstruction(cycle, "S2", None, f"addk .s2 {BYTES}, b15")
