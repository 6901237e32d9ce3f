/* board_type.h: the host's board. A plant in place of stage and converters, arrays in place of reference and store, and
 * faults that a test switches on. */

#ifndef BOARD_TYPE_H
#define BOARD_TYPE_H

#include <stdint.h>

#define HOST_FAULT_NONE       0u
#define HOST_FAULT_STUCK      1u  /* the sensor repeats its reading */
#define HOST_FAULT_READING    2u  /* the sensor gives `fault_value` */
#define HOST_FAULT_SATURATED  3u  /* the amplifier passes at most `fault_value` volts on, and does not tell */
#define HOST_FAULT_LIMITS     4u  /* the amplifier tells that it is at its limit */
#define HOST_FAULT_AMPLIFIER  5u  /* the amplifier tells that it failed */
#define HOST_FAULT_LATE       6u  /* interrupts take `fault_value` cycles */
#define HOST_FAULT_OVERRUN    7u  /* the next interrupt waits already */
#define HOST_FAULT_LOST       8u  /* `fault_value` cycles pass between interrupts */
#define HOST_FAULT_STOPPED    9u  /* the stop input asks */

/* Of the converters: settings beyond them are refused. */
#define BOARD_LOW_V            -20.0f
#define BOARD_HIGH_V           120.0f
#define BOARD_SAFE_V           0.0f         /* put out while settings are refused, whatever they say */
#define BOARD_LOW_UM           -3.276f      /* a reading at a rail of the A/D is none */
#define BOARD_HIGH_UM          13.1077f
#define BOARD_RECORD           65536u
#define BOARD_PERIOD_CYCLES    7500u

#define HOST_NO_CUT 0xFFFFFFFFu
#define HOST_LINE   512u  /* bytes from the firmware until the test takes them */

typedef struct board {
    double (*step)(void *plant, double u_V);  /* holds u_V for a period, returns the reading at its end */
    void *plant;
    const float *reference_um;  /* one per sample */
    uint32_t sample;
    float reading_um;
    float output_V;             /* as the D/A has it */
    float applied_V;            /* as the amplifier passes it on */
    float zero_um;              /* calibration of both converters, see board.h */
    float gain_um;
    float zero_V;
    float gain_V;

    uint32_t fault;
    uint32_t fault_from;        /* first sample of the fault, */
    uint32_t fault_until;       /* first sample after it */
    uint32_t fault_period;      /* in between it acts on the first `fault_length` samples of every so many; 0: on all */
    uint32_t fault_length;
    float fault_value;
    uint32_t cycles;

    const uint8_t *incoming;    /* bytes on the line to the firmware, */
    uint32_t incoming_count;
    uint8_t outgoing[512];      /* and from it */
    uint32_t outgoing_count;
    uint32_t served;            /* calls of hysgen_board_line_serve */
    uint32_t enabled;           /* the amplifier is switched on, */
    uint32_t enabled_for;       /* for so many samples; */
    uint32_t ready_after;       /* its OK pin is high from this number on, and low while it is off */
    uint32_t restarted;         /* the next boot is no power on */
    uint32_t kept[2];
    uint16_t record[BOARD_RECORD];
    uint32_t code[64];          /* in place of the image: what a test may change, */
    uint32_t stack[64];         /* and the stack; looked at from the first */
    uint32_t watched;           /* `watched` words on */
    uint32_t alive;             /* calls of hysgen_board_alive */
    uint8_t store[2][4096];
    void (*preempt)(void *with);  /* called while the store erases and after it has written, or NULL */
    uint32_t preempts_line;     /* and before each byte is read from the line */
    void *preempt_with;
    uint32_t bytes_to_cut;      /* bytes that the store still changes before the power fails, or HOST_NO_CUT */
} board_t;

#endif
