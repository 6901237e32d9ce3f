/* extended.c: the algorithm of model `extended`; changes only with the model's structure. Interface: extended.h. */

#include "extended.h"

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

#include <float.h>
#include <limits.h>

#if CHAR_BIT != 8 || FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MIN_EXP != -125 || FLT_MAX_EXP != 128
#error "extended: needs bytes of 8 bits, and float in the 32-bit format of IEEE 754"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__GNUC__)
#define EXTENDED_INLINE static inline __attribute__((always_inline))
#else
#define EXTENDED_INLINE EXTENDED_CODE static inline
#endif

#define EXTENDED_NUMBERS
#include "extended_params.h"

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

/** Voltages that the inverse may put out at one sample. */
typedef struct {
    float low;   /**< [V] */
    float high;  /**< [V] */
} extended_span_t;

/* low_V .. high_V, and at most step_V from the voltage before. */
EXTENDED_INLINE extended_span_t extended_span(const extended_t *self, float last_V)
{
    const float least = self->low_V;
    const float most = self->high_V;
    const float down = last_V - self->step_V;
    const float up = last_V + self->step_V;
    const float low = (down < least) ? least : down;
    const float high = (up < least) ? least : up;
    extended_span_t span;

    span.low = (low > most) ? most : low;
    span.high = (high > most) ? most : high;
    return span;
}

/* The voltage of the span that is nearest to x. */
EXTENDED_INLINE float extended_allowed(float x, extended_span_t span, uint32_t *clamped)
{
    const float low = span.low;
    const float high = span.high;
    const float raised = (x < low) ? low : x;
    const float allowed = (raised > high) ? high : raised;

    *clamped = (uint32_t)(allowed < x) | (uint32_t)(allowed > x);
    return allowed;
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

/* (high, low) + delta: `low` keeps what the rounding of `high` loses, for states that move by less than their last bit.
 * t = low + delta; adding and taking off 1.09139364e-11f makes steps below 2^-61 zero, so that no word becomes denormal. */
EXTENDED_INLINE float extended_carried(float low, float delta)
{
    const float step = (delta + 1.09139364e-11f) - 1.09139364e-11f;

    return low + step;
}

/* The new `high`. */
EXTENDED_INLINE float extended_total(float high, float t)
{
    return extended_inside(high + t, 1048576.0f);
}

/* The new `low`, the rounding error of high + t. */
EXTENDED_INLINE float extended_lost(float high, float t)
{
    const float sum = high + t;

    return t - (sum - high);
}

/* ---- Path -------------------------------------------------------------------------------------------------------- */

EXTENDED_CODE
static float extended_delay_init(extended_delay_t *self, float u)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        self->ring[i] = u;
    }
    self->newest = 0u;
    self->wanted_V = u;
    return u;
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
    self->wanted_V = u;
    extended_delay_push(self, u);

    const float late = extended_delay_past(self, 1u);
    const float later = extended_delay_past(self, 2u);

    return late + extended_delay_part[0] * (later - late);
}

/* u(k) = v(k+n-1) + mu (v(k+n) - v(k+n-1)),  n the preview */
EXTENDED_INLINE float extended_delay_command(extended_delay_t *self, float v)
{
    const float u = self->wanted_V + extended_delay_part[0] * (v - self->wanted_V);

    self->wanted_V = v;
    extended_delay_push(self, u);
    return u;
}

/* What arrives one sample before v of the last command: nothing that comes later changes it. */
EXTENDED_INLINE float extended_delay_arrived(const extended_delay_t *self)
{
    const float late = extended_delay_past(self, 0u);
    const float later = extended_delay_past(self, 1u);

    return late + extended_delay_part[0] * (later - late);
}

/* x = (v - middle) / half range, limited to -1 .. 1 */
EXTENDED_INLINE float extended_hysteresis_normalised(float v)
{
    uint32_t beyond;
    const float x = (v - extended_hysteresis_range[0]) * extended_hysteresis_range[2];

    return extended_flushed(extended_limited(x, -1.0f, 1.0f, &beyond));
}

/* g0(x) */
EXTENDED_INLINE float extended_hysteresis_curve_um(float x)
{
    const float square = x * x;
    const float even = extended_hysteresis_curve[0] + square * (extended_hysteresis_curve[2] + square * (extended_hysteresis_curve[4] + square * extended_hysteresis_curve[6]));
    const float odd = extended_hysteresis_curve[1] + square * (extended_hysteresis_curve[3] + square * (extended_hysteresis_curve[5] + square * extended_hysteresis_curve[7]));

    return even + x * odd;
}

/* z <- max(x - r, min(x + r, z)) */
EXTENDED_INLINE float extended_hysteresis_moved(float z, float x, float r)
{
    const float low = x - r;
    const float high = x + r;
    const float pulled = (z > high) ? high : z;

    return (pulled < low) ? low : pulled;
}

/* g(z) = c_1 z + c_2 z^2 + ...;  play: row of the half-width and the coefficients c_1, c_2, ... */
EXTENDED_INLINE float extended_hysteresis_play_um(float z, const float play[4])
{
    return z * (play[1] + z * (play[2] + z * play[3]));
}

/* |x| */
EXTENDED_INLINE float extended_hysteresis_magnitude(float x)
{
    return extended_float(extended_bits(x) & 0x7fffffffu);
}

/* e = exp(-|way| / reach) of the first Duhem state, at most 1. Positive floats are in the order of their bits. */
EXTENDED_INLINE float extended_hysteresis_decay(float way)
{
    const uint32_t bits = extended_bits(extended_power_of_two(extended_hysteresis_magnitude(way) * extended_hysteresis_rate[0]));

    return extended_float((bits > 0x3f800000u) ? 0x3f800000u : bits);
}

/* b d + c d |d|, the part of a Duhem state in the output;  duhem: row b, c, 1/reach */
EXTENDED_INLINE float extended_hysteresis_duhem_um(float d, const float duhem[3])
{
    return d * (duhem[0] + duhem[1] * extended_hysteresis_magnitude(d));
}

/* The Duhem states of `next`, at the input x, from those of `self`; returns their part of the output. Measured in the
 * direction of the input,
 *     d_i = 1 - left_i e_i,   e_i = exp(-2^i |x - turn| / reach)
 * where left_i is 1 - d_i at the last turn. After a turn, the direction and with it d_i change sign: left_i = back_i. */
EXTENDED_INLINE float extended_hysteresis_followed_um(const extended_hysteresis_t *self, extended_hysteresis_t *next, float x)
{
    const uint32_t fell = (uint32_t)(self->last < self->turn);
    const float from_last = x - self->last;
    const float from_turn = x - self->turn;
    const uint32_t step = extended_bits(from_last);
    const uint32_t falls = (step >> 31) | (fell & (uint32_t)(step == 0u));
    const uint32_t turns = falls ^ fell;
    const float side = (falls != 0u) ? -1.0f : 1.0f;
    const float way = (turns != 0u) ? from_last : from_turn;
    const float left0 = (turns != 0u) ? self->back[0] : self->left[0];
    const float left1 = (turns != 0u) ? self->back[1] : self->left[1];
    const float left2 = (turns != 0u) ? self->back[2] : self->left[2];
    const float left3 = (turns != 0u) ? self->back[3] : self->left[3];
    const float left4 = (turns != 0u) ? self->back[4] : self->left[4];
    const float e0 = extended_hysteresis_decay(way);
    const float e1 = e0 * e0;
    const float e2 = e1 * e1;
    const float e3 = e2 * e2;
    const float e4 = e3 * e3;
    const float d0 = 1.0f - left0 * e0;
    const float d1 = 1.0f - left1 * e1;
    const float d2 = 1.0f - left2 * e2;
    const float d3 = 1.0f - left3 * e3;
    const float d4 = 1.0f - left4 * e4;

    next->turn = (turns != 0u) ? self->last : self->turn;
    next->left[0] = left0;
    next->back[0] = 1.0f + d0;
    next->left[1] = left1;
    next->back[1] = 1.0f + d1;
    next->left[2] = left2;
    next->back[2] = 1.0f + d2;
    next->left[3] = left3;
    next->back[3] = 1.0f + d3;
    next->left[4] = left4;
    next->back[4] = 1.0f + d4;
    return side * (extended_hysteresis_duhem_um(d0, &extended_hysteresis_duhem[0]) + extended_hysteresis_duhem_um(d1, &extended_hysteresis_duhem[3]) + extended_hysteresis_duhem_um(d2, &extended_hysteresis_duhem[6]) + extended_hysteresis_duhem_um(d3, &extended_hysteresis_duhem[9]) + extended_hysteresis_duhem_um(d4, &extended_hysteresis_duhem[12]));
}

EXTENDED_CODE
static float extended_hysteresis_apply(extended_hysteresis_t *self, float v)
{
    const float x = extended_hysteresis_normalised(v);
    float sum = 0.0f;

    const float z11 = extended_hysteresis_moved(self->play[11], x, extended_hysteresis_play[44]);
    self->play[11] = z11;
    const float z10 = extended_hysteresis_moved(self->play[10], x, extended_hysteresis_play[40]);
    self->play[10] = z10;
    const float z9 = extended_hysteresis_moved(self->play[9], x, extended_hysteresis_play[36]);
    self->play[9] = z9;
    const float z8 = extended_hysteresis_moved(self->play[8], x, extended_hysteresis_play[32]);
    self->play[8] = z8;
    const float z7 = extended_hysteresis_moved(self->play[7], x, extended_hysteresis_play[28]);
    self->play[7] = z7;
    const float z6 = extended_hysteresis_moved(self->play[6], x, extended_hysteresis_play[24]);
    self->play[6] = z6;
    sum = sum + extended_hysteresis_play_um(z11, &extended_hysteresis_play[44]);
    self->sum_um[11] = sum;
    sum = sum + extended_hysteresis_play_um(z10, &extended_hysteresis_play[40]);
    self->sum_um[10] = sum;
    sum = sum + extended_hysteresis_play_um(z9, &extended_hysteresis_play[36]);
    self->sum_um[9] = sum;
    sum = sum + extended_hysteresis_play_um(z8, &extended_hysteresis_play[32]);
    self->sum_um[8] = sum;
    sum = sum + extended_hysteresis_play_um(z7, &extended_hysteresis_play[28]);
    self->sum_um[7] = sum;
    sum = sum + extended_hysteresis_play_um(z6, &extended_hysteresis_play[24]);
    self->sum_um[6] = sum;
    const float z5 = extended_hysteresis_moved(self->play[5], x, extended_hysteresis_play[20]);
    self->play[5] = z5;
    const float z4 = extended_hysteresis_moved(self->play[4], x, extended_hysteresis_play[16]);
    self->play[4] = z4;
    const float z3 = extended_hysteresis_moved(self->play[3], x, extended_hysteresis_play[12]);
    self->play[3] = z3;
    const float z2 = extended_hysteresis_moved(self->play[2], x, extended_hysteresis_play[8]);
    self->play[2] = z2;
    const float z1 = extended_hysteresis_moved(self->play[1], x, extended_hysteresis_play[4]);
    self->play[1] = z1;
    const float z0 = extended_hysteresis_moved(self->play[0], x, extended_hysteresis_play[0]);
    self->play[0] = z0;
    sum = sum + extended_hysteresis_play_um(z5, &extended_hysteresis_play[20]);
    self->sum_um[5] = sum;
    sum = sum + extended_hysteresis_play_um(z4, &extended_hysteresis_play[16]);
    self->sum_um[4] = sum;
    sum = sum + extended_hysteresis_play_um(z3, &extended_hysteresis_play[12]);
    self->sum_um[3] = sum;
    sum = sum + extended_hysteresis_play_um(z2, &extended_hysteresis_play[8]);
    self->sum_um[2] = sum;
    sum = sum + extended_hysteresis_play_um(z1, &extended_hysteresis_play[4]);
    self->sum_um[1] = sum;
    sum = sum + extended_hysteresis_play_um(z0, &extended_hysteresis_play[0]);
    self->sum_um[0] = sum;
    const float memory = extended_hysteresis_followed_um(self, self, x);
    const float curve = extended_hysteresis_curve_um(x);
    const float h = (curve + sum) + memory;

    self->last = x;
    self->h_um = h;
    return h;
}

/* The same, with the state behind it in `next`. */
EXTENDED_CODE
static float extended_hysteresis_ahead(const extended_hysteresis_t *self, extended_hysteresis_t *next, float v)
{
    next->sum_um[12] = 0.0f;
    const float x = extended_hysteresis_normalised(v);
    float sum = 0.0f;

    const float z11 = extended_hysteresis_moved(self->play[11], x, extended_hysteresis_play[44]);
    next->play[11] = z11;
    const float z10 = extended_hysteresis_moved(self->play[10], x, extended_hysteresis_play[40]);
    next->play[10] = z10;
    const float z9 = extended_hysteresis_moved(self->play[9], x, extended_hysteresis_play[36]);
    next->play[9] = z9;
    const float z8 = extended_hysteresis_moved(self->play[8], x, extended_hysteresis_play[32]);
    next->play[8] = z8;
    const float z7 = extended_hysteresis_moved(self->play[7], x, extended_hysteresis_play[28]);
    next->play[7] = z7;
    const float z6 = extended_hysteresis_moved(self->play[6], x, extended_hysteresis_play[24]);
    next->play[6] = z6;
    sum = sum + extended_hysteresis_play_um(z11, &extended_hysteresis_play[44]);
    next->sum_um[11] = sum;
    sum = sum + extended_hysteresis_play_um(z10, &extended_hysteresis_play[40]);
    next->sum_um[10] = sum;
    sum = sum + extended_hysteresis_play_um(z9, &extended_hysteresis_play[36]);
    next->sum_um[9] = sum;
    sum = sum + extended_hysteresis_play_um(z8, &extended_hysteresis_play[32]);
    next->sum_um[8] = sum;
    sum = sum + extended_hysteresis_play_um(z7, &extended_hysteresis_play[28]);
    next->sum_um[7] = sum;
    sum = sum + extended_hysteresis_play_um(z6, &extended_hysteresis_play[24]);
    next->sum_um[6] = sum;
    const float z5 = extended_hysteresis_moved(self->play[5], x, extended_hysteresis_play[20]);
    next->play[5] = z5;
    const float z4 = extended_hysteresis_moved(self->play[4], x, extended_hysteresis_play[16]);
    next->play[4] = z4;
    const float z3 = extended_hysteresis_moved(self->play[3], x, extended_hysteresis_play[12]);
    next->play[3] = z3;
    const float z2 = extended_hysteresis_moved(self->play[2], x, extended_hysteresis_play[8]);
    next->play[2] = z2;
    const float z1 = extended_hysteresis_moved(self->play[1], x, extended_hysteresis_play[4]);
    next->play[1] = z1;
    const float z0 = extended_hysteresis_moved(self->play[0], x, extended_hysteresis_play[0]);
    next->play[0] = z0;
    sum = sum + extended_hysteresis_play_um(z5, &extended_hysteresis_play[20]);
    next->sum_um[5] = sum;
    sum = sum + extended_hysteresis_play_um(z4, &extended_hysteresis_play[16]);
    next->sum_um[4] = sum;
    sum = sum + extended_hysteresis_play_um(z3, &extended_hysteresis_play[12]);
    next->sum_um[3] = sum;
    sum = sum + extended_hysteresis_play_um(z2, &extended_hysteresis_play[8]);
    next->sum_um[2] = sum;
    sum = sum + extended_hysteresis_play_um(z1, &extended_hysteresis_play[4]);
    next->sum_um[1] = sum;
    sum = sum + extended_hysteresis_play_um(z0, &extended_hysteresis_play[0]);
    next->sum_um[0] = sum;
    const float memory = extended_hysteresis_followed_um(self, next, x);
    const float curve = extended_hysteresis_curve_um(x);
    const float h = (curve + sum) + memory;

    next->last = x;
    next->h_um = h;
    return h;
}

/* At rest under v; returns the output. */
EXTENDED_CODE
static float extended_hysteresis_init(extended_hysteresis_t *self, float v)
{
    const float x = extended_hysteresis_normalised(v);

    for (uint32_t j = 0u; j < 12u; ++j) {
        const float most = 1.0f - extended_hysteresis_play[4u * j];
        uint32_t beyond;

        self->play[j] = extended_limited(x, -most, most, &beyond);
    }
    self->sum_um[12] = 0.0f;
    for (uint32_t i = 0u; i < 5u; ++i) {
        self->left[i] = 1.0f;
        self->back[i] = 1.0f;
    }
    self->turn = x;
    self->last = x;
    return extended_hysteresis_apply(self, v);
}

/* 1/x of a slope, relative error at most 0.27 %: a Newton step converges with it by a factor of 370 or more. */
EXTENDED_INLINE float extended_hysteresis_rough_reciprocal(float x)
{
    const float r = extended_float(0x7ef311c7u - extended_bits(x));

    return r * (2.0f - x * r);
}

/** h [um] and dh/dx [um per half range]. */
typedef struct {
    float um;     /**< h, or a part of h [um] */
    float slope;  /**< its derivative by x [um per half range] */
} extended_hysteresis_ahead_t;

/* Number of plays that the input has taken along when it reaches `ahead`. `taken` rises with the half-width. */
EXTENDED_INLINE uint32_t extended_hysteresis_count(const float taken[12], float ahead)
{
    return (uint32_t)(ahead > taken[0]) + (uint32_t)(ahead > taken[1]) + (uint32_t)(ahead > taken[2]) + (uint32_t)(ahead > taken[3])
        + (uint32_t)(ahead > taken[4]) + (uint32_t)(ahead > taken[5]) + (uint32_t)(ahead > taken[6]) + (uint32_t)(ahead > taken[7])
        + (uint32_t)(ahead > taken[8]) + (uint32_t)(ahead > taken[9]) + (uint32_t)(ahead > taken[10]) + (uint32_t)(ahead > taken[11]);
}

/* c_0 + c_1 x + c_2 x^2 + ... and its derivative */
EXTENDED_INLINE extended_hysteresis_ahead_t extended_hysteresis_polynomial(const float c[8], float x)
{
    float um = c[7];
    float slope = um;

    um = c[6] + x * um;
    slope = um + x * slope;
    um = c[5] + x * um;
    slope = um + x * slope;
    um = c[4] + x * um;
    slope = um + x * slope;
    um = c[3] + x * um;
    slope = um + x * slope;
    um = c[2] + x * um;
    slope = um + x * slope;
    um = c[1] + x * um;
    slope = um + x * slope;
    um = c[0] + x * um;
    const extended_hysteresis_ahead_t found = { um, slope };

    return found;
}

/* b d + c d |d| and its derivative by x, d = 1 - left e */
EXTENDED_INLINE extended_hysteresis_ahead_t extended_hysteresis_duhem_ahead(float left, float e, const float duhem[3])
{
    const float ahead = left * e;
    const float d = 1.0f - ahead;
    const float bent = duhem[1] * extended_hysteresis_magnitude(d);
    const extended_hysteresis_ahead_t found = { d * (duhem[0] + bent), (duhem[0] + (bent + bent)) * (ahead * duhem[2]) };

    return found;
}

/* The voltage for which extended_hysteresis_apply would return `wanted`; the state does not change. 3 Newton steps
 *     x <- x - (f(x) - side wanted) / f'(x),   f(x) = side h(side x)
 * in the direction of `wanted`; the first x is that of the mean slope. */
EXTENDED_CODE
static float extended_hysteresis_solve(const extended_hysteresis_t *self, float wanted)
{
    const float way = (wanted - self->h_um) * extended_hysteresis_range[5];
    const uint32_t falls = (uint32_t)(way < 0.0f);
    const float side = (falls != 0u) ? -1.0f : 1.0f;
    const float start = side * self->last;
    const float aim = side * wanted;
    const float *row = &extended_hysteresis_curve[falls * 104u];
    float taken[12];
    const uint32_t turns = falls ^ (uint32_t)(self->last < self->turn);
    const float turn = side * ((turns != 0u) ? self->last : self->turn);
    const float left0 = (turns != 0u) ? self->back[0] : self->left[0];
    const float left1 = (turns != 0u) ? self->back[1] : self->left[1];
    const float left2 = (turns != 0u) ? self->back[2] : self->left[2];
    const float left3 = (turns != 0u) ? self->back[3] : self->left[3];
    const float left4 = (turns != 0u) ? self->back[4] : self->left[4];
    uint32_t beyond;
    float x = extended_flushed(extended_limited(start + side * way, start, 1.0f, &beyond));

    taken[0] = side * self->play[0] + (extended_hysteresis_play[0] - 2.38418579e-07f);
    taken[1] = side * self->play[1] + (extended_hysteresis_play[4] - 2.38418579e-07f);
    taken[2] = side * self->play[2] + (extended_hysteresis_play[8] - 2.38418579e-07f);
    taken[3] = side * self->play[3] + (extended_hysteresis_play[12] - 2.38418579e-07f);
    taken[4] = side * self->play[4] + (extended_hysteresis_play[16] - 2.38418579e-07f);
    taken[5] = side * self->play[5] + (extended_hysteresis_play[20] - 2.38418579e-07f);
    taken[6] = side * self->play[6] + (extended_hysteresis_play[24] - 2.38418579e-07f);
    taken[7] = side * self->play[7] + (extended_hysteresis_play[28] - 2.38418579e-07f);
    taken[8] = side * self->play[8] + (extended_hysteresis_play[32] - 2.38418579e-07f);
    taken[9] = side * self->play[9] + (extended_hysteresis_play[36] - 2.38418579e-07f);
    taken[10] = side * self->play[10] + (extended_hysteresis_play[40] - 2.38418579e-07f);
    taken[11] = side * self->play[11] + (extended_hysteresis_play[44] - 2.38418579e-07f);
    for (uint32_t step = 0u; step < 3u; ++step) {
        const float e0 = extended_power_of_two((x - turn) * extended_hysteresis_rate[0]);
        const float e1 = e0 * e0;
        const float e2 = e1 * e1;
        const float e3 = e2 * e2;
        const float e4 = e3 * e3;
        const extended_hysteresis_ahead_t d0 = extended_hysteresis_duhem_ahead(left0, e0, &extended_hysteresis_duhem[0]);
        const extended_hysteresis_ahead_t d1 = extended_hysteresis_duhem_ahead(left1, e1, &extended_hysteresis_duhem[3]);
        const extended_hysteresis_ahead_t d2 = extended_hysteresis_duhem_ahead(left2, e2, &extended_hysteresis_duhem[6]);
        const extended_hysteresis_ahead_t d3 = extended_hysteresis_duhem_ahead(left3, e3, &extended_hysteresis_duhem[9]);
        const extended_hysteresis_ahead_t d4 = extended_hysteresis_duhem_ahead(left4, e4, &extended_hysteresis_duhem[12]);
        const uint32_t n = extended_hysteresis_count(taken, x);
        const extended_hysteresis_ahead_t moved = extended_hysteresis_polynomial(&row[8u * n], x);
        float missed = moved.um + (side * self->sum_um[n] - aim);
        float slope = moved.slope;

        missed = missed + (d0.um + d1.um + d2.um + d3.um + d4.um);
        slope = slope + (d0.slope + d1.slope + d2.slope + d3.slope + d4.slope);
        slope = extended_limited(slope, extended_hysteresis_range[3], extended_hysteresis_range[4], &beyond);
        x = extended_limited(x - missed * extended_hysteresis_rough_reciprocal(slope), start, 1.0f, &beyond);
        x = extended_flushed(x);
    }
    return extended_hysteresis_range[0] + (side * x) * extended_hysteresis_range[1];
}

/* amount sum_i s_i */
EXTENDED_INLINE float extended_creep_slow(const extended_creep_t *self)
{
    float sum = self->high[0];

    sum = sum + self->high[1];
    sum = sum + self->high[2];
    sum = sum + self->high[3];
    return extended_creep_amount[0] * sum;
}

EXTENDED_CODE
static float extended_creep_init(extended_creep_t *self, float x)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        self->high[i] = x;
        self->low[i] = 0.0f;
    }
    return x + extended_creep_slow(self);
}

/* y = x + amount sum_i s_i,   s_i = s_i + a_i (x - s_i) */
EXTENDED_INLINE float extended_creep_apply(extended_creep_t *self, float x)
{
    const float y = x + extended_creep_slow(self);
    const float high0 = self->high[0];
    const float t0 = extended_carried(self->low[0], extended_creep_rate[0] * (x - high0));
    const float high1 = self->high[1];
    const float t1 = extended_carried(self->low[1], extended_creep_rate[1] * (x - high1));
    const float high2 = self->high[2];
    const float t2 = extended_carried(self->low[2], extended_creep_rate[2] * (x - high2));
    const float high3 = self->high[3];
    const float t3 = extended_carried(self->low[3], extended_creep_rate[3] * (x - high3));

    self->low[0] = extended_lost(high0, t0);
    self->high[0] = extended_total(high0, t0);
    self->low[1] = extended_lost(high1, t1);
    self->high[1] = extended_total(high1, t1);
    self->low[2] = extended_lost(high2, t2);
    self->high[2] = extended_total(high2, t2);
    self->low[3] = extended_lost(high3, t3);
    self->high[3] = extended_total(high3, t3);
    return y;
}

/* The same, with the state behind it in `next`. */
EXTENDED_INLINE float extended_creep_ahead(const extended_creep_t *self, extended_creep_t *next, float x)
{
    const float y = x + extended_creep_slow(self);
    const float high0 = self->high[0];
    const float t0 = extended_carried(self->low[0], extended_creep_rate[0] * (x - high0));
    const float high1 = self->high[1];
    const float t1 = extended_carried(self->low[1], extended_creep_rate[1] * (x - high1));
    const float high2 = self->high[2];
    const float t2 = extended_carried(self->low[2], extended_creep_rate[2] * (x - high2));
    const float high3 = self->high[3];
    const float t3 = extended_carried(self->low[3], extended_creep_rate[3] * (x - high3));

    next->low[0] = extended_lost(high0, t0);
    next->high[0] = extended_total(high0, t0);
    next->low[1] = extended_lost(high1, t1);
    next->high[1] = extended_total(high1, t1);
    next->low[2] = extended_lost(high2, t2);
    next->high[2] = extended_total(high2, t2);
    next->low[3] = extended_lost(high3, t3);
    next->high[3] = extended_total(high3, t3);
    return y;
}

/* x = y - amount sum_i s_i */
EXTENDED_INLINE float extended_creep_solve(const extended_creep_t *self, float wanted)
{
    return wanted - extended_creep_slow(self);
}


/* At rest under the command u; returns w at rest. */
EXTENDED_CODE
static float extended_inputs_init(extended_inputs_t *inputs, float u)
{
    float v = u;

    v = extended_delay_init(&inputs->delay, v);
    inputs->v_V = v;
    uint32_t outside;

    v = extended_flushed(extended_hysteresis_init(&inputs->hysteresis, v));
    v = extended_flushed(extended_creep_init(&inputs->creep, v));
    return extended_limited(v, EXTENDED_W_MIN, EXTENDED_W_MAX, &outside);
}

/* w of the voltage v that reaches the stage. */
EXTENDED_INLINE float extended_inputs_respond(extended_hysteresis_t *hysteresis, extended_creep_t *creep, float v)
{
    uint32_t outside;
    float w = v;

    w = extended_flushed(extended_hysteresis_apply(hysteresis, w));
    w = extended_flushed(extended_creep_apply(creep, w));
    return extended_limited(w, EXTENDED_W_MIN, EXTENDED_W_MAX, &outside);
}

/* w of the command u. */
EXTENDED_INLINE float extended_inputs_apply(extended_inputs_t *inputs, float u)
{
    float v = u;

    v = extended_delay_apply(&inputs->delay, v);
    inputs->v_V = v;
    return extended_inputs_respond(&inputs->hysteresis, &inputs->creep, v);
}

/** What the inverse of the path finds besides the command. */
typedef struct {
    float w;               /**< input of the rules that follows from the command */
    uint32_t u_clamped;    /**< 1: the voltage lay outside the span */
    uint32_t unreachable;  /**< 1: a limit keeps the stage from the wanted input */
    uint32_t residual;     /**< 1: the wanted input is missed although no limit acted */
} extended_found_t;

/* The command for which w is the input of the rules, 2 samples later;
 * the voltage that reaches the stage stays in the span. */
EXTENDED_CODE
static float extended_inputs_invert(extended_inputs_t *inputs, float w, extended_span_t span,
    extended_found_t *found)
{
    extended_hysteresis_t hysteresis;
    extended_creep_t creep;
    uint32_t beyond;
    const float wanted = extended_limited(w, EXTENDED_W_MIN, EXTENDED_W_MAX, &beyond);
    float solved = wanted;

    /* What arrives next depends on the command that follows: the responses are one sample behind, and a copy of them
     * goes ahead by the voltage that the call before asked for. */
float w_ahead = extended_flushed(extended_hysteresis_ahead(&inputs->hysteresis, &hysteresis, inputs->v_V));
(void)extended_creep_ahead(&inputs->creep, &creep, w_ahead);
    solved = extended_flushed(extended_creep_solve(&creep, solved));
    solved = extended_flushed(extended_hysteresis_solve(&hysteresis, solved));
    const float allowed = extended_allowed(solved, span, &found->u_clamped);
    float v = allowed;

    float u = v;

    u = extended_delay_command(&inputs->delay, u);
    inputs->v_V = v;
    found->w = extended_inputs_respond(&hysteresis, &creep, v);
    const float arrived = extended_delay_arrived(&inputs->delay);

    (void)extended_inputs_respond(&inputs->hysteresis, &inputs->creep, arrived);

    const float less = found->w - wanted;
    const float more = wanted - found->w;
    const uint32_t missed = (uint32_t)(less > EXTENDED_W_TOLERANCE) | (uint32_t)(more > EXTENDED_W_TOLERANCE);
    const uint32_t at_end = (uint32_t)(v <= span.low) | (uint32_t)(v >= span.high);
    const uint32_t held = beyond | found->u_clamped | (uint32_t)(extended_bits(v) != extended_bits(allowed));

    found->unreachable = held | (missed & at_end);
    found->residual = missed & ~(held | at_end) & 1u;
    return u;
}

/* ---- Prediction ------------------------------------------------------------------------------------------------ */

EXTENDED_CODE
void extended_init(extended_t *self, float y_um, float u_V)
{
    extended_events_t events;

    for (uint32_t b = 0u; b < 2u; ++b) {
        for (uint32_t l = 0u; l < EXTENDED_BANK_RULES; ++l) {
            self->bank[b].slope[l] = extended_slope[l];
            self->bank[b].offset[l] = extended_offset[l];
            self->bank[b].gain[l] = extended_gain[l];
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
    self->low_V = EXTENDED_U_MIN_V;
    self->high_V = EXTENDED_U_MAX_V;
    self->step_V = EXTENDED_U_STEP_MAX_V;
    (void)extended_inputs_init(&self->inputs, self->u_V);
}

/* The model's output under the input u that reaches the stage, Eq. (4), with base = y S + O; the input acts on the state. */
EXTENDED_INLINE float extended_apply(extended_t *self, float base, float gain, float per_weight, float u)
{
    const float rules = (base + u * gain) * per_weight;
    const float y_next = extended_flushed(rules);

    self->y_um = y_next;
    return y_next;
}

/* y(k+1) from measured y(k) and u(k). */
EXTENDED_CODE
float extended_predict(extended_t *self, float y_um, float u_V)
{
    const extended_bank_t *bank = &self->bank[self->active];
    extended_events_t events;
    const float y = extended_checked_y(self, y_um, &events);
    const float u = extended_checked_u(self, u_V, &events);
    const float w = extended_inputs_apply(&self->inputs, u);
    const extended_sums_t sums = extended_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = extended_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = extended_apply(self, base, sums.gain, per_weight, w);

    extended_count_events(self, &events);
    return y_next;
}

/* ---- Free run -------------------------------------------------------------------------------------------------- */

/* y(k+1) from the last output and u(k). */
EXTENDED_CODE
float extended_simulate(extended_t *self, float u_V)
{
    const extended_bank_t *bank = &self->bank[self->active];
    extended_events_t events = { 0u, 0u, 0u, 0u };
    const float y = extended_limited(self->y_um, EXTENDED_Y_MIN_UM, EXTENDED_Y_MAX_UM, &events.y_clamped);
    const float u = extended_checked_u(self, u_V, &events);
    const float w = extended_inputs_apply(&self->inputs, u);
    const extended_sums_t sums = extended_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = extended_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = extended_apply(self, base, sums.gain, per_weight, w);

    extended_count_events(self, &events);
    return y_next;
}

/* ---- Inverse --------------------------------------------------------------------------------------------------- */

EXTENDED_CODE
void extended_limits(extended_t *self, float low_V, float high_V, float step_V)
{
    uint32_t acted;
    const float low = extended_finite(low_V, EXTENDED_U_MIN_V, &acted);
    const float high = extended_finite(high_V, EXTENDED_U_MAX_V, &acted);
    const float step = extended_finite(step_V, EXTENDED_U_STEP_MAX_V, &acted);

    self->low_V = extended_limited(low, EXTENDED_U_MIN_V, EXTENDED_U_MAX_V, &acted);
    self->high_V = extended_limited(high, self->low_V, EXTENDED_U_MAX_V, &acted);
    self->step_V = extended_limited(step, 0.0f, EXTENDED_U_STEP_MAX_V, &acted);
}

/* u(k) that takes y(k) to y(k+1): (y(k+1) - sum theta phi) W = y S + O + u G, solved for u. */
EXTENDED_CODE
float extended_inverse(extended_t *self, float y_um, float y_next_um)
{
    const extended_bank_t *bank = &self->bank[self->active];
    extended_events_t events = { 0u, 0u, 0u, 0u };
    uint32_t rejected;
    uint32_t clamped;
    const float y = extended_checked_y(self, y_um, &events);
    const extended_sums_t sums = extended_rule_sums(bank, y);
    const extended_span_t span = extended_span(self, self->inputs.v_V);
    const float finite = extended_finite(y_next_um, y, &rejected);
    const float wanted = extended_limited(finite, EXTENDED_REFERENCE_MIN_UM, EXTENDED_REFERENCE_MAX_UM, &clamped);
    const float base = y * sums.slope + sums.offset;
    const float numerator = wanted * sums.weight - base;
    const float per_gain = extended_reciprocal(sums.gain);
    const float per_weight = extended_reciprocal(sums.weight);
    const float exact = extended_flushed(numerator * per_gain);
    extended_found_t found;
    const float u = extended_inputs_invert(&self->inputs, exact, span, &found);
    const uint32_t unreachable = found.unreachable;

    self->status |= (clamped * EXTENDED_STATUS_REFERENCE_CLAMPED) | (unreachable * EXTENDED_STATUS_UNREACHABLE);
    self->status |= found.residual * EXTENDED_STATUS_INVERSE_RESIDUAL;
    events.u_clamped = found.u_clamped;
    events.y_rejected |= rejected;
    extended_count_events(self, &events);
    self->u_V = u;
    (void)extended_apply(self, base, sums.gain, per_weight, found.w);
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

/* U = I. */
EXTENDED_CODE
static EXTENDED_STRAIGHT void extended_clear(extended_learner_t *self)
{
    self->u[0] = 0.0f;
    self->u[1] = 0.0f; self->u[2] = 0.0f;
    self->u[3] = 0.0f; self->u[4] = 0.0f; self->u[5] = 0.0f;
    self->u[6] = 0.0f; self->u[7] = 0.0f; self->u[8] = 0.0f; self->u[9] = 0.0f;
    self->u[10] = 0.0f; self->u[11] = 0.0f; self->u[12] = 0.0f; self->u[13] = 0.0f;
            self->u[14] = 0.0f;
    self->u[15] = 0.0f; self->u[16] = 0.0f; self->u[17] = 0.0f; self->u[18] = 0.0f;
            self->u[19] = 0.0f; self->u[20] = 0.0f;
    self->u[21] = 0.0f; self->u[22] = 0.0f; self->u[23] = 0.0f; self->u[24] = 0.0f;
            self->u[25] = 0.0f; self->u[26] = 0.0f;
    self->u[27] = 0.0f;
    self->u[28] = 0.0f; self->u[29] = 0.0f; self->u[30] = 0.0f; self->u[31] = 0.0f;
            self->u[32] = 0.0f; self->u[33] = 0.0f;
    self->u[34] = 0.0f; self->u[35] = 0.0f;
    self->u[36] = 0.0f; self->u[37] = 0.0f; self->u[38] = 0.0f; self->u[39] = 0.0f;
            self->u[40] = 0.0f; self->u[41] = 0.0f;
    self->u[42] = 0.0f; self->u[43] = 0.0f; self->u[44] = 0.0f;
    self->u[45] = 0.0f; self->u[46] = 0.0f; self->u[47] = 0.0f; self->u[48] = 0.0f;
            self->u[49] = 0.0f; self->u[50] = 0.0f;
    self->u[51] = 0.0f; self->u[52] = 0.0f; self->u[53] = 0.0f; self->u[54] = 0.0f;
    self->u[55] = 0.0f; self->u[56] = 0.0f; self->u[57] = 0.0f; self->u[58] = 0.0f;
            self->u[59] = 0.0f; self->u[60] = 0.0f;
    self->u[61] = 0.0f; self->u[62] = 0.0f; self->u[63] = 0.0f; self->u[64] = 0.0f;
            self->u[65] = 0.0f;
    self->u[66] = 0.0f; self->u[67] = 0.0f; self->u[68] = 0.0f; self->u[69] = 0.0f;
            self->u[70] = 0.0f; self->u[71] = 0.0f;
    self->u[72] = 0.0f; self->u[73] = 0.0f; self->u[74] = 0.0f; self->u[75] = 0.0f;
            self->u[76] = 0.0f; self->u[77] = 0.0f;
    self->u[78] = 0.0f; self->u[79] = 0.0f; self->u[80] = 0.0f; self->u[81] = 0.0f;
            self->u[82] = 0.0f; self->u[83] = 0.0f;
    self->u[84] = 0.0f; self->u[85] = 0.0f; self->u[86] = 0.0f; self->u[87] = 0.0f;
            self->u[88] = 0.0f; self->u[89] = 0.0f;
    self->u[90] = 0.0f;
    self->u[91] = 0.0f; self->u[92] = 0.0f; self->u[93] = 0.0f; self->u[94] = 0.0f;
            self->u[95] = 0.0f; self->u[96] = 0.0f;
    self->u[97] = 0.0f; self->u[98] = 0.0f; self->u[99] = 0.0f; self->u[100] = 0.0f;
            self->u[101] = 0.0f; self->u[102] = 0.0f;
    self->u[103] = 0.0f; self->u[104] = 0.0f;
    self->u[105] = 0.0f; self->u[106] = 0.0f; self->u[107] = 0.0f; self->u[108] = 0.0f;
            self->u[109] = 0.0f; self->u[110] = 0.0f;
    self->u[111] = 0.0f; self->u[112] = 0.0f; self->u[113] = 0.0f; self->u[114] = 0.0f;
            self->u[115] = 0.0f; self->u[116] = 0.0f;
    self->u[117] = 0.0f; self->u[118] = 0.0f; self->u[119] = 0.0f;
    self->u[120] = 0.0f; self->u[121] = 0.0f; self->u[122] = 0.0f; self->u[123] = 0.0f;
            self->u[124] = 0.0f; self->u[125] = 0.0f;
    self->u[126] = 0.0f; self->u[127] = 0.0f; self->u[128] = 0.0f; self->u[129] = 0.0f;
            self->u[130] = 0.0f; self->u[131] = 0.0f;
    self->u[132] = 0.0f; self->u[133] = 0.0f; self->u[134] = 0.0f; self->u[135] = 0.0f;
    self->u[136] = 0.0f; self->u[137] = 0.0f; self->u[138] = 0.0f; self->u[139] = 0.0f;
            self->u[140] = 0.0f; self->u[141] = 0.0f;
    self->u[142] = 0.0f; self->u[143] = 0.0f; self->u[144] = 0.0f; self->u[145] = 0.0f;
            self->u[146] = 0.0f; self->u[147] = 0.0f;
    self->u[148] = 0.0f; self->u[149] = 0.0f; self->u[150] = 0.0f; self->u[151] = 0.0f;
            self->u[152] = 0.0f;
}

/* Back to the reference parameters and the prior, P = alpha I. */
EXTENDED_CODE
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
    self->scale_um = EXTENDED_LEARN_LEVEL_UM;
    self->moving_um = EXTENDED_LEARN_LEVEL_UM;
    self->error = 0.0f;
    self->reference_error = 0.0f;
    self->step_error = 0.0f;
    extended_clear(self);
    self->run = 0u;
    self->age = 0u;
}

/* ---- Learner: the update, P = U D U' --------------------------------------------------------------------------- */

/* f = U' x and g = D f. Row i of U meets x_i; every f_j sums over i = 0, 1, ... and ends with x_j.
 * Independent chains stand side by side, in the order in which the C674x had better start them: while one row adds, the
 * next multiplies. */
EXTENDED_CODE
static EXTENDED_STRAIGHT void extended_project(extended_learner_t *self)
{
    const float grid = 1.09139364e-11f;
    const float inflate = self->inflate;
    const float *u = self->u;
    float f0, f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17;

    const float x0 = self->x[0]; /* row 0 */
    const float u0_1 = u[0], u0_2 = u[1], u0_3 = u[3], u0_4 = u[6], u0_5 = u[10], u0_6 = u[15], u0_7 = u[21],
            u0_8 = u[28], u0_9 = u[36], u0_10 = u[45], u0_11 = u[55], u0_12 = u[66];
    const float u0_13 = u[78], u0_14 = u[91], u0_15 = u[105], u0_16 = u[120], u0_17 = u[136];
    const float m0_1 = u0_1 * x0, m0_2 = u0_2 * x0, m0_3 = u0_3 * x0, m0_4 = u0_4 * x0, m0_5 = u0_5 * x0,
            m0_6 = u0_6 * x0, m0_7 = u0_7 * x0, m0_8 = u0_8 * x0, m0_9 = u0_9 * x0, m0_10 = u0_10 * x0,
            m0_11 = u0_11 * x0, m0_12 = u0_12 * x0;
    const float x1 = self->x[1]; /* row 1 */
    const float u1_2 = u[2], u1_3 = u[4], u1_4 = u[7], u1_5 = u[11], u1_6 = u[16], u1_7 = u[22],
            u1_8 = u[29], u1_9 = u[37], u1_10 = u[46], u1_11 = u[56], u1_12 = u[67], u1_13 = u[79];
    const float m0_13 = u0_13 * x0, m0_14 = u0_14 * x0, m0_15 = u0_15 * x0, m0_16 = u0_16 * x0,
            m0_17 = u0_17 * x0;
    const float u1_14 = u[92], u1_15 = u[106], u1_16 = u[121], u1_17 = u[137];
    f0 = x0;
    f1 = m0_1; f2 = m0_2; f3 = m0_3; f4 = m0_4; f5 = m0_5; f6 = m0_6; f7 = m0_7; f8 = m0_8;
            f9 = m0_9; f10 = m0_10; f11 = m0_11; f12 = m0_12;
    const float m1_2 = u1_2 * x1, m1_3 = u1_3 * x1, m1_4 = u1_4 * x1, m1_5 = u1_5 * x1, m1_6 = u1_6 * x1,
            m1_7 = u1_7 * x1, m1_8 = u1_8 * x1, m1_9 = u1_9 * x1, m1_10 = u1_10 * x1, m1_11 = u1_11 * x1,
            m1_12 = u1_12 * x1, m1_13 = u1_13 * x1;
    const float x2 = self->x[2]; /* row 2 */
    const float u2_3 = u[5], u2_4 = u[8], u2_5 = u[12], u2_6 = u[17], u2_7 = u[23], u2_8 = u[30],
            u2_9 = u[38], u2_10 = u[47], u2_11 = u[57], u2_12 = u[68], u2_13 = u[80], u2_14 = u[93];
    f13 = m0_13; f14 = m0_14; f15 = m0_15; f16 = m0_16; f17 = m0_17;
    const float m1_14 = u1_14 * x1, m1_15 = u1_15 * x1, m1_16 = u1_16 * x1, m1_17 = u1_17 * x1;
    const float u2_15 = u[107], u2_16 = u[122], u2_17 = u[138];
    f1 = f1 + x1;
    f2 = f2 + m1_2; f3 = f3 + m1_3; f4 = f4 + m1_4; f5 = f5 + m1_5; f6 = f6 + m1_6;
            f7 = f7 + m1_7; f8 = f8 + m1_8; f9 = f9 + m1_9; f10 = f10 + m1_10; f11 = f11 + m1_11;
            f12 = f12 + m1_12; f13 = f13 + m1_13;
    const float m2_3 = u2_3 * x2, m2_4 = u2_4 * x2, m2_5 = u2_5 * x2, m2_6 = u2_6 * x2, m2_7 = u2_7 * x2,
            m2_8 = u2_8 * x2, m2_9 = u2_9 * x2, m2_10 = u2_10 * x2, m2_11 = u2_11 * x2,
            m2_12 = u2_12 * x2, m2_13 = u2_13 * x2, m2_14 = u2_14 * x2;
    const float x3 = self->x[3]; /* row 3 */
    const float u3_4 = u[9], u3_5 = u[13], u3_6 = u[18], u3_7 = u[24], u3_8 = u[31], u3_9 = u[39],
            u3_10 = u[48], u3_11 = u[58], u3_12 = u[69], u3_13 = u[81], u3_14 = u[94], u3_15 = u[108];
    f14 = f14 + m1_14; f15 = f15 + m1_15; f16 = f16 + m1_16; f17 = f17 + m1_17;
    const float m2_15 = u2_15 * x2, m2_16 = u2_16 * x2, m2_17 = u2_17 * x2;
    const float u3_16 = u[123], u3_17 = u[139];
    f2 = f2 + x2;
    f3 = f3 + m2_3; f4 = f4 + m2_4; f5 = f5 + m2_5; f6 = f6 + m2_6; f7 = f7 + m2_7;
            f8 = f8 + m2_8; f9 = f9 + m2_9; f10 = f10 + m2_10; f11 = f11 + m2_11; f12 = f12 + m2_12;
            f13 = f13 + m2_13; f14 = f14 + m2_14;
    const float m3_4 = u3_4 * x3, m3_5 = u3_5 * x3, m3_6 = u3_6 * x3, m3_7 = u3_7 * x3, m3_8 = u3_8 * x3,
            m3_9 = u3_9 * x3, m3_10 = u3_10 * x3, m3_11 = u3_11 * x3, m3_12 = u3_12 * x3,
            m3_13 = u3_13 * x3, m3_14 = u3_14 * x3, m3_15 = u3_15 * x3;
    const float x4 = self->x[4]; /* row 4 */
    const float u4_5 = u[14], u4_6 = u[19], u4_7 = u[25], u4_8 = u[32], u4_9 = u[40], u4_10 = u[49],
            u4_11 = u[59], u4_12 = u[70], u4_13 = u[82], u4_14 = u[95], u4_15 = u[109], u4_16 = u[124];
    f15 = f15 + m2_15; f16 = f16 + m2_16; f17 = f17 + m2_17;
    const float m3_16 = u3_16 * x3, m3_17 = u3_17 * x3;
    const float u4_17 = u[140];
    f3 = f3 + x3;
    f4 = f4 + m3_4; f5 = f5 + m3_5; f6 = f6 + m3_6; f7 = f7 + m3_7; f8 = f8 + m3_8;
            f9 = f9 + m3_9; f10 = f10 + m3_10; f11 = f11 + m3_11; f12 = f12 + m3_12; f13 = f13 + m3_13;
            f14 = f14 + m3_14; f15 = f15 + m3_15;
    const float m4_5 = u4_5 * x4, m4_6 = u4_6 * x4, m4_7 = u4_7 * x4, m4_8 = u4_8 * x4, m4_9 = u4_9 * x4,
            m4_10 = u4_10 * x4, m4_11 = u4_11 * x4, m4_12 = u4_12 * x4, m4_13 = u4_13 * x4,
            m4_14 = u4_14 * x4, m4_15 = u4_15 * x4, m4_16 = u4_16 * x4;
    const float x5 = self->x[5]; /* row 5 */
    const float u5_6 = u[20], u5_7 = u[26], u5_8 = u[33], u5_9 = u[41], u5_10 = u[50], u5_11 = u[60],
            u5_12 = u[71], u5_13 = u[83], u5_14 = u[96], u5_15 = u[110], u5_16 = u[125], u5_17 = u[141];
    f16 = f16 + m3_16; f17 = f17 + m3_17;
    const float m4_17 = u4_17 * x4;
    const float x6 = self->x[6]; /* row 6 */
    const float u6_7 = u[27], u6_8 = u[34], u6_9 = u[42], u6_10 = u[51], u6_11 = u[61], u6_12 = u[72],
            u6_13 = u[84], u6_14 = u[97], u6_15 = u[111], u6_16 = u[126], u6_17 = u[142];
    f4 = f4 + x4;
    f5 = f5 + m4_5; f6 = f6 + m4_6; f7 = f7 + m4_7; f8 = f8 + m4_8; f9 = f9 + m4_9;
            f10 = f10 + m4_10; f11 = f11 + m4_11; f12 = f12 + m4_12; f13 = f13 + m4_13;
            f14 = f14 + m4_14; f15 = f15 + m4_15; f16 = f16 + m4_16;
    const float m5_6 = u5_6 * x5, m5_7 = u5_7 * x5, m5_8 = u5_8 * x5, m5_9 = u5_9 * x5, m5_10 = u5_10 * x5,
            m5_11 = u5_11 * x5, m5_12 = u5_12 * x5, m5_13 = u5_13 * x5, m5_14 = u5_14 * x5,
            m5_15 = u5_15 * x5, m5_16 = u5_16 * x5, m5_17 = u5_17 * x5;
    const float x7 = self->x[7]; /* row 7 */
    const float u7_8 = u[35], u7_9 = u[43], u7_10 = u[52], u7_11 = u[62], u7_12 = u[73], u7_13 = u[85],
            u7_14 = u[98], u7_15 = u[112], u7_16 = u[127], u7_17 = u[143];
    f17 = f17 + m4_17;
    const float m6_7 = u6_7 * x6, m6_8 = u6_8 * x6, m6_9 = u6_9 * x6, m6_10 = u6_10 * x6, m6_11 = u6_11 * x6,
            m6_12 = u6_12 * x6, m6_13 = u6_13 * x6, m6_14 = u6_14 * x6, m6_15 = u6_15 * x6,
            m6_16 = u6_16 * x6, m6_17 = u6_17 * x6;
    const float x8 = self->x[8]; /* row 8 */
    const float u8_9 = u[44], u8_10 = u[53], u8_11 = u[63], u8_12 = u[74], u8_13 = u[86], u8_14 = u[99],
            u8_15 = u[113], u8_16 = u[128], u8_17 = u[144];
    f5 = f5 + x5;
    f6 = f6 + m5_6; f7 = f7 + m5_7; f8 = f8 + m5_8; f9 = f9 + m5_9; f10 = f10 + m5_10;
            f11 = f11 + m5_11; f12 = f12 + m5_12; f13 = f13 + m5_13; f14 = f14 + m5_14;
            f15 = f15 + m5_15; f16 = f16 + m5_16; f17 = f17 + m5_17;
    const float m7_8 = u7_8 * x7, m7_9 = u7_9 * x7, m7_10 = u7_10 * x7, m7_11 = u7_11 * x7,
            m7_12 = u7_12 * x7, m7_13 = u7_13 * x7, m7_14 = u7_14 * x7, m7_15 = u7_15 * x7,
            m7_16 = u7_16 * x7, m7_17 = u7_17 * x7;
    const float x9 = self->x[9]; /* row 9 */
    const float u9_10 = u[54], u9_11 = u[64], u9_12 = u[75], u9_13 = u[87], u9_14 = u[100], u9_15 = u[114],
            u9_16 = u[129], u9_17 = u[145];
    f6 = f6 + x6;
    f7 = f7 + m6_7; f8 = f8 + m6_8; f9 = f9 + m6_9; f10 = f10 + m6_10; f11 = f11 + m6_11;
            f12 = f12 + m6_12; f13 = f13 + m6_13; f14 = f14 + m6_14; f15 = f15 + m6_15;
            f16 = f16 + m6_16; f17 = f17 + m6_17;
    const float m8_9 = u8_9 * x8, m8_10 = u8_10 * x8, m8_11 = u8_11 * x8, m8_12 = u8_12 * x8,
            m8_13 = u8_13 * x8, m8_14 = u8_14 * x8, m8_15 = u8_15 * x8, m8_16 = u8_16 * x8,
            m8_17 = u8_17 * x8;
    const float x10 = self->x[10]; /* row 10 */
    const float u10_11 = u[65], u10_12 = u[76], u10_13 = u[88], u10_14 = u[101], u10_15 = u[115],
            u10_16 = u[130], u10_17 = u[146];
    f7 = f7 + x7;
    f8 = f8 + m7_8; f9 = f9 + m7_9; f10 = f10 + m7_10; f11 = f11 + m7_11; f12 = f12 + m7_12;
            f13 = f13 + m7_13; f14 = f14 + m7_14; f15 = f15 + m7_15; f16 = f16 + m7_16;
            f17 = f17 + m7_17;
    const float m9_10 = u9_10 * x9, m9_11 = u9_11 * x9, m9_12 = u9_12 * x9, m9_13 = u9_13 * x9,
            m9_14 = u9_14 * x9, m9_15 = u9_15 * x9, m9_16 = u9_16 * x9, m9_17 = u9_17 * x9;
    const float x11 = self->x[11]; /* row 11 */
    const float u11_12 = u[77], u11_13 = u[89], u11_14 = u[102], u11_15 = u[116], u11_16 = u[131],
            u11_17 = u[147];
    f8 = f8 + x8;
    f9 = f9 + m8_9; f10 = f10 + m8_10; f11 = f11 + m8_11; f12 = f12 + m8_12; f13 = f13 + m8_13;
            f14 = f14 + m8_14; f15 = f15 + m8_15; f16 = f16 + m8_16; f17 = f17 + m8_17;
    const float m10_11 = u10_11 * x10, m10_12 = u10_12 * x10, m10_13 = u10_13 * x10, m10_14 = u10_14 * x10,
            m10_15 = u10_15 * x10, m10_16 = u10_16 * x10, m10_17 = u10_17 * x10;
    const float x12 = self->x[12]; /* row 12 */
    const float u12_13 = u[90], u12_14 = u[103], u12_15 = u[117], u12_16 = u[132], u12_17 = u[148];
    f9 = f9 + x9;
    f10 = f10 + m9_10; f11 = f11 + m9_11; f12 = f12 + m9_12; f13 = f13 + m9_13;
            f14 = f14 + m9_14; f15 = f15 + m9_15; f16 = f16 + m9_16; f17 = f17 + m9_17;
    const float m11_12 = u11_12 * x11, m11_13 = u11_13 * x11, m11_14 = u11_14 * x11, m11_15 = u11_15 * x11,
            m11_16 = u11_16 * x11, m11_17 = u11_17 * x11;
    const float x13 = self->x[13]; /* row 13 */
    const float u13_14 = u[104], u13_15 = u[118], u13_16 = u[133], u13_17 = u[149];
    f10 = f10 + x10;
    f11 = f11 + m10_11; f12 = f12 + m10_12; f13 = f13 + m10_13; f14 = f14 + m10_14;
            f15 = f15 + m10_15; f16 = f16 + m10_16; f17 = f17 + m10_17;
    const float m12_13 = u12_13 * x12, m12_14 = u12_14 * x12, m12_15 = u12_15 * x12, m12_16 = u12_16 * x12,
            m12_17 = u12_17 * x12;
    const float x14 = self->x[14]; /* row 14 */
    const float u14_15 = u[119], u14_16 = u[134], u14_17 = u[150];
    f11 = f11 + x11;
    f12 = f12 + m11_12; f13 = f13 + m11_13; f14 = f14 + m11_14; f15 = f15 + m11_15;
            f16 = f16 + m11_16; f17 = f17 + m11_17;
    const float m13_14 = u13_14 * x13, m13_15 = u13_15 * x13, m13_16 = u13_16 * x13, m13_17 = u13_17 * x13;
    const float x15 = self->x[15]; /* row 15 */
    const float u15_16 = u[135], u15_17 = u[151];
    f12 = f12 + x12;
    f13 = f13 + m12_13; f14 = f14 + m12_14; f15 = f15 + m12_15; f16 = f16 + m12_16;
            f17 = f17 + m12_17;
    const float m14_15 = u14_15 * x14, m14_16 = u14_16 * x14, m14_17 = u14_17 * x14;
    const float x16 = self->x[16]; /* row 16 */
    const float u16_17 = u[152];
    f13 = f13 + x13;
    f14 = f14 + m13_14; f15 = f15 + m13_15; f16 = f16 + m13_16; f17 = f17 + m13_17;
    const float m15_16 = u15_16 * x15, m15_17 = u15_17 * x15;
    f14 = f14 + x14;
    f15 = f15 + m14_15; f16 = f16 + m14_16; f17 = f17 + m14_17;
    const float m16_17 = u16_17 * x16;
    f15 = f15 + x15;
    f16 = f16 + m15_16; f17 = f17 + m15_17;
    f16 = f16 + x16;
    f17 = f17 + m16_17;
    f17 = f17 + self->x[17];

    self->f[0] = f0; self->f[1] = f1; self->f[2] = f2; self->f[3] = f3; self->f[4] = f4;
            self->f[5] = f5;
    self->f[6] = f6; self->f[7] = f7; self->f[8] = f8; self->f[9] = f9; self->f[10] = f10;
            self->f[11] = f11;
    self->f[12] = f12; self->f[13] = f13; self->f[14] = f14; self->f[15] = f15;
            self->f[16] = f16; self->f[17] = f17;
    const float d0 = self->d[0] * inflate, d1 = self->d[1] * inflate, d2 = self->d[2] * inflate,
            d3 = self->d[3] * inflate, d4 = self->d[4] * inflate, d5 = self->d[5] * inflate;
    const float d6 = self->d[6] * inflate, d7 = self->d[7] * inflate, d8 = self->d[8] * inflate,
            d9 = self->d[9] * inflate, d10 = self->d[10] * inflate, d11 = self->d[11] * inflate;
    const float d12 = self->d[12] * inflate, d13 = self->d[13] * inflate, d14 = self->d[14] * inflate,
            d15 = self->d[15] * inflate, d16 = self->d[16] * inflate, d17 = self->d[17] * inflate;
    const float g0 = d0 * f0, g1 = d1 * f1, g2 = d2 * f2, g3 = d3 * f3, g4 = d4 * f4, g5 = d5 * f5;
    const float g6 = d6 * f6, g7 = d7 * f7, g8 = d8 * f8, g9 = d9 * f9, g10 = d10 * f10, g11 = d11 * f11;
    const float g12 = d12 * f12, g13 = d13 * f13, g14 = d14 * f14, g15 = d15 * f15, g16 = d16 * f16,
            g17 = d17 * f17;
    const float h0 = g0 + grid, h1 = g1 + grid, h2 = g2 + grid, h3 = g3 + grid, h4 = g4 + grid,
            h5 = g5 + grid;
    const float h6 = g6 + grid, h7 = g7 + grid, h8 = g8 + grid, h9 = g9 + grid, h10 = g10 + grid,
            h11 = g11 + grid;
    const float h12 = g12 + grid, h13 = g13 + grid, h14 = g14 + grid, h15 = g15 + grid, h16 = g16 + grid,
            h17 = g17 + grid;
    self->g[0] = h0 - grid; self->g[1] = h1 - grid; self->g[2] = h2 - grid;
            self->g[3] = h3 - grid; self->g[4] = h4 - grid; self->g[5] = h5 - grid;
    self->g[6] = h6 - grid; self->g[7] = h7 - grid; self->g[8] = h8 - grid;
            self->g[9] = h9 - grid; self->g[10] = h10 - grid; self->g[11] = h11 - grid;
    self->g[12] = h12 - grid; self->g[13] = h13 - grid; self->g[14] = h14 - grid;
            self->g[15] = h15 - grid; self->g[16] = h16 - grid; self->g[17] = h17 - grid;
}

/* U and P x. In column j, with k_i the sum so far: U_ij <- U_ij + k_i l_j, k_i <- k_i + U_ij g_j, i < j.
 * Adding and taking off `grid` leaves multiples of 2^-30: nothing that is kept can become denormal. */
EXTENDED_CODE
static EXTENDED_STRAIGHT void extended_factor(extended_learner_t *self)
{
    const float grid = 0.01171875f;
    float *u = self->u;
    float k0 = self->g[0];

    const float l1 = self->l[1]; /* column 1 */
    float k1 = self->g[1];
    const float u0_1 = u[0];
    const float p0_1 = k0 * l1;
    const float q0_1 = u0_1 * k1;
    const float l2 = self->l[2]; /* column 2 */
    float k2 = self->g[2];
    const float u0_2 = u[1], u1_2 = u[2];
    const float r0_1 = u0_1 + p0_1;
    k0 = k0 + q0_1;
    const float p0_2 = k0 * l2, p1_2 = k1 * l2;
    const float q0_2 = u0_2 * k2, q1_2 = u1_2 * k2;
    const float l3 = self->l[3]; /* column 3 */
    float k3 = self->g[3];
    const float u0_3 = u[3], u1_3 = u[4], u2_3 = u[5];
    const float s0_1 = r0_1 + grid;
    const float r0_2 = u0_2 + p0_2, r1_2 = u1_2 + p1_2;
    k0 = k0 + q0_2; k1 = k1 + q1_2;
    const float p0_3 = k0 * l3, p1_3 = k1 * l3, p2_3 = k2 * l3;
    const float q0_3 = u0_3 * k3, q1_3 = u1_3 * k3, q2_3 = u2_3 * k3;
    const float l4 = self->l[4]; /* column 4 */
    float k4 = self->g[4];
    const float u0_4 = u[6], u1_4 = u[7], u2_4 = u[8];
    const float t0_1 = s0_1 - grid;
    const float s0_2 = r0_2 + grid, s1_2 = r1_2 + grid;
    const float r0_3 = u0_3 + p0_3, r1_3 = u1_3 + p1_3, r2_3 = u2_3 + p2_3;
    k0 = k0 + q0_3; k1 = k1 + q1_3; k2 = k2 + q2_3;
    const float p0_4 = k0 * l4, p1_4 = k1 * l4, p2_4 = k2 * l4;
    const float q0_4 = u0_4 * k4, q1_4 = u1_4 * k4, q2_4 = u2_4 * k4;
    const float u3_4 = u[9];
    u[0] = t0_1;
    const float t0_2 = s0_2 - grid, t1_2 = s1_2 - grid;
    const float s0_3 = r0_3 + grid, s1_3 = r1_3 + grid, s2_3 = r2_3 + grid;
    const float r0_4 = u0_4 + p0_4, r1_4 = u1_4 + p1_4, r2_4 = u2_4 + p2_4;
    k0 = k0 + q0_4; k1 = k1 + q1_4; k2 = k2 + q2_4;
    const float p3_4 = k3 * l4;
    const float q3_4 = u3_4 * k4;
    const float l5 = self->l[5]; /* column 5 */
    float k5 = self->g[5];
    const float u0_5 = u[10], u1_5 = u[11], u2_5 = u[12];
    u[1] = t0_2; u[2] = t1_2;
    const float t0_3 = s0_3 - grid, t1_3 = s1_3 - grid, t2_3 = s2_3 - grid;
    const float s0_4 = r0_4 + grid, s1_4 = r1_4 + grid, s2_4 = r2_4 + grid;
    const float r3_4 = u3_4 + p3_4;
    k3 = k3 + q3_4;
    const float p0_5 = k0 * l5, p1_5 = k1 * l5, p2_5 = k2 * l5;
    const float q0_5 = u0_5 * k5, q1_5 = u1_5 * k5, q2_5 = u2_5 * k5;
    const float u3_5 = u[13], u4_5 = u[14];
    u[3] = t0_3; u[4] = t1_3; u[5] = t2_3;
    const float t0_4 = s0_4 - grid, t1_4 = s1_4 - grid, t2_4 = s2_4 - grid;
    const float s3_4 = r3_4 + grid;
    const float r0_5 = u0_5 + p0_5, r1_5 = u1_5 + p1_5, r2_5 = u2_5 + p2_5;
    k0 = k0 + q0_5; k1 = k1 + q1_5; k2 = k2 + q2_5;
    const float p3_5 = k3 * l5, p4_5 = k4 * l5;
    const float q3_5 = u3_5 * k5, q4_5 = u4_5 * k5;
    const float l6 = self->l[6]; /* column 6 */
    float k6 = self->g[6];
    const float u0_6 = u[15], u1_6 = u[16], u2_6 = u[17];
    u[6] = t0_4; u[7] = t1_4; u[8] = t2_4;
    const float t3_4 = s3_4 - grid;
    const float s0_5 = r0_5 + grid, s1_5 = r1_5 + grid, s2_5 = r2_5 + grid;
    const float r3_5 = u3_5 + p3_5, r4_5 = u4_5 + p4_5;
    k3 = k3 + q3_5; k4 = k4 + q4_5;
    const float p0_6 = k0 * l6, p1_6 = k1 * l6, p2_6 = k2 * l6;
    const float q0_6 = u0_6 * k6, q1_6 = u1_6 * k6, q2_6 = u2_6 * k6;
    const float u3_6 = u[18], u4_6 = u[19], u5_6 = u[20];
    u[9] = t3_4;
    const float t0_5 = s0_5 - grid, t1_5 = s1_5 - grid, t2_5 = s2_5 - grid;
    const float s3_5 = r3_5 + grid, s4_5 = r4_5 + grid;
    const float r0_6 = u0_6 + p0_6, r1_6 = u1_6 + p1_6, r2_6 = u2_6 + p2_6;
    k0 = k0 + q0_6; k1 = k1 + q1_6; k2 = k2 + q2_6;
    const float p3_6 = k3 * l6, p4_6 = k4 * l6, p5_6 = k5 * l6;
    const float q3_6 = u3_6 * k6, q4_6 = u4_6 * k6, q5_6 = u5_6 * k6;
    const float l7 = self->l[7]; /* column 7 */
    float k7 = self->g[7];
    const float u0_7 = u[21], u1_7 = u[22], u2_7 = u[23];
    u[10] = t0_5; u[11] = t1_5; u[12] = t2_5;
    const float t3_5 = s3_5 - grid, t4_5 = s4_5 - grid;
    const float s0_6 = r0_6 + grid, s1_6 = r1_6 + grid, s2_6 = r2_6 + grid;
    const float r3_6 = u3_6 + p3_6, r4_6 = u4_6 + p4_6, r5_6 = u5_6 + p5_6;
    k3 = k3 + q3_6; k4 = k4 + q4_6; k5 = k5 + q5_6;
    const float p0_7 = k0 * l7, p1_7 = k1 * l7, p2_7 = k2 * l7;
    const float q0_7 = u0_7 * k7, q1_7 = u1_7 * k7, q2_7 = u2_7 * k7;
    const float u3_7 = u[24], u4_7 = u[25], u5_7 = u[26];
    u[13] = t3_5; u[14] = t4_5;
    const float t0_6 = s0_6 - grid, t1_6 = s1_6 - grid, t2_6 = s2_6 - grid;
    const float s3_6 = r3_6 + grid, s4_6 = r4_6 + grid, s5_6 = r5_6 + grid;
    const float r0_7 = u0_7 + p0_7, r1_7 = u1_7 + p1_7, r2_7 = u2_7 + p2_7;
    k0 = k0 + q0_7; k1 = k1 + q1_7; k2 = k2 + q2_7;
    const float p3_7 = k3 * l7, p4_7 = k4 * l7, p5_7 = k5 * l7;
    const float q3_7 = u3_7 * k7, q4_7 = u4_7 * k7, q5_7 = u5_7 * k7;
    const float u6_7 = u[27];
    u[15] = t0_6; u[16] = t1_6; u[17] = t2_6;
    const float t3_6 = s3_6 - grid, t4_6 = s4_6 - grid, t5_6 = s5_6 - grid;
    const float s0_7 = r0_7 + grid, s1_7 = r1_7 + grid, s2_7 = r2_7 + grid;
    const float r3_7 = u3_7 + p3_7, r4_7 = u4_7 + p4_7, r5_7 = u5_7 + p5_7;
    k3 = k3 + q3_7; k4 = k4 + q4_7; k5 = k5 + q5_7;
    const float p6_7 = k6 * l7;
    const float q6_7 = u6_7 * k7;
    const float l8 = self->l[8]; /* column 8 */
    float k8 = self->g[8];
    const float u0_8 = u[28], u1_8 = u[29], u2_8 = u[30];
    u[18] = t3_6; u[19] = t4_6; u[20] = t5_6;
    const float t0_7 = s0_7 - grid, t1_7 = s1_7 - grid, t2_7 = s2_7 - grid;
    const float s3_7 = r3_7 + grid, s4_7 = r4_7 + grid, s5_7 = r5_7 + grid;
    const float r6_7 = u6_7 + p6_7;
    k6 = k6 + q6_7;
    const float p0_8 = k0 * l8, p1_8 = k1 * l8, p2_8 = k2 * l8;
    const float q0_8 = u0_8 * k8, q1_8 = u1_8 * k8, q2_8 = u2_8 * k8;
    const float u3_8 = u[31], u4_8 = u[32], u5_8 = u[33];
    u[21] = t0_7; u[22] = t1_7; u[23] = t2_7;
    const float t3_7 = s3_7 - grid, t4_7 = s4_7 - grid, t5_7 = s5_7 - grid;
    const float s6_7 = r6_7 + grid;
    const float r0_8 = u0_8 + p0_8, r1_8 = u1_8 + p1_8, r2_8 = u2_8 + p2_8;
    k0 = k0 + q0_8; k1 = k1 + q1_8; k2 = k2 + q2_8;
    const float p3_8 = k3 * l8, p4_8 = k4 * l8, p5_8 = k5 * l8;
    const float q3_8 = u3_8 * k8, q4_8 = u4_8 * k8, q5_8 = u5_8 * k8;
    const float u6_8 = u[34], u7_8 = u[35];
    u[24] = t3_7; u[25] = t4_7; u[26] = t5_7;
    const float t6_7 = s6_7 - grid;
    const float s0_8 = r0_8 + grid, s1_8 = r1_8 + grid, s2_8 = r2_8 + grid;
    const float r3_8 = u3_8 + p3_8, r4_8 = u4_8 + p4_8, r5_8 = u5_8 + p5_8;
    k3 = k3 + q3_8; k4 = k4 + q4_8; k5 = k5 + q5_8;
    const float p6_8 = k6 * l8, p7_8 = k7 * l8;
    const float q6_8 = u6_8 * k8, q7_8 = u7_8 * k8;
    const float l9 = self->l[9]; /* column 9 */
    float k9 = self->g[9];
    const float u0_9 = u[36], u1_9 = u[37], u2_9 = u[38];
    u[27] = t6_7;
    const float t0_8 = s0_8 - grid, t1_8 = s1_8 - grid, t2_8 = s2_8 - grid;
    const float s3_8 = r3_8 + grid, s4_8 = r4_8 + grid, s5_8 = r5_8 + grid;
    const float r6_8 = u6_8 + p6_8, r7_8 = u7_8 + p7_8;
    k6 = k6 + q6_8; k7 = k7 + q7_8;
    const float p0_9 = k0 * l9, p1_9 = k1 * l9, p2_9 = k2 * l9;
    const float q0_9 = u0_9 * k9, q1_9 = u1_9 * k9, q2_9 = u2_9 * k9;
    const float u3_9 = u[39], u4_9 = u[40], u5_9 = u[41];
    u[28] = t0_8; u[29] = t1_8; u[30] = t2_8;
    const float t3_8 = s3_8 - grid, t4_8 = s4_8 - grid, t5_8 = s5_8 - grid;
    const float s6_8 = r6_8 + grid, s7_8 = r7_8 + grid;
    const float r0_9 = u0_9 + p0_9, r1_9 = u1_9 + p1_9, r2_9 = u2_9 + p2_9;
    k0 = k0 + q0_9; k1 = k1 + q1_9; k2 = k2 + q2_9;
    const float p3_9 = k3 * l9, p4_9 = k4 * l9, p5_9 = k5 * l9;
    const float q3_9 = u3_9 * k9, q4_9 = u4_9 * k9, q5_9 = u5_9 * k9;
    const float u6_9 = u[42], u7_9 = u[43], u8_9 = u[44];
    u[31] = t3_8; u[32] = t4_8; u[33] = t5_8;
    const float t6_8 = s6_8 - grid, t7_8 = s7_8 - grid;
    const float s0_9 = r0_9 + grid, s1_9 = r1_9 + grid, s2_9 = r2_9 + grid;
    const float r3_9 = u3_9 + p3_9, r4_9 = u4_9 + p4_9, r5_9 = u5_9 + p5_9;
    k3 = k3 + q3_9; k4 = k4 + q4_9; k5 = k5 + q5_9;
    const float p6_9 = k6 * l9, p7_9 = k7 * l9, p8_9 = k8 * l9;
    const float q6_9 = u6_9 * k9, q7_9 = u7_9 * k9, q8_9 = u8_9 * k9;
    const float l10 = self->l[10]; /* column 10 */
    float k10 = self->g[10];
    const float u0_10 = u[45], u1_10 = u[46], u2_10 = u[47];
    u[34] = t6_8; u[35] = t7_8;
    const float t0_9 = s0_9 - grid, t1_9 = s1_9 - grid, t2_9 = s2_9 - grid;
    const float s3_9 = r3_9 + grid, s4_9 = r4_9 + grid, s5_9 = r5_9 + grid;
    const float r6_9 = u6_9 + p6_9, r7_9 = u7_9 + p7_9, r8_9 = u8_9 + p8_9;
    k6 = k6 + q6_9; k7 = k7 + q7_9; k8 = k8 + q8_9;
    const float p0_10 = k0 * l10, p1_10 = k1 * l10, p2_10 = k2 * l10;
    const float q0_10 = u0_10 * k10, q1_10 = u1_10 * k10, q2_10 = u2_10 * k10;
    const float u3_10 = u[48], u4_10 = u[49], u5_10 = u[50];
    u[36] = t0_9; u[37] = t1_9; u[38] = t2_9;
    const float t3_9 = s3_9 - grid, t4_9 = s4_9 - grid, t5_9 = s5_9 - grid;
    const float s6_9 = r6_9 + grid, s7_9 = r7_9 + grid, s8_9 = r8_9 + grid;
    const float r0_10 = u0_10 + p0_10, r1_10 = u1_10 + p1_10, r2_10 = u2_10 + p2_10;
    k0 = k0 + q0_10; k1 = k1 + q1_10; k2 = k2 + q2_10;
    const float p3_10 = k3 * l10, p4_10 = k4 * l10, p5_10 = k5 * l10;
    const float q3_10 = u3_10 * k10, q4_10 = u4_10 * k10, q5_10 = u5_10 * k10;
    const float u6_10 = u[51], u7_10 = u[52], u8_10 = u[53];
    u[39] = t3_9; u[40] = t4_9; u[41] = t5_9;
    const float t6_9 = s6_9 - grid, t7_9 = s7_9 - grid, t8_9 = s8_9 - grid;
    const float s0_10 = r0_10 + grid, s1_10 = r1_10 + grid, s2_10 = r2_10 + grid;
    const float r3_10 = u3_10 + p3_10, r4_10 = u4_10 + p4_10, r5_10 = u5_10 + p5_10;
    k3 = k3 + q3_10; k4 = k4 + q4_10; k5 = k5 + q5_10;
    const float p6_10 = k6 * l10, p7_10 = k7 * l10, p8_10 = k8 * l10;
    const float q6_10 = u6_10 * k10, q7_10 = u7_10 * k10, q8_10 = u8_10 * k10;
    const float u9_10 = u[54];
    u[42] = t6_9; u[43] = t7_9; u[44] = t8_9;
    const float t0_10 = s0_10 - grid, t1_10 = s1_10 - grid, t2_10 = s2_10 - grid;
    const float s3_10 = r3_10 + grid, s4_10 = r4_10 + grid, s5_10 = r5_10 + grid;
    const float r6_10 = u6_10 + p6_10, r7_10 = u7_10 + p7_10, r8_10 = u8_10 + p8_10;
    k6 = k6 + q6_10; k7 = k7 + q7_10; k8 = k8 + q8_10;
    const float p9_10 = k9 * l10;
    const float q9_10 = u9_10 * k10;
    const float l11 = self->l[11]; /* column 11 */
    float k11 = self->g[11];
    const float u0_11 = u[55], u1_11 = u[56], u2_11 = u[57];
    u[45] = t0_10; u[46] = t1_10; u[47] = t2_10;
    const float t3_10 = s3_10 - grid, t4_10 = s4_10 - grid, t5_10 = s5_10 - grid;
    const float s6_10 = r6_10 + grid, s7_10 = r7_10 + grid, s8_10 = r8_10 + grid;
    const float r9_10 = u9_10 + p9_10;
    k9 = k9 + q9_10;
    const float p0_11 = k0 * l11, p1_11 = k1 * l11, p2_11 = k2 * l11;
    const float q0_11 = u0_11 * k11, q1_11 = u1_11 * k11, q2_11 = u2_11 * k11;
    const float u3_11 = u[58], u4_11 = u[59], u5_11 = u[60];
    u[48] = t3_10; u[49] = t4_10; u[50] = t5_10;
    const float t6_10 = s6_10 - grid, t7_10 = s7_10 - grid, t8_10 = s8_10 - grid;
    const float s9_10 = r9_10 + grid;
    const float r0_11 = u0_11 + p0_11, r1_11 = u1_11 + p1_11, r2_11 = u2_11 + p2_11;
    k0 = k0 + q0_11; k1 = k1 + q1_11; k2 = k2 + q2_11;
    const float p3_11 = k3 * l11, p4_11 = k4 * l11, p5_11 = k5 * l11;
    const float q3_11 = u3_11 * k11, q4_11 = u4_11 * k11, q5_11 = u5_11 * k11;
    const float u6_11 = u[61], u7_11 = u[62], u8_11 = u[63];
    u[51] = t6_10; u[52] = t7_10; u[53] = t8_10;
    const float t9_10 = s9_10 - grid;
    const float s0_11 = r0_11 + grid, s1_11 = r1_11 + grid, s2_11 = r2_11 + grid;
    const float r3_11 = u3_11 + p3_11, r4_11 = u4_11 + p4_11, r5_11 = u5_11 + p5_11;
    k3 = k3 + q3_11; k4 = k4 + q4_11; k5 = k5 + q5_11;
    const float p6_11 = k6 * l11, p7_11 = k7 * l11, p8_11 = k8 * l11;
    const float q6_11 = u6_11 * k11, q7_11 = u7_11 * k11, q8_11 = u8_11 * k11;
    const float u9_11 = u[64], u10_11 = u[65];
    u[54] = t9_10;
    const float t0_11 = s0_11 - grid, t1_11 = s1_11 - grid, t2_11 = s2_11 - grid;
    const float s3_11 = r3_11 + grid, s4_11 = r4_11 + grid, s5_11 = r5_11 + grid;
    const float r6_11 = u6_11 + p6_11, r7_11 = u7_11 + p7_11, r8_11 = u8_11 + p8_11;
    k6 = k6 + q6_11; k7 = k7 + q7_11; k8 = k8 + q8_11;
    const float p9_11 = k9 * l11, p10_11 = k10 * l11;
    const float q9_11 = u9_11 * k11, q10_11 = u10_11 * k11;
    const float l12 = self->l[12]; /* column 12 */
    float k12 = self->g[12];
    const float u0_12 = u[66], u1_12 = u[67], u2_12 = u[68];
    u[55] = t0_11; u[56] = t1_11; u[57] = t2_11;
    const float t3_11 = s3_11 - grid, t4_11 = s4_11 - grid, t5_11 = s5_11 - grid;
    const float s6_11 = r6_11 + grid, s7_11 = r7_11 + grid, s8_11 = r8_11 + grid;
    const float r9_11 = u9_11 + p9_11, r10_11 = u10_11 + p10_11;
    k9 = k9 + q9_11; k10 = k10 + q10_11;
    const float p0_12 = k0 * l12, p1_12 = k1 * l12, p2_12 = k2 * l12;
    const float q0_12 = u0_12 * k12, q1_12 = u1_12 * k12, q2_12 = u2_12 * k12;
    const float u3_12 = u[69], u4_12 = u[70], u5_12 = u[71];
    u[58] = t3_11; u[59] = t4_11; u[60] = t5_11;
    const float t6_11 = s6_11 - grid, t7_11 = s7_11 - grid, t8_11 = s8_11 - grid;
    const float s9_11 = r9_11 + grid, s10_11 = r10_11 + grid;
    const float r0_12 = u0_12 + p0_12, r1_12 = u1_12 + p1_12, r2_12 = u2_12 + p2_12;
    k0 = k0 + q0_12; k1 = k1 + q1_12; k2 = k2 + q2_12;
    const float p3_12 = k3 * l12, p4_12 = k4 * l12, p5_12 = k5 * l12;
    const float q3_12 = u3_12 * k12, q4_12 = u4_12 * k12, q5_12 = u5_12 * k12;
    const float u6_12 = u[72], u7_12 = u[73], u8_12 = u[74];
    u[61] = t6_11; u[62] = t7_11; u[63] = t8_11;
    const float t9_11 = s9_11 - grid, t10_11 = s10_11 - grid;
    const float s0_12 = r0_12 + grid, s1_12 = r1_12 + grid, s2_12 = r2_12 + grid;
    const float r3_12 = u3_12 + p3_12, r4_12 = u4_12 + p4_12, r5_12 = u5_12 + p5_12;
    k3 = k3 + q3_12; k4 = k4 + q4_12; k5 = k5 + q5_12;
    const float p6_12 = k6 * l12, p7_12 = k7 * l12, p8_12 = k8 * l12;
    const float q6_12 = u6_12 * k12, q7_12 = u7_12 * k12, q8_12 = u8_12 * k12;
    const float u9_12 = u[75], u10_12 = u[76], u11_12 = u[77];
    u[64] = t9_11; u[65] = t10_11;
    const float t0_12 = s0_12 - grid, t1_12 = s1_12 - grid, t2_12 = s2_12 - grid;
    const float s3_12 = r3_12 + grid, s4_12 = r4_12 + grid, s5_12 = r5_12 + grid;
    const float r6_12 = u6_12 + p6_12, r7_12 = u7_12 + p7_12, r8_12 = u8_12 + p8_12;
    k6 = k6 + q6_12; k7 = k7 + q7_12; k8 = k8 + q8_12;
    const float p9_12 = k9 * l12, p10_12 = k10 * l12, p11_12 = k11 * l12;
    const float q9_12 = u9_12 * k12, q10_12 = u10_12 * k12, q11_12 = u11_12 * k12;
    const float l13 = self->l[13]; /* column 13 */
    float k13 = self->g[13];
    const float u0_13 = u[78], u1_13 = u[79], u2_13 = u[80];
    u[66] = t0_12; u[67] = t1_12; u[68] = t2_12;
    const float t3_12 = s3_12 - grid, t4_12 = s4_12 - grid, t5_12 = s5_12 - grid;
    const float s6_12 = r6_12 + grid, s7_12 = r7_12 + grid, s8_12 = r8_12 + grid;
    const float r9_12 = u9_12 + p9_12, r10_12 = u10_12 + p10_12, r11_12 = u11_12 + p11_12;
    k9 = k9 + q9_12; k10 = k10 + q10_12; k11 = k11 + q11_12;
    const float p0_13 = k0 * l13, p1_13 = k1 * l13, p2_13 = k2 * l13;
    const float q0_13 = u0_13 * k13, q1_13 = u1_13 * k13, q2_13 = u2_13 * k13;
    const float u3_13 = u[81], u4_13 = u[82], u5_13 = u[83];
    u[69] = t3_12; u[70] = t4_12; u[71] = t5_12;
    const float t6_12 = s6_12 - grid, t7_12 = s7_12 - grid, t8_12 = s8_12 - grid;
    const float s9_12 = r9_12 + grid, s10_12 = r10_12 + grid, s11_12 = r11_12 + grid;
    const float r0_13 = u0_13 + p0_13, r1_13 = u1_13 + p1_13, r2_13 = u2_13 + p2_13;
    k0 = k0 + q0_13; k1 = k1 + q1_13; k2 = k2 + q2_13;
    const float p3_13 = k3 * l13, p4_13 = k4 * l13, p5_13 = k5 * l13;
    const float q3_13 = u3_13 * k13, q4_13 = u4_13 * k13, q5_13 = u5_13 * k13;
    const float u6_13 = u[84], u7_13 = u[85], u8_13 = u[86];
    u[72] = t6_12; u[73] = t7_12; u[74] = t8_12;
    const float t9_12 = s9_12 - grid, t10_12 = s10_12 - grid, t11_12 = s11_12 - grid;
    const float s0_13 = r0_13 + grid, s1_13 = r1_13 + grid, s2_13 = r2_13 + grid;
    const float r3_13 = u3_13 + p3_13, r4_13 = u4_13 + p4_13, r5_13 = u5_13 + p5_13;
    k3 = k3 + q3_13; k4 = k4 + q4_13; k5 = k5 + q5_13;
    const float p6_13 = k6 * l13, p7_13 = k7 * l13, p8_13 = k8 * l13;
    const float q6_13 = u6_13 * k13, q7_13 = u7_13 * k13, q8_13 = u8_13 * k13;
    const float u9_13 = u[87], u10_13 = u[88], u11_13 = u[89];
    u[75] = t9_12; u[76] = t10_12; u[77] = t11_12;
    const float t0_13 = s0_13 - grid, t1_13 = s1_13 - grid, t2_13 = s2_13 - grid;
    const float s3_13 = r3_13 + grid, s4_13 = r4_13 + grid, s5_13 = r5_13 + grid;
    const float r6_13 = u6_13 + p6_13, r7_13 = u7_13 + p7_13, r8_13 = u8_13 + p8_13;
    k6 = k6 + q6_13; k7 = k7 + q7_13; k8 = k8 + q8_13;
    const float p9_13 = k9 * l13, p10_13 = k10 * l13, p11_13 = k11 * l13;
    const float q9_13 = u9_13 * k13, q10_13 = u10_13 * k13, q11_13 = u11_13 * k13;
    const float u12_13 = u[90];
    u[78] = t0_13; u[79] = t1_13; u[80] = t2_13;
    const float t3_13 = s3_13 - grid, t4_13 = s4_13 - grid, t5_13 = s5_13 - grid;
    const float s6_13 = r6_13 + grid, s7_13 = r7_13 + grid, s8_13 = r8_13 + grid;
    const float r9_13 = u9_13 + p9_13, r10_13 = u10_13 + p10_13, r11_13 = u11_13 + p11_13;
    k9 = k9 + q9_13; k10 = k10 + q10_13; k11 = k11 + q11_13;
    const float p12_13 = k12 * l13;
    const float q12_13 = u12_13 * k13;
    const float l14 = self->l[14]; /* column 14 */
    float k14 = self->g[14];
    const float u0_14 = u[91], u1_14 = u[92], u2_14 = u[93];
    u[81] = t3_13; u[82] = t4_13; u[83] = t5_13;
    const float t6_13 = s6_13 - grid, t7_13 = s7_13 - grid, t8_13 = s8_13 - grid;
    const float s9_13 = r9_13 + grid, s10_13 = r10_13 + grid, s11_13 = r11_13 + grid;
    const float r12_13 = u12_13 + p12_13;
    k12 = k12 + q12_13;
    const float p0_14 = k0 * l14, p1_14 = k1 * l14, p2_14 = k2 * l14;
    const float q0_14 = u0_14 * k14, q1_14 = u1_14 * k14, q2_14 = u2_14 * k14;
    const float u3_14 = u[94], u4_14 = u[95], u5_14 = u[96];
    u[84] = t6_13; u[85] = t7_13; u[86] = t8_13;
    const float t9_13 = s9_13 - grid, t10_13 = s10_13 - grid, t11_13 = s11_13 - grid;
    const float s12_13 = r12_13 + grid;
    const float r0_14 = u0_14 + p0_14, r1_14 = u1_14 + p1_14, r2_14 = u2_14 + p2_14;
    k0 = k0 + q0_14; k1 = k1 + q1_14; k2 = k2 + q2_14;
    const float p3_14 = k3 * l14, p4_14 = k4 * l14, p5_14 = k5 * l14;
    const float q3_14 = u3_14 * k14, q4_14 = u4_14 * k14, q5_14 = u5_14 * k14;
    const float u6_14 = u[97], u7_14 = u[98], u8_14 = u[99];
    u[87] = t9_13; u[88] = t10_13; u[89] = t11_13;
    const float t12_13 = s12_13 - grid;
    const float s0_14 = r0_14 + grid, s1_14 = r1_14 + grid, s2_14 = r2_14 + grid;
    const float r3_14 = u3_14 + p3_14, r4_14 = u4_14 + p4_14, r5_14 = u5_14 + p5_14;
    k3 = k3 + q3_14; k4 = k4 + q4_14; k5 = k5 + q5_14;
    const float p6_14 = k6 * l14, p7_14 = k7 * l14, p8_14 = k8 * l14;
    const float q6_14 = u6_14 * k14, q7_14 = u7_14 * k14, q8_14 = u8_14 * k14;
    const float u9_14 = u[100], u10_14 = u[101], u11_14 = u[102];
    u[90] = t12_13;
    const float t0_14 = s0_14 - grid, t1_14 = s1_14 - grid, t2_14 = s2_14 - grid;
    const float s3_14 = r3_14 + grid, s4_14 = r4_14 + grid, s5_14 = r5_14 + grid;
    const float r6_14 = u6_14 + p6_14, r7_14 = u7_14 + p7_14, r8_14 = u8_14 + p8_14;
    k6 = k6 + q6_14; k7 = k7 + q7_14; k8 = k8 + q8_14;
    const float p9_14 = k9 * l14, p10_14 = k10 * l14, p11_14 = k11 * l14;
    const float q9_14 = u9_14 * k14, q10_14 = u10_14 * k14, q11_14 = u11_14 * k14;
    const float u12_14 = u[103], u13_14 = u[104];
    u[91] = t0_14; u[92] = t1_14; u[93] = t2_14;
    const float t3_14 = s3_14 - grid, t4_14 = s4_14 - grid, t5_14 = s5_14 - grid;
    const float s6_14 = r6_14 + grid, s7_14 = r7_14 + grid, s8_14 = r8_14 + grid;
    const float r9_14 = u9_14 + p9_14, r10_14 = u10_14 + p10_14, r11_14 = u11_14 + p11_14;
    k9 = k9 + q9_14; k10 = k10 + q10_14; k11 = k11 + q11_14;
    const float p12_14 = k12 * l14, p13_14 = k13 * l14;
    const float q12_14 = u12_14 * k14, q13_14 = u13_14 * k14;
    const float l15 = self->l[15]; /* column 15 */
    float k15 = self->g[15];
    const float u0_15 = u[105], u1_15 = u[106], u2_15 = u[107];
    u[94] = t3_14; u[95] = t4_14; u[96] = t5_14;
    const float t6_14 = s6_14 - grid, t7_14 = s7_14 - grid, t8_14 = s8_14 - grid;
    const float s9_14 = r9_14 + grid, s10_14 = r10_14 + grid, s11_14 = r11_14 + grid;
    const float r12_14 = u12_14 + p12_14, r13_14 = u13_14 + p13_14;
    k12 = k12 + q12_14; k13 = k13 + q13_14;
    const float p0_15 = k0 * l15, p1_15 = k1 * l15, p2_15 = k2 * l15;
    const float q0_15 = u0_15 * k15, q1_15 = u1_15 * k15, q2_15 = u2_15 * k15;
    const float u3_15 = u[108], u4_15 = u[109], u5_15 = u[110];
    u[97] = t6_14; u[98] = t7_14; u[99] = t8_14;
    const float t9_14 = s9_14 - grid, t10_14 = s10_14 - grid, t11_14 = s11_14 - grid;
    const float s12_14 = r12_14 + grid, s13_14 = r13_14 + grid;
    const float r0_15 = u0_15 + p0_15, r1_15 = u1_15 + p1_15, r2_15 = u2_15 + p2_15;
    k0 = k0 + q0_15; k1 = k1 + q1_15; k2 = k2 + q2_15;
    const float p3_15 = k3 * l15, p4_15 = k4 * l15, p5_15 = k5 * l15;
    const float q3_15 = u3_15 * k15, q4_15 = u4_15 * k15, q5_15 = u5_15 * k15;
    const float u6_15 = u[111], u7_15 = u[112], u8_15 = u[113];
    u[100] = t9_14; u[101] = t10_14; u[102] = t11_14;
    const float t12_14 = s12_14 - grid, t13_14 = s13_14 - grid;
    const float s0_15 = r0_15 + grid, s1_15 = r1_15 + grid, s2_15 = r2_15 + grid;
    const float r3_15 = u3_15 + p3_15, r4_15 = u4_15 + p4_15, r5_15 = u5_15 + p5_15;
    k3 = k3 + q3_15; k4 = k4 + q4_15; k5 = k5 + q5_15;
    const float p6_15 = k6 * l15, p7_15 = k7 * l15, p8_15 = k8 * l15;
    const float q6_15 = u6_15 * k15, q7_15 = u7_15 * k15, q8_15 = u8_15 * k15;
    const float u9_15 = u[114], u10_15 = u[115], u11_15 = u[116];
    u[103] = t12_14; u[104] = t13_14;
    const float t0_15 = s0_15 - grid, t1_15 = s1_15 - grid, t2_15 = s2_15 - grid;
    const float s3_15 = r3_15 + grid, s4_15 = r4_15 + grid, s5_15 = r5_15 + grid;
    const float r6_15 = u6_15 + p6_15, r7_15 = u7_15 + p7_15, r8_15 = u8_15 + p8_15;
    k6 = k6 + q6_15; k7 = k7 + q7_15; k8 = k8 + q8_15;
    const float p9_15 = k9 * l15, p10_15 = k10 * l15, p11_15 = k11 * l15;
    const float q9_15 = u9_15 * k15, q10_15 = u10_15 * k15, q11_15 = u11_15 * k15;
    const float u12_15 = u[117], u13_15 = u[118], u14_15 = u[119];
    u[105] = t0_15; u[106] = t1_15; u[107] = t2_15;
    const float t3_15 = s3_15 - grid, t4_15 = s4_15 - grid, t5_15 = s5_15 - grid;
    const float s6_15 = r6_15 + grid, s7_15 = r7_15 + grid, s8_15 = r8_15 + grid;
    const float r9_15 = u9_15 + p9_15, r10_15 = u10_15 + p10_15, r11_15 = u11_15 + p11_15;
    k9 = k9 + q9_15; k10 = k10 + q10_15; k11 = k11 + q11_15;
    const float p12_15 = k12 * l15, p13_15 = k13 * l15, p14_15 = k14 * l15;
    const float q12_15 = u12_15 * k15, q13_15 = u13_15 * k15, q14_15 = u14_15 * k15;
    const float l16 = self->l[16]; /* column 16 */
    float k16 = self->g[16];
    const float u0_16 = u[120], u1_16 = u[121], u2_16 = u[122];
    u[108] = t3_15; u[109] = t4_15; u[110] = t5_15;
    const float t6_15 = s6_15 - grid, t7_15 = s7_15 - grid, t8_15 = s8_15 - grid;
    const float s9_15 = r9_15 + grid, s10_15 = r10_15 + grid, s11_15 = r11_15 + grid;
    const float r12_15 = u12_15 + p12_15, r13_15 = u13_15 + p13_15, r14_15 = u14_15 + p14_15;
    k12 = k12 + q12_15; k13 = k13 + q13_15; k14 = k14 + q14_15;
    const float p0_16 = k0 * l16, p1_16 = k1 * l16, p2_16 = k2 * l16;
    const float q0_16 = u0_16 * k16, q1_16 = u1_16 * k16, q2_16 = u2_16 * k16;
    const float u3_16 = u[123], u4_16 = u[124], u5_16 = u[125];
    u[111] = t6_15; u[112] = t7_15; u[113] = t8_15;
    const float t9_15 = s9_15 - grid, t10_15 = s10_15 - grid, t11_15 = s11_15 - grid;
    const float s12_15 = r12_15 + grid, s13_15 = r13_15 + grid, s14_15 = r14_15 + grid;
    const float r0_16 = u0_16 + p0_16, r1_16 = u1_16 + p1_16, r2_16 = u2_16 + p2_16;
    k0 = k0 + q0_16; k1 = k1 + q1_16; k2 = k2 + q2_16;
    const float p3_16 = k3 * l16, p4_16 = k4 * l16, p5_16 = k5 * l16;
    const float q3_16 = u3_16 * k16, q4_16 = u4_16 * k16, q5_16 = u5_16 * k16;
    const float u6_16 = u[126], u7_16 = u[127], u8_16 = u[128];
    u[114] = t9_15; u[115] = t10_15; u[116] = t11_15;
    const float t12_15 = s12_15 - grid, t13_15 = s13_15 - grid, t14_15 = s14_15 - grid;
    const float s0_16 = r0_16 + grid, s1_16 = r1_16 + grid, s2_16 = r2_16 + grid;
    const float r3_16 = u3_16 + p3_16, r4_16 = u4_16 + p4_16, r5_16 = u5_16 + p5_16;
    k3 = k3 + q3_16; k4 = k4 + q4_16; k5 = k5 + q5_16;
    const float p6_16 = k6 * l16, p7_16 = k7 * l16, p8_16 = k8 * l16;
    const float q6_16 = u6_16 * k16, q7_16 = u7_16 * k16, q8_16 = u8_16 * k16;
    const float u9_16 = u[129], u10_16 = u[130], u11_16 = u[131];
    u[117] = t12_15; u[118] = t13_15; u[119] = t14_15;
    const float t0_16 = s0_16 - grid, t1_16 = s1_16 - grid, t2_16 = s2_16 - grid;
    const float s3_16 = r3_16 + grid, s4_16 = r4_16 + grid, s5_16 = r5_16 + grid;
    const float r6_16 = u6_16 + p6_16, r7_16 = u7_16 + p7_16, r8_16 = u8_16 + p8_16;
    k6 = k6 + q6_16; k7 = k7 + q7_16; k8 = k8 + q8_16;
    const float p9_16 = k9 * l16, p10_16 = k10 * l16, p11_16 = k11 * l16;
    const float q9_16 = u9_16 * k16, q10_16 = u10_16 * k16, q11_16 = u11_16 * k16;
    const float u12_16 = u[132], u13_16 = u[133], u14_16 = u[134];
    u[120] = t0_16; u[121] = t1_16; u[122] = t2_16;
    const float t3_16 = s3_16 - grid, t4_16 = s4_16 - grid, t5_16 = s5_16 - grid;
    const float s6_16 = r6_16 + grid, s7_16 = r7_16 + grid, s8_16 = r8_16 + grid;
    const float r9_16 = u9_16 + p9_16, r10_16 = u10_16 + p10_16, r11_16 = u11_16 + p11_16;
    k9 = k9 + q9_16; k10 = k10 + q10_16; k11 = k11 + q11_16;
    const float p12_16 = k12 * l16, p13_16 = k13 * l16, p14_16 = k14 * l16;
    const float q12_16 = u12_16 * k16, q13_16 = u13_16 * k16, q14_16 = u14_16 * k16;
    const float u15_16 = u[135];
    u[123] = t3_16; u[124] = t4_16; u[125] = t5_16;
    const float t6_16 = s6_16 - grid, t7_16 = s7_16 - grid, t8_16 = s8_16 - grid;
    const float s9_16 = r9_16 + grid, s10_16 = r10_16 + grid, s11_16 = r11_16 + grid;
    const float r12_16 = u12_16 + p12_16, r13_16 = u13_16 + p13_16, r14_16 = u14_16 + p14_16;
    k12 = k12 + q12_16; k13 = k13 + q13_16; k14 = k14 + q14_16;
    const float p15_16 = k15 * l16;
    const float q15_16 = u15_16 * k16;
    const float l17 = self->l[17]; /* column 17 */
    const float k17 = self->g[17];
    const float u0_17 = u[136], u1_17 = u[137], u2_17 = u[138];
    u[126] = t6_16; u[127] = t7_16; u[128] = t8_16;
    const float t9_16 = s9_16 - grid, t10_16 = s10_16 - grid, t11_16 = s11_16 - grid;
    const float s12_16 = r12_16 + grid, s13_16 = r13_16 + grid, s14_16 = r14_16 + grid;
    const float r15_16 = u15_16 + p15_16;
    k15 = k15 + q15_16;
    const float p0_17 = k0 * l17, p1_17 = k1 * l17, p2_17 = k2 * l17;
    const float q0_17 = u0_17 * k17, q1_17 = u1_17 * k17, q2_17 = u2_17 * k17;
    const float u3_17 = u[139], u4_17 = u[140], u5_17 = u[141];
    u[129] = t9_16; u[130] = t10_16; u[131] = t11_16;
    const float t12_16 = s12_16 - grid, t13_16 = s13_16 - grid, t14_16 = s14_16 - grid;
    const float s15_16 = r15_16 + grid;
    const float r0_17 = u0_17 + p0_17, r1_17 = u1_17 + p1_17, r2_17 = u2_17 + p2_17;
    k0 = k0 + q0_17; k1 = k1 + q1_17; k2 = k2 + q2_17;
    const float p3_17 = k3 * l17, p4_17 = k4 * l17, p5_17 = k5 * l17;
    const float q3_17 = u3_17 * k17, q4_17 = u4_17 * k17, q5_17 = u5_17 * k17;
    const float u6_17 = u[142], u7_17 = u[143], u8_17 = u[144];
    u[132] = t12_16; u[133] = t13_16; u[134] = t14_16;
    const float t15_16 = s15_16 - grid;
    const float s0_17 = r0_17 + grid, s1_17 = r1_17 + grid, s2_17 = r2_17 + grid;
    const float r3_17 = u3_17 + p3_17, r4_17 = u4_17 + p4_17, r5_17 = u5_17 + p5_17;
    k3 = k3 + q3_17; k4 = k4 + q4_17; k5 = k5 + q5_17;
    const float p6_17 = k6 * l17, p7_17 = k7 * l17, p8_17 = k8 * l17;
    const float q6_17 = u6_17 * k17, q7_17 = u7_17 * k17, q8_17 = u8_17 * k17;
    const float u9_17 = u[145], u10_17 = u[146], u11_17 = u[147];
    u[135] = t15_16;
    const float t0_17 = s0_17 - grid, t1_17 = s1_17 - grid, t2_17 = s2_17 - grid;
    const float s3_17 = r3_17 + grid, s4_17 = r4_17 + grid, s5_17 = r5_17 + grid;
    const float r6_17 = u6_17 + p6_17, r7_17 = u7_17 + p7_17, r8_17 = u8_17 + p8_17;
    k6 = k6 + q6_17; k7 = k7 + q7_17; k8 = k8 + q8_17;
    const float p9_17 = k9 * l17, p10_17 = k10 * l17, p11_17 = k11 * l17;
    const float q9_17 = u9_17 * k17, q10_17 = u10_17 * k17, q11_17 = u11_17 * k17;
    const float u12_17 = u[148], u13_17 = u[149], u14_17 = u[150];
    u[136] = t0_17; u[137] = t1_17; u[138] = t2_17;
    const float t3_17 = s3_17 - grid, t4_17 = s4_17 - grid, t5_17 = s5_17 - grid;
    const float s6_17 = r6_17 + grid, s7_17 = r7_17 + grid, s8_17 = r8_17 + grid;
    const float r9_17 = u9_17 + p9_17, r10_17 = u10_17 + p10_17, r11_17 = u11_17 + p11_17;
    k9 = k9 + q9_17; k10 = k10 + q10_17; k11 = k11 + q11_17;
    const float p12_17 = k12 * l17, p13_17 = k13 * l17, p14_17 = k14 * l17;
    const float q12_17 = u12_17 * k17, q13_17 = u13_17 * k17, q14_17 = u14_17 * k17;
    const float u15_17 = u[151], u16_17 = u[152];
    u[139] = t3_17; u[140] = t4_17; u[141] = t5_17;
    const float t6_17 = s6_17 - grid, t7_17 = s7_17 - grid, t8_17 = s8_17 - grid;
    const float s9_17 = r9_17 + grid, s10_17 = r10_17 + grid, s11_17 = r11_17 + grid;
    const float r12_17 = u12_17 + p12_17, r13_17 = u13_17 + p13_17, r14_17 = u14_17 + p14_17;
    k12 = k12 + q12_17; k13 = k13 + q13_17; k14 = k14 + q14_17;
    const float p15_17 = k15 * l17, p16_17 = k16 * l17;
    const float q15_17 = u15_17 * k17, q16_17 = u16_17 * k17;
    u[142] = t6_17; u[143] = t7_17; u[144] = t8_17;
    const float t9_17 = s9_17 - grid, t10_17 = s10_17 - grid, t11_17 = s11_17 - grid;
    const float s12_17 = r12_17 + grid, s13_17 = r13_17 + grid, s14_17 = r14_17 + grid;
    const float r15_17 = u15_17 + p15_17, r16_17 = u16_17 + p16_17;
    k15 = k15 + q15_17; k16 = k16 + q16_17;
    u[145] = t9_17; u[146] = t10_17; u[147] = t11_17;
    const float t12_17 = s12_17 - grid, t13_17 = s13_17 - grid, t14_17 = s14_17 - grid;
    const float s15_17 = r15_17 + grid, s16_17 = r16_17 + grid;
    u[148] = t12_17; u[149] = t13_17; u[150] = t14_17;
    const float t15_17 = s15_17 - grid, t16_17 = s16_17 - grid;
    u[151] = t15_17; u[152] = t16_17;

    self->k[0] = k0; self->k[1] = k1; self->k[2] = k2; self->k[3] = k3; self->k[4] = k4;
            self->k[5] = k5;
    self->k[6] = k6; self->k[7] = k7; self->k[8] = k8; self->k[9] = k9; self->k[10] = k10;
            self->k[11] = k11;
    self->k[12] = k12; self->k[13] = k13; self->k[14] = k14; self->k[15] = k15;
            self->k[16] = k16; self->k[17] = k17;
}

/* 1 if the sample behind f and g may be learnt from. Its innovation is expected to be up to the usual one times
 * sqrt(alpha), alpha = 1 + x' P x, for where the learner knows little it errs more. */
EXTENDED_CODE
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

/* alpha_j = alpha_(j-1) + f_j g_j from alpha = 1 on, l_j = -f_j / alpha_(j-1), D_j <- D_j / lambda * alpha_(j-1) / alpha_j.
 * The reciprocals are those of extended_reciprocal, several side by side. Returns 1 if the update goes on, 0 if the
 * sample is not learnt from, 2 if the shadow has to start again. */
EXTENDED_CODE
static EXTENDED_STRAIGHT uint32_t extended_update_diagonal(extended_learner_t *self)
{
    const float inflate = self->inflate;
    const float least = EXTENDED_LEARN_LEAST_VARIANCE;
    uint32_t clamped = 0u;
    uint32_t outcome;
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
    const float m12 = self->f[12] * self->g[12];
    const float m13 = self->f[13] * self->g[13];
    const float m14 = self->f[14] * self->g[14];
    const float m15 = self->f[15] * self->g[15];
    const float m16 = self->f[16] * self->g[16];
    const float m17 = self->f[17] * self->g[17];
    const float a0 = 1.0f + m0;
    const float a1 = a0 + m1;
    const float a2 = a1 + m2;
    const float a3 = a2 + m3;
    const float a4 = a3 + m4;
    const float a5 = a4 + m5;
    const float a6 = a5 + m6;
    const float a7 = a6 + m7;
    const float a8 = a7 + m8;
    const float a9 = a8 + m9;
    const float a10 = a9 + m10;
    const float a11 = a10 + m11;
    const float a12 = a11 + m12;
    const float a13 = a12 + m13;
    const float a14 = a13 + m14;
    const float a15 = a14 + m15;
    const float a16 = a15 + m16;
    const float a17 = a16 + m17;

    /* Only rounding gone wild brings alpha here; in the order of the bits this also finds what is not finite. */
    if (extended_bits(a17) >= extended_bits(EXTENDED_LEARN_LARGEST_DENOMINATOR)) {
        outcome = 2u;
    } else if (self->measuring != 0u) {
        outcome = extended_admit(self, a17);
    } else {
        outcome = 1u;
    }
    if (outcome != 1u) {
        return outcome;
    }

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
    float r9 = extended_float(0x7ef311c7u - extended_bits(a9)),
            r10 = extended_float(0x7ef311c7u - extended_bits(a10)),
            r11 = extended_float(0x7ef311c7u - extended_bits(a11)),
            r12 = extended_float(0x7ef311c7u - extended_bits(a12)),
            r13 = extended_float(0x7ef311c7u - extended_bits(a13)),
            r14 = extended_float(0x7ef311c7u - extended_bits(a14)),
            r15 = extended_float(0x7ef311c7u - extended_bits(a15)),
            r16 = extended_float(0x7ef311c7u - extended_bits(a16)),
            r17 = extended_float(0x7ef311c7u - extended_bits(a17));
    float t9 = a9 * r9, t10 = a10 * r10, t11 = a11 * r11, t12 = a12 * r12, t13 = a13 * r13,
            t14 = a14 * r14, t15 = a15 * r15, t16 = a16 * r16, t17 = a17 * r17;
    r0 = r0 * t0; r1 = r1 * t1; r2 = r2 * t2; r3 = r3 * t3; r4 = r4 * t4; r5 = r5 * t5;
            r6 = r6 * t6; r7 = r7 * t7; r8 = r8 * t8;
    t9 = 2.0f - t9; t10 = 2.0f - t10; t11 = 2.0f - t11; t12 = 2.0f - t12; t13 = 2.0f - t13;
            t14 = 2.0f - t14; t15 = 2.0f - t15; t16 = 2.0f - t16; t17 = 2.0f - t17;
    t0 = a0 * r0; t1 = a1 * r1; t2 = a2 * r2; t3 = a3 * r3; t4 = a4 * r4; t5 = a5 * r5;
            t6 = a6 * r6; t7 = a7 * r7; t8 = a8 * r8;
    r9 = r9 * t9; r10 = r10 * t10; r11 = r11 * t11; r12 = r12 * t12; r13 = r13 * t13;
            r14 = r14 * t14; r15 = r15 * t15; r16 = r16 * t16; r17 = r17 * t17;
    t0 = 2.0f - t0; t1 = 2.0f - t1; t2 = 2.0f - t2; t3 = 2.0f - t3; t4 = 2.0f - t4;
            t5 = 2.0f - t5; t6 = 2.0f - t6; t7 = 2.0f - t7; t8 = 2.0f - t8;
    t9 = a9 * r9; t10 = a10 * r10; t11 = a11 * r11; t12 = a12 * r12; t13 = a13 * r13;
            t14 = a14 * r14; t15 = a15 * r15; t16 = a16 * r16; t17 = a17 * r17;
    r0 = r0 * t0; r1 = r1 * t1; r2 = r2 * t2; r3 = r3 * t3; r4 = r4 * t4; r5 = r5 * t5;
            r6 = r6 * t6; r7 = r7 * t7; r8 = r8 * t8;
    t9 = 2.0f - t9; t10 = 2.0f - t10; t11 = 2.0f - t11; t12 = 2.0f - t12; t13 = 2.0f - t13;
            t14 = 2.0f - t14; t15 = 2.0f - t15; t16 = 2.0f - t16; t17 = 2.0f - t17;
    t0 = a0 * r0; t1 = a1 * r1; t2 = a2 * r2; t3 = a3 * r3; t4 = a4 * r4; t5 = a5 * r5;
            t6 = a6 * r6; t7 = a7 * r7; t8 = a8 * r8;
    r9 = r9 * t9; r10 = r10 * t10; r11 = r11 * t11; r12 = r12 * t12; r13 = r13 * t13;
            r14 = r14 * t14; r15 = r15 * t15; r16 = r16 * t16; r17 = r17 * t17;
    t0 = 2.0f - t0; t1 = 2.0f - t1; t2 = 2.0f - t2; t3 = 2.0f - t3; t4 = 2.0f - t4;
            t5 = 2.0f - t5; t6 = 2.0f - t6; t7 = 2.0f - t7; t8 = 2.0f - t8;
    t9 = a9 * r9; t10 = a10 * r10; t11 = a11 * r11; t12 = a12 * r12; t13 = a13 * r13;
            t14 = a14 * r14; t15 = a15 * r15; t16 = a16 * r16; t17 = a17 * r17;
    r0 = r0 * t0; r1 = r1 * t1; r2 = r2 * t2; r3 = r3 * t3; r4 = r4 * t4; r5 = r5 * t5;
            r6 = r6 * t6; r7 = r7 * t7; r8 = r8 * t8;
    t9 = 2.0f - t9; t10 = 2.0f - t10; t11 = 2.0f - t11; t12 = 2.0f - t12; t13 = 2.0f - t13;
            t14 = 2.0f - t14; t15 = 2.0f - t15; t16 = 2.0f - t16; t17 = 2.0f - t17;
    const float l0 = self->f[0];
    const float q0 = r0;
    const float l1 = self->f[1] * r0;
    const float q1 = a0 * r1;
    const float l2 = self->f[2] * r1;
    const float q2 = a1 * r2;
    const float l3 = self->f[3] * r2;
    const float q3 = a2 * r3;
    const float l4 = self->f[4] * r3;
    const float q4 = a3 * r4;
    const float l5 = self->f[5] * r4;
    const float q5 = a4 * r5;
    const float l6 = self->f[6] * r5;
    const float q6 = a5 * r6;
    const float l7 = self->f[7] * r6;
    const float q7 = a6 * r7;
    const float l8 = self->f[8] * r7;
    const float q8 = a7 * r8;
    const float d0 = self->d[0] * inflate, d1 = self->d[1] * inflate, d2 = self->d[2] * inflate,
            d3 = self->d[3] * inflate, d4 = self->d[4] * inflate, d5 = self->d[5] * inflate,
            d6 = self->d[6] * inflate, d7 = self->d[7] * inflate, d8 = self->d[8] * inflate;
    r9 = r9 * t9; r10 = r10 * t10; r11 = r11 * t11; r12 = r12 * t12; r13 = r13 * t13;
            r14 = r14 * t14; r15 = r15 * t15; r16 = r16 * t16; r17 = r17 * t17;
    const float v0 = d0 * q0, v1 = d1 * q1, v2 = d2 * q2, v3 = d3 * q3, v4 = d4 * q4, v5 = d5 * q5,
            v6 = d6 * q6, v7 = d7 * q7, v8 = d8 * q8;
    const float c0 = extended_learn_ceiling[0], c1 = extended_learn_ceiling[1],
            c2 = extended_learn_ceiling[2], c3 = extended_learn_ceiling[3],
            c4 = extended_learn_ceiling[4], c5 = extended_learn_ceiling[5],
            c6 = extended_learn_ceiling[6], c7 = extended_learn_ceiling[7],
            c8 = extended_learn_ceiling[8];
    self->l[0] = -l0; self->l[1] = -l1; self->l[2] = -l2; self->l[3] = -l3; self->l[4] = -l4;
            self->l[5] = -l5; self->l[6] = -l6; self->l[7] = -l7; self->l[8] = -l8;
    const float l9 = self->f[9] * r8;
    const float q9 = a8 * r9;
    const float l10 = self->f[10] * r9;
    const float q10 = a9 * r10;
    const float l11 = self->f[11] * r10;
    const float q11 = a10 * r11;
    const float l12 = self->f[12] * r11;
    const float q12 = a11 * r12;
    const float l13 = self->f[13] * r12;
    const float q13 = a12 * r13;
    const float l14 = self->f[14] * r13;
    const float q14 = a13 * r14;
    const float l15 = self->f[15] * r14;
    const float q15 = a14 * r15;
    const float l16 = self->f[16] * r15;
    const float q16 = a15 * r16;
    const float l17 = self->f[17] * r16;
    const float q17 = a16 * r17;
    const float d9 = self->d[9] * inflate, d10 = self->d[10] * inflate, d11 = self->d[11] * inflate,
            d12 = self->d[12] * inflate, d13 = self->d[13] * inflate, d14 = self->d[14] * inflate,
            d15 = self->d[15] * inflate, d16 = self->d[16] * inflate, d17 = self->d[17] * inflate;
    const uint32_t below0 = extended_mask((uint32_t)(v0 < least)),
            below1 = extended_mask((uint32_t)(v1 < least)),
            below2 = extended_mask((uint32_t)(v2 < least)),
            below3 = extended_mask((uint32_t)(v3 < least)),
            below4 = extended_mask((uint32_t)(v4 < least)),
            below5 = extended_mask((uint32_t)(v5 < least)),
            below6 = extended_mask((uint32_t)(v6 < least)),
            below7 = extended_mask((uint32_t)(v7 < least)),
            below8 = extended_mask((uint32_t)(v8 < least));
    const uint32_t above0 = extended_mask((uint32_t)(v0 > c0)), above1 = extended_mask((uint32_t)(v1 > c1)),
            above2 = extended_mask((uint32_t)(v2 > c2)), above3 = extended_mask((uint32_t)(v3 > c3)),
            above4 = extended_mask((uint32_t)(v4 > c4)), above5 = extended_mask((uint32_t)(v5 > c5)),
            above6 = extended_mask((uint32_t)(v6 > c6)), above7 = extended_mask((uint32_t)(v7 > c7)),
            above8 = extended_mask((uint32_t)(v8 > c8));
    const uint32_t inside0 = extended_bits(v0) & ~(below0 | above0),
            inside1 = extended_bits(v1) & ~(below1 | above1),
            inside2 = extended_bits(v2) & ~(below2 | above2),
            inside3 = extended_bits(v3) & ~(below3 | above3),
            inside4 = extended_bits(v4) & ~(below4 | above4),
            inside5 = extended_bits(v5) & ~(below5 | above5),
            inside6 = extended_bits(v6) & ~(below6 | above6),
            inside7 = extended_bits(v7) & ~(below7 | above7),
            inside8 = extended_bits(v8) & ~(below8 | above8);
    const uint32_t end0 = (extended_bits(least) & below0) | (extended_bits(c0) & above0),
            end1 = (extended_bits(least) & below1) | (extended_bits(c1) & above1),
            end2 = (extended_bits(least) & below2) | (extended_bits(c2) & above2),
            end3 = (extended_bits(least) & below3) | (extended_bits(c3) & above3),
            end4 = (extended_bits(least) & below4) | (extended_bits(c4) & above4),
            end5 = (extended_bits(least) & below5) | (extended_bits(c5) & above5),
            end6 = (extended_bits(least) & below6) | (extended_bits(c6) & above6),
            end7 = (extended_bits(least) & below7) | (extended_bits(c7) & above7),
            end8 = (extended_bits(least) & below8) | (extended_bits(c8) & above8);
    self->d[0] = extended_float(inside0 | end0); self->d[1] = extended_float(inside1 | end1);
            self->d[2] = extended_float(inside2 | end2); self->d[3] = extended_float(inside3 | end3);
            self->d[4] = extended_float(inside4 | end4); self->d[5] = extended_float(inside5 | end5);
            self->d[6] = extended_float(inside6 | end6); self->d[7] = extended_float(inside7 | end7);
            self->d[8] = extended_float(inside8 | end8);
    clamped |= below0 | above0 | below1 | above1 | below2 | above2 | below3 | above3 | below4 | above4 |
            below5 | above5 | below6 | above6 | below7 | above7 | below8 | above8;
    const float v9 = d9 * q9, v10 = d10 * q10, v11 = d11 * q11, v12 = d12 * q12, v13 = d13 * q13,
            v14 = d14 * q14, v15 = d15 * q15, v16 = d16 * q16, v17 = d17 * q17;
    const float c9 = extended_learn_ceiling[9], c10 = extended_learn_ceiling[10],
            c11 = extended_learn_ceiling[11], c12 = extended_learn_ceiling[12],
            c13 = extended_learn_ceiling[13], c14 = extended_learn_ceiling[14],
            c15 = extended_learn_ceiling[15], c16 = extended_learn_ceiling[16],
            c17 = extended_learn_ceiling[17];
    self->l[9] = -l9; self->l[10] = -l10; self->l[11] = -l11; self->l[12] = -l12;
            self->l[13] = -l13; self->l[14] = -l14; self->l[15] = -l15; self->l[16] = -l16;
            self->l[17] = -l17;
    const uint32_t below9 = extended_mask((uint32_t)(v9 < least)),
            below10 = extended_mask((uint32_t)(v10 < least)),
            below11 = extended_mask((uint32_t)(v11 < least)),
            below12 = extended_mask((uint32_t)(v12 < least)),
            below13 = extended_mask((uint32_t)(v13 < least)),
            below14 = extended_mask((uint32_t)(v14 < least)),
            below15 = extended_mask((uint32_t)(v15 < least)),
            below16 = extended_mask((uint32_t)(v16 < least)),
            below17 = extended_mask((uint32_t)(v17 < least));
    const uint32_t above9 = extended_mask((uint32_t)(v9 > c9)), above10 = extended_mask((uint32_t)(v10 > c10)),
            above11 = extended_mask((uint32_t)(v11 > c11)),
            above12 = extended_mask((uint32_t)(v12 > c12)),
            above13 = extended_mask((uint32_t)(v13 > c13)),
            above14 = extended_mask((uint32_t)(v14 > c14)),
            above15 = extended_mask((uint32_t)(v15 > c15)),
            above16 = extended_mask((uint32_t)(v16 > c16)),
            above17 = extended_mask((uint32_t)(v17 > c17));
    const uint32_t inside9 = extended_bits(v9) & ~(below9 | above9),
            inside10 = extended_bits(v10) & ~(below10 | above10),
            inside11 = extended_bits(v11) & ~(below11 | above11),
            inside12 = extended_bits(v12) & ~(below12 | above12),
            inside13 = extended_bits(v13) & ~(below13 | above13),
            inside14 = extended_bits(v14) & ~(below14 | above14),
            inside15 = extended_bits(v15) & ~(below15 | above15),
            inside16 = extended_bits(v16) & ~(below16 | above16),
            inside17 = extended_bits(v17) & ~(below17 | above17);
    const uint32_t end9 = (extended_bits(least) & below9) | (extended_bits(c9) & above9),
            end10 = (extended_bits(least) & below10) | (extended_bits(c10) & above10),
            end11 = (extended_bits(least) & below11) | (extended_bits(c11) & above11),
            end12 = (extended_bits(least) & below12) | (extended_bits(c12) & above12),
            end13 = (extended_bits(least) & below13) | (extended_bits(c13) & above13),
            end14 = (extended_bits(least) & below14) | (extended_bits(c14) & above14),
            end15 = (extended_bits(least) & below15) | (extended_bits(c15) & above15),
            end16 = (extended_bits(least) & below16) | (extended_bits(c16) & above16),
            end17 = (extended_bits(least) & below17) | (extended_bits(c17) & above17);
    self->d[9] = extended_float(inside9 | end9); self->d[10] = extended_float(inside10 | end10);
            self->d[11] = extended_float(inside11 | end11);
            self->d[12] = extended_float(inside12 | end12);
            self->d[13] = extended_float(inside13 | end13);
            self->d[14] = extended_float(inside14 | end14);
            self->d[15] = extended_float(inside15 | end15);
            self->d[16] = extended_float(inside16 | end16);
            self->d[17] = extended_float(inside17 | end17);
    clamped |= below9 | above9 | below10 | above10 | below11 | above11 | below12 | above12 |
            below13 | above13 | below14 | above14 | below15 | above15 | below16 | above16 |
            below17 | above17;
    self->per_alpha = r17;
    extended_count_learner_event(self, &self->clamped, clamped & 1u, EXTENDED_LEARN_CLAMPED);
    return 1u;
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
EXTENDED_CODE
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
    self->theta_low[3] = left3; self->theta_low[4] = left4; self->theta_low[5] = left5;
    const float left6 = low6 - kept6, left7 = low7 - kept7, left8 = low8 - kept8;
    beyond |= extended_beyond(sum6) | extended_beyond(sum7) | extended_beyond(sum8);
    const float kept9 = sum9 - high9, kept10 = sum10 - high10, kept11 = sum11 - high11;
    self->theta[9] = sum9; self->theta[10] = sum10; self->theta[11] = sum11;
    const float sum12 = high12 + low12, sum13 = high13 + low13, sum14 = high14 + low14;
    const float low15 = self->theta_low[15] + t15, low16 = self->theta_low[16] + t16,
            low17 = self->theta_low[17] + t17;
    const float high15 = self->theta[15], high16 = self->theta[16], high17 = self->theta[17];
    self->theta_low[6] = left6; self->theta_low[7] = left7; self->theta_low[8] = left8;
    const float left9 = low9 - kept9, left10 = low10 - kept10, left11 = low11 - kept11;
    beyond |= extended_beyond(sum9) | extended_beyond(sum10) | extended_beyond(sum11);
    const float kept12 = sum12 - high12, kept13 = sum13 - high13, kept14 = sum14 - high14;
    self->theta[12] = sum12; self->theta[13] = sum13; self->theta[14] = sum14;
    const float sum15 = high15 + low15, sum16 = high16 + low16, sum17 = high17 + low17;
    self->theta_low[9] = left9; self->theta_low[10] = left10; self->theta_low[11] = left11;
    const float left12 = low12 - kept12, left13 = low13 - kept13, left14 = low14 - kept14;
    beyond |= extended_beyond(sum12) | extended_beyond(sum13) | extended_beyond(sum14);
    const float kept15 = sum15 - high15, kept16 = sum16 - high16, kept17 = sum17 - high17;
    self->theta[15] = sum15; self->theta[16] = sum16; self->theta[17] = sum17;
    self->theta_low[12] = left12; self->theta_low[13] = left13; self->theta_low[14] = left14;
    const float left15 = low15 - kept15, left16 = low16 - kept16, left17 = low17 - kept17;
    beyond |= extended_beyond(sum15) | extended_beyond(sum16) | extended_beyond(sum17);
    self->theta_low[15] = left15; self->theta_low[16] = left16; self->theta_low[17] = left17;
    self->age += self->measuring & (uint32_t)(self->age < UINT32_MAX);
    extended_count_learner_event(self, &self->updates, beyond ^ 1u, 0u);
    return beyond;
}

/* The update that was begun. Returns 1 if the shadow has to start again. */
EXTENDED_INLINE uint32_t extended_update(extended_learner_t *self)
{
    uint32_t lost;
    uint32_t outcome;

    extended_project(self);
    outcome = extended_update_diagonal(self);
    lost = (uint32_t)(outcome == 2u);
    if (outcome == 1u) {
        extended_factor(self);
        lost = extended_step(self);
    }
    return lost;
}

/* ---- Learner: samples ------------------------------------------------------------------------------------------ */

/* Innovation of the displacement y behind the regressors kept, and of the reference parameters for the same sample. */
EXTENDED_CODE
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
    shadow = shadow + p16;
    other = other + q16;
    shadow = shadow + p17;
    other = other + q17;
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
        self->x[j] = extended_learn_refresh[j];
        self->inflate = 1.0f;
        self->innovation_um = extended_learn_refresh[j] * (self->reference[j] - self->theta[j]);
        self->turn = (j + 1u < EXTENDED_LEARNED) ? j + 1u : 0u;
        self->since_refresh = 0u;
    }
}

/* What the displacement y says about the sample before. Returns 1 if the shadow has to start again; *begun becomes 1 if
 * an update begins. */
EXTENDED_INLINE uint32_t extended_evaluate_reading(
    extended_learner_t *self, float y, float *innovation, uint32_t *begun)
{
    float reference;
    uint32_t lost = 0u;

    *innovation = extended_innovations(self, y, &reference);
    extended_count_learner_event(self, &self->resting, self->rested, EXTENDED_LEARN_RESTING);
    if (self->rested == 0u) {
        lost = extended_restart_needed(self, *innovation, reference, y - self->y_um);
        if (lost == 0u) {
            extended_begin(self, *innovation);
            *begun = 1u;
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
EXTENDED_CODE
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

    self->fixed_um = 0.0f;
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
    self->fresh = outside ^ 1u;
    self->y_um = y_um;
    extended_count_learner_event(self, &self->outside, outside, EXTENDED_LEARN_OUTSIDE);
}

/* ---- Learner: copies of a model's states ------------------------------------------------------------------------- */

/* Number by number: for a struct assignment compilers may call their library. That of gcc for the C674x copies in a
 * hardware loop, and the loop's counter is lost where an interrupt copies as well. */
EXTENDED_CODE
static void extended_delay_copy(extended_delay_t *to, const extended_delay_t *from)
{
    to->newest = from->newest;
    to->wanted_V = from->wanted_V;
    for (uint32_t i = 0u; i < 4u; ++i) {
        to->ring[i] = from->ring[i];
    }
}

EXTENDED_CODE
static void extended_hysteresis_copy(extended_hysteresis_t *to, const extended_hysteresis_t *from)
{
    to->turn = from->turn;
    to->last = from->last;
    to->h_um = from->h_um;
    for (uint32_t i = 0u; i < 5u; ++i) {
        to->left[i] = from->left[i];
        to->back[i] = from->back[i];
    }
    for (uint32_t i = 0u; i < 12u; ++i) {
        to->play[i] = from->play[i];
    }
    for (uint32_t i = 0u; i < 13u; ++i) {
        to->sum_um[i] = from->sum_um[i];
    }
}

EXTENDED_CODE
static void extended_creep_copy(extended_creep_t *to, const extended_creep_t *from)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        to->high[i] = from->high[i];
        to->low[i] = from->low[i];
    }
}

EXTENDED_CODE
void extended_learn(extended_learner_t *self, float y_um, float u_V)
{
    uint32_t y_lost;
    uint32_t u_lost;
    uint32_t moved;
    const float y = extended_finite(y_um, self->y_um, &y_lost);
    const float u_finite = extended_finite(u_V, self->u_V, &u_lost);
    const float u = extended_limited(u_finite, EXTENDED_U_MIN_V, EXTENDED_U_MAX_V, &moved);
    const float w = extended_inputs_apply(&self->inputs, u);
    const uint32_t implausible = (uint32_t)(y < EXTENDED_LEARN_Y_LOW_UM) | (uint32_t)(y > EXTENDED_LEARN_Y_HIGH_UM);
    const uint32_t usable = 1u ^ (y_lost | implausible);
    const float away = u - self->mean_u_V;
    float innovation = 0.0f;
    uint32_t begun = 0u;
    uint32_t lost = 0u;

    extended_count_learner_event(self, &self->rejected, (usable ^ 1u) | u_lost, EXTENDED_LEARN_REJECTED);
    if ((self->fresh & usable) != 0u) {
        lost = extended_evaluate_reading(self, y, &innovation, &begun);
    }
    if (begun != 0u) {
        lost = extended_update(self);
    }
    if (lost != 0u) {
        extended_count_learner_event(self, &self->restarts, 1u, EXTENDED_LEARN_RESTARTED);
        extended_restart(self);
    }
    self->fresh = 0u;
    if ((usable & (u_lost ^ 1u)) != 0u) {
        extended_store_regressors(self, y, w);
    }
    self->rested = (uint32_t)(extended_float(extended_bits(away) & 0x7fffffffu) < EXTENDED_LEARN_REST_V);
    self->mean_u_V = extended_flushed(self->mean_u_V + EXTENDED_LEARN_FAST * away);
    self->u_V = u;
}

EXTENDED_CODE
void extended_learn_init(extended_learner_t *self, const extended_t *model)
{
    const extended_bank_t *bank = &model->bank[model->active];

    for (uint32_t l = 0u; l < EXTENDED_BANK_RULES; ++l) {
        self->base.slope[l] = bank->slope[l];
        self->base.offset[l] = bank->offset[l];
        self->base.gain[l] = bank->gain[l];
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
    extended_hysteresis_copy(&self->inputs.hysteresis, &model->inputs.hysteresis);
    extended_creep_copy(&self->inputs.creep, &model->inputs.creep);
    self->candidate.phase = 0u;
    self->candidate.point = 0u;
    extended_restart(self);
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
EXTENDED_CODE
static void extended_bound_remainders(extended_candidate_t *candidate)
{
    const extended_bank_t *bank = &candidate->bank;
    const float common = EXTENDED_COMMIT_SLOPE_REMAINDER_1 * extended_half_span(bank, 1.0f, 0.0f, 0.0f);
    const float low = extended_greater(
        extended_half_span(bank, EXTENDED_Y_MIN_UM, EXTENDED_W_MIN, 1.0f), extended_half_span(bank, EXTENDED_Y_MAX_UM, EXTENDED_W_MIN, 1.0f));
    const float high = extended_greater(
        extended_half_span(bank, EXTENDED_Y_MIN_UM, EXTENDED_W_MAX, 1.0f), extended_half_span(bank, EXTENDED_Y_MAX_UM, EXTENDED_W_MAX, 1.0f));

    candidate->gain_remainder_um_per_V = EXTENDED_COMMIT_GAIN_REMAINDER * extended_half_span(bank, 0.0f, 1.0f, 0.0f);
    candidate->slope_remainder[0] = common + EXTENDED_COMMIT_SLOPE_REMAINDER_3 * low;
    candidate->slope_remainder[1] = common + EXTENDED_COMMIT_SLOPE_REMAINDER_3 * high;
}

/* Take the shadow as it is now. */
EXTENDED_CODE
static uint32_t extended_snapshot(extended_learner_t *learner)
{
    extended_candidate_t *candidate = &learner->candidate;
    uint32_t beyond = 0u;

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
    if (beyond != 0u) {
        return EXTENDED_REFUSED_LIMIT;
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
EXTENDED_CODE
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
    const uint32_t steep = extended_too_steep(slope + b1 * EXTENDED_W_MIN, curve + b2 * EXTENDED_W_MIN, candidate->slope_remainder[0])
        | extended_too_steep(slope + b1 * EXTENDED_W_MAX, curve + b2 * EXTENDED_W_MAX, candidate->slope_remainder[1]);
    const uint32_t weak = (uint32_t)(gain - away <= EXTENDED_COMMIT_GAIN_FLOOR) | (uint32_t)(gain + away >= EXTENDED_COMMIT_GAIN_CEILING);

    if (weak != 0u) {
        return EXTENDED_REFUSED_GAIN;
    }
    return (steep != 0u) ? EXTENDED_REFUSED_SLOPE : EXTENDED_BUSY;
}

/* Write the candidate into the bank that is not in use. */
EXTENDED_CODE
static void extended_write(extended_t *self, const extended_candidate_t *candidate)
{
    extended_bank_t *idle = &self->bank[1u - self->active];

    for (uint32_t l = 0u; l < EXTENDED_BANK_RULES; ++l) {
        idle->slope[l] = candidate->bank.slope[l];
        idle->offset[l] = candidate->bank.offset[l];
        idle->gain[l] = candidate->bank.gain[l];
    }
}

/* Writing and making active are two calls: whatever interrupts in between sees a bank that is whole. */
EXTENDED_CODE
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
        candidate->phase = 0u;
        answer = EXTENDED_COMMITTED;
        break;
    }
    return answer;
}
