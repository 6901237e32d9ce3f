/* smooth_50.c: the algorithm of model `smooth_50`; changes only with the model's structure. Interface: smooth_50.h. */

#include "smooth_50.h"

/* Equal bits on every machine rest on float32 operations as they are written: no shortcuts, no wider intermediate
 * results, no multiplication fused with an addition. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#error "smooth_50: compile without -ffast-math and its parts"
#endif
#if defined(__FLT_EVAL_METHOD__)
#if __FLT_EVAL_METHOD__ != 0
#error "smooth_50: float must be evaluated as float (on x86: -msse2 -mfpmath=sse)"
#endif
#endif

#include <float.h>
#include <limits.h>

#if CHAR_BIT != 8 || FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MIN_EXP != -125 || FLT_MAX_EXP != 128
#error "smooth_50: needs bytes of 8 bits, and float in the 32-bit format of IEEE 754"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__GNUC__)
#define SMOOTH_50_INLINE static inline __attribute__((always_inline))
#else
#define SMOOTH_50_INLINE SMOOTH_50_CODE static inline
#endif

#define SMOOTH_50_NUMBERS
#include "smooth_50_params.h"

/* ---- Arithmetic ---------------------------------------------------------------------------------------------- */

SMOOTH_50_INLINE uint32_t smooth_50_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

SMOOTH_50_INLINE float smooth_50_float(uint32_t bits)
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
SMOOTH_50_INLINE float smooth_50_power_of_two(float x)
{
    const float shifted = x + 12582912.0f;
    const float f = x - (shifted - 12582912.0f);
    const float square = f * f;
    const float fourth = square * square;
    const float low = 1.0f + 0.693147182f * f;
    const float middle = 0.240226477f + 0.0555035993f * f;
    const float high = (0.00961850584f + 0.00133908063f * f) + 0.000153264715f * square;
    const float mantissa = low + (square * middle + fourth * high);

    return smooth_50_float(smooth_50_bits(mantissa) + (smooth_50_bits(shifted) << 23));
}

/* 1/x for 2^-120 <= |x| <= 2^120, relative error at most 1.5e-07: a seed from the bits, then 3 Newton steps
 *     r <- r (2 - x r) */
SMOOTH_50_INLINE float smooth_50_reciprocal(float x)
{
    float r = smooth_50_float(0x7ef311c7u - smooth_50_bits(x));

    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);

    return r;
}

/* ---- Input checks: constant time, by masks --------------------------------------------------------------------- */

/* All ones if the condition is 1, else 0. */
SMOOTH_50_INLINE uint32_t smooth_50_mask(uint32_t condition)
{
    return 0u - condition;
}

/** Events at the inputs during one call, 1 if the event occurred and 0 if not. */
typedef struct {
    uint32_t y_clamped;   /**< y was outside its range and was limited. */
    uint32_t u_clamped;   /**< u was outside its range and was limited. */
    uint32_t y_rejected;  /**< y was not finite and was replaced. */
    uint32_t u_rejected;  /**< u was not finite and was replaced. */
} smooth_50_events_t;

SMOOTH_50_INLINE uint32_t smooth_50_counted(uint32_t counter, uint32_t happened)
{
    return counter + (happened & (uint32_t)(counter < UINT32_MAX));
}

/* Status bits and counters of one call. Called last: the counting fills the slots that the arithmetic leaves free. */
SMOOTH_50_INLINE void smooth_50_count_events(smooth_50_t *self, const smooth_50_events_t *events)
{
    self->status |= (events->y_clamped * SMOOTH_50_STATUS_Y_CLAMPED) | (events->u_clamped * SMOOTH_50_STATUS_U_CLAMPED)
        | (events->y_rejected * SMOOTH_50_STATUS_Y_REJECTED) | (events->u_rejected * SMOOTH_50_STATUS_U_REJECTED);
    self->y_clamped = smooth_50_counted(self->y_clamped, events->y_clamped);
    self->u_clamped = smooth_50_counted(self->u_clamped, events->u_clamped);
    self->y_rejected = smooth_50_counted(self->y_rejected, events->y_rejected);
    self->u_rejected = smooth_50_counted(self->u_rejected, events->u_rejected);
}

/* x, or the value held if x is not finite; magnitudes below 2^-40 become 0, so that denormal numbers never occur. */
SMOOTH_50_INLINE float smooth_50_finite(float x, float held, uint32_t *rejected)
{
    const uint32_t bits = smooth_50_bits(x);
    const uint32_t magnitude = bits & 0x7fffffffu;
    const uint32_t infinite = (uint32_t)(magnitude >= 0x7f800000u);
    const uint32_t keep = smooth_50_mask((uint32_t)(magnitude >= 0x2b800000u));
    const uint32_t hold = smooth_50_mask(infinite);

    *rejected = infinite;
    return smooth_50_float((bits & keep & ~hold) | (smooth_50_bits(held) & hold));
}

/* A result before it leaves or is kept: magnitudes below 2^-40 become 0. */
SMOOTH_50_INLINE float smooth_50_flushed(float x)
{
    const uint32_t bits = smooth_50_bits(x);

    return smooth_50_float(bits & smooth_50_mask((uint32_t)((bits & 0x7fffffffu) >= 0x2b800000u)));
}

/* x limited to [low, high]. */
SMOOTH_50_INLINE float smooth_50_limited(float x, float low, float high, uint32_t *clamped)
{
    const uint32_t below = (uint32_t)(x < low);
    const uint32_t above = (uint32_t)(x > high);
    const uint32_t raise = smooth_50_mask(below);
    const uint32_t lower = smooth_50_mask(above);

    *clamped = below | above;
    return smooth_50_float(
        (smooth_50_bits(x) & ~(raise | lower)) | (smooth_50_bits(low) & raise) | (smooth_50_bits(high) & lower));
}

/** The range of the inverse's voltage at one sample. */
typedef struct {
    float low;   /**< Lowest voltage [V]. */
    float high;  /**< Highest voltage [V]. */
} smooth_50_span_t;

/* low_V .. high_V, and at most step_V from the voltage before. */
SMOOTH_50_INLINE smooth_50_span_t smooth_50_span(const smooth_50_t *self, float last_V)
{
    const float least = self->low_V;
    const float most = self->high_V;
    const float down = last_V - self->step_V;
    const float up = last_V + self->step_V;
    const float low = (down < least) ? least : down;
    const float high = (up < least) ? least : up;
    smooth_50_span_t span;

    span.low = (low > most) ? most : low;
    span.high = (high > most) ? most : high;
    return span;
}

/* The voltage of the span that is nearest to x. */
SMOOTH_50_INLINE float smooth_50_allowed(float x, smooth_50_span_t span, uint32_t *clamped)
{
    const float low = span.low;
    const float high = span.high;
    const float raised = (x < low) ? low : x;
    const float allowed = (raised > high) ? high : raised;

    *clamped = (uint32_t)(allowed < x) | (uint32_t)(allowed > x);
    return allowed;
}

/* A displacement inside the identified range, whatever came in. */
SMOOTH_50_INLINE float smooth_50_checked_y(const smooth_50_t *self, float y_um, smooth_50_events_t *events)
{
    const float finite = smooth_50_finite(y_um, self->y_um, &events->y_rejected);

    return smooth_50_limited(finite, SMOOTH_50_Y_MIN_UM, SMOOTH_50_Y_MAX_UM, &events->y_clamped);
}

/* A voltage inside the input range, whatever came in. */
SMOOTH_50_INLINE float smooth_50_checked_u(const smooth_50_t *self, float u_V, smooth_50_events_t *events)
{
    const float finite = smooth_50_finite(u_V, self->u_V, &events->u_rejected);

    return smooth_50_limited(finite, SMOOTH_50_U_MIN_V, SMOOTH_50_U_MAX_V, &events->u_clamped);
}

/* ---- Rules ----------------------------------------------------------------------------------------------------- */

/** Sums over the rules; v_l are the unnormalised memberships, p_l = v_l / weight. */
typedef struct {
    float slope;   /**< Sum of v_l q_l1. */
    float offset;  /**< Sum of v_l q_l3 [um]. */
    float gain;    /**< Sum of v_l q_l2. */
    float weight;  /**< Sum of v_l. */
} smooth_50_sums_t;

/* Of 50 rules the 11 around the nearest centre are summed, the others carry less than 3e-7 of the weight. With t the
 * distance from that centre in steps and r = exp(t), |t| <= 1/2, row j of the window fires with v_j = w_j r^j; rows beyond
 * the first and last rule are phantoms of weight 0. The cost does not depend on the number of rules. y inside the range. */
SMOOTH_50_INLINE smooth_50_sums_t smooth_50_rule_sums(const smooth_50_bank_t *bank, float y)
{
    const float steps = (y - SMOOTH_50_ORIGIN_UM) * SMOOTH_50_PER_STEP;
    const float shifted = steps + 12582912.0f;
    const float t = steps - (shifted - 12582912.0f);
    const uint32_t nearest = smooth_50_bits(shifted) - 0x4b400000u;
    const float *present = &smooth_50_present[nearest];
    const float *slope = &bank->slope[nearest];
    const float *offset = &bank->offset[nearest];
    const float *gain = &bank->gain[nearest];

    const float r = smooth_50_power_of_two(t * 1.44269502f);
    const float r2 = r * r;
    const float r3 = r * r2;
    const float r4 = r2 * r2;
    const float r5 = r2 * r3;
    const float r6 = r3 * r3;
    const float r7 = r3 * r4;
    const float r8 = r4 * r4;
    const float r9 = r4 * r5;
    const float r10 = r5 * r5;

    const float v0 = smooth_50_strength[0];
    const float v1 = smooth_50_strength[1] * r;
    const float v2 = smooth_50_strength[2] * r2;
    const float v3 = smooth_50_strength[3] * r3;
    const float v4 = smooth_50_strength[4] * r4;
    const float v5 = smooth_50_strength[5] * r5;
    const float v6 = smooth_50_strength[6] * r6;
    const float v7 = smooth_50_strength[7] * r7;
    const float v8 = smooth_50_strength[8] * r8;
    const float v9 = smooth_50_strength[9] * r9;
    const float v10 = smooth_50_strength[10] * r10;
    smooth_50_sums_t sums;

    const float w0_1 = v0 * present[0] + v1 * present[1];
    const float w2_3 = v2 * present[2] + v3 * present[3];
    const float w4_5 = v4 * present[4] + v5 * present[5];
    const float w6_7 = v6 * present[6] + v7 * present[7];
    const float w8_9 = v8 * present[8] + v9 * present[9];
    const float w0_3 = w0_1 + w2_3;
    const float w4_7 = w4_5 + w6_7;
    const float w8_10 = w8_9 + v10 * present[10];
    const float w0_7 = w0_3 + w4_7;
    sums.weight = w0_7 + w8_10;

    const float s0_1 = v0 * slope[0] + v1 * slope[1];
    const float s2_3 = v2 * slope[2] + v3 * slope[3];
    const float s4_5 = v4 * slope[4] + v5 * slope[5];
    const float s6_7 = v6 * slope[6] + v7 * slope[7];
    const float s8_9 = v8 * slope[8] + v9 * slope[9];
    const float s0_3 = s0_1 + s2_3;
    const float s4_7 = s4_5 + s6_7;
    const float s8_10 = s8_9 + v10 * slope[10];
    const float s0_7 = s0_3 + s4_7;
    sums.slope = s0_7 + s8_10;

    const float o0_1 = v0 * offset[0] + v1 * offset[1];
    const float o2_3 = v2 * offset[2] + v3 * offset[3];
    const float o4_5 = v4 * offset[4] + v5 * offset[5];
    const float o6_7 = v6 * offset[6] + v7 * offset[7];
    const float o8_9 = v8 * offset[8] + v9 * offset[9];
    const float o0_3 = o0_1 + o2_3;
    const float o4_7 = o4_5 + o6_7;
    const float o8_10 = o8_9 + v10 * offset[10];
    const float o0_7 = o0_3 + o4_7;
    sums.offset = o0_7 + o8_10;

    const float g0_1 = v0 * gain[0] + v1 * gain[1];
    const float g2_3 = v2 * gain[2] + v3 * gain[3];
    const float g4_5 = v4 * gain[4] + v5 * gain[5];
    const float g6_7 = v6 * gain[6] + v7 * gain[7];
    const float g8_9 = v8 * gain[8] + v9 * gain[9];
    const float g0_3 = g0_1 + g2_3;
    const float g4_7 = g4_5 + g6_7;
    const float g8_10 = g8_9 + v10 * gain[10];
    const float g0_7 = g0_3 + g4_7;
    sums.gain = g0_7 + g8_10;

    return sums;
}

/* ---- Prediction ------------------------------------------------------------------------------------------------ */

SMOOTH_50_CODE
void smooth_50_init(smooth_50_t *self, float y_um, float u_V)
{
    smooth_50_events_t events;

    for (uint32_t b = 0u; b < 2u; ++b) {
        for (uint32_t l = 0u; l < SMOOTH_50_BANK_RULES; ++l) {
            self->bank[b].slope[l] = smooth_50_slope[l];
            self->bank[b].offset[l] = smooth_50_offset[l];
            self->bank[b].gain[l] = smooth_50_gain[l];
        }
    }
    self->active = 0u;
    self->status = 0u;
    self->y_clamped = 0u;
    self->u_clamped = 0u;
    self->y_rejected = 0u;
    self->u_rejected = 0u;
    self->y_um = SMOOTH_50_Y_REST_UM;
    self->u_V = SMOOTH_50_U_REST_V;
    self->y_um = smooth_50_checked_y(self, y_um, &events);
    self->u_V = smooth_50_checked_u(self, u_V, &events);
    smooth_50_count_events(self, &events);
    self->low_V = SMOOTH_50_U_MIN_V;
    self->high_V = SMOOTH_50_U_MAX_V;
    self->step_V = SMOOTH_50_U_STEP_MAX_V;
}

/* The model's output under the input u, Eq. (4), with base = y S + O; the input acts on the state. */
SMOOTH_50_INLINE float smooth_50_apply(smooth_50_t *self, float base, float gain, float per_weight, float u)
{
    const float rules = (base + u * gain) * per_weight;
    const float y_next = smooth_50_flushed(rules);

    self->y_um = y_next;
    return y_next;
}

/* y(k+1) from measured y(k) and u(k). */
SMOOTH_50_CODE
float smooth_50_predict(smooth_50_t *self, float y_um, float u_V)
{
    const smooth_50_bank_t *bank = &self->bank[self->active];
    smooth_50_events_t events;
    const float y = smooth_50_checked_y(self, y_um, &events);
    const float u = smooth_50_checked_u(self, u_V, &events);
    const smooth_50_sums_t sums = smooth_50_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = smooth_50_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = smooth_50_apply(self, base, sums.gain, per_weight, u);

    smooth_50_count_events(self, &events);
    return y_next;
}

/* ---- Free run -------------------------------------------------------------------------------------------------- */

/* y(k+1) from the last output and u(k). */
SMOOTH_50_CODE
float smooth_50_simulate(smooth_50_t *self, float u_V)
{
    const smooth_50_bank_t *bank = &self->bank[self->active];
    smooth_50_events_t events = { 0u, 0u, 0u, 0u };
    const float y = smooth_50_limited(self->y_um, SMOOTH_50_Y_MIN_UM, SMOOTH_50_Y_MAX_UM, &events.y_clamped);
    const float u = smooth_50_checked_u(self, u_V, &events);
    const smooth_50_sums_t sums = smooth_50_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = smooth_50_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = smooth_50_apply(self, base, sums.gain, per_weight, u);

    smooth_50_count_events(self, &events);
    return y_next;
}

/* ---- Inverse --------------------------------------------------------------------------------------------------- */

SMOOTH_50_CODE
void smooth_50_limits(smooth_50_t *self, float low_V, float high_V, float step_V)
{
    uint32_t acted;
    const float low = smooth_50_finite(low_V, SMOOTH_50_U_MIN_V, &acted);
    const float high = smooth_50_finite(high_V, SMOOTH_50_U_MAX_V, &acted);
    const float step = smooth_50_finite(step_V, SMOOTH_50_U_STEP_MAX_V, &acted);

    self->low_V = smooth_50_limited(low, SMOOTH_50_U_MIN_V, SMOOTH_50_U_MAX_V, &acted);
    self->high_V = smooth_50_limited(high, self->low_V, SMOOTH_50_U_MAX_V, &acted);
    self->step_V = smooth_50_limited(step, 0.0f, SMOOTH_50_U_STEP_MAX_V, &acted);
}

/* u(k) that takes y(k) to y(k+1): (y(k+1) - sum theta phi) W = y S + O + u G, solved for u. */
SMOOTH_50_CODE
float smooth_50_inverse(smooth_50_t *self, float y_um, float y_next_um)
{
    const smooth_50_bank_t *bank = &self->bank[self->active];
    smooth_50_events_t events = { 0u, 0u, 0u, 0u };
    uint32_t rejected;
    uint32_t clamped;
    const float y = smooth_50_checked_y(self, y_um, &events);
    const smooth_50_sums_t sums = smooth_50_rule_sums(bank, y);
    const smooth_50_span_t span = smooth_50_span(self, self->u_V);
    const float finite = smooth_50_finite(y_next_um, y, &rejected);
    const float wanted = smooth_50_limited(finite, SMOOTH_50_REFERENCE_MIN_UM, SMOOTH_50_REFERENCE_MAX_UM, &clamped);
    const float base = y * sums.slope + sums.offset;
    const float numerator = wanted * sums.weight - base;
    const float per_gain = smooth_50_reciprocal(sums.gain);
    const float per_weight = smooth_50_reciprocal(sums.weight);
    const float exact = smooth_50_flushed(numerator * per_gain);
    const float u = smooth_50_allowed(exact, span, &events.u_clamped);
    const uint32_t unreachable = events.u_clamped;

    self->status |= (clamped * SMOOTH_50_STATUS_REFERENCE_CLAMPED) | (unreachable * SMOOTH_50_STATUS_UNREACHABLE);
    events.y_rejected |= rejected;
    smooth_50_count_events(self, &events);
    self->u_V = u;
    (void)smooth_50_apply(self, base, sums.gain, per_weight, u);
    return u;
}
