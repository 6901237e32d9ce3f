#include "settings.h"

#include <stddef.h>

#include "board.h"
#include "bytes.h"
#include "model.h"
#include "number.h"
#include "watchdog.h"

typedef struct {
    const char *field;
    float value;
    float low;
    float high;
} settings_range_t;

#define SETTINGS_LONGEST  30000000u  /* samples of a state: 10 minutes */

/* Converters against the scales that the board was built with: what is further away is a mistake, or a broken part. */
#define SETTINGS_GAIN  0.1f
#define SETTINGS_ZERO  0.05f  /* of the range */

#define SETTINGS_STEP_SHARE 0.0625f  /* of the model's inputs, see WATCHDOG_JUMP_SHARE */
#define SETTINGS_SHORTEST 64u        /* samples of HOLD: a mean of so many readings has an eighth of their noise */

uint32_t hysgen_settings_word(const settings_t *settings, uint32_t i)
{
    const uint8_t *bytes = (const uint8_t *)settings;

    return bytes_word(&bytes[4u * i]);
}

void hysgen_settings_put(settings_t *settings, uint32_t i, uint32_t word)
{
    uint8_t *bytes = (uint8_t *)settings;

    bytes_put(&bytes[4u * i], word);
}

/* [S3] */
const char *hysgen_settings_check(const settings_t *settings)
{
    const settings_t *s = settings;
    const float range_um = MODEL_Y_MAX_UM - MODEL_Y_MIN_UM;
    const float zero_um = SETTINGS_ZERO * (BOARD_HIGH_UM - BOARD_LOW_UM);
    const float zero_V = SETTINGS_ZERO * (BOARD_HIGH_V - BOARD_LOW_V);
    const float time = (float)s->state_samples;
    /* Smallest change that may count as one: smaller than any step of a converter, larger than 0. */
    const float least = 1.0e-9f;
    const float range_V = s->high_V - s->low_V;
    const float low_V = (s->low_V > MODEL_U_MIN_V) ? s->low_V : MODEL_U_MIN_V;
    const float high_V = (s->high_V < MODEL_U_MAX_V) ? s->high_V : MODEL_U_MAX_V;
    /* In this order: each row relies on the rows above it. */
    const settings_range_t ranges[] = {
        { "low_V", s->low_V, BOARD_LOW_V, BOARD_HIGH_V },
        { "high_V", s->high_V, s->low_V, BOARD_HIGH_V },
        { "off_V", s->off_V, s->low_V, s->high_V },
        { "step_V", s->step_V, least, SETTINGS_STEP_SHARE * (MODEL_U_MAX_V - MODEL_U_MIN_V) },
        { "ramp_V", s->ramp_V, least, s->step_V },
        { "ramp_V", s->ramp_V * time, range_V, NUMBER_LARGEST },
        { "loop_low_V", s->loop_low_V, low_V, high_V },
        { "loop_high_V", s->loop_high_V, s->loop_low_V + WATCHDOG_STUCK_V, high_V },
        { "offset_um", s->offset_um, least, range_um },
        { "reference_step_um", s->reference_step_um, least, range_um },
        { "follow_um", s->follow_um, 0.0f, WATCHDOG_FOLLOW_MOST * range_um },
        { "reading_zero_um", s->reading_zero_um, -zero_um, zero_um },
        { "reading_gain", s->reading_gain, 1.0f - SETTINGS_GAIN, 1.0f + SETTINGS_GAIN },
        { "output_zero_V", s->output_zero_V, -zero_V, zero_V },
        { "output_gain", s->output_gain, 1.0f - SETTINGS_GAIN, 1.0f + SETTINGS_GAIN },
        { "low_V", s->output_zero_V + s->output_gain * s->low_V, BOARD_LOW_V, BOARD_HIGH_V },
        { "high_V", s->output_zero_V + s->output_gain * s->high_V, BOARD_LOW_V, BOARD_HIGH_V },
    };
    const struct {
        const char *field;
        uint32_t value;
        uint32_t low;
        uint32_t high;
    } counts[] = {
        { "options", s->options, 0u, SETTINGS_LOOP | SETTINGS_LEARN | SETTINGS_KEEP | SETTINGS_NO_OFFSET },
        { "state_samples", s->state_samples, 1u, SETTINGS_LONGEST },
        { "power_samples", s->power_samples, 1u, s->state_samples - 1u },
        { "hold_samples", s->hold_samples, SETTINGS_SHORTEST, s->state_samples - 1u },
    };
    const char *wrong = NULL;

    for (uint32_t i = 0u; i < (uint32_t)(sizeof ranges / sizeof ranges[0]); ++i) {
        const settings_range_t *range = &ranges[i];
        const uint32_t good = number_finite(range->value) & (uint32_t)(range->value >= range->low)
            & (uint32_t)(range->value <= range->high);

        if ((good == 0u) && (wrong == NULL)) {
            wrong = range->field;
        }
    }
    for (uint32_t i = 0u; i < (uint32_t)(sizeof counts / sizeof counts[0]); ++i) {
        if (((counts[i].value < counts[i].low) | (counts[i].value > counts[i].high)) && (wrong == NULL)) {
            wrong = counts[i].field;
        }
    }
    return wrong;
}
