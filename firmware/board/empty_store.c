/* empty_store.c: a parameter store without memory, of the simulator's board, and for a board without flash in place of c6748/flash.c.
 *
 * Nothing survives power off, and images are refused with IMAGE_NOT_STORED; reading gives erased memory. */

#include "board.h"

void hysgen_board_store_read(board_t *board, uint32_t slot, uint32_t offset, uint8_t *bytes, uint32_t count)
{
    (void)board;
    (void)slot;
    (void)offset;
    for (uint32_t i = 0u; i < count; ++i) {
        bytes[i] = 0xFFu;
    }
}

void hysgen_board_store_erase(board_t *board, uint32_t slot)
{
    (void)board;
    (void)slot;
}

uint32_t hysgen_board_store_write(board_t *board, uint32_t slot, uint32_t offset, const uint8_t *bytes, uint32_t count)
{
    (void)board;
    (void)slot;
    (void)offset;
    (void)bytes;
    (void)count;
    return 0u;
}
