/* store.h: two slots of parameter images in memory that survives power off. One of them is always good.
 *
 * A slot holds an image and, SEAL_OFFSET bytes on, its seal: magic, sequence number, CRC-32 of the image, CRC-32 of
 * these three words. Writing goes to the slot that is not in use: erase, image, read back, seal. Whatever byte the power
 * fails at, that slot has no valid seal or a whole image, and the other slot is as it was. */

#ifndef STORE_H
#define STORE_H

#include <stdint.h>

#include "board.h"
#include "image.h"
#include "linkage.h"

LINKAGE_BEGIN

#define STORE_SEAL_OFFSET  (BOARD_SLOT_BYTES - 16u)
#define STORE_SEAL_MAGIC   0x4C414553u
#define STORE_NONE         0xFFFFFFFFu

typedef struct {
    uint8_t bytes[IMAGE_BYTES];  /* image being looked at, or written */
    uint32_t slot;               /* in use, or STORE_NONE: the numbers that the firmware was built with */
    uint32_t sequence;           /* of the newest sealed image, good or not */
    uint32_t counter;            /* largest of an authentic image, the one in use or one for another build; 0: none */
    const image_owner_t *owner;  /* whose images are taken */
    uint32_t answer;             /* of the image that was looked at last */
} store_t;

/* Look for the newest image that is whole, right and certified, and put its numbers into *bank; leaves *bank alone if
 * there is none. Returns 1 if a sealed image was found that was not good. */
uint32_t hysgen_store_load(store_t *self, board_t *board, const image_owner_t *owner, image_bench_t *bench, bank_t *bank);

/* Check the image in self->bytes, write it to the slot that is not in use, and put its numbers into *bank. An image equal to
 * the one in use is not written again: erasing wears the memory. Any other needs a larger counter than the one in use, so that nobody
 * brings an old image back. Returns
 * IMAGE_GOOD, or why not: then neither the slot in use nor *bank has changed. */
uint32_t hysgen_store_keep(store_t *self, board_t *board, image_bench_t *bench, bank_t *bank, uint32_t count);

LINKAGE_END

#endif
