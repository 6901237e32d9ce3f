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
static uint32_t appendix_a_selftest_correct(void)
{
    appendix_a_t self;
    uint32_t mismatches = 0u;

    appendix_a_init(&self, appendix_a_selftest_float(APPENDIX_A_SELFTEST_CORRECT_START_Y),
        appendix_a_selftest_float(APPENDIX_A_SELFTEST_CORRECT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = appendix_a_selftest_correct_rows[k];
        float result;

        result = appendix_a_correct(&self, appendix_a_selftest_float(row[0]));
        mismatches += (uint32_t)(appendix_a_selftest_bits(result) != row[1]);
    }
    mismatches += (uint32_t)(self.status != APPENDIX_A_SELFTEST_CORRECT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != APPENDIX_A_SELFTEST_CORRECT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != APPENDIX_A_SELFTEST_CORRECT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != APPENDIX_A_SELFTEST_CORRECT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != APPENDIX_A_SELFTEST_CORRECT_U_REJECTED);

    return mismatches;
}

/** A model, and its words to hash. */
typedef union {
    appendix_a_t model;                         /**< The model. */
    uint32_t words[sizeof(appendix_a_t) >> 2];  /**< All words of the struct. */
} appendix_a_selftest_model_t;

/** A learner, and its words to hash. */
typedef union {
    appendix_a_learner_t learner;                       /**< The learner. */
    uint32_t words[sizeof(appendix_a_learner_t) >> 2];  /**< All words of the struct. */
} appendix_a_selftest_learner_t;

#define APPENDIX_A_SELFTEST_WORDS(both) ((uint32_t)(sizeof(both) >> 2))

/* Each step is invertible in hash and in the word: a single wrong word always changes the hash. Byte by byte: the words are floats of a
 * struct, which a compiler may suppose that no read of a uint32_t sees. */
APPENDIX_A_CODE
static uint32_t appendix_a_selftest_hash(uint32_t hash, const uint32_t *words, uint32_t count)
{
    const unsigned char *from = (const unsigned char *)words;
    uint32_t mixed = hash;

    for (uint32_t i = 0u; i < count; ++i) {
        union {
            unsigned char bytes[4];
            uint32_t word;
        } copy;

        for (uint32_t j = 0u; j < 4u; ++j) {
            copy.bytes[j] = from[4u * i + j];
        }
        mixed = (mixed ^ copy.word) * 0x01000193u;
    }
    return mixed;
}

APPENDIX_A_CODE
static void appendix_a_selftest_clear(uint32_t *words, uint32_t count)
{
    unsigned char *to = (unsigned char *)words;

    for (uint32_t i = 0u; i < 4u * count; ++i) {
        to[i] = 0u;
    }
}

/* Commit of the shadows of the table, one after the other, each until an answer. */
APPENDIX_A_CODE
static uint32_t appendix_a_selftest_commit(appendix_a_selftest_model_t *self, appendix_a_selftest_learner_t *learner)
{
    uint32_t mismatches = 0u;

    for (uint32_t k = 0u; k < 10u; ++k) {
        const uint32_t *row = appendix_a_selftest_commit_rows[k];
        appendix_a_commit_t answer = APPENDIX_A_COMMIT_BUSY;
        uint32_t calls;
        uint32_t hash;

        learner->learner.age = row[0];
        for (uint32_t i = 0u; i < APPENDIX_A_LEARNED; ++i) {
            learner->learner.theta[i] = appendix_a_selftest_float(row[4u + i]);
        }
        for (calls = 0u; (answer == APPENDIX_A_COMMIT_BUSY) && (calls < APPENDIX_A_SELFTEST_LEARN_CALLS); ++calls) {
            answer = appendix_a_commit(&self->model, &learner->learner);
            if (answer == APPENDIX_A_COMMIT_TRYING) {
                /* A trial of one sample, which takes two readings. */
                answer = APPENDIX_A_COMMIT_BUSY;
                learner->learner.trying = 1u;
                appendix_a_learn(&learner->learner, appendix_a_selftest_float(appendix_a_selftest_learn_rows[0][0]),
                    appendix_a_selftest_float(appendix_a_selftest_learn_rows[0][1]));
            }
        }
        hash = appendix_a_selftest_hash(0x811c9dc5u, self->words, APPENDIX_A_SELFTEST_WORDS(*self));
        hash = appendix_a_selftest_hash(hash, learner->words, APPENDIX_A_SELFTEST_WORDS(*learner));
        mismatches += (uint32_t)(calls != row[1]) + (uint32_t)((uint32_t)answer != row[2]) + (uint32_t)(hash != row[3]);
    }
    return mismatches;
}

/* Samples of the learner, every word compared after each; then commits. */
APPENDIX_A_CODE
static uint32_t appendix_a_selftest_learn(void)
{
    appendix_a_selftest_model_t self;
    appendix_a_selftest_learner_t learner;
    uint32_t mismatches = 0u;

    appendix_a_selftest_clear(self.words, APPENDIX_A_SELFTEST_WORDS(self));
    appendix_a_selftest_clear(learner.words, APPENDIX_A_SELFTEST_WORDS(learner));
    appendix_a_init(&self.model, appendix_a_selftest_float(APPENDIX_A_SELFTEST_LEARN_START_Y),
        appendix_a_selftest_float(APPENDIX_A_SELFTEST_LEARN_START_U));
    appendix_a_learn_init(&learner.learner, &self.model);
    for (uint32_t k = 0u; k < 64u; ++k) {
        const uint32_t *row = appendix_a_selftest_learn_rows[k];
        uint32_t hash;

        if (k == 32u) {
            learner.learner.age = APPENDIX_A_SELFTEST_LEARN_AGE;
        }
        appendix_a_learn(&learner.learner, appendix_a_selftest_float(row[0]), appendix_a_selftest_float(row[1]));
        hash = appendix_a_selftest_hash(0x811c9dc5u, learner.words, APPENDIX_A_SELFTEST_WORDS(learner));
        mismatches += (uint32_t)(hash != row[2]);
    }
    return mismatches + appendix_a_selftest_commit(&self, &learner);
}

APPENDIX_A_CODE
uint32_t appendix_a_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += appendix_a_selftest_predict();
    mismatches += appendix_a_selftest_simulate();
    mismatches += appendix_a_selftest_inverse();
    mismatches += appendix_a_selftest_correct();
    mismatches += appendix_a_selftest_learn();

    return mismatches;
}
