#include "integrity.h"

#include "bytes.h"

/* Takes the next words of the code into the round. */
static void integrity_take(integrity_t *self)
{
    uint32_t partial = self->partial;
    uint32_t at = self->at;

    for (uint32_t i = 0u; i < INTEGRITY_WORDS; ++i) {
        if (at < self->code.count) {
            partial = bytes_check(partial, self->code.words[at]);
            at += 1u;
        }
    }
    self->partial = partial;
    self->at = at;
}

void hysgen_integrity_init(integrity_t *self, board_t *board)
{
    self->code = hysgen_board_code(board);
    self->stack = hysgen_board_stack(board);
    self->partial = 1u;
    self->at = 0u;
    while (self->at < self->code.count) {
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
    if (self->at >= self->code.count) {
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
