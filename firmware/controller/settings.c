#include "settings.h"

#include <stddef.h>

#include "model.h"
#include "number.h"

typedef struct {
    const char *field;
    float value;
    float low;
    float high;
} settings_range_t;

#define SETTINGS_LARGEST 1.0e30f

const char *hysgen_settings_check(const settings_t *settings)
{
    const settings_t *s = settings;
    const float large = SETTINGS_LARGEST;
    /* Smallest change that may count as one: smaller than any step of a converter, larger than 0. */
    const float least = 1.0e-9f;
    const float low_V = (s->low_V > MODEL_U_MIN_V) ? s->low_V : MODEL_U_MIN_V;
    const float high_V = (s->high_V < MODEL_U_MAX_V) ? s->high_V : MODEL_U_MAX_V;
    /* In this order: each row relies on the rows above it. */
    const settings_range_t ranges[] = {
        { "low_V", s->low_V, -large, large },
        { "high_V", s->high_V, s->low_V, large },
        { "off_V", s->off_V, s->low_V, s->high_V },
        { "step_V", s->step_V, least, large },
        { "ramp_V", s->ramp_V, least, s->step_V },
        { "fall_V", s->fall_V, least, s->step_V },
        { "loop_low_V", s->loop_low_V, low_V, high_V },
        { "loop_high_V", s->loop_high_V, s->loop_low_V + least, high_V },
        { "loop_middle_V", s->loop_middle_V, s->loop_low_V, s->loop_high_V },
        { "stroke_um", s->stroke_um, least, large },
        { "offset_smoothing", s->offset_smoothing, 0.0f, 1.0f },
        { "offset_um", s->offset_um, least, large },
        { "approach_um", s->approach_um, least, large },
        { "reference_step_um", s->reference_step_um, least, large },
        { "low_um", s->low_um, -large, large },
        { "high_um", s->high_um, s->low_um, large },
        { "stuck_V", s->stuck_V, least, large },
        { "follow_um", s->follow_um, least, large },
        { "trim_integral", s->trim_integral, 0.0f, 1.0f },
        { "trim_proportion", s->trim_proportion, 0.0f, large },
        { "trim_smoothing", s->trim_smoothing, 0.0f, 1.0f },
        { "trim_limit_um", s->trim_limit_um, 0.0f, large },
    };
    const struct {
        const char *field;
        uint32_t value;
        uint32_t low;
        uint32_t high;
    } counts[] = {
        { "options", s->options, 0u, SETTINGS_TRIM | SETTINGS_LEARN | SETTINGS_KEEP },
        { "state_samples", s->state_samples, 1u, UINT32_MAX },
        { "power_samples", s->power_samples, 1u, s->state_samples - 1u },
        { "hold_samples", s->hold_samples, 1u, s->state_samples - 1u },
        { "stuck_samples", s->stuck_samples, 1u, UINT32_MAX },
        { "follow_samples", s->follow_samples, 1u, UINT32_MAX },
        { "bad_samples", s->bad_samples, 1u, UINT32_MAX },
        { "period_cycles", s->period_cycles, 1u, 0x7FFFFFFFu },
        { "budget_cycles", s->budget_cycles, 1u, s->period_cycles },
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
