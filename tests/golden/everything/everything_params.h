/* everything_params.h: the numbers of model `everything`. All that changes when the same structure is identified again.
 *
 * Every float32 is written with 9 significant digits, which read back to the bits in the comment behind it. */

#ifndef EVERYTHING_PARAMS_H
#define EVERYTHING_PARAMS_H

#include <stdint.h>

#include "everything.h"

/* Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value. */
#define EVERYTHING_Y_MIN_UM           0.66079998f  /* 0x3f292a30 */
#define EVERYTHING_Y_MAX_UM           3.73589993f  /* 0x406f18fc */
#define EVERYTHING_Y_REST_UM          2.19834995f  /* 0x400cb1c4 */
#define EVERYTHING_U_MIN_V                 -20.0f  /* 0xc1a00000 */
#define EVERYTHING_U_MAX_V                 120.0f  /* 0x42f00000 */
#define EVERYTHING_U_REST_V                  0.0f  /* 0x00000000 */
#define EVERYTHING_REFERENCE_MIN_UM  -2.41429996f  /* 0xc01a83e4 */
#define EVERYTHING_REFERENCE_MAX_UM   6.81099987f  /* 0x40d9f3b6 */

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/V]. */
#define EVERYTHING_ORIGIN_UM  2.19834995f  /* 0x400cb1c4 */
#define EVERYTHING_PER_STEP   2.34576941f  /* 0x40162116 */

static const float everything_strength[EVERYTHING_RULES] = {
      0.0439369343f,  /* 0x3d33f737 */
       0.324652463f,  /* 0x3ea638d9 */
       0.882496893f,  /* 0x3f61eb51 */
       0.882496893f,  /* 0x3f61eb51 */
       0.324652463f,  /* 0x3ea638d9 */
      0.0439369343f,  /* 0x3d33f737 */
};

static const float everything_slope[EVERYTHING_BANK_RULES] = {
      0.0268937983f,  /* 0x3cdc5062 */
      0.0225958116f,  /* 0x3cb91ada */
       0.530115902f,  /* 0x3f07b5ad */
       0.911089778f,  /* 0x3f693d2e */
       0.270305634f,  /* 0x3e8a6580 */
       0.038370125f,  /* 0x3d1d29fe */
};

static const float everything_offset[EVERYTHING_BANK_RULES] = {
     -0.0112039177f,  /* 0xbc3790a3 */
       0.362019956f,  /* 0x3eb95aae */
        1.02466714f,  /* 0x3f83284b */
      -0.154966459f,  /* 0xbe1eaf87 */
       0.106615864f,  /* 0x3dda596b */
      0.0197320767f,  /* 0x3ca1a52a */
};

static const float everything_gain[EVERYTHING_BANK_RULES] = {
    7.02990947e-05f,  /* 0x38936d8a */
    0.000551909208f,  /* 0x3a10ae00 */
     0.00132374535f,  /* 0x3aad8186 */
     0.00150024472f,  /* 0x3ac4a3dc */
    0.000454513443f,  /* 0x39ee4bc3 */
    9.22675608e-05f,  /* 0x38c17fc5 */
};

/* Input block `saturation`: input saturates at -15 and 110 V. */

static const float everything_saturation_low[1] = {
             -15.0f,  /* 0xc1700000 */
};

static const float everything_saturation_high[1] = {
             110.0f,  /* 0x42dc0000 */
};

/* Input block `slew`: input slews at most 2e+06 V/s up and 1.5e+06 V/s down. */

static const float everything_slew_rise[1] = {
              40.0f,  /* 0x42200000 */
};

static const float everything_slew_fall[1] = {
              30.0f,  /* 0x41f00000 */
};

/* Input block `delay`: input delayed by 2.4 samples. */

static const float everything_delay_part[1] = {
       0.400000006f,  /* 0x3ecccccd */
};

/* Term `memory`: 4 play operators, half-widths 12 .. 48 V. */

static const float everything_memory_half_width[4] = {
              12.0f,  /* 0x41400000 */
              24.0f,  /* 0x41c00000 */
              36.0f,  /* 0x42100000 */
              48.0f,  /* 0x42400000 */
};

/* Term `creep`: creep, a weight for each of the time constants 0.001, 0.1, 10 s. */

static const float everything_creep_rate[3] = {
      0.0198013261f,  /* 0x3ca23664 */
    0.000199980001f,  /* 0x3951b1b9 */
    1.99999795e-06f,  /* 0x360637b4 */
};

/* Term `resonance`: resonance at 730 Hz (damping 0.05). */

static const float everything_resonance_real[1] = {
     0.00875118468f,  /* 0x3c0f6121 */
};

static const float everything_resonance_imag[1] = {
      0.0910729542f,  /* 0x3dba8475 */
};

/* Term `periodic`: periodic disturbance at 50 Hz. */

static const uint32_t everything_periodic_turn_high[1] = {
        0x00418937u,
};

static const uint32_t everything_periodic_turn_low[1] = {
        0x4bc6a7f1u,
};

/* Term `coupling`: coupling to temperature, 2 samples of each. */

static const float everything_coupling_low[1] = {
              20.0f,  /* 0x41a00000 */
};

static const float everything_coupling_high[1] = {
              24.0f,  /* 0x41c00000 */
};

static const float everything_coupling_middle[1] = {
              22.0f,  /* 0x41b00000 */
};

/* Term `drift`: drift followed over 0.1 s, bias within 0.05 um per sample. */

static const float everything_drift_rate[1] = {
    0.000199980001f,  /* 0x3951b1b9 */
};

static const float everything_drift_limit[1] = {
      0.0500000007f,  /* 0x3d4ccccd */
};

/* Weights theta of the terms' regressors, in their order. */

static const float everything_weight[EVERYTHING_WEIGHTS] = {
    9.99999975e-06f,  /* 0x3727c5ac */
    -9.99999975e-06f,  /* 0xb727c5ac */
    9.99999975e-06f,  /* 0x3727c5ac */
    -9.99999975e-06f,  /* 0xb727c5ac */
    9.99999975e-06f,  /* 0x3727c5ac */
    -9.99999975e-06f,  /* 0xb727c5ac */
    9.99999975e-06f,  /* 0x3727c5ac */
    3.16227761e-06f,  /* 0x36543784 */
    -3.16227761e-06f,  /* 0xb6543784 */
    9.99999975e-06f,  /* 0x3727c5ac */
    -9.99999975e-06f,  /* 0xb727c5ac */
    4.99999987e-06f,  /* 0x36a7c5ac */
    -4.99999987e-06f,  /* 0xb6a7c5ac */
    0.000199999995f,  /* 0x3951b717 */
};

/* Worst error of one step against the float64 model, measured when this file was generated
 * over 20000 samples of the whole range, rounded up. */
#define EVERYTHING_PREDICT_ERROR_UM  9.69999974e-07f  /* 0x358230f2 */
#define EVERYTHING_INVERSE_ERROR_V   0.000479999988f  /* 0x39fba882 */

#endif
