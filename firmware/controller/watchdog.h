/* watchdog.h: is what comes in believable, does the stage do what the model says, is there time left? */

#ifndef WATCHDOG_H
#define WATCHDOG_H

#include <stdint.h>

#include "linkage.h"
#include "settings.h"

LINKAGE_BEGIN

/* A leaky count: +1 per bad sample, -1 per WATCHDOG_LEAK good ones. With 8, a lasting share of bad samples above one in
 * nine reaches any limit, in whatever pattern they come, while seven bad samples in a row are forgotten after 56 good
 * ones (1.1 ms): sparse noise never adds up, and feedback and learner have at least 8 of 9 readings. */
#define WATCHDOG_LEAK 8u

/* Readings that are none, amplifier limits or late samples, and samples in which the stage does not follow, until they are a fault. */
#define WATCHDOG_BAD    8u
#define WATCHDOG_ASTRAY 50u

/* Samples for which a reading repeats itself at least until it counts as stuck: more than delay and lag of a stage, so that a jump of the
 * input does not count before the sensor can have seen it. */
#define WATCHDOG_STUCK 64u

/* The same reading to the last bit is a fault once the input has moved this far: the stage moves by less than the bound of
 * hysgen_watchdog_judge then. */
#define WATCHDOG_STUCK_V ((MODEL_U_MAX_V - MODEL_U_MIN_V) * 0.015625f)

/* Change of a reading per sample beyond which it is none, as a share of the model's range. The largest step_V is a sixteenth of the
 * model's inputs: a stage whose slope is twice the mean one, and that has no lag at all, moves as far. A reading as far from the last
 * good one that the next reading inside the range confirms is taken: the stage is there. */
#define WATCHDOG_JUMP_SHARE 0.125f

/* Reading and model of START may differ by this share of the model's range, creep and drift behind START among them, and by so many times
 * the error that the model had at START, at the slow ramp: the reference may move faster, up to 4 times without a reason to trip. */
#define WATCHDOG_FOLLOW_SHARE  0.02f
#define WATCHDOG_FOLLOW_ERRORS 4.0f
#define WATCHDOG_FOLLOW_MOST   0.16f  /* of the range: with a model that is worse the guard still acts */

/* Bad samples of the amplifier's failure until it counts: 60 us of a broken wire, not a spike on it. */
#define WATCHDOG_DEBOUNCE 3u

typedef struct {
    uint32_t bad;            /* the count */
    uint32_t good;           /* good samples since it last fell */
} watchdog_count_t;

typedef struct {
    float reading_um;        /* last reading that was one */
    float sample_um;         /* the reading of this sample, NaN where it was none */
    float raw_um;            /* the reading as it came, of the sample before at first */
    float seen_um;           /* the last reading inside the range, a jump or not; NaN at first */
    watchdog_count_t unread; /* readings that were none */
    float same_V;            /* input when the reading last changed, */
    uint32_t same;           /* and samples since then */
    float follow_um;         /* largest difference of reading and model, see hysgen_watchdog_judge */
    watchdog_count_t astray; /* samples in which the stage did not follow */
    watchdog_count_t limits; /* samples with the amplifier at its limit */
    watchdog_count_t failed; /* samples with the amplifier failed */
    watchdog_count_t late;   /* interrupts that took too long */
} watchdog_t;

void hysgen_watchdog_init(watchdog_t *self, const settings_t *settings);

/* A reading [um] that came while the input was u_V. self->reading_um is the reading that control uses, the last good one
 * where this one is none; self->sample_um is NaN there, so that a learner rejects the sample. Returns STATUS_ bits. */
uint32_t hysgen_watchdog_reading(watchdog_t *self, float y_um, float u_V);

/* From here on the stage follows a model whose own error is error_um: within follow_um of the settings, or, where that is 0, within what
 * the error says. */
void hysgen_watchdog_judge(watchdog_t *self, const settings_t *settings, float error_um);

/* The reading against what the model expected of this sample. Returns STATUS_ bits. */
uint32_t hysgen_watchdog_follow(watchdog_t *self, float expected_um);

/* BOARD_AMPLIFIER_ bits of this sample. Returns STATUS_ bits. */
uint32_t hysgen_watchdog_amplifier(watchdog_t *self, uint32_t amplifier);

/* Cycles that the interrupt took, and whether it overran. Returns STATUS_ bits. */
uint32_t hysgen_watchdog_time(watchdog_t *self, uint32_t cycles, uint32_t overrun);

LINKAGE_END

#endif
