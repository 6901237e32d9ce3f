/* case.h: the state of one case of the fuzzer, and its random numbers. */

#ifndef CASE_H
#define CASE_H

#include <stdint.h>

#include "firmware.h"
#include "fuzz.h"
#include "number.h"

#define FUZZ_LINE 1024u

typedef struct {
    uint64_t random;
    uint32_t k;                /* interrupts of this case */
    uint32_t broken;           /* FUZZ_ bits of broken invariants */
    uint32_t refused;          /* hysgen_settings_check refused the settings */
    uint32_t kind;             /* of the reference */
    uint32_t apart;            /* interrupts in a row in which model and stage are apart and no fault is told */
    uint32_t tracked;          /* interrupts in TRACK with a sound sensor since START */
    uint32_t lied;             /* the sensor repeated or invented a believable reading since START */
    uint32_t calm;             /* interrupts per interrupt of a case without drift: events are rarer by as much */
    float drift;               /* of the sensor, from the first sample of TRACK on: per sample, */
    uint32_t drifts_offset;    /* in um, else a share of the displacement */
    uint32_t drifted;          /* samples of drift since START, 0: the sensor is sound */
    float wrong_um;            /* what the reading that waits is wrong by */
    uint32_t spoiled;          /* START did not begin with the built-in parameters, or a fault of the board came since */
    uint32_t untold;           /* interrupts in a row in which the drift is too large and no fault is told */
    uint32_t same_bits;        /* reading that changed last, */
    float same_V;              /* voltage then, or when the output last rested, */
    float taken_V;             /* and then, */
    uint32_t same;             /* and readings since then */
    uint32_t sent;             /* bit i: image i was sent whole since the store last acknowledged an image */
    uint32_t stored;           /* image that the store acknowledged last, FUZZ_IMAGES: none */
    uint32_t before;           /* state of the controller, its status word and CLEARs after the interrupt before */
    uint32_t status;
    uint32_t clears;
    uint32_t armed;            /* a START was taken since the controller was off */
    uint32_t locked;           /* a reset under power came, and no CLEAR since */
    uint32_t counter;          /* of the image that the store acknowledged last */
    model_t stage;
    board_t board;
    firmware_t firmware;
    settings_t settings;
    image_owner_t owner;
    bank_t built_in;
    float reference_um[1];
    uint8_t line[FUZZ_LINE];
} fuzz_t;

/* Images that a case may send, and the parameters in them. */
extern uint8_t fuzz_image[FUZZ_IMAGES][IMAGE_BYTES];
extern bank_t fuzz_bank[FUZZ_IMAGES];

static inline uint32_t fuzz_word(fuzz_t *self)
{
    self->random ^= self->random << 13;
    self->random ^= self->random >> 7;
    self->random ^= self->random << 17;
    return (uint32_t)(self->random >> 16);
}

static inline uint32_t fuzz_below(fuzz_t *self, uint32_t limit)
{
    return fuzz_word(self) % limit;
}

/* Uniform in low .. high. */
static inline float fuzz_float(fuzz_t *self, float low, float high)
{
    return low + (high - low) * (float)(fuzz_word(self) & 0xFFFFFFu) / 16777215.0f;
}

/* inputs.c */
void fuzz_settings(fuzz_t *self);
void fuzz_event(fuzz_t *self);
float fuzz_reference(fuzz_t *self);

/* preempt.c: call `hysgen_firmware_idle`, and `interrupt` before some of the accesses to memory that it makes. */
void fuzz_preempted_idle(fuzz_t *self, void (*interrupt)(fuzz_t *self));

#endif
