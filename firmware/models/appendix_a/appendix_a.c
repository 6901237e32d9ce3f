/* appendix_a.c: the algorithm of model `appendix_a`; changes only with the model's structure. Interface: appendix_a.h. */

#include "appendix_a.h"

/* Equal bits on every machine rest on float32 operations as they are written: no shortcuts, no wider intermediate
 * results, no multiplication fused with an addition. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#error "appendix_a: compile without -ffast-math and its parts"
#endif
#if defined(__FLT_EVAL_METHOD__)
#if __FLT_EVAL_METHOD__ != 0
#error "appendix_a: float must be evaluated as float (on x86: -msse2 -mfpmath=sse)"
#endif
#endif

#include <float.h>
#include <limits.h>

#if CHAR_BIT != 8 || FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MIN_EXP != -125 || FLT_MAX_EXP != 128
#error "appendix_a: needs bytes of 8 bits, and float in the 32-bit format of IEEE 754"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__GNUC__)
#define APPENDIX_A_INLINE static inline __attribute__((always_inline))
#else
#define APPENDIX_A_INLINE APPENDIX_A_CODE static inline
#endif

#define APPENDIX_A_NUMBERS
#include "appendix_a_params.h"

/* ---- Arithmetic ---------------------------------------------------------------------------------------------- */

APPENDIX_A_INLINE uint32_t appendix_a_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

APPENDIX_A_INLINE float appendix_a_float(uint32_t bits)
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
APPENDIX_A_INLINE float appendix_a_power_of_two(float x)
{
    const float shifted = x + 12582912.0f;
    const float f = x - (shifted - 12582912.0f);
    const float square = f * f;
    const float fourth = square * square;
    const float low = 1.0f + 0.693147182f * f;
    const float middle = 0.240226477f + 0.0555035993f * f;
    const float high = (0.00961850584f + 0.00133908063f * f) + 0.000153264715f * square;
    const float mantissa = low + (square * middle + fourth * high);

    return appendix_a_float(appendix_a_bits(mantissa) + (appendix_a_bits(shifted) << 23));
}

/* 1/x for 2^-120 <= |x| <= 2^120, relative error at most 1.5e-07: a seed from the bits, then 3 Newton steps
 *     r <- r (2 - x r) */
APPENDIX_A_INLINE float appendix_a_reciprocal(float x)
{
    float r = appendix_a_float(0x7ef311c7u - appendix_a_bits(x));

    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);

    return r;
}

/* ---- Input checks: constant time, by masks --------------------------------------------------------------------- */

/* All ones if the condition is 1, else 0. */
APPENDIX_A_INLINE uint32_t appendix_a_mask(uint32_t condition)
{
    return 0u - condition;
}

/** Events at the inputs during one call, 1 if the event occurred and 0 if not. */
typedef struct {
    uint32_t y_clamped;   /**< y was outside its range and was limited. */
    uint32_t u_clamped;   /**< u was outside its range and was limited. */
    uint32_t y_rejected;  /**< y was not finite and was replaced. */
    uint32_t u_rejected;  /**< u was not finite and was replaced. */
} appendix_a_events_t;

APPENDIX_A_INLINE uint32_t appendix_a_counted(uint32_t counter, uint32_t happened)
{
    return counter + (happened & (uint32_t)(counter < UINT32_MAX));
}

/* Status bits and counters of one call. Called last: the counting fills the slots that the arithmetic leaves free. */
APPENDIX_A_INLINE void appendix_a_count_events(appendix_a_t *self, const appendix_a_events_t *events)
{
    self->status |= (events->y_clamped * APPENDIX_A_STATUS_Y_CLAMPED) | (events->u_clamped * APPENDIX_A_STATUS_U_CLAMPED)
        | (events->y_rejected * APPENDIX_A_STATUS_Y_REJECTED) | (events->u_rejected * APPENDIX_A_STATUS_U_REJECTED);
    self->y_clamped = appendix_a_counted(self->y_clamped, events->y_clamped);
    self->u_clamped = appendix_a_counted(self->u_clamped, events->u_clamped);
    self->y_rejected = appendix_a_counted(self->y_rejected, events->y_rejected);
    self->u_rejected = appendix_a_counted(self->u_rejected, events->u_rejected);
}

/* x, or the value held if x is not finite; magnitudes below 2^-40 become 0, so that denormal numbers never occur. */
APPENDIX_A_INLINE float appendix_a_finite(float x, float held, uint32_t *rejected)
{
    const uint32_t bits = appendix_a_bits(x);
    const uint32_t magnitude = bits & 0x7fffffffu;
    const uint32_t infinite = (uint32_t)(magnitude >= 0x7f800000u);
    const uint32_t keep = appendix_a_mask((uint32_t)(magnitude >= 0x2b800000u));
    const uint32_t hold = appendix_a_mask(infinite);

    *rejected = infinite;
    return appendix_a_float((bits & keep & ~hold) | (appendix_a_bits(held) & hold));
}

/* A result before it leaves or is kept: magnitudes below 2^-40 become 0. */
APPENDIX_A_INLINE float appendix_a_flushed(float x)
{
    const uint32_t bits = appendix_a_bits(x);

    return appendix_a_float(bits & appendix_a_mask((uint32_t)((bits & 0x7fffffffu) >= 0x2b800000u)));
}

/* x limited to [low, high]. */
APPENDIX_A_INLINE float appendix_a_limited(float x, float low, float high, uint32_t *clamped)
{
    const uint32_t below = (uint32_t)(x < low);
    const uint32_t above = (uint32_t)(x > high);
    const uint32_t raise = appendix_a_mask(below);
    const uint32_t lower = appendix_a_mask(above);

    *clamped = below | above;
    return appendix_a_float(
        (appendix_a_bits(x) & ~(raise | lower)) | (appendix_a_bits(low) & raise) | (appendix_a_bits(high) & lower));
}

/** The range of the inverse's voltage at one sample. */
typedef struct {
    float low;   /**< Lowest voltage [V]. */
    float high;  /**< Highest voltage [V]. */
} appendix_a_span_t;

/* low_V .. high_V, and at most step_V from the voltage before. */
APPENDIX_A_INLINE appendix_a_span_t appendix_a_span(const appendix_a_t *self, float last_V)
{
    const float least = self->low_V;
    const float most = self->high_V;
    const float down = last_V - self->step_V;
    const float up = last_V + self->step_V;
    const float low = (down < least) ? least : down;
    const float high = (up < least) ? least : up;
    appendix_a_span_t span;

    span.low = (low > most) ? most : low;
    span.high = (high > most) ? most : high;
    return span;
}

/* The voltage of the span that is nearest to x. */
APPENDIX_A_INLINE float appendix_a_allowed(float x, appendix_a_span_t span, uint32_t *clamped)
{
    const float low = span.low;
    const float high = span.high;
    const float raised = (x < low) ? low : x;
    const float allowed = (raised > high) ? high : raised;

    *clamped = (uint32_t)(allowed < x) | (uint32_t)(allowed > x);
    return allowed;
}

/* A displacement inside the identified range, whatever came in. */
APPENDIX_A_INLINE float appendix_a_checked_y(const appendix_a_t *self, float y_um, appendix_a_events_t *events)
{
    const float finite = appendix_a_finite(y_um, self->y_um, &events->y_rejected);

    return appendix_a_limited(finite, APPENDIX_A_Y_MIN_UM, APPENDIX_A_Y_MAX_UM, &events->y_clamped);
}

/* A voltage inside the input range, whatever came in. */
APPENDIX_A_INLINE float appendix_a_checked_u(const appendix_a_t *self, float u_V, appendix_a_events_t *events)
{
    const float finite = appendix_a_finite(u_V, self->u_V, &events->u_rejected);

    return appendix_a_limited(finite, APPENDIX_A_U_MIN_V, APPENDIX_A_U_MAX_V, &events->u_clamped);
}

/* ---- Rules ----------------------------------------------------------------------------------------------------- */

/** Sums over the rules; v_l are the unnormalised memberships, p_l = v_l / weight. */
typedef struct {
    float slope;   /**< Sum of v_l q_l1. */
    float offset;  /**< Sum of v_l q_l3 [um]. */
    float gain;    /**< Sum of v_l q_l2. */
    float weight;  /**< Sum of v_l. */
} appendix_a_sums_t;

/* Neighbouring rules' strengths differ by r = exp((y - middle) / h) and constants, so each sum over the rules is a
 * polynomial in r of degree 5, evaluated by Estrin's scheme: its chains are the shortest. y inside the range. */
APPENDIX_A_INLINE appendix_a_sums_t appendix_a_rule_sums(const appendix_a_bank_t *bank, float y)
{
    const float r = appendix_a_power_of_two((y - APPENDIX_A_ORIGIN_UM) * APPENDIX_A_PER_STEP);
    const float r2 = r * r;
    const float r4 = r2 * r2;
    appendix_a_sums_t sums;

    const float w0_1 = appendix_a_strength[0] + appendix_a_strength[1] * r;
    const float w2_3 = appendix_a_strength[2] + appendix_a_strength[3] * r;
    const float w4_5 = appendix_a_strength[4] + appendix_a_strength[5] * r;
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

/* ---- Feedback -------------------------------------------------------------------------------------------------- */

/* Without correction, at rest, with the integral of the design. */
APPENDIX_A_INLINE void appendix_a_loop_init(appendix_a_loop_t *loop)
{
    loop->correction_um = 0.0f;
    loop->before_um = 0.0f;
    loop->half = APPENDIX_A_LOOP_HALF;
}

/* c(k) = c(k-1) + K/2 (f(k) + f(k-1)), f = F of the residual; it stands still at a limit that it would move beyond. */
APPENDIX_A_CODE
float appendix_a_correct(appendix_a_t *self, float residual_um)
{
    appendix_a_events_t events = { 0u, 0u, 0u, 0u };
    const float finite = appendix_a_finite(residual_um, 0.0f, &events.y_rejected);
    const float residual = appendix_a_limited(finite, -APPENDIX_A_LOOP_REACH_UM, APPENDIX_A_LOOP_REACH_UM, &events.y_clamped);
    const float before = self->loop.correction_um;
    const float moves = residual;
    const float step = appendix_a_flushed(self->loop.half * (moves + self->loop.before_um));
    const uint32_t at_top = (uint32_t)(self->u_V >= self->high_V);
    const uint32_t at_bottom = (uint32_t)(self->u_V <= self->low_V);
    const uint32_t winds = (at_top & (uint32_t)(step > 0.0f)) | (at_bottom & (uint32_t)(step < 0.0f));
    uint32_t limited;
    const float moved = appendix_a_flushed(appendix_a_limited(before + step, -APPENDIX_A_LOOP_LIMIT_UM, APPENDIX_A_LOOP_LIMIT_UM, &limited));
    const float correction = (winds != 0u) ? before : moved;

    self->loop.before_um = moves;
    self->loop.correction_um = correction;
    appendix_a_count_events(self, &events);
    return correction;
}

/* ---- Prediction ------------------------------------------------------------------------------------------------ */

APPENDIX_A_CODE
void appendix_a_init(appendix_a_t *self, float y_um, float u_V)
{
    appendix_a_events_t events;

    for (uint32_t b = 0u; b < 2u; ++b) {
        for (uint32_t l = 0u; l < APPENDIX_A_BANK_RULES; ++l) {
            self->bank[b].slope[l] = appendix_a_slope[l];
            self->bank[b].offset[l] = appendix_a_offset[l];
            self->bank[b].gain[l] = appendix_a_gain[l];
        }
    }
    self->active = 0u;
    self->status = 0u;
    self->y_clamped = 0u;
    self->u_clamped = 0u;
    self->y_rejected = 0u;
    self->u_rejected = 0u;
    self->y_um = APPENDIX_A_Y_REST_UM;
    self->u_V = APPENDIX_A_U_REST_V;
    self->y_um = appendix_a_checked_y(self, y_um, &events);
    self->u_V = appendix_a_checked_u(self, u_V, &events);
    appendix_a_count_events(self, &events);
    self->low_V = APPENDIX_A_U_MIN_V;
    self->high_V = APPENDIX_A_U_MAX_V;
    self->step_V = APPENDIX_A_U_STEP_MAX_V;
    appendix_a_loop_init(&self->loop);
}

/* The model's output under the input u, Eq. (4), with base = y S + O; the input acts on the state. */
APPENDIX_A_INLINE float appendix_a_apply(appendix_a_t *self, float base, float gain, float per_weight, float u)
{
    const float rules = (base + u * gain) * per_weight;
    const float y_next = appendix_a_flushed(rules);

    self->y_um = y_next;
    return y_next;
}

/* y(k+1) from measured y(k) and u(k). */
APPENDIX_A_CODE
float appendix_a_predict(appendix_a_t *self, float y_um, float u_V)
{
    const appendix_a_bank_t *bank = &self->bank[self->active];
    appendix_a_events_t events;
    const float y = appendix_a_checked_y(self, y_um, &events);
    const float u = appendix_a_checked_u(self, u_V, &events);
    const appendix_a_sums_t sums = appendix_a_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = appendix_a_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = appendix_a_apply(self, base, sums.gain, per_weight, u);

    appendix_a_count_events(self, &events);
    return y_next;
}

/* ---- Free run -------------------------------------------------------------------------------------------------- */

/* y(k+1) from the last output and u(k). */
APPENDIX_A_CODE
float appendix_a_simulate(appendix_a_t *self, float u_V)
{
    const appendix_a_bank_t *bank = &self->bank[self->active];
    appendix_a_events_t events = { 0u, 0u, 0u, 0u };
    const float y = appendix_a_limited(self->y_um, APPENDIX_A_Y_MIN_UM, APPENDIX_A_Y_MAX_UM, &events.y_clamped);
    const float u = appendix_a_checked_u(self, u_V, &events);
    const appendix_a_sums_t sums = appendix_a_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = appendix_a_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = appendix_a_apply(self, base, sums.gain, per_weight, u);

    appendix_a_count_events(self, &events);
    return y_next;
}

/* ---- Inverse --------------------------------------------------------------------------------------------------- */

APPENDIX_A_CODE
void appendix_a_limits(appendix_a_t *self, float low_V, float high_V, float step_V)
{
    uint32_t acted;
    const float low = appendix_a_finite(low_V, APPENDIX_A_U_MIN_V, &acted);
    const float high = appendix_a_finite(high_V, APPENDIX_A_U_MAX_V, &acted);
    const float step = appendix_a_finite(step_V, APPENDIX_A_U_STEP_MAX_V, &acted);

    self->low_V = appendix_a_limited(low, APPENDIX_A_U_MIN_V, APPENDIX_A_U_MAX_V, &acted);
    self->high_V = appendix_a_limited(high, self->low_V, APPENDIX_A_U_MAX_V, &acted);
    self->step_V = appendix_a_limited(step, 0.0f, APPENDIX_A_U_STEP_MAX_V, &acted);
}

/* u(k) that takes y(k) to y(k+1): (y(k+1) - sum theta phi) W = y S + O + u G, solved for u. */
APPENDIX_A_CODE
float appendix_a_inverse(appendix_a_t *self, float y_um, float y_next_um)
{
    const appendix_a_bank_t *bank = &self->bank[self->active];
    appendix_a_events_t events = { 0u, 0u, 0u, 0u };
    uint32_t rejected;
    uint32_t clamped;
    const float y = appendix_a_checked_y(self, y_um, &events);
    const appendix_a_sums_t sums = appendix_a_rule_sums(bank, y);
    const appendix_a_span_t span = appendix_a_span(self, self->u_V);
    const float finite = appendix_a_finite(y_next_um, y, &rejected);
    const float wanted = appendix_a_limited(finite, APPENDIX_A_REFERENCE_MIN_UM, APPENDIX_A_REFERENCE_MAX_UM, &clamped);
    const float base = y * sums.slope + sums.offset;
    const float numerator = wanted * sums.weight - base;
    const float per_gain = appendix_a_reciprocal(sums.gain);
    const float per_weight = appendix_a_reciprocal(sums.weight);
    const float exact = appendix_a_flushed(numerator * per_gain);
    const float u = appendix_a_allowed(exact, span, &events.u_clamped);
    const uint32_t unreachable = events.u_clamped;

    self->status |= (clamped * APPENDIX_A_STATUS_REFERENCE_CLAMPED) | (unreachable * APPENDIX_A_STATUS_UNREACHABLE);
    events.y_rejected |= rejected;
    appendix_a_count_events(self, &events);
    self->u_V = u;
    (void)appendix_a_apply(self, base, sums.gain, per_weight, u);
    return u;
}

/* ---- Learner ---------------------------------------------------------------------------------------------------- */

/* Advice for gcc on the C674x, which overlaps operations of a basic block only: it unrolls the loops over parameters and
 * rules, schedules each function alone, and keeps the order of the loads. For the same reason these loops write local
 * arrays, which nothing else can alias, and copy them at the end. The bits do not depend on the advice. */
#if defined(_TMS320C6X) && defined(__GNUC__)
#define APPENDIX_A_UNROLL _Pragma("GCC unroll 153")
#define APPENDIX_A_ALONE __attribute__((noinline, optimize("no-tree-ter")))
#else
#define APPENDIX_A_UNROLL
#define APPENDIX_A_ALONE
#endif

/* 1.5 * 2^23 times the grids of regressors (2^-30), U (2^-30), g (2^-60) and steps of theta (2^-45). */
#define APPENDIX_A_REGRESSOR_GRID  0.01171875f
#define APPENDIX_A_FACTOR_GRID     0.01171875f
#define APPENDIX_A_GAIN_GRID       1.09139364e-11f
#define APPENDIX_A_STEP_GRID       3.57627869e-07f

/** How an update goes on behind its diagonal. */
typedef enum {
    APPENDIX_A_UPDATE_SKIPPED = 0,    /**< The sample is an outlier or inside the dead zone; P and theta stay. */
    APPENDIX_A_UPDATE_CONTINUES = 1,  /**< The diagonal is updated; U and theta follow. */
    APPENDIX_A_UPDATE_RESTARTS = 2    /**< alpha is beyond its limit; the shadow restarts. */
} appendix_a_outcome_t;

/* x rounded to a multiple of the grid that the constant APPENDIX_A_..._GRID belongs to: no stored word is denormal. */
APPENDIX_A_INLINE float appendix_a_on_grid(float x, float grid)
{
    return (x + grid) - grid;
}

/* |x| as bits, which have the order of the magnitudes. */
APPENDIX_A_INLINE uint32_t appendix_a_size(float x)
{
    return appendix_a_bits(x) & 0x7fffffffu;
}

/* 1 if a parameter is not finite or beyond its limit. */
APPENDIX_A_INLINE uint32_t appendix_a_beyond(float theta)
{
    return (uint32_t)(appendix_a_size(theta) >= appendix_a_bits(APPENDIX_A_LEARN_LIMIT_UM));
}

/* Set the bit of an event in the status word and increment its counter, which stops at its largest value. */
APPENDIX_A_INLINE void appendix_a_count_learner_event(
    appendix_a_learner_t *self, uint32_t *counter, uint32_t happened, uint32_t flag)
{
    self->status |= appendix_a_mask(happened) & flag;
    *counter += happened & (uint32_t)(*counter < UINT32_MAX);
}

/* U = I. */
APPENDIX_A_CODE
static void appendix_a_clear(appendix_a_learner_t *self)
{
    APPENDIX_A_UNROLL
    for (uint32_t i = 0u; i < APPENDIX_A_FACTORS; ++i) {
        self->u[i] = 0.0f;
    }
}

/* The shadow becomes the reference parameters, and P the prior: U = I, D = alpha. */
APPENDIX_A_CODE
static void appendix_a_restart(appendix_a_learner_t *self)
{
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        self->theta[j] = self->reference[j];
        self->theta_low[j] = 0.0f;
        self->d[j] = appendix_a_learn_prior[j];
    }
    appendix_a_clear(self);
    self->scale_um = APPENDIX_A_LEARN_LEVEL_UM;
    self->moving_um = APPENDIX_A_LEARN_LEVEL_UM;
    self->error = 0.0f;
    self->reference_error = 0.0f;
    self->step_error = 0.0f;
    self->run = 0u;
    self->age = 0u;
}

/* ---- Learner: the update, P = U D U' --------------------------------------------------------------------------- */

/* Index of U_ij, i < j, in the packed columns. */
APPENDIX_A_INLINE uint32_t appendix_a_place(uint32_t i, uint32_t j)
{
    return ((j * (j - 1u)) >> 1) + i;
}

/* f = U' x and g = D f with D / lambda:  f_j = sum_{i<j} U_ij x_i + x_j. Row i of U adds to every f_j behind it. */
APPENDIX_A_CODE
static APPENDIX_A_ALONE void appendix_a_project(appendix_a_learner_t *self)
{
    float f[APPENDIX_A_LEARNED];

    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        f[j] = 0.0f;
    }
    APPENDIX_A_UNROLL
    for (uint32_t i = 0u; i < APPENDIX_A_LEARNED; ++i) {
        f[i] = f[i] + self->x[i];
        APPENDIX_A_UNROLL
        for (uint32_t j = i + 1u; j < APPENDIX_A_LEARNED; ++j) {
            f[j] = f[j] + self->u[appendix_a_place(i, j)] * self->x[i];
        }
    }
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        self->f[j] = f[j];
        self->g[j] = appendix_a_on_grid((self->d[j] * self->inflate) * f[j], APPENDIX_A_GAIN_GRID);
    }
}

/* U and k = P x. In column j, over the rows i < j:
 *     U_ij <- U_ij + k_i l_j,  k_i <- k_i + U_ij g_j with the old U_ij,  then k_j = g_j.
 * One loop reads U and the next one writes it, so that the rows of a column can overlap. */
APPENDIX_A_CODE
static APPENDIX_A_ALONE void appendix_a_factor(appendix_a_learner_t *self)
{
    float k[APPENDIX_A_LEARNED];

    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        const float l = self->l[j];
        const float g = self->g[j];
        float u[APPENDIX_A_LEARNED];
        float moved[APPENDIX_A_LEARNED];

        APPENDIX_A_UNROLL
        for (uint32_t i = 0u; i < j; ++i) {
            u[i] = self->u[appendix_a_place(i, j)];
            moved[i] = u[i] + k[i] * l;
        }
        APPENDIX_A_UNROLL
        for (uint32_t i = 0u; i < j; ++i) {
            k[i] = k[i] + u[i] * g;
            self->u[appendix_a_place(i, j)] = appendix_a_on_grid(moved[i], APPENDIX_A_FACTOR_GRID);
        }
        k[j] = g;
    }
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        self->k[j] = k[j];
    }
}

/* 1 if the shadow learns from the sample, 0 for an outlier and for an innovation in the dead zone. The limit of the
 * innovation is that of the usual one times sqrt(alpha), alpha = 1 + x' P x: its variance is alpha times that of the noise. */
APPENDIX_A_CODE
static uint32_t appendix_a_admit(appendix_a_learner_t *self, float alpha)
{
    const float e = self->innovation_um;
    const float size = appendix_a_float(appendix_a_size(e));
    const float limit = APPENDIX_A_LEARN_GATE * self->scale_um + (2.0f * self->moving_um + APPENDIX_A_LEARN_GATE_FLOOR_UM);
    const float square = limit * limit;
    const uint32_t far = (uint32_t)(e * e > square * alpha);
    const uint32_t quiet = (uint32_t)(size < APPENDIX_A_LEARN_DEAD_ZONE_UM) & (uint32_t)(alpha < 1.25f) & (uint32_t)(self->inflate > 1.0f);
    uint32_t changed;
    uint32_t outlier;

    if (alpha < 2.0f) {
        uint32_t cut;
        const float most = 4.0f * self->scale_um + APPENDIX_A_LEARN_GATE_FLOOR_UM;
        const float seen = appendix_a_limited(size, 0.0f, most, &cut) + APPENDIX_A_LEARN_FLOOR_UM;

        self->scale_um = self->scale_um + APPENDIX_A_LEARN_FAST * (seen - self->scale_um);
    }
    self->run = (self->run + far) - ((far ^ 1u) & (uint32_t)(self->run > 0u));
    changed = (uint32_t)(self->run >= APPENDIX_A_LEARN_OUTLIER_RUN);
    outlier = far & (changed ^ 1u);
    if (changed != 0u) {
        self->run = 0u;
        if (size > self->scale_um) {
            self->scale_um = size;
        }
    }
    appendix_a_count_learner_event(self, &self->outliers, outlier, APPENDIX_A_LEARN_OUTLIER);
    appendix_a_count_learner_event(self, &self->changes, changed, APPENDIX_A_LEARN_CHANGED);
    appendix_a_count_learner_event(self, &self->quiet, quiet, APPENDIX_A_LEARN_QUIET);
    return (outlier | quiet) ^ 1u;
}

/* 1/alpha_j for every parameter. */
APPENDIX_A_CODE
static APPENDIX_A_ALONE void appendix_a_reciprocals(const float *alpha, float *per_alpha)
{
    float found[APPENDIX_A_LEARNED];

    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        found[j] = appendix_a_reciprocal(alpha[j]);
    }
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        per_alpha[j] = found[j];
    }
}

/* D becomes d, limited to positive values below the ceiling. Returns 1 if an element was limited. */
APPENDIX_A_CODE
static APPENDIX_A_ALONE uint32_t appendix_a_store_diagonal(appendix_a_learner_t *self, const float *d)
{
    float kept[APPENDIX_A_LEARNED];
    uint32_t clamped = 0u;

    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        uint32_t limited;

        kept[j] = appendix_a_limited(d[j], APPENDIX_A_LEARN_LEAST_VARIANCE, appendix_a_learn_ceiling[j], &limited);
        clamped |= limited;
    }
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        self->d[j] = kept[j];
    }
    return clamped;
}

/* alpha, l and D from f and g, for alpha_(-1) = 1:
 *     alpha_j = alpha_(j-1) + f_j g_j,  l_j = -f_j / alpha_(j-1),  D_j <- D_j / lambda * alpha_(j-1) / alpha_j */
APPENDIX_A_CODE
static APPENDIX_A_ALONE appendix_a_outcome_t appendix_a_update_diagonal(appendix_a_learner_t *self)
{
    float alpha[APPENDIX_A_LEARNED];
    float per_alpha[APPENDIX_A_LEARNED];
    float d[APPENDIX_A_LEARNED];
    float l[APPENDIX_A_LEARNED];
    float before = 1.0f;
    float per_before = 1.0f;
    appendix_a_outcome_t outcome;

    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        alpha[j] = before + self->f[j] * self->g[j];
        before = alpha[j];
    }
    /* The comparison of bits is true for infinity and NaN, too: all accuracy of U and D is lost. */
    if (appendix_a_bits(before) >= appendix_a_bits(APPENDIX_A_LEARN_LARGEST_DENOMINATOR)) {
        outcome = APPENDIX_A_UPDATE_RESTARTS;
    } else if ((self->measuring != 0u) && (appendix_a_admit(self, before) == 0u)) {
        outcome = APPENDIX_A_UPDATE_SKIPPED;
    } else {
        outcome = APPENDIX_A_UPDATE_CONTINUES;
    }
    if (outcome != APPENDIX_A_UPDATE_CONTINUES) {
        return outcome;
    }
    appendix_a_reciprocals(alpha, per_alpha);
    before = 1.0f;
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        l[j] = -(self->f[j] * per_before);
        d[j] = (self->d[j] * self->inflate) * (before * per_alpha[j]);
        before = alpha[j];
        per_before = per_alpha[j];
    }
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        self->l[j] = l[j];
    }
    self->per_alpha = per_before;
    appendix_a_count_learner_event(self, &self->clamped, appendix_a_store_diagonal(self, d), APPENDIX_A_LEARN_CLAMPED);
    return APPENDIX_A_UPDATE_CONTINUES;
}

/* theta <- theta + k q,  q = innovation / alpha,  k = P x. q is reduced if a parameter would move beyond its limit per
 * step. theta is the sum of two words, because most steps are smaller than its last bit. Returns 1 if a parameter is
 * beyond its limit: the shadow restarts. */
APPENDIX_A_CODE
static APPENDIX_A_ALONE uint32_t appendix_a_step(appendix_a_learner_t *self)
{
    float q = self->innovation_um * self->per_alpha;
    uint32_t largest = 0u;
    uint32_t beyond = 0u;
    float size;

    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        const uint32_t k = appendix_a_size(self->k[j]);

        largest = (k > largest) ? k : largest;
    }
    size = appendix_a_float(largest) * appendix_a_float(appendix_a_size(q));
    if (size > APPENDIX_A_LEARN_STEP_UM) {
        q = q * (APPENDIX_A_LEARN_STEP_UM * appendix_a_reciprocal(size));
        appendix_a_count_learner_event(self, &self->limited, 1u, APPENDIX_A_LEARN_LIMITED);
    }
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        const float theta = self->theta[j];
        const float carried = self->theta_low[j] + appendix_a_on_grid(self->k[j] * q, APPENDIX_A_STEP_GRID);
        const float sum = theta + carried;

        self->theta_low[j] = carried - (sum - theta);
        self->theta[j] = sum;
        beyond |= appendix_a_beyond(sum);
    }
    self->age += self->measuring & (uint32_t)(self->age < UINT32_MAX);
    appendix_a_count_learner_event(self, &self->updates, beyond ^ 1u, 0u);
    return beyond;
}

/* One update of P and theta. Returns 1 if the shadow restarts. */
APPENDIX_A_INLINE uint32_t appendix_a_update(appendix_a_learner_t *self)
{
    appendix_a_outcome_t outcome;
    uint32_t lost;

    appendix_a_project(self);
    outcome = appendix_a_update_diagonal(self);
    lost = (uint32_t)(outcome == APPENDIX_A_UPDATE_RESTARTS);
    if (outcome == APPENDIX_A_UPDATE_CONTINUES) {
        appendix_a_factor(self);
        lost = appendix_a_step(self);
    }
    return lost;
}

/* ---- Learner: samples ------------------------------------------------------------------------------------------ */

/* Innovation of the displacement y, e = y - x' theta - fixed, that of the reference parameters and that of the copy on trial. */
APPENDIX_A_CODE
static APPENDIX_A_ALONE float appendix_a_innovations(const appendix_a_learner_t *self, float y, float *reference, float *tried)
{
    float shadow = 0.0f;
    float other = 0.0f;
    float copy = 0.0f;

    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        shadow = shadow + self->x[j] * self->theta[j];
        other = other + self->x[j] * self->reference[j];
        copy = copy + self->x[j] * self->trial[j];
    }
    *reference = y - (other + self->fixed_um);
    *tried = y - (copy + self->fixed_um);
    return y - (shadow + self->fixed_um);
}

/* The innovations of a trial, none larger than that of an outlier, add up as they do in a free run. */
APPENDIX_A_INLINE void appendix_a_try(appendix_a_learner_t *self, float tried, float reference)
{
    uint32_t cut;
    const float gate = APPENDIX_A_LEARN_GATE * self->scale_um + (2.0f * self->moving_um + APPENDIX_A_LEARN_GATE_FLOOR_UM);
    const float limit = appendix_a_float(appendix_a_size(gate));
    const float mine = APPENDIX_A_LEARN_CARRIED * self->trial_um + appendix_a_limited(tried, -limit, limit, &cut);
    const float others = APPENDIX_A_LEARN_CARRIED * self->trial_reference_um + appendix_a_limited(reference, -limit, limit, &cut);

    self->trying -= (uint32_t)(self->trying != 0u);
    self->trial_um = appendix_a_flushed(mine);
    self->trial_reference_um = appendix_a_flushed(others);
    self->trial_error = self->trial_error + APPENDIX_A_LEARN_SLOW * ((mine * mine + APPENDIX_A_LEARN_FLOOR_SQUARE) - self->trial_error);
    self->trial_reference_error = self->trial_reference_error
        + APPENDIX_A_LEARN_SLOW * ((others * others + APPENDIX_A_LEARN_FLOOR_SQUARE) - self->trial_reference_error);
}

/* Update the running means. Returns 1 if the shadow, after its settling time, has a larger mean square innovation than
 * the reference parameters or than y(k+1) = y(k), times a limit each. */
APPENDIX_A_INLINE uint32_t appendix_a_restart_needed(appendix_a_learner_t *self, float e, float reference, float moved)
{
    const float size = appendix_a_float(appendix_a_size(moved)) + APPENDIX_A_LEARN_FLOOR_UM;
    const uint32_t settling = appendix_a_mask((uint32_t)(self->age >= APPENDIX_A_LEARN_SETTLING));
    const float rate = appendix_a_float(appendix_a_bits(APPENDIX_A_LEARN_SLOW) & settling);
    const float mine = e * e + APPENDIX_A_LEARN_FLOOR_SQUARE;
    const float others = reference * reference + APPENDIX_A_LEARN_FLOOR_SQUARE;
    const float persistence = moved * moved + APPENDIX_A_LEARN_FLOOR_SQUARE;

    self->moving_um = self->moving_um + APPENDIX_A_LEARN_FAST * (size - self->moving_um);
    self->error = self->error + rate * (mine - self->error);
    self->reference_error = self->reference_error + rate * (others - self->reference_error);
    self->step_error = self->step_error + rate * (persistence - self->step_error);
    return (uint32_t)(self->age >= APPENDIX_A_LEARN_SETTLED)
        & ((uint32_t)(self->error > APPENDIX_A_LEARN_WORSE * self->reference_error)
            | (uint32_t)(self->error > APPENDIX_A_LEARN_LOST * self->step_error));
}

/* Prepare one update: with the sample, or, every APPENDIX_A_LEARN_REFRESH_EVERY updates, with the pseudo-measurement
 * w reference_j = w theta_j, which restores the prior information of parameter j that forgetting removed. */
APPENDIX_A_INLINE void appendix_a_begin(appendix_a_learner_t *self, float e)
{
    const uint32_t sliding = (uint32_t)(self->age >= APPENDIX_A_LEARN_WINDOW);

    self->since_refresh += sliding;
    self->measuring = (uint32_t)(self->since_refresh < APPENDIX_A_LEARN_REFRESH_EVERY);
    if (self->measuring != 0u) {
        self->inflate = appendix_a_float((appendix_a_bits(APPENDIX_A_LEARN_INFLATE) & appendix_a_mask(sliding))
            | (appendix_a_bits(APPENDIX_A_LEARN_INFLATE_FIRST) & appendix_a_mask(sliding ^ 1u)));
        self->innovation_um = e;
    } else {
        const uint32_t j = self->turn;

        for (uint32_t i = 0u; i < APPENDIX_A_LEARNED; ++i) {
            self->x[i] = 0.0f;
        }
        self->x[j] = appendix_a_learn_refresh[j];
        self->inflate = 1.0f;
        self->innovation_um = appendix_a_learn_refresh[j] * (self->reference[j] - self->theta[j]);
        self->turn = (j + 1u < APPENDIX_A_LEARNED) ? j + 1u : 0u;
        self->since_refresh = 0u;
    }
}

/* Compare the displacement y with the prediction from sample k - 1. Returns 1 if the shadow restarts; *begun becomes 1
 * if an update begins. */
APPENDIX_A_INLINE uint32_t appendix_a_evaluate_reading(
    appendix_a_learner_t *self, float y, float *innovation, uint32_t *begun)
{
    float reference;
    float tried;
    uint32_t lost = 0u;

    *innovation = appendix_a_innovations(self, y, &reference, &tried);
    appendix_a_count_learner_event(self, &self->resting, self->rested, APPENDIX_A_LEARN_RESTING);
    if (self->rested == 0u) {
        appendix_a_try(self, tried, reference);
        lost = appendix_a_restart_needed(self, *innovation, reference, y - self->y_um);
        if (lost == 0u) {
            appendix_a_begin(self, *innovation);
            *begun = 1u;
        }
    }
    return lost;
}

/* Keep the regressors of sample k for the displacement of sample k + 1:  x = phi / scale. The regressors of rule l are
 * p_l y, p_l u and p_l with p_l = w_l r^l / W; the strength w_l is part of the numbers in a bank. */
APPENDIX_A_CODE
static APPENDIX_A_ALONE void appendix_a_store_regressors(appendix_a_learner_t *self, float y_um, float u)
{
    uint32_t outside;
    const float y = appendix_a_limited(y_um, APPENDIX_A_Y_MIN_UM, APPENDIX_A_Y_MAX_UM, &outside);
    const appendix_a_sums_t sums = appendix_a_rule_sums(&self->base, y);
    const float per_weight = appendix_a_reciprocal(sums.weight);
    const float r = appendix_a_power_of_two((y - APPENDIX_A_ORIGIN_UM) * APPENDIX_A_PER_STEP);
    const float y_share = y * APPENDIX_A_LEARN_PER_Y;
    const float u_share = u * APPENDIX_A_LEARN_PER_U;
    float power[APPENDIX_A_RULES];

    power[0] = 1.0f;
    power[1] = r;
    APPENDIX_A_UNROLL
    for (uint32_t l = 2u; l < APPENDIX_A_RULES; ++l) {
        power[l] = power[l >> 1] * power[l - (l >> 1)];
    }

    self->fixed_um = 0.0f;
    APPENDIX_A_UNROLL
    for (uint32_t l = 0u; l < APPENDIX_A_RULES; ++l) {
        const float firing = (power[l] * per_weight) * appendix_a_learn_firing[l];

        self->x[3u * l] = appendix_a_on_grid(firing * y_share, APPENDIX_A_REGRESSOR_GRID);
        self->x[3u * l + 1u] = appendix_a_on_grid(firing * u_share, APPENDIX_A_REGRESSOR_GRID);
        self->x[3u * l + 2u] = appendix_a_on_grid(firing, APPENDIX_A_REGRESSOR_GRID);
    }
    self->fresh = outside ^ 1u;
    self->y_um = y_um;
    appendix_a_count_learner_event(self, &self->outside, outside, APPENDIX_A_LEARN_OUTSIDE);
}

APPENDIX_A_CODE
void appendix_a_learn(appendix_a_learner_t *self, float y_um, float u_V)
{
    uint32_t y_lost;
    uint32_t u_lost;
    uint32_t moved;
    const float y = appendix_a_finite(y_um, self->y_um, &y_lost);
    const float u_finite = appendix_a_finite(u_V, self->u_V, &u_lost);
    const float u = appendix_a_limited(u_finite, APPENDIX_A_U_MIN_V, APPENDIX_A_U_MAX_V, &moved);
    const uint32_t implausible = (uint32_t)(y < APPENDIX_A_LEARN_Y_LOW_UM) | (uint32_t)(y > APPENDIX_A_LEARN_Y_HIGH_UM);
    const uint32_t usable = 1u ^ (y_lost | implausible);
    const float away = u - self->mean_u_V;
    float innovation = 0.0f;
    uint32_t begun = 0u;
    uint32_t lost = 0u;

    appendix_a_count_learner_event(self, &self->rejected, (usable ^ 1u) | u_lost, APPENDIX_A_LEARN_REJECTED);
    if ((self->fresh & usable) != 0u) {
        lost = appendix_a_evaluate_reading(self, y, &innovation, &begun);
    }
    if (begun != 0u) {
        lost = appendix_a_update(self);
    }
    if (lost != 0u) {
        appendix_a_count_learner_event(self, &self->restarts, 1u, APPENDIX_A_LEARN_RESTARTED);
        appendix_a_restart(self);
    }
    self->fresh = 0u;
    if ((usable & (u_lost ^ 1u)) != 0u) {
        appendix_a_store_regressors(self, y, u);
    }
    self->rested = (uint32_t)(appendix_a_float(appendix_a_size(away)) < APPENDIX_A_LEARN_REST_V);
    self->mean_u_V = appendix_a_flushed(self->mean_u_V + APPENDIX_A_LEARN_FAST * away);
    self->u_V = u;
}

APPENDIX_A_CODE
void appendix_a_learn_init(appendix_a_learner_t *self, const appendix_a_t *model)
{
    const appendix_a_bank_t *bank = &model->bank[model->active];

    APPENDIX_A_UNROLL
    for (uint32_t l = 0u; l < APPENDIX_A_BANK_RULES; ++l) {
        self->base.slope[l] = bank->slope[l];
        self->base.offset[l] = bank->offset[l];
        self->base.gain[l] = bank->gain[l];
    }
    APPENDIX_A_UNROLL
    for (uint32_t l = 0u; l < APPENDIX_A_RULES; ++l) {
        self->reference[3u * l] = self->base.slope[l] * appendix_a_learn_scale[3u * l];
        self->reference[3u * l + 1u] = self->base.gain[l] * appendix_a_learn_scale[3u * l + 1u];
        self->reference[3u * l + 2u] = self->base.offset[l] * appendix_a_learn_scale[3u * l + 2u];
    }
    for (uint32_t i = 0u; i < APPENDIX_A_LEARNED; ++i) {
        self->x[i] = 0.0f;
        self->trial[i] = 0.0f;
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
    self->trial_um = 0.0f;
    self->trial_reference_um = 0.0f;
    self->trial_error = 0.0f;
    self->trial_reference_error = 0.0f;
    self->fresh = 0u;
    self->rested = 0u;
    self->measuring = 0u;
    self->since_refresh = 0u;
    self->turn = 0u;
    self->trying = 0u;
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
    self->candidate.phase = (uint32_t)APPENDIX_A_PHASE_IDLE;
    self->candidate.point = 0u;
    appendix_a_restart(self);
}

/* ---- Commit ---------------------------------------------------------------------------------------------------- */

APPENDIX_A_INLINE float appendix_a_lesser(float a, float b)
{
    return (b < a) ? b : a;
}

APPENDIX_A_INLINE float appendix_a_greater(float a, float b)
{
    return (b > a) ? b : a;
}

/* y q1 + u q2 + one q3 of rule l; the table takes the rule's strength off the numbers in the bank. */
APPENDIX_A_INLINE float appendix_a_rule_value(const appendix_a_bank_t *bank, uint32_t l, float y, float u, float one)
{
    return ((y * bank->slope[l] + u * bank->gain[l]) + one * bank->offset[l]) * appendix_a_commit_unfold[l];
}

/* Half the difference between the largest and the smallest y q1 + u q2 + one q3 of a rule. */
APPENDIX_A_INLINE float appendix_a_half_span(const appendix_a_bank_t *bank, float y, float u, float one)
{
    float least = appendix_a_rule_value(bank, 0u, y, u, one);
    float most = least;

    APPENDIX_A_UNROLL
    for (uint32_t l = 1u; l < APPENDIX_A_RULES; ++l) {
        const float value = appendix_a_rule_value(bank, l, y, u, one);

        least = appendix_a_lesser(least, value);
        most = appendix_a_greater(most, value);
    }
    return 0.5f * (most - least);
}

/* Bounds of the Taylor remainders of gain and slope between the check points, for the parameters of the candidate. */
APPENDIX_A_CODE
static void appendix_a_bound_remainders(appendix_a_candidate_t *candidate)
{
    const appendix_a_bank_t *bank = &candidate->bank;
    const float common = APPENDIX_A_COMMIT_SLOPE_REMAINDER_1 * appendix_a_half_span(bank, 1.0f, 0.0f, 0.0f);
    const float low = appendix_a_greater(appendix_a_half_span(bank, APPENDIX_A_Y_MIN_UM, APPENDIX_A_U_MIN_V, 1.0f),
        appendix_a_half_span(bank, APPENDIX_A_Y_MAX_UM, APPENDIX_A_U_MIN_V, 1.0f));
    const float high = appendix_a_greater(appendix_a_half_span(bank, APPENDIX_A_Y_MIN_UM, APPENDIX_A_U_MAX_V, 1.0f),
        appendix_a_half_span(bank, APPENDIX_A_Y_MAX_UM, APPENDIX_A_U_MAX_V, 1.0f));

    candidate->gain_remainder_um_per_V = APPENDIX_A_COMMIT_GAIN_REMAINDER * appendix_a_half_span(bank, 0.0f, 1.0f, 0.0f);
    candidate->slope_remainder[0] = common + APPENDIX_A_COMMIT_SLOPE_REMAINDER_3 * low;
    candidate->slope_remainder[1] = common + APPENDIX_A_COMMIT_SLOPE_REMAINDER_3 * high;
}

/* Copy the shadow for a trial, on nothing if nothing was ever learnt, unless it is too young or a parameter is beyond its limit. */
APPENDIX_A_CODE
static appendix_a_commit_t appendix_a_snapshot(appendix_a_learner_t *learner)
{
    appendix_a_candidate_t *candidate = &learner->candidate;
    appendix_a_bank_t *bank = &candidate->bank;
    uint32_t beyond = 0u;

    if (learner->age < APPENDIX_A_COMMIT_MATURE) {
        return APPENDIX_A_COMMIT_REFUSED_YOUNG;
    }
    APPENDIX_A_UNROLL
    for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
        learner->trial[j] = learner->theta[j];
        beyond |= appendix_a_beyond(learner->theta[j]);
    }
    APPENDIX_A_UNROLL
    for (uint32_t l = 0u; l < APPENDIX_A_RULES; ++l) {
        bank->slope[l] = learner->theta[3u * l] * appendix_a_learn_per_scale[3u * l];
        bank->offset[l] = learner->theta[3u * l + 2u] * appendix_a_learn_per_scale[3u * l + 2u];
        bank->gain[l] = learner->theta[3u * l + 1u] * appendix_a_learn_per_scale[3u * l + 1u];
    }
    if (beyond != 0u) {
        return APPENDIX_A_COMMIT_REFUSED_LIMIT;
    }
    appendix_a_bound_remainders(candidate);
    learner->trial_um = 0.0f;
    learner->trial_reference_um = 0.0f;
    learner->trial_error = 0.0f;
    learner->trial_reference_error = 0.0f;
    learner->trying = (learner->updates != 0u) ? (uint32_t)APPENDIX_A_COMMIT_TRIAL : 0u;
    candidate->point = 0u;
    candidate->phase = (uint32_t)APPENDIX_A_PHASE_CHECK;
    return APPENDIX_A_COMMIT_BUSY;
}

/* 1 if |df/dy| may reach its limit within half a distance of the check points, from its value and its derivative. */
APPENDIX_A_INLINE uint32_t appendix_a_too_steep(float slope, float curve, float remainder)
{
    const float change = APPENDIX_A_COMMIT_HALF_UM * appendix_a_float(appendix_a_size(curve));

    return (uint32_t)(appendix_a_float(appendix_a_size(slope)) + (change + remainder) >= APPENDIX_A_COMMIT_SLOPE_LIMIT);
}

/* Gain and slope around one check point. With f = a(y) y + b(y) u + c(y), a = sum p_l q_l1 and likewise b and c:
 *     df/dy = a + a' y + b' u + c',  d2f/dy2 = 2 a' + a'' y + b'' u + c''
 * p_l, p_l' and p_l'' at the check point stand in a row of the table. */
APPENDIX_A_CODE
static appendix_a_commit_t appendix_a_check(const appendix_a_candidate_t *candidate)
{
    const float *p = &appendix_a_commit_table[candidate->point * (3u * APPENDIX_A_RULES)];
    const float *dp = &p[APPENDIX_A_RULES];
    const float *ddp = &dp[APPENDIX_A_RULES];
    const appendix_a_bank_t *bank = &candidate->bank;
    const float y = appendix_a_commit_y[candidate->point];
    float a = 0.0f;
    float da = 0.0f;
    float dda = 0.0f;
    float b = 0.0f;
    float db = 0.0f;
    float ddb = 0.0f;
    float dc = 0.0f;
    float ddc = 0.0f;

    APPENDIX_A_UNROLL
    for (uint32_t l = 0u; l < APPENDIX_A_RULES; ++l) {
        a = a + p[l] * bank->slope[l];
        da = da + dp[l] * bank->slope[l];
        dda = dda + ddp[l] * bank->slope[l];
        b = b + p[l] * bank->gain[l];
        db = db + dp[l] * bank->gain[l];
        ddb = ddb + ddp[l] * bank->gain[l];
        dc = dc + dp[l] * bank->offset[l];
        ddc = ddc + ddp[l] * bank->offset[l];
    }

    const float gain = APPENDIX_A_COMMIT_SIGN * b;
    const float away = APPENDIX_A_COMMIT_HALF_UM * appendix_a_float(appendix_a_size(db)) + candidate->gain_remainder_um_per_V;
    const float slope = (a + da * y) + dc;
    const float curve = ((da + da) + dda * y) + ddc;
    const uint32_t steep =
        appendix_a_too_steep(slope + db * APPENDIX_A_U_MIN_V, curve + ddb * APPENDIX_A_U_MIN_V, candidate->slope_remainder[0])
        | appendix_a_too_steep(slope + db * APPENDIX_A_U_MAX_V, curve + ddb * APPENDIX_A_U_MAX_V, candidate->slope_remainder[1]);
    const uint32_t weak = (uint32_t)(gain - away <= APPENDIX_A_COMMIT_GAIN_FLOOR)
        | (uint32_t)(gain + away >= APPENDIX_A_COMMIT_GAIN_CEILING);

    if (weak != 0u) {
        return APPENDIX_A_COMMIT_REFUSED_GAIN;
    }
    return (steep != 0u) ? APPENDIX_A_COMMIT_REFUSED_SLOPE : APPENDIX_A_COMMIT_BUSY;
}

/* Copy the candidate into the bank that is not in use. */
APPENDIX_A_CODE
static void appendix_a_write(appendix_a_t *self, const appendix_a_candidate_t *candidate)
{
    appendix_a_bank_t *idle = &self->bank[1u - self->active];

    for (uint32_t l = 0u; l < APPENDIX_A_BANK_RULES; ++l) {
        idle->slope[l] = candidate->bank.slope[l];
        idle->offset[l] = candidate->bank.offset[l];
        idle->gain[l] = candidate->bank.gain[l];
    }
}

/* Writing and switching are two calls: an interrupt between them finds the active bank complete. */
APPENDIX_A_CODE
appendix_a_commit_t appendix_a_commit(appendix_a_t *self, appendix_a_learner_t *learner)
{
    appendix_a_candidate_t *candidate = &learner->candidate;
    appendix_a_commit_t answer = APPENDIX_A_COMMIT_BUSY;

    switch (candidate->phase) {
    case (uint32_t)APPENDIX_A_PHASE_IDLE:
        answer = appendix_a_snapshot(learner);
        break;
    case (uint32_t)APPENDIX_A_PHASE_CHECK:
        for (uint32_t i = 0u; i < 1u; ++i) {
            if ((candidate->phase == (uint32_t)APPENDIX_A_PHASE_CHECK) && (answer == APPENDIX_A_COMMIT_BUSY)) {
                answer = appendix_a_check(candidate);
                candidate->point += 1u;
                candidate->phase += (uint32_t)(candidate->point >= APPENDIX_A_COMMIT_POINTS);
            }
        }
        candidate->phase = (answer == APPENDIX_A_COMMIT_BUSY) ? candidate->phase : (uint32_t)APPENDIX_A_PHASE_IDLE;
        break;
    case (uint32_t)APPENDIX_A_PHASE_TRIAL:
        if (learner->trying != 0u) {
            answer = APPENDIX_A_COMMIT_TRYING;
        } else if (learner->trial_error > learner->trial_reference_error) {
            answer = APPENDIX_A_COMMIT_REFUSED_WORSE;
            candidate->phase = (uint32_t)APPENDIX_A_PHASE_IDLE;
        } else {
            candidate->phase = (uint32_t)APPENDIX_A_PHASE_WRITE;
        }
        break;
    case (uint32_t)APPENDIX_A_PHASE_WRITE:
        appendix_a_write(self, candidate);
        candidate->phase = (uint32_t)APPENDIX_A_PHASE_SWITCH;
        break;
    default:
        self->active = 1u - self->active;
        for (uint32_t j = 0u; j < APPENDIX_A_LEARNED; ++j) {
            learner->reference[j] = learner->trial[j];
        }
        candidate->phase = (uint32_t)APPENDIX_A_PHASE_IDLE;
        answer = APPENDIX_A_COMMIT_COMMITTED;
        break;
    }
    return answer;
}
