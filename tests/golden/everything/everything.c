/* everything.c: the algorithm of model `everything`; changes only with the model's structure. Interface: everything.h. */

#include "everything.h"

/* Equal bits on every machine rest on float32 operations as they are written: no shortcuts, no wider intermediate
 * results, no multiplication fused with an addition. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#error "everything: compile without -ffast-math and its parts"
#endif
#if defined(__FLT_EVAL_METHOD__)
#if __FLT_EVAL_METHOD__ != 0
#error "everything: float must be evaluated as float (on x86: -msse2 -mfpmath=sse)"
#endif
#endif

#include <float.h>
#include <limits.h>

#if CHAR_BIT != 8 || FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MIN_EXP != -125 || FLT_MAX_EXP != 128
#error "everything: needs bytes of 8 bits, and float in the 32-bit format of IEEE 754"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__GNUC__)
#define EVERYTHING_INLINE static inline __attribute__((always_inline))
#else
#define EVERYTHING_INLINE EVERYTHING_CODE static inline
#endif

#define EVERYTHING_NUMBERS
#include "everything_params.h"

/* ---- Arithmetic ---------------------------------------------------------------------------------------------- */

EVERYTHING_INLINE uint32_t everything_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

EVERYTHING_INLINE float everything_float(uint32_t bits)
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
EVERYTHING_INLINE float everything_power_of_two(float x)
{
    const float shifted = x + 12582912.0f;
    const float f = x - (shifted - 12582912.0f);
    const float square = f * f;
    const float fourth = square * square;
    const float low = 1.0f + 0.693147182f * f;
    const float middle = 0.240226477f + 0.0555035993f * f;
    const float high = (0.00961850584f + 0.00133908063f * f) + 0.000153264715f * square;
    const float mantissa = low + (square * middle + fourth * high);

    return everything_float(everything_bits(mantissa) + (everything_bits(shifted) << 23));
}

/* 1/x for 2^-120 <= |x| <= 2^120, relative error at most 1.5e-07: a seed from the bits, then 3 Newton steps
 *     r <- r (2 - x r) */
EVERYTHING_INLINE float everything_reciprocal(float x)
{
    float r = everything_float(0x7ef311c7u - everything_bits(x));

    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);
    r = r * (2.0f - x * r);

    return r;
}

/* ---- Input checks: constant time, by masks --------------------------------------------------------------------- */

/* All ones if the condition is 1, else 0. */
EVERYTHING_INLINE uint32_t everything_mask(uint32_t condition)
{
    return 0u - condition;
}

/** Events at the inputs during one call, 1 if the event occurred and 0 if not. */
typedef struct {
    uint32_t y_clamped;   /**< y was outside its range and was limited. */
    uint32_t u_clamped;   /**< u was outside its range and was limited. */
    uint32_t y_rejected;  /**< y was not finite and was replaced. */
    uint32_t u_rejected;  /**< u was not finite and was replaced. */
} everything_events_t;

EVERYTHING_INLINE uint32_t everything_counted(uint32_t counter, uint32_t happened)
{
    return counter + (happened & (uint32_t)(counter < UINT32_MAX));
}

/* Status bits and counters of one call. Called last: the counting fills the slots that the arithmetic leaves free. */
EVERYTHING_INLINE void everything_count_events(everything_t *self, const everything_events_t *events)
{
    self->status |= (events->y_clamped * EVERYTHING_STATUS_Y_CLAMPED) | (events->u_clamped * EVERYTHING_STATUS_U_CLAMPED)
        | (events->y_rejected * EVERYTHING_STATUS_Y_REJECTED) | (events->u_rejected * EVERYTHING_STATUS_U_REJECTED);
    self->y_clamped = everything_counted(self->y_clamped, events->y_clamped);
    self->u_clamped = everything_counted(self->u_clamped, events->u_clamped);
    self->y_rejected = everything_counted(self->y_rejected, events->y_rejected);
    self->u_rejected = everything_counted(self->u_rejected, events->u_rejected);
}

/* x, or the value held if x is not finite; magnitudes below 2^-40 become 0, so that denormal numbers never occur. */
EVERYTHING_INLINE float everything_finite(float x, float held, uint32_t *rejected)
{
    const uint32_t bits = everything_bits(x);
    const uint32_t magnitude = bits & 0x7fffffffu;
    const uint32_t infinite = (uint32_t)(magnitude >= 0x7f800000u);
    const uint32_t keep = everything_mask((uint32_t)(magnitude >= 0x2b800000u));
    const uint32_t hold = everything_mask(infinite);

    *rejected = infinite;
    return everything_float((bits & keep & ~hold) | (everything_bits(held) & hold));
}

/* A result before it leaves or is kept: magnitudes below 2^-40 become 0. */
EVERYTHING_INLINE float everything_flushed(float x)
{
    const uint32_t bits = everything_bits(x);

    return everything_float(bits & everything_mask((uint32_t)((bits & 0x7fffffffu) >= 0x2b800000u)));
}

/* A state before it is kept: 0 if it is not finite or its magnitude reaches the limit, which no sound state does. */
EVERYTHING_INLINE float everything_inside(float x, float limit)
{
    const uint32_t bits = everything_bits(x);

    return everything_float(bits & everything_mask((uint32_t)((bits & 0x7fffffffu) < everything_bits(limit))));
}

/* x limited to [low, high]. */
EVERYTHING_INLINE float everything_limited(float x, float low, float high, uint32_t *clamped)
{
    const uint32_t below = (uint32_t)(x < low);
    const uint32_t above = (uint32_t)(x > high);
    const uint32_t raise = everything_mask(below);
    const uint32_t lower = everything_mask(above);

    *clamped = below | above;
    return everything_float(
        (everything_bits(x) & ~(raise | lower)) | (everything_bits(low) & raise) | (everything_bits(high) & lower));
}

/** The range of the inverse's voltage at one sample. */
typedef struct {
    float low;   /**< Lowest voltage [V]. */
    float high;  /**< Highest voltage [V]. */
} everything_span_t;

/* low_V .. high_V, and at most step_V from the voltage before. */
EVERYTHING_INLINE everything_span_t everything_span(const everything_t *self, float last_V)
{
    const float least = self->low_V;
    const float most = self->high_V;
    const float down = last_V - self->step_V;
    const float up = last_V + self->step_V;
    const float low = (down < least) ? least : down;
    const float high = (up < least) ? least : up;
    everything_span_t span;

    span.low = (low > most) ? most : low;
    span.high = (high > most) ? most : high;
    return span;
}

/* The voltage of the span that is nearest to x. */
EVERYTHING_INLINE float everything_allowed(float x, everything_span_t span, uint32_t *clamped)
{
    const float low = span.low;
    const float high = span.high;
    const float raised = (x < low) ? low : x;
    const float allowed = (raised > high) ? high : raised;

    *clamped = (uint32_t)(allowed < x) | (uint32_t)(allowed > x);
    return allowed;
}

/* A displacement inside the identified range, whatever came in. */
EVERYTHING_INLINE float everything_checked_y(const everything_t *self, float y_um, everything_events_t *events)
{
    const float finite = everything_finite(y_um, self->y_um, &events->y_rejected);

    return everything_limited(finite, EVERYTHING_Y_MIN_UM, EVERYTHING_Y_MAX_UM, &events->y_clamped);
}

/* A voltage inside the input range, whatever came in. */
EVERYTHING_INLINE float everything_checked_u(const everything_t *self, float u_V, everything_events_t *events)
{
    const float finite = everything_finite(u_V, self->u_V, &events->u_rejected);

    return everything_limited(finite, EVERYTHING_U_MIN_V, EVERYTHING_U_MAX_V, &events->u_clamped);
}

/* ---- Rules ----------------------------------------------------------------------------------------------------- */

/** Sums over the rules; v_l are the unnormalised memberships, p_l = v_l / weight. */
typedef struct {
    float slope;   /**< Sum of v_l q_l1. */
    float offset;  /**< Sum of v_l q_l3 [um]. */
    float gain;    /**< Sum of v_l q_l2. */
    float weight;  /**< Sum of v_l. */
} everything_sums_t;

/* Neighbouring rules' strengths differ by r = exp((y - middle) / h) and constants, so each sum over the rules is a
 * polynomial in r of degree 5, evaluated by Estrin's scheme: its chains are the shortest. y inside the range. */
EVERYTHING_INLINE everything_sums_t everything_rule_sums(const everything_bank_t *bank, float y)
{
    const float r = everything_power_of_two((y - EVERYTHING_ORIGIN_UM) * EVERYTHING_PER_STEP);
    const float r2 = r * r;
    const float r4 = r2 * r2;
    everything_sums_t sums;

    const float w0_1 = everything_strength[0] + everything_strength[1] * r;
    const float w2_3 = everything_strength[2] + everything_strength[3] * r;
    const float w4_5 = everything_strength[4] + everything_strength[5] * r;
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
EVERYTHING_INLINE float everything_carried(float low, float delta)
{
    const float step = (delta + 1.09139364e-11f) - 1.09139364e-11f;

    return low + step;
}

/* The new `high`. */
EVERYTHING_INLINE float everything_total(float high, float t)
{
    return everything_inside(high + t, 1048576.0f);
}

/* The new `low`, the rounding error of high + t. */
EVERYTHING_INLINE float everything_lost(float high, float t)
{
    const float sum = high + t;

    return t - (sum - high);
}

EVERYTHING_INLINE void everything_accumulate(float *high, float *low, float delta)
{
    const float before = *high;
    const float t = everything_carried(*low, delta);

    *low = everything_lost(before, t);
    *high = everything_total(before, t);
}

/* ---- Path -------------------------------------------------------------------------------------------------------- */

/* v = min(max(u, low), high) */
EVERYTHING_INLINE float everything_saturation_apply(float u)
{
    uint32_t clipped;

    return everything_limited(u, everything_saturation_low[0], everything_saturation_high[0], &clipped);
}

EVERYTHING_CODE
static float everything_slew_init(everything_slew_t *self, float u)
{
    self->last_V = u;
    return u;
}

/* v(k) = min(max(u(k), v(k-1) - fall), v(k-1) + rise) */
EVERYTHING_INLINE float everything_slew_apply(everything_slew_t *self, float u)
{
    const float low = self->last_V - everything_slew_fall[0];
    const float high = self->last_V + everything_slew_rise[0];
    const float slow = (u > high) ? high : u;

    self->last_V = (slow < low) ? low : slow;
    return self->last_V;
}

EVERYTHING_CODE
static float everything_delay_init(everything_delay_t *self, float u)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        self->ring[i] = u;
    }
    self->newest = 0u;
    self->wanted_V = u;
    return u;
}

EVERYTHING_INLINE void everything_delay_push(everything_delay_t *self, float u)
{
    self->newest = (self->newest + 1u) & 3u;
    self->ring[self->newest] = u;
}

/* The input of so many samples ago. */
EVERYTHING_INLINE float everything_delay_past(const everything_delay_t *self, uint32_t samples)
{
    return self->ring[(self->newest - samples) & 3u];
}

/* v(k) = u(k-d) + mu (u(k-d-1) - u(k-d)) */
EVERYTHING_INLINE float everything_delay_apply(everything_delay_t *self, float u)
{
    self->wanted_V = u;
    everything_delay_push(self, u);

    const float late = everything_delay_past(self, 2u);
    const float later = everything_delay_past(self, 3u);

    return late + everything_delay_part[0] * (later - late);
}

/* u(k) = v(k+n-1) + mu (v(k+n) - v(k+n-1)),  n the preview */
EVERYTHING_INLINE float everything_delay_command(everything_delay_t *self, float v)
{
    const float u = self->wanted_V + everything_delay_part[0] * (v - self->wanted_V);

    self->wanted_V = v;
    everything_delay_push(self, u);
    return u;
}

/* What arrives one sample before v of the last command: nothing that comes later changes it. */
EVERYTHING_INLINE float everything_delay_arrived(const everything_delay_t *self)
{
    const float late = everything_delay_past(self, 0u);
    const float later = everything_delay_past(self, 1u);

    return late + everything_delay_part[0] * (later - late);
}

/* x = (v - middle) / half range, limited to -1 .. 1 */
EVERYTHING_INLINE float everything_hysteresis_normalised(float v)
{
    uint32_t beyond;
    const float x = (v - everything_hysteresis_range[0]) * everything_hysteresis_range[2];

    return everything_flushed(everything_limited(x, -1.0f, 1.0f, &beyond));
}

/* g0(x) */
EVERYTHING_INLINE float everything_hysteresis_curve_um(float x)
{
    const float square = x * x;
    const float even = everything_hysteresis_curve[0] + square * everything_hysteresis_curve[2];
    const float odd = everything_hysteresis_curve[1] + square * everything_hysteresis_curve[3];

    return even + x * odd;
}

/* z <- max(x - r, min(x + r, z)) */
EVERYTHING_INLINE float everything_hysteresis_moved(float z, float x, float r)
{
    const float low = x - r;
    const float high = x + r;
    const float pulled = (z > high) ? high : z;

    return (pulled < low) ? low : pulled;
}

/* g(z) = c_1 z + c_2 z^2 + ...;  play: row of the half-width and the coefficients c_1, c_2, ... */
EVERYTHING_INLINE float everything_hysteresis_play_um(float z, const float play[4])
{
    return z * (play[1] + z * (play[2] + z * play[3]));
}

/* |x| */
EVERYTHING_INLINE float everything_hysteresis_magnitude(float x)
{
    return everything_float(everything_bits(x) & 0x7fffffffu);
}

/* e = exp(-|way| / reach) of the first Duhem state, at most 1. Positive floats are in the order of their bits. */
EVERYTHING_INLINE float everything_hysteresis_decay(float way)
{
    const uint32_t bits = everything_bits(everything_power_of_two(everything_hysteresis_magnitude(way) * everything_hysteresis_rate[0]));

    return everything_float((bits > 0x3f800000u) ? 0x3f800000u : bits);
}

/* b d + c d |d|, the part of a Duhem state in the output;  duhem: row b, c, 1/reach */
EVERYTHING_INLINE float everything_hysteresis_duhem_um(float d, const float duhem[3])
{
    return d * (duhem[0] + duhem[1] * everything_hysteresis_magnitude(d));
}

/* The Duhem states of `next`, at the input x, from those of `self`; returns their part of the output. Measured in the
 * direction of the input,
 *     d_i = 1 - left_i e_i,   e_i = exp(-2^i |x - turn| / reach)
 * where left_i is 1 - d_i at the last turn. After a turn, the direction and with it d_i change sign: left_i = back_i. */
EVERYTHING_INLINE float everything_hysteresis_followed_um(const everything_hysteresis_t *self, everything_hysteresis_t *next, float x)
{
    const uint32_t fell = (uint32_t)(self->last < self->turn);
    const float from_last = x - self->last;
    const float from_turn = x - self->turn;
    const uint32_t step = everything_bits(from_last);
    const uint32_t falls = (step >> 31) | (fell & (uint32_t)(step == 0u));
    const uint32_t turns = falls ^ fell;
    const float side = (falls != 0u) ? -1.0f : 1.0f;
    const float way = (turns != 0u) ? from_last : from_turn;
    const float left0 = (turns != 0u) ? self->back[0] : self->left[0];
    const float left1 = (turns != 0u) ? self->back[1] : self->left[1];
    const float e0 = everything_hysteresis_decay(way);
    const float e1 = e0 * e0;
    const float d0 = 1.0f - left0 * e0;
    const float d1 = 1.0f - left1 * e1;

    next->turn = (turns != 0u) ? self->last : self->turn;
    next->left[0] = left0;
    next->back[0] = 1.0f + d0;
    next->left[1] = left1;
    next->back[1] = 1.0f + d1;
    return side * (everything_hysteresis_duhem_um(d0, &everything_hysteresis_duhem[0]) + everything_hysteresis_duhem_um(d1, &everything_hysteresis_duhem[3]));
}

EVERYTHING_CODE
static float everything_hysteresis_apply(everything_hysteresis_t *self, float v)
{
    const float x = everything_hysteresis_normalised(v);
    float sum = 0.0f;

    const float z5 = everything_hysteresis_moved(self->play[5], x, everything_hysteresis_play[20]);
    self->play[5] = z5;
    const float z4 = everything_hysteresis_moved(self->play[4], x, everything_hysteresis_play[16]);
    self->play[4] = z4;
    const float z3 = everything_hysteresis_moved(self->play[3], x, everything_hysteresis_play[12]);
    self->play[3] = z3;
    const float z2 = everything_hysteresis_moved(self->play[2], x, everything_hysteresis_play[8]);
    self->play[2] = z2;
    const float z1 = everything_hysteresis_moved(self->play[1], x, everything_hysteresis_play[4]);
    self->play[1] = z1;
    const float z0 = everything_hysteresis_moved(self->play[0], x, everything_hysteresis_play[0]);
    self->play[0] = z0;
    sum = sum + everything_hysteresis_play_um(z5, &everything_hysteresis_play[20]);
    self->sum_um[5] = sum;
    sum = sum + everything_hysteresis_play_um(z4, &everything_hysteresis_play[16]);
    self->sum_um[4] = sum;
    sum = sum + everything_hysteresis_play_um(z3, &everything_hysteresis_play[12]);
    self->sum_um[3] = sum;
    sum = sum + everything_hysteresis_play_um(z2, &everything_hysteresis_play[8]);
    self->sum_um[2] = sum;
    sum = sum + everything_hysteresis_play_um(z1, &everything_hysteresis_play[4]);
    self->sum_um[1] = sum;
    sum = sum + everything_hysteresis_play_um(z0, &everything_hysteresis_play[0]);
    self->sum_um[0] = sum;
    const float memory = everything_hysteresis_followed_um(self, self, x);
    const float curve = everything_hysteresis_curve_um(x);
    const float h = (curve + sum) + memory;

    self->last = x;
    self->h_um = h;
    return h;
}

/* The same, with the state behind it in `next`. */
EVERYTHING_CODE
static float everything_hysteresis_ahead(const everything_hysteresis_t *self, everything_hysteresis_t *next, float v)
{
    next->sum_um[6] = 0.0f;
    const float x = everything_hysteresis_normalised(v);
    float sum = 0.0f;

    const float z5 = everything_hysteresis_moved(self->play[5], x, everything_hysteresis_play[20]);
    next->play[5] = z5;
    const float z4 = everything_hysteresis_moved(self->play[4], x, everything_hysteresis_play[16]);
    next->play[4] = z4;
    const float z3 = everything_hysteresis_moved(self->play[3], x, everything_hysteresis_play[12]);
    next->play[3] = z3;
    const float z2 = everything_hysteresis_moved(self->play[2], x, everything_hysteresis_play[8]);
    next->play[2] = z2;
    const float z1 = everything_hysteresis_moved(self->play[1], x, everything_hysteresis_play[4]);
    next->play[1] = z1;
    const float z0 = everything_hysteresis_moved(self->play[0], x, everything_hysteresis_play[0]);
    next->play[0] = z0;
    sum = sum + everything_hysteresis_play_um(z5, &everything_hysteresis_play[20]);
    next->sum_um[5] = sum;
    sum = sum + everything_hysteresis_play_um(z4, &everything_hysteresis_play[16]);
    next->sum_um[4] = sum;
    sum = sum + everything_hysteresis_play_um(z3, &everything_hysteresis_play[12]);
    next->sum_um[3] = sum;
    sum = sum + everything_hysteresis_play_um(z2, &everything_hysteresis_play[8]);
    next->sum_um[2] = sum;
    sum = sum + everything_hysteresis_play_um(z1, &everything_hysteresis_play[4]);
    next->sum_um[1] = sum;
    sum = sum + everything_hysteresis_play_um(z0, &everything_hysteresis_play[0]);
    next->sum_um[0] = sum;
    const float memory = everything_hysteresis_followed_um(self, next, x);
    const float curve = everything_hysteresis_curve_um(x);
    const float h = (curve + sum) + memory;

    next->last = x;
    next->h_um = h;
    return h;
}

/* At rest under v; returns the output. */
EVERYTHING_CODE
static float everything_hysteresis_init(everything_hysteresis_t *self, float v)
{
    const float x = everything_hysteresis_normalised(v);

    for (uint32_t j = 0u; j < 6u; ++j) {
        const float most = 1.0f - everything_hysteresis_play[4u * j];
        uint32_t beyond;

        self->play[j] = everything_limited(x, -most, most, &beyond);
    }
    self->sum_um[6] = 0.0f;
    for (uint32_t i = 0u; i < 2u; ++i) {
        self->left[i] = 1.0f;
        self->back[i] = 1.0f;
    }
    self->turn = x;
    self->last = x;
    return everything_hysteresis_apply(self, v);
}

/* missed / slope, relative error at most 0.27 %: a Newton step converges with it by a factor of 370 or more. */
EVERYTHING_INLINE float everything_hysteresis_rough_quotient(float missed, float slope)
{
    const float r = everything_float(0x7ef311c7u - everything_bits(slope));

    return (missed * r) * (2.0f - slope * r);
}

/** h [um] and dh/dx [um per half range]. */
typedef struct {
    float um;     /**< Output h, or a part of it [um]. */
    float slope;  /**< Derivative of `um` by the input [um per half range]. */
} everything_hysteresis_ahead_t;

/* Number of plays that the input has taken along when it reaches `ahead`. `taken` rises with the half-width. */
EVERYTHING_INLINE uint32_t everything_hysteresis_count(const float taken[6], float ahead)
{
    return (uint32_t)(ahead > taken[0]) + (uint32_t)(ahead > taken[1]) + (uint32_t)(ahead > taken[2]) + (uint32_t)(ahead > taken[3])
        + (uint32_t)(ahead > taken[4]) + (uint32_t)(ahead > taken[5]);
}

/* c_0 + c_1 x + c_2 x^2 + ... and its derivative */
EVERYTHING_INLINE everything_hysteresis_ahead_t everything_hysteresis_polynomial(const float c[4], float x)
{
    float um = c[3];
    float slope = um;

    um = c[2] + x * um;
    slope = um + x * slope;
    um = c[1] + x * um;
    slope = um + x * slope;
    um = c[0] + x * um;
    const everything_hysteresis_ahead_t found = { um, slope };

    return found;
}

/* b d + c d |d| and its derivative by x, d = 1 - left e */
EVERYTHING_INLINE everything_hysteresis_ahead_t everything_hysteresis_duhem_ahead(float left, float e, const float duhem[3])
{
    const float ahead = left * e;
    const float d = 1.0f - ahead;
    const float size = everything_hysteresis_magnitude(d);
    const float twice = duhem[1] + duhem[1];
    const everything_hysteresis_ahead_t found = { d * (duhem[0] + duhem[1] * size), (duhem[0] + twice * size) * (ahead * duhem[2]) };

    return found;
}

/* The voltage for which everything_hysteresis_apply would return `wanted`; the state does not change. 3 Newton steps
 *     x <- x - (f(x) - side wanted) / f'(x),   f(x) = side h(side x)
 * in the direction of `wanted`; the first x is that of the mean slope. */
EVERYTHING_CODE
static float everything_hysteresis_solve(const everything_hysteresis_t *self, float wanted)
{
    const float way = (wanted - self->h_um) * everything_hysteresis_range[5];
    const uint32_t falls = (uint32_t)(way < 0.0f);
    const float side = (falls != 0u) ? -1.0f : 1.0f;
    const float start = side * self->last;
    const float aim = side * wanted;
    const float *row = &everything_hysteresis_curve[falls * 28u];
    float taken[6];
    const uint32_t turns = falls ^ (uint32_t)(self->last < self->turn);
    const float turn = side * ((turns != 0u) ? self->last : self->turn);
    const float left0 = (turns != 0u) ? self->back[0] : self->left[0];
    const float left1 = (turns != 0u) ? self->back[1] : self->left[1];
    uint32_t beyond;
    float x = everything_flushed(everything_limited(start + side * way, start, 1.0f, &beyond));

    taken[0] = side * self->play[0] + (everything_hysteresis_play[0] - 2.38418579e-07f);
    taken[1] = side * self->play[1] + (everything_hysteresis_play[4] - 2.38418579e-07f);
    taken[2] = side * self->play[2] + (everything_hysteresis_play[8] - 2.38418579e-07f);
    taken[3] = side * self->play[3] + (everything_hysteresis_play[12] - 2.38418579e-07f);
    taken[4] = side * self->play[4] + (everything_hysteresis_play[16] - 2.38418579e-07f);
    taken[5] = side * self->play[5] + (everything_hysteresis_play[20] - 2.38418579e-07f);
    for (uint32_t step = 0u; step < 3u; ++step) {
        const float e0 = everything_power_of_two((x - turn) * everything_hysteresis_rate[0]);
        const float e1 = e0 * e0;
        const everything_hysteresis_ahead_t d0 = everything_hysteresis_duhem_ahead(left0, e0, &everything_hysteresis_duhem[0]);
        const everything_hysteresis_ahead_t d1 = everything_hysteresis_duhem_ahead(left1, e1, &everything_hysteresis_duhem[3]);
        const uint32_t n = everything_hysteresis_count(taken, x);
        const everything_hysteresis_ahead_t moved = everything_hysteresis_polynomial(&row[4u * n], x);
        float missed = moved.um + (side * self->sum_um[n] - aim);
        float slope = moved.slope;

        missed = missed + d0.um;
        slope = slope + d0.slope;
        missed = missed + d1.um;
        slope = slope + d1.slope;
        slope = everything_limited(slope, everything_hysteresis_range[3], everything_hysteresis_range[4], &beyond);
        x = everything_limited(x - everything_hysteresis_rough_quotient(missed, slope), start, 1.0f, &beyond);
        x = everything_flushed(x);
    }
    return everything_hysteresis_range[0] + (side * x) * everything_hysteresis_range[1];
}

/* amount sum_i s_i */
EVERYTHING_INLINE float everything_creep_slow(const everything_creep_t *self)
{
    float sum = self->high[0];

    sum = sum + self->high[1];
    sum = sum + self->high[2];
    sum = sum + self->high[3];
    return everything_creep_amount[0] * sum;
}

EVERYTHING_CODE
static float everything_creep_init(everything_creep_t *self, float x)
{
    for (uint32_t i = 0u; i < 4u; ++i) {
        self->high[i] = x;
        self->low[i] = 0.0f;
    }
    return x + everything_creep_slow(self);
}

/* y = x + amount sum_i s_i,   s_i = s_i + a_i (x - s_i) */
EVERYTHING_INLINE float everything_creep_apply(everything_creep_t *self, float x)
{
    const float y = x + everything_creep_slow(self);
    const float high0 = self->high[0];
    const float t0 = everything_carried(self->low[0], everything_creep_rate[0] * (x - high0));
    const float high1 = self->high[1];
    const float t1 = everything_carried(self->low[1], everything_creep_rate[1] * (x - high1));
    const float high2 = self->high[2];
    const float t2 = everything_carried(self->low[2], everything_creep_rate[2] * (x - high2));
    const float high3 = self->high[3];
    const float t3 = everything_carried(self->low[3], everything_creep_rate[3] * (x - high3));

    self->low[0] = everything_lost(high0, t0);
    self->high[0] = everything_total(high0, t0);
    self->low[1] = everything_lost(high1, t1);
    self->high[1] = everything_total(high1, t1);
    self->low[2] = everything_lost(high2, t2);
    self->high[2] = everything_total(high2, t2);
    self->low[3] = everything_lost(high3, t3);
    self->high[3] = everything_total(high3, t3);
    return y;
}

/* The same, with the state behind it in `next`. */
EVERYTHING_INLINE float everything_creep_ahead(const everything_creep_t *self, everything_creep_t *next, float x)
{
    const float y = x + everything_creep_slow(self);
    const float high0 = self->high[0];
    const float t0 = everything_carried(self->low[0], everything_creep_rate[0] * (x - high0));
    const float high1 = self->high[1];
    const float t1 = everything_carried(self->low[1], everything_creep_rate[1] * (x - high1));
    const float high2 = self->high[2];
    const float t2 = everything_carried(self->low[2], everything_creep_rate[2] * (x - high2));
    const float high3 = self->high[3];
    const float t3 = everything_carried(self->low[3], everything_creep_rate[3] * (x - high3));

    next->low[0] = everything_lost(high0, t0);
    next->high[0] = everything_total(high0, t0);
    next->low[1] = everything_lost(high1, t1);
    next->high[1] = everything_total(high1, t1);
    next->low[2] = everything_lost(high2, t2);
    next->high[2] = everything_total(high2, t2);
    next->low[3] = everything_lost(high3, t3);
    next->high[3] = everything_total(high3, t3);
    return y;
}

/* x = y - amount sum_i s_i */
EVERYTHING_INLINE float everything_creep_solve(const everything_creep_t *self, float wanted)
{
    return wanted - everything_creep_slow(self);
}


/* sum_j q_j (Re M_j position_j - Im M_j velocity_j) */
EVERYTHING_INLINE float everything_modes_moving(const float position[1], const float velocity[1])
{
    float sum = everything_modes_of_position[0] * position[0] + everything_modes_of_velocity[0] * velocity[0];

    return sum;
}

EVERYTHING_CODE
static float everything_modes_init(everything_modes_t *self, float x)
{
    for (uint32_t j = 0u; j < 1u; ++j) {
        self->position[j] = x;
        self->position_low[j] = 0.0f;
        self->velocity[j] = 0.0f;
        self->velocity_low[j] = 0.0f;
    }
    return everything_modes_direct[0] * x + everything_modes_moving(self->position, self->velocity);
}

/* w = direct x + the share of the modes;   c = c + s (x - c),  c = position + i velocity */
EVERYTHING_INLINE float everything_modes_apply(everything_modes_t *self, float x)
{
    const float w = everything_modes_direct[0] * x + everything_modes_moving(self->position, self->velocity);
    const float position0 = self->position[0];
    const float velocity0 = self->velocity[0];
    const float away0 = x - position0;
    const float forward0 = everything_carried(self->position_low[0], everything_modes_real[0] * away0 + everything_modes_imag[0] * velocity0);
    const float turn0 = everything_carried(self->velocity_low[0], everything_modes_imag[0] * away0 - everything_modes_real[0] * velocity0);

    self->position_low[0] = everything_lost(position0, forward0);
    self->position[0] = everything_total(position0, forward0);
    self->velocity_low[0] = everything_lost(velocity0, turn0);
    self->velocity[0] = everything_total(velocity0, turn0);
    return w;
}

/* The same, with the state behind it in `next`. */
EVERYTHING_INLINE float everything_modes_ahead(const everything_modes_t *self, everything_modes_t *next, float x)
{
    const float w = everything_modes_direct[0] * x + everything_modes_moving(self->position, self->velocity);
    const float position0 = self->position[0];
    const float velocity0 = self->velocity[0];
    const float away0 = x - position0;
    const float forward0 = everything_carried(self->position_low[0], everything_modes_real[0] * away0 + everything_modes_imag[0] * velocity0);
    const float turn0 = everything_carried(self->velocity_low[0], everything_modes_imag[0] * away0 - everything_modes_real[0] * velocity0);

    next->position_low[0] = everything_lost(position0, forward0);
    next->position[0] = everything_total(position0, forward0);
    next->velocity_low[0] = everything_lost(velocity0, turn0);
    next->velocity[0] = everything_total(velocity0, turn0);
    return w;
}

/* x = (w - the share of the modes) / direct */
EVERYTHING_INLINE float everything_modes_solve(const everything_modes_t *self, float wanted)
{
    return (wanted - everything_modes_moving(self->position, self->velocity)) * everything_modes_per_direct[0];
}

/* Input against the velocities that limits left. */
EVERYTHING_INLINE float everything_modes_calming(const everything_inputs_t *inputs)
{
    float sum = inputs->astray_velocity[0];

    return sum * everything_modes_calm[0];
}

/* What limits left, behind the input x that they add. */
EVERYTHING_INLINE void everything_modes_stray(everything_inputs_t *inputs, float x)
{
    const float position0 = inputs->astray_position[0];
    const float velocity0 = inputs->astray_velocity[0];
    const float away0 = x - position0;
    const float forward0 = everything_modes_real[0] * away0 + everything_modes_imag[0] * velocity0;
    const float turn0 = everything_modes_imag[0] * away0 - everything_modes_real[0] * velocity0;

    inputs->astray_position[0] = everything_flushed(everything_inside(position0 + forward0, 1048576.0f));
    inputs->astray_velocity[0] = everything_flushed(everything_inside(velocity0 + turn0, 1048576.0f));
}


/* No limit has acted, as far as the inverse knows. */
EVERYTHING_INLINE void everything_inputs_straighten(everything_inputs_t *inputs)
{
    inputs->asked_um = 0.0f;
    inputs->astray_um = 0.0f;
    for (uint32_t j = 0u; j < 1u; ++j) {
        inputs->astray_position[j] = 0.0f;
        inputs->astray_velocity[j] = 0.0f;
    }
}

/* At rest under the command u; returns w at rest. */
EVERYTHING_CODE
static float everything_inputs_init(everything_inputs_t *inputs, float u)
{
    float v = u;

    v = everything_saturation_apply(v);
    v = everything_slew_init(&inputs->slew, v);
    v = everything_delay_init(&inputs->delay, v);
    inputs->v_V = v;
    everything_inputs_straighten(inputs);
    uint32_t outside;

    v = everything_flushed(everything_hysteresis_init(&inputs->hysteresis, v));
    v = everything_flushed(everything_creep_init(&inputs->creep, v));
    v = everything_flushed(everything_modes_init(&inputs->modes, v));
    return everything_limited(v, EVERYTHING_W_MIN, EVERYTHING_W_MAX, &outside);
}

/* w of the voltage v that reaches the stage. */
EVERYTHING_INLINE float everything_inputs_respond(everything_hysteresis_t *hysteresis, everything_creep_t *creep, everything_modes_t *modes, float v, float *entered)
{
    uint32_t outside;
    float w = v;

    w = everything_flushed(everything_hysteresis_apply(hysteresis, w));
    w = everything_flushed(everything_creep_apply(creep, w));
    *entered = w;
    w = everything_flushed(everything_modes_apply(modes, w));
    return everything_limited(w, EVERYTHING_W_MIN, EVERYTHING_W_MAX, &outside);
}

/* w of the command u. */
EVERYTHING_INLINE float everything_inputs_apply(everything_inputs_t *inputs, float u)
{
    float v = u;
    float entered;

    v = everything_saturation_apply(v);
    v = everything_slew_apply(&inputs->slew, v);
    v = everything_delay_apply(&inputs->delay, v);
    inputs->v_V = v;
    everything_inputs_straighten(inputs);
    return everything_inputs_respond(&inputs->hysteresis, &inputs->creep, &inputs->modes, v, &entered);
}

/** What the inverse of the path finds besides the command. */
typedef struct {
    float w;               /**< Input of the rules that follows from the command. */
    uint32_t u_clamped;    /**< 1 if the voltage was outside the span. */
    uint32_t unreachable;  /**< 1 if a limit keeps the input of the rules from the wanted one. */
    uint32_t residual;     /**< 1 if the input of the rules is not the wanted one although no limit acted. */
    float astray;          /**< What limits, of this sample and before, add to the input of the rules. */
} everything_found_t;

/* The command for which w is the input of the rules, 3 samples later;
 * the voltage that reaches the stage stays in the span. */
EVERYTHING_CODE
static float everything_inputs_invert(everything_inputs_t *inputs, float w, everything_span_t span,
    everything_found_t *found)
{
    everything_hysteresis_t hysteresis;
    everything_creep_t creep;
    everything_modes_t modes;
    uint32_t beyond;
    const float wanted = everything_limited(w, EVERYTHING_W_MIN, EVERYTHING_W_MAX, &beyond);
    float solved = wanted;
    const float led = everything_flushed(everything_modes_moving(inputs->astray_position, inputs->astray_velocity));
    const float calm = everything_modes_calming(inputs);
    float entered;
    float later;

    /* What arrives next depends on the command that follows: the responses are one sample behind, and a copy of them
     * goes ahead by the voltage that the call before asked for. */
    float w_ahead = everything_flushed(everything_hysteresis_ahead(&inputs->hysteresis, &hysteresis, inputs->v_V));
    w_ahead = everything_flushed(everything_creep_ahead(&inputs->creep, &creep, w_ahead));
    (void)everything_modes_ahead(&inputs->modes, &modes, w_ahead);
    solved = everything_flushed(everything_modes_solve(&modes, solved + led));
    const float asked = solved;

    solved = solved + calm;
    solved = everything_flushed(everything_creep_solve(&creep, solved));
    solved = everything_flushed(everything_hysteresis_solve(&hysteresis, solved));
    const float allowed = everything_allowed(solved, span, &found->u_clamped);
    float v = allowed;

    v = everything_saturation_apply(v);
    v = everything_slew_apply(&inputs->slew, v);
    float u = v;

    u = everything_delay_command(&inputs->delay, u);
    inputs->v_V = v;
    found->w = everything_inputs_respond(&hysteresis, &creep, &modes, v, &entered);
    const float arrived = everything_delay_arrived(&inputs->delay);

    (void)everything_inputs_respond(&inputs->hysteresis, &inputs->creep, &inputs->modes, arrived, &later);

    const float less = found->w - wanted;
    const float more = wanted - found->w;
    const uint32_t missed = (uint32_t)(less > EVERYTHING_W_TOLERANCE) | (uint32_t)(more > EVERYTHING_W_TOLERANCE);
    const uint32_t at_end = (uint32_t)(v <= span.low) | (uint32_t)(v >= span.high);
    const uint32_t held = beyond | found->u_clamped | (uint32_t)(everything_bits(v) != everything_bits(allowed));

    const uint32_t excused = at_end | (uint32_t)(everything_bits(led) != 0u);
    const float off = (held != 0u) ? (entered - asked) : calm;

    found->astray = everything_flushed((everything_modes_direct[0] * off + led) + (wanted - w));
    everything_modes_stray(inputs, off);
    found->unreachable = held | (missed & excused);
    found->residual = missed & ~(held | excused) & 1u;
    return u;
}

/* ---- Terms ----------------------------------------------------------------------------------------------------- */

/* Cosine and sine of 2 pi phase / 2^32, worst error 1.9e-7. The nearest quadrant is taken off in integers; what is left,
 * r in quarters of a turn, |r| <= 1/2, is exact: its bits are the significand of a float in [1, 2), less 1.5. */
EVERYTHING_INLINE void everything_cosine_sine(uint32_t phase, float *cosine, float *sine)
{
    const uint32_t shifted = phase + 0x20000040u;
    const uint32_t quadrant = shifted >> 30;
    const float r = everything_float(((shifted & 0x3fffffffu) >> 7) | 0x3f800000u) - 1.5f;
    const float z = r * r;
    const float zz = z * z;
    const float sine_low = 1.57079637f + -0.64596349f * z;
    const float sine_high = 0.0796802193f + -0.00460214913f * z;
    const float cosine_low = -1.23370051f + 0.253669411f * z;
    const float cosine_high = -0.0208615288f + 0.000906739908f * z;
    const uint32_t s = everything_bits(r * (sine_low + sine_high * zz));
    const uint32_t c = everything_bits(1.0f + z * (cosine_low + cosine_high * zz));
    const uint32_t swap = (s ^ c) & everything_mask(quadrant & 1u);

    *cosine = everything_float((c ^ swap) ^ (((quadrant + 1u) & 2u) << 30));
    *sine = everything_float((s ^ swap) ^ ((quadrant & 2u) << 30));
}

EVERYTHING_CODE
static void everything_periodic_init(everything_periodic_t *self)
{
    for (uint32_t j = 0u; j < 1u; ++j) {
        self->phase[j] = 0u;
        self->phase_low[j] = 0u;
    }
}

EVERYTHING_INLINE void everything_periodic_regressors(const everything_periodic_t *self, float phi[2])
{
    everything_cosine_sine(self->phase[0], &phi[0], &phi[1]);
}

/* The regressors 3 samples later. */
EVERYTHING_INLINE void everything_periodic_regressors_ahead(const everything_periodic_t *self, float phi[2])
{
    everything_cosine_sine(self->phase[0] + EVERYTHING_PREVIEW * everything_periodic_turn_high[0], &phi[0], &phi[1]);
}

EVERYTHING_INLINE void everything_periodic_advance(everything_periodic_t *self)
{
    self->phase_low[0] += everything_periodic_turn_low[0];
    self->phase[0] += everything_periodic_turn_high[0] + (uint32_t)(self->phase_low[0] < everything_periodic_turn_low[0]);
}

EVERYTHING_CODE
static void everything_coupling_init(everything_coupling_t *self)
{
    for (uint32_t c = 0u; c < 1u; ++c) {
        for (uint32_t i = 0u; i < 2u; ++i) {
            self->sample[c][i] = 0.0f;
        }
    }
}

/* The newest sample of channel c; one that is not finite is replaced by the one before. */
EVERYTHING_INLINE uint32_t everything_coupling_channel(everything_coupling_t *self, uint32_t c, float value)
{
    uint32_t rejected;
    uint32_t clamped;
    const float finite = everything_finite(value, everything_coupling_middle[c], &rejected);
    const float inside = everything_limited(finite, everything_coupling_low[c], everything_coupling_high[c], &clamped);
    const uint32_t hold = everything_mask(rejected);
    const uint32_t fresh = everything_bits(inside - everything_coupling_middle[c]);

    self->sample[c][0] = everything_float((fresh & ~hold) | (everything_bits(self->sample[c][0]) & hold));
    return (everything_mask(rejected) & EVERYTHING_STATUS_AUX_REJECTED) | (everything_mask(clamped) & EVERYTHING_STATUS_AUX_CLAMPED);
}

EVERYTHING_INLINE uint32_t everything_coupling_listen(everything_coupling_t *self, const float aux[EVERYTHING_CHANNELS])
{
    uint32_t status = 0u;

    status |= everything_coupling_channel(self, 0u, aux[0]);
    return status;
}

EVERYTHING_INLINE void everything_coupling_regressors(const everything_coupling_t *self, float phi[2])
{
    phi[0] = self->sample[0][0];
    phi[1] = self->sample[0][1];
}

EVERYTHING_INLINE void everything_coupling_advance(everything_coupling_t *self)
{
    self->sample[0][1] = self->sample[0][0];
}

EVERYTHING_CODE
static void everything_drift_init(everything_drift_t *self)
{
    self->bias_um = 0.0f;
    self->bias_low_um = 0.0f;
}

/* b = b + g (y(k) - yhat(k)), limited */
EVERYTHING_INLINE void everything_drift_correct(everything_drift_t *self, float innovation)
{
    uint32_t clamped;

    everything_accumulate(&self->bias_um, &self->bias_low_um, everything_drift_rate[0] * innovation);
    self->bias_um = everything_limited(self->bias_um, -everything_drift_limit[0], everything_drift_limit[0], &clamped);
}

EVERYTHING_INLINE void everything_drift_regressors(const everything_drift_t *self, float phi[1])
{
    phi[0] = self->bias_um;
}

EVERYTHING_INLINE void everything_drift_advance(everything_drift_t *self)
{
    (void)self;
}

EVERYTHING_CODE
static void everything_terms_init(everything_terms_t *terms)
{
    everything_periodic_init(&terms->periodic);
    everything_coupling_init(&terms->coupling);
    everything_drift_init(&terms->drift);
}

/* phi(k), in the order of the weights. */
EVERYTHING_INLINE void everything_terms_regressors(const everything_terms_t *terms, float phi[EVERYTHING_WEIGHTS])
{
    everything_periodic_regressors(&terms->periodic, &phi[0]);
    everything_coupling_regressors(&terms->coupling, &phi[2]);
    everything_drift_regressors(&terms->drift, &phi[4]);
}

/* y(k) - yhat(k) corrects the terms that follow it. */
EVERYTHING_INLINE void everything_terms_correct(everything_terms_t *terms, float innovation)
{
    everything_drift_correct(&terms->drift, innovation);
}

/* The auxiliary channels of this sample; bits for the status word. */
EVERYTHING_INLINE uint32_t everything_terms_listen(everything_terms_t *terms, const float aux[EVERYTHING_CHANNELS])
{
    uint32_t status = 0u;

    status |= everything_coupling_listen(&terms->coupling, aux);
    return status;
}

/* One sample later. */
EVERYTHING_INLINE void everything_terms_advance(everything_terms_t *terms)
{
    everything_periodic_advance(&terms->periodic);
    everything_coupling_advance(&terms->coupling);
    everything_drift_advance(&terms->drift);
}

/* sum_j theta_j phi_j(k). */
EVERYTHING_INLINE float everything_terms_sum(const everything_bank_t *bank, const everything_terms_t *terms)
{
    float phi[EVERYTHING_WEIGHTS];
    float sum;

    everything_terms_regressors(terms, phi);
    sum = bank->weight[0] * phi[0];
    sum = sum + bank->weight[1] * phi[1];
    sum = sum + bank->weight[2] * phi[2];
    sum = sum + bank->weight[3] * phi[3];
    sum = sum + bank->weight[4] * phi[4];
    return sum;
}

/* The same sum for the inverse, whose arguments belong to sample k + 3. */
EVERYTHING_INLINE float everything_terms_sum_ahead(const everything_bank_t *bank, const everything_terms_t *terms)
{
    float phi[EVERYTHING_WEIGHTS];
    float sum;

    everything_periodic_regressors_ahead(&terms->periodic, &phi[0]);
    everything_coupling_regressors(&terms->coupling, &phi[2]);
    everything_drift_regressors(&terms->drift, &phi[4]);
    sum = bank->weight[0] * phi[0];
    sum = sum + bank->weight[1] * phi[1];
    sum = sum + bank->weight[2] * phi[2];
    sum = sum + bank->weight[3] * phi[3];
    sum = sum + bank->weight[4] * phi[4];
    return sum;
}

/* ---- Feedback -------------------------------------------------------------------------------------------------- */

/* Without correction, at rest, with the integral of the design. */
EVERYTHING_INLINE void everything_loop_init(everything_loop_t *loop)
{
    loop->correction_um = 0.0f;
    loop->before_um = 0.0f;
    loop->half = EVERYTHING_LOOP_HALF;
    for (uint32_t j = 0u; j < 1u; ++j) {
        loop->position[j] = 0.0f;
        loop->velocity[j] = 0.0f;
    }
}

/* f = direct r + sum_j (p_j position_j + v_j velocity_j), and the modes of the filter behind it. */
EVERYTHING_INLINE float everything_loop_filter(everything_loop_t *loop, float x)
{
    float sum = everything_notches_of_position[0] * loop->position[0] + everything_notches_of_velocity[0] * loop->velocity[0];

    const float position0 = loop->position[0];
    const float velocity0 = loop->velocity[0];
    const float away0 = x - position0;
    const float forward0 = everything_notches_real[0] * away0 + everything_notches_imag[0] * velocity0;
    const float turn0 = everything_notches_imag[0] * away0 - everything_notches_real[0] * velocity0;

    loop->position[0] = everything_flushed(everything_inside(position0 + forward0, 1048576.0f));
    loop->velocity[0] = everything_flushed(everything_inside(velocity0 + turn0, 1048576.0f));
    return everything_flushed(everything_notches_direct[0] * x + sum);
}

/* c(k) = c(k-1) + K/2 (f(k) + f(k-1)), f = F of the residual; it stands still at a limit that it would move beyond. */
EVERYTHING_CODE
float everything_correct(everything_t *self, float residual_um)
{
    everything_events_t events = { 0u, 0u, 0u, 0u };
    const float finite = everything_finite(residual_um, 0.0f, &events.y_rejected);
    const float residual = everything_limited(finite, -EVERYTHING_LOOP_REACH_UM, EVERYTHING_LOOP_REACH_UM, &events.y_clamped);
    const float before = self->loop.correction_um;
    const float moves = everything_loop_filter(&self->loop, residual);
    const float step = everything_flushed(self->loop.half * (moves + self->loop.before_um));
    const uint32_t at_top = (uint32_t)(self->u_V >= self->high_V);
    const uint32_t at_bottom = (uint32_t)(self->u_V <= self->low_V);
    const uint32_t winds = (at_top & (uint32_t)(step > 0.0f)) | (at_bottom & (uint32_t)(step < 0.0f));
    uint32_t limited;
    const float moved = everything_flushed(everything_limited(before + step, -EVERYTHING_LOOP_LIMIT_UM, EVERYTHING_LOOP_LIMIT_UM, &limited));
    const float correction = (winds != 0u) ? before : moved;

    self->loop.before_um = moves;
    self->loop.correction_um = correction;
    everything_count_events(self, &events);
    return correction;
}

/* ---- Prediction ------------------------------------------------------------------------------------------------ */

EVERYTHING_CODE
void everything_init(everything_t *self, float y_um, float u_V)
{
    everything_events_t events;

    for (uint32_t b = 0u; b < 2u; ++b) {
        for (uint32_t l = 0u; l < EVERYTHING_BANK_RULES; ++l) {
            self->bank[b].slope[l] = everything_slope[l];
            self->bank[b].offset[l] = everything_offset[l];
            self->bank[b].gain[l] = everything_gain[l];
        }
        for (uint32_t j = 0u; j < EVERYTHING_WEIGHTS; ++j) {
            self->bank[b].weight[j] = everything_weight[j];
        }
    }
    self->active = 0u;
    self->status = 0u;
    self->y_clamped = 0u;
    self->u_clamped = 0u;
    self->y_rejected = 0u;
    self->u_rejected = 0u;
    self->y_um = EVERYTHING_Y_REST_UM;
    self->u_V = EVERYTHING_U_REST_V;
    self->y_um = everything_checked_y(self, y_um, &events);
    self->u_V = everything_checked_u(self, u_V, &events);
    everything_count_events(self, &events);
    self->low_V = EVERYTHING_U_MIN_V;
    self->high_V = EVERYTHING_U_MAX_V;
    self->step_V = EVERYTHING_U_STEP_MAX_V;
    (void)everything_inputs_init(&self->inputs, self->u_V);
    everything_terms_init(&self->terms);
    everything_loop_init(&self->loop);
}

EVERYTHING_CODE
void everything_aux(everything_t *self, const float aux[EVERYTHING_CHANNELS])
{
    self->status |= everything_terms_listen(&self->terms, aux);
}

/* The model's output under the input u that reaches the stage, Eq. (4), with base = y S + O; the input acts on the state. */
EVERYTHING_INLINE float everything_apply(everything_t *self, float base, float gain, float per_weight, float extra, float u)
{
    const float rules = (base + u * gain) * per_weight;
    const float y_next = everything_flushed(rules + extra);

    everything_terms_advance(&self->terms);
    self->y_um = y_next;
    return y_next;
}

/* y(k+1) from measured y(k) and u(k). */
EVERYTHING_CODE
float everything_predict(everything_t *self, float y_um, float u_V)
{
    const everything_bank_t *bank = &self->bank[self->active];
    everything_events_t events;
    const float y = everything_checked_y(self, y_um, &events);
    const float u = everything_checked_u(self, u_V, &events);
    const float w = everything_inputs_apply(&self->inputs, u);
    const everything_sums_t sums = everything_rule_sums(bank, y);

    everything_terms_correct(&self->terms, y - self->y_um);

    const float extra = everything_terms_sum(bank, &self->terms);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = everything_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = everything_apply(self, base, sums.gain, per_weight, extra, w);

    everything_count_events(self, &events);
    return y_next;
}

/* ---- Free run -------------------------------------------------------------------------------------------------- */

/* y(k+1) from the last output and u(k). */
EVERYTHING_CODE
float everything_simulate(everything_t *self, float u_V)
{
    const everything_bank_t *bank = &self->bank[self->active];
    everything_events_t events = { 0u, 0u, 0u, 0u };
    const float y = everything_limited(self->y_um, EVERYTHING_Y_MIN_UM, EVERYTHING_Y_MAX_UM, &events.y_clamped);
    const float u = everything_checked_u(self, u_V, &events);
    const float w = everything_inputs_apply(&self->inputs, u);
    const everything_sums_t sums = everything_rule_sums(bank, y);
    const float extra = everything_terms_sum(bank, &self->terms);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = everything_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = everything_apply(self, base, sums.gain, per_weight, extra, w);

    everything_count_events(self, &events);
    return y_next;
}

/* ---- Inverse --------------------------------------------------------------------------------------------------- */

EVERYTHING_CODE
void everything_limits(everything_t *self, float low_V, float high_V, float step_V)
{
    uint32_t acted;
    const float low = everything_finite(low_V, EVERYTHING_U_MIN_V, &acted);
    const float high = everything_finite(high_V, EVERYTHING_U_MAX_V, &acted);
    const float step = everything_finite(step_V, EVERYTHING_U_STEP_MAX_V, &acted);

    self->low_V = everything_limited(low, EVERYTHING_U_MIN_V, EVERYTHING_U_MAX_V, &acted);
    self->high_V = everything_limited(high, self->low_V, EVERYTHING_U_MAX_V, &acted);
    self->step_V = everything_limited(step, 0.0f, EVERYTHING_U_STEP_MAX_V, &acted);
}

/* u(k) that takes y(k) to y(k+1): (y(k+1) - sum theta phi) W = y S + O + u G, solved for u. */
EVERYTHING_CODE
float everything_inverse(everything_t *self, float y_um, float y_next_um)
{
    const everything_bank_t *bank = &self->bank[self->active];
    everything_events_t events = { 0u, 0u, 0u, 0u };
    uint32_t rejected;
    uint32_t clamped;
    const float y = everything_checked_y(self, y_um, &events);
    const everything_sums_t sums = everything_rule_sums(bank, y);
    const float extra = everything_terms_sum_ahead(bank, &self->terms);
    const everything_span_t span = everything_span(self, self->inputs.v_V);
    const float finite = everything_finite(y_next_um, y, &rejected);
    const float wanted = everything_limited(finite, EVERYTHING_REFERENCE_MIN_UM, EVERYTHING_REFERENCE_MAX_UM, &clamped);
    const float base = y * sums.slope + sums.offset;
    /* Where a limit led the model astray, it goes on from where it was asked to be. */
    const float led_um = self->inputs.astray_um;
    const float start_um = (everything_bits(led_um) != 0u) ? self->inputs.asked_um : y;
    const float numerator = (wanted - extra) * sums.weight - (start_um * sums.slope + sums.offset);
    const float per_gain = everything_reciprocal(sums.gain);
    const float per_weight = everything_reciprocal(sums.weight);
    const float exact = everything_flushed(numerator * per_gain);
    everything_found_t found;
    const float u = everything_inputs_invert(&self->inputs, exact, span, &found);
    const uint32_t unreachable = found.unreachable;
    const float moved_um = (sums.slope * led_um + sums.gain * found.astray) * per_weight;

    const float astray_um = everything_flushed(everything_inside(moved_um, 1048576.0f));

    self->inputs.astray_um = astray_um;
    self->inputs.asked_um = (everything_bits(astray_um) != 0u) ? wanted : 0.0f;

    self->status |= (clamped * EVERYTHING_STATUS_REFERENCE_CLAMPED) | (unreachable * EVERYTHING_STATUS_UNREACHABLE);
    self->status |= found.residual * EVERYTHING_STATUS_INVERSE_RESIDUAL;
    events.u_clamped = found.u_clamped;
    events.y_rejected |= rejected;
    everything_count_events(self, &events);
    self->u_V = u;
    (void)everything_apply(self, base, sums.gain, per_weight, extra, found.w);
    return u;
}
