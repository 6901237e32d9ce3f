/* extended_selftest.c: every function over fixed inputs; they and the expected bits stand in extended_params.h. */

#include "extended_selftest.h"

#include "extended.h"

#define EXTENDED_SELFTEST_NUMBERS
#include "extended_params.h"

EXTENDED_CODE
static float extended_selftest_float(uint32_t bits)
{
    const union {
        uint32_t bits;
        float number;
    } pattern = { .bits = bits };

    return pattern.number;
}

EXTENDED_CODE
static uint32_t extended_selftest_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

EXTENDED_CODE
static uint32_t extended_selftest_predict(void)
{
    extended_t self;
    uint32_t mismatches = 0u;

    extended_init(&self, extended_selftest_float(EXTENDED_SELFTEST_PREDICT_START_Y),
        extended_selftest_float(EXTENDED_SELFTEST_PREDICT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = extended_selftest_predict_rows[k];
        float result;

        result = extended_predict(&self, extended_selftest_float(row[0]), extended_selftest_float(row[1]));
        mismatches += (uint32_t)(extended_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != EXTENDED_SELFTEST_PREDICT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EXTENDED_SELFTEST_PREDICT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EXTENDED_SELFTEST_PREDICT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EXTENDED_SELFTEST_PREDICT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EXTENDED_SELFTEST_PREDICT_U_REJECTED);

    return mismatches;
}

EXTENDED_CODE
static uint32_t extended_selftest_simulate(void)
{
    extended_t self;
    uint32_t mismatches = 0u;

    extended_init(&self, extended_selftest_float(EXTENDED_SELFTEST_SIMULATE_START_Y),
        extended_selftest_float(EXTENDED_SELFTEST_SIMULATE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = extended_selftest_simulate_rows[k];
        float result;

        result = extended_simulate(&self, extended_selftest_float(row[0]));
        mismatches += (uint32_t)(extended_selftest_bits(result) != row[1]);
    }
    mismatches += (uint32_t)(self.status != EXTENDED_SELFTEST_SIMULATE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EXTENDED_SELFTEST_SIMULATE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EXTENDED_SELFTEST_SIMULATE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EXTENDED_SELFTEST_SIMULATE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EXTENDED_SELFTEST_SIMULATE_U_REJECTED);

    return mismatches;
}

EXTENDED_CODE
static uint32_t extended_selftest_inverse(void)
{
    extended_t self;
    uint32_t mismatches = 0u;

    extended_init(&self, extended_selftest_float(EXTENDED_SELFTEST_INVERSE_START_Y),
        extended_selftest_float(EXTENDED_SELFTEST_INVERSE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = extended_selftest_inverse_rows[k];
        float result;

        result = extended_inverse(&self, extended_selftest_float(row[0]), extended_selftest_float(row[1]));
        mismatches += (uint32_t)(extended_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != EXTENDED_SELFTEST_INVERSE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EXTENDED_SELFTEST_INVERSE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EXTENDED_SELFTEST_INVERSE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EXTENDED_SELFTEST_INVERSE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EXTENDED_SELFTEST_INVERSE_U_REJECTED);

    return mismatches;
}

EXTENDED_CODE
uint32_t extended_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += extended_selftest_predict();
    mismatches += extended_selftest_simulate();
    mismatches += extended_selftest_inverse();

    return mismatches;
}
