"""A C674x that runs from reset, with devices: registers, control registers and time persist between the calls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import DTypeLike, NDArray

from hysgen_c674x import translation
from hysgen_c674x.decode import CONTROL
from hysgen_c674x.elf import ProgramImage
from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import MEMORY_BASE, Devices, Processor, ProcessorFault, load

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
