/* everything_selftest.c: every function over the fixed inputs of everything_selftest_data.h, compared bit by bit. */

#include "everything_selftest.h"

#include "everything.h"
#include "everything_selftest_data.h"

EVERYTHING_CODE
static float everything_selftest_float(uint32_t bits)
{
    const union {
        uint32_t bits;
        float number;
    } pattern = { .bits = bits };

    return pattern.number;
}

EVERYTHING_CODE
static uint32_t everything_selftest_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

EVERYTHING_CODE
static uint32_t everything_selftest_predict(void)
{
    everything_t self;
    uint32_t mismatches = 0u;

    everything_init(&self, everything_selftest_float(EVERYTHING_SELFTEST_PREDICT_START_Y),
        everything_selftest_float(EVERYTHING_SELFTEST_PREDICT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = everything_selftest_predict_rows[k];
        const float aux[EVERYTHING_CHANNELS] = {
            everything_selftest_float(row[2]),
        };
        float result;

        everything_aux(&self, aux);
        result = everything_predict(&self, everything_selftest_float(row[0]), everything_selftest_float(row[1]));
        mismatches += (uint32_t)(everything_selftest_bits(result) != row[3]);
    }
    mismatches += (uint32_t)(self.status != EVERYTHING_SELFTEST_PREDICT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EVERYTHING_SELFTEST_PREDICT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EVERYTHING_SELFTEST_PREDICT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EVERYTHING_SELFTEST_PREDICT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EVERYTHING_SELFTEST_PREDICT_U_REJECTED);

    return mismatches;
}

EVERYTHING_CODE
static uint32_t everything_selftest_simulate(void)
{
    everything_t self;
    uint32_t mismatches = 0u;

    everything_init(&self, everything_selftest_float(EVERYTHING_SELFTEST_SIMULATE_START_Y),
        everything_selftest_float(EVERYTHING_SELFTEST_SIMULATE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = everything_selftest_simulate_rows[k];
        const float aux[EVERYTHING_CHANNELS] = {
            everything_selftest_float(row[1]),
        };
        float result;

        everything_aux(&self, aux);
        result = everything_simulate(&self, everything_selftest_float(row[0]));
        mismatches += (uint32_t)(everything_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != EVERYTHING_SELFTEST_SIMULATE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EVERYTHING_SELFTEST_SIMULATE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EVERYTHING_SELFTEST_SIMULATE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EVERYTHING_SELFTEST_SIMULATE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EVERYTHING_SELFTEST_SIMULATE_U_REJECTED);

    return mismatches;
}

EVERYTHING_CODE
static uint32_t everything_selftest_inverse(void)
{
    everything_t self;
    uint32_t mismatches = 0u;

    everything_init(&self, everything_selftest_float(EVERYTHING_SELFTEST_INVERSE_START_Y),
        everything_selftest_float(EVERYTHING_SELFTEST_INVERSE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = everything_selftest_inverse_rows[k];
        const float aux[EVERYTHING_CHANNELS] = {
            everything_selftest_float(row[2]),
        };
        float result;

        everything_aux(&self, aux);
        result = everything_inverse(&self, everything_selftest_float(row[0]), everything_selftest_float(row[1]));
        mismatches += (uint32_t)(everything_selftest_bits(result) != row[3]);
    }
    mismatches += (uint32_t)(self.status != EVERYTHING_SELFTEST_INVERSE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EVERYTHING_SELFTEST_INVERSE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EVERYTHING_SELFTEST_INVERSE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EVERYTHING_SELFTEST_INVERSE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EVERYTHING_SELFTEST_INVERSE_U_REJECTED);

    return mismatches;
}

EVERYTHING_CODE
static uint32_t everything_selftest_correct(void)
{
    everything_t self;
    uint32_t mismatches = 0u;

    everything_init(&self, everything_selftest_float(EVERYTHING_SELFTEST_CORRECT_START_Y),
        everything_selftest_float(EVERYTHING_SELFTEST_CORRECT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = everything_selftest_correct_rows[k];
        const float aux[EVERYTHING_CHANNELS] = {
            everything_selftest_float(row[1]),
        };
        float result;

        everything_aux(&self, aux);
        result = everything_correct(&self, everything_selftest_float(row[0]));
        mismatches += (uint32_t)(everything_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != EVERYTHING_SELFTEST_CORRECT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EVERYTHING_SELFTEST_CORRECT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EVERYTHING_SELFTEST_CORRECT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EVERYTHING_SELFTEST_CORRECT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EVERYTHING_SELFTEST_CORRECT_U_REJECTED);

    return mismatches;
}

EVERYTHING_CODE
uint32_t everything_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += everything_selftest_predict();
    mismatches += everything_selftest_simulate();
    mismatches += everything_selftest_inverse();
    mismatches += everything_selftest_correct();

    return mismatches;
}
