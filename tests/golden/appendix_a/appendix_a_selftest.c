/* appendix_a_selftest.c: every function over the fixed inputs of appendix_a_selftest_data.h, compared bit by bit. */

#include "appendix_a_selftest.h"

#include "appendix_a.h"
#include "appendix_a_selftest_data.h"

APPENDIX_A_CODE
static float appendix_a_selftest_float(uint32_t bits)
{
    const union {
        uint32_t bits;
        float number;
    } pattern = { .bits = bits };

    return pattern.number;
}

APPENDIX_A_CODE
static uint32_t appendix_a_selftest_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

APPENDIX_A_CODE
static uint32_t appendix_a_selftest_predict(void)
{
    appendix_a_t self;
    uint32_t mismatches = 0u;

    appendix_a_init(&self, appendix_a_selftest_float(APPENDIX_A_SELFTEST_PREDICT_START_Y),
        appendix_a_selftest_float(APPENDIX_A_SELFTEST_PREDICT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = appendix_a_selftest_predict_rows[k];
        float result;

        result = appendix_a_predict(&self, appendix_a_selftest_float(row[0]), appendix_a_selftest_float(row[1]));
        mismatches += (uint32_t)(appendix_a_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != APPENDIX_A_SELFTEST_PREDICT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != APPENDIX_A_SELFTEST_PREDICT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != APPENDIX_A_SELFTEST_PREDICT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != APPENDIX_A_SELFTEST_PREDICT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != APPENDIX_A_SELFTEST_PREDICT_U_REJECTED);

    return mismatches;
}

APPENDIX_A_CODE
static uint32_t appendix_a_selftest_simulate(void)
{
    appendix_a_t self;
    uint32_t mismatches = 0u;

    appendix_a_init(&self, appendix_a_selftest_float(APPENDIX_A_SELFTEST_SIMULATE_START_Y),
        appendix_a_selftest_float(APPENDIX_A_SELFTEST_SIMULATE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = appendix_a_selftest_simulate_rows[k];
        float result;

        result = appendix_a_simulate(&self, appendix_a_selftest_float(row[0]));
        mismatches += (uint32_t)(appendix_a_selftest_bits(result) != row[1]);
    }
    mismatches += (uint32_t)(self.status != APPENDIX_A_SELFTEST_SIMULATE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != APPENDIX_A_SELFTEST_SIMULATE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != APPENDIX_A_SELFTEST_SIMULATE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != APPENDIX_A_SELFTEST_SIMULATE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != APPENDIX_A_SELFTEST_SIMULATE_U_REJECTED);

    return mismatches;
}

APPENDIX_A_CODE
static uint32_t appendix_a_selftest_inverse(void)
{
    appendix_a_t self;
    uint32_t mismatches = 0u;

    appendix_a_init(&self, appendix_a_selftest_float(APPENDIX_A_SELFTEST_INVERSE_START_Y),
        appendix_a_selftest_float(APPENDIX_A_SELFTEST_INVERSE_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = appendix_a_selftest_inverse_rows[k];
        float result;

        result = appendix_a_inverse(&self, appendix_a_selftest_float(row[0]), appendix_a_selftest_float(row[1]));
        mismatches += (uint32_t)(appendix_a_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != APPENDIX_A_SELFTEST_INVERSE_STATUS);
    mismatches += (uint32_t)(self.y_clamped != APPENDIX_A_SELFTEST_INVERSE_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != APPENDIX_A_SELFTEST_INVERSE_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != APPENDIX_A_SELFTEST_INVERSE_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != APPENDIX_A_SELFTEST_INVERSE_U_REJECTED);

    return mismatches;
}

APPENDIX_A_CODE
uint32_t appendix_a_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += appendix_a_selftest_predict();
    mismatches += appendix_a_selftest_simulate();
    mismatches += appendix_a_selftest_inverse();

    return mismatches;
}
