"""The flash driver over the model of SPI1 and of a W25Q64JV: 24-bit addresses, pages that wrap, bits that only fall.

The model tells what the real part would ignore: writing without write enable, or anything while it is busy.
"""

import numpy as np
import pytest

from fixtures.board_drivers import Chip, drivers

SECTOR, SLOTS = 4096, 0x7FE000


class Flash(Chip):
    """An erased part behind the driver."""

    def read(self, slot: int, offset: int, count: int) -> bytes:
        data = self.ffi.new("uint8_t []", count)
        self.lib.hysgen_board_store_read(self.board, slot, offset, data, count)
        return bytes(data)

    def write(self, slot: int, offset: int, data: bytes) -> int:
        return int(self.lib.hysgen_board_store_write(self.board, slot, offset, data, len(data)))

    def erase(self, slot: int) -> None:
        self.lib.hysgen_board_store_erase(self.board, slot)


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
        wrong += flash.state.flash_selected
    wrong += int((flash.flash[SLOTS:].reshape(2, SECTOR) != expected).sum())
    return wrong + int((flash.flash[:SLOTS] != 0xFF).sum()) + len(flash.violations)


def test_whatever_is_written_is_read_back_and_nothing_else_changes() -> None:
    assert differences(Flash()) == 0


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
    assert differences(Flash(drivers("flash.c", old, new))) > 0


def test_without_the_part_nothing_claims_to_be_stored() -> None:
    flash = Flash()
    flash.state.flash_absent = 1
    assert flash.lib.hysgen_flash_present() == 0
    assert flash.write(0, 0, bytes(4)) == 0
    assert flash.read(0, 0, 4) == b"\xff" * 4
    flash.state.flash_absent = 0
    assert flash.lib.hysgen_flash_present() == 1


def test_a_part_that_stays_busy_is_a_failed_write() -> None:
    flash = Flash(drivers("flash.c", "#define FLASH_BUSY_POLLS    1000000u", "#define FLASH_BUSY_POLLS    1000u"))
    flash.state.program_s = 1e9
    assert flash.write(0, 0, bytes(4)) == 0
