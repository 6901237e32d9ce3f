/* trace.h: the last samples around a fault, to be read over the link. A ring that stops TRACE_BEHIND samples behind the first fault. */

#ifndef TRACE_H
#define TRACE_H

#include <stdint.h>

#define TRACE_SAMPLES 1024u  /* a power of two: 20 ms */
#define TRACE_BEHIND  256u
#define TRACE_WORDS   4u     /* reading as it came [um], voltage that was put out [V], reference [um], state */

typedef struct {
    uint32_t words[TRACE_WORDS * TRACE_SAMPLES];  /* float32 as its bits */
    uint32_t count;                               /* samples since the last CLEAR at rest; behind 2^32 - 1 comes TRACE_SAMPLES */
    uint32_t left;                                /* samples behind the first fault that are still to come */
} trace_t;

#endif
