/* everything_params.h: the numbers of model `everything`. All that changes when the same structure is identified again.
 *
 * Part 1 comes with everything.h. everything.c defines EVERYTHING_NUMBERS for part 2, everything_selftest.c
 * EVERYTHING_SELFTEST_NUMBERS for part 3. Every float32 is written with 9 significant digits, which read back to the bits
 * in the comment behind it. */

#ifndef EVERYTHING_PARAMS_H
#define EVERYTHING_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define EVERYTHING_NUMBERS_DIGEST "fe7851bf8aff66950011b153e6bd3ed954446c6af830f32b99ca4f33bf13faf0"
#define EVERYTHING_NUMBERS_WORD 0xfe7851bfu

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
#define EVERYTHING_W_MIN               -0.710765958f  /* 0xbf35f4c2 */
#define EVERYTHING_W_MAX                 5.38415861f  /* 0x40ac4b07 */
#define EVERYTHING_W_TOLERANCE       5.81257291e-06f  /* 0x36c3099f */

/* Worst error of one step against the float64 model, measured when this file was generated
 * over 20000 samples of the whole range, rounded up.
 * PATH_ERROR: part of the path, of w, along random ramps from rest; INVERSE_ERROR_UM: of y(k+1) against the
 * reference where no limit acts. */
#define EVERYTHING_PREDICT_ERROR_UM  1.09999996e-06f  /* 0x3593a3b6 */
#define EVERYTHING_PATH_ERROR        7.50000027e-07f  /* 0x3549539c */
#define EVERYTHING_INVERSE_ERROR_UM  5.20000015e-07f  /* 0x350b9621 */

#endif

#ifdef EVERYTHING_NUMBERS

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/um]. */
#define EVERYTHING_ORIGIN_UM  2.19834995f  /* 0x400cb1c4 */
#define EVERYTHING_PER_STEP   2.34576941f  /* 0x40162116 */

EVERYTHING_TABLE
static const float everything_strength[EVERYTHING_RULES] = {
      0.0439369343f,  /* 0x3d33f737 */
       0.324652463f,  /* 0x3ea638d9 */
       0.882496893f,  /* 0x3f61eb51 */
       0.882496893f,  /* 0x3f61eb51 */
       0.324652463f,  /* 0x3ea638d9 */
      0.0439369343f,  /* 0x3d33f737 */
};

EVERYTHING_TABLE
static const float everything_slope[EVERYTHING_BANK_RULES] = {
      0.0417400859f,  /* 0x3d2af7a7 */
       0.309069157f,  /* 0x3e9e3e50 */
       0.841902018f,  /* 0x3f5786e4 */
        0.84366703f,  /* 0x3f57fa90 */
       0.311017066f,  /* 0x3e9f3da1 */
      0.0421794578f,  /* 0x3d2cc45e */
};

EVERYTHING_TABLE
static const float everything_offset[EVERYTHING_BANK_RULES] = {
               0.0f,  /* 0x00000000 */
    0.000273185608f,  /* 0x398f3a5a */
    0.000802452152f,  /* 0x3a525ba7 */
    0.000124537968f,  /* 0x39029668 */
    -0.000245697796f,  /* 0xb980d100 */
    -4.21321929e-05f,  /* 0xb830b719 */
};

EVERYTHING_TABLE
static const float everything_gain[EVERYTHING_BANK_RULES] = {
     0.00224078353f,  /* 0x3b12da1c */
       0.015751712f,  /* 0x3c8109bc */
      0.0402569883f,  /* 0x3d24e483 */
      0.0380610377f,  /* 0x3d1be5e4 */
      0.0134571502f,  /* 0x3c5c7b61 */
     0.00176744792f,  /* 0x3ae7a9b6 */
};

/* Input block `saturation`: input saturates at -15 and 110 V. */

EVERYTHING_TABLE
static const float everything_saturation_low[1] = {
             -15.0f,  /* 0xc1700000 */
};

EVERYTHING_TABLE
static const float everything_saturation_high[1] = {
             110.0f,  /* 0x42dc0000 */
};

/* Input block `slew`: input slews at most 2e+06 V/s up and 1.5e+06 V/s down. */

EVERYTHING_TABLE
static const float everything_slew_rise[1] = {
              40.0f,  /* 0x42200000 */
};

EVERYTHING_TABLE
static const float everything_slew_fall[1] = {
              30.0f,  /* 0x41f00000 */
};

/* Input block `delay`: input delayed by 2.4 samples. */

EVERYTHING_TABLE
static const float everything_delay_part[1] = {
       0.400000006f,  /* 0x3ecccccd */
};

/* Input block `hysteresis`: 6 plays of degree 3, 2 Duhem states, curve of degree 3. */

EVERYTHING_TABLE
static const float everything_hysteresis_range[6] = {
              50.0f,  /* 0x42480000 */
              70.0f,  /* 0x428c0000 */
      0.0142857144f,  /* 0x3c6a0ea1 */
        1.08666754f,  /* 0x3f8b17ec */
        2.10994387f,  /* 0x40070952 */
       0.711679876f,  /* 0x3f3630a7 */
};

EVERYTHING_TABLE
static const float everything_hysteresis_curve[56] = {
        2.13800001f,  /* 0x4008d4fe */
        1.16999996f,  /* 0x3f95c28f */
       0.100000001f,  /* 0x3dcccccd */
      0.0399999991f,  /* 0x3d23d70a */
        2.13251615f,  /* 0x40087b25 */
        1.22633803f,  /* 0x3f9cf8a5 */
       0.102838382f,  /* 0x3dd29cee */
      0.0439999998f,  /* 0x3d343958 */
        2.11999369f,  /* 0x4007adfa */
        1.28215241f,  /* 0x3fa41d92 */
       0.104169682f,  /* 0x3dd556ea */
      0.0480000004f,  /* 0x3d449ba6 */
        2.09970713f,  /* 0x4006619a */
        1.33782876f,  /* 0x3fab3df9 */
        0.10382849f,  /* 0x3dd4a408 */
      0.0520000011f,  /* 0x3d54fdf4 */
        2.07109523f,  /* 0x40048cd3 */
        1.39387393f,  /* 0x3fb26a76 */
        0.10169743f,  /* 0x3dd046be */
      0.0560000017f,  /* 0x3d656042 */
        2.03362322f,  /* 0x400226e2 */
        1.45088291f,  /* 0x3fb9b688 */
       0.097683832f,  /* 0x3dc80e76 */
      0.0599999987f,  /* 0x3d75c28f */
        1.98671603f,  /* 0x3ffe4cb6 */
        1.50952315f,  /* 0x3fc1380e */
      0.0917103887f,  /* 0x3dbbd2a8 */
       0.064000003f,  /* 0x3d83126f */
       -2.13800001f,  /* 0xc008d4fe */
        1.16999996f,  /* 0x3f95c28f */
      -0.100000001f,  /* 0xbdcccccd */
      0.0399999991f,  /* 0x3d23d70a */
       -2.14355874f,  /* 0xc0093011 */
        1.22788692f,  /* 0x3f9d2b66 */
      -0.105161622f,  /* 0xbdd75efa */
      0.0439999998f,  /* 0x3d343958 */
       -2.15647697f,  /* 0xc00a03b8 */
        1.28725946f,  /* 0x3fa4c4eb */
      -0.111830316f,  /* 0xbde5074b */
      0.0480000004f,  /* 0x3d449ba6 */
       -2.17781043f,  /* 0xc00b613f */
        1.34872413f,  /* 0x3faca2fe */
       -0.12017151f,  /* 0xbdf61c7b */
      0.0520000011f,  /* 0x3d54fdf4 */
       -2.20851064f,  /* 0xc00d583d */
        1.41294396f,  /* 0x3fb4db59 */
      -0.130302578f,  /* 0xbe056e0a */
      0.0560000017f,  /* 0x3d656042 */
       -2.24955034f,  /* 0xc00ff8a2 */
        1.48063791f,  /* 0x3fbd858b */
      -0.142316177f,  /* 0xbe11bb55 */
      0.0599999987f,  /* 0x3d75c28f */
       -2.30198359f,  /* 0xc01353b3 */
        1.55257595f,  /* 0x3fc6bacf */
      -0.156289607f,  /* 0xbe200a62 */
       0.064000003f,  /* 0x3d83126f */
};

EVERYTHING_TABLE
static const float everything_hysteresis_play[24] = {
      0.0968015566f,  /* 0x3dc63fe5 */
             0.057f,  /* 0x3d6978d5 */
     0.00400000019f,  /* 0x3b83126f */
     0.00400000019f,  /* 0x3b83126f */
        0.22239159f,  /* 0x3e63ba9f */
             0.057f,  /* 0x3d6978d5 */
     0.00400000019f,  /* 0x3b83126f */
     0.00400000019f,  /* 0x3b83126f */
         0.3617661f,  /* 0x3eb93968 */
             0.057f,  /* 0x3d6978d5 */
     0.00400000019f,  /* 0x3b83126f */
     0.00400000019f,  /* 0x3b83126f */
       0.510921717f,  /* 0x3f02cbc4 */
             0.057f,  /* 0x3d6978d5 */
     0.00400000019f,  /* 0x3b83126f */
     0.00400000019f,  /* 0x3b83126f */
        0.66779989f,  /* 0x3f2af4ef */
             0.057f,  /* 0x3d6978d5 */
     0.00400000019f,  /* 0x3b83126f */
     0.00400000019f,  /* 0x3b83126f */
       0.831120253f,  /* 0x3f54c44c */
             0.057f,  /* 0x3d6978d5 */
     0.00400000019f,  /* 0x3b83126f */
     0.00400000019f,  /* 0x3b83126f */
};

EVERYTHING_TABLE
static const float everything_hysteresis_rate[1] = {
       -1.80336881f,  /* 0xbfe6d4ca */
};

EVERYTHING_TABLE
static const float everything_hysteresis_duhem[6] = {
      0.0299999993f,  /* 0x3cf5c28f */
     0.00999999978f,  /* 0x3c23d70a */
              1.25f,  /* 0x3fa00000 */
      0.0199999996f,  /* 0x3ca3d70a */
    9.09494702e-13f,  /* 0x2b800000 */
               2.5f,  /* 0x40200000 */
};

/* Input block `creep`: creep by 0.01 per state, 4 states of 0.001 .. 1 s. */

EVERYTHING_TABLE
static const float everything_creep_rate[4] = {
      0.0198013261f,  /* 0x3ca23664 */
     0.00199800124f,  /* 0x3b02f0e6 */
    0.000199980001f,  /* 0x3951b1b9 */
    1.99997994e-05f,  /* 0x37a7c53e */
};

EVERYTHING_TABLE
static const float everything_creep_amount[1] = {
     0.00999999978f,  /* 0x3c23d70a */
};

/* Input block `modes`: modes at 730 Hz (damping 0.05, share 0.3). */

EVERYTHING_TABLE
static const float everything_modes_real[1] = {
     0.00875118468f,  /* 0x3c0f6121 */
};

EVERYTHING_TABLE
static const float everything_modes_imag[1] = {
      0.0910729542f,  /* 0x3dba8475 */
};

EVERYTHING_TABLE
static const float everything_modes_of_position[1] = {
        0.29957512f,  /* 0x3e9961e9 */
};

EVERYTHING_TABLE
static const float everything_modes_of_velocity[1] = {
    -0.00115762639f,  /* 0xba97bb7f */
};

EVERYTHING_TABLE
static const float everything_modes_direct[1] = {
        0.70042485f,  /* 0x3f334f0b */
};

EVERYTHING_TABLE
static const float everything_modes_per_direct[1] = {
        1.42770481f,  /* 0x3fb6bf08 */
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
              20.0f,  /* 0x41a00000 */
};

EVERYTHING_TABLE
static const float everything_coupling_high[1] = {
              24.0f,  /* 0x41c00000 */
};

EVERYTHING_TABLE
static const float everything_coupling_middle[1] = {
              22.0f,  /* 0x41b00000 */
};

/* Term `drift`: drift followed over 0.1 s, bias within 0.05 um per sample. */

EVERYTHING_TABLE
static const float everything_drift_rate[1] = {
    0.000199980001f,  /* 0x3951b1b9 */
};

EVERYTHING_TABLE
static const float everything_drift_limit[1] = {
      0.0500000007f,  /* 0x3d4ccccd */
};

/* Weights theta of the terms' regressors, in their order. */

EVERYTHING_TABLE
static const float everything_weight[EVERYTHING_WEIGHTS] = {
    9.99999975e-06f,  /* 0x3727c5ac */
    -9.99999975e-06f,  /* 0xb727c5ac */
    9.99999975e-06f,  /* 0x3727c5ac */
    -9.99999975e-06f,  /* 0xb727c5ac */
    9.99999975e-06f,  /* 0x3727c5ac */
};

#endif

#ifdef EVERYTHING_SELFTEST_NUMBERS

/* Self-test: where each function starts, what it is given, and the bits that the float32 reference answers. */

/* predict: arguments, auxiliary channels, expected result. */
#define EVERYTHING_SELFTEST_PREDICT_START_Y 0x400cb1c4u
#define EVERYTHING_SELFTEST_PREDICT_START_U 0x00000000u
#define EVERYTHING_SELFTEST_PREDICT_STATUS 0x000000cfu
#define EVERYTHING_SELFTEST_PREDICT_Y_CLAMPED 5u
#define EVERYTHING_SELFTEST_PREDICT_U_CLAMPED 2u
#define EVERYTHING_SELFTEST_PREDICT_Y_REJECTED 3u
#define EVERYTHING_SELFTEST_PREDICT_U_REJECTED 3u

EVERYTHING_TABLE
static const uint32_t everything_selftest_predict_rows[32][4] = {
    { 0x40130acbu, 0x40e16fbau, 0x41d210e4u, 0x400fed1bu },  /* 2.29753, 7.04489, 26.2582 -> 2.24885 */
    { 0x4018d62eu, 0x42a9dcb1u, 0x41cc2959u, 0x4015796bu },  /* 2.38807, 84.931, 25.5202 -> 2.33554 */
    { 0x000116c2u, 0xf149f2cau, 0x000116c2u, 0x3f3108a2u },  /* 9.99995e-41, -1e+30, 9.99995e-41 -> 0.691538 */
    { 0x4054ca65u, 0x42e2ffafu, 0x4117627au, 0x40501a7cu },  /* 3.32485, 113.499, 9.46154 -> 3.25162 */
    { 0x3fd97f40u, 0x426db281u, 0x4199366cu, 0x3fd8d3ceu },  /* 1.6992, 59.4243, 19.1516 -> 1.69396 */
    { 0x7fc00000u, 0xff800000u, 0xff800000u, 0x3fd9264fu },  /* nan, -inf, -inf -> 1.69648 */
    { 0x4037e929u, 0xc1055a2fu, 0x41644234u, 0x403562c4u },  /* 2.87361, -8.33452, 14.2662 -> 2.83415 */
    { 0x40603901u, 0x42b4ed3bu, 0x40a1dc8au, 0x405c2ce6u },  /* 3.50348, 90.4633, 5.05817 -> 3.44024 */
    { 0x00000000u, 0xc1a00000u, 0x7fc00000u, 0x3f379347u },  /* 0, -20, nan -> 0.717091 */
    { 0x40051f51u, 0x426bce0cu, 0x4056f5dfu, 0x4004b15du },  /* 2.08004, 58.9512, 3.35876 -> 2.07333 */
    { 0x3fffe6ccu, 0x4291b005u, 0x41b120afu, 0x3fff75ecu },  /* 1.99923, 72.8438, 22.141 -> 1.99579 */
    { 0x40d9f3b6u, 0x7fc00000u, 0x7f800000u, 0x406a4e01u },  /* 6.811, nan, inf -> 3.66101 */
    { 0x3ff8895cu, 0x42a43af7u, 0x412c2f8au, 0x3ff9e94cu },  /* 1.94169, 82.1152, 10.7616 -> 1.95243 */
    { 0x403b66d1u, 0x41efe1d4u, 0x41a10c53u, 0x40398976u },  /* 2.92815, 29.9853, 20.131 -> 2.89901 */
    { 0x406f18fcu, 0x42f00000u, 0x42200000u, 0x406b7eb2u },  /* 3.7359, 120, 40 -> 3.67961 */
    { 0x400bbf81u, 0x42bd456eu, 0x419cb17eu, 0x400bcef8u },  /* 2.18356, 94.6356, 19.5867 -> 2.18451 */
    { 0x3fe0ca87u, 0x419110cdu, 0x4133df15u, 0x3fe4aa38u },  /* 1.75618, 18.1332, 11.242 -> 1.78644 */
    { 0x80000000u, 0xc3200000u, 0x42a20000u, 0x3f437408u },  /* -0, -160, 81 -> 0.763489 */
    { 0x40452245u, 0x40247e78u, 0x4146476fu, 0x404373a1u },  /* 3.08022, 2.57022, 12.3924 -> 3.05393 */
    { 0x400623f8u, 0x428ec970u, 0x42076512u, 0x400630a0u },  /* 2.09595, 71.3934, 33.8487 -> 2.09672 */
    { 0xf149f2cau, 0x000116c2u, 0x00000000u, 0x3f3737e1u },  /* -1e+30, 9.99995e-41, 0 -> 0.715696 */
    { 0x40103482u, 0x42e2ea73u, 0x41b45333u, 0x400f3f24u },  /* 2.2532, 113.458, 22.5406 -> 2.23823 */
    { 0x40509284u, 0x40ad7765u, 0x3fb48717u, 0x404cf050u },  /* 3.25894, 5.42082, 1.41037 -> 3.20217 */
    { 0xff800000u, 0x7f800000u, 0xc2280000u, 0x4049ecb0u },  /* -inf, inf, -42 -> 3.15507 */
    { 0x3ffef8acu, 0x42eb0910u, 0x415274bcu, 0x3fffac4bu },  /* 1.99196, 117.518, 13.1535 -> 1.99745 */
    { 0x3ffd6a37u, 0x42cac53cu, 0x40937cdcu, 0x3ffca1d1u },  /* 1.9798, 101.385, 4.60899 -> 1.97369 */
    { 0x7f800000u, 0x80000000u, 0x80000000u, 0x3ffd2b2du },  /* inf, -0, -0 -> 1.97788 */
    { 0x3fff579du, 0x4107ea96u, 0x41a51c30u, 0x40017778u },  /* 1.99486, 8.49477, 20.6388 -> 2.02292 */
    { 0x4005525au, 0x42ce6710u, 0x41cef07au, 0x4006ce62u },  /* 2.08315, 103.201, 25.8674 -> 2.10635 */
    { 0x3f292a30u, 0x00000000u, 0xf149f2cau, 0x3f3d44e1u },  /* 0.6608, 0, -1e+30 -> 0.739332 */
    { 0x4069e6a1u, 0x42b69faeu, 0x420cb568u, 0x40667eeeu },  /* 3.6547, 91.3119, 35.1772 -> 3.6015 */
    { 0x3f554929u, 0xc177c691u, 0x41e1b040u, 0x3f690106u },  /* 0.833148, -15.486, 28.2111 -> 0.910172 */
};

/* simulate: arguments, auxiliary channels, expected result. */
#define EVERYTHING_SELFTEST_SIMULATE_START_Y 0x400cb1c4u
#define EVERYTHING_SELFTEST_SIMULATE_START_U 0x00000000u
#define EVERYTHING_SELFTEST_SIMULATE_STATUS 0x000000cau
#define EVERYTHING_SELFTEST_SIMULATE_Y_CLAMPED 0u
#define EVERYTHING_SELFTEST_SIMULATE_U_CLAMPED 3u
#define EVERYTHING_SELFTEST_SIMULATE_Y_REJECTED 0u
#define EVERYTHING_SELFTEST_SIMULATE_U_REJECTED 2u

EVERYTHING_TABLE
static const uint32_t everything_selftest_simulate_rows[32][3] = {
    { 0x429f4944u, 0x416a15bcu, 0x4009d93fu },  /* 79.6431, 14.6303 -> 2.15388 */
    { 0xbf41a05bu, 0x3f761e21u, 0x400720b6u },  /* -0.756353, 0.961397 -> 2.11137 */
    { 0xc3200000u, 0x7f800000u, 0x40055f45u },  /* -160, inf -> 2.08394 */
    { 0x428d34ddu, 0x41843fbfu, 0x4003a086u },  /* 70.6032, 16.5311 -> 2.05667 */
    { 0x4279bfd0u, 0x4026e2fdu, 0x40010493u },  /* 62.4373, 2.6076 -> 2.0159 */
    { 0x000116c2u, 0xbf800000u, 0x3ffe061du },  /* 9.99995e-41, -1 -> 1.98456 */
    { 0x4202092cu, 0x41a1c4c8u, 0x3ffd17abu },  /* 32.509, 20.2211 -> 1.97728 */
    { 0x4266cbc5u, 0x41a413beu, 0x3ffbff87u },  /* 57.699, 20.5096 -> 1.96874 */
    { 0xf149f2cau, 0x7fc00000u, 0x3ffa1b1cu },  /* -1e+30, nan -> 1.95395 */
    { 0x422115cau, 0x41b34065u, 0x3ff96cc2u },  /* 40.2713, 22.4064 -> 1.94863 */
    { 0x3fc31fb7u, 0x420d82deu, 0x3ff83df6u },  /* 1.52441, 35.3778 -> 1.93939 */
    { 0x43820000u, 0x80000000u, 0x3ff6d955u },  /* 260, -0 -> 1.92851 */
    { 0x415884d8u, 0x40606b8au, 0x3ff4a692u },  /* 13.5324, 3.50656 -> 1.91133 */
    { 0x4261fa3du, 0x40f7ba2du, 0x3ff37af0u },  /* 56.4944, 7.74148 -> 1.90219 */
    { 0x42f00000u, 0xff800000u, 0x3ff24c60u },  /* 120, -inf -> 1.89296 */
    { 0x4217ca18u, 0x41af7546u, 0x3ff1f7deu },  /* 37.9474, 21.9323 -> 1.89038 */
    { 0x401918aeu, 0x41efc4a5u, 0x3ff5099au },  /* 2.39213, 29.971 -> 1.91436 */
    { 0x80000000u, 0xc2280000u, 0x3ff7e14eu },  /* -0, -42 -> 1.93656 */
    { 0xc030b7c5u, 0xbe800ce0u, 0x3ff853ffu },  /* -2.76122, -0.250098 -> 1.94006 */
    { 0x42b4c6a3u, 0x417bd119u, 0x3ff69317u },  /* 90.388, 15.7385 -> 1.92636 */
    { 0xff800000u, 0x000116c2u, 0x3ff3ab1cu },  /* -inf, 9.99995e-41 -> 1.90366 */
    { 0x41cf0dbeu, 0x42056f76u, 0x3ff27d80u },  /* 25.8817, 33.3588 -> 1.89445 */
    { 0x42bd649fu, 0x40a8531au, 0x3ff48d3fu },  /* 94.6965, 5.26014 -> 1.91056 */
    { 0x7fc00000u, 0x42a20000u, 0x3ff678f1u },  /* nan, 81 -> 1.92557 */
    { 0x42b4ea76u, 0x420f9894u, 0x3ff963c8u },  /* 90.4579, 35.899 -> 1.94836 */
    { 0x405df404u, 0x3f6201a9u, 0x3ffe2889u },  /* 3.46802, 0.882838 -> 1.98561 */
    { 0xc1a00000u, 0x42200000u, 0x40016ef6u },  /* -20, 40 -> 2.0224 */
    { 0x42ed8cf3u, 0x413635cbu, 0x4002e8c9u },  /* 118.775, 11.3881 -> 2.04546 */
    { 0x42075ad3u, 0x40d4bc0bu, 0x40033594u },  /* 33.8387, 6.64795 -> 2.05015 */
    { 0x00000000u, 0xf149f2cau, 0x40040226u },  /* 0, -1e+30 -> 2.06263 */
    { 0xc1918f1fu, 0x41237b55u, 0x4004c30cu },  /* -18.1949, 10.2176 -> 2.0744 */
    { 0x42d72899u, 0x41a24316u, 0x400468c6u },  /* 107.579, 20.2828 -> 2.06889 */
};

/* inverse: arguments, auxiliary channels, expected result. */
#define EVERYTHING_SELFTEST_INVERSE_START_Y 0x400cb1c4u
#define EVERYTHING_SELFTEST_INVERSE_START_U 0x00000000u
#define EVERYTHING_SELFTEST_INVERSE_STATUS 0x000000f5u
#define EVERYTHING_SELFTEST_INVERSE_Y_CLAMPED 5u
#define EVERYTHING_SELFTEST_INVERSE_U_CLAMPED 0u
#define EVERYTHING_SELFTEST_INVERSE_Y_REJECTED 5u
#define EVERYTHING_SELFTEST_INVERSE_U_REJECTED 0u

EVERYTHING_TABLE
static const uint32_t everything_selftest_inverse_rows[32][4] = {
    { 0x4059dc88u, 0x4053f6ecu, 0x41479b95u, 0x3c87b667u },  /* 3.40409, 3.31195, 12.4755 -> 0.0165665 */
    { 0x3fbf3b6bu, 0x3fbda4e1u, 0x3ff007f8u, 0x3ccb9199u },  /* 1.494, 1.48159, 1.87524 -> 0.0248497 */
    { 0x406f18fcu, 0x3f292a30u, 0x80000000u, 0xc0c00000u },  /* 3.7359, 0.6608, -0 -> -6 */
    { 0x3f824051u, 0x3f83e3f7u, 0x421c2225u, 0xc0f0dbf6u },  /* 1.01759, 1.03039, 39.0333 -> -7.52685 */
    { 0x3f9065a1u, 0x3f91d02cu, 0x41a3084au, 0x40c958f5u },  /* 1.1281, 1.13917, 20.379 -> 6.29211 */
    { 0xff800000u, 0x80000000u, 0x42a20000u, 0x3dfd1680u },  /* -inf, -0, 81 -> 0.123578 */
    { 0x3f911acdu, 0x3f937b5du, 0x41a23091u, 0x3e4b03c0u },  /* 1.13363, 1.1522, 20.2737 -> 0.198256 */
    { 0x3fa4d84au, 0x3fa6c1cau, 0x41ca4847u, 0x41cc7a0du },  /* 1.28785, 1.30279, 25.2853 -> 25.5596 */
    { 0x80000000u, 0xf149f2cau, 0x42200000u, 0x418b3e86u },  /* -0, -1e+30, 40 -> 17.4055 */
    { 0x3f794288u, 0x3f81a981u, 0x4199a3c4u, 0x41767d0cu },  /* 0.973671, 1.01299, 19.205 -> 15.4055 */
    { 0x3ffbdc0du, 0x3ffb29a0u, 0x40f30d07u, 0x422d344du },  /* 1.96765, 1.96221, 7.59534 -> 43.3011 */
    { 0x7f800000u, 0x40d9f3b6u, 0x000116c2u, 0x428249eeu },  /* inf, 6.811, 9.99995e-41 -> 65.1444 */
    { 0x40350e16u, 0x4032d218u, 0x42011eb0u, 0x429a813au },  /* 2.82898, 2.79407, 32.28 -> 77.2524 */
    { 0x4006ba40u, 0x4006d88du, 0x41b8db8du, 0x427ca4b8u },  /* 2.10512, 2.10697, 23.1072 -> 63.1609 */
    { 0x3f292a30u, 0x000116c2u, 0xf149f2cau, 0x42631f4au },  /* 0.6608, 9.99995e-41, -1e+30 -> 56.7806 */
    { 0x404ec247u, 0x404c6333u, 0x410c78fau, 0x425b1f4au },  /* 3.23061, 3.19355, 8.77954 -> 54.7806 */
    { 0x3f764e8cu, 0x3f84f675u, 0x40741415u, 0x42a50791u },  /* 0.962136, 1.03877, 3.81373 -> 82.5148 */
    { 0x7fc00000u, 0xff800000u, 0x7fc00000u, 0x42983b74u },  /* nan, -inf, nan -> 76.1161 */
    { 0x3fb8c7bcu, 0x3fc0f281u, 0x40ea0454u, 0x42943b74u },  /* 1.4436, 1.5074, 7.31303 -> 74.1161 */
    { 0x3f89abffu, 0x3f94bb7bu, 0x40c65246u, 0x42c7e6f8u },  /* 1.07556, 1.16197, 6.19754 -> 99.9511 */
    { 0x40d9f3b6u, 0x406f18fcu, 0xff800000u, 0x42d33e8cu },  /* 6.811, 3.7359, -inf -> 105.622 */
    { 0x40652288u, 0x4063221au, 0x4218d5d2u, 0x42d2ffb9u },  /* 3.58023, 3.54896, 38.2088 -> 105.499 */
    { 0x4056bef3u, 0x40555b3fu, 0x41921bc7u, 0x42c51ad1u },  /* 3.3554, 3.33369, 18.2636 -> 98.5524 */
    { 0x00000000u, 0x00000000u, 0xc2280000u, 0x42ac8415u },  /* 0, 0, -42 -> 86.258 */
    { 0x4048ff21u, 0x404844e4u, 0x40421597u, 0x429ed2e9u },  /* 3.14057, 3.1292, 3.03257 -> 79.4119 */
    { 0x40314e01u, 0x4031a50du, 0x3fa7b779u, 0x42bf067eu },  /* 2.77039, 2.7757, 1.31029 -> 95.5127 */
    { 0xf149f2cau, 0x7fc00000u, 0x7f800000u, 0x42a52280u },  /* -1e+30, nan, inf -> 82.5674 */
    { 0x4015142du, 0x4016db34u, 0x4219ff23u, 0x42970f96u },  /* 2.32936, 2.35713, 38.4992 -> 75.5304 */
    { 0x3ff463d2u, 0x3ffacb44u, 0x41fcb356u, 0x42b6aa41u },  /* 1.9093, 1.95933, 31.5876 -> 91.3325 */
    { 0x000116c2u, 0x7f800000u, 0x00000000u, 0x429cbcceu },  /* 9.99995e-41, inf, 0 -> 78.3688 */
    { 0x40218d04u, 0x4022e9b2u, 0x414eaf86u, 0x428ea6b0u },  /* 2.52423, 2.54551, 12.9179 -> 71.3256 */
    { 0x4067a433u, 0x4066169bu, 0x41acd8cfu, 0x42adfebcu },  /* 3.6194, 3.59513, 21.6059 -> 86.9975 */
};

#endif
