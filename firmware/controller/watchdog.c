#include "watchdog.h"

#include "board.h"
#include "number.h"
#include "status.h"

void watchdog_init(watchdog_t *self, const settings_t *settings)
{
    self->reading_um = number_limited(0.0f, settings->low_um, settings->high_um);
    self->sample_um = self->reading_um;
    self->bad = 0u;
    self->same_V = settings->off_V;
    self->same = 0u;
    self->astray = 0u;
    self->limits = 0u;
    self->late = 0u;
}

uint32_t watchdog_reading(watchdog_t *self, const settings_t *settings, float y_um, float u_V)
{
    uint32_t status = 0u;

    if (number_finite(y_um) == 0u) {
        status |= STATUS_SENSOR_INVALID;
    } else if ((y_um < settings->low_um) | (y_um > settings->high_um)) {
        status |= STATUS_SENSOR_RANGE;
    } else if (number_bits(y_um) != number_bits(self->reading_um)) {
        self->reading_um = y_um;
        self->same_V = u_V;
        self->same = 0u;
    } else {
        self->same += (uint32_t)(self->same < UINT32_MAX);
    }
    self->sample_um = (status == 0u) ? y_um : number_of(NUMBER_NAN);
    self->bad = (status != 0u) ? self->bad + 1u : 0u;
    if (self->bad >= settings->bad_samples) {
        self->bad = settings->bad_samples;
        status |= STATUS_FAULT_SENSOR;
    }
    if ((self->same >= settings->stuck_samples) & (number_size(u_V - self->same_V) >= settings->stuck_V)) {
        status |= STATUS_FAULT_STUCK;
    }
    return status;
}

uint32_t watchdog_follow(watchdog_t *self, const settings_t *settings, float expected_um)
{
    const uint32_t far = (uint32_t)(number_size(self->reading_um - expected_um) > settings->follow_um);

    self->astray = (far != 0u) ? self->astray + 1u : 0u;
    return (self->astray >= settings->follow_samples) ? STATUS_FAULT_FOLLOW : 0u;
}

uint32_t watchdog_amplifier(watchdog_t *self, const settings_t *settings, uint32_t amplifier)
{
    uint32_t status = 0u;

    self->limits = ((amplifier & BOARD_AMPLIFIER_LIMITS) != 0u) ? self->limits + 1u : 0u;
    if (self->limits != 0u) {
        status |= STATUS_AMPLIFIER_LIMITS;
    }
    if ((self->limits >= settings->bad_samples) | ((amplifier & BOARD_AMPLIFIER_FAILED) != 0u)) {
        status |= STATUS_FAULT_AMPLIFIER;
    }
    return status;
}

uint32_t watchdog_time(watchdog_t *self, const settings_t *settings, uint32_t cycles, uint32_t overrun)
{
    const uint32_t late = (uint32_t)(cycles > settings->budget_cycles) | overrun;

    self->late = (late != 0u) ? self->late + 1u : 0u;
    if (self->late >= settings->bad_samples) {
        return STATUS_DEADLINE_MISSED | STATUS_FAULT_DEADLINE;
    }
    return (late != 0u) ? STATUS_DEADLINE_MISSED : 0u;
}
