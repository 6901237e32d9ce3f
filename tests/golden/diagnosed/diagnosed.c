/* diagnosed.c: the algorithm of model `diagnosed`; changes only with the model's structure. Interface: diagnosed.h. */

#include "diagnosed.h"

/* Equal bits on every machine rest on float32 operations as they are written: no shortcuts, no wider intermediate
 * results, no multiplication fused with an addition. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#error "diagnosed: compile without -ffast-math and its parts"
#endif
#if defined(__FLT_EVAL_METHOD__)
#if __FLT_EVAL_METHOD__ != 0
#error "diagnosed: float must be evaluated as float (on x86: -msse2 -mfpmath=sse)"
#endif
#endif

#include <float.h>
#include <limits.h>

#if CHAR_BIT != 8 || FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MIN_EXP != -125 || FLT_MAX_EXP != 128
#error "diagnosed: needs bytes of 8 bits, and float in the 32-bit format of IEEE 754"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__GNUC__)
#define DIAGNOSED_INLINE static inline __attribute__((always_inline))
#else
#define DIAGNOSED_INLINE DIAGNOSED_CODE static inline
#endif

#define DIAGNOSED_NUMBERS
#include "diagnosed_params.h"

/* ---- Arithmetic ---------------------------------------------------------------------------------------------- */

DIAGNOSED_INLINE uint32_t diagnosed_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

DIAGNOSED_INLINE float diagnosed_float(uint32_t bits)
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
DIAGNOSED_INLINE float diagnosed_power_of_two(float x)
{
    const float shifted = x + 12582912.0f;
    const float f = x - (shifted - 12582912.0f);
    const float square = f * f;
    const float fourth = square * square;
    const float low = 1.0f + 0.693147182f * f;
    const float middle = 0.240226477f + 0.0555035993f * f;
    const float high = (0.00961850584f + 0.00133908063f * f) + 0.000153264715f * square;
    const float mantissa = low + (square * middle + fourth * high);

    return diagnosed_float(diagnosed_bits(mantissa) + (diagnosed_bits(shifted) << 23));
}

/* 1/x for 2^-120 <= |x| <= 2^120, relative error at most 1.5e-07: a seed from the bits, then 3 Newton steps
 *     r <- r (2 - x r) */
DIAGNOSED_INLINE float diagnosed_reciprocal(float x)
{
    float r = diagnosed_float(0x7ef311c7u - diagnosed_bits(x));

    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);

    return r;
}

/* ---- Input checks: constant time, by masks --------------------------------------------------------------------- */

/* All ones if the condition is 1, else 0. */
DIAGNOSED_INLINE uint32_t diagnosed_mask(uint32_t condition)
{
    return 0u - condition;
}

/** Events at the inputs during one call, 1 if the event occurred and 0 if not. */
typedef struct {
    uint32_t y_clamped;   /**< y was outside its range and was limited. */
    uint32_t u_clamped;   /**< u was outside its range and was limited. */
    uint32_t y_rejected;  /**< y was not finite and was replaced. */
    uint32_t u_rejected;  /**< u was not finite and was replaced. */
} diagnosed_events_t;

DIAGNOSED_INLINE uint32_t diagnosed_counted(uint32_t counter, uint32_t happened)
{
    return counter + (happened & (uint32_t)(counter < UINT32_MAX));
}

/* Status bits and counters of one call. Called last: the counting fills the slots that the arithmetic leaves free. */
DIAGNOSED_INLINE void diagnosed_count_events(diagnosed_t *self, const diagnosed_events_t *events)
{
    self->status |= (events->y_clamped * DIAGNOSED_STATUS_Y_CLAMPED) | (events->u_clamped * DIAGNOSED_STATUS_U_CLAMPED)
        | (events->y_rejected * DIAGNOSED_STATUS_Y_REJECTED) | (events->u_rejected * DIAGNOSED_STATUS_U_REJECTED);
    self->y_clamped = diagnosed_counted(self->y_clamped, events->y_clamped);
    self->u_clamped = diagnosed_counted(self->u_clamped, events->u_clamped);
    self->y_rejected = diagnosed_counted(self->y_rejected, events->y_rejected);
    self->u_rejected = diagnosed_counted(self->u_rejected, events->u_rejected);
}

/* x, or the value held if x is not finite; magnitudes below 2^-40 become 0, so that denormal numbers never occur. */
DIAGNOSED_INLINE float diagnosed_finite(float x, float held, uint32_t *rejected)
{
    const uint32_t bits = diagnosed_bits(x);
    const uint32_t magnitude = bits & 0x7fffffffu;
    const uint32_t infinite = (uint32_t)(magnitude >= 0x7f800000u);
    const uint32_t keep = diagnosed_mask((uint32_t)(magnitude >= 0x2b800000u));
    const uint32_t hold = diagnosed_mask(infinite);

    *rejected = infinite;
    return diagnosed_float((bits & keep & ~hold) | (diagnosed_bits(held) & hold));
}

/* A result before it leaves or is kept: magnitudes below 2^-40 become 0. */
DIAGNOSED_INLINE float diagnosed_flushed(float x)
{
    const uint32_t bits = diagnosed_bits(x);

    return diagnosed_float(bits & diagnosed_mask((uint32_t)((bits & 0x7fffffffu) >= 0x2b800000u)));
}

/* A state before it is kept: 0 if it is not finite or its magnitude reaches the limit, which no sound state does. */
DIAGNOSED_INLINE float diagnosed_inside(float x, float limit)
{
    const uint32_t bits = diagnosed_bits(x);

    return diagnosed_float(bits & diagnosed_mask((uint32_t)((bits & 0x7fffffffu) < diagnosed_bits(limit))));
}

/* x limited to [low, high]. */
DIAGNOSED_INLINE float diagnosed_limited(float x, float low, float high, uint32_t *clamped)
{
    const uint32_t below = (uint32_t)(x < low);
    const uint32_t above = (uint32_t)(x > high);
    const uint32_t raise = diagnosed_mask(below);
    const uint32_t lower = diagnosed_mask(above);

    *clamped = below | above;
    return diagnosed_float(
        (diagnosed_bits(x) & ~(raise | lower)) | (diagnosed_bits(low) & raise) | (diagnosed_bits(high) & lower));
}

/** The range of the inverse's voltage at one sample. */
typedef struct {
    float low;   /**< Lowest voltage [V]. */
    float high;  /**< Highest voltage [V]. */
} diagnosed_span_t;

/* low_V .. high_V, and at most step_V from the voltage before. */
DIAGNOSED_INLINE diagnosed_span_t diagnosed_span(const diagnosed_t *self, float last_V)
{
    const float least = self->low_V;
    const float most = self->high_V;
    const float down = last_V - self->step_V;
    const float up = last_V + self->step_V;
    const float low = (down < least) ? least : down;
    const float high = (up < least) ? least : up;
    diagnosed_span_t span;

    span.low = (low > most) ? most : low;
    span.high = (high > most) ? most : high;
    return span;
}

/* The voltage of the span that is nearest to x. */
DIAGNOSED_INLINE float diagnosed_allowed(float x, diagnosed_span_t span, uint32_t *clamped)
{
    const float low = span.low;
    const float high = span.high;
    const float raised = (x < low) ? low : x;
    const float allowed = (raised > high) ? high : raised;

    *clamped = (uint32_t)(allowed < x) | (uint32_t)(allowed > x);
    return allowed;
}

/* A displacement inside the identified range, whatever came in. */
DIAGNOSED_INLINE float diagnosed_checked_y(const diagnosed_t *self, float y_um, diagnosed_events_t *events)
{
    const float finite = diagnosed_finite(y_um, self->y_um, &events->y_rejected);

    return diagnosed_limited(finite, DIAGNOSED_Y_MIN_UM, DIAGNOSED_Y_MAX_UM, &events->y_clamped);
}

/* A voltage inside the input range, whatever came in. */
DIAGNOSED_INLINE float diagnosed_checked_u(const diagnosed_t *self, float u_V, diagnosed_events_t *events)
{
    const float finite = diagnosed_finite(u_V, self->u_V, &events->u_rejected);

    return diagnosed_limited(finite, DIAGNOSED_U_MIN_V, DIAGNOSED_U_MAX_V, &events->u_clamped);
}

/* ---- Rules ----------------------------------------------------------------------------------------------------- */

/** Sums over the rules; v_l are the unnormalised memberships, p_l = v_l / weight. */
typedef struct {
    float slope;   /**< Sum of v_l q_l1. */
    float offset;  /**< Sum of v_l q_l3 [um]. */
    float gain;    /**< Sum of v_l q_l2. */
    float weight;  /**< Sum of v_l. */
} diagnosed_sums_t;

/* Neighbouring rules' strengths differ by r = exp((y - middle) / h) and constants, so each sum over the rules is a
 * polynomial in r of degree 5, evaluated by Estrin's scheme: its chains are the shortest. y inside the range. */
DIAGNOSED_INLINE diagnosed_sums_t diagnosed_rule_sums(const diagnosed_bank_t *bank, float y)
{
    const float r = diagnosed_power_of_two((y - DIAGNOSED_ORIGIN_UM) * DIAGNOSED_PER_STEP);
    const float r2 = r * r;
    const float r4 = r2 * r2;
    diagnosed_sums_t sums;

    const float w0_1 = diagnosed_strength[0] + diagnosed_strength[1] * r;
    const float w2_3 = diagnosed_strength[2] + diagnosed_strength[3] * r;
    const float w4_5 = diagnosed_strength[4] + diagnosed_strength[5] * r;
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
DIAGNOSED_INLINE float diagnosed_carried(float low, float delta)
{
    const float step = (delta + 1.09139364e-11f) - 1.09139364e-11f;

    return low + step;
}

/* The new `high`. */
DIAGNOSED_INLINE float diagnosed_total(float high, float t)
{
    return diagnosed_inside(high + t, 1048576.0f);
}

/* The new `low`, the rounding error of high + t. */
DIAGNOSED_INLINE float diagnosed_lost(float high, float t)
{
    const float sum = high + t;

    return t - (sum - high);
}

/* ---- Path -------------------------------------------------------------------------------------------------------- */

DIAGNOSED_CODE
static float diagnosed_delay_init(diagnosed_delay_t *self, float u)
{
    for (uint32_t i = 0u; i < 2u; ++i) {
        self->ring[i] = u;
    }
    self->newest = 0u;
    self->wanted_V = u;
    return u;
}

DIAGNOSED_INLINE void diagnosed_delay_push(diagnosed_delay_t *self, float u)
{
    self->newest = (self->newest + 1u) & 1u;
    self->ring[self->newest] = u;
}

/* The input of so many samples ago. */
DIAGNOSED_INLINE float diagnosed_delay_past(const diagnosed_delay_t *self, uint32_t samples)
{
    return self->ring[(self->newest - samples) & 1u];
}

/* v(k) = u(k-d) + mu (u(k-d-1) - u(k-d)) */
DIAGNOSED_INLINE float diagnosed_delay_apply(diagnosed_delay_t *self, float u)
{
    self->wanted_V = u;
    diagnosed_delay_push(self, u);

    const float late = diagnosed_delay_past(self, 0u);
    const float later = diagnosed_delay_past(self, 1u);

    return late + diagnosed_delay_part[0] * (later - late);
}

/* u(k) = v(k+n-1) + mu (v(k+n) - v(k+n-1)),  n the preview */
DIAGNOSED_INLINE float diagnosed_delay_command(diagnosed_delay_t *self, float v)
{
    const float u = self->wanted_V + diagnosed_delay_part[0] * (v - self->wanted_V);

    self->wanted_V = v;
    diagnosed_delay_push(self, u);
    return u;
}

/* What arrives one sample before v of the last command: nothing that comes later changes it. */
DIAGNOSED_INLINE float diagnosed_delay_arrived(const diagnosed_delay_t *self)
{
    const float late = diagnosed_delay_past(self, 0u);
    const float later = diagnosed_delay_past(self, 1u);

    return late + diagnosed_delay_part[0] * (later - late);
}

/* x = (v - middle) / half range, limited to -1 .. 1 */
DIAGNOSED_INLINE float diagnosed_hysteresis_normalised(float v)
{
    uint32_t beyond;
    const float x = (v - diagnosed_hysteresis_range[0]) * diagnosed_hysteresis_range[2];

    return diagnosed_flushed(diagnosed_limited(x, -1.0f, 1.0f, &beyond));
}

/* g0(x) */
DIAGNOSED_INLINE float diagnosed_hysteresis_curve_um(float x)
{
    const float square = x * x;
    const float even = diagnosed_hysteresis_curve[0] + square * diagnosed_hysteresis_curve[2];
    const float odd = diagnosed_hysteresis_curve[1] + square * diagnosed_hysteresis_curve[3];

    return even + x * odd;
}

/* z <- max(x - r, min(x + r, z)) */
DIAGNOSED_INLINE float diagnosed_hysteresis_moved(float z, float x, float r)
{
    const float low = x - r;
    const float high = x + r;
    const float pulled = (z > high) ? high : z;

    return (pulled < low) ? low : pulled;
}

/* g(z) = c_1 z + c_2 z^2 + ...;  play: row of the half-width and the coefficients c_1, c_2, ... */
DIAGNOSED_INLINE float diagnosed_hysteresis_play_um(float z, const float play[4])
{
    return z * (play[1] + z * (play[2] + z * play[3]));
}

/* |x| */
DIAGNOSED_INLINE float diagnosed_hysteresis_magnitude(float x)
{
    return diagnosed_float(diagnosed_bits(x) & 0x7fffffffu);
}

/* e = exp(-|way| / reach) of the first Duhem state, at most 1. Positive floats are in the order of their bits. */
DIAGNOSED_INLINE float diagnosed_hysteresis_decay(float way)
{
    const uint32_t bits = diagnosed_bits(diagnosed_power_of_two(diagnosed_hysteresis_magnitude(way) * diagnosed_hysteresis_rate[0]));

    return diagnosed_float((bits > 0x3f800000u) ? 0x3f800000u : bits);
}

/* b d + c d |d|, the part of a Duhem state in the output;  duhem: row b, c, 1/reach */
DIAGNOSED_INLINE float diagnosed_hysteresis_duhem_um(float d, const float duhem[3])
{
    return d * (duhem[0] + duhem[1] * diagnosed_hysteresis_magnitude(d));
}

/* The Duhem states of `next`, at the input x, from those of `self`; returns their part of the output. Measured in the
 * direction of the input,
 *     d_i = 1 - left_i e_i,   e_i = exp(-2^i |x - turn| / reach)
 * where left_i is 1 - d_i at the last turn. After a turn, the direction and with it d_i change sign: left_i = back_i. */
DIAGNOSED_INLINE float diagnosed_hysteresis_followed_um(const diagnosed_hysteresis_t *self, diagnosed_hysteresis_t *next, float x)
{
    const uint32_t fell = (uint32_t)(self->last < self->turn);
    const float from_last = x - self->last;
    const float from_turn = x - self->turn;
    const uint32_t step = diagnosed_bits(from_last);
    const uint32_t falls = (step >> 31) | (fell & (uint32_t)(step == 0u));
    const uint32_t turns = falls ^ fell;
    const float side = (falls != 0u) ? -1.0f : 1.0f;
    const float way = (turns != 0u) ? from_last : from_turn;
    const float left0 = (turns != 0u) ? self->back[0] : self->left[0];
    const float left1 = (turns != 0u) ? self->back[1] : self->left[1];
    const float e0 = diagnosed_hysteresis_decay(way);
    const float e1 = e0 * e0;
    const float d0 = 1.0f - left0 * e0;
    const float d1 = 1.0f - left1 * e1;

    next->turn = (turns != 0u) ? self->last : self->turn;
    next->left[0] = left0;
    next->back[0] = 1.0f + d0;
    next->left[1] = left1;
    next->back[1] = 1.0f + d1;
    return side * (diagnosed_hysteresis_duhem_um(d0, &diagnosed_hysteresis_duhem[0]) + diagnosed_hysteresis_duhem_um(d1, &diagnosed_hysteresis_duhem[3]));
}

DIAGNOSED_CODE
static float diagnosed_hysteresis_apply(diagnosed_hysteresis_t *self, float v)
{
    const float x = diagnosed_hysteresis_normalised(v);
    float sum = 0.0f;

    const float z11 = diagnosed_hysteresis_moved(self->play[11], x, diagnosed_hysteresis_play[44]);
    self->play[11] = z11;
    const float z10 = diagnosed_hysteresis_moved(self->play[10], x, diagnosed_hysteresis_play[40]);
    self->play[10] = z10;
    const float z9 = diagnosed_hysteresis_moved(self->play[9], x, diagnosed_hysteresis_play[36]);
    self->play[9] = z9;
    const float z8 = diagnosed_hysteresis_moved(self->play[8], x, diagnosed_hysteresis_play[32]);
    self->play[8] = z8;
    const float z7 = diagnosed_hysteresis_moved(self->play[7], x, diagnosed_hysteresis_play[28]);
    self->play[7] = z7;
    const float z6 = diagnosed_hysteresis_moved(self->play[6], x, diagnosed_hysteresis_play[24]);
    self->play[6] = z6;
    sum = sum + diagnosed_hysteresis_play_um(z11, &diagnosed_hysteresis_play[44]);
    self->sum_um[11] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z10, &diagnosed_hysteresis_play[40]);
    self->sum_um[10] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z9, &diagnosed_hysteresis_play[36]);
    self->sum_um[9] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z8, &diagnosed_hysteresis_play[32]);
    self->sum_um[8] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z7, &diagnosed_hysteresis_play[28]);
    self->sum_um[7] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z6, &diagnosed_hysteresis_play[24]);
    self->sum_um[6] = sum;
    const float z5 = diagnosed_hysteresis_moved(self->play[5], x, diagnosed_hysteresis_play[20]);
    self->play[5] = z5;
    const float z4 = diagnosed_hysteresis_moved(self->play[4], x, diagnosed_hysteresis_play[16]);
    self->play[4] = z4;
    const float z3 = diagnosed_hysteresis_moved(self->play[3], x, diagnosed_hysteresis_play[12]);
    self->play[3] = z3;
    const float z2 = diagnosed_hysteresis_moved(self->play[2], x, diagnosed_hysteresis_play[8]);
    self->play[2] = z2;
    const float z1 = diagnosed_hysteresis_moved(self->play[1], x, diagnosed_hysteresis_play[4]);
    self->play[1] = z1;
    const float z0 = diagnosed_hysteresis_moved(self->play[0], x, diagnosed_hysteresis_play[0]);
    self->play[0] = z0;
    sum = sum + diagnosed_hysteresis_play_um(z5, &diagnosed_hysteresis_play[20]);
    self->sum_um[5] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z4, &diagnosed_hysteresis_play[16]);
    self->sum_um[4] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z3, &diagnosed_hysteresis_play[12]);
    self->sum_um[3] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z2, &diagnosed_hysteresis_play[8]);
    self->sum_um[2] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z1, &diagnosed_hysteresis_play[4]);
    self->sum_um[1] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z0, &diagnosed_hysteresis_play[0]);
    self->sum_um[0] = sum;
    const float memory = diagnosed_hysteresis_followed_um(self, self, x);
    const float curve = diagnosed_hysteresis_curve_um(x);
    const float h = (curve + sum) + memory;

    self->last = x;
    self->h_um = h;
    return h;
}

/* The same, with the state behind it in `next`. */
DIAGNOSED_CODE
static float diagnosed_hysteresis_ahead(const diagnosed_hysteresis_t *self, diagnosed_hysteresis_t *next, float v)
{
    next->sum_um[12] = 0.0f;
    const float x = diagnosed_hysteresis_normalised(v);
    float sum = 0.0f;

    const float z11 = diagnosed_hysteresis_moved(self->play[11], x, diagnosed_hysteresis_play[44]);
    next->play[11] = z11;
    const float z10 = diagnosed_hysteresis_moved(self->play[10], x, diagnosed_hysteresis_play[40]);
    next->play[10] = z10;
    const float z9 = diagnosed_hysteresis_moved(self->play[9], x, diagnosed_hysteresis_play[36]);
    next->play[9] = z9;
    const float z8 = diagnosed_hysteresis_moved(self->play[8], x, diagnosed_hysteresis_play[32]);
    next->play[8] = z8;
    const float z7 = diagnosed_hysteresis_moved(self->play[7], x, diagnosed_hysteresis_play[28]);
    next->play[7] = z7;
    const float z6 = diagnosed_hysteresis_moved(self->play[6], x, diagnosed_hysteresis_play[24]);
    next->play[6] = z6;
    sum = sum + diagnosed_hysteresis_play_um(z11, &diagnosed_hysteresis_play[44]);
    next->sum_um[11] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z10, &diagnosed_hysteresis_play[40]);
    next->sum_um[10] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z9, &diagnosed_hysteresis_play[36]);
    next->sum_um[9] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z8, &diagnosed_hysteresis_play[32]);
    next->sum_um[8] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z7, &diagnosed_hysteresis_play[28]);
    next->sum_um[7] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z6, &diagnosed_hysteresis_play[24]);
    next->sum_um[6] = sum;
    const float z5 = diagnosed_hysteresis_moved(self->play[5], x, diagnosed_hysteresis_play[20]);
    next->play[5] = z5;
    const float z4 = diagnosed_hysteresis_moved(self->play[4], x, diagnosed_hysteresis_play[16]);
    next->play[4] = z4;
    const float z3 = diagnosed_hysteresis_moved(self->play[3], x, diagnosed_hysteresis_play[12]);
    next->play[3] = z3;
    const float z2 = diagnosed_hysteresis_moved(self->play[2], x, diagnosed_hysteresis_play[8]);
    next->play[2] = z2;
    const float z1 = diagnosed_hysteresis_moved(self->play[1], x, diagnosed_hysteresis_play[4]);
    next->play[1] = z1;
    const float z0 = diagnosed_hysteresis_moved(self->play[0], x, diagnosed_hysteresis_play[0]);
    next->play[0] = z0;
    sum = sum + diagnosed_hysteresis_play_um(z5, &diagnosed_hysteresis_play[20]);
    next->sum_um[5] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z4, &diagnosed_hysteresis_play[16]);
    next->sum_um[4] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z3, &diagnosed_hysteresis_play[12]);
    next->sum_um[3] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z2, &diagnosed_hysteresis_play[8]);
    next->sum_um[2] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z1, &diagnosed_hysteresis_play[4]);
    next->sum_um[1] = sum;
    sum = sum + diagnosed_hysteresis_play_um(z0, &diagnosed_hysteresis_play[0]);
    next->sum_um[0] = sum;
    const float memory = diagnosed_hysteresis_followed_um(self, next, x);
    const float curve = diagnosed_hysteresis_curve_um(x);
    const float h = (curve + sum) + memory;

    next->last = x;
    next->h_um = h;
    return h;
}

/* At rest under v; returns the output. */
DIAGNOSED_CODE
static float diagnosed_hysteresis_init(diagnosed_hysteresis_t *self, float v)
{
    const float x = diagnosed_hysteresis_normalised(v);

    for (uint32_t j = 0u; j < 12u; ++j) {
        const float most = 1.0f - diagnosed_hysteresis_play[4u * j];
        uint32_t beyond;

        self->play[j] = diagnosed_limited(x, -most, most, &beyond);
    }
    self->sum_um[12] = 0.0f;
    for (uint32_t i = 0u; i < 2u; ++i) {
        self->left[i] = 1.0f;
        self->back[i] = 1.0f;
    }
    self->turn = x;
    self->last = x;
    return diagnosed_hysteresis_apply(self, v);
}

/* missed / slope, relative error at most 0.27 %: a Newton step converges with it by a factor of 370 or more. */
DIAGNOSED_INLINE float diagnosed_hysteresis_rough_quotient(float missed, float slope)
{
    const float r = diagnosed_float(0x7ef311c7u - diagnosed_bits(slope));

    return (missed * r) * (2.0f - slope * r);
}

/** h [um] and dh/dx [um per half range]. */
typedef struct {
    float um;     /**< Output h, or a part of it [um]. */
    float slope;  /**< Derivative of `um` by the input [um per half range]. */
} diagnosed_hysteresis_ahead_t;

/* Number of plays that the input has taken along when it reaches `ahead`. `taken` rises with the half-width. */
DIAGNOSED_INLINE uint32_t diagnosed_hysteresis_count(const float taken[12], float ahead)
{
    return (uint32_t)(ahead > taken[0]) + (uint32_t)(ahead > taken[1]) + (uint32_t)(ahead > taken[2]) + (uint32_t)(ahead > taken[3])
        + (uint32_t)(ahead > taken[4]) + (uint32_t)(ahead > taken[5]) + (uint32_t)(ahead > taken[6]) + (uint32_t)(ahead > taken[7])
        + (uint32_t)(ahead > taken[8]) + (uint32_t)(ahead > taken[9]) + (uint32_t)(ahead > taken[10]) + (uint32_t)(ahead > taken[11]);
}

/* c_0 + c_1 x + c_2 x^2 + ... and its derivative */
DIAGNOSED_INLINE diagnosed_hysteresis_ahead_t diagnosed_hysteresis_polynomial(const float c[4], float x)
{
    float um = c[3];
    float slope = um;

    um = c[2] + x * um;
    slope = um + x * slope;
    um = c[1] + x * um;
    slope = um + x * slope;
    um = c[0] + x * um;
    const diagnosed_hysteresis_ahead_t found = { um, slope };

    return found;
}

/* b d + c d |d| and its derivative by x, d = 1 - left e */
DIAGNOSED_INLINE diagnosed_hysteresis_ahead_t diagnosed_hysteresis_duhem_ahead(float left, float e, const float duhem[3])
{
    const float ahead = left * e;
    const float d = 1.0f - ahead;
    const float size = diagnosed_hysteresis_magnitude(d);
    const float twice = duhem[1] + duhem[1];
    const diagnosed_hysteresis_ahead_t found = { d * (duhem[0] + duhem[1] * size), (duhem[0] + twice * size) * (ahead * duhem[2]) };

    return found;
}

/* The voltage for which diagnosed_hysteresis_apply would return `wanted`; the state does not change. 3 Newton steps
 *     x <- x - (f(x) - side wanted) / f'(x),   f(x) = side h(side x)
 * in the direction of `wanted`; the first x is that of the mean slope. */
DIAGNOSED_CODE
static float diagnosed_hysteresis_solve(const diagnosed_hysteresis_t *self, float wanted)
{
    const float way = (wanted - self->h_um) * diagnosed_hysteresis_range[5];
    const uint32_t falls = (uint32_t)(way < 0.0f);
    const float side = (falls != 0u) ? -1.0f : 1.0f;
    const float start = side * self->last;
    const float aim = side * wanted;
    const float *row = &diagnosed_hysteresis_curve[falls * 52u];
    float taken[12];
    const uint32_t turns = falls ^ (uint32_t)(self->last < self->turn);
    const float turn = side * ((turns != 0u) ? self->last : self->turn);
    const float left0 = (turns != 0u) ? self->back[0] : self->left[0];
    const float left1 = (turns != 0u) ? self->back[1] : self->left[1];
    uint32_t beyond;
    float x = diagnosed_flushed(diagnosed_limited(start + side * way, start, 1.0f, &beyond));

    taken[0] = side * self->play[0] + (diagnosed_hysteresis_play[0] - 2.38418579e-07f);
    taken[1] = side * self->play[1] + (diagnosed_hysteresis_play[4] - 2.38418579e-07f);
    taken[2] = side * self->play[2] + (diagnosed_hysteresis_play[8] - 2.38418579e-07f);
    taken[3] = side * self->play[3] + (diagnosed_hysteresis_play[12] - 2.38418579e-07f);
    taken[4] = side * self->play[4] + (diagnosed_hysteresis_play[16] - 2.38418579e-07f);
    taken[5] = side * self->play[5] + (diagnosed_hysteresis_play[20] - 2.38418579e-07f);
    taken[6] = side * self->play[6] + (diagnosed_hysteresis_play[24] - 2.38418579e-07f);
    taken[7] = side * self->play[7] + (diagnosed_hysteresis_play[28] - 2.38418579e-07f);
    taken[8] = side * self->play[8] + (diagnosed_hysteresis_play[32] - 2.38418579e-07f);
    taken[9] = side * self->play[9] + (diagnosed_hysteresis_play[36] - 2.38418579e-07f);
    taken[10] = side * self->play[10] + (diagnosed_hysteresis_play[40] - 2.38418579e-07f);
    taken[11] = side * self->play[11] + (diagnosed_hysteresis_play[44] - 2.38418579e-07f);
    for (uint32_t step = 0u; step < 3u; ++step) {
        const float e0 = diagnosed_power_of_two((x - turn) * diagnosed_hysteresis_rate[0]);
        const float e1 = e0 * e0;
        const diagnosed_hysteresis_ahead_t d0 = diagnosed_hysteresis_duhem_ahead(left0, e0, &diagnosed_hysteresis_duhem[0]);
        const diagnosed_hysteresis_ahead_t d1 = diagnosed_hysteresis_duhem_ahead(left1, e1, &diagnosed_hysteresis_duhem[3]);
        const uint32_t n = diagnosed_hysteresis_count(taken, x);
        const diagnosed_hysteresis_ahead_t moved = diagnosed_hysteresis_polynomial(&row[4u * n], x);
        float missed = moved.um + (side * self->sum_um[n] - aim);
        float slope = moved.slope;

        missed = missed + d0.um;
        slope = slope + d0.slope;
        missed = missed + d1.um;
        slope = slope + d1.slope;
        slope = diagnosed_limited(slope, diagnosed_hysteresis_range[3], diagnosed_hysteresis_range[4], &beyond);
        x = diagnosed_limited(x - diagnosed_hysteresis_rough_quotient(missed, slope), start, 1.0f, &beyond);
        x = diagnosed_flushed(x);
    }
    return diagnosed_hysteresis_range[0] + (side * x) * diagnosed_hysteresis_range[1];
}

/* amount sum_i s_i */
DIAGNOSED_INLINE float diagnosed_creep_slow(const diagnosed_creep_t *self)
{
    float sum = self->high[0];

    sum = sum + self->high[1];
    sum = sum + self->high[2];
    sum = sum + self->high[3];
    return diagnosed_creep_amount[0] * sum;
}

DIAGNOSED_CODE
static float diagnosed_creep_init(diagnosed_creep_t *self, float x)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        self->high[i] = x;
        self->low[i] = 0.0f;
    }
    return x + diagnosed_creep_slow(self);
}

/* y = x + amount sum_i s_i,   s_i = s_i + a_i (x - s_i) */
DIAGNOSED_INLINE float diagnosed_creep_apply(diagnosed_creep_t *self, float x)
{
    const float y = x + diagnosed_creep_slow(self);
    const float high0 = self->high[0];
    const float t0 = diagnosed_carried(self->low[0], diagnosed_creep_rate[0] * (x - high0));
    const float high1 = self->high[1];
    const float t1 = diagnosed_carried(self->low[1], diagnosed_creep_rate[1] * (x - high1));
    const float high2 = self->high[2];
    const float t2 = diagnosed_carried(self->low[2], diagnosed_creep_rate[2] * (x - high2));
    const float high3 = self->high[3];
    const float t3 = diagnosed_carried(self->low[3], diagnosed_creep_rate[3] * (x - high3));

    self->low[0] = diagnosed_lost(high0, t0);
    self->high[0] = diagnosed_total(high0, t0);
    self->low[1] = diagnosed_lost(high1, t1);
    self->high[1] = diagnosed_total(high1, t1);
    self->low[2] = diagnosed_lost(high2, t2);
    self->high[2] = diagnosed_total(high2, t2);
    self->low[3] = diagnosed_lost(high3, t3);
    self->high[3] = diagnosed_total(high3, t3);
    return y;
}

/* The same, with the state behind it in `next`. */
DIAGNOSED_INLINE float diagnosed_creep_ahead(const diagnosed_creep_t *self, diagnosed_creep_t *next, float x)
{
    const float y = x + diagnosed_creep_slow(self);
    const float high0 = self->high[0];
    const float t0 = diagnosed_carried(self->low[0], diagnosed_creep_rate[0] * (x - high0));
    const float high1 = self->high[1];
    const float t1 = diagnosed_carried(self->low[1], diagnosed_creep_rate[1] * (x - high1));
    const float high2 = self->high[2];
    const float t2 = diagnosed_carried(self->low[2], diagnosed_creep_rate[2] * (x - high2));
    const float high3 = self->high[3];
    const float t3 = diagnosed_carried(self->low[3], diagnosed_creep_rate[3] * (x - high3));

    next->low[0] = diagnosed_lost(high0, t0);
    next->high[0] = diagnosed_total(high0, t0);
    next->low[1] = diagnosed_lost(high1, t1);
    next->high[1] = diagnosed_total(high1, t1);
    next->low[2] = diagnosed_lost(high2, t2);
    next->high[2] = diagnosed_total(high2, t2);
    next->low[3] = diagnosed_lost(high3, t3);
    next->high[3] = diagnosed_total(high3, t3);
    return y;
}

/* x = y - amount sum_i s_i */
DIAGNOSED_INLINE float diagnosed_creep_solve(const diagnosed_creep_t *self, float wanted)
{
    return wanted - diagnosed_creep_slow(self);
}


/* sum_j q_j (Re M_j position_j - Im M_j velocity_j) */
DIAGNOSED_INLINE float diagnosed_modes_moving(const float position[1], const float velocity[1])
{
    float sum = diagnosed_modes_of_position[0] * position[0] + diagnosed_modes_of_velocity[0] * velocity[0];

    return sum;
}

DIAGNOSED_CODE
static float diagnosed_modes_init(diagnosed_modes_t *self, float x)
{
    for (uint32_t j = 0u; j < 1u; ++j) {
        self->position[j] = x;
        self->position_low[j] = 0.0f;
        self->velocity[j] = 0.0f;
        self->velocity_low[j] = 0.0f;
    }
    return diagnosed_modes_direct[0] * x + diagnosed_modes_moving(self->position, self->velocity);
}

/* w = direct x + the share of the modes;   c = c + s (x - c),  c = position + i velocity */
DIAGNOSED_INLINE float diagnosed_modes_apply(diagnosed_modes_t *self, float x)
{
    const float w = diagnosed_modes_direct[0] * x + diagnosed_modes_moving(self->position, self->velocity);
    const float position0 = self->position[0];
    const float velocity0 = self->velocity[0];
    const float away0 = x - position0;
    const float forward0 = diagnosed_carried(self->position_low[0], diagnosed_modes_real[0] * away0 + diagnosed_modes_imag[0] * velocity0);
    const float turn0 = diagnosed_carried(self->velocity_low[0], diagnosed_modes_imag[0] * away0 - diagnosed_modes_real[0] * velocity0);

    self->position_low[0] = diagnosed_lost(position0, forward0);
    self->position[0] = diagnosed_total(position0, forward0);
    self->velocity_low[0] = diagnosed_lost(velocity0, turn0);
    self->velocity[0] = diagnosed_total(velocity0, turn0);
    return w;
}

/* The same, with the state behind it in `next`. */
DIAGNOSED_INLINE float diagnosed_modes_ahead(const diagnosed_modes_t *self, diagnosed_modes_t *next, float x)
{
    const float w = diagnosed_modes_direct[0] * x + diagnosed_modes_moving(self->position, self->velocity);
    const float position0 = self->position[0];
    const float velocity0 = self->velocity[0];
    const float away0 = x - position0;
    const float forward0 = diagnosed_carried(self->position_low[0], diagnosed_modes_real[0] * away0 + diagnosed_modes_imag[0] * velocity0);
    const float turn0 = diagnosed_carried(self->velocity_low[0], diagnosed_modes_imag[0] * away0 - diagnosed_modes_real[0] * velocity0);

    next->position_low[0] = diagnosed_lost(position0, forward0);
    next->position[0] = diagnosed_total(position0, forward0);
    next->velocity_low[0] = diagnosed_lost(velocity0, turn0);
    next->velocity[0] = diagnosed_total(velocity0, turn0);
    return w;
}

/* x = (w - the share of the modes) / direct */
DIAGNOSED_INLINE float diagnosed_modes_solve(const diagnosed_modes_t *self, float wanted)
{
    return (wanted - diagnosed_modes_moving(self->position, self->velocity)) * diagnosed_modes_per_direct[0];
}

/* Input against the velocities that limits left. */
DIAGNOSED_INLINE float diagnosed_modes_calming(const diagnosed_inputs_t *inputs)
{
    float sum = inputs->astray_velocity[0];

    return sum * diagnosed_modes_calm[0];
}

/* What limits left, behind the input x that they add. */
DIAGNOSED_INLINE void diagnosed_modes_stray(diagnosed_inputs_t *inputs, float x)
{
    const float position0 = inputs->astray_position[0];
    const float velocity0 = inputs->astray_velocity[0];
    const float away0 = x - position0;
    const float forward0 = diagnosed_modes_real[0] * away0 + diagnosed_modes_imag[0] * velocity0;
    const float turn0 = diagnosed_modes_imag[0] * away0 - diagnosed_modes_real[0] * velocity0;

    inputs->astray_position[0] = diagnosed_flushed(diagnosed_inside(position0 + forward0, 1048576.0f));
    inputs->astray_velocity[0] = diagnosed_flushed(diagnosed_inside(velocity0 + turn0, 1048576.0f));
}


/* No limit has acted, as far as the inverse knows. */
DIAGNOSED_INLINE void diagnosed_inputs_straighten(diagnosed_inputs_t *inputs)
{
    inputs->asked_um = 0.0f;
    inputs->astray_um = 0.0f;
    for (uint32_t j = 0u; j < 1u; ++j) {
        inputs->astray_position[j] = 0.0f;
        inputs->astray_velocity[j] = 0.0f;
    }
}

/* At rest under the command u; returns w at rest. */
DIAGNOSED_CODE
static float diagnosed_inputs_init(diagnosed_inputs_t *inputs, float u)
{
    float v = u;

    v = diagnosed_delay_init(&inputs->delay, v);
    inputs->v_V = v;
    diagnosed_inputs_straighten(inputs);
    uint32_t outside;

    v = diagnosed_flushed(diagnosed_hysteresis_init(&inputs->hysteresis, v));
    v = diagnosed_flushed(diagnosed_creep_init(&inputs->creep, v));
    v = diagnosed_flushed(diagnosed_modes_init(&inputs->modes, v));
    return diagnosed_limited(v, DIAGNOSED_W_MIN, DIAGNOSED_W_MAX, &outside);
}

/* w of the voltage v that reaches the stage. */
DIAGNOSED_INLINE float diagnosed_inputs_respond(diagnosed_hysteresis_t *hysteresis, diagnosed_creep_t *creep, diagnosed_modes_t *modes, float v, float *entered)
{
    uint32_t outside;
    float w = v;

    w = diagnosed_flushed(diagnosed_hysteresis_apply(hysteresis, w));
    w = diagnosed_flushed(diagnosed_creep_apply(creep, w));
    *entered = w;
    w = diagnosed_flushed(diagnosed_modes_apply(modes, w));
    return diagnosed_limited(w, DIAGNOSED_W_MIN, DIAGNOSED_W_MAX, &outside);
}

/* w of the command u. */
DIAGNOSED_INLINE float diagnosed_inputs_apply(diagnosed_inputs_t *inputs, float u)
{
    float v = u;
    float entered;

    v = diagnosed_delay_apply(&inputs->delay, v);
    inputs->v_V = v;
    diagnosed_inputs_straighten(inputs);
    return diagnosed_inputs_respond(&inputs->hysteresis, &inputs->creep, &inputs->modes, v, &entered);
}

/** What the inverse of the path finds besides the command. */
typedef struct {
    float w;               /**< Input of the rules that follows from the command. */
    uint32_t u_clamped;    /**< 1 if the voltage was outside the span. */
    uint32_t unreachable;  /**< 1 if a limit keeps the input of the rules from the wanted one. */
    uint32_t residual;     /**< 1 if the input of the rules is not the wanted one although no limit acted. */
    float astray;          /**< What limits, of this sample and before, add to the input of the rules. */
} diagnosed_found_t;

/* The command for which w is the input of the rules, 1 samples later;
 * the voltage that reaches the stage stays in the span. */
DIAGNOSED_CODE
static float diagnosed_inputs_invert(diagnosed_inputs_t *inputs, float w, diagnosed_span_t span,
    diagnosed_found_t *found)
{
    diagnosed_hysteresis_t hysteresis;
    diagnosed_creep_t creep;
    diagnosed_modes_t modes;
    uint32_t beyond;
    const float wanted = diagnosed_limited(w, DIAGNOSED_W_MIN, DIAGNOSED_W_MAX, &beyond);
    float solved = wanted;
    const float led = diagnosed_flushed(diagnosed_modes_moving(inputs->astray_position, inputs->astray_velocity));
    const float calm = diagnosed_modes_calming(inputs);
    float entered;
    float later;

    /* What arrives next depends on the command that follows: the responses are one sample behind, and a copy of them
     * goes ahead by the voltage that the call before asked for. */
    float w_ahead = diagnosed_flushed(diagnosed_hysteresis_ahead(&inputs->hysteresis, &hysteresis, inputs->v_V));
    w_ahead = diagnosed_flushed(diagnosed_creep_ahead(&inputs->creep, &creep, w_ahead));
    (void)diagnosed_modes_ahead(&inputs->modes, &modes, w_ahead);
    solved = diagnosed_flushed(diagnosed_modes_solve(&modes, solved + led));
    const float asked = solved;

    solved = solved + calm;
    solved = diagnosed_flushed(diagnosed_creep_solve(&creep, solved));
    solved = diagnosed_flushed(diagnosed_hysteresis_solve(&hysteresis, solved));
    const float allowed = diagnosed_allowed(solved, span, &found->u_clamped);
    float v = allowed;

    float u = v;

    u = diagnosed_delay_command(&inputs->delay, u);
    inputs->v_V = v;
    found->w = diagnosed_inputs_respond(&hysteresis, &creep, &modes, v, &entered);
    const float arrived = diagnosed_delay_arrived(&inputs->delay);

    (void)diagnosed_inputs_respond(&inputs->hysteresis, &inputs->creep, &inputs->modes, arrived, &later);

    const float less = found->w - wanted;
    const float more = wanted - found->w;
    const uint32_t missed = (uint32_t)(less > DIAGNOSED_W_TOLERANCE) | (uint32_t)(more > DIAGNOSED_W_TOLERANCE);
    const uint32_t at_end = (uint32_t)(v <= span.low) | (uint32_t)(v >= span.high);
    const uint32_t held = beyond | found->u_clamped | (uint32_t)(diagnosed_bits(v) != diagnosed_bits(allowed));

    const uint32_t excused = at_end | (uint32_t)(diagnosed_bits(led) != 0u);
    const float off = (held != 0u) ? (entered - asked) : calm;

    found->astray = diagnosed_flushed((diagnosed_modes_direct[0] * off + led) + (wanted - w));
    diagnosed_modes_stray(inputs, off);
    found->unreachable = held | (missed & excused);
    found->residual = missed & ~(held | excused) & 1u;
    return u;
}

/* ---- Prediction ------------------------------------------------------------------------------------------------ */

DIAGNOSED_CODE
void diagnosed_init(diagnosed_t *self, float y_um, float u_V)
{
    diagnosed_events_t events;

    for (uint32_t b = 0u; b < 2u; ++b) {
        for (uint32_t l = 0u; l < DIAGNOSED_BANK_RULES; ++l) {
            self->bank[b].slope[l] = diagnosed_slope[l];
            self->bank[b].offset[l] = diagnosed_offset[l];
            self->bank[b].gain[l] = diagnosed_gain[l];
        }
    }
    self->active = 0u;
    self->status = 0u;
    self->y_clamped = 0u;
    self->u_clamped = 0u;
    self->y_rejected = 0u;
    self->u_rejected = 0u;
    self->y_um = DIAGNOSED_Y_REST_UM;
    self->u_V = DIAGNOSED_U_REST_V;
    self->y_um = diagnosed_checked_y(self, y_um, &events);
    self->u_V = diagnosed_checked_u(self, u_V, &events);
    diagnosed_count_events(self, &events);
    self->low_V = DIAGNOSED_U_MIN_V;
    self->high_V = DIAGNOSED_U_MAX_V;
    self->step_V = DIAGNOSED_U_STEP_MAX_V;
    (void)diagnosed_inputs_init(&self->inputs, self->u_V);
}

/* The model's output under the input u that reaches the stage, Eq. (4), with base = y S + O; the input acts on the state. */
DIAGNOSED_INLINE float diagnosed_apply(diagnosed_t *self, float base, float gain, float per_weight, float u)
{
    const float rules = (base + u * gain) * per_weight;
    const float y_next = diagnosed_flushed(rules);

    self->y_um = y_next;
    return y_next;
}

/* y(k+1) from measured y(k) and u(k). */
DIAGNOSED_CODE
float diagnosed_predict(diagnosed_t *self, float y_um, float u_V)
{
    const diagnosed_bank_t *bank = &self->bank[self->active];
    diagnosed_events_t events;
    const float y = diagnosed_checked_y(self, y_um, &events);
    const float u = diagnosed_checked_u(self, u_V, &events);
    const float w = diagnosed_inputs_apply(&self->inputs, u);
    const diagnosed_sums_t sums = diagnosed_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = diagnosed_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = diagnosed_apply(self, base, sums.gain, per_weight, w);

    diagnosed_count_events(self, &events);
    return y_next;
}

/* ---- Free run -------------------------------------------------------------------------------------------------- */

/* y(k+1) from the last output and u(k). */
DIAGNOSED_CODE
float diagnosed_simulate(diagnosed_t *self, float u_V)
{
    const diagnosed_bank_t *bank = &self->bank[self->active];
    diagnosed_events_t events = { 0u, 0u, 0u, 0u };
    const float y = diagnosed_limited(self->y_um, DIAGNOSED_Y_MIN_UM, DIAGNOSED_Y_MAX_UM, &events.y_clamped);
    const float u = diagnosed_checked_u(self, u_V, &events);
    const float w = diagnosed_inputs_apply(&self->inputs, u);
    const diagnosed_sums_t sums = diagnosed_rule_sums(bank, y);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = diagnosed_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = diagnosed_apply(self, base, sums.gain, per_weight, w);

    diagnosed_count_events(self, &events);
    return y_next;
}

/* ---- Inverse --------------------------------------------------------------------------------------------------- */

DIAGNOSED_CODE
void diagnosed_limits(diagnosed_t *self, float low_V, float high_V, float step_V)
{
    uint32_t acted;
    const float low = diagnosed_finite(low_V, DIAGNOSED_U_MIN_V, &acted);
    const float high = diagnosed_finite(high_V, DIAGNOSED_U_MAX_V, &acted);
    const float step = diagnosed_finite(step_V, DIAGNOSED_U_STEP_MAX_V, &acted);

    self->low_V = diagnosed_limited(low, DIAGNOSED_U_MIN_V, DIAGNOSED_U_MAX_V, &acted);
    self->high_V = diagnosed_limited(high, self->low_V, DIAGNOSED_U_MAX_V, &acted);
    self->step_V = diagnosed_limited(step, 0.0f, DIAGNOSED_U_STEP_MAX_V, &acted);
}

/* u(k) that takes y(k) to y(k+1): (y(k+1) - sum theta phi) W = y S + O + u G, solved for u. */
DIAGNOSED_CODE
float diagnosed_inverse(diagnosed_t *self, float y_um, float y_next_um)
{
    const diagnosed_bank_t *bank = &self->bank[self->active];
    diagnosed_events_t events = { 0u, 0u, 0u, 0u };
    uint32_t rejected;
    uint32_t clamped;
    const float y = diagnosed_checked_y(self, y_um, &events);
    const diagnosed_sums_t sums = diagnosed_rule_sums(bank, y);
    const diagnosed_span_t span = diagnosed_span(self, self->inputs.v_V);
    const float finite = diagnosed_finite(y_next_um, y, &rejected);
    const float wanted = diagnosed_limited(finite, DIAGNOSED_REFERENCE_MIN_UM, DIAGNOSED_REFERENCE_MAX_UM, &clamped);
    const float base = y * sums.slope + sums.offset;
    /* Where a limit led the model astray, it goes on from where it was asked to be. */
    const float led_um = self->inputs.astray_um;
    const float start_um = (diagnosed_bits(led_um) != 0u) ? self->inputs.asked_um : y;
    const float numerator = wanted * sums.weight - (start_um * sums.slope + sums.offset);
    const float per_gain = diagnosed_reciprocal(sums.gain);
    const float per_weight = diagnosed_reciprocal(sums.weight);
    const float exact = diagnosed_flushed(numerator * per_gain);
    diagnosed_found_t found;
    const float u = diagnosed_inputs_invert(&self->inputs, exact, span, &found);
    const uint32_t unreachable = found.unreachable;
    const float moved_um = (sums.slope * led_um + sums.gain * found.astray) * per_weight;

    const float astray_um = diagnosed_flushed(diagnosed_inside(moved_um, 1048576.0f));

    self->inputs.astray_um = astray_um;
    self->inputs.asked_um = (diagnosed_bits(astray_um) != 0u) ? wanted : 0.0f;

    self->status |= (clamped * DIAGNOSED_STATUS_REFERENCE_CLAMPED) | (unreachable * DIAGNOSED_STATUS_UNREACHABLE);
    self->status |= found.residual * DIAGNOSED_STATUS_INVERSE_RESIDUAL;
    events.u_clamped = found.u_clamped;
    events.y_rejected |= rejected;
    diagnosed_count_events(self, &events);
    self->u_V = u;
    (void)diagnosed_apply(self, base, sums.gain, per_weight, found.w);
    return u;
}

/* ---- Learner ---------------------------------------------------------------------------------------------------- */

/* Advice for gcc on the C674x, which overlaps operations of a basic block only: it unrolls the loops over parameters and
 * rules, schedules each function alone, and keeps the order of the loads. For the same reason these loops write local
 * arrays, which nothing else can alias, and copy them at the end. The bits do not depend on the advice. */
#if defined(_TMS320C6X) && defined(__GNUC__)
#define DIAGNOSED_UNROLL _Pragma("GCC unroll 153")
#define DIAGNOSED_ALONE __attribute__((noinline, optimize("no-tree-ter")))
#else
#define DIAGNOSED_UNROLL
#define DIAGNOSED_ALONE
#endif

/* 1.5 * 2^23 times the grids of regressors (2^-30), U (2^-30), g (2^-60) and steps of theta (2^-45). */
#define DIAGNOSED_REGRESSOR_GRID  0.01171875f
#define DIAGNOSED_FACTOR_GRID     0.01171875f
#define DIAGNOSED_GAIN_GRID       1.09139364e-11f
#define DIAGNOSED_STEP_GRID       3.57627869e-07f

/** How an update goes on behind its diagonal. */
typedef enum {
    DIAGNOSED_UPDATE_SKIPPED = 0,    /**< The sample is an outlier or inside the dead zone; P and theta stay. */
    DIAGNOSED_UPDATE_CONTINUES = 1,  /**< The diagonal is updated; U and theta follow. */
    DIAGNOSED_UPDATE_RESTARTS = 2    /**< alpha is beyond its limit; the shadow restarts. */
} diagnosed_outcome_t;

/* x rounded to a multiple of the grid that the constant DIAGNOSED_..._GRID belongs to: no stored word is denormal. */
DIAGNOSED_INLINE float diagnosed_on_grid(float x, float grid)
{
    return (x + grid) - grid;
}

/* |x| as bits, which have the order of the magnitudes. */
DIAGNOSED_INLINE uint32_t diagnosed_size(float x)
{
    return diagnosed_bits(x) & 0x7fffffffu;
}

/* 1 if a parameter is not finite or beyond its limit. */
DIAGNOSED_INLINE uint32_t diagnosed_beyond(float theta)
{
    return (uint32_t)(diagnosed_size(theta) >= diagnosed_bits(DIAGNOSED_LEARN_LIMIT_UM));
}

/* Set the bit of an event in the status word and increment its counter, which stops at its largest value. */
DIAGNOSED_INLINE void diagnosed_count_learner_event(
    diagnosed_learner_t *self, uint32_t *counter, uint32_t happened, uint32_t flag)
{
    self->status |= diagnosed_mask(happened) & flag;
    *counter += happened & (uint32_t)(*counter < UINT32_MAX);
}

/* U = I. */
DIAGNOSED_CODE
static void diagnosed_clear(diagnosed_learner_t *self)
{
    DIAGNOSED_UNROLL
    for (uint32_t i = 0u; i < DIAGNOSED_FACTORS; ++i) {
        self->u[i] = 0.0f;
    }
}

/* The shadow becomes the reference parameters, and P the prior: U = I, D = alpha. */
DIAGNOSED_CODE
static void diagnosed_restart(diagnosed_learner_t *self)
{
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        self->theta[j] = self->reference[j];
        self->theta_low[j] = 0.0f;
        self->d[j] = diagnosed_learn_prior[j];
    }
    diagnosed_clear(self);
    self->scale_um = DIAGNOSED_LEARN_LEVEL_UM;
    self->moving_um = DIAGNOSED_LEARN_LEVEL_UM;
    self->error = 0.0f;
    self->reference_error = 0.0f;
    self->step_error = 0.0f;
    self->run = 0u;
    self->age = 0u;
}

/* ---- Learner: the update, P = U D U' --------------------------------------------------------------------------- */

/* Index of U_ij, i < j, in the packed columns. */
DIAGNOSED_INLINE uint32_t diagnosed_place(uint32_t i, uint32_t j)
{
    return ((j * (j - 1u)) >> 1) + i;
}

/* f = U' x and g = D f with D / lambda:  f_j = sum_{i<j} U_ij x_i + x_j. Row i of U adds to every f_j behind it. */
DIAGNOSED_CODE
static DIAGNOSED_ALONE void diagnosed_project(diagnosed_learner_t *self)
{
    float f[DIAGNOSED_LEARNED];

    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        f[j] = 0.0f;
    }
    DIAGNOSED_UNROLL
    for (uint32_t i = 0u; i < DIAGNOSED_LEARNED; ++i) {
        f[i] = f[i] + self->x[i];
        DIAGNOSED_UNROLL
        for (uint32_t j = i + 1u; j < DIAGNOSED_LEARNED; ++j) {
            f[j] = f[j] + self->u[diagnosed_place(i, j)] * self->x[i];
        }
    }
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        self->f[j] = f[j];
        self->g[j] = diagnosed_on_grid((self->d[j] * self->inflate) * f[j], DIAGNOSED_GAIN_GRID);
    }
}

/* U and k = P x. In column j, over the rows i < j:
 *     U_ij <- U_ij + k_i l_j,  k_i <- k_i + U_ij g_j with the old U_ij,  then k_j = g_j.
 * One loop reads U and the next one writes it, so that the rows of a column can overlap. */
DIAGNOSED_CODE
static DIAGNOSED_ALONE void diagnosed_factor(diagnosed_learner_t *self)
{
    float k[DIAGNOSED_LEARNED];

    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        const float l = self->l[j];
        const float g = self->g[j];
        float u[DIAGNOSED_LEARNED];
        float moved[DIAGNOSED_LEARNED];

        DIAGNOSED_UNROLL
        for (uint32_t i = 0u; i < j; ++i) {
            u[i] = self->u[diagnosed_place(i, j)];
            moved[i] = u[i] + k[i] * l;
        }
        DIAGNOSED_UNROLL
        for (uint32_t i = 0u; i < j; ++i) {
            k[i] = k[i] + u[i] * g;
            self->u[diagnosed_place(i, j)] = diagnosed_on_grid(moved[i], DIAGNOSED_FACTOR_GRID);
        }
        k[j] = g;
    }
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        self->k[j] = k[j];
    }
}

/* 1 if the shadow learns from the sample, 0 for an outlier and for an innovation in the dead zone. The limit of the
 * innovation is that of the usual one times sqrt(alpha), alpha = 1 + x' P x: its variance is alpha times that of the noise. */
DIAGNOSED_CODE
static uint32_t diagnosed_admit(diagnosed_learner_t *self, float alpha)
{
    const float e = self->innovation_um;
    const float size = diagnosed_float(diagnosed_size(e));
    const float limit = DIAGNOSED_LEARN_GATE * self->scale_um + (2.0f * self->moving_um + DIAGNOSED_LEARN_GATE_FLOOR_UM);
    const float square = limit * limit;
    const uint32_t far = (uint32_t)(e * e > square * alpha);
    const uint32_t quiet = (uint32_t)(size < DIAGNOSED_LEARN_DEAD_ZONE_UM) & (uint32_t)(alpha < 1.25f) & (uint32_t)(self->inflate > 1.0f);
    uint32_t changed;
    uint32_t outlier;

    if (alpha < 2.0f) {
        uint32_t cut;
        const float most = 4.0f * self->scale_um + DIAGNOSED_LEARN_GATE_FLOOR_UM;
        const float seen = diagnosed_limited(size, 0.0f, most, &cut) + DIAGNOSED_LEARN_FLOOR_UM;

        self->scale_um = self->scale_um + DIAGNOSED_LEARN_FAST * (seen - self->scale_um);
    }
    self->run = (self->run + far) - ((far ^ 1u) & (uint32_t)(self->run > 0u));
    changed = (uint32_t)(self->run >= DIAGNOSED_LEARN_OUTLIER_RUN);
    outlier = far & (changed ^ 1u);
    if (changed != 0u) {
        self->run = 0u;
        if (size > self->scale_um) {
            self->scale_um = size;
        }
    }
    diagnosed_count_learner_event(self, &self->outliers, outlier, DIAGNOSED_LEARN_OUTLIER);
    diagnosed_count_learner_event(self, &self->changes, changed, DIAGNOSED_LEARN_CHANGED);
    diagnosed_count_learner_event(self, &self->quiet, quiet, DIAGNOSED_LEARN_QUIET);
    return (outlier | quiet) ^ 1u;
}

/* 1/alpha_j for every parameter. */
DIAGNOSED_CODE
static DIAGNOSED_ALONE void diagnosed_reciprocals(const float *alpha, float *per_alpha)
{
    float found[DIAGNOSED_LEARNED];

    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        found[j] = diagnosed_reciprocal(alpha[j]);
    }
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        per_alpha[j] = found[j];
    }
}

/* D becomes d, limited to positive values below the ceiling. Returns 1 if an element was limited. */
DIAGNOSED_CODE
static DIAGNOSED_ALONE uint32_t diagnosed_store_diagonal(diagnosed_learner_t *self, const float *d)
{
    float kept[DIAGNOSED_LEARNED];
    uint32_t clamped = 0u;

    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        uint32_t limited;

        kept[j] = diagnosed_limited(d[j], DIAGNOSED_LEARN_LEAST_VARIANCE, diagnosed_learn_ceiling[j], &limited);
        clamped |= limited;
    }
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        self->d[j] = kept[j];
    }
    return clamped;
}

/* alpha, l and D from f and g, for alpha_(-1) = 1:
 *     alpha_j = alpha_(j-1) + f_j g_j,  l_j = -f_j / alpha_(j-1),  D_j <- D_j / lambda * alpha_(j-1) / alpha_j */
DIAGNOSED_CODE
static DIAGNOSED_ALONE diagnosed_outcome_t diagnosed_update_diagonal(diagnosed_learner_t *self)
{
    float alpha[DIAGNOSED_LEARNED];
    float per_alpha[DIAGNOSED_LEARNED];
    float d[DIAGNOSED_LEARNED];
    float l[DIAGNOSED_LEARNED];
    float before = 1.0f;
    float per_before = 1.0f;
    diagnosed_outcome_t outcome;

    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        alpha[j] = before + self->f[j] * self->g[j];
        before = alpha[j];
    }
    /* The comparison of bits is true for infinity and NaN, too: all accuracy of U and D is lost. */
    if (diagnosed_bits(before) >= diagnosed_bits(DIAGNOSED_LEARN_LARGEST_DENOMINATOR)) {
        outcome = DIAGNOSED_UPDATE_RESTARTS;
    } else if ((self->measuring != 0u) && (diagnosed_admit(self, before) == 0u)) {
        outcome = DIAGNOSED_UPDATE_SKIPPED;
    } else {
        outcome = DIAGNOSED_UPDATE_CONTINUES;
    }
    if (outcome != DIAGNOSED_UPDATE_CONTINUES) {
        return outcome;
    }
    diagnosed_reciprocals(alpha, per_alpha);
    before = 1.0f;
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        l[j] = -(self->f[j] * per_before);
        d[j] = (self->d[j] * self->inflate) * (before * per_alpha[j]);
        before = alpha[j];
        per_before = per_alpha[j];
    }
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        self->l[j] = l[j];
    }
    self->per_alpha = per_before;
    diagnosed_count_learner_event(self, &self->clamped, diagnosed_store_diagonal(self, d), DIAGNOSED_LEARN_CLAMPED);
    return DIAGNOSED_UPDATE_CONTINUES;
}

/* theta <- theta + k q,  q = innovation / alpha,  k = P x. q is reduced if a parameter would move beyond its limit per
 * step. theta is the sum of two words, because most steps are smaller than its last bit. Returns 1 if a parameter is
 * beyond its limit: the shadow restarts. */
DIAGNOSED_CODE
static DIAGNOSED_ALONE uint32_t diagnosed_step(diagnosed_learner_t *self)
{
    float q = self->innovation_um * self->per_alpha;
    uint32_t largest = 0u;
    uint32_t beyond = 0u;
    float size;

    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        const uint32_t k = diagnosed_size(self->k[j]);

        largest = (k > largest) ? k : largest;
    }
    size = diagnosed_float(largest) * diagnosed_float(diagnosed_size(q));
    if (size > DIAGNOSED_LEARN_STEP_UM) {
        q = q * (DIAGNOSED_LEARN_STEP_UM * diagnosed_reciprocal(size));
        diagnosed_count_learner_event(self, &self->limited, 1u, DIAGNOSED_LEARN_LIMITED);
    }
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        const float theta = self->theta[j];
        const float carried = self->theta_low[j] + diagnosed_on_grid(self->k[j] * q, DIAGNOSED_STEP_GRID);
        const float sum = theta + carried;

        self->theta_low[j] = carried - (sum - theta);
        self->theta[j] = sum;
        beyond |= diagnosed_beyond(sum);
    }
    self->age += self->measuring & (uint32_t)(self->age < UINT32_MAX);
    diagnosed_count_learner_event(self, &self->updates, beyond ^ 1u, 0u);
    return beyond;
}

/* One update of P and theta. Returns 1 if the shadow restarts. */
DIAGNOSED_INLINE uint32_t diagnosed_update(diagnosed_learner_t *self)
{
    diagnosed_outcome_t outcome;
    uint32_t lost;

    diagnosed_project(self);
    outcome = diagnosed_update_diagonal(self);
    lost = (uint32_t)(outcome == DIAGNOSED_UPDATE_RESTARTS);
    if (outcome == DIAGNOSED_UPDATE_CONTINUES) {
        diagnosed_factor(self);
        lost = diagnosed_step(self);
    }
    return lost;
}

/* ---- Learner: samples ------------------------------------------------------------------------------------------ */

/* Innovation of the displacement y, e = y - x' theta - fixed, that of the reference parameters and that of the copy on trial. */
DIAGNOSED_CODE
static DIAGNOSED_ALONE float diagnosed_innovations(const diagnosed_learner_t *self, float y, float *reference, float *tried)
{
    float shadow = 0.0f;
    float other = 0.0f;
    float copy = 0.0f;

    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        shadow = shadow + self->x[j] * self->theta[j];
        other = other + self->x[j] * self->reference[j];
        copy = copy + self->x[j] * self->trial[j];
    }
    *reference = y - (other + self->fixed_um);
    *tried = y - (copy + self->fixed_um);
    return y - (shadow + self->fixed_um);
}

/* The innovations of a trial, none larger than that of an outlier, add up as they do in a free run. */
DIAGNOSED_INLINE void diagnosed_try(diagnosed_learner_t *self, float tried, float reference)
{
    uint32_t cut;
    const float gate = DIAGNOSED_LEARN_GATE * self->scale_um + (2.0f * self->moving_um + DIAGNOSED_LEARN_GATE_FLOOR_UM);
    const float limit = diagnosed_float(diagnosed_size(gate));
    const float mine = DIAGNOSED_LEARN_CARRIED * self->trial_um + diagnosed_limited(tried, -limit, limit, &cut);
    const float others = DIAGNOSED_LEARN_CARRIED * self->trial_reference_um + diagnosed_limited(reference, -limit, limit, &cut);

    self->trying -= (uint32_t)(self->trying != 0u);
    self->trial_um = diagnosed_flushed(mine);
    self->trial_reference_um = diagnosed_flushed(others);
    self->trial_error = self->trial_error + DIAGNOSED_LEARN_SLOW * ((mine * mine + DIAGNOSED_LEARN_FLOOR_SQUARE) - self->trial_error);
    self->trial_reference_error = self->trial_reference_error
        + DIAGNOSED_LEARN_SLOW * ((others * others + DIAGNOSED_LEARN_FLOOR_SQUARE) - self->trial_reference_error);
}

/* Update the running means. Returns 1 if the shadow, after its settling time, has a larger mean square innovation than
 * the reference parameters or than y(k+1) = y(k), times a limit each. */
DIAGNOSED_INLINE uint32_t diagnosed_restart_needed(diagnosed_learner_t *self, float e, float reference, float moved)
{
    const float size = diagnosed_float(diagnosed_size(moved)) + DIAGNOSED_LEARN_FLOOR_UM;
    const uint32_t settling = diagnosed_mask((uint32_t)(self->age >= DIAGNOSED_LEARN_SETTLING));
    const float rate = diagnosed_float(diagnosed_bits(DIAGNOSED_LEARN_SLOW) & settling);
    const float mine = e * e + DIAGNOSED_LEARN_FLOOR_SQUARE;
    const float others = reference * reference + DIAGNOSED_LEARN_FLOOR_SQUARE;
    const float persistence = moved * moved + DIAGNOSED_LEARN_FLOOR_SQUARE;

    self->moving_um = self->moving_um + DIAGNOSED_LEARN_FAST * (size - self->moving_um);
    self->error = self->error + rate * (mine - self->error);
    self->reference_error = self->reference_error + rate * (others - self->reference_error);
    self->step_error = self->step_error + rate * (persistence - self->step_error);
    return (uint32_t)(self->age >= DIAGNOSED_LEARN_SETTLED)
        & ((uint32_t)(self->error > DIAGNOSED_LEARN_WORSE * self->reference_error)
            | (uint32_t)(self->error > DIAGNOSED_LEARN_LOST * self->step_error));
}

/* Prepare one update: with the sample, or, every DIAGNOSED_LEARN_REFRESH_EVERY updates, with the pseudo-measurement
 * w reference_j = w theta_j, which restores the prior information of parameter j that forgetting removed. */
DIAGNOSED_INLINE void diagnosed_begin(diagnosed_learner_t *self, float e)
{
    const uint32_t sliding = 1u;

    self->since_refresh += sliding;
    self->measuring = (uint32_t)(self->since_refresh < DIAGNOSED_LEARN_REFRESH_EVERY);
    if (self->measuring != 0u) {
        self->inflate = diagnosed_float((diagnosed_bits(DIAGNOSED_LEARN_INFLATE) & diagnosed_mask(sliding))
            | (diagnosed_bits(DIAGNOSED_LEARN_INFLATE_FIRST) & diagnosed_mask(sliding ^ 1u)));
        self->innovation_um = e;
    } else {
        const uint32_t j = self->turn;

        for (uint32_t i = 0u; i < DIAGNOSED_LEARNED; ++i) {
            self->x[i] = 0.0f;
        }
        self->x[j] = diagnosed_learn_refresh[j];
        self->inflate = 1.0f;
        self->innovation_um = diagnosed_learn_refresh[j] * (self->reference[j] - self->theta[j]);
        self->turn = (j + 1u < DIAGNOSED_LEARNED) ? j + 1u : 0u;
        self->since_refresh = 0u;
    }
}

/* Compare the displacement y with the prediction from sample k - 1. Returns 1 if the shadow restarts; *begun becomes 1
 * if an update begins. */
DIAGNOSED_INLINE uint32_t diagnosed_evaluate_reading(
    diagnosed_learner_t *self, float y, float *innovation, uint32_t *begun)
{
    float reference;
    float tried;
    uint32_t lost = 0u;

    *innovation = diagnosed_innovations(self, y, &reference, &tried);
    diagnosed_count_learner_event(self, &self->resting, self->rested, DIAGNOSED_LEARN_RESTING);
    if (self->rested == 0u) {
        diagnosed_try(self, tried, reference);
        lost = diagnosed_restart_needed(self, *innovation, reference, y - self->y_um);
        if (lost == 0u) {
            diagnosed_begin(self, *innovation);
            *begun = 1u;
        }
    }
    return lost;
}

/* Keep the regressors of sample k for the displacement of sample k + 1:  x = phi / scale. The regressors of rule l are
 * p_l y, p_l u and p_l with p_l = w_l r^l / W; the strength w_l is part of the numbers in a bank. */
DIAGNOSED_CODE
static DIAGNOSED_ALONE void diagnosed_store_regressors(diagnosed_learner_t *self, float y_um, float u)
{
    uint32_t outside;
    const float y = diagnosed_limited(y_um, DIAGNOSED_Y_MIN_UM, DIAGNOSED_Y_MAX_UM, &outside);
    const diagnosed_sums_t sums = diagnosed_rule_sums(&self->base, y);
    const float per_weight = diagnosed_reciprocal(sums.weight);
    const float r = diagnosed_power_of_two((y - DIAGNOSED_ORIGIN_UM) * DIAGNOSED_PER_STEP);
    const float y_share = y * DIAGNOSED_LEARN_PER_Y;
    const float u_share = u * DIAGNOSED_LEARN_PER_U;
    float power[DIAGNOSED_RULES];

    power[0] = 1.0f;
    power[1] = r;
    DIAGNOSED_UNROLL
    for (uint32_t l = 2u; l < DIAGNOSED_RULES; ++l) {
        power[l] = power[l >> 1] * power[l - (l >> 1)];
    }

    self->fixed_um = 0.0f;
    DIAGNOSED_UNROLL
    for (uint32_t l = 0u; l < DIAGNOSED_RULES; ++l) {
        const float firing = (power[l] * per_weight) * diagnosed_learn_firing[l];

        self->x[3u * l] = diagnosed_on_grid(firing * y_share, DIAGNOSED_REGRESSOR_GRID);
        self->x[3u * l + 1u] = diagnosed_on_grid(firing * u_share, DIAGNOSED_REGRESSOR_GRID);
        self->x[3u * l + 2u] = diagnosed_on_grid(firing, DIAGNOSED_REGRESSOR_GRID);
    }
    self->fresh = outside ^ 1u;
    self->y_um = y_um;
    diagnosed_count_learner_event(self, &self->outside, outside, DIAGNOSED_LEARN_OUTSIDE);
}

/* ---- Learner: copies of a model's states ------------------------------------------------------------------------- */

/* Number by number: for a struct assignment compilers may call their library. That of gcc for the C674x copies in a
 * hardware loop, and the loop's counter is lost where an interrupt copies as well. */
DIAGNOSED_CODE
static void diagnosed_delay_copy(diagnosed_delay_t *to, const diagnosed_delay_t *from)
{
    to->newest = from->newest;
    to->wanted_V = from->wanted_V;
    for (uint32_t i = 0u; i < 2u; ++i) {
        to->ring[i] = from->ring[i];
    }
}

DIAGNOSED_CODE
static void diagnosed_hysteresis_copy(diagnosed_hysteresis_t *to, const diagnosed_hysteresis_t *from)
{
    to->turn = from->turn;
    to->last = from->last;
    to->h_um = from->h_um;
    for (uint32_t i = 0u; i < 2u; ++i) {
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

DIAGNOSED_CODE
static void diagnosed_creep_copy(diagnosed_creep_t *to, const diagnosed_creep_t *from)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        to->high[i] = from->high[i];
        to->low[i] = from->low[i];
    }
}

DIAGNOSED_CODE
static void diagnosed_modes_copy(diagnosed_modes_t *to, const diagnosed_modes_t *from)
{
    for (uint32_t i = 0u; i < 1u; ++i) {
        to->position[i] = from->position[i];
        to->position_low[i] = from->position_low[i];
        to->velocity[i] = from->velocity[i];
        to->velocity_low[i] = from->velocity_low[i];
    }
}

DIAGNOSED_CODE
void diagnosed_learn(diagnosed_learner_t *self, float y_um, float u_V)
{
    uint32_t y_lost;
    uint32_t u_lost;
    uint32_t moved;
    const float y = diagnosed_finite(y_um, self->y_um, &y_lost);
    const float u_finite = diagnosed_finite(u_V, self->u_V, &u_lost);
    const float u = diagnosed_limited(u_finite, DIAGNOSED_U_MIN_V, DIAGNOSED_U_MAX_V, &moved);
    const float w = diagnosed_inputs_apply(&self->inputs, u);
    const uint32_t implausible = (uint32_t)(y < DIAGNOSED_LEARN_Y_LOW_UM) | (uint32_t)(y > DIAGNOSED_LEARN_Y_HIGH_UM);
    const uint32_t usable = 1u ^ (y_lost | implausible);
    const float away = u - self->mean_u_V;
    float innovation = 0.0f;
    uint32_t begun = 0u;
    uint32_t lost = 0u;

    diagnosed_count_learner_event(self, &self->rejected, (usable ^ 1u) | u_lost, DIAGNOSED_LEARN_REJECTED);
    if ((self->fresh & usable) != 0u) {
        lost = diagnosed_evaluate_reading(self, y, &innovation, &begun);
    }
    if (begun != 0u) {
        lost = diagnosed_update(self);
    }
    if (lost != 0u) {
        diagnosed_count_learner_event(self, &self->restarts, 1u, DIAGNOSED_LEARN_RESTARTED);
        diagnosed_restart(self);
    }
    self->fresh = 0u;
    if ((usable & (u_lost ^ 1u)) != 0u) {
        diagnosed_store_regressors(self, y, w);
    }
    self->rested = (uint32_t)(diagnosed_float(diagnosed_size(away)) < DIAGNOSED_LEARN_REST_V);
    self->mean_u_V = diagnosed_flushed(self->mean_u_V + DIAGNOSED_LEARN_FAST * away);
    self->u_V = u;
}

DIAGNOSED_CODE
void diagnosed_learn_init(diagnosed_learner_t *self, const diagnosed_t *model)
{
    const diagnosed_bank_t *bank = &model->bank[model->active];

    DIAGNOSED_UNROLL
    for (uint32_t l = 0u; l < DIAGNOSED_BANK_RULES; ++l) {
        self->base.slope[l] = bank->slope[l];
        self->base.offset[l] = bank->offset[l];
        self->base.gain[l] = bank->gain[l];
    }
    DIAGNOSED_UNROLL
    for (uint32_t l = 0u; l < DIAGNOSED_RULES; ++l) {
        self->reference[3u * l] = self->base.slope[l] * diagnosed_learn_scale[3u * l];
        self->reference[3u * l + 1u] = self->base.gain[l] * diagnosed_learn_scale[3u * l + 1u];
        self->reference[3u * l + 2u] = self->base.offset[l] * diagnosed_learn_scale[3u * l + 2u];
    }
    for (uint32_t i = 0u; i < DIAGNOSED_LEARNED; ++i) {
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
    diagnosed_delay_copy(&self->inputs.delay, &model->inputs.delay);
    diagnosed_hysteresis_copy(&self->inputs.hysteresis, &model->inputs.hysteresis);
    diagnosed_creep_copy(&self->inputs.creep, &model->inputs.creep);
    diagnosed_modes_copy(&self->inputs.modes, &model->inputs.modes);
    diagnosed_inputs_straighten(&self->inputs);
    self->candidate.phase = (uint32_t)DIAGNOSED_PHASE_IDLE;
    self->candidate.point = 0u;
    diagnosed_restart(self);
}

/* ---- Commit ---------------------------------------------------------------------------------------------------- */

DIAGNOSED_INLINE float diagnosed_lesser(float a, float b)
{
    return (b < a) ? b : a;
}

DIAGNOSED_INLINE float diagnosed_greater(float a, float b)
{
    return (b > a) ? b : a;
}

/* y q1 + u q2 + one q3 of rule l; the table takes the rule's strength off the numbers in the bank. */
DIAGNOSED_INLINE float diagnosed_rule_value(const diagnosed_bank_t *bank, uint32_t l, float y, float u, float one)
{
    return ((y * bank->slope[l] + u * bank->gain[l]) + one * bank->offset[l]) * diagnosed_commit_unfold[l];
}

/* Half the difference between the largest and the smallest y q1 + u q2 + one q3 of a rule. */
DIAGNOSED_INLINE float diagnosed_half_span(const diagnosed_bank_t *bank, float y, float u, float one)
{
    float least = diagnosed_rule_value(bank, 0u, y, u, one);
    float most = least;

    DIAGNOSED_UNROLL
    for (uint32_t l = 1u; l < DIAGNOSED_RULES; ++l) {
        const float value = diagnosed_rule_value(bank, l, y, u, one);

        least = diagnosed_lesser(least, value);
        most = diagnosed_greater(most, value);
    }
    return 0.5f * (most - least);
}

/* Bounds of the Taylor remainders of gain and slope between the check points, for the parameters of the candidate. */
DIAGNOSED_CODE
static void diagnosed_bound_remainders(diagnosed_candidate_t *candidate)
{
    const diagnosed_bank_t *bank = &candidate->bank;
    const float common = DIAGNOSED_COMMIT_SLOPE_REMAINDER_1 * diagnosed_half_span(bank, 1.0f, 0.0f, 0.0f);
    const float low = diagnosed_greater(diagnosed_half_span(bank, DIAGNOSED_Y_MIN_UM, DIAGNOSED_W_MIN, 1.0f),
        diagnosed_half_span(bank, DIAGNOSED_Y_MAX_UM, DIAGNOSED_W_MIN, 1.0f));
    const float high = diagnosed_greater(diagnosed_half_span(bank, DIAGNOSED_Y_MIN_UM, DIAGNOSED_W_MAX, 1.0f),
        diagnosed_half_span(bank, DIAGNOSED_Y_MAX_UM, DIAGNOSED_W_MAX, 1.0f));

    candidate->gain_remainder_um_per_V = DIAGNOSED_COMMIT_GAIN_REMAINDER * diagnosed_half_span(bank, 0.0f, 1.0f, 0.0f);
    candidate->slope_remainder[0] = common + DIAGNOSED_COMMIT_SLOPE_REMAINDER_3 * low;
    candidate->slope_remainder[1] = common + DIAGNOSED_COMMIT_SLOPE_REMAINDER_3 * high;
}

/* Copy the shadow for a trial, on nothing if nothing was ever learnt, unless it is too young or a parameter is beyond its limit. */
DIAGNOSED_CODE
static diagnosed_commit_t diagnosed_snapshot(diagnosed_learner_t *learner)
{
    diagnosed_candidate_t *candidate = &learner->candidate;
    diagnosed_bank_t *bank = &candidate->bank;
    uint32_t beyond = 0u;

    if (learner->age < DIAGNOSED_COMMIT_MATURE) {
        return DIAGNOSED_COMMIT_REFUSED_YOUNG;
    }
    DIAGNOSED_UNROLL
    for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
        learner->trial[j] = learner->theta[j];
        beyond |= diagnosed_beyond(learner->theta[j]);
    }
    DIAGNOSED_UNROLL
    for (uint32_t l = 0u; l < DIAGNOSED_RULES; ++l) {
        bank->slope[l] = learner->theta[3u * l] * diagnosed_learn_per_scale[3u * l];
        bank->offset[l] = learner->theta[3u * l + 2u] * diagnosed_learn_per_scale[3u * l + 2u];
        bank->gain[l] = learner->theta[3u * l + 1u] * diagnosed_learn_per_scale[3u * l + 1u];
    }
    if (beyond != 0u) {
        return DIAGNOSED_COMMIT_REFUSED_LIMIT;
    }
    diagnosed_bound_remainders(candidate);
    learner->trial_um = 0.0f;
    learner->trial_reference_um = 0.0f;
    learner->trial_error = 0.0f;
    learner->trial_reference_error = 0.0f;
    learner->trying = (learner->updates != 0u) ? (uint32_t)DIAGNOSED_COMMIT_TRIAL : 0u;
    candidate->point = 0u;
    candidate->phase = (uint32_t)DIAGNOSED_PHASE_CHECK;
    return DIAGNOSED_COMMIT_BUSY;
}

/* 1 if |df/dy| may reach its limit within half a distance of the check points, from its value and its derivative. */
DIAGNOSED_INLINE uint32_t diagnosed_too_steep(float slope, float curve, float remainder)
{
    const float change = DIAGNOSED_COMMIT_HALF_UM * diagnosed_float(diagnosed_size(curve));

    return (uint32_t)(diagnosed_float(diagnosed_size(slope)) + (change + remainder) >= DIAGNOSED_COMMIT_SLOPE_LIMIT);
}

/* Gain and slope around one check point. With f = a(y) y + b(y) u + c(y), a = sum p_l q_l1 and likewise b and c:
 *     df/dy = a + a' y + b' u + c',  d2f/dy2 = 2 a' + a'' y + b'' u + c''
 * p_l, p_l' and p_l'' at the check point stand in a row of the table. */
DIAGNOSED_CODE
static diagnosed_commit_t diagnosed_check(const diagnosed_candidate_t *candidate)
{
    const float *p = &diagnosed_commit_table[candidate->point * (3u * DIAGNOSED_RULES)];
    const float *dp = &p[DIAGNOSED_RULES];
    const float *ddp = &dp[DIAGNOSED_RULES];
    const diagnosed_bank_t *bank = &candidate->bank;
    const float y = diagnosed_commit_y[candidate->point];
    float a = 0.0f;
    float da = 0.0f;
    float dda = 0.0f;
    float b = 0.0f;
    float db = 0.0f;
    float ddb = 0.0f;
    float dc = 0.0f;
    float ddc = 0.0f;

    DIAGNOSED_UNROLL
    for (uint32_t l = 0u; l < DIAGNOSED_RULES; ++l) {
        a = a + p[l] * bank->slope[l];
        da = da + dp[l] * bank->slope[l];
        dda = dda + ddp[l] * bank->slope[l];
        b = b + p[l] * bank->gain[l];
        db = db + dp[l] * bank->gain[l];
        ddb = ddb + ddp[l] * bank->gain[l];
        dc = dc + dp[l] * bank->offset[l];
        ddc = ddc + ddp[l] * bank->offset[l];
    }

    const float gain = DIAGNOSED_COMMIT_SIGN * b;
    const float away = DIAGNOSED_COMMIT_HALF_UM * diagnosed_float(diagnosed_size(db)) + candidate->gain_remainder_um_per_V;
    const float slope = (a + da * y) + dc;
    const float curve = ((da + da) + dda * y) + ddc;
    const uint32_t steep =
        diagnosed_too_steep(slope + db * DIAGNOSED_W_MIN, curve + ddb * DIAGNOSED_W_MIN, candidate->slope_remainder[0])
        | diagnosed_too_steep(slope + db * DIAGNOSED_W_MAX, curve + ddb * DIAGNOSED_W_MAX, candidate->slope_remainder[1]);
    const uint32_t weak = (uint32_t)(gain - away <= DIAGNOSED_COMMIT_GAIN_FLOOR)
        | (uint32_t)(gain + away >= DIAGNOSED_COMMIT_GAIN_CEILING);

    if (weak != 0u) {
        return DIAGNOSED_COMMIT_REFUSED_GAIN;
    }
    return (steep != 0u) ? DIAGNOSED_COMMIT_REFUSED_SLOPE : DIAGNOSED_COMMIT_BUSY;
}

/* Copy the candidate into the bank that is not in use. */
DIAGNOSED_CODE
static void diagnosed_write(diagnosed_t *self, const diagnosed_candidate_t *candidate)
{
    diagnosed_bank_t *idle = &self->bank[1u - self->active];

    for (uint32_t l = 0u; l < DIAGNOSED_BANK_RULES; ++l) {
        idle->slope[l] = candidate->bank.slope[l];
        idle->offset[l] = candidate->bank.offset[l];
        idle->gain[l] = candidate->bank.gain[l];
    }
}

/* Writing and switching are two calls: an interrupt between them finds the active bank complete. */
DIAGNOSED_CODE
diagnosed_commit_t diagnosed_commit(diagnosed_t *self, diagnosed_learner_t *learner)
{
    diagnosed_candidate_t *candidate = &learner->candidate;
    diagnosed_commit_t answer = DIAGNOSED_COMMIT_BUSY;

    switch (candidate->phase) {
    case (uint32_t)DIAGNOSED_PHASE_IDLE:
        answer = diagnosed_snapshot(learner);
        break;
    case (uint32_t)DIAGNOSED_PHASE_CHECK:
        for (uint32_t i = 0u; i < 1u; ++i) {
            if ((candidate->phase == (uint32_t)DIAGNOSED_PHASE_CHECK) && (answer == DIAGNOSED_COMMIT_BUSY)) {
                answer = diagnosed_check(candidate);
                candidate->point += 1u;
                candidate->phase += (uint32_t)(candidate->point >= DIAGNOSED_COMMIT_POINTS);
            }
        }
        candidate->phase = (answer == DIAGNOSED_COMMIT_BUSY) ? candidate->phase : (uint32_t)DIAGNOSED_PHASE_IDLE;
        break;
    case (uint32_t)DIAGNOSED_PHASE_TRIAL:
        if (learner->trying != 0u) {
            answer = DIAGNOSED_COMMIT_TRYING;
        } else if (learner->trial_error > learner->trial_reference_error) {
            answer = DIAGNOSED_COMMIT_REFUSED_WORSE;
            candidate->phase = (uint32_t)DIAGNOSED_PHASE_IDLE;
        } else {
            candidate->phase = (uint32_t)DIAGNOSED_PHASE_WRITE;
        }
        break;
    case (uint32_t)DIAGNOSED_PHASE_WRITE:
        diagnosed_write(self, candidate);
        candidate->phase = (uint32_t)DIAGNOSED_PHASE_SWITCH;
        break;
    default:
        self->active = 1u - self->active;
        for (uint32_t j = 0u; j < DIAGNOSED_LEARNED; ++j) {
            learner->reference[j] = learner->trial[j];
        }
        candidate->phase = (uint32_t)DIAGNOSED_PHASE_IDLE;
        answer = DIAGNOSED_COMMIT_COMMITTED;
        break;
    }
    return answer;
}
