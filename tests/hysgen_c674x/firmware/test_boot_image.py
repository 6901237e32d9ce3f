"""The boot image, read by a model of the boot ROM that shares no code with its writer."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from fixtures.boot_rom import BootRom
from fixtures.c674x_compiler import need_compiler
from fixtures.firmware_bench import model
from hysgen.errors import TargetError
from hysgen.firmware.binding import firmware_model
from hysgen_c674x import toolchain
from hysgen_c674x.elf import MemorySection, ProgramImage, Symbol
from hysgen_c674x.firmware.boot_image import boot_image, main
from hysgen_c674x.firmware.target import link_image


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
