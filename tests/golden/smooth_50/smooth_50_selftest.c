/* smooth_50_selftest.c: every function over the fixed inputs of smooth_50_selftest_data.h, compared bit by bit. */

#include "smooth_50_selftest.h"

#include "smooth_50.h"
#include "smooth_50_selftest_data.h"

SMOOTH_50_CODE
static float smooth_50_selftest_float(uint32_t bits)
{
    const union {
        uint32_t bits;
        float number;
    } pattern = { .bits = bits };

    return pattern.number;
}

SMOOTH_50_CODE
static uint32_t smooth_50_selftest_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

SMOOTH_50_CODE
static uint32_t smooth_50_selftest_predict(void)
{
    smooth_50_t self;
    uint32_t mismatches = 0u;

    smooth_50_init(&self, smooth_50_selftest_float(SMOOTH_50_SELFTEST_PREDICT_START_Y),
        smooth_50_selftest_float(SMOOTH_50_SELFTEST_PREDICT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = smooth_50_selftest_predict_rows[k];
        float result;

        result = smooth_50_predict(&self, smooth_50_selftest_float(row[0]), smooth_50_selftest_float(row[1]));
        mismatches += (uint32_t)(smooth_50_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != SMOOTH_50_SELFTEST_PREDICT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != SMOOTH_50_SELFTEST_PREDICT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != SMOOTH_50_SELFTEST_PREDICT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != SMOOTH_50_SELFTEST_PREDICT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != SMOOTH_50_SELFTEST_PREDICT_U_REJECTED);

    return mismatches;
}

SMOOTH_50_CODE
static uint32_t smooth_50_selftest_simulate(void)
{
    smooth_50_t self;
    uint32_t mismatches = 0u;

    smooth_50_init(&self, smooth_50_selftest_float(SMOOTH_50_SELFTEST_SIMULATE_START_Y),
        smooth_50_selftest_float(SMOOTH_50_SELFTEST_SIMULATE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = smooth_50_selftest_simulate_rows[k];
        float result;

        result = smooth_50_simulate(&self, smooth_50_selftest_float(row[0]));
        mismatches += (uint32_t)(smooth_50_selftest_bits(result) != row[1]);
    }
    mismatches += (uint32_t)(self.status != SMOOTH_50_SELFTEST_SIMULATE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != SMOOTH_50_SELFTEST_SIMULATE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != SMOOTH_50_SELFTEST_SIMULATE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != SMOOTH_50_SELFTEST_SIMULATE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != SMOOTH_50_SELFTEST_SIMULATE_U_REJECTED);

    return mismatches;
}

SMOOTH_50_CODE
static uint32_t smooth_50_selftest_inverse(void)
{
    smooth_50_t self;
    uint32_t mismatches = 0u;

    smooth_50_init(&self, smooth_50_selftest_float(SMOOTH_50_SELFTEST_INVERSE_START_Y),
        smooth_50_selftest_float(SMOOTH_50_SELFTEST_INVERSE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = smooth_50_selftest_inverse_rows[k];
        float result;

        result = smooth_50_inverse(&self, smooth_50_selftest_float(row[0]), smooth_50_selftest_float(row[1]));
        mismatches += (uint32_t)(smooth_50_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != SMOOTH_50_SELFTEST_INVERSE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != SMOOTH_50_SELFTEST_INVERSE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != SMOOTH_50_SELFTEST_INVERSE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != SMOOTH_50_SELFTEST_INVERSE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != SMOOTH_50_SELFTEST_INVERSE_U_REJECTED);

    return mismatches;
}

SMOOTH_50_CODE
uint32_t smooth_50_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += smooth_50_selftest_predict();
    mismatches += smooth_50_selftest_simulate();
    mismatches += smooth_50_selftest_inverse();

    return mismatches;
}
