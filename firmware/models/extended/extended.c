/* extended.c: the algorithm of model `extended`; changes only with the model's structure. Interface: extended.h. */

#include "extended.h"

#include "extended_params.h"

/* Equal bits on every machine rest on float32 operations as they are written: no shortcuts, no wider intermediate
 * results, no multiplication fused with an addition. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#error "extended: compile without -ffast-math and its parts"
#endif
#if defined(__FLT_EVAL_METHOD__)
#if __FLT_EVAL_METHOD__ != 0
#error "extended: float must be evaluated as float (on x86: -msse2 -mfpmath=sse)"
#endif
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__GNUC__)
#define EXTENDED_INLINE static inline __attribute__((always_inline))
#else
#define EXTENDED_INLINE static inline
#endif

/* ---- Arithmetic ---------------------------------------------------------------------------------------------- */

EXTENDED_INLINE uint32_t extended_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

EXTENDED_INLINE float extended_float(uint32_t bits)
{
    const union {
        uint32_t bits;
        float number;
    } pattern = { .bits = bits };

    return pattern.number;
}

/* 2^x for |x| <= 8, relative error at most 1.2e-07:
 *     n = round(x),  f = x - n,  2^x = 2^n ((1 + c1 f) + (f^2 (c2 + c3 f) + f^4 ((c4 + c5 f) + c6 f^2)))
 * Adding 1.5 * 2^23 rounds x and leaves n in the last bits of the sum, from where it is shifted into the exponent. */
EXTENDED_INLINE float extended_power_of_two(float x)
{
    const float shifted = x + 12582912.0f;
    const float f = x - (shifted - 12582912.0f);
    const float square = f * f;
    const float fourth = square * square;
    const float low = 1.0f + 0.693147182f * f;
    const float middle = 0.240226477f + 0.0555035993f * f;
    const float high = (0.00961850584f + 0.00133908063f * f) + 0.000153264715f * square;
    const float mantissa = low + (square * middle + fourth * high);

    return extended_float(extended_bits(mantissa) + (extended_bits(shifted) << 23));
}

/* 1/x for 2^-120 <= |x| <= 2^120, relative error at most 1.5e-07: a seed from the bits, then 3 Newton steps
 *     r <- r (2 - x r) */
EXTENDED_INLINE float extended_reciprocal(float x)
{
    float r = extended_float(0x7ef311c7u - extended_bits(x));

    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);

    return r;
}

/* ---- Input checks: constant time, by masks --------------------------------------------------------------------- */

/* All ones if the condition is 1, else 0. */
EXTENDED_INLINE uint32_t extended_mask(uint32_t condition)
{
    return 0u - condition;
}

/** What happened to the inputs during one call: each 0 or 1. */
typedef struct {
    uint32_t y_clamped;   /**< y was outside its range */
    uint32_t u_clamped;   /**< u was outside its range */
    uint32_t y_rejected;  /**< y was not finite */
    uint32_t u_rejected;  /**< u was not finite */
} extended_events_t;

EXTENDED_INLINE uint32_t extended_counted(uint32_t counter, uint32_t happened)
{
    return counter + (happened & (uint32_t)(counter < UINT32_MAX));
}

/* Status bits and counters of one call. Called last: the counting fills the slots that the arithmetic leaves free. */
EXTENDED_INLINE void extended_count_events(extended_t *self, const extended_events_t *events)
{
    self->status |= (events->y_clamped * EXTENDED_STATUS_Y_CLAMPED) | (events->u_clamped * EXTENDED_STATUS_U_CLAMPED)
        | (events->y_rejected * EXTENDED_STATUS_Y_REJECTED) | (events->u_rejected * EXTENDED_STATUS_U_REJECTED);
    self->y_clamped = extended_counted(self->y_clamped, events->y_clamped);
    self->u_clamped = extended_counted(self->u_clamped, events->u_clamped);
    self->y_rejected = extended_counted(self->y_rejected, events->y_rejected);
    self->u_rejected = extended_counted(self->u_rejected, events->u_rejected);
}

/* x, or the value held if x is not finite; magnitudes below 2^-40 become 0, so that denormal numbers never occur. */
EXTENDED_INLINE float extended_finite(float x, float held, uint32_t *rejected)
{
    const uint32_t bits = extended_bits(x);
    const uint32_t magnitude = bits & 0x7fffffffu;
    const uint32_t infinite = (uint32_t)(magnitude >= 0x7f800000u);
    const uint32_t keep = extended_mask((uint32_t)(magnitude >= 0x2b800000u));
    const uint32_t hold = extended_mask(infinite);

    *rejected = infinite;
    return extended_float((bits & keep & ~hold) | (extended_bits(held) & hold));
}

/* A result before it leaves or is kept: magnitudes below 2^-40 become 0. */
EXTENDED_INLINE float extended_flushed(float x)
{
    const uint32_t bits = extended_bits(x);

    return extended_float(bits & extended_mask((uint32_t)((bits & 0x7fffffffu) >= 0x2b800000u)));
}

/* A state before it is kept: 0 if it is not finite or its magnitude reaches the limit, which no sound state does. */
EXTENDED_INLINE float extended_inside(float x, float limit)
{
    const uint32_t bits = extended_bits(x);

    return extended_float(bits & extended_mask((uint32_t)((bits & 0x7fffffffu) < extended_bits(limit))));
}

/* x limited to [low, high]. */
EXTENDED_INLINE float extended_limited(float x, float low, float high, uint32_t *clamped)
{
    const uint32_t below = (uint32_t)(x < low);
    const uint32_t above = (uint32_t)(x > high);
    const uint32_t raise = extended_mask(below);
    const uint32_t lower = extended_mask(above);

    *clamped = below | above;
    return extended_float(
        (extended_bits(x) & ~(raise | lower)) | (extended_bits(low) & raise) | (extended_bits(high) & lower));
}

/* A displacement inside the identified range, whatever came in. */
EXTENDED_INLINE float extended_checked_y(const extended_t *self, float y_um, extended_events_t *events)
{
    const float finite = extended_finite(y_um, self->y_um, &events->y_rejected);

    return extended_limited(finite, EXTENDED_Y_MIN_UM, EXTENDED_Y_MAX_UM, &events->y_clamped);
}

/* A voltage inside the input range, whatever came in. */
EXTENDED_INLINE float extended_checked_u(const extended_t *self, float u_V, extended_events_t *events)
{
    const float finite = extended_finite(u_V, self->u_V, &events->u_rejected);

    return extended_limited(finite, EXTENDED_U_MIN_V, EXTENDED_U_MAX_V, &events->u_clamped);
}

/* ---- Rules ----------------------------------------------------------------------------------------------------- */

/** Sums over the rules; v_l are the unnormalised memberships, p_l = v_l / weight. */
typedef struct {
    float slope;   /**< sum v_l q_l1 */
    float offset;  /**< sum v_l q_l3 */
    float gain;    /**< sum v_l q_l2 */
    float weight;  /**< sum v_l */
} extended_sums_t;

/* Neighbouring rules' strengths differ by r = exp((y - middle) / h) and constants, so each sum over the rules is a
 * polynomial in r of degree 5, evaluated by Estrin's scheme: its chains are the shortest. y inside the range. */
EXTENDED_INLINE extended_sums_t extended_rule_sums(const extended_bank_t *bank, float y)
{
    const float r = extended_power_of_two((y - EXTENDED_ORIGIN_UM) * EXTENDED_PER_STEP);
    const float r2 = r * r;
    const float r4 = r2 * r2;
    extended_sums_t sums;

    const float w0_1 = extended_strength[0] + extended_strength[1] * r;
    const float w2_3 = extended_strength[2] + extended_strength[3] * r;
    const float w4_5 = extended_strength[4] + extended_strength[5] * r;
    const float w0_3 = w0_1 + w2_3 * r2;
    sums.weight = w0_3 + w4_5 * r4;

    const float s0_1 = bank->slope[0] + bank->slope[1] * r;
    const float s2_3 = bank->slope[2] + bank->slope[3] * r;
    const float s4_5 = bank->slope[4] + bank->slope[5] * r;
    const float s0_3 = s0_1 + s2_3 * r2;
    sums.slope = s0_3 + s4_5 * r4;

    const float o0_1 = bank->offset[0] + bank->offset[1] * r;
    const float o2_3 = bank->offset[2] + bank->offset[3] * r;
    const float o4_5 = bank->offset[4] + bank->offset[5] * r;
    const float o0_3 = o0_1 + o2_3 * r2;
    sums.offset = o0_3 + o4_5 * r4;

    const float g0_1 = bank->gain[0] + bank->gain[1] * r;
    const float g2_3 = bank->gain[2] + bank->gain[3] * r;
    const float g4_5 = bank->gain[4] + bank->gain[5] * r;
    const float g0_3 = g0_1 + g2_3 * r2;
    sums.gain = g0_3 + g4_5 * r4;

    return sums;
}

/* ---- Input blocks ---------------------------------------------------------------------------------------------- */

static void extended_delay_init(extended_delay_t *self, float u)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        self->ring[i] = u;
    }
    self->newest = 0u;
}

EXTENDED_INLINE void extended_delay_push(extended_delay_t *self, float u)
{
    self->newest = (self->newest + 1u) & 3u;
    self->ring[self->newest] = u;
}

/* The input of so many samples ago. */
EXTENDED_INLINE float extended_delay_past(const extended_delay_t *self, uint32_t samples)
{
    return self->ring[(self->newest - samples) & 3u];
}

/* v(k) = u(k-d) + mu (u(k-d-1) - u(k-d)) */
EXTENDED_INLINE float extended_delay_apply(extended_delay_t *self, float u)
{
    extended_delay_push(self, u);

    const float late = extended_delay_past(self, 1u);
    const float later = extended_delay_past(self, 2u);

    return late + extended_delay_part[0] * (later - late);
}

/* u(k) = v(k+n-1) + mu (v(k+n) - v(k+n-1)),  n the preview */
EXTENDED_INLINE float extended_delay_command(extended_delay_t *self, float v)
{
    const float before = extended_delay_past(self, 0u);

    extended_delay_push(self, v);
    return before + extended_delay_part[0] * (v - before);
}

/* At rest under the command u. */
static void extended_inputs_init(extended_inputs_t *inputs, float u)
{
    float v = u;

    extended_delay_init(&inputs->delay, v);
    inputs->v_V = v;
}

/* What reaches the stage of the command u. */
EXTENDED_INLINE float extended_inputs_apply(extended_inputs_t *inputs, float u)
{
    float v = u;

    v = extended_delay_apply(&inputs->delay, v);
    inputs->v_V = v;
    return v;
}

/* The nearest to v that can be made to reach the stage: the limiters hold it back. */
EXTENDED_INLINE float extended_inputs_reach(extended_inputs_t *inputs, float v)
{
    float reached = v;

    inputs->v_V = reached;
    return reached;
}

/* What to command so that v reaches the stage. */
EXTENDED_INLINE float extended_inputs_command(extended_inputs_t *inputs, float v)
{
    float u = v;

    u = extended_delay_command(&inputs->delay, u);
    return u;
}

/* ---- Terms ----------------------------------------------------------------------------------------------------- */

/* (high, low) + delta: `low` keeps what the rounding of `high` loses, for states that move by less than their last bit.
 * Adding and taking off 1.09139364e-11f makes steps below 2^-61 zero, so that no word ever becomes denormal. */
EXTENDED_INLINE void extended_accumulate(float *high, float *low, float delta)
{
    const float step = (delta + 1.09139364e-11f) - 1.09139364e-11f;
    const float t = *low + step;
    const float sum = *high + t;

    *low = t - (sum - *high);
    *high = extended_inside(sum, 1048576.0f);
}

static void extended_memory_init(extended_memory_t *self, float u)
{
    for (uint32_t j = 0u; j < 6u; ++j) {
        self->play[j] = u;
    }
}

EXTENDED_INLINE void extended_memory_regressors(const extended_memory_t *self, float phi[6])
{
    phi[0] = self->play[0];
    phi[1] = self->play[1];
    phi[2] = self->play[2];
    phi[3] = self->play[3];
    phi[4] = self->play[4];
    phi[5] = self->play[5];
}

/* z = max(u - r, min(u + r, z)) */
EXTENDED_INLINE float extended_memory_play(float z, float u, float half_width)
{
    const float low = u - half_width;
    const float high = u + half_width;
    const float pulled = (z > high) ? high : z;

    return (pulled < low) ? low : pulled;
}

EXTENDED_INLINE void extended_memory_advance(extended_memory_t *self, float u)
{
    self->play[0] = extended_memory_play(self->play[0], u, extended_memory_half_width[0]);
    self->play[1] = extended_memory_play(self->play[1], u, extended_memory_half_width[1]);
    self->play[2] = extended_memory_play(self->play[2], u, extended_memory_half_width[2]);
    self->play[3] = extended_memory_play(self->play[3], u, extended_memory_half_width[3]);
    self->play[4] = extended_memory_play(self->play[4], u, extended_memory_half_width[4]);
    self->play[5] = extended_memory_play(self->play[5], u, extended_memory_half_width[5]);
}

static void extended_creep_init(extended_creep_t *self, float u)
{
    for (uint32_t j = 0u; j < 4u; ++j) {
        self->high[j] = u;
        self->low[j] = 0.0f;
    }
}

EXTENDED_INLINE void extended_creep_regressors(const extended_creep_t *self, float phi[1])
{
    float sum = self->high[0];

    sum = sum + self->high[1];
    sum = sum + self->high[2];
    sum = sum + self->high[3];
    phi[0] = extended_creep_mean[0] * sum;
}

/* s = s + a (u - s) */
EXTENDED_INLINE void extended_creep_advance(extended_creep_t *self, float u)
{
    extended_accumulate(&self->high[0], &self->low[0], extended_creep_rate[0] * (u - self->high[0]));
    extended_accumulate(&self->high[1], &self->low[1], extended_creep_rate[1] * (u - self->high[1]));
    extended_accumulate(&self->high[2], &self->low[2], extended_creep_rate[2] * (u - self->high[2]));
    extended_accumulate(&self->high[3], &self->low[3], extended_creep_rate[3] * (u - self->high[3]));
}

/* Every term at rest under the input u. */
static void extended_terms_init(extended_terms_t *terms, float u)
{
    extended_memory_init(&terms->memory, u);
    extended_creep_init(&terms->creep, u);
}

/* phi(k), in the order of the weights. */
EXTENDED_INLINE void extended_terms_regressors(const extended_terms_t *terms, float phi[EXTENDED_WEIGHTS])
{
    extended_memory_regressors(&terms->memory, &phi[0]);
    extended_creep_regressors(&terms->creep, &phi[6]);
}

/* v(k) acts. */
EXTENDED_INLINE void extended_terms_advance(extended_terms_t *terms, float u)
{
    extended_memory_advance(&terms->memory, u);
    extended_creep_advance(&terms->creep, u);
}

/* sum_j theta_j phi_j(k). */
EXTENDED_INLINE float extended_terms_sum(const extended_bank_t *bank, const extended_terms_t *terms)
{
    float phi[EXTENDED_WEIGHTS];
    float sum;

    extended_terms_regressors(terms, phi);
    sum = bank->weight[0] * phi[0];
    sum = sum + bank->weight[1] * phi[1];
    sum = sum + bank->weight[2] * phi[2];
    sum = sum + bank->weight[3] * phi[3];
    sum = sum + bank->weight[4] * phi[4];
    sum = sum + bank->weight[5] * phi[5];
    sum = sum + bank->weight[6] * phi[6];
    return sum;
}

/* ---- Prediction ------------------------------------------------------------------------------------------------ */

void extended_init(extended_t *self, float y_um, float u_V)
{
    extended_events_t events;

    for (uint32_t b = 0u; b < 2u; ++b) {
        for (uint32_t l = 0u; l < EXTENDED_BANK_RULES; ++l) {
            self->bank[b].slope[l] = extended_slope[l];
            self->bank[b].offset[l] = extended_offset[l];
            self->bank[b].gain[l] = extended_gain[l];
        }
        for (uint32_t j = 0u; j < EXTENDED_WEIGHTS; ++j) {
            self->bank[b].weight[j] = extended_weight[j];
        }
    }
    self->active = 0u;
    self->status = 0u;
    self->y_clamped = 0u;
    self->u_clamped = 0u;
    self->y_rejected = 0u;
    self->u_rejected = 0u;
    self->y_um = EXTENDED_Y_REST_UM;
    self->u_V = EXTENDED_U_REST_V;
    self->y_um = extended_checked_y(self, y_um, &events);
    self->u_V = extended_checked_u(self, u_V, &events);
    extended_count_events(self, &events);
    extended_inputs_init(&self->inputs, self->u_V);
    extended_terms_init(&self->terms, self->inputs.v_V);
}

/* The model's output under the input u that reaches the stage, Eq. (4), with base = y S + O; the input acts on the state. */
EXTENDED_INLINE float extended_apply(extended_t *self, float base, float gain, float per_weight, float extra, float u)
{
    const float rules = (base + u * gain) * per_weight;
    const float y_next = extended_flushed(rules + extra);

    extended_terms_advance(&self->terms, u);
    self->y_um = y_next;
    return y_next;
}

/* y(k+1) from measured y(k) and u(k). */
float extended_predict(extended_t *self, float y_um, float u_V)
{
    const extended_bank_t *bank = &self->bank[self->active];
    extended_events_t events;
    const float y = extended_checked_y(self, y_um, &events);
    const float u = extended_checked_u(self, u_V, &events);
    const float v = extended_inputs_apply(&self->inputs, u);
    const extended_sums_t sums = extended_rule_sums(bank, y);
    const float extra = extended_terms_sum(bank, &self->terms);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = extended_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = extended_apply(self, base, sums.gain, per_weight, extra, v);

    extended_count_events(self, &events);
    return y_next;
}

/* ---- Free run -------------------------------------------------------------------------------------------------- */

/* y(k+1) from the last output and u(k). */
float extended_simulate(extended_t *self, float u_V)
{
    const extended_bank_t *bank = &self->bank[self->active];
    extended_events_t events = { 0u, 0u, 0u, 0u };
    const float y = extended_limited(self->y_um, EXTENDED_Y_MIN_UM, EXTENDED_Y_MAX_UM, &events.y_clamped);
    const float u = extended_checked_u(self, u_V, &events);
    const float v = extended_inputs_apply(&self->inputs, u);
    const extended_sums_t sums = extended_rule_sums(bank, y);
    const float extra = extended_terms_sum(bank, &self->terms);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = extended_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = extended_apply(self, base, sums.gain, per_weight, extra, v);

    extended_count_events(self, &events);
    return y_next;
}

/* ---- Inverse --------------------------------------------------------------------------------------------------- */

/* u(k) that takes y(k) to y(k+1): (y(k+1) - sum theta phi) W = y S + O + u G, solved for u. */
float extended_inverse(extended_t *self, float y_um, float y_next_um)
{
    const extended_bank_t *bank = &self->bank[self->active];
    extended_events_t events = { 0u, 0u, 0u, 0u };
    uint32_t rejected;
    uint32_t clamped;
    const float y = extended_checked_y(self, y_um, &events);
    const extended_sums_t sums = extended_rule_sums(bank, y);
    const float extra = extended_terms_sum(bank, &self->terms);
    const float finite = extended_finite(y_next_um, y, &rejected);
    const float wanted = extended_limited(finite, EXTENDED_REFERENCE_MIN_UM, EXTENDED_REFERENCE_MAX_UM, &clamped);
    const float base = y * sums.slope + sums.offset;
    const float numerator = (wanted - extra) * sums.weight - base;
    const float per_gain = extended_reciprocal(sums.gain);
    const float per_weight = extended_reciprocal(sums.weight);
    const float exact = extended_flushed(numerator * per_gain);
    const float inside = extended_limited(exact, EXTENDED_U_MIN_V, EXTENDED_U_MAX_V, &events.u_clamped);
    const float v = extended_inputs_reach(&self->inputs, inside);
    const float u = extended_inputs_command(&self->inputs, v);
    const uint32_t unreachable = events.u_clamped | (uint32_t)(extended_bits(v) != extended_bits(inside));

    self->status |= (clamped * EXTENDED_STATUS_REFERENCE_CLAMPED) | (unreachable * EXTENDED_STATUS_UNREACHABLE);
    events.y_rejected |= rejected;
    extended_count_events(self, &events);
    self->u_V = u;
    (void)extended_apply(self, base, sums.gain, per_weight, extra, v);
    return u;
}

/* ---- Learner: keeping count and starting again ------------------------------------------------------------------- */

/* What is written out already stands in the order in which it had better be executed: gcc's first scheduling pass for
 * the C674x would only take it apart. */
#if defined(_TMS320C6X) && defined(__GNUC__)
#define EXTENDED_STRAIGHT __attribute__((noinline, optimize("no-schedule-insns", "no-tree-ter")))
#else
#define EXTENDED_STRAIGHT
#endif

/* Set the bit of an event in the status word and step its counter, which stops at its largest value. */
EXTENDED_INLINE void extended_count_learner_event(
    extended_learner_t *self, uint32_t *counter, uint32_t happened, uint32_t flag)
{
    self->status |= extended_mask(happened) & flag;
    *counter += happened & (uint32_t)(*counter < UINT32_MAX);
}

/* Column j of U = I. */
static EXTENDED_STRAIGHT void extended_clear_column(extended_learner_t *self, uint32_t j)
{
    float *u = &self->u[j * EXTENDED_LEARNED];

    u[0] = 0.0f; u[1] = 0.0f; u[2] = 0.0f; u[3] = 0.0f; u[4] = 0.0f; u[5] = 0.0f;
    u[6] = 0.0f; u[7] = 0.0f; u[8] = 0.0f; u[9] = 0.0f; u[10] = 0.0f; u[11] = 0.0f;
    u[12] = 0.0f; u[13] = 0.0f; u[14] = 0.0f; u[15] = 0.0f; u[16] = 0.0f; u[17] = 0.0f;
    u[18] = 0.0f; u[19] = 0.0f; u[20] = 0.0f; u[21] = 0.0f; u[22] = 0.0f; u[23] = 0.0f;
    u[24] = 0.0f;
    u[j] = 1.0f;
}

/* U = I, columns 0 to 5. */
static EXTENDED_STRAIGHT void extended_clear_0(extended_learner_t *self)
{
    extended_clear_column(self, 0u);
    extended_clear_column(self, 1u);
    extended_clear_column(self, 2u);
    extended_clear_column(self, 3u);
    extended_clear_column(self, 4u);
    extended_clear_column(self, 5u);
}

/* U = I, columns 6 to 11. */
static EXTENDED_STRAIGHT void extended_clear_1(extended_learner_t *self)
{
    extended_clear_column(self, 6u);
    extended_clear_column(self, 7u);
    extended_clear_column(self, 8u);
    extended_clear_column(self, 9u);
    extended_clear_column(self, 10u);
    extended_clear_column(self, 11u);
}

/* U = I, columns 12 to 17. */
static EXTENDED_STRAIGHT void extended_clear_2(extended_learner_t *self)
{
    extended_clear_column(self, 12u);
    extended_clear_column(self, 13u);
    extended_clear_column(self, 14u);
    extended_clear_column(self, 15u);
    extended_clear_column(self, 16u);
    extended_clear_column(self, 17u);
}

/* U = I, columns 18 to 23. */
static EXTENDED_STRAIGHT void extended_clear_3(extended_learner_t *self)
{
    extended_clear_column(self, 18u);
    extended_clear_column(self, 19u);
    extended_clear_column(self, 20u);
    extended_clear_column(self, 21u);
    extended_clear_column(self, 22u);
    extended_clear_column(self, 23u);
}

/* U = I, column 24. */
static EXTENDED_STRAIGHT void extended_clear_4(extended_learner_t *self)
{
    extended_clear_column(self, 24u);
}

/* Back to the reference parameters and the prior, P = alpha I: U in the calls to come. */
static void extended_restart(extended_learner_t *self)
{
    self->theta[0] = self->reference[0]; self->theta[1] = self->reference[1];
            self->theta[2] = self->reference[2]; self->theta[3] = self->reference[3];
            self->theta[4] = self->reference[4]; self->theta[5] = self->reference[5];
    self->theta_low[0] = 0.0f; self->theta_low[1] = 0.0f; self->theta_low[2] = 0.0f;
            self->theta_low[3] = 0.0f; self->theta_low[4] = 0.0f; self->theta_low[5] = 0.0f;
    self->d[0] = extended_learn_prior[0]; self->d[1] = extended_learn_prior[1];
            self->d[2] = extended_learn_prior[2]; self->d[3] = extended_learn_prior[3];
            self->d[4] = extended_learn_prior[4]; self->d[5] = extended_learn_prior[5];
    self->theta[6] = self->reference[6]; self->theta[7] = self->reference[7];
            self->theta[8] = self->reference[8]; self->theta[9] = self->reference[9];
            self->theta[10] = self->reference[10]; self->theta[11] = self->reference[11];
    self->theta_low[6] = 0.0f; self->theta_low[7] = 0.0f; self->theta_low[8] = 0.0f;
            self->theta_low[9] = 0.0f; self->theta_low[10] = 0.0f; self->theta_low[11] = 0.0f;
    self->d[6] = extended_learn_prior[6]; self->d[7] = extended_learn_prior[7];
            self->d[8] = extended_learn_prior[8]; self->d[9] = extended_learn_prior[9];
            self->d[10] = extended_learn_prior[10]; self->d[11] = extended_learn_prior[11];
    self->theta[12] = self->reference[12]; self->theta[13] = self->reference[13];
            self->theta[14] = self->reference[14]; self->theta[15] = self->reference[15];
            self->theta[16] = self->reference[16]; self->theta[17] = self->reference[17];
    self->theta_low[12] = 0.0f; self->theta_low[13] = 0.0f; self->theta_low[14] = 0.0f;
            self->theta_low[15] = 0.0f; self->theta_low[16] = 0.0f; self->theta_low[17] = 0.0f;
    self->d[12] = extended_learn_prior[12]; self->d[13] = extended_learn_prior[13];
            self->d[14] = extended_learn_prior[14]; self->d[15] = extended_learn_prior[15];
            self->d[16] = extended_learn_prior[16]; self->d[17] = extended_learn_prior[17];
    self->theta[18] = self->reference[18]; self->theta[19] = self->reference[19];
            self->theta[20] = self->reference[20]; self->theta[21] = self->reference[21];
            self->theta[22] = self->reference[22]; self->theta[23] = self->reference[23];
    self->theta_low[18] = 0.0f; self->theta_low[19] = 0.0f; self->theta_low[20] = 0.0f;
            self->theta_low[21] = 0.0f; self->theta_low[22] = 0.0f; self->theta_low[23] = 0.0f;
    self->d[18] = extended_learn_prior[18]; self->d[19] = extended_learn_prior[19];
            self->d[20] = extended_learn_prior[20]; self->d[21] = extended_learn_prior[21];
            self->d[22] = extended_learn_prior[22]; self->d[23] = extended_learn_prior[23];
    self->theta[24] = self->reference[24];
    self->theta_low[24] = 0.0f;
    self->d[24] = extended_learn_prior[24];
    self->scale_um = EXTENDED_LEARN_LEVEL_UM;
    self->moving_um = EXTENDED_LEARN_LEVEL_UM;
    self->error = 0.0f;
    self->reference_error = 0.0f;
    self->step_error = 0.0f;
    self->phase = 9u;
    self->run = 0u;
    self->age = 0u;
}

/* ---- Learner: the update, P = U D U' --------------------------------------------------------------------------- */

/* f = U' x in 6 columns from c on. Every f_j sums over i = 0, 1, ...; U is whole columns with ones on the diagonal
 * and zeros below. */
static EXTENDED_STRAIGHT void extended_project_columns(extended_learner_t *self, uint32_t c)
{
    const float *u = &self->u[c * EXTENDED_LEARNED];
    float f0, f1, f2, f3, f4, f5;

    const float x0 = self->x[0], u0_0 = u[0], u0_1 = u[25], u0_2 = u[50], u0_3 = u[75], u0_4 = u[100], u0_5 = u[125];
    const float x1 = self->x[1], u1_0 = u[1], u1_1 = u[26], u1_2 = u[51], u1_3 = u[76], u1_4 = u[101], u1_5 = u[126];
    const float m0_0 = u0_0 * x0, m0_1 = u0_1 * x0, m0_2 = u0_2 * x0, m0_3 = u0_3 * x0, m0_4 = u0_4 * x0,
            m0_5 = u0_5 * x0;
    const float x2 = self->x[2], u2_0 = u[2], u2_1 = u[27], u2_2 = u[52], u2_3 = u[77], u2_4 = u[102], u2_5 = u[127];
    const float m1_0 = u1_0 * x1, m1_1 = u1_1 * x1, m1_2 = u1_2 * x1, m1_3 = u1_3 * x1, m1_4 = u1_4 * x1,
            m1_5 = u1_5 * x1;
    const float x3 = self->x[3], u3_0 = u[3], u3_1 = u[28], u3_2 = u[53], u3_3 = u[78], u3_4 = u[103], u3_5 = u[128];
    f0 = m0_0; f1 = m0_1; f2 = m0_2; f3 = m0_3; f4 = m0_4; f5 = m0_5;
    const float m2_0 = u2_0 * x2, m2_1 = u2_1 * x2, m2_2 = u2_2 * x2, m2_3 = u2_3 * x2, m2_4 = u2_4 * x2,
            m2_5 = u2_5 * x2;
    const float x4 = self->x[4], u4_0 = u[4], u4_1 = u[29], u4_2 = u[54], u4_3 = u[79], u4_4 = u[104], u4_5 = u[129];
    f0 = f0 + m1_0; f1 = f1 + m1_1; f2 = f2 + m1_2; f3 = f3 + m1_3; f4 = f4 + m1_4;
            f5 = f5 + m1_5;
    const float m3_0 = u3_0 * x3, m3_1 = u3_1 * x3, m3_2 = u3_2 * x3, m3_3 = u3_3 * x3, m3_4 = u3_4 * x3,
            m3_5 = u3_5 * x3;
    const float x5 = self->x[5], u5_0 = u[5], u5_1 = u[30], u5_2 = u[55], u5_3 = u[80], u5_4 = u[105], u5_5 = u[130];
    f0 = f0 + m2_0; f1 = f1 + m2_1; f2 = f2 + m2_2; f3 = f3 + m2_3; f4 = f4 + m2_4;
            f5 = f5 + m2_5;
    const float m4_0 = u4_0 * x4, m4_1 = u4_1 * x4, m4_2 = u4_2 * x4, m4_3 = u4_3 * x4, m4_4 = u4_4 * x4,
            m4_5 = u4_5 * x4;
    const float x6 = self->x[6], u6_0 = u[6], u6_1 = u[31], u6_2 = u[56], u6_3 = u[81], u6_4 = u[106], u6_5 = u[131];
    f0 = f0 + m3_0; f1 = f1 + m3_1; f2 = f2 + m3_2; f3 = f3 + m3_3; f4 = f4 + m3_4;
            f5 = f5 + m3_5;
    const float m5_0 = u5_0 * x5, m5_1 = u5_1 * x5, m5_2 = u5_2 * x5, m5_3 = u5_3 * x5, m5_4 = u5_4 * x5,
            m5_5 = u5_5 * x5;
    const float x7 = self->x[7], u7_0 = u[7], u7_1 = u[32], u7_2 = u[57], u7_3 = u[82], u7_4 = u[107], u7_5 = u[132];
    f0 = f0 + m4_0; f1 = f1 + m4_1; f2 = f2 + m4_2; f3 = f3 + m4_3; f4 = f4 + m4_4;
            f5 = f5 + m4_5;
    const float m6_0 = u6_0 * x6, m6_1 = u6_1 * x6, m6_2 = u6_2 * x6, m6_3 = u6_3 * x6, m6_4 = u6_4 * x6,
            m6_5 = u6_5 * x6;
    const float x8 = self->x[8], u8_0 = u[8], u8_1 = u[33], u8_2 = u[58], u8_3 = u[83], u8_4 = u[108], u8_5 = u[133];
    f0 = f0 + m5_0; f1 = f1 + m5_1; f2 = f2 + m5_2; f3 = f3 + m5_3; f4 = f4 + m5_4;
            f5 = f5 + m5_5;
    const float m7_0 = u7_0 * x7, m7_1 = u7_1 * x7, m7_2 = u7_2 * x7, m7_3 = u7_3 * x7, m7_4 = u7_4 * x7,
            m7_5 = u7_5 * x7;
    const float x9 = self->x[9], u9_0 = u[9], u9_1 = u[34], u9_2 = u[59], u9_3 = u[84], u9_4 = u[109], u9_5 = u[134];
    f0 = f0 + m6_0; f1 = f1 + m6_1; f2 = f2 + m6_2; f3 = f3 + m6_3; f4 = f4 + m6_4;
            f5 = f5 + m6_5;
    const float m8_0 = u8_0 * x8, m8_1 = u8_1 * x8, m8_2 = u8_2 * x8, m8_3 = u8_3 * x8, m8_4 = u8_4 * x8,
            m8_5 = u8_5 * x8;
    const float x10 = self->x[10], u10_0 = u[10], u10_1 = u[35], u10_2 = u[60], u10_3 = u[85], u10_4 = u[110], u10_5 = u[135];
    f0 = f0 + m7_0; f1 = f1 + m7_1; f2 = f2 + m7_2; f3 = f3 + m7_3; f4 = f4 + m7_4;
            f5 = f5 + m7_5;
    const float m9_0 = u9_0 * x9, m9_1 = u9_1 * x9, m9_2 = u9_2 * x9, m9_3 = u9_3 * x9, m9_4 = u9_4 * x9,
            m9_5 = u9_5 * x9;
    const float x11 = self->x[11], u11_0 = u[11], u11_1 = u[36], u11_2 = u[61], u11_3 = u[86], u11_4 = u[111], u11_5 = u[136];
    f0 = f0 + m8_0; f1 = f1 + m8_1; f2 = f2 + m8_2; f3 = f3 + m8_3; f4 = f4 + m8_4;
            f5 = f5 + m8_5;
    const float m10_0 = u10_0 * x10, m10_1 = u10_1 * x10, m10_2 = u10_2 * x10, m10_3 = u10_3 * x10,
            m10_4 = u10_4 * x10, m10_5 = u10_5 * x10;
    const float x12 = self->x[12], u12_0 = u[12], u12_1 = u[37], u12_2 = u[62], u12_3 = u[87], u12_4 = u[112], u12_5 = u[137];
    f0 = f0 + m9_0; f1 = f1 + m9_1; f2 = f2 + m9_2; f3 = f3 + m9_3; f4 = f4 + m9_4;
            f5 = f5 + m9_5;
    const float m11_0 = u11_0 * x11, m11_1 = u11_1 * x11, m11_2 = u11_2 * x11, m11_3 = u11_3 * x11,
            m11_4 = u11_4 * x11, m11_5 = u11_5 * x11;
    const float x13 = self->x[13], u13_0 = u[13], u13_1 = u[38], u13_2 = u[63], u13_3 = u[88], u13_4 = u[113], u13_5 = u[138];
    f0 = f0 + m10_0; f1 = f1 + m10_1; f2 = f2 + m10_2; f3 = f3 + m10_3; f4 = f4 + m10_4;
            f5 = f5 + m10_5;
    const float m12_0 = u12_0 * x12, m12_1 = u12_1 * x12, m12_2 = u12_2 * x12, m12_3 = u12_3 * x12,
            m12_4 = u12_4 * x12, m12_5 = u12_5 * x12;
    const float x14 = self->x[14], u14_0 = u[14], u14_1 = u[39], u14_2 = u[64], u14_3 = u[89], u14_4 = u[114], u14_5 = u[139];
    f0 = f0 + m11_0; f1 = f1 + m11_1; f2 = f2 + m11_2; f3 = f3 + m11_3; f4 = f4 + m11_4;
            f5 = f5 + m11_5;
    const float m13_0 = u13_0 * x13, m13_1 = u13_1 * x13, m13_2 = u13_2 * x13, m13_3 = u13_3 * x13,
            m13_4 = u13_4 * x13, m13_5 = u13_5 * x13;
    const float x15 = self->x[15], u15_0 = u[15], u15_1 = u[40], u15_2 = u[65], u15_3 = u[90], u15_4 = u[115], u15_5 = u[140];
    f0 = f0 + m12_0; f1 = f1 + m12_1; f2 = f2 + m12_2; f3 = f3 + m12_3; f4 = f4 + m12_4;
            f5 = f5 + m12_5;
    const float m14_0 = u14_0 * x14, m14_1 = u14_1 * x14, m14_2 = u14_2 * x14, m14_3 = u14_3 * x14,
            m14_4 = u14_4 * x14, m14_5 = u14_5 * x14;
    const float x16 = self->x[16], u16_0 = u[16], u16_1 = u[41], u16_2 = u[66], u16_3 = u[91], u16_4 = u[116], u16_5 = u[141];
    f0 = f0 + m13_0; f1 = f1 + m13_1; f2 = f2 + m13_2; f3 = f3 + m13_3; f4 = f4 + m13_4;
            f5 = f5 + m13_5;
    const float m15_0 = u15_0 * x15, m15_1 = u15_1 * x15, m15_2 = u15_2 * x15, m15_3 = u15_3 * x15,
            m15_4 = u15_4 * x15, m15_5 = u15_5 * x15;
    const float x17 = self->x[17], u17_0 = u[17], u17_1 = u[42], u17_2 = u[67], u17_3 = u[92], u17_4 = u[117], u17_5 = u[142];
    f0 = f0 + m14_0; f1 = f1 + m14_1; f2 = f2 + m14_2; f3 = f3 + m14_3; f4 = f4 + m14_4;
            f5 = f5 + m14_5;
    const float m16_0 = u16_0 * x16, m16_1 = u16_1 * x16, m16_2 = u16_2 * x16, m16_3 = u16_3 * x16,
            m16_4 = u16_4 * x16, m16_5 = u16_5 * x16;
    const float x18 = self->x[18], u18_0 = u[18], u18_1 = u[43], u18_2 = u[68], u18_3 = u[93], u18_4 = u[118], u18_5 = u[143];
    f0 = f0 + m15_0; f1 = f1 + m15_1; f2 = f2 + m15_2; f3 = f3 + m15_3; f4 = f4 + m15_4;
            f5 = f5 + m15_5;
    const float m17_0 = u17_0 * x17, m17_1 = u17_1 * x17, m17_2 = u17_2 * x17, m17_3 = u17_3 * x17,
            m17_4 = u17_4 * x17, m17_5 = u17_5 * x17;
    const float x19 = self->x[19], u19_0 = u[19], u19_1 = u[44], u19_2 = u[69], u19_3 = u[94], u19_4 = u[119], u19_5 = u[144];
    f0 = f0 + m16_0; f1 = f1 + m16_1; f2 = f2 + m16_2; f3 = f3 + m16_3; f4 = f4 + m16_4;
            f5 = f5 + m16_5;
    const float m18_0 = u18_0 * x18, m18_1 = u18_1 * x18, m18_2 = u18_2 * x18, m18_3 = u18_3 * x18,
            m18_4 = u18_4 * x18, m18_5 = u18_5 * x18;
    const float x20 = self->x[20], u20_0 = u[20], u20_1 = u[45], u20_2 = u[70], u20_3 = u[95], u20_4 = u[120], u20_5 = u[145];
    f0 = f0 + m17_0; f1 = f1 + m17_1; f2 = f2 + m17_2; f3 = f3 + m17_3; f4 = f4 + m17_4;
            f5 = f5 + m17_5;
    const float m19_0 = u19_0 * x19, m19_1 = u19_1 * x19, m19_2 = u19_2 * x19, m19_3 = u19_3 * x19,
            m19_4 = u19_4 * x19, m19_5 = u19_5 * x19;
    const float x21 = self->x[21], u21_0 = u[21], u21_1 = u[46], u21_2 = u[71], u21_3 = u[96], u21_4 = u[121], u21_5 = u[146];
    f0 = f0 + m18_0; f1 = f1 + m18_1; f2 = f2 + m18_2; f3 = f3 + m18_3; f4 = f4 + m18_4;
            f5 = f5 + m18_5;
    const float m20_0 = u20_0 * x20, m20_1 = u20_1 * x20, m20_2 = u20_2 * x20, m20_3 = u20_3 * x20,
            m20_4 = u20_4 * x20, m20_5 = u20_5 * x20;
    const float x22 = self->x[22], u22_0 = u[22], u22_1 = u[47], u22_2 = u[72], u22_3 = u[97], u22_4 = u[122], u22_5 = u[147];
    f0 = f0 + m19_0; f1 = f1 + m19_1; f2 = f2 + m19_2; f3 = f3 + m19_3; f4 = f4 + m19_4;
            f5 = f5 + m19_5;
    const float m21_0 = u21_0 * x21, m21_1 = u21_1 * x21, m21_2 = u21_2 * x21, m21_3 = u21_3 * x21,
            m21_4 = u21_4 * x21, m21_5 = u21_5 * x21;
    const float x23 = self->x[23], u23_0 = u[23], u23_1 = u[48], u23_2 = u[73], u23_3 = u[98], u23_4 = u[123], u23_5 = u[148];
    f0 = f0 + m20_0; f1 = f1 + m20_1; f2 = f2 + m20_2; f3 = f3 + m20_3; f4 = f4 + m20_4;
            f5 = f5 + m20_5;
    const float m22_0 = u22_0 * x22, m22_1 = u22_1 * x22, m22_2 = u22_2 * x22, m22_3 = u22_3 * x22,
            m22_4 = u22_4 * x22, m22_5 = u22_5 * x22;
    const float x24 = self->x[24], u24_0 = u[24], u24_1 = u[49], u24_2 = u[74], u24_3 = u[99], u24_4 = u[124], u24_5 = u[149];
    f0 = f0 + m21_0; f1 = f1 + m21_1; f2 = f2 + m21_2; f3 = f3 + m21_3; f4 = f4 + m21_4;
            f5 = f5 + m21_5;
    const float m23_0 = u23_0 * x23, m23_1 = u23_1 * x23, m23_2 = u23_2 * x23, m23_3 = u23_3 * x23,
            m23_4 = u23_4 * x23, m23_5 = u23_5 * x23;
    f0 = f0 + m22_0; f1 = f1 + m22_1; f2 = f2 + m22_2; f3 = f3 + m22_3; f4 = f4 + m22_4;
            f5 = f5 + m22_5;
    const float m24_0 = u24_0 * x24, m24_1 = u24_1 * x24, m24_2 = u24_2 * x24, m24_3 = u24_3 * x24,
            m24_4 = u24_4 * x24, m24_5 = u24_5 * x24;
    f0 = f0 + m23_0; f1 = f1 + m23_1; f2 = f2 + m23_2; f3 = f3 + m23_3; f4 = f4 + m23_4;
            f5 = f5 + m23_5;
    f0 = f0 + m24_0; f1 = f1 + m24_1; f2 = f2 + m24_2; f3 = f3 + m24_3; f4 = f4 + m24_4;
            f5 = f5 + m24_5;
    self->f[c + 0u] = f0; self->f[c + 1u] = f1; self->f[c + 2u] = f2; self->f[c + 3u] = f3;
            self->f[c + 4u] = f4; self->f[c + 5u] = f5;
}

/* Column j of U, and what it adds to P x, with k_i the sum so far: U_ij <- U_ij + k_i l_j, k_i <- k_i + U_ij g_j.
 * Below the diagonal both are 0 and stay so; on it U_jj = 1 makes k_j = g_j.
 * Adding and taking off `grid` leaves multiples of 2^-30: nothing that is kept can become denormal. */
static EXTENDED_STRAIGHT void extended_factor_column(extended_learner_t *self, uint32_t j)
{
    const float grid = 0.01171875f;
    const float l = self->l[j];
    const float g = self->g[j];
    float *u = &self->u[j * EXTENDED_LEARNED];
    float *k = self->k;

    const float u0 = u[0], u1 = u[1], u2 = u[2];
    const float k0 = k[0], k1 = k[1], k2 = k[2];
    const float p0 = k0 * l, p1 = k1 * l, p2 = k2 * l;
    const float q0 = u0 * g, q1 = u1 * g, q2 = u2 * g;
    const float u3 = u[3], u4 = u[4], u5 = u[5];
    const float k3 = k[3], k4 = k[4], k5 = k[5];
    const float r0 = u0 + p0, r1 = u1 + p1, r2 = u2 + p2;
    const float n0 = k0 + q0, n1 = k1 + q1, n2 = k2 + q2;
    const float p3 = k3 * l, p4 = k4 * l, p5 = k5 * l;
    const float q3 = u3 * g, q4 = u4 * g, q5 = u5 * g;
    const float u6 = u[6], u7 = u[7], u8 = u[8];
    const float k6 = k[6], k7 = k[7], k8 = k[8];
    const float s0 = r0 + grid, s1 = r1 + grid, s2 = r2 + grid;
    k[0] = n0; k[1] = n1; k[2] = n2;
    const float r3 = u3 + p3, r4 = u4 + p4, r5 = u5 + p5;
    const float n3 = k3 + q3, n4 = k4 + q4, n5 = k5 + q5;
    const float p6 = k6 * l, p7 = k7 * l, p8 = k8 * l;
    const float q6 = u6 * g, q7 = u7 * g, q8 = u8 * g;
    const float u9 = u[9], u10 = u[10], u11 = u[11];
    const float k9 = k[9], k10 = k[10], k11 = k[11];
    const float t0 = s0 - grid, t1 = s1 - grid, t2 = s2 - grid;
    const float s3 = r3 + grid, s4 = r4 + grid, s5 = r5 + grid;
    k[3] = n3; k[4] = n4; k[5] = n5;
    const float r6 = u6 + p6, r7 = u7 + p7, r8 = u8 + p8;
    const float n6 = k6 + q6, n7 = k7 + q7, n8 = k8 + q8;
    const float p9 = k9 * l, p10 = k10 * l, p11 = k11 * l;
    const float q9 = u9 * g, q10 = u10 * g, q11 = u11 * g;
    const float u12 = u[12], u13 = u[13], u14 = u[14];
    const float k12 = k[12], k13 = k[13], k14 = k[14];
    u[0] = t0; u[1] = t1; u[2] = t2;
    const float t3 = s3 - grid, t4 = s4 - grid, t5 = s5 - grid;
    const float s6 = r6 + grid, s7 = r7 + grid, s8 = r8 + grid;
    k[6] = n6; k[7] = n7; k[8] = n8;
    const float r9 = u9 + p9, r10 = u10 + p10, r11 = u11 + p11;
    const float n9 = k9 + q9, n10 = k10 + q10, n11 = k11 + q11;
    const float p12 = k12 * l, p13 = k13 * l, p14 = k14 * l;
    const float q12 = u12 * g, q13 = u13 * g, q14 = u14 * g;
    const float u15 = u[15], u16 = u[16], u17 = u[17];
    const float k15 = k[15], k16 = k[16], k17 = k[17];
    u[3] = t3; u[4] = t4; u[5] = t5;
    const float t6 = s6 - grid, t7 = s7 - grid, t8 = s8 - grid;
    const float s9 = r9 + grid, s10 = r10 + grid, s11 = r11 + grid;
    k[9] = n9; k[10] = n10; k[11] = n11;
    const float r12 = u12 + p12, r13 = u13 + p13, r14 = u14 + p14;
    const float n12 = k12 + q12, n13 = k13 + q13, n14 = k14 + q14;
    const float p15 = k15 * l, p16 = k16 * l, p17 = k17 * l;
    const float q15 = u15 * g, q16 = u16 * g, q17 = u17 * g;
    const float u18 = u[18], u19 = u[19], u20 = u[20];
    const float k18 = k[18], k19 = k[19], k20 = k[20];
    u[6] = t6; u[7] = t7; u[8] = t8;
    const float t9 = s9 - grid, t10 = s10 - grid, t11 = s11 - grid;
    const float s12 = r12 + grid, s13 = r13 + grid, s14 = r14 + grid;
    k[12] = n12; k[13] = n13; k[14] = n14;
    const float r15 = u15 + p15, r16 = u16 + p16, r17 = u17 + p17;
    const float n15 = k15 + q15, n16 = k16 + q16, n17 = k17 + q17;
    const float p18 = k18 * l, p19 = k19 * l, p20 = k20 * l;
    const float q18 = u18 * g, q19 = u19 * g, q20 = u20 * g;
    const float u21 = u[21], u22 = u[22], u23 = u[23];
    const float k21 = k[21], k22 = k[22], k23 = k[23];
    u[9] = t9; u[10] = t10; u[11] = t11;
    const float t12 = s12 - grid, t13 = s13 - grid, t14 = s14 - grid;
    const float s15 = r15 + grid, s16 = r16 + grid, s17 = r17 + grid;
    k[15] = n15; k[16] = n16; k[17] = n17;
    const float r18 = u18 + p18, r19 = u19 + p19, r20 = u20 + p20;
    const float n18 = k18 + q18, n19 = k19 + q19, n20 = k20 + q20;
    const float p21 = k21 * l, p22 = k22 * l, p23 = k23 * l;
    const float q21 = u21 * g, q22 = u22 * g, q23 = u23 * g;
    const float u24 = u[24];
    const float k24 = k[24];
    u[12] = t12; u[13] = t13; u[14] = t14;
    const float t15 = s15 - grid, t16 = s16 - grid, t17 = s17 - grid;
    const float s18 = r18 + grid, s19 = r19 + grid, s20 = r20 + grid;
    k[18] = n18; k[19] = n19; k[20] = n20;
    const float r21 = u21 + p21, r22 = u22 + p22, r23 = u23 + p23;
    const float n21 = k21 + q21, n22 = k22 + q22, n23 = k23 + q23;
    const float p24 = k24 * l;
    const float q24 = u24 * g;
    u[15] = t15; u[16] = t16; u[17] = t17;
    const float t18 = s18 - grid, t19 = s19 - grid, t20 = s20 - grid;
    const float s21 = r21 + grid, s22 = r22 + grid, s23 = r23 + grid;
    k[21] = n21; k[22] = n22; k[23] = n23;
    const float r24 = u24 + p24;
    const float n24 = k24 + q24;
    u[18] = t18; u[19] = t19; u[20] = t20;
    const float t21 = s21 - grid, t22 = s22 - grid, t23 = s23 - grid;
    const float s24 = r24 + grid;
    k[24] = n24;
    u[21] = t21; u[22] = t22; u[23] = t23;
    const float t24 = s24 - grid;
    u[24] = t24;
}

/* f = U' x and g = D f, columns 0 to 11. */
static EXTENDED_STRAIGHT void extended_project_0(extended_learner_t *self)
{
    const float grid = 1.09139364e-11f;
    const float inflate = self->inflate;

    extended_project_columns(self, 0u);
    extended_project_columns(self, 6u);
    const float d0 = self->d[0] * inflate, d1 = self->d[1] * inflate, d2 = self->d[2] * inflate,
            d3 = self->d[3] * inflate, d4 = self->d[4] * inflate, d5 = self->d[5] * inflate;
    const float d6 = self->d[6] * inflate, d7 = self->d[7] * inflate, d8 = self->d[8] * inflate,
            d9 = self->d[9] * inflate, d10 = self->d[10] * inflate, d11 = self->d[11] * inflate;
    const float g0 = d0 * self->f[0], g1 = d1 * self->f[1], g2 = d2 * self->f[2], g3 = d3 * self->f[3],
            g4 = d4 * self->f[4], g5 = d5 * self->f[5];
    const float g6 = d6 * self->f[6], g7 = d7 * self->f[7], g8 = d8 * self->f[8], g9 = d9 * self->f[9],
            g10 = d10 * self->f[10], g11 = d11 * self->f[11];
    const float h0 = g0 + grid, h1 = g1 + grid, h2 = g2 + grid, h3 = g3 + grid, h4 = g4 + grid,
            h5 = g5 + grid;
    const float h6 = g6 + grid, h7 = g7 + grid, h8 = g8 + grid, h9 = g9 + grid, h10 = g10 + grid,
            h11 = g11 + grid;
    self->g[0] = h0 - grid; self->g[1] = h1 - grid; self->g[2] = h2 - grid;
            self->g[3] = h3 - grid; self->g[4] = h4 - grid; self->g[5] = h5 - grid;
    self->g[6] = h6 - grid; self->g[7] = h7 - grid; self->g[8] = h8 - grid;
            self->g[9] = h9 - grid; self->g[10] = h10 - grid; self->g[11] = h11 - grid;
}

/* f = U' x and g = D f, columns 12 to 24. */
static EXTENDED_STRAIGHT void extended_project_1(extended_learner_t *self)
{
    const float grid = 1.09139364e-11f;
    const float inflate = self->inflate;

    extended_project_columns(self, 12u);
    extended_project_columns(self, 18u);
    extended_project_columns(self, 19u);
    const float d12 = self->d[12] * inflate, d13 = self->d[13] * inflate, d14 = self->d[14] * inflate,
            d15 = self->d[15] * inflate, d16 = self->d[16] * inflate, d17 = self->d[17] * inflate;
    const float d18 = self->d[18] * inflate, d19 = self->d[19] * inflate, d20 = self->d[20] * inflate,
            d21 = self->d[21] * inflate, d22 = self->d[22] * inflate, d23 = self->d[23] * inflate;
    const float d24 = self->d[24] * inflate;
    const float g12 = d12 * self->f[12], g13 = d13 * self->f[13], g14 = d14 * self->f[14],
            g15 = d15 * self->f[15], g16 = d16 * self->f[16], g17 = d17 * self->f[17];
    const float g18 = d18 * self->f[18], g19 = d19 * self->f[19], g20 = d20 * self->f[20],
            g21 = d21 * self->f[21], g22 = d22 * self->f[22], g23 = d23 * self->f[23];
    const float g24 = d24 * self->f[24];
    const float h12 = g12 + grid, h13 = g13 + grid, h14 = g14 + grid, h15 = g15 + grid, h16 = g16 + grid,
            h17 = g17 + grid;
    const float h18 = g18 + grid, h19 = g19 + grid, h20 = g20 + grid, h21 = g21 + grid, h22 = g22 + grid,
            h23 = g23 + grid;
    const float h24 = g24 + grid;
    self->g[12] = h12 - grid; self->g[13] = h13 - grid; self->g[14] = h14 - grid;
            self->g[15] = h15 - grid; self->g[16] = h16 - grid; self->g[17] = h17 - grid;
    self->g[18] = h18 - grid; self->g[19] = h19 - grid; self->g[20] = h20 - grid;
            self->g[21] = h21 - grid; self->g[22] = h22 - grid; self->g[23] = h23 - grid;
    self->g[24] = h24 - grid;
}

/* U and P x, columns 0 to 5. */
static EXTENDED_STRAIGHT void extended_factor_0(extended_learner_t *self)
{
    self->k[0] = 0.0f; self->k[1] = 0.0f; self->k[2] = 0.0f; self->k[3] = 0.0f;
            self->k[4] = 0.0f; self->k[5] = 0.0f;
    self->k[6] = 0.0f; self->k[7] = 0.0f; self->k[8] = 0.0f; self->k[9] = 0.0f;
            self->k[10] = 0.0f; self->k[11] = 0.0f;
    self->k[12] = 0.0f; self->k[13] = 0.0f; self->k[14] = 0.0f; self->k[15] = 0.0f;
            self->k[16] = 0.0f; self->k[17] = 0.0f;
    self->k[18] = 0.0f; self->k[19] = 0.0f; self->k[20] = 0.0f; self->k[21] = 0.0f;
            self->k[22] = 0.0f; self->k[23] = 0.0f;
    self->k[24] = 0.0f;
    extended_factor_column(self, 0u);
    extended_factor_column(self, 1u);
    extended_factor_column(self, 2u);
    extended_factor_column(self, 3u);
    extended_factor_column(self, 4u);
    extended_factor_column(self, 5u);
}

/* U and P x, columns 6 to 11. */
static EXTENDED_STRAIGHT void extended_factor_1(extended_learner_t *self)
{
    extended_factor_column(self, 6u);
    extended_factor_column(self, 7u);
    extended_factor_column(self, 8u);
    extended_factor_column(self, 9u);
    extended_factor_column(self, 10u);
    extended_factor_column(self, 11u);
}

/* U and P x, columns 12 to 17. */
static EXTENDED_STRAIGHT void extended_factor_2(extended_learner_t *self)
{
    extended_factor_column(self, 12u);
    extended_factor_column(self, 13u);
    extended_factor_column(self, 14u);
    extended_factor_column(self, 15u);
    extended_factor_column(self, 16u);
    extended_factor_column(self, 17u);
}

/* U and P x, columns 18 to 23. */
static EXTENDED_STRAIGHT void extended_factor_3(extended_learner_t *self)
{
    extended_factor_column(self, 18u);
    extended_factor_column(self, 19u);
    extended_factor_column(self, 20u);
    extended_factor_column(self, 21u);
    extended_factor_column(self, 22u);
    extended_factor_column(self, 23u);
}

/* U and P x, column 24. */
static EXTENDED_STRAIGHT void extended_factor_4(extended_learner_t *self)
{
    extended_factor_column(self, 24u);
}

/* 1 if the sample behind f and g may be learnt from. Its innovation is expected to be up to the usual one times
 * sqrt(alpha), alpha = 1 + x' P x, for where the learner knows little it errs more. */
static uint32_t extended_admit(extended_learner_t *self, float alpha)
{
    const float e = self->innovation_um;
    const float size = extended_float(extended_bits(e) & 0x7fffffffu);
    const float limit = EXTENDED_LEARN_GATE * self->scale_um + (2.0f * self->moving_um + EXTENDED_LEARN_GATE_FLOOR_UM);
    const float square = limit * limit;
    const uint32_t far = (uint32_t)(e * e > square * alpha);
    const uint32_t quiet = (uint32_t)(size < EXTENDED_LEARN_DEAD_ZONE_UM) & (uint32_t)(alpha < 1.25f) & (uint32_t)(self->inflate > 1.0f);
    uint32_t changed;
    uint32_t outlier;

    if (alpha < 2.0f) {
        uint32_t cut;
        const float most = 4.0f * self->scale_um + EXTENDED_LEARN_GATE_FLOOR_UM;
        const float seen = extended_limited(size, 0.0f, most, &cut) + EXTENDED_LEARN_FLOOR_UM;

        self->scale_um = self->scale_um + EXTENDED_LEARN_FAST * (seen - self->scale_um);
    }
    self->run = (self->run + far) - ((far ^ 1u) & (uint32_t)(self->run > 0u));
    changed = (uint32_t)(self->run >= EXTENDED_LEARN_OUTLIER_RUN);
    outlier = far & (changed ^ 1u);
    if (changed != 0u) {
        self->run = 0u;
        if (size > self->scale_um) {
            self->scale_um = size;
        }
    }
    extended_count_learner_event(self, &self->outliers, outlier, EXTENDED_LEARN_OUTLIER);
    extended_count_learner_event(self, &self->changes, changed, EXTENDED_LEARN_CHANGED);
    extended_count_learner_event(self, &self->quiet, quiet, EXTENDED_LEARN_QUIET);
    return (outlier | quiet) ^ 1u;
}

/* r_i = 1 / a_i, 9 side by side from c on: those of extended_reciprocal. */
static EXTENDED_STRAIGHT void extended_reciprocals(const float *a, float *r, uint32_t c)
{
    const float a0 = a[c + 0u], a1 = a[c + 1u], a2 = a[c + 2u], a3 = a[c + 3u], a4 = a[c + 4u],
            a5 = a[c + 5u], a6 = a[c + 6u], a7 = a[c + 7u], a8 = a[c + 8u];
    float r0 = extended_float(0x7ef311c7u - extended_bits(a0)),
            r1 = extended_float(0x7ef311c7u - extended_bits(a1)),
            r2 = extended_float(0x7ef311c7u - extended_bits(a2)),
            r3 = extended_float(0x7ef311c7u - extended_bits(a3)),
            r4 = extended_float(0x7ef311c7u - extended_bits(a4)),
            r5 = extended_float(0x7ef311c7u - extended_bits(a5)),
            r6 = extended_float(0x7ef311c7u - extended_bits(a6)),
            r7 = extended_float(0x7ef311c7u - extended_bits(a7)),
            r8 = extended_float(0x7ef311c7u - extended_bits(a8));
    float t0 = a0 * r0, t1 = a1 * r1, t2 = a2 * r2, t3 = a3 * r3, t4 = a4 * r4, t5 = a5 * r5,
            t6 = a6 * r6, t7 = a7 * r7, t8 = a8 * r8;

    t0 = 2.0f - t0; t1 = 2.0f - t1; t2 = 2.0f - t2; t3 = 2.0f - t3; t4 = 2.0f - t4;
            t5 = 2.0f - t5; t6 = 2.0f - t6; t7 = 2.0f - t7; t8 = 2.0f - t8;
    r0 = r0 * t0; r1 = r1 * t1; r2 = r2 * t2; r3 = r3 * t3; r4 = r4 * t4; r5 = r5 * t5;
            r6 = r6 * t6; r7 = r7 * t7; r8 = r8 * t8;
    t0 = a0 * r0; t1 = a1 * r1; t2 = a2 * r2; t3 = a3 * r3; t4 = a4 * r4; t5 = a5 * r5;
            t6 = a6 * r6; t7 = a7 * r7; t8 = a8 * r8;
    t0 = 2.0f - t0; t1 = 2.0f - t1; t2 = 2.0f - t2; t3 = 2.0f - t3; t4 = 2.0f - t4;
            t5 = 2.0f - t5; t6 = 2.0f - t6; t7 = 2.0f - t7; t8 = 2.0f - t8;
    r0 = r0 * t0; r1 = r1 * t1; r2 = r2 * t2; r3 = r3 * t3; r4 = r4 * t4; r5 = r5 * t5;
            r6 = r6 * t6; r7 = r7 * t7; r8 = r8 * t8;
    t0 = a0 * r0; t1 = a1 * r1; t2 = a2 * r2; t3 = a3 * r3; t4 = a4 * r4; t5 = a5 * r5;
            t6 = a6 * r6; t7 = a7 * r7; t8 = a8 * r8;
    t0 = 2.0f - t0; t1 = 2.0f - t1; t2 = 2.0f - t2; t3 = 2.0f - t3; t4 = 2.0f - t4;
            t5 = 2.0f - t5; t6 = 2.0f - t6; t7 = 2.0f - t7; t8 = 2.0f - t8;
    r0 = r0 * t0; r1 = r1 * t1; r2 = r2 * t2; r3 = r3 * t3; r4 = r4 * t4; r5 = r5 * t5;
            r6 = r6 * t6; r7 = r7 * t7; r8 = r8 * t8;
    r[c + 0u] = r0; r[c + 1u] = r1; r[c + 2u] = r2; r[c + 3u] = r3; r[c + 4u] = r4;
            r[c + 5u] = r5; r[c + 6u] = r6; r[c + 7u] = r7; r[c + 8u] = r8;
}

/* alpha_j = alpha_(j-1) + f_j g_j from alpha = 1 on, l_j = -f_j / alpha_(j-1), D_j <- D_j / lambda * alpha_(j-1) / alpha_j.
 * The reciprocals are those of extended_reciprocal, several side by side. Returns 1 if the shadow has to start again. */
static EXTENDED_STRAIGHT uint32_t extended_update_diagonal(extended_learner_t *self)
{
    const float inflate = self->inflate;
    const float least = EXTENDED_LEARN_LEAST_VARIANCE;
    uint32_t clamped = 0u;
    float a[EXTENDED_LEARNED];
    float r[EXTENDED_LEARNED];
    const float m0 = self->f[0] * self->g[0];
    const float m1 = self->f[1] * self->g[1];
    const float m2 = self->f[2] * self->g[2];
    const float m3 = self->f[3] * self->g[3];
    const float m4 = self->f[4] * self->g[4];
    const float m5 = self->f[5] * self->g[5];
    const float m6 = self->f[6] * self->g[6];
    const float m7 = self->f[7] * self->g[7];
    const float m8 = self->f[8] * self->g[8];
    const float m9 = self->f[9] * self->g[9];
    const float m10 = self->f[10] * self->g[10];
    const float m11 = self->f[11] * self->g[11];
    const float a0 = 1.0f + m0;
    const float a1 = a0 + m1;
    const float a2 = a1 + m2;
    const float a3 = a2 + m3;
    const float a4 = a3 + m4;
    const float a5 = a4 + m5;
    const float m12 = self->f[12] * self->g[12];
    const float m13 = self->f[13] * self->g[13];
    const float m14 = self->f[14] * self->g[14];
    const float m15 = self->f[15] * self->g[15];
    const float m16 = self->f[16] * self->g[16];
    const float m17 = self->f[17] * self->g[17];
    a[0] = a0;
    a[1] = a1;
    a[2] = a2;
    a[3] = a3;
    a[4] = a4;
    a[5] = a5;
    const float a6 = a5 + m6;
    const float a7 = a6 + m7;
    const float a8 = a7 + m8;
    const float a9 = a8 + m9;
    const float a10 = a9 + m10;
    const float a11 = a10 + m11;
    const float m18 = self->f[18] * self->g[18];
    const float m19 = self->f[19] * self->g[19];
    const float m20 = self->f[20] * self->g[20];
    const float m21 = self->f[21] * self->g[21];
    const float m22 = self->f[22] * self->g[22];
    const float m23 = self->f[23] * self->g[23];
    a[6] = a6;
    a[7] = a7;
    a[8] = a8;
    a[9] = a9;
    a[10] = a10;
    a[11] = a11;
    const float a12 = a11 + m12;
    const float a13 = a12 + m13;
    const float a14 = a13 + m14;
    const float a15 = a14 + m15;
    const float a16 = a15 + m16;
    const float a17 = a16 + m17;
    const float m24 = self->f[24] * self->g[24];
    a[12] = a12;
    a[13] = a13;
    a[14] = a14;
    a[15] = a15;
    a[16] = a16;
    a[17] = a17;
    const float a18 = a17 + m18;
    const float a19 = a18 + m19;
    const float a20 = a19 + m20;
    const float a21 = a20 + m21;
    const float a22 = a21 + m22;
    const float a23 = a22 + m23;
    a[18] = a18;
    a[19] = a19;
    a[20] = a20;
    a[21] = a21;
    a[22] = a22;
    a[23] = a23;
    const float a24 = a23 + m24;
    a[24] = a24;

    /* Only rounding gone wild brings alpha here; in the order of the bits this also finds what is not finite. */
    if (extended_bits(a24) >= extended_bits(EXTENDED_LEARN_LARGEST_DENOMINATOR)) {
        return 1u;
    }
    if (self->measuring != 0u && extended_admit(self, a24) == 0u) {
        self->phase = 0u;
        return 0u;
    }

    extended_reciprocals(a, r, 0u);
    extended_reciprocals(a, r, 9u);
    extended_reciprocals(a, r, 16u);
    const float l0 = self->f[0];
    const float q0 = r[0];
    const float l1 = self->f[1] * r[0];
    const float q1 = a[0] * r[1];
    const float l2 = self->f[2] * r[1];
    const float q2 = a[1] * r[2];
    const float d0 = self->d[0] * inflate, d1 = self->d[1] * inflate, d2 = self->d[2] * inflate;
    const float v0 = d0 * q0, v1 = d1 * q1, v2 = d2 * q2;
    const float c0 = extended_learn_ceiling[0], c1 = extended_learn_ceiling[1],
            c2 = extended_learn_ceiling[2];
    self->l[0] = -l0; self->l[1] = -l1; self->l[2] = -l2;
    const float l3 = self->f[3] * r[2];
    const float q3 = a[2] * r[3];
    const float l4 = self->f[4] * r[3];
    const float q4 = a[3] * r[4];
    const float l5 = self->f[5] * r[4];
    const float q5 = a[4] * r[5];
    const float d3 = self->d[3] * inflate, d4 = self->d[4] * inflate, d5 = self->d[5] * inflate;
    const uint32_t below0 = extended_mask((uint32_t)(v0 < least)),
            below1 = extended_mask((uint32_t)(v1 < least)),
            below2 = extended_mask((uint32_t)(v2 < least));
    const uint32_t above0 = extended_mask((uint32_t)(v0 > c0)), above1 = extended_mask((uint32_t)(v1 > c1)),
            above2 = extended_mask((uint32_t)(v2 > c2));
    const uint32_t inside0 = extended_bits(v0) & ~(below0 | above0),
            inside1 = extended_bits(v1) & ~(below1 | above1),
            inside2 = extended_bits(v2) & ~(below2 | above2);
    const uint32_t end0 = (extended_bits(least) & below0) | (extended_bits(c0) & above0),
            end1 = (extended_bits(least) & below1) | (extended_bits(c1) & above1),
            end2 = (extended_bits(least) & below2) | (extended_bits(c2) & above2);
    self->d[0] = extended_float(inside0 | end0); self->d[1] = extended_float(inside1 | end1);
            self->d[2] = extended_float(inside2 | end2);
    clamped |= below0 | above0 | below1 | above1 | below2 | above2;
    const float v3 = d3 * q3, v4 = d4 * q4, v5 = d5 * q5;
    const float c3 = extended_learn_ceiling[3], c4 = extended_learn_ceiling[4],
            c5 = extended_learn_ceiling[5];
    self->l[3] = -l3; self->l[4] = -l4; self->l[5] = -l5;
    const float l6 = self->f[6] * r[5];
    const float q6 = a[5] * r[6];
    const float l7 = self->f[7] * r[6];
    const float q7 = a[6] * r[7];
    const float l8 = self->f[8] * r[7];
    const float q8 = a[7] * r[8];
    const float d6 = self->d[6] * inflate, d7 = self->d[7] * inflate, d8 = self->d[8] * inflate;
    const uint32_t below3 = extended_mask((uint32_t)(v3 < least)),
            below4 = extended_mask((uint32_t)(v4 < least)),
            below5 = extended_mask((uint32_t)(v5 < least));
    const uint32_t above3 = extended_mask((uint32_t)(v3 > c3)), above4 = extended_mask((uint32_t)(v4 > c4)),
            above5 = extended_mask((uint32_t)(v5 > c5));
    const uint32_t inside3 = extended_bits(v3) & ~(below3 | above3),
            inside4 = extended_bits(v4) & ~(below4 | above4),
            inside5 = extended_bits(v5) & ~(below5 | above5);
    const uint32_t end3 = (extended_bits(least) & below3) | (extended_bits(c3) & above3),
            end4 = (extended_bits(least) & below4) | (extended_bits(c4) & above4),
            end5 = (extended_bits(least) & below5) | (extended_bits(c5) & above5);
    self->d[3] = extended_float(inside3 | end3); self->d[4] = extended_float(inside4 | end4);
            self->d[5] = extended_float(inside5 | end5);
    clamped |= below3 | above3 | below4 | above4 | below5 | above5;
    const float v6 = d6 * q6, v7 = d7 * q7, v8 = d8 * q8;
    const float c6 = extended_learn_ceiling[6], c7 = extended_learn_ceiling[7],
            c8 = extended_learn_ceiling[8];
    self->l[6] = -l6; self->l[7] = -l7; self->l[8] = -l8;
    const float l9 = self->f[9] * r[8];
    const float q9 = a[8] * r[9];
    const float l10 = self->f[10] * r[9];
    const float q10 = a[9] * r[10];
    const float l11 = self->f[11] * r[10];
    const float q11 = a[10] * r[11];
    const float d9 = self->d[9] * inflate, d10 = self->d[10] * inflate, d11 = self->d[11] * inflate;
    const uint32_t below6 = extended_mask((uint32_t)(v6 < least)),
            below7 = extended_mask((uint32_t)(v7 < least)),
            below8 = extended_mask((uint32_t)(v8 < least));
    const uint32_t above6 = extended_mask((uint32_t)(v6 > c6)), above7 = extended_mask((uint32_t)(v7 > c7)),
            above8 = extended_mask((uint32_t)(v8 > c8));
    const uint32_t inside6 = extended_bits(v6) & ~(below6 | above6),
            inside7 = extended_bits(v7) & ~(below7 | above7),
            inside8 = extended_bits(v8) & ~(below8 | above8);
    const uint32_t end6 = (extended_bits(least) & below6) | (extended_bits(c6) & above6),
            end7 = (extended_bits(least) & below7) | (extended_bits(c7) & above7),
            end8 = (extended_bits(least) & below8) | (extended_bits(c8) & above8);
    self->d[6] = extended_float(inside6 | end6); self->d[7] = extended_float(inside7 | end7);
            self->d[8] = extended_float(inside8 | end8);
    clamped |= below6 | above6 | below7 | above7 | below8 | above8;
    const float v9 = d9 * q9, v10 = d10 * q10, v11 = d11 * q11;
    const float c9 = extended_learn_ceiling[9], c10 = extended_learn_ceiling[10],
            c11 = extended_learn_ceiling[11];
    self->l[9] = -l9; self->l[10] = -l10; self->l[11] = -l11;
    const float l12 = self->f[12] * r[11];
    const float q12 = a[11] * r[12];
    const float l13 = self->f[13] * r[12];
    const float q13 = a[12] * r[13];
    const float l14 = self->f[14] * r[13];
    const float q14 = a[13] * r[14];
    const float d12 = self->d[12] * inflate, d13 = self->d[13] * inflate, d14 = self->d[14] * inflate;
    const uint32_t below9 = extended_mask((uint32_t)(v9 < least)),
            below10 = extended_mask((uint32_t)(v10 < least)),
            below11 = extended_mask((uint32_t)(v11 < least));
    const uint32_t above9 = extended_mask((uint32_t)(v9 > c9)), above10 = extended_mask((uint32_t)(v10 > c10)),
            above11 = extended_mask((uint32_t)(v11 > c11));
    const uint32_t inside9 = extended_bits(v9) & ~(below9 | above9),
            inside10 = extended_bits(v10) & ~(below10 | above10),
            inside11 = extended_bits(v11) & ~(below11 | above11);
    const uint32_t end9 = (extended_bits(least) & below9) | (extended_bits(c9) & above9),
            end10 = (extended_bits(least) & below10) | (extended_bits(c10) & above10),
            end11 = (extended_bits(least) & below11) | (extended_bits(c11) & above11);
    self->d[9] = extended_float(inside9 | end9); self->d[10] = extended_float(inside10 | end10);
            self->d[11] = extended_float(inside11 | end11);
    clamped |= below9 | above9 | below10 | above10 | below11 | above11;
    const float v12 = d12 * q12, v13 = d13 * q13, v14 = d14 * q14;
    const float c12 = extended_learn_ceiling[12], c13 = extended_learn_ceiling[13],
            c14 = extended_learn_ceiling[14];
    self->l[12] = -l12; self->l[13] = -l13; self->l[14] = -l14;
    const float l15 = self->f[15] * r[14];
    const float q15 = a[14] * r[15];
    const float l16 = self->f[16] * r[15];
    const float q16 = a[15] * r[16];
    const float l17 = self->f[17] * r[16];
    const float q17 = a[16] * r[17];
    const float d15 = self->d[15] * inflate, d16 = self->d[16] * inflate, d17 = self->d[17] * inflate;
    const uint32_t below12 = extended_mask((uint32_t)(v12 < least)),
            below13 = extended_mask((uint32_t)(v13 < least)),
            below14 = extended_mask((uint32_t)(v14 < least));
    const uint32_t above12 = extended_mask((uint32_t)(v12 > c12)),
            above13 = extended_mask((uint32_t)(v13 > c13)),
            above14 = extended_mask((uint32_t)(v14 > c14));
    const uint32_t inside12 = extended_bits(v12) & ~(below12 | above12),
            inside13 = extended_bits(v13) & ~(below13 | above13),
            inside14 = extended_bits(v14) & ~(below14 | above14);
    const uint32_t end12 = (extended_bits(least) & below12) | (extended_bits(c12) & above12),
            end13 = (extended_bits(least) & below13) | (extended_bits(c13) & above13),
            end14 = (extended_bits(least) & below14) | (extended_bits(c14) & above14);
    self->d[12] = extended_float(inside12 | end12);
            self->d[13] = extended_float(inside13 | end13);
            self->d[14] = extended_float(inside14 | end14);
    clamped |= below12 | above12 | below13 | above13 | below14 | above14;
    const float v15 = d15 * q15, v16 = d16 * q16, v17 = d17 * q17;
    const float c15 = extended_learn_ceiling[15], c16 = extended_learn_ceiling[16],
            c17 = extended_learn_ceiling[17];
    self->l[15] = -l15; self->l[16] = -l16; self->l[17] = -l17;
    const float l18 = self->f[18] * r[17];
    const float q18 = a[17] * r[18];
    const float l19 = self->f[19] * r[18];
    const float q19 = a[18] * r[19];
    const float l20 = self->f[20] * r[19];
    const float q20 = a[19] * r[20];
    const float d18 = self->d[18] * inflate, d19 = self->d[19] * inflate, d20 = self->d[20] * inflate;
    const uint32_t below15 = extended_mask((uint32_t)(v15 < least)),
            below16 = extended_mask((uint32_t)(v16 < least)),
            below17 = extended_mask((uint32_t)(v17 < least));
    const uint32_t above15 = extended_mask((uint32_t)(v15 > c15)),
            above16 = extended_mask((uint32_t)(v16 > c16)),
            above17 = extended_mask((uint32_t)(v17 > c17));
    const uint32_t inside15 = extended_bits(v15) & ~(below15 | above15),
            inside16 = extended_bits(v16) & ~(below16 | above16),
            inside17 = extended_bits(v17) & ~(below17 | above17);
    const uint32_t end15 = (extended_bits(least) & below15) | (extended_bits(c15) & above15),
            end16 = (extended_bits(least) & below16) | (extended_bits(c16) & above16),
            end17 = (extended_bits(least) & below17) | (extended_bits(c17) & above17);
    self->d[15] = extended_float(inside15 | end15);
            self->d[16] = extended_float(inside16 | end16);
            self->d[17] = extended_float(inside17 | end17);
    clamped |= below15 | above15 | below16 | above16 | below17 | above17;
    const float v18 = d18 * q18, v19 = d19 * q19, v20 = d20 * q20;
    const float c18 = extended_learn_ceiling[18], c19 = extended_learn_ceiling[19],
            c20 = extended_learn_ceiling[20];
    self->l[18] = -l18; self->l[19] = -l19; self->l[20] = -l20;
    const float l21 = self->f[21] * r[20];
    const float q21 = a[20] * r[21];
    const float l22 = self->f[22] * r[21];
    const float q22 = a[21] * r[22];
    const float l23 = self->f[23] * r[22];
    const float q23 = a[22] * r[23];
    const float d21 = self->d[21] * inflate, d22 = self->d[22] * inflate, d23 = self->d[23] * inflate;
    const uint32_t below18 = extended_mask((uint32_t)(v18 < least)),
            below19 = extended_mask((uint32_t)(v19 < least)),
            below20 = extended_mask((uint32_t)(v20 < least));
    const uint32_t above18 = extended_mask((uint32_t)(v18 > c18)),
            above19 = extended_mask((uint32_t)(v19 > c19)),
            above20 = extended_mask((uint32_t)(v20 > c20));
    const uint32_t inside18 = extended_bits(v18) & ~(below18 | above18),
            inside19 = extended_bits(v19) & ~(below19 | above19),
            inside20 = extended_bits(v20) & ~(below20 | above20);
    const uint32_t end18 = (extended_bits(least) & below18) | (extended_bits(c18) & above18),
            end19 = (extended_bits(least) & below19) | (extended_bits(c19) & above19),
            end20 = (extended_bits(least) & below20) | (extended_bits(c20) & above20);
    self->d[18] = extended_float(inside18 | end18);
            self->d[19] = extended_float(inside19 | end19);
            self->d[20] = extended_float(inside20 | end20);
    clamped |= below18 | above18 | below19 | above19 | below20 | above20;
    const float v21 = d21 * q21, v22 = d22 * q22, v23 = d23 * q23;
    const float c21 = extended_learn_ceiling[21], c22 = extended_learn_ceiling[22],
            c23 = extended_learn_ceiling[23];
    self->l[21] = -l21; self->l[22] = -l22; self->l[23] = -l23;
    const float l24 = self->f[24] * r[23];
    const float q24 = a[23] * r[24];
    const float d24 = self->d[24] * inflate;
    const uint32_t below21 = extended_mask((uint32_t)(v21 < least)),
            below22 = extended_mask((uint32_t)(v22 < least)),
            below23 = extended_mask((uint32_t)(v23 < least));
    const uint32_t above21 = extended_mask((uint32_t)(v21 > c21)),
            above22 = extended_mask((uint32_t)(v22 > c22)),
            above23 = extended_mask((uint32_t)(v23 > c23));
    const uint32_t inside21 = extended_bits(v21) & ~(below21 | above21),
            inside22 = extended_bits(v22) & ~(below22 | above22),
            inside23 = extended_bits(v23) & ~(below23 | above23);
    const uint32_t end21 = (extended_bits(least) & below21) | (extended_bits(c21) & above21),
            end22 = (extended_bits(least) & below22) | (extended_bits(c22) & above22),
            end23 = (extended_bits(least) & below23) | (extended_bits(c23) & above23);
    self->d[21] = extended_float(inside21 | end21);
            self->d[22] = extended_float(inside22 | end22);
            self->d[23] = extended_float(inside23 | end23);
    clamped |= below21 | above21 | below22 | above22 | below23 | above23;
    const float v24 = d24 * q24;
    const float c24 = extended_learn_ceiling[24];
    self->l[24] = -l24;
    const uint32_t below24 = extended_mask((uint32_t)(v24 < least));
    const uint32_t above24 = extended_mask((uint32_t)(v24 > c24));
    const uint32_t inside24 = extended_bits(v24) & ~(below24 | above24);
    const uint32_t end24 = (extended_bits(least) & below24) | (extended_bits(c24) & above24);
    self->d[24] = extended_float(inside24 | end24);
    clamped |= below24 | above24;
    self->per_alpha = r[24];
    extended_count_learner_event(self, &self->clamped, clamped & 1u, EXTENDED_LEARN_CLAMPED);
    return 0u;
}

/* |x| as bits: in the order of the magnitudes. */
EXTENDED_INLINE uint32_t extended_size(float x)
{
    return extended_bits(x) & 0x7fffffffu;
}

EXTENDED_INLINE uint32_t extended_larger(uint32_t a, uint32_t b)
{
    return a ^ ((a ^ b) & extended_mask((uint32_t)(b > a)));
}

/* 1 if a parameter is beyond its limit. */
EXTENDED_INLINE uint32_t extended_beyond(float theta)
{
    return (uint32_t)(extended_size(theta) >= extended_bits(EXTENDED_LEARN_LIMIT_UM));
}

/* theta <- theta + P x / alpha * innovation, P x in k. A step that would move a parameter by more than the limit is
 * shortened as a whole. theta is a sum of two words, for most steps are smaller than its last bit. Returns 1 if the
 * shadow has to start again. */
static EXTENDED_STRAIGHT uint32_t extended_step(extended_learner_t *self)
{
    const float grid = 3.57627869e-07f;
    uint32_t largest = 0u;
    uint32_t beyond = 0u;
    float size;
    float q = self->innovation_um * self->per_alpha;

    uint32_t k0 = extended_size(self->k[0]);
    uint32_t k1 = extended_size(self->k[1]);
    uint32_t k2 = extended_size(self->k[2]);
    uint32_t k3 = extended_size(self->k[3]);
    uint32_t k4 = extended_size(self->k[4]);
    uint32_t k5 = extended_size(self->k[5]);
    k0 = extended_larger(k0, extended_size(self->k[6]));
    k1 = extended_larger(k1, extended_size(self->k[7]));
    k2 = extended_larger(k2, extended_size(self->k[8]));
    k3 = extended_larger(k3, extended_size(self->k[9]));
    k4 = extended_larger(k4, extended_size(self->k[10]));
    k5 = extended_larger(k5, extended_size(self->k[11]));
    k0 = extended_larger(k0, extended_size(self->k[12]));
    k1 = extended_larger(k1, extended_size(self->k[13]));
    k2 = extended_larger(k2, extended_size(self->k[14]));
    k3 = extended_larger(k3, extended_size(self->k[15]));
    k4 = extended_larger(k4, extended_size(self->k[16]));
    k5 = extended_larger(k5, extended_size(self->k[17]));
    k0 = extended_larger(k0, extended_size(self->k[18]));
    k1 = extended_larger(k1, extended_size(self->k[19]));
    k2 = extended_larger(k2, extended_size(self->k[20]));
    k3 = extended_larger(k3, extended_size(self->k[21]));
    k4 = extended_larger(k4, extended_size(self->k[22]));
    k5 = extended_larger(k5, extended_size(self->k[23]));
    k0 = extended_larger(k0, extended_size(self->k[24]));
    largest = extended_larger(largest, k0);
    largest = extended_larger(largest, k1);
    largest = extended_larger(largest, k2);
    largest = extended_larger(largest, k3);
    largest = extended_larger(largest, k4);
    largest = extended_larger(largest, k5);
    size = extended_float(largest) * extended_float(extended_bits(q) & 0x7fffffffu);
    if (size > EXTENDED_LEARN_STEP_UM) {
        q = q * (EXTENDED_LEARN_STEP_UM * extended_reciprocal(size));
        extended_count_learner_event(self, &self->limited, 1u, EXTENDED_LEARN_LIMITED);
    }
    const float s0 = self->k[0] * q, s1 = self->k[1] * q, s2 = self->k[2] * q;
    const float h0 = s0 + grid, h1 = s1 + grid, h2 = s2 + grid;
    const float s3 = self->k[3] * q, s4 = self->k[4] * q, s5 = self->k[5] * q;
    const float t0 = h0 - grid, t1 = h1 - grid, t2 = h2 - grid;
    const float h3 = s3 + grid, h4 = s4 + grid, h5 = s5 + grid;
    const float s6 = self->k[6] * q, s7 = self->k[7] * q, s8 = self->k[8] * q;
    const float low0 = self->theta_low[0] + t0, low1 = self->theta_low[1] + t1,
            low2 = self->theta_low[2] + t2;
    const float high0 = self->theta[0], high1 = self->theta[1], high2 = self->theta[2];
    const float t3 = h3 - grid, t4 = h4 - grid, t5 = h5 - grid;
    const float h6 = s6 + grid, h7 = s7 + grid, h8 = s8 + grid;
    const float s9 = self->k[9] * q, s10 = self->k[10] * q, s11 = self->k[11] * q;
    const float sum0 = high0 + low0, sum1 = high1 + low1, sum2 = high2 + low2;
    const float low3 = self->theta_low[3] + t3, low4 = self->theta_low[4] + t4,
            low5 = self->theta_low[5] + t5;
    const float high3 = self->theta[3], high4 = self->theta[4], high5 = self->theta[5];
    const float t6 = h6 - grid, t7 = h7 - grid, t8 = h8 - grid;
    const float h9 = s9 + grid, h10 = s10 + grid, h11 = s11 + grid;
    const float s12 = self->k[12] * q, s13 = self->k[13] * q, s14 = self->k[14] * q;
    const float kept0 = sum0 - high0, kept1 = sum1 - high1, kept2 = sum2 - high2;
    self->theta[0] = sum0; self->theta[1] = sum1; self->theta[2] = sum2;
    const float sum3 = high3 + low3, sum4 = high4 + low4, sum5 = high5 + low5;
    const float low6 = self->theta_low[6] + t6, low7 = self->theta_low[7] + t7,
            low8 = self->theta_low[8] + t8;
    const float high6 = self->theta[6], high7 = self->theta[7], high8 = self->theta[8];
    const float t9 = h9 - grid, t10 = h10 - grid, t11 = h11 - grid;
    const float h12 = s12 + grid, h13 = s13 + grid, h14 = s14 + grid;
    const float s15 = self->k[15] * q, s16 = self->k[16] * q, s17 = self->k[17] * q;
    const float left0 = low0 - kept0, left1 = low1 - kept1, left2 = low2 - kept2;
    beyond |= extended_beyond(sum0) | extended_beyond(sum1) | extended_beyond(sum2);
    const float kept3 = sum3 - high3, kept4 = sum4 - high4, kept5 = sum5 - high5;
    self->theta[3] = sum3; self->theta[4] = sum4; self->theta[5] = sum5;
    const float sum6 = high6 + low6, sum7 = high7 + low7, sum8 = high8 + low8;
    const float low9 = self->theta_low[9] + t9, low10 = self->theta_low[10] + t10,
            low11 = self->theta_low[11] + t11;
    const float high9 = self->theta[9], high10 = self->theta[10], high11 = self->theta[11];
    const float t12 = h12 - grid, t13 = h13 - grid, t14 = h14 - grid;
    const float h15 = s15 + grid, h16 = s16 + grid, h17 = s17 + grid;
    const float s18 = self->k[18] * q, s19 = self->k[19] * q, s20 = self->k[20] * q;
    self->theta_low[0] = left0; self->theta_low[1] = left1; self->theta_low[2] = left2;
    const float left3 = low3 - kept3, left4 = low4 - kept4, left5 = low5 - kept5;
    beyond |= extended_beyond(sum3) | extended_beyond(sum4) | extended_beyond(sum5);
    const float kept6 = sum6 - high6, kept7 = sum7 - high7, kept8 = sum8 - high8;
    self->theta[6] = sum6; self->theta[7] = sum7; self->theta[8] = sum8;
    const float sum9 = high9 + low9, sum10 = high10 + low10, sum11 = high11 + low11;
    const float low12 = self->theta_low[12] + t12, low13 = self->theta_low[13] + t13,
            low14 = self->theta_low[14] + t14;
    const float high12 = self->theta[12], high13 = self->theta[13], high14 = self->theta[14];
    const float t15 = h15 - grid, t16 = h16 - grid, t17 = h17 - grid;
    const float h18 = s18 + grid, h19 = s19 + grid, h20 = s20 + grid;
    const float s21 = self->k[21] * q, s22 = self->k[22] * q, s23 = self->k[23] * q;
    self->theta_low[3] = left3; self->theta_low[4] = left4; self->theta_low[5] = left5;
    const float left6 = low6 - kept6, left7 = low7 - kept7, left8 = low8 - kept8;
    beyond |= extended_beyond(sum6) | extended_beyond(sum7) | extended_beyond(sum8);
    const float kept9 = sum9 - high9, kept10 = sum10 - high10, kept11 = sum11 - high11;
    self->theta[9] = sum9; self->theta[10] = sum10; self->theta[11] = sum11;
    const float sum12 = high12 + low12, sum13 = high13 + low13, sum14 = high14 + low14;
    const float low15 = self->theta_low[15] + t15, low16 = self->theta_low[16] + t16,
            low17 = self->theta_low[17] + t17;
    const float high15 = self->theta[15], high16 = self->theta[16], high17 = self->theta[17];
    const float t18 = h18 - grid, t19 = h19 - grid, t20 = h20 - grid;
    const float h21 = s21 + grid, h22 = s22 + grid, h23 = s23 + grid;
    const float s24 = self->k[24] * q;
    self->theta_low[6] = left6; self->theta_low[7] = left7; self->theta_low[8] = left8;
    const float left9 = low9 - kept9, left10 = low10 - kept10, left11 = low11 - kept11;
    beyond |= extended_beyond(sum9) | extended_beyond(sum10) | extended_beyond(sum11);
    const float kept12 = sum12 - high12, kept13 = sum13 - high13, kept14 = sum14 - high14;
    self->theta[12] = sum12; self->theta[13] = sum13; self->theta[14] = sum14;
    const float sum15 = high15 + low15, sum16 = high16 + low16, sum17 = high17 + low17;
    const float low18 = self->theta_low[18] + t18, low19 = self->theta_low[19] + t19,
            low20 = self->theta_low[20] + t20;
    const float high18 = self->theta[18], high19 = self->theta[19], high20 = self->theta[20];
    const float t21 = h21 - grid, t22 = h22 - grid, t23 = h23 - grid;
    const float h24 = s24 + grid;
    self->theta_low[9] = left9; self->theta_low[10] = left10; self->theta_low[11] = left11;
    const float left12 = low12 - kept12, left13 = low13 - kept13, left14 = low14 - kept14;
    beyond |= extended_beyond(sum12) | extended_beyond(sum13) | extended_beyond(sum14);
    const float kept15 = sum15 - high15, kept16 = sum16 - high16, kept17 = sum17 - high17;
    self->theta[15] = sum15; self->theta[16] = sum16; self->theta[17] = sum17;
    const float sum18 = high18 + low18, sum19 = high19 + low19, sum20 = high20 + low20;
    const float low21 = self->theta_low[21] + t21, low22 = self->theta_low[22] + t22,
            low23 = self->theta_low[23] + t23;
    const float high21 = self->theta[21], high22 = self->theta[22], high23 = self->theta[23];
    const float t24 = h24 - grid;
    self->theta_low[12] = left12; self->theta_low[13] = left13; self->theta_low[14] = left14;
    const float left15 = low15 - kept15, left16 = low16 - kept16, left17 = low17 - kept17;
    beyond |= extended_beyond(sum15) | extended_beyond(sum16) | extended_beyond(sum17);
    const float kept18 = sum18 - high18, kept19 = sum19 - high19, kept20 = sum20 - high20;
    self->theta[18] = sum18; self->theta[19] = sum19; self->theta[20] = sum20;
    const float sum21 = high21 + low21, sum22 = high22 + low22, sum23 = high23 + low23;
    const float low24 = self->theta_low[24] + t24;
    const float high24 = self->theta[24];
    self->theta_low[15] = left15; self->theta_low[16] = left16; self->theta_low[17] = left17;
    const float left18 = low18 - kept18, left19 = low19 - kept19, left20 = low20 - kept20;
    beyond |= extended_beyond(sum18) | extended_beyond(sum19) | extended_beyond(sum20);
    const float kept21 = sum21 - high21, kept22 = sum22 - high22, kept23 = sum23 - high23;
    self->theta[21] = sum21; self->theta[22] = sum22; self->theta[23] = sum23;
    const float sum24 = high24 + low24;
    self->theta_low[18] = left18; self->theta_low[19] = left19; self->theta_low[20] = left20;
    const float left21 = low21 - kept21, left22 = low22 - kept22, left23 = low23 - kept23;
    beyond |= extended_beyond(sum21) | extended_beyond(sum22) | extended_beyond(sum23);
    const float kept24 = sum24 - high24;
    self->theta[24] = sum24;
    self->theta_low[21] = left21; self->theta_low[22] = left22; self->theta_low[23] = left23;
    const float left24 = low24 - kept24;
    beyond |= extended_beyond(sum24);
    self->theta_low[24] = left24;
    self->phase = 0u;
    extended_count_learner_event(self, &self->updates, beyond ^ 1u, 0u);
    self->age += self->measuring & (uint32_t)(self->age < UINT32_MAX);
    return beyond;
}

/* ---- Learner: samples ------------------------------------------------------------------------------------------ */

/* Innovation of the displacement y behind the regressors kept, and of the reference parameters for the same sample. */
static EXTENDED_STRAIGHT float extended_innovations(const extended_learner_t *self, float y, float *reference)
{
    float shadow;
    float other;

    const float x0 = self->x[0], x1 = self->x[1];
    const float s0 = self->theta[0], s1 = self->theta[1];
    const float o0 = self->reference[0], o1 = self->reference[1];
    const float p0 = x0 * s0, p1 = x1 * s1;
    const float q0 = x0 * o0, q1 = x1 * o1;
    const float x2 = self->x[2], x3 = self->x[3];
    const float s2 = self->theta[2], s3 = self->theta[3];
    const float o2 = self->reference[2], o3 = self->reference[3];
    shadow = p0;
    other = q0;
    shadow = shadow + p1;
    other = other + q1;
    const float p2 = x2 * s2, p3 = x3 * s3;
    const float q2 = x2 * o2, q3 = x3 * o3;
    const float x4 = self->x[4], x5 = self->x[5];
    const float s4 = self->theta[4], s5 = self->theta[5];
    const float o4 = self->reference[4], o5 = self->reference[5];
    shadow = shadow + p2;
    other = other + q2;
    shadow = shadow + p3;
    other = other + q3;
    const float p4 = x4 * s4, p5 = x5 * s5;
    const float q4 = x4 * o4, q5 = x5 * o5;
    const float x6 = self->x[6], x7 = self->x[7];
    const float s6 = self->theta[6], s7 = self->theta[7];
    const float o6 = self->reference[6], o7 = self->reference[7];
    shadow = shadow + p4;
    other = other + q4;
    shadow = shadow + p5;
    other = other + q5;
    const float p6 = x6 * s6, p7 = x7 * s7;
    const float q6 = x6 * o6, q7 = x7 * o7;
    const float x8 = self->x[8], x9 = self->x[9];
    const float s8 = self->theta[8], s9 = self->theta[9];
    const float o8 = self->reference[8], o9 = self->reference[9];
    shadow = shadow + p6;
    other = other + q6;
    shadow = shadow + p7;
    other = other + q7;
    const float p8 = x8 * s8, p9 = x9 * s9;
    const float q8 = x8 * o8, q9 = x9 * o9;
    const float x10 = self->x[10], x11 = self->x[11];
    const float s10 = self->theta[10], s11 = self->theta[11];
    const float o10 = self->reference[10], o11 = self->reference[11];
    shadow = shadow + p8;
    other = other + q8;
    shadow = shadow + p9;
    other = other + q9;
    const float p10 = x10 * s10, p11 = x11 * s11;
    const float q10 = x10 * o10, q11 = x11 * o11;
    const float x12 = self->x[12], x13 = self->x[13];
    const float s12 = self->theta[12], s13 = self->theta[13];
    const float o12 = self->reference[12], o13 = self->reference[13];
    shadow = shadow + p10;
    other = other + q10;
    shadow = shadow + p11;
    other = other + q11;
    const float p12 = x12 * s12, p13 = x13 * s13;
    const float q12 = x12 * o12, q13 = x13 * o13;
    const float x14 = self->x[14], x15 = self->x[15];
    const float s14 = self->theta[14], s15 = self->theta[15];
    const float o14 = self->reference[14], o15 = self->reference[15];
    shadow = shadow + p12;
    other = other + q12;
    shadow = shadow + p13;
    other = other + q13;
    const float p14 = x14 * s14, p15 = x15 * s15;
    const float q14 = x14 * o14, q15 = x15 * o15;
    const float x16 = self->x[16], x17 = self->x[17];
    const float s16 = self->theta[16], s17 = self->theta[17];
    const float o16 = self->reference[16], o17 = self->reference[17];
    shadow = shadow + p14;
    other = other + q14;
    shadow = shadow + p15;
    other = other + q15;
    const float p16 = x16 * s16, p17 = x17 * s17;
    const float q16 = x16 * o16, q17 = x17 * o17;
    const float x18 = self->x[18], x19 = self->x[19];
    const float s18 = self->theta[18], s19 = self->theta[19];
    const float o18 = self->reference[18], o19 = self->reference[19];
    shadow = shadow + p16;
    other = other + q16;
    shadow = shadow + p17;
    other = other + q17;
    const float p18 = x18 * s18, p19 = x19 * s19;
    const float q18 = x18 * o18, q19 = x19 * o19;
    const float x20 = self->x[20], x21 = self->x[21];
    const float s20 = self->theta[20], s21 = self->theta[21];
    const float o20 = self->reference[20], o21 = self->reference[21];
    shadow = shadow + p18;
    other = other + q18;
    shadow = shadow + p19;
    other = other + q19;
    const float p20 = x20 * s20, p21 = x21 * s21;
    const float q20 = x20 * o20, q21 = x21 * o21;
    const float x22 = self->x[22], x23 = self->x[23];
    const float s22 = self->theta[22], s23 = self->theta[23];
    const float o22 = self->reference[22], o23 = self->reference[23];
    shadow = shadow + p20;
    other = other + q20;
    shadow = shadow + p21;
    other = other + q21;
    const float p22 = x22 * s22, p23 = x23 * s23;
    const float q22 = x22 * o22, q23 = x23 * o23;
    const float x24 = self->x[24];
    const float s24 = self->theta[24];
    const float o24 = self->reference[24];
    shadow = shadow + p22;
    other = other + q22;
    shadow = shadow + p23;
    other = other + q23;
    const float p24 = x24 * s24;
    const float q24 = x24 * o24;
    shadow = shadow + p24;
    other = other + q24;
    *reference = y - (other + self->fixed_um);
    return y - (shadow + self->fixed_um);
}

/* Running levels. Once the shadow has settled, 1 if it predicts worse than the reference parameters do, or than
 * y(k+1) = y(k): both are among the models that it could be. */
EXTENDED_INLINE uint32_t extended_restart_needed(extended_learner_t *self, float e, float reference, float moved)
{
    const float size = extended_float(extended_bits(moved) & 0x7fffffffu) + EXTENDED_LEARN_FLOOR_UM;
    const uint32_t settling = extended_mask((uint32_t)(self->age >= EXTENDED_LEARN_SETTLING));
    const float rate = extended_float(extended_bits(EXTENDED_LEARN_SLOW) & settling);
    const float mine = e * e + EXTENDED_LEARN_FLOOR_SQUARE;
    const float others = reference * reference + EXTENDED_LEARN_FLOOR_SQUARE;
    const float persistence = moved * moved + EXTENDED_LEARN_FLOOR_SQUARE;

    self->moving_um = self->moving_um + EXTENDED_LEARN_FAST * (size - self->moving_um);
    self->error = self->error + rate * (mine - self->error);
    self->reference_error = self->reference_error + rate * (others - self->reference_error);
    self->step_error = self->step_error + rate * (persistence - self->step_error);
    return (uint32_t)(self->age >= EXTENDED_LEARN_SETTLED)
        & ((uint32_t)(self->error > EXTENDED_LEARN_WORSE * self->reference_error)
            | (uint32_t)(self->error > EXTENDED_LEARN_LOST * self->step_error));
}

/* Begin the update that the sample y gives rise to: it learns, or it puts back what forgetting took from the prior of
 * one parameter, by the pseudo-measurement w reference_j = w theta_j. */
EXTENDED_INLINE void extended_begin(extended_learner_t *self, float e)
{
    const uint32_t sliding = (uint32_t)(self->age >= EXTENDED_LEARN_WINDOW);

    self->since_refresh += sliding;
    self->measuring = (uint32_t)(self->since_refresh < EXTENDED_LEARN_REFRESH_EVERY);
    self->phase = 1u;
    if (self->measuring != 0u) {
        self->inflate = extended_float((extended_bits(EXTENDED_LEARN_INFLATE) & extended_mask(sliding))
            | (extended_bits(EXTENDED_LEARN_INFLATE_FIRST) & extended_mask(sliding ^ 1u)));
        self->innovation_um = e;
    } else {
        const uint32_t j = self->turn;

        self->x[0] = 0.0f; self->x[1] = 0.0f; self->x[2] = 0.0f; self->x[3] = 0.0f;
            self->x[4] = 0.0f; self->x[5] = 0.0f;
        self->x[6] = 0.0f; self->x[7] = 0.0f; self->x[8] = 0.0f; self->x[9] = 0.0f;
            self->x[10] = 0.0f; self->x[11] = 0.0f;
        self->x[12] = 0.0f; self->x[13] = 0.0f; self->x[14] = 0.0f; self->x[15] = 0.0f;
            self->x[16] = 0.0f; self->x[17] = 0.0f;
        self->x[18] = 0.0f; self->x[19] = 0.0f; self->x[20] = 0.0f; self->x[21] = 0.0f;
            self->x[22] = 0.0f; self->x[23] = 0.0f;
        self->x[24] = 0.0f;
        self->x[j] = extended_learn_refresh[j];
        self->inflate = 1.0f;
        self->innovation_um = extended_learn_refresh[j] * (self->reference[j] - self->theta[j]);
        self->turn = (j + 1u < EXTENDED_LEARNED) ? j + 1u : 0u;
        self->since_refresh = 0u;
    }
}

/* What the displacement y says about the sample before. Returns 1 if the shadow has to start again. */
EXTENDED_INLINE uint32_t extended_evaluate_reading(extended_learner_t *self, float y, float *innovation)
{
    float reference;
    uint32_t lost = 0u;

    *innovation = extended_innovations(self, y, &reference);
    extended_count_learner_event(self, &self->resting, self->rested, EXTENDED_LEARN_RESTING);
    if (self->rested == 0u) {
        lost = extended_restart_needed(self, *innovation, reference, y - self->y_um);
        if (lost == 0u) {
            extended_begin(self, *innovation);
        }
    }
    return lost;
}

/* A regressor as a multiple of 2^-30. */
EXTENDED_INLINE float extended_on_grid(float x)
{
    return (x + 0.01171875f) - 0.01171875f;
}

/* Keep the regressors of sample k for the displacement of sample k + 1. firing_l is r^l / W times a power of two: with
 * the strength that the bank's numbers carry it is p_l. */
static EXTENDED_STRAIGHT void extended_store_regressors(extended_learner_t *self, float y_um, float u)
{
    uint32_t outside;
    const float y = extended_limited(y_um, EXTENDED_Y_MIN_UM, EXTENDED_Y_MAX_UM, &outside);
    const float r = extended_power_of_two((y - EXTENDED_ORIGIN_UM) * EXTENDED_PER_STEP);
    const float r2 = r * r;
    const float r3 = r * r2;
    const float r4 = r2 * r2;
    const float r5 = r2 * r3;
    const float w0_1 = extended_strength[0] + extended_strength[1] * r;
    const float w2_3 = extended_strength[2] + extended_strength[3] * r;
    const float w4_5 = extended_strength[4] + extended_strength[5] * r;
    const float w0_3 = w0_1 + w2_3 * r2;
    const float per_weight = extended_reciprocal(w0_3 + w4_5 * r4);
    const float firing0 = per_weight * extended_learn_firing[0];
    const float firing1 = (r * per_weight) * extended_learn_firing[1];
    const float firing2 = (r2 * per_weight) * extended_learn_firing[2];
    const float firing3 = (r3 * per_weight) * extended_learn_firing[3];
    const float firing4 = (r4 * per_weight) * extended_learn_firing[4];
    const float firing5 = (r5 * per_weight) * extended_learn_firing[5];
    const float y_share = y * EXTENDED_LEARN_PER_Y;
    const float u_share = u * EXTENDED_LEARN_PER_U;
    float phi[EXTENDED_WEIGHTS];

    extended_terms_regressors(&self->terms, phi);
    self->x[0] = extended_on_grid(firing0 * y_share);
    self->x[1] = extended_on_grid(firing0 * u_share);
    self->x[2] = extended_on_grid(firing0);
    self->x[3] = extended_on_grid(firing1 * y_share);
    self->x[4] = extended_on_grid(firing1 * u_share);
    self->x[5] = extended_on_grid(firing1);
    self->x[6] = extended_on_grid(firing2 * y_share);
    self->x[7] = extended_on_grid(firing2 * u_share);
    self->x[8] = extended_on_grid(firing2);
    self->x[9] = extended_on_grid(firing3 * y_share);
    self->x[10] = extended_on_grid(firing3 * u_share);
    self->x[11] = extended_on_grid(firing3);
    self->x[12] = extended_on_grid(firing4 * y_share);
    self->x[13] = extended_on_grid(firing4 * u_share);
    self->x[14] = extended_on_grid(firing4);
    self->x[15] = extended_on_grid(firing5 * y_share);
    self->x[16] = extended_on_grid(firing5 * u_share);
    self->x[17] = extended_on_grid(firing5);
    self->x[18] = extended_on_grid(phi[0] * extended_learn_per_phi[0]);
    self->x[19] = extended_on_grid(phi[1] * extended_learn_per_phi[1]);
    self->x[20] = extended_on_grid(phi[2] * extended_learn_per_phi[2]);
    self->x[21] = extended_on_grid(phi[3] * extended_learn_per_phi[3]);
    self->x[22] = extended_on_grid(phi[4] * extended_learn_per_phi[4]);
    self->x[23] = extended_on_grid(phi[5] * extended_learn_per_phi[5]);
    self->x[24] = extended_on_grid(phi[6] * extended_learn_per_phi[6]);
    self->fixed_um = 0.0f;
    self->fresh = outside ^ 1u;
    self->y_um = y_um;
    extended_count_learner_event(self, &self->outside, outside, EXTENDED_LEARN_OUTSIDE);
}

/* ---- Learner: copies of a model's states ------------------------------------------------------------------------- */

/* Number by number: for a struct assignment compilers may call their library. That of gcc for the C674x copies in a
 * hardware loop, and the loop's counter is lost where an interrupt copies as well. */
static void extended_delay_copy(extended_delay_t *to, const extended_delay_t *from)
{
    to->newest = from->newest;
    for (uint32_t i = 0u; i < 4u; ++i) {
        to->ring[i] = from->ring[i];
    }
}

static void extended_memory_copy(extended_memory_t *to, const extended_memory_t *from)
{
    for (uint32_t i = 0u; i < 6u; ++i) {
        to->play[i] = from->play[i];
    }
}

static void extended_creep_copy(extended_creep_t *to, const extended_creep_t *from)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        to->high[i] = from->high[i];
        to->low[i] = from->low[i];
    }
}

/* Work at an update or a restart behind its first call. Returns 1 if the shadow has to start again. */
EXTENDED_INLINE uint32_t extended_continue_update(extended_learner_t *self)
{
    uint32_t lost = 0u;

    switch (self->phase) {
    case 2u:
        extended_project_1(self);
        self->phase = 3u;

        break;
    case 3u:
        self->phase = 4u;
        lost = extended_update_diagonal(self);

        break;
    case 4u:
        extended_factor_0(self);
        self->phase = 5u;

        break;
    case 5u:
        extended_factor_1(self);
        self->phase = 6u;

        break;
    case 6u:
        extended_factor_2(self);
        self->phase = 7u;

        break;
    case 7u:
        extended_factor_3(self);
        self->phase = 8u;

        break;
    case 8u:
        extended_factor_4(self);
        lost = extended_step(self);

        break;
    case 9u:
        extended_clear_0(self);
        self->phase = 10u;

        break;
    case 10u:
        extended_clear_1(self);
        self->phase = 11u;

        break;
    case 11u:
        extended_clear_2(self);
        self->phase = 12u;

        break;
    case 12u:
        extended_clear_3(self);
        self->phase = 13u;

        break;
    default:
        extended_clear_4(self);
        self->phase = 0u;

        break;
    }
    return lost;
}

/* The first call of an update. Returns 1 if the shadow has to start again. */
EXTENDED_INLINE uint32_t extended_first_phase(extended_learner_t *self)
{
    uint32_t lost = 0u;

        extended_project_0(self);
        self->phase = 2u;

    return lost;
}

void extended_learn(extended_learner_t *self, float y_um, float u_V)
{
    uint32_t y_lost;
    uint32_t u_lost;
    uint32_t moved;
    const float y = extended_finite(y_um, self->y_um, &y_lost);
    const float u_finite = extended_finite(u_V, self->u_V, &u_lost);
    const float u = extended_limited(u_finite, EXTENDED_U_MIN_V, EXTENDED_U_MAX_V, &moved);
    const float v = extended_inputs_apply(&self->inputs, u);
    const uint32_t implausible = (uint32_t)(y < EXTENDED_LEARN_Y_LOW_UM) | (uint32_t)(y > EXTENDED_LEARN_Y_HIGH_UM);
    const uint32_t usable = 1u ^ (y_lost | implausible);
    const float away = u - self->mean_u_V;
    float innovation = 0.0f;
    uint32_t lost = 0u;

    extended_count_learner_event(self, &self->rejected, (usable ^ 1u) | u_lost, EXTENDED_LEARN_REJECTED);
    if (self->phase != 0u) {
        lost = extended_continue_update(self);
    } else {
        if ((self->fresh & usable) != 0u) {
            lost = extended_evaluate_reading(self, y, &innovation);
        }
        if (self->phase != 0u) {
            lost = extended_first_phase(self);
        }
    }
    if (lost != 0u) {
        extended_count_learner_event(self, &self->restarts, 1u, EXTENDED_LEARN_RESTARTED);
        extended_restart(self);
    }
    self->fresh = 0u;
    if (((uint32_t)(self->phase == 0u) & usable & (u_lost ^ 1u)) != 0u) {
        extended_store_regressors(self, y, v);
    }
    self->rested = (uint32_t)(extended_float(extended_bits(away) & 0x7fffffffu) < EXTENDED_LEARN_REST_V);
    self->mean_u_V = extended_flushed(self->mean_u_V + EXTENDED_LEARN_FAST * away);
    self->u_V = u;
    extended_terms_advance(&self->terms, v);
}

void extended_learn_init(extended_learner_t *self, const extended_t *model)
{
    const extended_bank_t *bank = &model->bank[model->active];

    for (uint32_t l = 0u; l < EXTENDED_BANK_RULES; ++l) {
        self->base.slope[l] = bank->slope[l];
        self->base.offset[l] = bank->offset[l];
        self->base.gain[l] = bank->gain[l];
    }
    for (uint32_t j = 0u; j < EXTENDED_WEIGHTS; ++j) {
        self->base.weight[j] = bank->weight[j];
    }
    self->reference[0] = bank->slope[0] * extended_learn_scale[0];
    self->reference[1] = bank->gain[0] * extended_learn_scale[1];
    self->reference[2] = bank->offset[0] * extended_learn_scale[2];
    self->reference[3] = bank->slope[1] * extended_learn_scale[3];
    self->reference[4] = bank->gain[1] * extended_learn_scale[4];
    self->reference[5] = bank->offset[1] * extended_learn_scale[5];
    self->reference[6] = bank->slope[2] * extended_learn_scale[6];
    self->reference[7] = bank->gain[2] * extended_learn_scale[7];
    self->reference[8] = bank->offset[2] * extended_learn_scale[8];
    self->reference[9] = bank->slope[3] * extended_learn_scale[9];
    self->reference[10] = bank->gain[3] * extended_learn_scale[10];
    self->reference[11] = bank->offset[3] * extended_learn_scale[11];
    self->reference[12] = bank->slope[4] * extended_learn_scale[12];
    self->reference[13] = bank->gain[4] * extended_learn_scale[13];
    self->reference[14] = bank->offset[4] * extended_learn_scale[14];
    self->reference[15] = bank->slope[5] * extended_learn_scale[15];
    self->reference[16] = bank->gain[5] * extended_learn_scale[16];
    self->reference[17] = bank->offset[5] * extended_learn_scale[17];
    self->reference[18] = bank->weight[0] * extended_learn_scale[18];
    self->reference[19] = bank->weight[1] * extended_learn_scale[19];
    self->reference[20] = bank->weight[2] * extended_learn_scale[20];
    self->reference[21] = bank->weight[3] * extended_learn_scale[21];
    self->reference[22] = bank->weight[4] * extended_learn_scale[22];
    self->reference[23] = bank->weight[5] * extended_learn_scale[23];
    self->reference[24] = bank->weight[6] * extended_learn_scale[24];
    for (uint32_t i = 0u; i < EXTENDED_LEARNED; ++i) {
        self->x[i] = 0.0f;
        self->f[i] = 0.0f;
        self->g[i] = 0.0f;
        self->l[i] = 0.0f;
        self->k[i] = 0.0f;
    }
    self->per_alpha = 1.0f;
    self->inflate = 1.0f;
    self->innovation_um = 0.0f;
    self->fixed_um = 0.0f;
    self->y_um = model->y_um;
    self->u_V = model->u_V;
    self->mean_u_V = model->u_V;
    self->fresh = 0u;
    self->rested = 0u;
    self->measuring = 0u;
    self->since_refresh = 0u;
    self->turn = 0u;
    self->status = 0u;
    self->updates = 0u;
    self->rejected = 0u;
    self->outside = 0u;
    self->resting = 0u;
    self->outliers = 0u;
    self->changes = 0u;
    self->quiet = 0u;
    self->limited = 0u;
    self->clamped = 0u;
    self->restarts = 0u;
    self->inputs.v_V = model->inputs.v_V;
    extended_delay_copy(&self->inputs.delay, &model->inputs.delay);
    extended_memory_copy(&self->terms.memory, &model->terms.memory);
    extended_creep_copy(&self->terms.creep, &model->terms.creep);
    self->candidate.phase = 0u;
    self->candidate.point = 0u;
    extended_restart(self);
    extended_clear_0(self);
    extended_clear_1(self);
    extended_clear_2(self);
    extended_clear_3(self);
    extended_clear_4(self);
    self->phase = 0u;
}

/* ---- Commit ---------------------------------------------------------------------------------------------------- */

EXTENDED_INLINE float extended_lesser(float a, float b)
{
    return (b < a) ? b : a;
}

EXTENDED_INLINE float extended_greater(float a, float b)
{
    return (b > a) ? b : a;
}

/* Half the spread over the rules of y q1 + u q2 + one q3, the strengths in the bank taken off again. */
EXTENDED_INLINE float extended_half_span(const extended_bank_t *bank, float y, float u, float one)
{
    const float v0 = ((y * bank->slope[0] + u * bank->gain[0]) + one * bank->offset[0]) * extended_commit_unfold[0];
    const float v1 = ((y * bank->slope[1] + u * bank->gain[1]) + one * bank->offset[1]) * extended_commit_unfold[1];
    const float v2 = ((y * bank->slope[2] + u * bank->gain[2]) + one * bank->offset[2]) * extended_commit_unfold[2];
    const float v3 = ((y * bank->slope[3] + u * bank->gain[3]) + one * bank->offset[3]) * extended_commit_unfold[3];
    const float v4 = ((y * bank->slope[4] + u * bank->gain[4]) + one * bank->offset[4]) * extended_commit_unfold[4];
    const float v5 = ((y * bank->slope[5] + u * bank->gain[5]) + one * bank->offset[5]) * extended_commit_unfold[5];
    float least = v0;
    float most = v0;

    least = extended_lesser(least, v1);
    most = extended_greater(most, v1);
    least = extended_lesser(least, v2);
    most = extended_greater(most, v2);
    least = extended_lesser(least, v3);
    most = extended_greater(most, v3);
    least = extended_lesser(least, v4);
    most = extended_greater(most, v4);
    least = extended_lesser(least, v5);
    most = extended_greater(most, v5);
    return 0.5f * (most - least);
}

/* What Taylor's theorem leaves between the check points, for these parameters. */
static void extended_bound_remainders(extended_candidate_t *candidate)
{
    const extended_bank_t *bank = &candidate->bank;
    const float common = EXTENDED_COMMIT_SLOPE_REMAINDER_1 * extended_half_span(bank, 1.0f, 0.0f, 0.0f);
    const float low = extended_greater(
        extended_half_span(bank, EXTENDED_Y_MIN_UM, EXTENDED_U_MIN_V, 1.0f), extended_half_span(bank, EXTENDED_Y_MAX_UM, EXTENDED_U_MIN_V, 1.0f));
    const float high = extended_greater(
        extended_half_span(bank, EXTENDED_Y_MIN_UM, EXTENDED_U_MAX_V, 1.0f), extended_half_span(bank, EXTENDED_Y_MAX_UM, EXTENDED_U_MAX_V, 1.0f));

    candidate->gain_remainder_um_per_V = EXTENDED_COMMIT_GAIN_REMAINDER * extended_half_span(bank, 0.0f, 1.0f, 0.0f);
    candidate->slope_remainder[0] = common + EXTENDED_COMMIT_SLOPE_REMAINDER_3 * low;
    candidate->slope_remainder[1] = common + EXTENDED_COMMIT_SLOPE_REMAINDER_3 * high;
}

/* Take the shadow as it is now. */
static uint32_t extended_snapshot(extended_learner_t *learner)
{
    extended_candidate_t *candidate = &learner->candidate;
    uint32_t beyond = 0u;
    float moved = 0.0f;

    if (learner->age < EXTENDED_COMMIT_MATURE) {
        return EXTENDED_REFUSED_YOUNG;
    }
    candidate->theta[0] = learner->theta[0];
    candidate->theta[1] = learner->theta[1];
    candidate->theta[2] = learner->theta[2];
    candidate->theta[3] = learner->theta[3];
    candidate->theta[4] = learner->theta[4];
    candidate->theta[5] = learner->theta[5];
    candidate->theta[6] = learner->theta[6];
    candidate->theta[7] = learner->theta[7];
    candidate->theta[8] = learner->theta[8];
    candidate->theta[9] = learner->theta[9];
    candidate->theta[10] = learner->theta[10];
    candidate->theta[11] = learner->theta[11];
    candidate->theta[12] = learner->theta[12];
    candidate->theta[13] = learner->theta[13];
    candidate->theta[14] = learner->theta[14];
    candidate->theta[15] = learner->theta[15];
    candidate->theta[16] = learner->theta[16];
    candidate->theta[17] = learner->theta[17];
    candidate->theta[18] = learner->theta[18];
    candidate->theta[19] = learner->theta[19];
    candidate->theta[20] = learner->theta[20];
    candidate->theta[21] = learner->theta[21];
    candidate->theta[22] = learner->theta[22];
    candidate->theta[23] = learner->theta[23];
    candidate->theta[24] = learner->theta[24];
    candidate->bank.slope[0] = candidate->theta[0] * extended_learn_per_scale[0];
    candidate->bank.gain[0] = candidate->theta[1] * extended_learn_per_scale[1];
    candidate->bank.offset[0] = candidate->theta[2] * extended_learn_per_scale[2];
    candidate->bank.slope[1] = candidate->theta[3] * extended_learn_per_scale[3];
    candidate->bank.gain[1] = candidate->theta[4] * extended_learn_per_scale[4];
    candidate->bank.offset[1] = candidate->theta[5] * extended_learn_per_scale[5];
    candidate->bank.slope[2] = candidate->theta[6] * extended_learn_per_scale[6];
    candidate->bank.gain[2] = candidate->theta[7] * extended_learn_per_scale[7];
    candidate->bank.offset[2] = candidate->theta[8] * extended_learn_per_scale[8];
    candidate->bank.slope[3] = candidate->theta[9] * extended_learn_per_scale[9];
    candidate->bank.gain[3] = candidate->theta[10] * extended_learn_per_scale[10];
    candidate->bank.offset[3] = candidate->theta[11] * extended_learn_per_scale[11];
    candidate->bank.slope[4] = candidate->theta[12] * extended_learn_per_scale[12];
    candidate->bank.gain[4] = candidate->theta[13] * extended_learn_per_scale[13];
    candidate->bank.offset[4] = candidate->theta[14] * extended_learn_per_scale[14];
    candidate->bank.slope[5] = candidate->theta[15] * extended_learn_per_scale[15];
    candidate->bank.gain[5] = candidate->theta[16] * extended_learn_per_scale[16];
    candidate->bank.offset[5] = candidate->theta[17] * extended_learn_per_scale[17];
    candidate->bank.weight[0] = candidate->theta[18] * extended_learn_per_scale[18];
    candidate->bank.weight[1] = candidate->theta[19] * extended_learn_per_scale[19];
    candidate->bank.weight[2] = candidate->theta[20] * extended_learn_per_scale[20];
    candidate->bank.weight[3] = candidate->theta[21] * extended_learn_per_scale[21];
    candidate->bank.weight[4] = candidate->theta[22] * extended_learn_per_scale[22];
    candidate->bank.weight[5] = candidate->theta[23] * extended_learn_per_scale[23];
    candidate->bank.weight[6] = candidate->theta[24] * extended_learn_per_scale[24];
    beyond |= extended_beyond(candidate->theta[0]);
    beyond |= extended_beyond(candidate->theta[1]);
    beyond |= extended_beyond(candidate->theta[2]);
    beyond |= extended_beyond(candidate->theta[3]);
    beyond |= extended_beyond(candidate->theta[4]);
    beyond |= extended_beyond(candidate->theta[5]);
    beyond |= extended_beyond(candidate->theta[6]);
    beyond |= extended_beyond(candidate->theta[7]);
    beyond |= extended_beyond(candidate->theta[8]);
    beyond |= extended_beyond(candidate->theta[9]);
    beyond |= extended_beyond(candidate->theta[10]);
    beyond |= extended_beyond(candidate->theta[11]);
    beyond |= extended_beyond(candidate->theta[12]);
    beyond |= extended_beyond(candidate->theta[13]);
    beyond |= extended_beyond(candidate->theta[14]);
    beyond |= extended_beyond(candidate->theta[15]);
    beyond |= extended_beyond(candidate->theta[16]);
    beyond |= extended_beyond(candidate->theta[17]);
    beyond |= extended_beyond(candidate->theta[18]);
    beyond |= extended_beyond(candidate->theta[19]);
    beyond |= extended_beyond(candidate->theta[20]);
    beyond |= extended_beyond(candidate->theta[21]);
    beyond |= extended_beyond(candidate->theta[22]);
    beyond |= extended_beyond(candidate->theta[23]);
    beyond |= extended_beyond(candidate->theta[24]);
    if (beyond != 0u) {
        return EXTENDED_REFUSED_LIMIT;
    }
    moved = moved + extended_commit_gamma[0] * extended_float(extended_size(candidate->bank.weight[0] - extended_weight[0]));
    moved = moved + extended_commit_gamma[1] * extended_float(extended_size(candidate->bank.weight[1] - extended_weight[1]));
    moved = moved + extended_commit_gamma[2] * extended_float(extended_size(candidate->bank.weight[2] - extended_weight[2]));
    moved = moved + extended_commit_gamma[3] * extended_float(extended_size(candidate->bank.weight[3] - extended_weight[3]));
    moved = moved + extended_commit_gamma[4] * extended_float(extended_size(candidate->bank.weight[4] - extended_weight[4]));
    moved = moved + extended_commit_gamma[5] * extended_float(extended_size(candidate->bank.weight[5] - extended_weight[5]));
    moved = moved + extended_commit_gamma[6] * extended_float(extended_size(candidate->bank.weight[6] - extended_weight[6]));
    if (moved > EXTENDED_COMMIT_WEIGHT_BUDGET) {
        return EXTENDED_REFUSED_WEIGHTS;
    }
    extended_bound_remainders(candidate);
    candidate->point = 0u;
    candidate->phase = 1u;
    return EXTENDED_BUSY;
}

/* 1 if |df/dy| may reach its limit near a check point, under the input u. */
EXTENDED_INLINE uint32_t extended_too_steep(float slope, float curve, float rest)
{
    const float near = EXTENDED_COMMIT_HALF_UM * extended_float(extended_size(curve));

    return (uint32_t)(extended_float(extended_size(slope)) + (near + rest) >= EXTENDED_COMMIT_SLOPE_LIMIT);
}

/* Gain and slope around one check point, from p, p' and p'' there (see extended_params.h). */
static uint32_t extended_check(const extended_candidate_t *candidate)
{
    const float *p = &extended_commit_table[candidate->point * 18u];
    const extended_bank_t *bank = &candidate->bank;
    const float y = extended_commit_y[candidate->point];
    float a0 = p[0] * bank->slope[0];
    float a1 = p[6] * bank->slope[0];
    float a2 = p[12] * bank->slope[0];
    float b0 = p[0] * bank->gain[0];
    float b1 = p[6] * bank->gain[0];
    float b2 = p[12] * bank->gain[0];
    float c1 = p[6] * bank->offset[0];
    float c2 = p[12] * bank->offset[0];

    a0 = a0 + p[1] * bank->slope[1];
    a1 = a1 + p[7] * bank->slope[1];
    a2 = a2 + p[13] * bank->slope[1];
    b0 = b0 + p[1] * bank->gain[1];
    b1 = b1 + p[7] * bank->gain[1];
    b2 = b2 + p[13] * bank->gain[1];
    c1 = c1 + p[7] * bank->offset[1];
    c2 = c2 + p[13] * bank->offset[1];
    a0 = a0 + p[2] * bank->slope[2];
    a1 = a1 + p[8] * bank->slope[2];
    a2 = a2 + p[14] * bank->slope[2];
    b0 = b0 + p[2] * bank->gain[2];
    b1 = b1 + p[8] * bank->gain[2];
    b2 = b2 + p[14] * bank->gain[2];
    c1 = c1 + p[8] * bank->offset[2];
    c2 = c2 + p[14] * bank->offset[2];
    a0 = a0 + p[3] * bank->slope[3];
    a1 = a1 + p[9] * bank->slope[3];
    a2 = a2 + p[15] * bank->slope[3];
    b0 = b0 + p[3] * bank->gain[3];
    b1 = b1 + p[9] * bank->gain[3];
    b2 = b2 + p[15] * bank->gain[3];
    c1 = c1 + p[9] * bank->offset[3];
    c2 = c2 + p[15] * bank->offset[3];
    a0 = a0 + p[4] * bank->slope[4];
    a1 = a1 + p[10] * bank->slope[4];
    a2 = a2 + p[16] * bank->slope[4];
    b0 = b0 + p[4] * bank->gain[4];
    b1 = b1 + p[10] * bank->gain[4];
    b2 = b2 + p[16] * bank->gain[4];
    c1 = c1 + p[10] * bank->offset[4];
    c2 = c2 + p[16] * bank->offset[4];
    a0 = a0 + p[5] * bank->slope[5];
    a1 = a1 + p[11] * bank->slope[5];
    a2 = a2 + p[17] * bank->slope[5];
    b0 = b0 + p[5] * bank->gain[5];
    b1 = b1 + p[11] * bank->gain[5];
    b2 = b2 + p[17] * bank->gain[5];
    c1 = c1 + p[11] * bank->offset[5];
    c2 = c2 + p[17] * bank->offset[5];

    const float gain = EXTENDED_COMMIT_SIGN * b0;
    const float away = EXTENDED_COMMIT_HALF_UM * extended_float(extended_size(b1)) + candidate->gain_remainder_um_per_V;
    const float slope = (a0 + a1 * y) + c1;
    const float curve = ((a1 + a1) + a2 * y) + c2;
    const uint32_t steep = extended_too_steep(slope + b1 * EXTENDED_U_MIN_V, curve + b2 * EXTENDED_U_MIN_V, candidate->slope_remainder[0])
        | extended_too_steep(slope + b1 * EXTENDED_U_MAX_V, curve + b2 * EXTENDED_U_MAX_V, candidate->slope_remainder[1]);
    const uint32_t weak = (uint32_t)(gain - away <= EXTENDED_COMMIT_GAIN_FLOOR) | (uint32_t)(gain + away >= EXTENDED_COMMIT_GAIN_CEILING);

    if (weak != 0u) {
        return EXTENDED_REFUSED_GAIN;
    }
    return (steep != 0u) ? EXTENDED_REFUSED_SLOPE : EXTENDED_BUSY;
}

/* Write the candidate into the bank that is not in use. */
static void extended_write(extended_t *self, const extended_candidate_t *candidate)
{
    extended_bank_t *idle = &self->bank[1u - self->active];

    for (uint32_t l = 0u; l < EXTENDED_BANK_RULES; ++l) {
        idle->slope[l] = candidate->bank.slope[l];
        idle->offset[l] = candidate->bank.offset[l];
        idle->gain[l] = candidate->bank.gain[l];
    }
    for (uint32_t j = 0u; j < EXTENDED_WEIGHTS; ++j) {
        idle->weight[j] = candidate->bank.weight[j];
    }
}

/* Writing and making active are two calls: whatever interrupts in between sees a bank that is whole. */
uint32_t extended_commit(extended_t *self, extended_learner_t *learner)
{
    extended_candidate_t *candidate = &learner->candidate;
    uint32_t answer = EXTENDED_BUSY;

    switch (candidate->phase) {
    case 0u:
        answer = extended_snapshot(learner);
        break;
    case 1u:
        for (uint32_t i = 0u; i < 1u; ++i) {
            if ((candidate->phase == 1u) && (answer == EXTENDED_BUSY)) {
                answer = extended_check(candidate);
                candidate->point += 1u;
                candidate->phase += (uint32_t)(candidate->point >= EXTENDED_COMMIT_POINTS);
            }
        }
        candidate->phase = (answer == EXTENDED_BUSY) ? candidate->phase : 0u;
        break;
    case 2u:
        extended_write(self, candidate);
        candidate->phase = 3u;
        break;
    default:
        self->active = 1u - self->active;
        learner->reference[0] = candidate->theta[0];
        learner->reference[1] = candidate->theta[1];
        learner->reference[2] = candidate->theta[2];
        learner->reference[3] = candidate->theta[3];
        learner->reference[4] = candidate->theta[4];
        learner->reference[5] = candidate->theta[5];
        learner->reference[6] = candidate->theta[6];
        learner->reference[7] = candidate->theta[7];
        learner->reference[8] = candidate->theta[8];
        learner->reference[9] = candidate->theta[9];
        learner->reference[10] = candidate->theta[10];
        learner->reference[11] = candidate->theta[11];
        learner->reference[12] = candidate->theta[12];
        learner->reference[13] = candidate->theta[13];
        learner->reference[14] = candidate->theta[14];
        learner->reference[15] = candidate->theta[15];
        learner->reference[16] = candidate->theta[16];
        learner->reference[17] = candidate->theta[17];
        learner->reference[18] = candidate->theta[18];
        learner->reference[19] = candidate->theta[19];
        learner->reference[20] = candidate->theta[20];
        learner->reference[21] = candidate->theta[21];
        learner->reference[22] = candidate->theta[22];
        learner->reference[23] = candidate->theta[23];
        learner->reference[24] = candidate->theta[24];
        candidate->phase = 0u;
        answer = EXTENDED_COMMITTED;
        break;
    }
    return answer;
}
