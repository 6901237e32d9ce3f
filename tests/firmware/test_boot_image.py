"""The boot image, read by a model of the boot ROM that shares no code with its writer."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.firmware_bench import model
from hysgen.c674x import toolchain
from hysgen.c674x.elf import MemorySection, ProgramImage, Symbol
from hysgen.errors import TargetError
from hysgen.firmware.binding import firmware_model
from hysgen.firmware.boot_image import boot_image, main
from hysgen.firmware.target import link_image

ROM = range(0x1180_0000, 0x1180_4000)


class BootRom:
    """Runs a script as SPRAB41 describes: loads sections, checks CRCs, ends at a jump. Its own memory stays its own."""

    def __init__(self, script: bytes) -> None:
        self.words = [int.from_bytes(script[at : at + 4], "little") for at in range(0, len(script), 4)]
        self.memory: dict[int, int] = {}
        self.at, self.checks, self.crc_on = 0, 0, False
        self.entry: int | None = None

    def take(self) -> int:
        self.at += 1
        return self.words[self.at - 1]

    def run(self) -> None:
        assert self.take() == 0x41504954
        begun, loaded = 0, b""
        while self.entry is None:
            opcode = self.take()
            if opcode == 0x58535903:
                self.crc_on = True
            elif opcode == 0x58535901:
                begun = self.at - 1
                address, size = self.take(), self.take()
                content = b"".join(self.take().to_bytes(4, "little") for _ in range(-(-size // 4)))[:size]
                assert not any(at in ROM for at in (address, address + size - 1)), "overwrites the boot ROM's memory"
                self.memory |= {address + i: byte for i, byte in enumerate(content)}
                loaded = address.to_bytes(4, "little") + size.to_bytes(4, "little") + content
            elif opcode == 0x58535902:
                crc, seek = self.take(), self.take() - (1 << 32)
                assert self.crc_on
                assert 4 * self.at + seek == 4 * begun, "seek does not lead back to the section"
                assert crc == bitwise_crc(loaded), "CRC"
                self.checks += 1
            elif opcode == 0x58535906:
                self.entry = self.take()
            else:
                raise AssertionError(f"{opcode:08x}")
        assert self.at == len(self.words)


def bitwise_crc(data: bytes) -> int:
    """CRC-32 bit by bit: polynomial 0x04C11DB7 reflected, all ones before and after."""
    crc = 0xFFFF_FFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xEDB8_8320 if crc & 1 else 0)
    return crc ^ 0xFFFF_FFFF


@pytest.mark.slow
def test_the_boot_rom_loads_what_the_linker_placed_and_jumps_to_reset(tmp_path: Path) -> None:
    need_compiler()
    built = link_image(model().name, firmware_model(model()))
    rom = BootRom(boot_image(built.firmware.image))
    rom.run()
    assert rom.entry == built.firmware.image.symbol("_c_int00").address
    assert rom.checks == 3
    # The same bytes by the linker's own tools: a flat binary from the first to the last loaded address.
    elf, flat = tmp_path / "firmware.out", tmp_path / "firmware.bin"
    elf.write_bytes(built.firmware.elf)
    objcopy = next((toolchain.folder() / "bin").glob("*-objcopy"))
    subprocess.run([objcopy, "-O", "binary", str(elf), str(flat)], check=True)
    expected, first = flat.read_bytes(), min(rom.memory)
    assert len(expected) <= max(rom.memory) + 1 - first < len(expected) + 4
    assert bytes(rom.memory.get(first + i, 0) for i in range(len(expected))) == expected


def program(*sections: MemorySection) -> ProgramImage:
    return ProgramImage(sections, {"_c_int00": Symbol("_c_int00", 0x1180_4400, 4, True)})


TEXT = MemorySection(".text", 0x1180_4000, 5, b"\1\2\3\4\5", False)


def test_a_section_is_padded_to_words_and_zeros_are_not_loaded() -> None:
    bss = MemorySection(".bss", 0x1180_5000, 64, b"", True)
    rom = BootRom(boot_image(program(bss, TEXT)))
    rom.run()
    assert [rom.memory[0x1180_4000 + i] for i in range(8)] == [1, 2, 3, 4, 5, 0, 0, 0]
    assert len(rom.memory) == 8


@pytest.mark.parametrize("address", [0x1180_0000, 0x1180_3FFC])
def test_content_in_the_boot_roms_memory_is_refused(address: int) -> None:
    with pytest.raises(TargetError, match="the boot ROM needs 0x11800000 to 0x11803fff"):
        boot_image(program(replace(TEXT, address=address)))


def test_a_flipped_bit_is_seen_by_the_reader() -> None:
    """The reader itself: every bit of address, size, content and CRC counts."""
    good = boot_image(program(TEXT))
    for bit in range(8 * 12, 8 * (8 + 12 + 8 + 8)):
        bad = bytearray(good)
        bad[bit // 8] ^= 1 << bit % 8
        with pytest.raises((AssertionError, IndexError)):
            BootRom(bytes(bad)).run()


def test_the_command_writes_the_image_or_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "no.out").write_bytes(b"no ELF")
    assert main([str(tmp_path / "no.out"), str(tmp_path / "no.ais")]) == 1
    assert "not a little-endian 32-bit ELF" in capsys.readouterr().err
    assert main([]) == 2
