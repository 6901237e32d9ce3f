"""Processor state: registers and memory; the counts of a run, and the faults that end it."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import TargetError
from hysgen.machine.native import Library
from hysgen_c674x.decode import CONTROL
from hysgen_c674x.elf import ProgramImage
from hysgen_c674x.packets import Packet

MEMORY_BASE = 0x1180_0000
MEMORY_SIZE = 0x4_0000  # the C6748's 256 KiB of L2 RAM, as the linker file says
RETURN_ADDRESS = 0xFFFF_FF00  # return address of the called function, outside any program
STACK_POINTER = 32 + 15

INTERRUPT_OVERHEAD: Final = 9
"""Cycles without instructions between the interrupted packet and the first of the vector (SPRU733A, 5.5.1, of the C67x;
the C674x's manual was not read)."""
NEVER: Final = (1 << 64) - 1


class ProcessorFault(enum.IntEnum):
    """Reasons for ending a run early; numbers as in engine/operations.h."""

    NONE = 0
    MISALIGNED = 1
    OUTSIDE = 2
    READ_ONLY = 3
    REGISTER_CLASH = 4
    PORT_CLASH = 5
    BRANCH_CLASH = 6
    NAN_TO_INTEGER = 7
    NO_PACKET = 8
    REFUSED = 9
    CYCLE_LIMIT = 10
    MODE = 11
    RESET = 12


_TEXTS = {
    ProcessorFault.MISALIGNED: "address {detail:08x} is not a multiple of the size of the access",
    ProcessorFault.OUTSIDE: "address {detail:08x} lies outside the memory",
    ProcessorFault.READ_ONLY: "a store to {detail:08x}, where code and constants lie",
    ProcessorFault.REGISTER_CLASH: "two results reach register {register} in one cycle",
    ProcessorFault.PORT_CLASH: "two results leave one functional unit in one cycle",
    ProcessorFault.BRANCH_CLASH: "two branches land in one cycle",
    ProcessorFault.NAN_TO_INTEGER: "a NaN becomes an integer, which is not modelled; keep NaN out",
    ProcessorFault.MODE: "control register {control} selects a mode that is not modelled",
    ProcessorFault.RESET: "a device resets the chip",
    ProcessorFault.CYCLE_LIMIT: "still running after {detail} cycles; an endless loop, or raise the limit",
}


@dataclass(frozen=True)
class RunCounts:
    """Counts of a run.

    cycles: without stalls. stalls: further cycles on silicon for operands over a cross path. packets: issued execute
    packets. denormals: operands and results flushed to zero. nans: NaN results. lowest_stack_pointer: its least value.
    """

    cycles: int
    stalls: int
    packets: int
    denormals: int
    nans: int
    lowest_stack_pointer: int


class AccessKind(enum.IntEnum):
    """Kinds of accesses to memory; numbers as in engine/pipeline.h."""

    FETCH = 0
    LOAD = 1
    STORE = 2


@dataclass
class Trace:
    """Record of the accesses of a run, in their order, as long as `room` lasts.

    words: (room,), cycle << 34 | kind << 32 | address; a FETCH has the address of its packet. count: accesses of the
    run, which may exceed the room.
    """

    room: int = 0
    count: int = 0
    words: NDArray[np.uint64] = field(init=False)

    def __post_init__(self) -> None:
        self.words = np.zeros(self.room, np.uint64)

    def add(self, cycle: int, kind: AccessKind, address: int) -> None:
        """Append an access."""
        if self.count < self.room:
            self.words[self.count] = cycle << 34 | kind << 32 | address
        self.count += 1


@dataclass(frozen=True)
class Devices:
    """Registers of devices outside the memory, which loads, stores and interrupts reach.

    library: C with device_load, device_store and device_events (engine/state.h). handle: their first argument.
    """

    library: Library
    handle: Any

    @property
    def handle_address(self) -> int:
        """The handle as a number."""
        return int(self.library.ffi.cast("uintptr_t", self.handle))

    def address(self, function: str) -> int:
        """Address of a function of the library."""
        ffi = self.library.ffi
        return int(ffi.cast("uintptr_t", ffi.addressof(self.library.lib, function)))


@dataclass
class Processor:
    """Registers, memory and program. read_only_end: end of code and constants. free: first unused address.

    control: control registers, by their number in CONTROL. counter_from: cycle at which TSCL was 0, None while it
    does not count. devices: None for a program alone in its memory. trace: filled by the next run. skipped: number of
    the packet, from 0, that has no effect in a run, as behind a glitch of clock or supply.
    """

    packets: Mapping[int, Packet]
    memory: bytearray
    read_only_end: int
    free: int
    registers: list[int]
    program_counter: int = RETURN_ADDRESS
    control: list[int] = field(default_factory=lambda: [0] * len(CONTROL))
    counter_from: int | None = None
    devices: Devices | None = None
    trace: Trace = field(default_factory=Trace)
    skipped: int = NEVER

    def packet(self, address: int) -> Packet:
        """The packet at `address`. Raises TargetError if none starts there, or if it is not modelled."""
        packet = self.packets.get(address)
        if packet is None:
            raise TargetError(f"{address:08x}: no execute packet starts here; a jump into data or into a packet")
        if packet.refusal:
            raise TargetError(packet.refusal)
        return packet

    def fault(self, kind: ProcessorFault, address: int, detail: int) -> TargetError:
        """The error for a fault in the packet at `address`; `detail` is an address, a register or a cycle limit."""
        if kind in (ProcessorFault.NO_PACKET, ProcessorFault.REFUSED):
            try:
                self.packet(address)
            except TargetError as refusal:
                return refusal
        register = f"{'ab'[detail // 32 % 2]}{detail % 32}"
        control = CONTROL[detail] if kind is ProcessorFault.MODE else ""
        text = _TEXTS[kind].format(detail=detail, register=register, control=control)
        return TargetError(f"{address:08x} {self.packets[address]}: {text}")


def load(image: ProgramImage, packets: Mapping[int, Packet]) -> Processor:
    """A processor with the program in its memory. Raises TargetError if the program does not fit there."""
    memory = bytearray(MEMORY_SIZE)
    for section in image.sections:
        start = section.address - MEMORY_BASE
        if start < 0 or start + section.size > MEMORY_SIZE:
            raise TargetError(f"section {section.name} lies outside the memory; link with l2ram.ld, or make it smaller")
        memory[start : start + len(section.content)] = section.content
    ends = [section.address + section.size for section in image.sections]
    constant_ends = [section.address + section.size for section in image.sections if not section.writable]
    read_only_end = max(constant_ends, default=MEMORY_BASE)
    if any(section.writable and section.address < read_only_end for section in image.sections):
        raise TargetError("writable sections lie below constant ones; link with l2ram.ld")
    return Processor(packets, memory, read_only_end, max(ends, default=MEMORY_BASE), [0] * 64)
