/* everything.c: the algorithm of model `everything`; changes only with the model's structure. Interface: everything.h. */

#include "everything.h"

#include "everything_params.h"

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
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__) && defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__GNUC__)
#define EVERYTHING_INLINE static inline __attribute__((always_inline))
#else
#define EVERYTHING_INLINE static inline
#endif

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

/** What happened to the inputs during one call: each 0 or 1. */
typedef struct {
    uint32_t y_clamped;   /**< y was outside its range */
    uint32_t u_clamped;   /**< u was outside its range */
    uint32_t y_rejected;  /**< y was not finite */
    uint32_t u_rejected;  /**< u was not finite */
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
    float slope;   /**< sum v_l q_l1 */
    float offset;  /**< sum v_l q_l3 */
    float gain;    /**< sum v_l q_l2 */
    float weight;  /**< sum v_l */
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

/* ---- Input blocks ---------------------------------------------------------------------------------------------- */

/* v = min(max(u, low), high) */
EVERYTHING_INLINE float everything_saturation_apply(float u)
{
    uint32_t clipped;

    return everything_limited(u, everything_saturation_low[0], everything_saturation_high[0], &clipped);
}

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

/* At rest under the command u; returns v at rest. */
static float everything_inputs_init(everything_inputs_t *inputs, float u)
{
    float v = u;

    v = everything_saturation_apply(v);
    v = everything_slew_init(&inputs->slew, v);
    v = everything_delay_init(&inputs->delay, v);
    inputs->v_V = v;
    return v;
}

/* v of the command u. */
EVERYTHING_INLINE float everything_inputs_apply(everything_inputs_t *inputs, float u)
{
    float v = u;

    v = everything_saturation_apply(v);
    v = everything_slew_apply(&inputs->slew, v);
    v = everything_delay_apply(&inputs->delay, v);
    inputs->v_V = v;
    return v;
}

/** What the inverse of the input blocks finds besides the command. */
typedef struct {
    float v;               /**< input of the rules that follows from the command */
    uint32_t u_clamped;    /**< 1: the voltage lay outside the input range */
    uint32_t unreachable;  /**< 1: a limit keeps the stage from the wanted input */
} everything_found_t;

/* The command for which `solved` reaches the stage, or the nearest voltage to it. */
EVERYTHING_INLINE float everything_inputs_invert(everything_inputs_t *inputs, float solved, everything_found_t *found)
{
    const float allowed = everything_limited(solved, EVERYTHING_U_MIN_V, EVERYTHING_U_MAX_V, &found->u_clamped);
    float u = allowed;

    u = everything_saturation_apply(u);
    u = everything_slew_apply(&inputs->slew, u);
    found->v = u;
    found->unreachable = found->u_clamped | (uint32_t)(everything_bits(u) != everything_bits(allowed));
    u = everything_delay_command(&inputs->delay, u);
    inputs->v_V = found->v;
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

static void everything_memory_init(everything_memory_t *self, float u)
{
    for (uint32_t j = 0u; j < 4u; ++j) {
        self->play[j] = u;
    }
}

EVERYTHING_INLINE void everything_memory_regressors(const everything_memory_t *self, float phi[4])
{
    phi[0] = self->play[0];
    phi[1] = self->play[1];
    phi[2] = self->play[2];
    phi[3] = self->play[3];
}

/* z = max(u - r, min(u + r, z)) */
EVERYTHING_INLINE float everything_memory_play(float z, float u, float half_width)
{
    const float low = u - half_width;
    const float high = u + half_width;
    const float pulled = (z > high) ? high : z;

    return (pulled < low) ? low : pulled;
}

EVERYTHING_INLINE void everything_memory_advance(everything_memory_t *self, float u)
{
    self->play[0] = everything_memory_play(self->play[0], u, everything_memory_half_width[0]);
    self->play[1] = everything_memory_play(self->play[1], u, everything_memory_half_width[1]);
    self->play[2] = everything_memory_play(self->play[2], u, everything_memory_half_width[2]);
    self->play[3] = everything_memory_play(self->play[3], u, everything_memory_half_width[3]);
}

static void everything_creep_init(everything_creep_t *self, float u)
{
    for (uint32_t j = 0u; j < 3u; ++j) {
        self->high[j] = u;
        self->low[j] = 0.0f;
    }
}

EVERYTHING_INLINE void everything_creep_regressors(const everything_creep_t *self, float phi[3])
{
    phi[0] = self->high[0];
    phi[1] = self->high[1];
    phi[2] = self->high[2];
}

/* s = s + a (u - s) */
EVERYTHING_INLINE void everything_creep_advance(everything_creep_t *self, float u)
{
    everything_accumulate(&self->high[0], &self->low[0], everything_creep_rate[0] * (u - self->high[0]));
    everything_accumulate(&self->high[1], &self->low[1], everything_creep_rate[1] * (u - self->high[1]));
    everything_accumulate(&self->high[2], &self->low[2], everything_creep_rate[2] * (u - self->high[2]));
}

static void everything_resonance_init(everything_resonance_t *self, float u)
{
    for (uint32_t j = 0u; j < 1u; ++j) {
        self->position[j] = u;
        self->position_low[j] = 0.0f;
        self->velocity[j] = 0.0f;
        self->velocity_low[j] = 0.0f;
    }
}

EVERYTHING_INLINE void everything_resonance_regressors(const everything_resonance_t *self, float phi[2])
{
    phi[0] = self->position[0];
    phi[1] = self->velocity[0];
}

/* c = c + q (u - c),  c = position + i velocity */
EVERYTHING_INLINE void everything_resonance_turn(everything_resonance_t *self, uint32_t j, float real, float imag, float u)
{
    const float away = u - self->position[j];
    const float velocity = self->velocity[j];

    everything_accumulate(&self->position[j], &self->position_low[j], real * away + imag * velocity);
    everything_accumulate(&self->velocity[j], &self->velocity_low[j], imag * away - real * velocity);
}

EVERYTHING_INLINE void everything_resonance_advance(everything_resonance_t *self, float u)
{
    everything_resonance_turn(self, 0u, everything_resonance_real[0], everything_resonance_imag[0], u);
}

static void everything_periodic_init(everything_periodic_t *self, float u)
{
    (void)u;
    for (uint32_t j = 0u; j < 1u; ++j) {
        self->phase[j] = 0u;
        self->phase_low[j] = 0u;
    }
}

EVERYTHING_INLINE void everything_periodic_regressors(const everything_periodic_t *self, float phi[2])
{
    everything_cosine_sine(self->phase[0], &phi[0], &phi[1]);
}

EVERYTHING_INLINE void everything_periodic_advance(everything_periodic_t *self, float u)
{
    (void)u;
    self->phase_low[0] += everything_periodic_turn_low[0];
    self->phase[0] += everything_periodic_turn_high[0] + (uint32_t)(self->phase_low[0] < everything_periodic_turn_low[0]);
}

static void everything_coupling_init(everything_coupling_t *self, float u)
{
    (void)u;
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

EVERYTHING_INLINE void everything_coupling_advance(everything_coupling_t *self, float u)
{
    (void)u;
    self->sample[0][1] = self->sample[0][0];
}

static void everything_drift_init(everything_drift_t *self, float u)
{
    (void)u;
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

EVERYTHING_INLINE void everything_drift_advance(everything_drift_t *self, float u)
{
    (void)self;
    (void)u;
}

/* Every term at rest under the input u. */
static void everything_terms_init(everything_terms_t *terms, float u)
{
    everything_memory_init(&terms->memory, u);
    everything_creep_init(&terms->creep, u);
    everything_resonance_init(&terms->resonance, u);
    everything_periodic_init(&terms->periodic, u);
    everything_coupling_init(&terms->coupling, u);
    everything_drift_init(&terms->drift, u);
}

/* phi(k), in the order of the weights. */
EVERYTHING_INLINE void everything_terms_regressors(const everything_terms_t *terms, float phi[EVERYTHING_WEIGHTS])
{
    everything_memory_regressors(&terms->memory, &phi[0]);
    everything_creep_regressors(&terms->creep, &phi[4]);
    everything_resonance_regressors(&terms->resonance, &phi[7]);
    everything_periodic_regressors(&terms->periodic, &phi[9]);
    everything_coupling_regressors(&terms->coupling, &phi[11]);
    everything_drift_regressors(&terms->drift, &phi[13]);
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

/* v(k) acts. */
EVERYTHING_INLINE void everything_terms_advance(everything_terms_t *terms, float u)
{
    everything_memory_advance(&terms->memory, u);
    everything_creep_advance(&terms->creep, u);
    everything_resonance_advance(&terms->resonance, u);
    everything_periodic_advance(&terms->periodic, u);
    everything_coupling_advance(&terms->coupling, u);
    everything_drift_advance(&terms->drift, u);
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
    sum = sum + bank->weight[5] * phi[5];
    sum = sum + bank->weight[6] * phi[6];
    sum = sum + bank->weight[7] * phi[7];
    sum = sum + bank->weight[8] * phi[8];
    sum = sum + bank->weight[9] * phi[9];
    sum = sum + bank->weight[10] * phi[10];
    sum = sum + bank->weight[11] * phi[11];
    sum = sum + bank->weight[12] * phi[12];
    sum = sum + bank->weight[13] * phi[13];
    return sum;
}

/* ---- Prediction ------------------------------------------------------------------------------------------------ */

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
    everything_terms_init(&self->terms, everything_inputs_init(&self->inputs, self->u_V));
}

void everything_aux(everything_t *self, const float aux[EVERYTHING_CHANNELS])
{
    self->status |= everything_terms_listen(&self->terms, aux);
}

/* The model's output under the input u that reaches the stage, Eq. (4), with base = y S + O; the input acts on the state. */
EVERYTHING_INLINE float everything_apply(everything_t *self, float base, float gain, float per_weight, float extra, float u)
{
    const float rules = (base + u * gain) * per_weight;
    const float y_next = everything_flushed(rules + extra);

    everything_terms_advance(&self->terms, u);
    self->y_um = y_next;
    return y_next;
}

/* y(k+1) from measured y(k) and u(k). */
float everything_predict(everything_t *self, float y_um, float u_V)
{
    const everything_bank_t *bank = &self->bank[self->active];
    everything_events_t events;
    const float y = everything_checked_y(self, y_um, &events);
    const float u = everything_checked_u(self, u_V, &events);
    const float v = everything_inputs_apply(&self->inputs, u);
    const everything_sums_t sums = everything_rule_sums(bank, y);

    everything_terms_correct(&self->terms, y - self->y_um);

    const float extra = everything_terms_sum(bank, &self->terms);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = everything_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = everything_apply(self, base, sums.gain, per_weight, extra, v);

    everything_count_events(self, &events);
    return y_next;
}

/* ---- Free run -------------------------------------------------------------------------------------------------- */

/* y(k+1) from the last output and u(k). */
float everything_simulate(everything_t *self, float u_V)
{
    const everything_bank_t *bank = &self->bank[self->active];
    everything_events_t events = { 0u, 0u, 0u, 0u };
    const float y = everything_limited(self->y_um, EVERYTHING_Y_MIN_UM, EVERYTHING_Y_MAX_UM, &events.y_clamped);
    const float u = everything_checked_u(self, u_V, &events);
    const float v = everything_inputs_apply(&self->inputs, u);
    const everything_sums_t sums = everything_rule_sums(bank, y);
    const float extra = everything_terms_sum(bank, &self->terms);
    const float base = y * sums.slope + sums.offset;
    const float per_weight = everything_reciprocal(sums.weight);

    self->u_V = u;
    const float y_next = everything_apply(self, base, sums.gain, per_weight, extra, v);

    everything_count_events(self, &events);
    return y_next;
}

/* ---- Inverse --------------------------------------------------------------------------------------------------- */

/* u(k) that takes y(k) to y(k+1): (y(k+1) - sum theta phi) W = y S + O + u G, solved for u. */
float everything_inverse(everything_t *self, float y_um, float y_next_um)
{
    const everything_bank_t *bank = &self->bank[self->active];
    everything_events_t events = { 0u, 0u, 0u, 0u };
    uint32_t rejected;
    uint32_t clamped;
    const float y = everything_checked_y(self, y_um, &events);
    const everything_sums_t sums = everything_rule_sums(bank, y);
    const float extra = everything_terms_sum(bank, &self->terms);
    const float finite = everything_finite(y_next_um, y, &rejected);
    const float wanted = everything_limited(finite, EVERYTHING_REFERENCE_MIN_UM, EVERYTHING_REFERENCE_MAX_UM, &clamped);
    const float base = y * sums.slope + sums.offset;
    const float numerator = (wanted - extra) * sums.weight - base;
    const float per_gain = everything_reciprocal(sums.gain);
    const float per_weight = everything_reciprocal(sums.weight);
    const float exact = everything_flushed(numerator * per_gain);
    everything_found_t found;
    const float u = everything_inputs_invert(&self->inputs, exact, &found);
    const uint32_t unreachable = found.unreachable;

    self->status |= (clamped * EVERYTHING_STATUS_REFERENCE_CLAMPED) | (unreachable * EVERYTHING_STATUS_UNREACHABLE);
    events.u_clamped = found.u_clamped;
    events.y_rejected |= rejected;
    everything_count_events(self, &events);
    self->u_V = u;
    (void)everything_apply(self, base, sums.gain, per_weight, extra, found.v);
    return u;
}
