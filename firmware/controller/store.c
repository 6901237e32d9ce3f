#include "store.h"

#include "bank.h"
#include "bytes.h"
#include "crc32.h"

#define SEAL_BYTES 16u

/* 1 and the sequence number if the seal of `slot` is valid and belongs to the image in self->bytes. */
static uint32_t store_seals(const store_t *self, board_t *board, uint32_t slot, uint32_t *sequence)
{
    uint8_t seal[SEAL_BYTES];

    hysgen_board_store_read(board, slot, STORE_SEAL_OFFSET, seal, SEAL_BYTES);
    *sequence = hysgen_image_word(seal, 1u);
    return (uint32_t)(hysgen_image_word(seal, 0u) == STORE_SEAL_MAGIC)
        & (uint32_t)(hysgen_image_word(seal, 3u) == hysgen_crc32(seal, SEAL_BYTES - 4u))
        & (uint32_t)(hysgen_image_word(seal, 2u) == hysgen_image_word(self->bytes, IMAGE_CRC));
}

/* Read slot into self->bytes. Returns 1 and its sequence number if its seal is valid and belongs to that image. */
static uint32_t store_sealed(store_t *self, board_t *board, uint32_t slot, uint32_t *sequence)
{
    hysgen_board_store_read(board, slot, 0u, self->bytes, IMAGE_BYTES);
    return store_seals(self, board, slot, sequence);
}

#define STORE_OTHER  0u  /* other bytes, or no slot in use */
#define STORE_OPEN   1u  /* the same bytes, without a valid seal */
#define STORE_SEALED 2u

/* What the slot in use holds, compared with the image in self->bytes. */
static uint32_t store_holds(const store_t *self, board_t *board)
{
    const uint32_t slot = self->slot;
    uint32_t held = STORE_OTHER;

    if (slot < BOARD_SLOTS) {
        uint32_t same = 1u;
        uint32_t sequence;
        uint8_t word[4];

        for (uint32_t at = 0u; (at < IMAGE_BYTES) && (same != 0u); at += 4u) {
            hysgen_board_store_read(board, slot, at, word, 4u);
            same = (uint32_t)(bytes_word(word) == bytes_word(&self->bytes[at]));
        }
        if (same != 0u) {
            held = STORE_OPEN;
            if (store_seals(self, board, slot, &sequence) != 0u) {
                held = STORE_SEALED;
            }
        }
    }
    return held;
}

/* 1 if sequence number a is newer than b; they may wrap. */
static uint32_t store_newer(uint32_t a, uint32_t b)
{
    return (uint32_t)(((a - b) & 0x80000000u) == 0u) & (uint32_t)(a != b);
}

static uint32_t store_judge(store_t *self, image_bench_t *bench, bank_t *bank, uint32_t count)
{
    self->answer = hysgen_image_check(self->bytes, count, self->owner);
    if (self->answer == IMAGE_GOOD) {
        self->answer = hysgen_image_certify(self->bytes, bench, bank);
    }
    return self->answer;
}

/* 1 if an image with this answer of store_judge is the owner's for this device, though perhaps of another build, or uncertified. */
static uint32_t store_authentic(uint32_t answer)
{
    return (uint32_t)(answer == IMAGE_GOOD) | (uint32_t)(answer == IMAGE_OTHER_BUILD) | (uint32_t)(answer == IMAGE_NO_NUMBER)
        | (uint32_t)(answer == IMAGE_RISKY)        | ((uint32_t)(answer > IMAGE_UNCERTIFIED) & (uint32_t)(answer < IMAGE_FORGED));
}

uint32_t hysgen_store_load(store_t *self, board_t *board, const image_owner_t *owner, image_bench_t *bench, bank_t *bank)
{
    uint32_t sequence[BOARD_SLOTS];
    uint32_t sealed[BOARD_SLOTS];
    uint32_t found = STORE_NONE;
    uint32_t first;
    uint32_t bad = 0u;

    self->slot = STORE_NONE;
    self->counter = 0u;
    self->owner = owner;
    self->answer = IMAGE_GOOD;
    for (uint32_t slot = 0u; slot < BOARD_SLOTS; ++slot) {
        sealed[slot] = store_sealed(self, board, slot, &sequence[slot]);
    }
    first = (uint32_t)((sealed[0] == 0u) || ((sealed[1] != 0u) && (store_newer(sequence[1], sequence[0]) != 0u)));
    self->sequence = (sealed[first] != 0u) ? sequence[first] : 0u;
    for (uint32_t i = 0u; i < BOARD_SLOTS; ++i) {
        const uint32_t slot = (i == 0u) ? first : 1u - first;

        if ((found == STORE_NONE) && (sealed[slot] != 0u) && (store_sealed(self, board, slot, &sequence[slot]) != 0u)) {
            const uint32_t answer = store_judge(self, bench, bank, IMAGE_BYTES);
            const uint32_t counter = hysgen_image_word(self->bytes, IMAGE_COUNTER);

            if ((store_authentic(answer) != 0u) && (counter > self->counter)) {
                self->counter = counter;
            }
            if (answer == IMAGE_GOOD) {
                found = slot;
            } else {
                bad = 1u;
            }
        }
    }
    self->slot = found;
    return bad;
}

/* Write the image in self->bytes to the slot that is not in use, and seal it; both are read back. [S10] */
static uint32_t store_write(store_t *self, board_t *board)
{
    const uint32_t slot = (uint32_t)(self->slot == 0u);
    const uint32_t crc = hysgen_image_word(self->bytes, IMAGE_CRC);
    const uint32_t counter = hysgen_image_word(self->bytes, IMAGE_COUNTER);
    const uint32_t next = self->sequence + 1u;
    uint8_t seal[SEAL_BYTES];
    uint32_t sequence;
    uint32_t answer = IMAGE_NOT_STORED;

    bytes_put(&seal[0], STORE_SEAL_MAGIC);
    bytes_put(&seal[4], next);
    bytes_put(&seal[8], crc);
    bytes_put(&seal[12], hysgen_crc32(seal, SEAL_BYTES - 4u));
    hysgen_board_store_erase(board, slot);
    if (hysgen_board_store_write(board, slot, 0u, self->bytes, IMAGE_BYTES) != 0u) {
        hysgen_board_store_read(board, slot, 0u, self->bytes, IMAGE_BYTES);
        answer = hysgen_image_check(self->bytes, IMAGE_BYTES, self->owner);
    }
    if (answer == IMAGE_GOOD) {
        (void)hysgen_board_store_write(board, slot, STORE_SEAL_OFFSET, seal, SEAL_BYTES);
        if ((store_sealed(self, board, slot, &sequence) == 0u) || (sequence != next)) {
            answer = IMAGE_DAMAGED;
        }
    }
    if (answer == IMAGE_GOOD) {
        self->slot = slot;
        self->sequence = next;
        self->counter = counter;
    }
    return answer;
}

uint32_t hysgen_store_keep(store_t *self, board_t *board, image_bench_t *bench, bank_t *bank, uint32_t count)
{
    bank_t good;

    hysgen_bank_copy(&good, bank);
    if (store_judge(self, bench, &good, count) == IMAGE_GOOD) {
        const uint32_t held = store_holds(self, board);

        const uint32_t rise = hysgen_image_word(self->bytes, IMAGE_COUNTER) - self->counter;

        if ((held == STORE_OTHER) && ((rise == 0u) || (rise > IMAGE_STRIDE))) {
            self->answer = IMAGE_REPLAYED;
        } else if (held != STORE_SEALED) {
            self->answer = store_write(self, board);
        } else {
            /* In use, and sealed. */
        }
    }
    if (self->answer == IMAGE_GOOD) {
        hysgen_bank_copy(bank, &good);
    }
    return self->answer;
}
