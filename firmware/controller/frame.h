/* frame.h: frames on a line of bytes that may lose, change and invent some.
 *
 *     COBS(payload, CRC-32 of the payload, low byte first) 0x00
 *
 * Consistent overhead byte stuffing (Cheshire and Baker, 1999) leaves no zero inside a frame: whatever happened before, a receiver
 * is in step again behind the next zero. A frame whose CRC does not fit is dropped without an answer. */

#ifndef FRAME_H
#define FRAME_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

#define FRAME_PAYLOAD  128u                   /* longest payload, bytes */
#define FRAME_BYTES    (FRAME_PAYLOAD + 4u)   /* with its CRC; below 254, where COBS needs a second code byte */
#define FRAME_WIRE     (FRAME_BYTES + 2u)     /* the same on the line */

typedef struct {
    uint8_t bytes[FRAME_BYTES];
    uint32_t count;   /* bytes of the frame that arrived */
    uint32_t left;    /* bytes until the next code byte */
    uint32_t zero;    /* the next code byte stands for a zero */
    uint32_t broken;  /* more bytes than a frame has: nothing is taken before the next zero */
} frame_t;

void hysgen_frame_init(frame_t *self);

/* A byte from the line. Returns the length of the payload in self->bytes if it ended a good frame, else 0. The payload stays
 * until the next call. */
uint32_t hysgen_frame_take(frame_t *self, uint8_t byte);

/* The frame of `count` bytes, at most FRAME_PAYLOAD, in `wire`; returns its length on the line. */
uint32_t hysgen_frame_make(const uint8_t *payload, uint32_t count, uint8_t wire[FRAME_WIRE]);

LINKAGE_END

#endif
