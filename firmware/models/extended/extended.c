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

/** Events at the inputs during one call, 1 if the event occurred and 0 if not. */
typedef struct {
    uint32_t y_clamped;   /**< y was outside its range and was limited. */
    uint32_t u_clamped;   /**< u was outside its range and was limited. */
    uint32_t y_rejected;  /**< y was not finite and was replaced. */
    uint32_t u_rejected;  /**< u was not finite and was replaced. */
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

/** The range of the inverse's voltage at one sample. */
typedef struct {
    float low;   /**< Lowest voltage [V]. */
    float high;  /**< Highest voltage [V]. */
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
    float slope;   /**< Sum of v_l q_l1. */
    float offset;  /**< Sum of v_l q_l3 [um]. */
    float gain;    /**< Sum of v_l q_l2. */
    float weight;  /**< Sum of v_l. */
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

/* missed / slope, relative error at most 0.27 %: a Newton step converges with it by a factor of 370 or more. */
EXTENDED_INLINE float extended_hysteresis_rough_quotient(float missed, float slope)
{
    const float r = extended_float(0x7ef311c7u - extended_bits(slope));

    return (missed * r) * (2.0f - slope * r);
}

/** h [um] and dh/dx [um per half range]. */
typedef struct {
    float um;     /**< Output h, or a part of it [um]. */
    float slope;  /**< Derivative of `um` by the input [um per half range]. */
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
    const float size = extended_hysteresis_magnitude(d);
    const float twice = duhem[1] + duhem[1];
    const extended_hysteresis_ahead_t found = { d * (duhem[0] + duhem[1] * size), (duhem[0] + twice * size) * (ahead * duhem[2]) };

    return found;
}

/* The voltage for which extended_hysteresis_apply would return `wanted`; the state does not change. 4 Newton steps
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
    for (uint32_t step = 0u; step < 4u; ++step) {
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

        missed = missed + d0.um;
        slope = slope + d0.slope;
        missed = missed + d1.um;
        slope = slope + d1.slope;
        missed = missed + d2.um;
        slope = slope + d2.slope;
        missed = missed + d3.um;
        slope = slope + d3.slope;
        missed = missed + d4.um;
        slope = slope + d4.slope;
        slope = extended_limited(slope, extended_hysteresis_range[3], extended_hysteresis_range[4], &beyond);
        x = extended_limited(x - extended_hysteresis_rough_quotient(missed, slope), start, 1.0f, &beyond);
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
    float w;               /**< Input of the rules that follows from the command. */
    uint32_t u_clamped;    /**< 1 if the voltage was outside the span. */
    uint32_t unreachable;  /**< 1 if a limit keeps the input of the rules from the wanted one. */
    uint32_t residual;     /**< 1 if the input of the rules is not the wanted one although no limit acted. */
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

/* ---- Feedback -------------------------------------------------------------------------------------------------- */

/* Without correction, at rest, with the integral of the design. */
EXTENDED_INLINE void extended_loop_init(extended_loop_t *loop)
{
    loop->correction_um = 0.0f;
    loop->before_um = 0.0f;
    loop->half = EXTENDED_LOOP_HALF;
}

/* c(k) = c(k-1) + K/2 (f(k) + f(k-1)), f = F of the residual; it stands still at a limit that it would move beyond. */
EXTENDED_CODE
float extended_correct(extended_t *self, float residual_um)
{
    extended_events_t events = { 0u, 0u, 0u, 0u };
    const float finite = extended_finite(residual_um, 0.0f, &events.y_rejected);
    const float residual = extended_limited(finite, -EXTENDED_LOOP_REACH_UM, EXTENDED_LOOP_REACH_UM, &events.y_clamped);
    const float before = self->loop.correction_um;
    const float moves = residual;
    const float step = extended_flushed(self->loop.half * (moves + self->loop.before_um));
    const uint32_t at_top = (uint32_t)(self->u_V >= self->high_V);
    const uint32_t at_bottom = (uint32_t)(self->u_V <= self->low_V);
    const uint32_t winds = (at_top & (uint32_t)(step > 0.0f)) | (at_bottom & (uint32_t)(step < 0.0f));
    uint32_t limited;
    const float moved = extended_flushed(extended_limited(before + step, -EXTENDED_LOOP_LIMIT_UM, EXTENDED_LOOP_LIMIT_UM, &limited));
    const float correction = (winds != 0u) ? before : moved;

    self->loop.before_um = moves;
    self->loop.correction_um = correction;
    extended_count_events(self, &events);
    return correction;
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
    extended_loop_init(&self->loop);
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

/* ---- Learner ---------------------------------------------------------------------------------------------------- */

/* Advice for gcc on the C674x, which overlaps operations of a basic block only: it unrolls the loops over parameters and
 * rules, schedules each function alone, and keeps the order of the loads. For the same reason these loops write local
 * arrays, which nothing else can alias, and copy them at the end. The bits do not depend on the advice. */
#if defined(_TMS320C6X) && defined(__GNUC__)
#define EXTENDED_UNROLL _Pragma("GCC unroll 153")
#define EXTENDED_ALONE __attribute__((noinline, optimize("no-tree-ter")))
#else
#define EXTENDED_UNROLL
#define EXTENDED_ALONE
#endif

/* 1.5 * 2^23 times the grids of regressors (2^-30), U (2^-30), g (2^-60) and steps of theta (2^-45). */
#define EXTENDED_REGRESSOR_GRID  0.01171875f
#define EXTENDED_FACTOR_GRID     0.01171875f
#define EXTENDED_GAIN_GRID       1.09139364e-11f
#define EXTENDED_STEP_GRID       3.57627869e-07f

/** How an update goes on behind its diagonal. */
typedef enum {
    EXTENDED_UPDATE_SKIPPED = 0,    /**< The sample is an outlier or inside the dead zone; P and theta stay. */
    EXTENDED_UPDATE_CONTINUES = 1,  /**< The diagonal is updated; U and theta follow. */
    EXTENDED_UPDATE_RESTARTS = 2    /**< alpha is beyond its limit; the shadow restarts. */
} extended_outcome_t;

/* x rounded to a multiple of the grid that the constant EXTENDED_..._GRID belongs to: no stored word is denormal. */
EXTENDED_INLINE float extended_on_grid(float x, float grid)
{
    return (x + grid) - grid;
}

/* |x| as bits, which have the order of the magnitudes. */
EXTENDED_INLINE uint32_t extended_size(float x)
{
    return extended_bits(x) & 0x7fffffffu;
}

/* 1 if a parameter is not finite or beyond its limit. */
EXTENDED_INLINE uint32_t extended_beyond(float theta)
{
    return (uint32_t)(extended_size(theta) >= extended_bits(EXTENDED_LEARN_LIMIT_UM));
}

/* Set the bit of an event in the status word and increment its counter, which stops at its largest value. */
EXTENDED_INLINE void extended_count_learner_event(
    extended_learner_t *self, uint32_t *counter, uint32_t happened, uint32_t flag)
{
    self->status |= extended_mask(happened) & flag;
    *counter += happened & (uint32_t)(*counter < UINT32_MAX);
}

/* U = I. */
EXTENDED_CODE
static void extended_clear(extended_learner_t *self)
{
    EXTENDED_UNROLL
    for (uint32_t i = 0u; i < EXTENDED_FACTORS; ++i) {
        self->u[i] = 0.0f;
    }
}

/* The shadow becomes the reference parameters, and P the prior: U = I, D = alpha. */
EXTENDED_CODE
static void extended_restart(extended_learner_t *self)
{
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        self->theta[j] = self->reference[j];
        self->theta_low[j] = 0.0f;
        self->d[j] = extended_learn_prior[j];
    }
    extended_clear(self);
    self->scale_um = EXTENDED_LEARN_LEVEL_UM;
    self->moving_um = EXTENDED_LEARN_LEVEL_UM;
    self->error = 0.0f;
    self->reference_error = 0.0f;
    self->step_error = 0.0f;
    self->run = 0u;
    self->age = 0u;
}

/* ---- Learner: the update, P = U D U' --------------------------------------------------------------------------- */

/* Index of U_ij, i < j, in the packed columns. */
EXTENDED_INLINE uint32_t extended_place(uint32_t i, uint32_t j)
{
    return ((j * (j - 1u)) >> 1) + i;
}

/* f = U' x and g = D f with D / lambda:  f_j = sum_{i<j} U_ij x_i + x_j. Row i of U adds to every f_j behind it. */
EXTENDED_CODE
static EXTENDED_ALONE void extended_project(extended_learner_t *self)
{
    float f[EXTENDED_LEARNED];

    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        f[j] = 0.0f;
    }
    EXTENDED_UNROLL
    for (uint32_t i = 0u; i < EXTENDED_LEARNED; ++i) {
        f[i] = f[i] + self->x[i];
        EXTENDED_UNROLL
        for (uint32_t j = i + 1u; j < EXTENDED_LEARNED; ++j) {
            f[j] = f[j] + self->u[extended_place(i, j)] * self->x[i];
        }
    }
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        self->f[j] = f[j];
        self->g[j] = extended_on_grid((self->d[j] * self->inflate) * f[j], EXTENDED_GAIN_GRID);
    }
}

/* U and k = P x. In column j, over the rows i < j:
 *     U_ij <- U_ij + k_i l_j,  k_i <- k_i + U_ij g_j with the old U_ij,  then k_j = g_j.
 * One loop reads U and the next one writes it, so that the rows of a column can overlap. */
EXTENDED_CODE
static EXTENDED_ALONE void extended_factor(extended_learner_t *self)
{
    float k[EXTENDED_LEARNED];

    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        const float l = self->l[j];
        const float g = self->g[j];
        float u[EXTENDED_LEARNED];
        float moved[EXTENDED_LEARNED];

        EXTENDED_UNROLL
        for (uint32_t i = 0u; i < j; ++i) {
            u[i] = self->u[extended_place(i, j)];
            moved[i] = u[i] + k[i] * l;
        }
        EXTENDED_UNROLL
        for (uint32_t i = 0u; i < j; ++i) {
            k[i] = k[i] + u[i] * g;
            self->u[extended_place(i, j)] = extended_on_grid(moved[i], EXTENDED_FACTOR_GRID);
        }
        k[j] = g;
    }
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        self->k[j] = k[j];
    }
}

/* 1 if the shadow learns from the sample, 0 for an outlier and for an innovation in the dead zone. The limit of the
 * innovation is that of the usual one times sqrt(alpha), alpha = 1 + x' P x: its variance is alpha times that of the noise. */
EXTENDED_CODE
static uint32_t extended_admit(extended_learner_t *self, float alpha)
{
    const float e = self->innovation_um;
    const float size = extended_float(extended_size(e));
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

/* 1/alpha_j for every parameter. */
EXTENDED_CODE
static EXTENDED_ALONE void extended_reciprocals(const float *alpha, float *per_alpha)
{
    float found[EXTENDED_LEARNED];

    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        found[j] = extended_reciprocal(alpha[j]);
    }
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        per_alpha[j] = found[j];
    }
}

/* D becomes d, limited to positive values below the ceiling. Returns 1 if an element was limited. */
EXTENDED_CODE
static EXTENDED_ALONE uint32_t extended_store_diagonal(extended_learner_t *self, const float *d)
{
    float kept[EXTENDED_LEARNED];
    uint32_t clamped = 0u;

    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        uint32_t limited;

        kept[j] = extended_limited(d[j], EXTENDED_LEARN_LEAST_VARIANCE, extended_learn_ceiling[j], &limited);
        clamped |= limited;
    }
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        self->d[j] = kept[j];
    }
    return clamped;
}

/* alpha, l and D from f and g, for alpha_(-1) = 1:
 *     alpha_j = alpha_(j-1) + f_j g_j,  l_j = -f_j / alpha_(j-1),  D_j <- D_j / lambda * alpha_(j-1) / alpha_j */
EXTENDED_CODE
static EXTENDED_ALONE extended_outcome_t extended_update_diagonal(extended_learner_t *self)
{
    float alpha[EXTENDED_LEARNED];
    float per_alpha[EXTENDED_LEARNED];
    float d[EXTENDED_LEARNED];
    float l[EXTENDED_LEARNED];
    float before = 1.0f;
    float per_before = 1.0f;
    extended_outcome_t outcome;

    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        alpha[j] = before + self->f[j] * self->g[j];
        before = alpha[j];
    }
    /* The comparison of bits is true for infinity and NaN, too: all accuracy of U and D is lost. */
    if (extended_bits(before) >= extended_bits(EXTENDED_LEARN_LARGEST_DENOMINATOR)) {
        outcome = EXTENDED_UPDATE_RESTARTS;
    } else if ((self->measuring != 0u) && (extended_admit(self, before) == 0u)) {
        outcome = EXTENDED_UPDATE_SKIPPED;
    } else {
        outcome = EXTENDED_UPDATE_CONTINUES;
    }
    if (outcome != EXTENDED_UPDATE_CONTINUES) {
        return outcome;
    }
    extended_reciprocals(alpha, per_alpha);
    before = 1.0f;
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        l[j] = -(self->f[j] * per_before);
        d[j] = (self->d[j] * self->inflate) * (before * per_alpha[j]);
        before = alpha[j];
        per_before = per_alpha[j];
    }
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        self->l[j] = l[j];
    }
    self->per_alpha = per_before;
    extended_count_learner_event(self, &self->clamped, extended_store_diagonal(self, d), EXTENDED_LEARN_CLAMPED);
    return EXTENDED_UPDATE_CONTINUES;
}

/* theta <- theta + k q,  q = innovation / alpha,  k = P x. q is reduced if a parameter would move beyond its limit per
 * step. theta is the sum of two words, because most steps are smaller than its last bit. Returns 1 if a parameter is
 * beyond its limit: the shadow restarts. */
EXTENDED_CODE
static EXTENDED_ALONE uint32_t extended_step(extended_learner_t *self)
{
    float q = self->innovation_um * self->per_alpha;
    uint32_t largest = 0u;
    uint32_t beyond = 0u;
    float size;

    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        const uint32_t k = extended_size(self->k[j]);

        largest = (k > largest) ? k : largest;
    }
    size = extended_float(largest) * extended_float(extended_size(q));
    if (size > EXTENDED_LEARN_STEP_UM) {
        q = q * (EXTENDED_LEARN_STEP_UM * extended_reciprocal(size));
        extended_count_learner_event(self, &self->limited, 1u, EXTENDED_LEARN_LIMITED);
    }
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        const float theta = self->theta[j];
        const float carried = self->theta_low[j] + extended_on_grid(self->k[j] * q, EXTENDED_STEP_GRID);
        const float sum = theta + carried;

        self->theta_low[j] = carried - (sum - theta);
        self->theta[j] = sum;
        beyond |= extended_beyond(sum);
    }
    self->age += self->measuring & (uint32_t)(self->age < UINT32_MAX);
    extended_count_learner_event(self, &self->updates, beyond ^ 1u, 0u);
    return beyond;
}

/* One update of P and theta. Returns 1 if the shadow restarts. */
EXTENDED_INLINE uint32_t extended_update(extended_learner_t *self)
{
    extended_outcome_t outcome;
    uint32_t lost;

    extended_project(self);
    outcome = extended_update_diagonal(self);
    lost = (uint32_t)(outcome == EXTENDED_UPDATE_RESTARTS);
    if (outcome == EXTENDED_UPDATE_CONTINUES) {
        extended_factor(self);
        lost = extended_step(self);
    }
    return lost;
}

/* ---- Learner: samples ------------------------------------------------------------------------------------------ */

/* Innovation of the displacement y, e = y - x' theta - fixed, that of the reference parameters and that of the copy on trial. */
EXTENDED_CODE
static EXTENDED_ALONE float extended_innovations(const extended_learner_t *self, float y, float *reference, float *tried)
{
    float shadow = 0.0f;
    float other = 0.0f;
    float copy = 0.0f;

    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        shadow = shadow + self->x[j] * self->theta[j];
        other = other + self->x[j] * self->reference[j];
        copy = copy + self->x[j] * self->trial[j];
    }
    *reference = y - (other + self->fixed_um);
    *tried = y - (copy + self->fixed_um);
    return y - (shadow + self->fixed_um);
}

/* The innovations of a trial, none larger than that of an outlier, add up as they do in a free run. */
EXTENDED_INLINE void extended_try(extended_learner_t *self, float tried, float reference)
{
    uint32_t cut;
    const float gate = EXTENDED_LEARN_GATE * self->scale_um + (2.0f * self->moving_um + EXTENDED_LEARN_GATE_FLOOR_UM);
    const float limit = extended_float(extended_size(gate));
    const float mine = EXTENDED_LEARN_CARRIED * self->trial_um + extended_limited(tried, -limit, limit, &cut);
    const float others = EXTENDED_LEARN_CARRIED * self->trial_reference_um + extended_limited(reference, -limit, limit, &cut);

    self->trying -= (uint32_t)(self->trying != 0u);
    self->trial_um = extended_flushed(mine);
    self->trial_reference_um = extended_flushed(others);
    self->trial_error = self->trial_error + EXTENDED_LEARN_SLOW * ((mine * mine + EXTENDED_LEARN_FLOOR_SQUARE) - self->trial_error);
    self->trial_reference_error = self->trial_reference_error
        + EXTENDED_LEARN_SLOW * ((others * others + EXTENDED_LEARN_FLOOR_SQUARE) - self->trial_reference_error);
}

/* Update the running means. Returns 1 if the shadow, after its settling time, has a larger mean square innovation than
 * the reference parameters or than y(k+1) = y(k), times a limit each. */
EXTENDED_INLINE uint32_t extended_restart_needed(extended_learner_t *self, float e, float reference, float moved)
{
    const float size = extended_float(extended_size(moved)) + EXTENDED_LEARN_FLOOR_UM;
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

/* Prepare one update: with the sample, or, every EXTENDED_LEARN_REFRESH_EVERY updates, with the pseudo-measurement
 * w reference_j = w theta_j, which restores the prior information of parameter j that forgetting removed. */
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

        for (uint32_t i = 0u; i < EXTENDED_LEARNED; ++i) {
            self->x[i] = 0.0f;
        }
        self->x[j] = extended_learn_refresh[j];
        self->inflate = 1.0f;
        self->innovation_um = extended_learn_refresh[j] * (self->reference[j] - self->theta[j]);
        self->turn = (j + 1u < EXTENDED_LEARNED) ? j + 1u : 0u;
        self->since_refresh = 0u;
    }
}

/* Compare the displacement y with the prediction from sample k - 1. Returns 1 if the shadow restarts; *begun becomes 1
 * if an update begins. */
EXTENDED_INLINE uint32_t extended_evaluate_reading(
    extended_learner_t *self, float y, float *innovation, uint32_t *begun)
{
    float reference;
    float tried;
    uint32_t lost = 0u;

    *innovation = extended_innovations(self, y, &reference, &tried);
    extended_count_learner_event(self, &self->resting, self->rested, EXTENDED_LEARN_RESTING);
    if (self->rested == 0u) {
        extended_try(self, tried, reference);
        lost = extended_restart_needed(self, *innovation, reference, y - self->y_um);
        if (lost == 0u) {
            extended_begin(self, *innovation);
            *begun = 1u;
        }
    }
    return lost;
}

/* Keep the regressors of sample k for the displacement of sample k + 1:  x = phi / scale. The regressors of rule l are
 * p_l y, p_l u and p_l with p_l = w_l r^l / W; the strength w_l is part of the numbers in a bank. */
EXTENDED_CODE
static EXTENDED_ALONE void extended_store_regressors(extended_learner_t *self, float y_um, float u)
{
    uint32_t outside;
    const float y = extended_limited(y_um, EXTENDED_Y_MIN_UM, EXTENDED_Y_MAX_UM, &outside);
    const extended_sums_t sums = extended_rule_sums(&self->base, y);
    const float per_weight = extended_reciprocal(sums.weight);
    const float r = extended_power_of_two((y - EXTENDED_ORIGIN_UM) * EXTENDED_PER_STEP);
    const float y_share = y * EXTENDED_LEARN_PER_Y;
    const float u_share = u * EXTENDED_LEARN_PER_U;
    float power[EXTENDED_RULES];

    power[0] = 1.0f;
    power[1] = r;
    EXTENDED_UNROLL
    for (uint32_t l = 2u; l < EXTENDED_RULES; ++l) {
        power[l] = power[l >> 1] * power[l - (l >> 1)];
    }

    self->fixed_um = 0.0f;
    EXTENDED_UNROLL
    for (uint32_t l = 0u; l < EXTENDED_RULES; ++l) {
        const float firing = (power[l] * per_weight) * extended_learn_firing[l];

        self->x[3u * l] = extended_on_grid(firing * y_share, EXTENDED_REGRESSOR_GRID);
        self->x[3u * l + 1u] = extended_on_grid(firing * u_share, EXTENDED_REGRESSOR_GRID);
        self->x[3u * l + 2u] = extended_on_grid(firing, EXTENDED_REGRESSOR_GRID);
    }
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
    self->rested = (uint32_t)(extended_float(extended_size(away)) < EXTENDED_LEARN_REST_V);
    self->mean_u_V = extended_flushed(self->mean_u_V + EXTENDED_LEARN_FAST * away);
    self->u_V = u;
}

EXTENDED_CODE
void extended_learn_init(extended_learner_t *self, const extended_t *model)
{
    const extended_bank_t *bank = &model->bank[model->active];

    EXTENDED_UNROLL
    for (uint32_t l = 0u; l < EXTENDED_BANK_RULES; ++l) {
        self->base.slope[l] = bank->slope[l];
        self->base.offset[l] = bank->offset[l];
        self->base.gain[l] = bank->gain[l];
    }
    EXTENDED_UNROLL
    for (uint32_t l = 0u; l < EXTENDED_RULES; ++l) {
        self->reference[3u * l] = self->base.slope[l] * extended_learn_scale[3u * l];
        self->reference[3u * l + 1u] = self->base.gain[l] * extended_learn_scale[3u * l + 1u];
        self->reference[3u * l + 2u] = self->base.offset[l] * extended_learn_scale[3u * l + 2u];
    }
    for (uint32_t i = 0u; i < EXTENDED_LEARNED; ++i) {
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
    self->inputs.v_V = model->inputs.v_V;
    extended_delay_copy(&self->inputs.delay, &model->inputs.delay);
    extended_hysteresis_copy(&self->inputs.hysteresis, &model->inputs.hysteresis);
    extended_creep_copy(&self->inputs.creep, &model->inputs.creep);
    self->candidate.phase = (uint32_t)EXTENDED_PHASE_IDLE;
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

/* y q1 + u q2 + one q3 of rule l; the table takes the rule's strength off the numbers in the bank. */
EXTENDED_INLINE float extended_rule_value(const extended_bank_t *bank, uint32_t l, float y, float u, float one)
{
    return ((y * bank->slope[l] + u * bank->gain[l]) + one * bank->offset[l]) * extended_commit_unfold[l];
}

/* Half the difference between the largest and the smallest y q1 + u q2 + one q3 of a rule. */
EXTENDED_INLINE float extended_half_span(const extended_bank_t *bank, float y, float u, float one)
{
    float least = extended_rule_value(bank, 0u, y, u, one);
    float most = least;

    EXTENDED_UNROLL
    for (uint32_t l = 1u; l < EXTENDED_RULES; ++l) {
        const float value = extended_rule_value(bank, l, y, u, one);

        least = extended_lesser(least, value);
        most = extended_greater(most, value);
    }
    return 0.5f * (most - least);
}

/* Bounds of the Taylor remainders of gain and slope between the check points, for the parameters of the candidate. */
EXTENDED_CODE
static void extended_bound_remainders(extended_candidate_t *candidate)
{
    const extended_bank_t *bank = &candidate->bank;
    const float common = EXTENDED_COMMIT_SLOPE_REMAINDER_1 * extended_half_span(bank, 1.0f, 0.0f, 0.0f);
    const float low = extended_greater(extended_half_span(bank, EXTENDED_Y_MIN_UM, EXTENDED_W_MIN, 1.0f),
        extended_half_span(bank, EXTENDED_Y_MAX_UM, EXTENDED_W_MIN, 1.0f));
    const float high = extended_greater(extended_half_span(bank, EXTENDED_Y_MIN_UM, EXTENDED_W_MAX, 1.0f),
        extended_half_span(bank, EXTENDED_Y_MAX_UM, EXTENDED_W_MAX, 1.0f));

    candidate->gain_remainder_um_per_V = EXTENDED_COMMIT_GAIN_REMAINDER * extended_half_span(bank, 0.0f, 1.0f, 0.0f);
    candidate->slope_remainder[0] = common + EXTENDED_COMMIT_SLOPE_REMAINDER_3 * low;
    candidate->slope_remainder[1] = common + EXTENDED_COMMIT_SLOPE_REMAINDER_3 * high;
}

/* Copy the shadow for a trial, on nothing if nothing was ever learnt, unless it is too young or a parameter is beyond its limit. */
EXTENDED_CODE
static extended_commit_t extended_snapshot(extended_learner_t *learner)
{
    extended_candidate_t *candidate = &learner->candidate;
    extended_bank_t *bank = &candidate->bank;
    uint32_t beyond = 0u;

    if (learner->age < EXTENDED_COMMIT_MATURE) {
        return EXTENDED_COMMIT_REFUSED_YOUNG;
    }
    EXTENDED_UNROLL
    for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
        learner->trial[j] = learner->theta[j];
        beyond |= extended_beyond(learner->theta[j]);
    }
    EXTENDED_UNROLL
    for (uint32_t l = 0u; l < EXTENDED_RULES; ++l) {
        bank->slope[l] = learner->theta[3u * l] * extended_learn_per_scale[3u * l];
        bank->offset[l] = learner->theta[3u * l + 2u] * extended_learn_per_scale[3u * l + 2u];
        bank->gain[l] = learner->theta[3u * l + 1u] * extended_learn_per_scale[3u * l + 1u];
    }
    if (beyond != 0u) {
        return EXTENDED_COMMIT_REFUSED_LIMIT;
    }
    extended_bound_remainders(candidate);
    learner->trial_um = 0.0f;
    learner->trial_reference_um = 0.0f;
    learner->trial_error = 0.0f;
    learner->trial_reference_error = 0.0f;
    learner->trying = (learner->updates != 0u) ? (uint32_t)EXTENDED_COMMIT_TRIAL : 0u;
    candidate->point = 0u;
    candidate->phase = (uint32_t)EXTENDED_PHASE_CHECK;
    return EXTENDED_COMMIT_BUSY;
}

/* 1 if |df/dy| may reach its limit within half a distance of the check points, from its value and its derivative. */
EXTENDED_INLINE uint32_t extended_too_steep(float slope, float curve, float remainder)
{
    const float change = EXTENDED_COMMIT_HALF_UM * extended_float(extended_size(curve));

    return (uint32_t)(extended_float(extended_size(slope)) + (change + remainder) >= EXTENDED_COMMIT_SLOPE_LIMIT);
}

/* Gain and slope around one check point. With f = a(y) y + b(y) u + c(y), a = sum p_l q_l1 and likewise b and c:
 *     df/dy = a + a' y + b' u + c',  d2f/dy2 = 2 a' + a'' y + b'' u + c''
 * p_l, p_l' and p_l'' at the check point stand in a row of the table. */
EXTENDED_CODE
static extended_commit_t extended_check(const extended_candidate_t *candidate)
{
    const float *p = &extended_commit_table[candidate->point * (3u * EXTENDED_RULES)];
    const float *dp = &p[EXTENDED_RULES];
    const float *ddp = &dp[EXTENDED_RULES];
    const extended_bank_t *bank = &candidate->bank;
    const float y = extended_commit_y[candidate->point];
    float a = 0.0f;
    float da = 0.0f;
    float dda = 0.0f;
    float b = 0.0f;
    float db = 0.0f;
    float ddb = 0.0f;
    float dc = 0.0f;
    float ddc = 0.0f;

    EXTENDED_UNROLL
    for (uint32_t l = 0u; l < EXTENDED_RULES; ++l) {
        a = a + p[l] * bank->slope[l];
        da = da + dp[l] * bank->slope[l];
        dda = dda + ddp[l] * bank->slope[l];
        b = b + p[l] * bank->gain[l];
        db = db + dp[l] * bank->gain[l];
        ddb = ddb + ddp[l] * bank->gain[l];
        dc = dc + dp[l] * bank->offset[l];
        ddc = ddc + ddp[l] * bank->offset[l];
    }

    const float gain = EXTENDED_COMMIT_SIGN * b;
    const float away = EXTENDED_COMMIT_HALF_UM * extended_float(extended_size(db)) + candidate->gain_remainder_um_per_V;
    const float slope = (a + da * y) + dc;
    const float curve = ((da + da) + dda * y) + ddc;
    const uint32_t steep =
        extended_too_steep(slope + db * EXTENDED_W_MIN, curve + ddb * EXTENDED_W_MIN, candidate->slope_remainder[0])
        | extended_too_steep(slope + db * EXTENDED_W_MAX, curve + ddb * EXTENDED_W_MAX, candidate->slope_remainder[1]);
    const uint32_t weak = (uint32_t)(gain - away <= EXTENDED_COMMIT_GAIN_FLOOR)
        | (uint32_t)(gain + away >= EXTENDED_COMMIT_GAIN_CEILING);

    if (weak != 0u) {
        return EXTENDED_COMMIT_REFUSED_GAIN;
    }
    return (steep != 0u) ? EXTENDED_COMMIT_REFUSED_SLOPE : EXTENDED_COMMIT_BUSY;
}

/* Copy the candidate into the bank that is not in use. */
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

/* Writing and switching are two calls: an interrupt between them finds the active bank complete. */
EXTENDED_CODE
extended_commit_t extended_commit(extended_t *self, extended_learner_t *learner)
{
    extended_candidate_t *candidate = &learner->candidate;
    extended_commit_t answer = EXTENDED_COMMIT_BUSY;

    switch (candidate->phase) {
    case (uint32_t)EXTENDED_PHASE_IDLE:
        answer = extended_snapshot(learner);
        break;
    case (uint32_t)EXTENDED_PHASE_CHECK:
        for (uint32_t i = 0u; i < 1u; ++i) {
            if ((candidate->phase == (uint32_t)EXTENDED_PHASE_CHECK) && (answer == EXTENDED_COMMIT_BUSY)) {
                answer = extended_check(candidate);
                candidate->point += 1u;
                candidate->phase += (uint32_t)(candidate->point >= EXTENDED_COMMIT_POINTS);
            }
        }
        candidate->phase = (answer == EXTENDED_COMMIT_BUSY) ? candidate->phase : (uint32_t)EXTENDED_PHASE_IDLE;
        break;
    case (uint32_t)EXTENDED_PHASE_TRIAL:
        if (learner->trying != 0u) {
            answer = EXTENDED_COMMIT_TRYING;
        } else if (learner->trial_error > learner->trial_reference_error) {
            answer = EXTENDED_COMMIT_REFUSED_WORSE;
            candidate->phase = (uint32_t)EXTENDED_PHASE_IDLE;
        } else {
            candidate->phase = (uint32_t)EXTENDED_PHASE_WRITE;
        }
        break;
    case (uint32_t)EXTENDED_PHASE_WRITE:
        extended_write(self, candidate);
        candidate->phase = (uint32_t)EXTENDED_PHASE_SWITCH;
        break;
    default:
        self->active = 1u - self->active;
        for (uint32_t j = 0u; j < EXTENDED_LEARNED; ++j) {
            learner->reference[j] = learner->trial[j];
        }
        candidate->phase = (uint32_t)EXTENDED_PHASE_IDLE;
        answer = EXTENDED_COMMIT_COMMITTED;
        break;
    }
    return answer;
}
