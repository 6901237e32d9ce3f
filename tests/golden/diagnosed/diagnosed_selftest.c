/* diagnosed_selftest.c: every function over fixed inputs; they and the expected bits stand in diagnosed_params.h. */

#include "diagnosed_selftest.h"

#include "diagnosed.h"

#define DIAGNOSED_SELFTEST_NUMBERS
#include "diagnosed_params.h"

DIAGNOSED_CODE
static float diagnosed_selftest_float(uint32_t bits)
{
    const union {
        uint32_t bits;
        float number;
    } pattern = { .bits = bits };

    return pattern.number;
}

DIAGNOSED_CODE
static uint32_t diagnosed_selftest_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

DIAGNOSED_CODE
static uint32_t diagnosed_selftest_predict(void)
{
    diagnosed_t self;
    uint32_t mismatches = 0u;

    diagnosed_init(&self, diagnosed_selftest_float(DIAGNOSED_SELFTEST_PREDICT_START_Y),
        diagnosed_selftest_float(DIAGNOSED_SELFTEST_PREDICT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = diagnosed_selftest_predict_rows[k];
        float result;

        result = diagnosed_predict(&self, diagnosed_selftest_float(row[0]), diagnosed_selftest_float(row[1]));
        mismatches += (uint32_t)(diagnosed_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != DIAGNOSED_SELFTEST_PREDICT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != DIAGNOSED_SELFTEST_PREDICT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != DIAGNOSED_SELFTEST_PREDICT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != DIAGNOSED_SELFTEST_PREDICT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != DIAGNOSED_SELFTEST_PREDICT_U_REJECTED);

    return mismatches;
}

DIAGNOSED_CODE
static uint32_t diagnosed_selftest_simulate(void)
{
    diagnosed_t self;
    uint32_t mismatches = 0u;

    diagnosed_init(&self, diagnosed_selftest_float(DIAGNOSED_SELFTEST_SIMULATE_START_Y),
        diagnosed_selftest_float(DIAGNOSED_SELFTEST_SIMULATE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = diagnosed_selftest_simulate_rows[k];
        float result;

        result = diagnosed_simulate(&self, diagnosed_selftest_float(row[0]));
        mismatches += (uint32_t)(diagnosed_selftest_bits(result) != row[1]);
    }
    mismatches += (uint32_t)(self.status != DIAGNOSED_SELFTEST_SIMULATE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != DIAGNOSED_SELFTEST_SIMULATE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != DIAGNOSED_SELFTEST_SIMULATE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != DIAGNOSED_SELFTEST_SIMULATE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != DIAGNOSED_SELFTEST_SIMULATE_U_REJECTED);

    return mismatches;
}

DIAGNOSED_CODE
static uint32_t diagnosed_selftest_inverse(void)
{
    diagnosed_t self;
    uint32_t mismatches = 0u;

    diagnosed_init(&self, diagnosed_selftest_float(DIAGNOSED_SELFTEST_INVERSE_START_Y),
        diagnosed_selftest_float(DIAGNOSED_SELFTEST_INVERSE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = diagnosed_selftest_inverse_rows[k];
        float result;

        result = diagnosed_inverse(&self, diagnosed_selftest_float(row[0]), diagnosed_selftest_float(row[1]));
        mismatches += (uint32_t)(diagnosed_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != DIAGNOSED_SELFTEST_INVERSE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != DIAGNOSED_SELFTEST_INVERSE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != DIAGNOSED_SELFTEST_INVERSE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != DIAGNOSED_SELFTEST_INVERSE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != DIAGNOSED_SELFTEST_INVERSE_U_REJECTED);

    return mismatches;
}

DIAGNOSED_CODE
uint32_t diagnosed_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += diagnosed_selftest_predict();
    mismatches += diagnosed_selftest_simulate();
    mismatches += diagnosed_selftest_inverse();

    return mismatches;
}
