/* flash.c: the parameter store of board.h in a W25Q64JV on SPI1, chip select 0.
 *
 * Instructions as TI's SWRA657, 7.2, lists them for SPI flash, and as Winbond's data sheet of the W25Q64JV has them: 06h write enable,
 * 05h read status, 03h read, 20h erase 4 KiB, 02h program up to 256 bytes of a page, 9Fh identification (EFh 40h 17h). Linux has the same:
 * drivers/mtd/spi-nor/winbond.c, "w25q64" 0xef4017 with sectors of 4 KiB. In the idle loop only: an erase takes up to 0.4 s, and the
 * interrupt runs on meanwhile. */

#include "flash.h"

#include "board.h"
#include "chip.h"

#define FLASH_WRITE_ENABLE  0x06u
#define FLASH_READ_STATUS   0x05u
#define FLASH_READ          0x03u
#define FLASH_ERASE         0x20u
#define FLASH_PROGRAM       0x02u
#define FLASH_IDENTIFY      0x9Fu
#define FLASH_BUSY          0x01u
#define FLASH_PAGE          256u
#define FLASH_MAKER         0xEFu
#define FLASH_BYTES_LOG2    0x17u      /* 2^23 bytes */

#define FLASH_WAITS         100000u    /* polls of SPI1 until a byte counts as lost */
#define FLASH_BUSY_POLLS    1000000u   /* status reads of 1.6 us and more until an erase counts as failed: above 1.6 s */

/* Send a byte, return the one that arrives meanwhile; with CHIP_SPI_HOLD the flash stays selected behind it, with 0 it is deselected for the
 * 50 ns at least that it needs between an instruction that writes and the next one. 0xFF if SPI1 does not answer. */
static uint8_t flash_exchange(uint8_t byte, uint32_t hold)
{
    uint32_t waits = 0u;
    uint32_t received;

    while (((chip_read(CHIP_SPI1 + CHIP_SPI_BUF) & CHIP_SPI_FULL) != 0u) && (waits < FLASH_WAITS)) {
        waits += 1u;
    }
    chip_write(CHIP_SPI1 + CHIP_SPI_DAT1, (uint32_t)byte | ((hold != 0u) ? hold : CHIP_SPI_PAUSE));
    received = chip_read(CHIP_SPI1 + CHIP_SPI_BUF);
    while (((received & CHIP_SPI_EMPTY) != 0u) && (waits < FLASH_WAITS)) {
        waits += 1u;
        received = chip_read(CHIP_SPI1 + CHIP_SPI_BUF);
    }
    return (waits < FLASH_WAITS) ? (uint8_t)(received & 0xFFu) : 0xFFu;
}

/* An instruction with a 24-bit address; the flash stays selected. */
static void flash_address(uint8_t instruction, uint32_t address)
{
    (void)flash_exchange(instruction, CHIP_SPI_HOLD);
    (void)flash_exchange((uint8_t)((address >> 16) & 0xFFu), CHIP_SPI_HOLD);
    (void)flash_exchange((uint8_t)((address >> 8) & 0xFFu), CHIP_SPI_HOLD);
}

/* 1 once nothing is being erased or programmed, 0 if that takes too long. */
static uint32_t flash_ready(void)
{
    uint32_t polls = 0u;
    uint32_t busy = 1u;

    while ((busy != 0u) && (polls < FLASH_BUSY_POLLS)) {
        (void)flash_exchange(FLASH_READ_STATUS, CHIP_SPI_HOLD);
        busy = (uint32_t)flash_exchange(0u, 0u) & FLASH_BUSY;
        polls += 1u;
    }
    return (uint32_t)(busy == 0u);
}

uint32_t hysgen_flash_present(void)
{
    uint8_t maker;
    uint8_t size;

    (void)flash_exchange(FLASH_IDENTIFY, CHIP_SPI_HOLD);
    maker = flash_exchange(0u, CHIP_SPI_HOLD);
    (void)flash_exchange(0u, CHIP_SPI_HOLD);
    size = flash_exchange(0u, 0u);
    return (uint32_t)(maker == FLASH_MAKER) & (uint32_t)(size == FLASH_BYTES_LOG2);
}

static uint32_t flash_place(uint32_t slot, uint32_t offset)
{
    return FLASH_SLOTS + slot * BOARD_SLOT_BYTES + offset;
}

void hysgen_board_store_read(board_t *board, uint32_t slot, uint32_t offset, uint8_t *bytes, uint32_t count)
{
    const uint32_t place = flash_place(slot, offset);

    (void)board;
    if (count != 0u) {
        flash_address(FLASH_READ, place);
        (void)flash_exchange((uint8_t)(place & 0xFFu), CHIP_SPI_HOLD);
        for (uint32_t i = 0u; i < count; ++i) {
            bytes[i] = flash_exchange(0u, (i + 1u < count) ? CHIP_SPI_HOLD : 0u);
        }
    }
}

void hysgen_board_store_erase(board_t *board, uint32_t slot)
{
    const uint32_t place = flash_place(slot, 0u);

    (void)board;
    if (hysgen_flash_present() != 0u) {
        (void)flash_exchange(FLASH_WRITE_ENABLE, 0u);
        flash_address(FLASH_ERASE, place);
        (void)flash_exchange((uint8_t)(place & 0xFFu), 0u);
        (void)flash_ready();
    }
}

uint32_t hysgen_board_store_write(board_t *board, uint32_t slot, uint32_t offset, const uint8_t *bytes, uint32_t count)
{
    const uint32_t first = flash_place(slot, offset);
    uint32_t good = hysgen_flash_present();
    uint32_t done = 0u;

    (void)board;
    while ((good != 0u) && (done < count)) {
        const uint32_t place = first + done;
        const uint32_t room = FLASH_PAGE - (place & (FLASH_PAGE - 1u));
        const uint32_t length = (count - done < room) ? count - done : room;

        (void)flash_exchange(FLASH_WRITE_ENABLE, 0u);
        flash_address(FLASH_PROGRAM, place);
        (void)flash_exchange((uint8_t)(place & 0xFFu), CHIP_SPI_HOLD);
        for (uint32_t i = 0u; i < length; ++i) {
            (void)flash_exchange(bytes[done + i], (i + 1u < length) ? CHIP_SPI_HOLD : 0u);
        }
        done += length;
        good = flash_ready();
    }
    return good;
}
