#include "store.h"

#include "bank.h"
#include "crc32.h"

#define SEAL_BYTES 16u

static void store_put(uint8_t *bytes, uint32_t i, uint32_t word)
{
    bytes[4u * i] = (uint8_t)(word & 0xFFu);
    bytes[4u * i + 1u] = (uint8_t)((word >> 8) & 0xFFu);
    bytes[4u * i + 2u] = (uint8_t)((word >> 16) & 0xFFu);
    bytes[4u * i + 3u] = (uint8_t)((word >> 24) & 0xFFu);
}

/* 1 and the sequence number if the seal of `slot` is valid and belongs to the image in self->bytes. */
static uint32_t store_seals(const store_t *self, board_t *board, uint32_t slot, uint32_t *sequence)
{
    uint8_t seal[SEAL_BYTES];

    board_store_read(board, slot, STORE_SEAL_OFFSET, seal, SEAL_BYTES);
    *sequence = image_word(seal, 1u);
    return (uint32_t)(image_word(seal, 0u) == STORE_SEAL_MAGIC)
        & (uint32_t)(image_word(seal, 3u) == crc32(seal, SEAL_BYTES - 4u))
        & (uint32_t)(image_word(seal, 2u) == image_word(self->bytes, IMAGE_WORDS - 1u));
}

/* Read slot into self->bytes. Returns 1 and its sequence number if its seal is valid and belongs to that image. */
static uint32_t store_sealed(store_t *self, board_t *board, uint32_t slot, uint32_t *sequence)
{
    board_store_read(board, slot, 0u, self->bytes, IMAGE_BYTES);
    return store_seals(self, board, slot, sequence);
}

/* 1 if the slot in use holds the image in self->bytes, byte for byte, with a valid seal. */
static uint32_t store_holds(const store_t *self, board_t *board)
{
    uint32_t same = 1u;
    uint32_t sequence;
    uint8_t word[4];

    if (self->slot == STORE_NONE) {
        return 0u;
    }
    for (uint32_t at = 0u; at < IMAGE_BYTES; at += 4u) {
        board_store_read(board, self->slot, at, word, 4u);
        same &= (uint32_t)(image_word(word, 0u) == image_word(&self->bytes[at], 0u));
    }
    return same & store_seals(self, board, self->slot, &sequence);
}

/* 1 if sequence number a is newer than b; they may wrap. */
static uint32_t store_newer(uint32_t a, uint32_t b)
{
    return (uint32_t)(((a - b) & 0x80000000u) == 0u) & (uint32_t)(a != b);
}

static uint32_t store_judge(store_t *self, image_bench_t *bench, model_bank_t *bank, uint32_t count)
{
    self->answer = image_check(self->bytes, count);
    if (self->answer == IMAGE_GOOD) {
        self->answer = image_certify(self->bytes, bench, bank);
    }
    return self->answer;
}

uint32_t store_load(store_t *self, board_t *board, image_bench_t *bench, model_bank_t *bank)
{
    uint32_t sequence[BOARD_SLOTS];
    uint32_t sealed[BOARD_SLOTS];
    uint32_t found = STORE_NONE;
    uint32_t first;
    uint32_t bad = 0u;

    self->slot = STORE_NONE;
    self->sequence = 0u;
    self->answer = IMAGE_GOOD;
    for (uint32_t slot = 0u; slot < BOARD_SLOTS; ++slot) {
        sealed[slot] = store_sealed(self, board, slot, &sequence[slot]);
    }
    first = (uint32_t)((sealed[0] == 0u) | ((sealed[1] != 0u) & (store_newer(sequence[1], sequence[0]) != 0u)));
    for (uint32_t i = 0u; i < BOARD_SLOTS; ++i) {
        const uint32_t slot = (i == 0u) ? first : 1u - first;

        if ((found == STORE_NONE) & (sealed[slot] != 0u)) {
            (void)store_sealed(self, board, slot, &sequence[slot]);
            if (store_judge(self, bench, bank, IMAGE_BYTES) == IMAGE_GOOD) {
                found = slot;
                self->sequence = sequence[slot];
            } else {
                bad = 1u;
            }
        }
    }
    self->slot = found;
    return bad;
}

uint32_t store_keep(store_t *self, board_t *board, image_bench_t *bench, model_bank_t *bank, uint32_t count)
{
    const uint32_t slot = (self->slot == 0u) ? 1u : 0u;
    const uint32_t crc = image_word(self->bytes, IMAGE_WORDS - 1u);
    const uint32_t next = self->sequence + 1u;
    uint8_t seal[SEAL_BYTES];
    model_bank_t good;
    uint32_t sequence;

    if (store_judge(self, bench, &good, count) != IMAGE_GOOD) {
        return self->answer;
    }
    if (store_holds(self, board) != 0u) {
        bank_copy(bank, &good);
        return IMAGE_GOOD;
    }
    store_put(seal, 0u, STORE_SEAL_MAGIC);
    store_put(seal, 1u, next);
    store_put(seal, 2u, crc);
    store_put(seal, 3u, crc32(seal, SEAL_BYTES - 4u));
    board_store_erase(board, slot);
    if (board_store_write(board, slot, 0u, self->bytes, IMAGE_BYTES) == 0u) {
        self->answer = IMAGE_NOT_STORED;
        return self->answer;
    }
    board_store_read(board, slot, 0u, self->bytes, IMAGE_BYTES);
    self->answer = image_check(self->bytes, IMAGE_BYTES);
    if (self->answer != IMAGE_GOOD) {
        return self->answer;
    }
    (void)board_store_write(board, slot, STORE_SEAL_OFFSET, seal, SEAL_BYTES);
    if ((store_sealed(self, board, slot, &sequence) == 0u) | (sequence != next)) {
        self->answer = IMAGE_DAMAGED;
        return self->answer;
    }
    self->slot = slot;
    self->sequence = next;
    bank_copy(bank, &good);
    return IMAGE_GOOD;
}
