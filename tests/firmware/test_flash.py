"""The flash driver over a model of SPI1 and of a W25Q64JV: 24-bit addresses, pages that wrap, bits that only fall.

The model acts on what the driver writes to SPI1's data register, byte by byte, as the data sheet's instructions say. It
counts what the real part would ignore: writing without write enable, or while it is busy.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest

from fixtures.firmware_bench import WARNINGS, model
from hysgen.firmware.binding import firmware_model
from hysgen.firmware.sources import CONTROLLER, TARGET_BOARD, read_sources
from hysgen.machine.native import Library, Toolchain, build, default_toolchain

SECTOR, SLOTS, SIZE = 4096, 0x7FE000, 1 << 23
MODEL = """
#include "chip.h"
#include "flash.h"

#define SIZE 0x800000u
uint8_t memory[SIZE];
uint32_t absent, ignored, busy_reads, selected, erased, programmed;
static uint32_t data1, buffer = CHIP_SPI_EMPTY, other, last, enabled, busy, count, address, instruction;
static uint8_t page[256];
static uint8_t latched[256];

static void deselected(void)
{
    if (instruction == 0x06u && count == 1u) {
        enabled = (busy == 0u);
    } else if ((instruction == 0x20u || instruction == 0x02u) && count >= 4u) {
        if (enabled == 0u || busy != 0u) {
            ignored += 1u;
        } else if (instruction == 0x20u && count == 4u) {
            for (uint32_t i = 0u; i < 4096u; ++i) { memory[((address & ~4095u) + i) % SIZE] = 0xFFu; }
            erased += 1u;
            busy = busy_reads;
        } else if (instruction == 0x02u && count > 4u) {
            for (uint32_t i = 0u; i < 256u; ++i) {
                if (latched[i] != 0u) { memory[((address & ~255u) + i) % SIZE] &= page[i]; }
            }
            programmed += 1u;
            busy = busy_reads;
        } else {
            ignored += 1u;
        }
        enabled = 0u;
    }
    selected = 0u;
    count = 0u;
}

static uint8_t exchanged(uint8_t byte, uint32_t hold)
{
    uint8_t answer = 0xFFu;

    if (count == 0u) {
        instruction = byte;
        selected = 1u;
        address = 0u;
        for (uint32_t i = 0u; i < 256u; ++i) { latched[i] = 0u; }
    } else if (instruction == 0x9Fu) {
        static const uint8_t id[3] = { 0xEFu, 0x40u, 0x17u };
        answer = id[(count - 1u) % 3u];
    } else if (instruction == 0x05u) {
        answer = (uint8_t)((busy != 0u) | (enabled << 1));
        busy -= (busy != 0u);
    } else if (count < 4u) {
        address = (address << 8 | byte) % SIZE;
    } else if (instruction == 0x03u) {
        if (busy == 0u) { answer = memory[(address + count - 4u) % SIZE]; }
    } else if (instruction == 0x02u) {
        const uint32_t at = (address + count - 4u) & 255u;
        page[at] = byte;
        latched[at] = 1u;
    }
    count += 1u;
    if (hold == 0u) { deselected(); }
    return (absent != 0u) ? 0xFFu : answer;
}

/* What was written through the last pointer takes effect now; a received byte is gone once it was read. */
volatile uint32_t *chip_register(uint32_t where)
{
    if (last == CHIP_SPI1 + CHIP_SPI_DAT1) {
        buffer = exchanged((uint8_t)data1, data1 & CHIP_SPI_HOLD);
    } else if (last == CHIP_SPI1 + CHIP_SPI_BUF) {
        buffer = CHIP_SPI_EMPTY;
    }
    last = where;
    if (where == CHIP_SPI1 + CHIP_SPI_DAT1) { return (volatile uint32_t *)&data1; }
    if (where == CHIP_SPI1 + CHIP_SPI_BUF) { return (volatile uint32_t *)&buffer; }
    return (volatile uint32_t *)&other;
}
volatile uint16_t *chip_bus(uint32_t address_of_bus) { (void)address_of_bus; return (volatile uint16_t *)&other; }
"""
DECLARED = """
typedef struct board board_t;
extern uint8_t memory[8388608];
extern uint32_t absent, ignored, busy_reads, selected, erased, programmed;
uint32_t flash_present(void);
void board_store_read(board_t *, uint32_t, uint32_t, uint8_t *, uint32_t);
void board_store_erase(board_t *, uint32_t);
uint32_t board_store_write(board_t *, uint32_t, uint32_t, const uint8_t *, uint32_t);
"""


def compiled(old: str = "", new: str = "") -> Library:
    """The driver over the model; old, new: a planted fault."""
    board = dict(read_sources(TARGET_BOARD))
    assert old in board["flash.c"]
    sources = {"flash.c": board["flash.c"].replace(old, new), "part.c": MODEL}
    sources |= {name: text for name, text in board.items() if name in ("flash.h", "chip.h", "board_type.h")}
    sources |= {name: text for name, text in read_sources(CONTROLLER) if name == "board.h"}
    sources |= {name: text for name, text in firmware_model(model()).items() if name.endswith(".h")}
    toolchain = Toolchain(default_toolchain().command, (*WARNINGS, "-DCHIP_MODEL", "-Wno-missing-prototypes", "-O2"))
    return build(list(sources.items()), DECLARED, toolchain, ())


@functools.cache
def sound() -> Library:
    return compiled()


class Flash:
    """An erased part behind the driver, busy for three status reads after each erase and page."""

    def __init__(self, library: Library) -> None:
        self.ffi, self.lib = library.ffi, library.lib
        self.lib.absent, self.lib.ignored, self.lib.busy_reads = 0, 0, 3
        self.memory = np.frombuffer(self.ffi.buffer(self.lib.memory), np.uint8)
        self.memory[:] = 0xFF

    def read(self, slot: int, offset: int, count: int) -> bytes:
        data = self.ffi.new("uint8_t []", count)
        self.lib.board_store_read(self.ffi.NULL, slot, offset, data, count)
        return bytes(data)

    def write(self, slot: int, offset: int, data: bytes) -> int:
        return int(self.lib.board_store_write(self.ffi.NULL, slot, offset, data, len(data)))

    def erase(self, slot: int) -> None:
        self.lib.board_store_erase(self.ffi.NULL, slot)


def differences(flash: Flash) -> int:
    """Random erases, writes and reads on both slots; returns how many reads or bytes of the part are wrong."""
    rng, wrong = np.random.default_rng(3), 0
    expected = np.full((2, SECTOR), 0xFF, np.uint8)
    for _ in range(300):
        slot, offset = int(rng.integers(2)), 4 * int(rng.integers(SECTOR // 4))
        count = min(4 * int(rng.integers(1, 200)), SECTOR - offset)
        action = rng.integers(8)
        if action == 0:
            flash.erase(slot)
            expected[slot] = 0xFF
        elif action < 5:
            data = rng.bytes(count)
            wrong += flash.write(slot, offset, data) != 1
            expected[slot, offset : offset + count] &= np.frombuffer(data, np.uint8)
        else:
            wrong += flash.read(slot, offset, count) != expected[slot, offset : offset + count].tobytes()
        wrong += flash.lib.selected
    wrong += int((flash.memory[SLOTS:].reshape(2, SECTOR) != expected).sum())
    return wrong + int((flash.memory[:SLOTS] != 0xFF).sum()) + int(flash.lib.ignored)


def test_whatever_is_written_is_read_back_and_nothing_else_changes() -> None:
    assert differences(Flash(sound())) == 0


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("const uint32_t room = FLASH_PAGE - (place & (FLASH_PAGE - 1u));", "const uint32_t room = FLASH_PAGE;"),
        ("        good = flash_ready();", "        good = 1u;"),
        ("(void)flash_exchange(FLASH_WRITE_ENABLE, 0u);", "(void)flash_exchange(FLASH_WRITE_ENABLE, CHIP_SPI_HOLD);"),
        ("FLASH_SLOTS + slot * BOARD_SLOT_BYTES", "FLASH_SLOTS + slot * FLASH_PAGE"),
        ("(i + 1u < length) ? CHIP_SPI_HOLD : 0u", "CHIP_SPI_HOLD"),
    ],
    ids=["page", "busy", "enable", "slot", "deselect"],
)
def test_a_fault_of_the_driver_is_seen_by_the_model(old: str, new: str) -> None:
    assert differences(Flash(compiled(old, new))) > 0


def test_without_the_part_nothing_claims_to_be_stored() -> None:
    flash = Flash(sound())
    flash.lib.absent = 1
    assert flash.lib.flash_present() == 0
    assert flash.write(0, 0, bytes(4)) == 0
    assert flash.read(0, 0, 4) == b"\xff" * 4
    flash.lib.absent = 0
    assert flash.lib.flash_present() == 1


def test_a_part_that_stays_busy_is_a_failed_write() -> None:
    flash = Flash(sound())
    flash.lib.busy_reads = 0xFFFFFFFF
    assert flash.write(0, 0, bytes(4)) == 0
    flash = Flash(compiled())
