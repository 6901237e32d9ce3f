/* play.h: open-loop play of a table of voltages, recording the readings in its place.
 *
 * One word of 16 bits a sample, in memory of the board: before the sample its voltage, behind it its reading. Reading and voltage of a word
 * are those of one interrupt: y(k) read, then u(k) put out. Codes are those of converters over the board's ranges:
 *
 *     u = BOARD_LOW_V + code (BOARD_HIGH_V - BOARD_LOW_V) / 65535
 *     y = BOARD_LOW_UM + code (BOARD_HIGH_UM - BOARD_LOW_UM) / 65535, code PLAY_NONE: the reading was none */

#ifndef PLAY_H
#define PLAY_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

#define PLAY_NONE 0u

typedef struct {
    volatile uint16_t *words;  /* BOARD_RECORD of them */
    uint32_t loaded;           /* words of a table that arrived in order; 0 once it is played: it is a record then */
    uint32_t count;            /* words of the table that is played, */
    volatile uint32_t done;    /* and how many of them were */
} play_t;

void hysgen_play_init(play_t *self, volatile uint16_t *words);

/* Voltage [V] of word k. */
float hysgen_play_voltage(const play_t *self, uint32_t k);

/* The next word becomes its reading [um], which may be NaN. */
void hysgen_play_record(play_t *self, float y_um);

LINKAGE_END

#endif
