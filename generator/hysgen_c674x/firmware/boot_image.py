"""Boot images of the C6748: the linked firmware as a script for the boot ROM (AIS, application image script).

    python -m hysgen_c674x.firmware.boot_image firmware.out firmware.ais

words, 32 bits, little-endian
    MAGIC, ENABLE_CRC
    for each section: SECTION_LOAD, address, bytes, content; REQUEST_CRC, CRC, seek
    JUMP_CLOSE, entry

The CRC is Ethernet's, of address, bytes and content. `seek` is the distance back to SECTION_LOAD, to which the ROM
returns if its own CRC differs. TI describes the script in SPRAB41 (bootloader of the C6748); opcodes, order and CRC are
those that TI's HexAIS for the OMAP-L138 writes with section CRCs. Not booted here: no silicon.
"""

import struct
import sys
import zlib
from pathlib import Path
from typing import Final

from hysgen.errors import HysgenError, TargetError
from hysgen.machine.files import write_whole
from hysgen_c674x.elf import MemorySection, ProgramImage, read

MAGIC: Final = 0x41504954
SECTION_LOAD: Final = 0x58535901
REQUEST_CRC: Final = 0x58535902
ENABLE_CRC: Final = 0x58535903
JUMP_CLOSE: Final = 0x58535906
ROM_MEMORY: Final = (0x1180_0000, 0x1180_4000)
"""Addresses of L2 that the boot ROM uses for itself (SPRAB41): no content may be loaded there."""


def boot_image(program: ProgramImage) -> bytes:
    """The script that loads the sections with content and jumps to `_c_int00`.

    Sections of zeros are not loaded: the firmware clears them itself. Raises TargetError for content in ROM_MEMORY or
    at an address that is not a multiple of 4.
    """
    words = struct.pack("<2I", MAGIC, ENABLE_CRC)
    for section in sorted(program.sections, key=lambda each: each.address):
        if section.content:
            words += _load(section)
    return words + struct.pack("<2I", JUMP_CLOSE, program.symbol("_c_int00").address)


def _load(section: MemorySection) -> bytes:
    content = section.content + bytes(-len(section.content) % 4)
    first, end = ROM_MEMORY
    if section.address < end and section.address + len(content) > first:
        needs = f"the boot ROM needs 0x{first:08x} to 0x{end - 1:08x} for itself"
        raise TargetError(f"{section.name}: at 0x{section.address:08x}; {needs}")
    if section.address % 4:
        raise TargetError(f"{section.name}: at 0x{section.address:08x}, which is not a multiple of 4")
    body = struct.pack("<2I", section.address, len(content)) + content
    seek = -(len(content) + 24)
    return struct.pack("<I", SECTION_LOAD) + body + struct.pack("<2Ii", REQUEST_CRC, zlib.crc32(body), seek)


def main(arguments: list[str]) -> int:
    """Write the boot image of a linked ELF file; returns the exit code."""
    if len(arguments) != 2:
        print("usage: python -m hysgen_c674x.firmware.boot_image firmware.out firmware.ais", file=sys.stderr)
        return 2
    source, target = map(Path, arguments)
    try:
        data = boot_image(read(source.read_bytes()))
        write_whole(target, data)
    except (HysgenError, OSError) as fault:
        print(f"{source}: {fault}", file=sys.stderr)
        return 1
    print(f"written: {target} ({len(data)} bytes)")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
