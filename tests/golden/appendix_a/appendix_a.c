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
