/* integrity.h: what nothing may change while the firmware runs: its code, constants and settings, and the far end of its stack.
 *
 * Boot takes the check word of code, constants, the key among them, and settings, right behind the self-test. From then on the idle loop
 * takes it again, INTEGRITY_WORDS words a sample, and compares it at the end of each round. The stack was filled with BOARD_STACK_FILL:
 * its first INTEGRITY_GUARD words must stay so, and as many words in a row from there on as still are were never used. */

#ifndef INTEGRITY_H
#define INTEGRITY_H

#include <stdint.h>

#include "board.h"
#include "linkage.h"
#include "settings.h"

LINKAGE_BEGIN

#define INTEGRITY_WORDS  8u  /* of the code, and of the stack, that a step reads */
#define INTEGRITY_GUARD  2u  /* words of the stack that are never used */

typedef struct {
    board_span_t code;
    const settings_t *settings;
    uint32_t words;        /* of both; */
    uint32_t check;        /* their check word at boot, */
    uint32_t partial;      /* that of the round under way, */
    uint32_t at;           /* and the words that are in it */
    board_span_t stack;
    uint32_t looked;       /* words of the stack of which this round knows that they were not used */
    uint32_t unused;       /* words of the stack that were not used up to the round before */
} integrity_t;

void hysgen_integrity_init(integrity_t *self, board_t *board, const settings_t *settings);

/* Part of a round; 2 INTEGRITY_WORDS + INTEGRITY_GUARD words are read at most. Returns 1 if code or stack is not what it was. */
uint32_t hysgen_integrity_step(integrity_t *self);

LINKAGE_END

#endif
