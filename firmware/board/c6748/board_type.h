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

#define BOARD_TIMER_HZ         24000000u    /* Timer64P0 runs from the oscillator */
#define BOARD_PERIOD           480u         /* of it in 20 us */
#define BOARD_PERIOD_NS        20000u       /* the same; must be the model's sampling period */

#define BOARD_LINE             256u         /* bytes between two calls of board_receive, a power of two */
#define BOARD_REFERENCES       1024u        /* length of the periodic reference, a power of two */

typedef struct {
    float reference_um[BOARD_REFERENCES];   /* fill in, or replace board_reference_um by your own source */
    uint32_t next;
    volatile uint8_t line[BOARD_LINE];      /* bytes of parameter images between board_link and board_receive */
    volatile uint32_t line_in;              /* bytes put in since board_start; wraps */
    volatile uint32_t line_start;           /* line_in at the beginning of the newest image */
    volatile uint32_t line_begins;          /* images begun; wraps; written after line_start */
    volatile uint32_t line_out;             /* bytes taken out; wraps */
    uint32_t line_begun;                    /* line_begins at the last board_receive */
    uint32_t line_broken;                   /* board_link lost a byte; nothing is taken before the next image begins */
} board_t;

/* For the interrupt of your link: one byte of an image arrived; begins: 1 if it is the first of an image. A byte that finds the
 * line full breaks the image: the rest is dropped until the next one begins, and what is left is never a whole image. */
void board_link(board_t *board, uint8_t byte, uint32_t begins);

/* Cycle counter, timer and interrupt: 50 kHz from here on. */
void board_start(board_t *board);

#endif
