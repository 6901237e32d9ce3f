#include "integrity.h"

#include "bytes.h"

/* Takes the next words of code and settings into the round. */
static void integrity_take(integrity_t *self)
{
    uint32_t partial = self->partial;
    uint32_t at = self->at;

    for (uint32_t i = 0u; i < INTEGRITY_WORDS; ++i) {
        if (at < self->words) {
            const uint32_t code = self->code.count;

            partial = bytes_check(partial, (at < code) ? self->code.words[at] : hysgen_settings_word(self->settings, at - code));
            at += 1u;
        }
    }
    self->partial = partial;
    self->at = at;
}

void hysgen_integrity_init(integrity_t *self, board_t *board, const settings_t *settings)
{
    self->code = hysgen_board_code(board);
    self->settings = settings;
    self->words = self->code.count + SETTINGS_WORDS;
    self->stack = hysgen_board_stack(board);
    self->partial = 1u;
    self->at = 0u;
    while (self->at < self->words) {
        integrity_take(self);
    }
    self->check = self->partial;
    self->partial = 1u;
    self->at = 0u;
    self->looked = 0u;
    self->unused = self->stack.count;
}

/* [S14] */
uint32_t hysgen_integrity_step(integrity_t *self)
{
    uint32_t looked = self->looked;
    uint32_t damaged = 0u;
    uint32_t ends = 0u;

    integrity_take(self);
    if (self->at >= self->words) {
        damaged = (uint32_t)(self->partial != self->check);
        self->partial = 1u;
        self->at = 0u;
    }
    for (uint32_t i = 0u; (i < INTEGRITY_GUARD) && (i < self->stack.count); ++i) {
        damaged |= (uint32_t)(self->stack.words[i] != BOARD_STACK_FILL);
    }
    for (uint32_t i = 0u; i < INTEGRITY_WORDS; ++i) {
        if ((looked < self->stack.count) && (self->stack.words[looked] == BOARD_STACK_FILL)) {
            looked += 1u;
        } else {
            ends = 1u;
        }
    }
    self->unused = (ends != 0u) ? looked : self->unused;
    self->looked = (ends != 0u) ? 0u : looked;
    return damaged;
}
