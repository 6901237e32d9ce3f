"""First-level caches of the C674x: lines that a traced call misses.

Of the C6748 (SPRUFK5): L1P 32 KiB, direct-mapped, lines of 32 bytes; L1D 32 KiB, two-way, lines of 64 bytes, the least
recently used line is replaced. A store that misses L1D goes to the write buffer and takes no line. The stall of a miss
depends on other users of L2, so the model counts lines; the caller knows the cycles of a line.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from hysgen_c674x.packets import Packet
from hysgen_c674x.processor import AccessKind, Trace

L1P_LINE: Final = 32
L1P_SETS: Final = 1024
L1D_LINE: Final = 64
L1D_SETS: Final = 256
L1D_WAYS: Final = 2


@dataclass(frozen=True)
class Misses:
    """Lines that were fetched from L2: of the program, and of data."""

    program: int
    data: int

    @property
    def lines(self) -> int:
        """All of them."""
        return self.program + self.data


def program_lines(packet: Packet) -> range:
    """Lines of L1P that hold an execute packet: addresses divided by L1P_LINE."""
    return range(packet.address // L1P_LINE, (packet.next - 1) // L1P_LINE + 1)


@dataclass
class Caches:
    """Content of both caches, empty at first. packets: of the program that runs."""

    packets: Mapping[int, Packet]
    _program: dict[int, int] = field(default_factory=dict)
    _data: dict[int, list[int]] = field(default_factory=dict)

    def run(self, trace: Trace) -> Misses:
        """The misses of a call, whose lines replace what the caches held."""
        program = data = 0
        for word in trace.words[: trace.count].tolist():
            kind, address = word >> 32 & 3, word & 0xFFFF_FFFF
            if kind == AccessKind.FETCH:
                program += sum(self._fetch(line) for line in program_lines(self.packets[address]))
            else:
                data += self._access(address // L1D_LINE, kind == AccessKind.LOAD)
        return Misses(program, data)

    def _fetch(self, line: int) -> bool:
        """Whether the line of L1P is missing; it is there afterwards."""
        missing = self._program.get(line % L1P_SETS) != line
        self._program[line % L1P_SETS] = line
        return missing

    def _access(self, line: int, loads: bool) -> bool:
        """Whether a load misses its line of L1D; it is there afterwards, as the one used last."""
        ways = self._data.setdefault(line % L1D_SETS, [])
        found = line in ways
        if found:
            ways.remove(line)
        if found or loads:
            ways.append(line)
            del ways[:-L1D_WAYS]
        return loads and not found
