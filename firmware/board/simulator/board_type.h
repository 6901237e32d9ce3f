/* board_type.h: the board of the simulated C674x: no hardware, one sample at a time from the caller. */

#ifndef BOARD_TYPE_H
#define BOARD_TYPE_H

#include <stdint.h>

#define SIMULATED_LINE 256u  /* a power of two */

/* Of the converters: settings beyond them are refused. */
#define BOARD_LOW_V            -20.0f
#define BOARD_HIGH_V           120.0f
#define BOARD_SAFE_V           0.0f         /* put out while settings are refused, whatever they say */
#define BOARD_LOW_UM           -3.276f      /* a reading at a rail of the A/D is none */
#define BOARD_HIGH_UM          13.1077f
#define BOARD_RECORD           4096u
#define BOARD_PERIOD_CYCLES    7500u

typedef struct {
    float reading_um;
    float reference_um;
    float output_V;
    uint32_t kept[2];
    uint16_t record[BOARD_RECORD];
    uint32_t stack[64];           /* nobody's */
    uint32_t enabled;             /* the amplifier is switched on */
    uint8_t in[SIMULATED_LINE];   /* bytes on the line to the firmware, */
    uint32_t in_first;
    uint32_t in_last;
    uint8_t out[SIMULATED_LINE];  /* and from it */
    uint32_t out_first;
    uint32_t out_last;
} board_t;

#endif
