"""Stack frame of a kernel that uses the registers that a function preserves: A10-A15 and B10-B14.

The stack pointer moves in the first packet and the pairs are saved in the three packets behind it, while the kernel
begins. Each pair is restored when its last reader has been issued. Stores and loads are of 64 bits: the stack pointer
is a multiple of 8 (C6000 EABI, SPRAB89).
"""

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


def saved_at(pair: Pair, stack: int) -> int:
    """The cycle in which a pair is saved. With values on the stack the unit of side A alone saves, one pair a cycle."""
    return PAIRS.index(pair) + 1 if stack else pair.cycle


def entry(stack: int) -> list[FrameInstruction]:
    """The instructions that open the frame; stack: bytes below it for values."""
    found = [
        FrameInstruction(0, "S2", None, f"addk .s2 -{BYTES + stack}, b15"),
        FrameInstruction(0, "L1", None, "mv .l1x b15, a3"),
    ]
    for pair in PAIRS:
        kind, size = ("stdw", 8) if pair.wide else ("stw", 4)
        side = 1 if stack or pair.side == 0 else 2
        where = f"*-a3[{(BYTES - 8 * pair.slot) // size}]" if side == 1 else f"*+b15[{8 * pair.slot // size}]"
        text = f"{kind} .d{side}t{pair.side + 1} {pair.text}, {where}"
        found.append(FrameInstruction(saved_at(pair, stack), f"D{side}", pair.side, text))
    return found


def restored(pair: Pair, cycle: int, stack: int) -> list[FrameInstruction]:
    """The loads of a pair, by the unit of side B.

    The offset of a 64-bit load does not reach over values on the stack.
    """
    path = f".d2t{pair.side + 1}"
    if pair.wide and not stack:
        return [FrameInstruction(cycle, "D2", pair.side, f"lddw {path} *+b15[{pair.slot}], {pair.text}")]
    first = (stack + 8 * pair.slot) // 4
    return [
        FrameInstruction(cycle, "D2", pair.side, f"ldw {path} *+b15[{first + k}], {'ab'[pair.side]}{register}")
        for k, register in enumerate(pair.registers)
    ]


def closed(cycle: int, stack: int) -> FrameInstruction:
    """The stack pointer's return."""
    return FrameInstruction(cycle, "S2", None, f"addk .s2 {BYTES + stack}, b15")
