#include "watchdog.h"

#include "board.h"
#include "model.h"
#include "number.h"
#include "status.h"

#define WATCHDOG_RANGE_UM (MODEL_Y_MAX_UM - MODEL_Y_MIN_UM)
#define WATCHDOG_JUMP_UM  (WATCHDOG_JUMP_SHARE * WATCHDOG_RANGE_UM)

/* Counts a sample; returns 1 once the count has reached `most`. */
static uint32_t watchdog_count(watchdog_count_t *count, uint32_t bad, uint32_t most)
{
    if (bad != 0u) {
        count->bad += (uint32_t)(count->bad < most);
    } else if (count->bad != 0u) {
        count->good += 1u;
        if (count->good >= WATCHDOG_LEAK) {
            count->bad -= 1u;
            count->good = 0u;
        }
    } else {
        count->good = 0u;
    }
    return (uint32_t)(count->bad >= most);
}

static void watchdog_restart(watchdog_count_t *count)
{
    count->bad = 0u;
    count->good = 0u;
}

void hysgen_watchdog_init(watchdog_t *self, const settings_t *settings)
{
    self->reading_um = number_limited(0.0f, BOARD_LOW_UM, BOARD_HIGH_UM);
    self->sample_um = self->reading_um;
    self->raw_um = number_of(NUMBER_NAN);
    self->seen_um = self->raw_um;
    watchdog_restart(&self->unread);
    self->same_V = settings->off_V;
    self->same = 0u;
    self->follow_um = settings->follow_um;
    watchdog_restart(&self->astray);
    watchdog_restart(&self->limits);
    watchdog_restart(&self->failed);
    watchdog_restart(&self->late);
}

/* [S4] */
uint32_t hysgen_watchdog_reading(watchdog_t *self, float y_um, float u_V)
{
    uint32_t status = 0u;

    if (number_finite(y_um) == 0u) {
        status |= STATUS_SENSOR_INVALID;
    } else if ((y_um < BOARD_LOW_UM) || (y_um > BOARD_HIGH_UM)) {
        status |= STATUS_SENSOR_RANGE;
    } else {
        if ((number_size(y_um - self->reading_um) > WATCHDOG_JUMP_UM) && (number_size(y_um - self->seen_um) > WATCHDOG_JUMP_UM)) {
            status |= STATUS_SENSOR_JUMP;
        } else if (number_bits(y_um) != number_bits(self->reading_um)) {
            self->reading_um = y_um;
            self->same_V = u_V;
            self->same = 0u;
        } else {
            self->same += (uint32_t)(self->same < UINT32_MAX);
        }
        self->seen_um = y_um;
    }
    self->raw_um = y_um;
    self->sample_um = (status == 0u) ? y_um : number_of(NUMBER_NAN);
    if (watchdog_count(&self->unread, (uint32_t)(status != 0u), WATCHDOG_BAD) != 0u) {
        status |= STATUS_FAULT_SENSOR;
    }
    if ((self->same >= WATCHDOG_STUCK) && (number_size(u_V - self->same_V) >= WATCHDOG_STUCK_V)) {
        status |= STATUS_FAULT_STUCK;
    }
    return status;
}

void hysgen_watchdog_judge(watchdog_t *self, const settings_t *settings, float error_um)
{
    const float least_um = WATCHDOG_FOLLOW_SHARE * WATCHDOG_RANGE_UM;
    const float judged_um = least_um + WATCHDOG_FOLLOW_ERRORS * error_um;

    self->follow_um = (settings->follow_um > 0.0f)
        ? settings->follow_um : number_limited(judged_um, least_um, WATCHDOG_FOLLOW_MOST * WATCHDOG_RANGE_UM);
}

/* [S5] */
uint32_t hysgen_watchdog_follow(watchdog_t *self, float expected_um)
{
    /* As bits, of which those of NaN are larger than any number's. */
    const uint32_t far = (uint32_t)(number_bits(number_size(self->reading_um - expected_um)) > number_bits(self->follow_um));

    return (watchdog_count(&self->astray, far, WATCHDOG_ASTRAY) != 0u) ? STATUS_FAULT_FOLLOW : 0u;
}

uint32_t hysgen_watchdog_amplifier(watchdog_t *self, uint32_t amplifier)
{
    const uint32_t limits = (uint32_t)((amplifier & BOARD_AMPLIFIER_LIMITS) != 0u);
    const uint32_t lasts = watchdog_count(&self->limits, limits, WATCHDOG_BAD);
    const uint32_t failed = watchdog_count(&self->failed, amplifier & BOARD_AMPLIFIER_FAILED, WATCHDOG_DEBOUNCE);
    uint32_t status = limits * STATUS_AMPLIFIER_LIMITS;

    if ((lasts | failed) != 0u) {
        status |= STATUS_FAULT_AMPLIFIER;
    }
    return status;
}

/* [S7] */
uint32_t hysgen_watchdog_time(watchdog_t *self, uint32_t cycles, uint32_t overrun)
{
    const uint32_t late = (uint32_t)(cycles > BOARD_PERIOD_CYCLES) | overrun;

    if (watchdog_count(&self->late, late, WATCHDOG_BAD) != 0u) {
        return STATUS_DEADLINE_MISSED | STATUS_FAULT_DEADLINE;
    }
    return (late != 0u) ? STATUS_DEADLINE_MISSED : 0u;
}
