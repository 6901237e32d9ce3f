/* board_type.h: the C6748's board. What is said here of registers comes from TI's SPRUH79 (TRM) and SPRUFE8 (C674x CPU);
 * none of it ran on silicon. Lines marked "fill in" are your hardware's. */

#ifndef BOARD_TYPE_H
#define BOARD_TYPE_H

#include <stdint.h>

/* Fill in: converters on the EMIFA bus, 16-bit A/D and 20-bit D/A, and the pins of the amplifier. */
#define BOARD_ADC_ADDRESS      0x60000000u  /* chip select 2: one 16-bit word, offset binary */
#define BOARD_DAC_ADDRESS      0x62000000u  /* chip select 3: one 32-bit word, offset binary, right-aligned */
#define BOARD_AMPLIFIER_PINS   0x01E26020u  /* GPIO banks 0 and 1, IN_DATA: bit 0 limit, bit 1 fault, both active high */
#define BOARD_ADC_LOW_UM       -3.276f
#define BOARD_ADC_STEP_UM      0.00025f
#define BOARD_DAC_LOW_V        -20.0f
#define BOARD_DAC_PER_V        7489.82857f  /* 2^20 codes over 140 V */
#define BOARD_DAC_CODES        1048575.0f

#define BOARD_CLOCK_HZ         375000000u
#define BOARD_TIMER_HZ         24000000u    /* Timer64P0 runs from the oscillator */
#define BOARD_PERIOD           480u         /* of it in 20 us */

#define BOARD_REFERENCES       1024u        /* length of the periodic reference, a power of two */

typedef struct {
    float reference_um[BOARD_REFERENCES];   /* fill in, or replace board_reference_um by your own source */
    uint32_t next;
    volatile uint8_t line[256];             /* bytes of a parameter image that a link's interrupt puts here */
    volatile uint32_t line_in;
    uint32_t line_out;
    volatile uint32_t line_begins;
} board_t;

/* Cycle counter, timer and interrupt: 50 kHz from here on. */
void board_start(board_t *board);

#endif
