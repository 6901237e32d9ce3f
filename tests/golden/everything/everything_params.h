/* everything_params.h: the numbers of model `everything`. All that changes when the same structure is identified again.
 *
 * everything.h includes part 1; everything.c defines EVERYTHING_NUMBERS and includes part 2. Every float32 is written with
 * 9 significant digits, which read back to the same bits; the bits of a constant stand in the comment behind it. */

#ifndef EVERYTHING_PARAMS_H
#define EVERYTHING_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define EVERYTHING_NUMBERS_DIGEST "5cee18bf6d6b5304dd6b28881f416e36e067b192058722aa95dc79f5c1f4ccf2"
#define EVERYTHING_NUMBERS_WORD 0x5cee18bfu

/* Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value. */
#define EVERYTHING_Y_MIN_UM              0.66079998f  /* 0x3f292a30 */
#define EVERYTHING_Y_MAX_UM              3.73589993f  /* 0x406f18fc */
#define EVERYTHING_Y_REST_UM             2.19834995f  /* 0x400cb1c4 */
#define EVERYTHING_U_MIN_V                    -20.0f  /* 0xc1a00000 */
#define EVERYTHING_U_MAX_V                    120.0f  /* 0x42f00000 */
#define EVERYTHING_U_REST_V                     0.0f  /* 0x00000000 */
#define EVERYTHING_U_STEP_MAX_V               280.0f  /* 0x438c0000 */
#define EVERYTHING_REFERENCE_MIN_UM     -2.41429996f  /* 0xc01a83e4 */
#define EVERYTHING_REFERENCE_MAX_UM      6.81099987f  /* 0x40d9f3b6 */
#define EVERYTHING_W_MIN                -4.55483723f  /* 0xc091c13a */
#define EVERYTHING_W_MAX                 9.22823048f  /* 0x4113a6d5 */
#define EVERYTHING_W_TOLERANCE       1.31445577e-05f  /* 0x375c8772 */

/* Feedback: half the integral of a sample, largest correction, largest residual. */
#define EVERYTHING_LOOP_HALF      0.0250000004f  /* 0x3ccccccd */
#define EVERYTHING_LOOP_LIMIT_UM   0.300000012f  /* 0x3e99999a */
#define EVERYTHING_LOOP_REACH_UM    3.07509995f  /* 0x4044ce70 */

/* Error of one step from any state. FOUND: the largest against float64 over 20000 samples of the
 * whole range, rounded up; larger ones exist. PATH: part of the path, of w; INVERSE: of y(k+1) against
 * the reference where no limit acts.
 * BOUND: proved against real arithmetic, for every input and state and these numbers;
 * ANY_BANK: for all numbers that a learner may commit, at the limits of its parameters. */
#define EVERYTHING_PREDICT_FOUND_UM  1.30000001e-06f  /* 0x35ae7ba9 */
#define EVERYTHING_PATH_FOUND        6.60000012e-07f  /* 0x35312adb */
#define EVERYTHING_INVERSE_FOUND_UM  9.79999982e-07f  /* 0x3583888b */
#define EVERYTHING_CORRECT_FOUND_UM         2.2e-08f  /* 0x32bcfa83 */
#define EVERYTHING_PREDICT_BOUND_UM  3.50000005e-06f  /* 0x366ae18b */
#define EVERYTHING_PATH_BOUND        3.29999989e-06f  /* 0x365d7591 */
#define EVERYTHING_INVERSE_BOUND_UM  3.80000006e-06f  /* 0x367f0381 */
#define EVERYTHING_CORRECT_BOUND_UM  1.19999996e-07f  /* 0x3400d959 */

#endif

#ifdef EVERYTHING_NUMBERS

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/um]. */
#define EVERYTHING_ORIGIN_UM  2.19834995f  /* 0x400cb1c4 */
#define EVERYTHING_PER_STEP   2.34576941f  /* 0x40162116 */

EVERYTHING_TABLE
static const float everything_strength[EVERYTHING_RULES] = {
    0.0439369343f,  0.324652463f,  0.882496893f,  0.882496893f,  0.324652463f, 0.0439369343f,
};

EVERYTHING_TABLE
static const float everything_slope[EVERYTHING_BANK_RULES] = {
    0.0417400859f,  0.309069157f,  0.841902018f,   0.84366703f,  0.311017066f, 0.0421794578f,
};

EVERYTHING_TABLE
static const float everything_offset[EVERYTHING_BANK_RULES] = {
                0.0f,  0.000273185608f,  0.000802452152f,  0.000124537968f, -0.000245697796f, -4.21321929e-05f,
};

EVERYTHING_TABLE
static const float everything_gain[EVERYTHING_BANK_RULES] = {
    0.00224078353f,   0.015751712f,  0.0402569883f,  0.0380610377f,  0.0134571502f, 0.00176744792f,
};

/* Input block `saturation`: input saturates at -15 and 110 V. */

EVERYTHING_TABLE
static const float everything_saturation_low[1] = {
    -15.0f,
};

EVERYTHING_TABLE
static const float everything_saturation_high[1] = {
    110.0f,
};

/* Input block `slew`: input slews at most 2e+06 V/s up and 1.5e+06 V/s down. */

EVERYTHING_TABLE
static const float everything_slew_rise[1] = {
    40.0f,
};

EVERYTHING_TABLE
static const float everything_slew_fall[1] = {
    30.0f,
};

/* Input block `delay`: input delayed by 2.4 samples. */

EVERYTHING_TABLE
static const float everything_delay_part[1] = {
    0.400000006f,
};

/* Input block `hysteresis`: 6 plays of degree 3, 2 Duhem states, curve of degree 3. */

EVERYTHING_TABLE
static const float everything_hysteresis_range[6] = {
            50.0f,         70.0f, 0.0142857144f,   1.08666754f,   2.10994387f,  0.711679876f,
};

EVERYTHING_TABLE
static const float everything_hysteresis_curve[56] = {
      2.13800001f,   1.16999996f,  0.100000001f, 0.0399999991f,   2.13251615f,   1.22633803f,  0.102838382f, 0.0439999998f,
      2.11999369f,   1.28215241f,  0.104169682f, 0.0480000004f,   2.09970713f,   1.33782876f,   0.10382849f, 0.0520000011f,
      2.07109523f,   1.39387393f,   0.10169743f, 0.0560000017f,   2.03362322f,   1.45088291f,  0.097683832f, 0.0599999987f,
      1.98671603f,   1.50952315f, 0.0917103887f,  0.064000003f,  -2.13800001f,   1.16999996f, -0.100000001f, 0.0399999991f,
     -2.14355874f,   1.22788692f, -0.105161622f, 0.0439999998f,  -2.15647697f,   1.28725946f, -0.111830316f, 0.0480000004f,
     -2.17781043f,   1.34872413f,  -0.12017151f, 0.0520000011f,  -2.20851064f,   1.41294396f, -0.130302578f, 0.0560000017f,
     -2.24955034f,   1.48063791f, -0.142316177f, 0.0599999987f,  -2.30198359f,   1.55257595f, -0.156289607f,  0.064000003f,
};

EVERYTHING_TABLE
static const float everything_hysteresis_play[24] = {
     0.0968015566f,         0.057f, 0.00400000019f, 0.00400000019f,    0.22239159f,         0.057f, 0.00400000019f, 0.00400000019f,
        0.3617661f,         0.057f, 0.00400000019f, 0.00400000019f,   0.510921717f,         0.057f, 0.00400000019f, 0.00400000019f,
       0.66779989f,         0.057f, 0.00400000019f, 0.00400000019f,   0.831120253f,         0.057f, 0.00400000019f, 0.00400000019f,
};

EVERYTHING_TABLE
static const float everything_hysteresis_rate[1] = {
    -1.80336881f,
};

EVERYTHING_TABLE
static const float everything_hysteresis_duhem[6] = {
      0.0299999993f,  0.00999999978f,           1.25f,   0.0199999996f, 9.09494702e-13f,            2.5f,
};

/* Input block `creep`: creep by 0.01 per state, 4 states of 0.001 .. 1 s. */

EVERYTHING_TABLE
static const float everything_creep_rate[4] = {
      0.0198013261f,  0.00199800124f, 0.000199980001f, 1.99997994e-05f,
};

EVERYTHING_TABLE
static const float everything_creep_amount[1] = {
    0.00999999978f,
};

/* Input block `modes`: modes at 730 Hz (damping 0.05, share 0.3). */

EVERYTHING_TABLE
static const float everything_modes_real[1] = {
    0.00875118468f,
};

EVERYTHING_TABLE
static const float everything_modes_imag[1] = {
    0.0910729542f,
};

EVERYTHING_TABLE
static const float everything_modes_of_position[1] = {
    0.29957512f,
};

EVERYTHING_TABLE
static const float everything_modes_of_velocity[1] = {
    -0.00115762639f,
};

EVERYTHING_TABLE
static const float everything_modes_direct[1] = {
    0.70042485f,
};

EVERYTHING_TABLE
static const float everything_modes_per_direct[1] = {
    1.42770481f,
};

EVERYTHING_TABLE
static const float everything_modes_calm[1] = {
    -1.0f,
};

/* Term `periodic`: periodic disturbance at 50 Hz. */

EVERYTHING_TABLE
static const uint32_t everything_periodic_turn_high[1] = {
    0x00418937u,
};

EVERYTHING_TABLE
static const uint32_t everything_periodic_turn_low[1] = {
    0x4bc6a7f1u,
};

/* Term `coupling`: coupling to temperature, 2 samples of each. */

EVERYTHING_TABLE
static const float everything_coupling_low[1] = {
    20.0f,
};

EVERYTHING_TABLE
static const float everything_coupling_high[1] = {
    24.0f,
};

EVERYTHING_TABLE
static const float everything_coupling_middle[1] = {
    22.0f,
};

/* Term `drift`: drift followed over 0.1 s, bias within 0.05 um per sample. */

EVERYTHING_TABLE
static const float everything_drift_rate[1] = {
    0.000199980001f,
};

EVERYTHING_TABLE
static const float everything_drift_limit[1] = {
    0.0500000007f,
};

/* Weights theta of the terms' regressors, in their order. */

EVERYTHING_TABLE
static const float everything_weight[EVERYTHING_WEIGHTS] = {
     9.99999975e-06f, -9.99999975e-06f,  9.99999975e-06f, -9.99999975e-06f,  9.99999975e-06f,
};

/* Filter of the feedback: structure with modes at 1800 Hz (damping 0.8). */

EVERYTHING_TABLE
static const float everything_notches_real[1] = {
    0.17320101f,
};

EVERYTHING_TABLE
static const float everything_notches_imag[1] = {
    0.112904564f,
};

EVERYTHING_TABLE
static const float everything_notches_of_position[1] = {
    0.529950738f,
};

EVERYTHING_TABLE
static const float everything_notches_of_velocity[1] = {
    -0.180296957f,
};

EVERYTHING_TABLE
static const float everything_notches_direct[1] = {
    0.470049232f,
};

#endif
