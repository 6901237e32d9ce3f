/* extended_selftest.c: every function over the fixed inputs of extended_selftest_data.h, compared bit by bit. */

#include "extended_selftest.h"

#include "extended.h"
#include "extended_selftest_data.h"

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
static uint32_t extended_selftest_correct(void)
{
    extended_t self;
    uint32_t mismatches = 0u;

    extended_init(&self, extended_selftest_float(EXTENDED_SELFTEST_CORRECT_START_Y),
        extended_selftest_float(EXTENDED_SELFTEST_CORRECT_START_U));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = extended_selftest_correct_rows[k];
        float result;

        result = extended_correct(&self, extended_selftest_float(row[0]));
        mismatches += (uint32_t)(extended_selftest_bits(result) != row[1]);
    }
    mismatches += (uint32_t)(self.status != EXTENDED_SELFTEST_CORRECT_STATUS);
    mismatches += (uint32_t)(self.y_clamped != EXTENDED_SELFTEST_CORRECT_Y_CLAMPED);
    mismatches += (uint32_t)(self.u_clamped != EXTENDED_SELFTEST_CORRECT_U_CLAMPED);
    mismatches += (uint32_t)(self.y_rejected != EXTENDED_SELFTEST_CORRECT_Y_REJECTED);
    mismatches += (uint32_t)(self.u_rejected != EXTENDED_SELFTEST_CORRECT_U_REJECTED);

    return mismatches;
}

/** A model, and its words to hash. */
typedef union {
    extended_t model;                         /**< The model. */
    uint32_t words[sizeof(extended_t) >> 2];  /**< All words of the struct. */
} extended_selftest_model_t;

/** A learner, and its words to hash. */
typedef union {
    extended_learner_t learner;                       /**< The learner. */
    uint32_t words[sizeof(extended_learner_t) >> 2];  /**< All words of the struct. */
} extended_selftest_learner_t;

#define EXTENDED_SELFTEST_WORDS(both) ((uint32_t)(sizeof(both) >> 2))

/* Each step is invertible in hash and in the word: a single wrong word always changes the hash. Byte by byte: the words are floats of a
 * struct, which a compiler may suppose that no read of a uint32_t sees. */
EXTENDED_CODE
static uint32_t extended_selftest_hash(uint32_t hash, const uint32_t *words, uint32_t count)
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

EXTENDED_CODE
static void extended_selftest_clear(uint32_t *words, uint32_t count)
{
    unsigned char *to = (unsigned char *)words;

    for (uint32_t i = 0u; i < 4u * count; ++i) {
        to[i] = 0u;
    }
}

/* Commit of the shadows of the table, one after the other, each until an answer. */
EXTENDED_CODE
static uint32_t extended_selftest_commit(extended_selftest_model_t *self, extended_selftest_learner_t *learner)
{
    uint32_t mismatches = 0u;

    for (uint32_t k = 0u; k < 10u; ++k) {
        const uint32_t *row = extended_selftest_commit_rows[k];
        extended_commit_t answer = EXTENDED_COMMIT_BUSY;
        uint32_t calls;
        uint32_t hash;

        learner->learner.age = row[0];
        for (uint32_t i = 0u; i < EXTENDED_LEARNED; ++i) {
            learner->learner.theta[i] = extended_selftest_float(row[4u + i]);
        }
        for (calls = 0u; (answer == EXTENDED_COMMIT_BUSY) && (calls < EXTENDED_SELFTEST_LEARN_CALLS); ++calls) {
            answer = extended_commit(&self->model, &learner->learner);
            if (answer == EXTENDED_COMMIT_TRYING) {
                /* A trial of one sample, which takes two readings. */
                answer = EXTENDED_COMMIT_BUSY;
                learner->learner.trying = 1u;
                extended_learn(&learner->learner, extended_selftest_float(extended_selftest_learn_rows[0][0]),
                    extended_selftest_float(extended_selftest_learn_rows[0][1]));
            }
        }
        hash = extended_selftest_hash(0x811c9dc5u, self->words, EXTENDED_SELFTEST_WORDS(*self));
        hash = extended_selftest_hash(hash, learner->words, EXTENDED_SELFTEST_WORDS(*learner));
        mismatches += (uint32_t)(calls != row[1]) + (uint32_t)((uint32_t)answer != row[2]) + (uint32_t)(hash != row[3]);
    }
    return mismatches;
}

/* Samples of the learner, every word compared after each; then commits. */
EXTENDED_CODE
static uint32_t extended_selftest_learn(void)
{
    extended_selftest_model_t self;
    extended_selftest_learner_t learner;
    uint32_t mismatches = 0u;

    extended_selftest_clear(self.words, EXTENDED_SELFTEST_WORDS(self));
    extended_selftest_clear(learner.words, EXTENDED_SELFTEST_WORDS(learner));
    extended_init(&self.model, extended_selftest_float(EXTENDED_SELFTEST_LEARN_START_Y),
        extended_selftest_float(EXTENDED_SELFTEST_LEARN_START_U));
    extended_learn_init(&learner.learner, &self.model);
    for (uint32_t k = 0u; k < 64u; ++k) {
        const uint32_t *row = extended_selftest_learn_rows[k];
        uint32_t hash;

        if (k == 32u) {
            learner.learner.age = EXTENDED_SELFTEST_LEARN_AGE;
        }
        extended_learn(&learner.learner, extended_selftest_float(row[0]), extended_selftest_float(row[1]));
        hash = extended_selftest_hash(0x811c9dc5u, learner.words, EXTENDED_SELFTEST_WORDS(learner));
        mismatches += (uint32_t)(hash != row[2]);
    }
    return mismatches + extended_selftest_commit(&self, &learner);
}

EXTENDED_CODE
uint32_t extended_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += extended_selftest_predict();
    mismatches += extended_selftest_simulate();
    mismatches += extended_selftest_inverse();
    mismatches += extended_selftest_correct();
    mismatches += extended_selftest_learn();

    return mismatches;
}
