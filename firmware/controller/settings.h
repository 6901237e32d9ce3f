/* settings.h: the numbers of a stage and its amplifier that are not the model's. One const instance per board.
 *
 * "per sample" is one period of 20 us: 0.05 V per sample is 2500 V/s. */

#ifndef SETTINGS_H
#define SETTINGS_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

#define SETTINGS_LOOP   0x1u  /* the model's feedback; a model without one is driven by feed-forward alone */
#define SETTINGS_LEARN  0x2u  /* on-line learning, with commit */
#define SETTINGS_NO_OFFSET  0x8u  /* the offset of HOLD is held against offset_um, and not used: for a model without memory */
#define SETTINGS_KEEP   0x4u  /* the next start begins with the parameters that were committed last, not with those of the store */

typedef struct {
    uint32_t options;

    /* Output. It never leaves low_V .. high_V and never moves faster than step_V, in any state. */
    float off_V;    /* when off */
    float low_V;
    float high_V;
    float step_V;   /* largest change per sample */
    float ramp_V;   /* change per sample of start, stop and the way down after a fault; the reference is approached about as fast */

    /* Start: samples in a row in which the amplifier, switched on, tells no limit and no failure until the stage moves; */
    uint32_t power_samples;
    /* the loop from low over high to the middle that sets the hysteresis, inside the model's range; hold_samples of
     * rest, in which the offset between stage and model is taken; then the way to the reference. */
    float loop_low_V;
    float loop_high_V;
    uint32_t hold_samples;
    float offset_um;         /* largest offset of the stage from the model, either way */

    /* Longest time in POWER, RISE, LOOP, HOLD, APPROACH, FALL or TRIP, each. */
    uint32_t state_samples;

    /* Reference. */
    float reference_step_um;  /* largest change per sample */

    /* Watchdog, see watchdog.h. |reading - model|, with the parameters of START and without feedback, beyond which the stage does not follow. A sensor that fails while
     * feedback and learning follow it is told before the stage is this far from where it belongs, and the model's own error. 0: 2 % of the
     * model's range and 4 times the error that START found on the way back of LOOP and in HOLD. Either way 16 % of the range at most. */
    float follow_um;

    /* Calibration of the converters, against the scales that the board was built with; as built: 0, 1, 0, 1.
     * reading = reading_zero_um + reading_gain * as built; put out: output_zero_V + output_gain * voltage, as built. */
    float reading_zero_um;
    float reading_gain;
    float output_zero_V;
    float output_gain;
} settings_t;

#define SETTINGS_WORDS 18u  /* float32 and uint32_t */

/* Name of the first field that is not finite or must not run, or a null pointer. low_V .. high_V inside the board's, as calibrated too;
 * low_V < off_V, loop < high_V, the loop inside the model's range of inputs and a 64th of it wide at least; step_V at most a sixteenth of
 * that range; ramp_V at most step_V, and such that it crosses low_V .. high_V in state_samples, which are 10 minutes at most; HOLD long
 * enough for a mean; offset_um at most the model's range, follow_um 16 % of it; converters within 10 % of their scales, and 5 % of their ranges. */
const char *hysgen_settings_check(const settings_t *settings);

/* Word i of the settings, in the order above, for an image; and the other way. */
uint32_t hysgen_settings_word(const settings_t *settings, uint32_t i);
void hysgen_settings_put(settings_t *settings, uint32_t i, uint32_t word);

LINKAGE_END

#endif
