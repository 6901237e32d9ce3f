/* board_type.h: the C6748's board. Registers: the head of chip.c, and SPRUFE8 (C674x CPU);
 * none of it ran on silicon. Lines marked "fill in" are your hardware's. */

#ifndef BOARD_TYPE_H
#define BOARD_TYPE_H

#include <stdint.h>

#include "chip.h"
#include "linkage.h"

LINKAGE_BEGIN

/* Converters on the EMIFA bus, 16 bits each. On TI's LCDK chip select 3 is the NAND flash.
 *
 * Chip select 2: Analog Devices AD7606C-16 (or AD7606B, AD7606), hardware mode, parallel, +-10 V, no oversampling: the sensor on V1, CONVST
 * on TM64P0_OUT12, BUSY on GP0[3], RESET on GP0[4], RD on EMA_OE. Two's complement; the first read behind BUSY is V1, the second V2.
 * Chip select 3: Analog Devices AD5547 (or AD5546, one channel), four-quadrant, +-10 V: WR on EMA_CS3 or EMA_WE (both low), LDAC high, A0 and
 * A1 to select one channel. Offset binary.
 *
 * Strobes are 75 ns (read) and 53 ns (write), see EMIFA_BUS. Neither data sheet was seen. RESET as in Linux (drivers/iio/adc/ad7606.c: a pulse
 * of 100 ns and more), here 5 us, then 300 us until the first CONVST. */
#define BOARD_ADC_ADDRESS      0x60000000u
#define BOARD_DAC_ADDRESS      0x62000000u
#define BOARD_ADC_BUSY         0x00000008u  /* GP0[3], input: 1 while it converts */
#define BOARD_ADC_RESET        0x00000010u  /* GP0[4], output: RESET, once behind power on */
#define BOARD_ADC_POLLS        100u         /* looks at BUSY, some 30 cycles each, until a conversion counts as failed: the reading is NaN */

/* Fill in: scales and pins of the amplifier. */
/* The amplifier's pins, all with pull-downs: a broken wire or an amplifier without power reads as failure and switches it off. */
#define BOARD_AMPLIFIER_PINS   0x00000003u  /* GP0[0], input: 1 not at a limit; GP0[1], input: 1 no fault */
#define BOARD_AMPLIFIER_ENABLE 0x00000004u  /* GP0[2], output: 1 on */
#define BOARD_STOP_PIN         0u           /* none; GP0[5], a pull-down, 1 run: 0x20, and the pin in chip_pins of chip.c */
#define BOARD_OUTPUTS          (BOARD_AMPLIFIER_ENABLE | BOARD_ADC_RESET)
#define BOARD_ADC_ZERO_UM      4.916f       /* displacement at 0 V of the A/D */
#define BOARD_ADC_STEP_UM      0.00025f
#define BOARD_DAC_LOW_V        -20.0f
#define BOARD_DAC_PER_V        468.107143f  /* 65535 codes over 140 V: 2.1 mV */
#define BOARD_DAC_CODES        65535.0f
#define BOARD_READS_BACK       0            /* 1: the D/A is wired to V2 too, and is to put out what it was given, */
#define BOARD_READ_BACK_CODES  655u         /* to this many codes, 1 % of the range; else the amplifier counts as failed */
/* Of the converters: what they can put out and read; settings beyond that are refused. */
#define BOARD_LOW_V            BOARD_DAC_LOW_V
#define BOARD_HIGH_V           120.0f
#define BOARD_SAFE_V           0.0f         /* put out while settings are refused, whatever they say */
#define BOARD_LOW_UM           -3.276f      /* a reading at a rail of the A/D is none */
#define BOARD_HIGH_UM          13.1077f
#define BOARD_RECORD           65536u       /* words of the shared RAM, which is theirs: samples of a record */

#define BOARD_PERIOD           500u         /* ticks of the crystal in 20 us: CHIP_OSCILLATOR_HZ / 50000 */
#define BOARD_PERIOD_NS        20000u       /* the same; must be the model's sampling period */
#define BOARD_PERIOD_CYCLES    (BOARD_PERIOD * CHIP_MULTIPLIER)

#define BOARD_STACK            1792u        /* words of the stack that start-up fills, of 2048: the last KiB is in use then */

#define BOARD_LINE             256u         /* bytes between interrupt and idle loop each way, a power of two */
#define BOARD_REFERENCES       1024u        /* length of the periodic reference, a power of two */

/* Bytes between one writer and one reader, of which either may interrupt the other. */
typedef struct {
    volatile uint8_t bytes[BOARD_LINE];
    volatile uint32_t in;   /* bytes put in since hysgen_board_start; wraps */
    volatile uint32_t out;  /* bytes taken out; wraps */
} board_ring_t;

typedef struct {
    float reference_um[BOARD_REFERENCES];   /* fill in, or replace hysgen_board_reference_um by your own source */
    uint32_t next;
    float adc_zero_um;                      /* scales as calibrated */
    float adc_step_um;
    float dac_zero_V;
    float dac_gain;
    uint32_t written;                       /* code that the D/A was given last, */
    uint32_t read_back;                     /* and what V2 had at this interrupt */
    board_ring_t received;                  /* bytes from the line, in hysgen_board_line_serve to hysgen_board_line_read */
    board_ring_t sent;                      /* bytes to the line, from hysgen_board_line_write to hysgen_board_line_serve */
} board_t;

/* Cycle counter, timer and interrupt: 50 kHz from here on. */
void hysgen_board_start(board_t *board);

LINKAGE_END

#endif
