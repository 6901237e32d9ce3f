"""Calls of functions of a C674x program from Python, and access to its memory.

A C674x that runs from reset, with devices: registers, control registers and time persist between the calls.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import DTypeLike, NDArray

from hysgen.checking.symbolic.semantics import MASK, from_image, to_image
from hysgen.errors import TargetError
from hysgen_c674x import interpreter, translation
from hysgen_c674x.assembly import Register
from hysgen_c674x.decode import CONTROL
from hysgen_c674x.elf import ProgramImage
from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import (
    MEMORY_BASE,
    MEMORY_SIZE,
    RETURN_ADDRESS,
    STACK_POINTER,
    Devices,
    Processor,
    ProcessorFault,
    RunCounts,
    Trace,
    load,
)

Argument = float | int | np.float32 | np.integer[Any]

# C6000 EABI (SPRAB89), chapter 3: arguments alternate between the register files; a callee preserves 10..15 of both.
_ARGUMENT_REGISTERS = (4, 32 + 4, 6, 32 + 6, 8, 32 + 8, 10, 32 + 10, 12, 32 + 12)
_CALLEE_SAVED = (*range(10, 16), *range(32 + 10, 32 + 16))
_RETURN_VALUE, _LINK = 4, 32 + 3

_STACK_TOP = MEMORY_BASE + MEMORY_SIZE - 64
_STACK_ROOM = 0x4000
# Initial value of registers that the caller does not set: conspicuous as integer and as float.
_LEFTOVER = 0xCDCD_0000

CYCLE_LIMIT = 100_000_000


@dataclass(frozen=True)
class CallOutcome:
    """Result and cost of a call.

    bits: register A4, the 32-bit image of the return value. stack_bytes: most stack in use.
    """

    bits: int
    counts: RunCounts
    stack_bytes: int

    @property
    def cycles(self) -> int:
        """Cycles from the first packet until the return branch takes effect, without stalls."""
        return self.counts.cycles

    @property
    def float32(self) -> float:
        """The return value as a float."""
        return from_image(self.bits)


@dataclass(frozen=True)
class CallOutcomes:
    """Results of N calls of one function. bits, cycles, stalls: (N,). memory: words after each call, (N, words)."""

    bits: NDArray[np.uint32]
    cycles: NDArray[np.int64]
    stalls: NDArray[np.int64]
    denormals: int
    nans: int
    memory: Mapping[str | int, NDArray[np.uint32]]


class Machine:
    """A C674x with a program in its memory. Memory persists between calls; registers are initialised in each call.

    image, packets: the linked program and its execute packets, from `toolchain.compile`.
    processor: registers and memory, for a caller that steps the interpreter itself.
    interpreted: use the interpreter instead of the compiled engine; same results, a hundred times slower.
    """

    def __init__(self, image: ProgramImage, packets: Mapping[int, Packet], interpreted: bool = False) -> None:
        self.image = image
        self.packets = packets
        self.processor = load(image, self.packets)
        self._run = interpreter.run if interpreted else translation.engine(self.packets)
        self._bytes = np.frombuffer(self.processor.memory, dtype=np.uint8)
        self._free = self.processor.free

    def address(self, where: str | int) -> int:
        """The address of a symbol; an address is returned unchanged."""
        return self.image.symbol(where).address if isinstance(where, str) else where

    def allocate(self, words: int) -> int:
        """Allocate `words` 32-bit words of zeros, aligned to 8 bytes; returns their address."""
        start = (self._free + 7) & ~7
        if start + 4 * words > _STACK_TOP - _STACK_ROOM:
            raise TargetError(f"{4 * words} bytes do not fit into the target's memory beside program and stack")
        self._free = start + 4 * words
        return start

    def view(self, where: str | int, words: int, dtype: DTypeLike = np.float32) -> NDArray[Any]:
        """A writable view of `words` 32-bit numbers of the memory at a symbol or address."""
        start = self.address(where) - MEMORY_BASE
        if start < 0 or start % 4 or start + 4 * words > MEMORY_SIZE:
            raise TargetError(f"{where}: {words} words there are unaligned or outside the target's memory")
        return self._bytes[start : start + 4 * words].view(np.dtype(dtype).newbyteorder("<"))

    def read(self, where: str | int, words: int, dtype: DTypeLike = np.float32) -> NDArray[Any]:
        """A copy of `words` 32-bit numbers at a symbol or address."""
        return self.view(where, words, dtype).astype(np.dtype(dtype))

    def write(self, where: str | int, values: NDArray[Any] | Sequence[float]) -> None:
        """Write 32-bit numbers to memory: the bits of an array, or a sequence of floats rounded to float32."""
        array = np.asarray(values, dtype=None if isinstance(values, np.ndarray) else np.float32)
        if array.dtype.itemsize != 4:
            raise TargetError(f"{where}: values of type {array.dtype} are not 32 bits wide; use float32 or uint32")
        self.view(where, array.size, array.dtype)[:] = array.ravel()

    def call(self, function: str, *arguments: Argument, cycle_limit: int = CYCLE_LIMIT) -> CallOutcome:
        """Call a function by the C calling convention.

        arguments: a float is passed as float32, an int as a 32-bit integer or pointer; at most ten.
        Raises TargetError if the simulator refuses an instruction or the callee does not preserve a register.
        """
        return self._call(self.address(function), [_image(argument) for argument in arguments], cycle_limit)

    def trace(self, function: str, *arguments: Argument, room: int = 1 << 16) -> tuple[CallOutcome, Trace]:
        """As `call`, with the accesses of the call to memory. Raises TargetError if there are more than `room`."""
        trace = self.processor.trace = Trace(room)
        outcome = self.call(function, *arguments)
        self.processor.trace = Trace()
        if trace.count > room:
            raise TargetError(f"{function}: {trace.count} accesses to memory; the trace has room for {room}")
        return outcome, trace

    def map(
        self,
        function: str,
        *arguments: Argument | NDArray[Any],
        write: Mapping[str | int, NDArray[Any]] | None = None,
        read: Mapping[str | int, int] | None = None,
        cycle_limit: int = CYCLE_LIMIT,
    ) -> CallOutcomes:
        """Call a function N times; memory persists between the calls.

        arguments: arrays of N values, or one value for all calls.
        write: by symbol or address, (N, words) numbers; row i is written before call i.
        read: by symbol or address, the number of words that are read after each call.
        """
        sources = {where: np.asarray(rows) for where, rows in (write or {}).items()}
        lengths = {len(each) for each in (*arguments, *sources.values()) if isinstance(each, np.ndarray)}
        if len(lengths) != 1:
            raise TargetError(f"{function}: arguments and memory rows have lengths {sorted(lengths)}; make them one")
        count = lengths.pop()
        columns = [_images(argument, count) for argument in arguments]
        views = {where: (self.view(where, rows[0].size, rows.dtype), rows) for where, rows in sources.items()}
        kept = {where: (self.view(where, words, np.uint32), words) for where, words in (read or {}).items()}
        memory = {where: np.empty((count, words), np.uint32) for where, (_, words) in kept.items()}
        bits, cycles, stalls = np.empty(count, np.uint32), np.empty(count, np.int64), np.empty(count, np.int64)
        denormals = nans = 0
        entry = self.address(function)
        for i in range(count):
            for place, rows in views.values():
                place[:] = rows[i].ravel()
            outcome = self._call(entry, [column[i] for column in columns], cycle_limit)
            for where, (place, _) in kept.items():
                memory[where][i] = place
            bits[i], cycles[i], stalls[i] = outcome.bits, outcome.cycles, outcome.counts.stalls
            denormals += outcome.counts.denormals
            nans += outcome.counts.nans
        return CallOutcomes(bits, cycles, stalls, denormals, nans, memory)

    def _call(self, entry: int, images: list[int], cycle_limit: int) -> CallOutcome:
        if len(images) > len(_ARGUMENT_REGISTERS):
            raise TargetError(f"{entry:08x}: {len(images)} arguments; ten go in registers, more are not modelled")
        registers = [_LEFTOVER + index for index in range(64)]
        for index, image in zip(_ARGUMENT_REGISTERS, images, strict=False):
            registers[index] = image
        registers[STACK_POINTER], registers[_LINK] = _STACK_TOP, RETURN_ADDRESS
        processor = self.processor
        processor.registers, processor.program_counter = list(registers), entry
        counts = self._run(processor, cycle_limit)
        for index in _CALLEE_SAVED:
            if processor.registers[index] != registers[index]:
                raise TargetError(f"{entry:08x}: returned with register {Register(index)} changed, against the ABI")
        stack_bytes = max(0, _STACK_TOP - counts.lowest_stack_pointer)
        return CallOutcome(processor.registers[_RETURN_VALUE], counts, stack_bytes)


def _image(argument: Argument) -> int:
    if isinstance(argument, int | np.integer):
        return int(argument) & MASK
    return to_image(float(argument))


def _images(argument: Argument | NDArray[Any], count: int) -> list[int]:
    if not isinstance(argument, np.ndarray):
        return [_image(argument)] * count
    if np.issubdtype(argument.dtype, np.floating):
        return [int(bits) for bits in argument.astype("<f4").view("<u4")]
    return [int(value) & MASK for value in argument]


JUNK: Final = 0xCD
"""Content of memory and registers at power on: a program that relies on zeros fails."""


class System:
    """The compiled engine at a reset, in front of the first packet of `_c_int00`.

    image, packets: the linked program, which the boot has loaded; memory beside it holds JUNK.
    devices: registers outside the memory, and sources of interrupts.
    """

    def __init__(self, image: ProgramImage, packets: Mapping[int, Packet], devices: Devices) -> None:
        self.image = image
        self.processor: Processor = load(image, packets)
        self.processor.devices = devices
        self._library = translation.compiled(packets)
        self._bytes = np.frombuffer(self.processor.memory, dtype=np.uint8)
        loaded = np.zeros(self._bytes.size, bool)
        for section in image.sections:
            start = section.address - MEMORY_BASE
            loaded[start : start + len(section.content)] = True
        self._bytes[~loaded] = JUNK
        self.processor.registers = [JUNK * 0x0101_0101] * 64
        self.processor.program_counter = image.symbol("_c_int00").address
        self._state = translation.initial(self._library, self.processor)

    @property
    def cycle(self) -> int:
        """Cycles since reset."""
        return int(self._state.cycle)

    @property
    def function(self) -> str:
        """The function that holds the program counter."""
        here = self._state.program_counter
        below = [each for each in self.image.symbols.values() if each.address <= here and each.function]
        return max(below, key=lambda each: each.address).name

    def control(self, name: str) -> int:
        """A control register."""
        return int(self._state.control[CONTROL.index(name)])

    def raise_nmi(self) -> None:
        """Set the flag of NMI."""
        self._state.control[CONTROL.index("ifr")] |= 2

    def run(self, cycles: int) -> bool:
        """Run for `cycles` cycles; returns False if a device has reset the chip before.

        Raises TargetError if the processor forbids the effect of a packet or the simulator does not model it.
        """
        state: Any = self._state
        state.cycle_limit = state.cycle + cycles
        state.trace_room = 0
        self._library.lib.c674x_run(state)
        fault = ProcessorFault(state.fault)
        if fault not in (ProcessorFault.CYCLE_LIMIT, ProcessorFault.RESET):
            raise self.processor.fault(fault, state.fault_address, state.fault_detail)
        state.fault = 0
        return fault is ProcessorFault.CYCLE_LIMIT

    def view(self, where: str | int, words: int, dtype: DTypeLike = np.float32) -> NDArray[Any]:
        """A writable view of `words` 32-bit numbers of the memory at a symbol or address."""
        start = (self.image.symbol(where).address if isinstance(where, str) else where) - MEMORY_BASE
        return self._bytes[start : start + 4 * words].view(np.dtype(dtype).newbyteorder("<"))
