#include "play.h"

#include "board.h"
#include "number.h"

#define PLAY_CODES  65535.0f
#define PLAY_V      ((BOARD_HIGH_V - BOARD_LOW_V) / PLAY_CODES)
#define PLAY_PER_UM (PLAY_CODES / (BOARD_HIGH_UM - BOARD_LOW_UM))

void hysgen_play_init(play_t *self, volatile uint16_t *words)
{
    self->words = words;
    self->loaded = 0u;
    self->count = 0u;
    self->done = 0u;
}

float hysgen_play_voltage(const play_t *self, uint32_t k)
{
    return BOARD_LOW_V + PLAY_V * (float)self->words[k & (BOARD_RECORD - 1u)];
}

void hysgen_play_record(play_t *self, float y_um)
{
    /* Behind 2^23 the low bits of the sum are the nearest whole number: no conversion, which NaN would make undefined. */
    const float code = number_limited((y_um - BOARD_LOW_UM) * PLAY_PER_UM, 1.0f, PLAY_CODES);
    const uint32_t nearest = number_bits(code + 8388608.0f) & 0xFFFFu;

    self->words[self->done & (BOARD_RECORD - 1u)] = (uint16_t)((number_finite(y_um) != 0u) ? nearest : PLAY_NONE);
    self->done += 1u;
}
