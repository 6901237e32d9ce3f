/* everything_params.h: the numbers of model `everything`. All that changes when the same structure is identified again.
 *
 * Every float32 is written with 9 significant digits, which read back to the bits in the comment behind it. */

#ifndef EVERYTHING_PARAMS_H
#define EVERYTHING_PARAMS_H

#include <stdint.h>

#include "everything.h"

#ifndef EVERYTHING_SELFTEST_NUMBERS

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

#else

/* Self-test: where each function starts, what it is given, and the bits that the float32 reference answers. */

/* predict: arguments, auxiliary channels, expected result. */
#define EVERYTHING_SELFTEST_PREDICT_START_Y 0x400cb1c4u
#define EVERYTHING_SELFTEST_PREDICT_START_U 0x00000000u
#define EVERYTHING_SELFTEST_PREDICT_STATUS 0x000000cfu
#define EVERYTHING_SELFTEST_PREDICT_Y_CLAMPED 5u
#define EVERYTHING_SELFTEST_PREDICT_U_CLAMPED 2u
#define EVERYTHING_SELFTEST_PREDICT_Y_REJECTED 3u
#define EVERYTHING_SELFTEST_PREDICT_U_REJECTED 3u

static const uint32_t everything_selftest_predict_rows[32][4] = {
    { 0x40130acbu, 0x40e16fbau, 0x420cb568u, 0x400dda7bu },  /* 2.29753, 7.04489, 35.1772 -> 2.21646 */
    { 0x4018d62eu, 0x42a9dcb1u, 0x41e1b040u, 0x40138877u },  /* 2.38807, 84.931, 28.2111 -> 2.3052 */
    { 0x000116c2u, 0xf149f2cau, 0x42a20000u, 0x3f1e10f0u },  /* 9.99995e-41, -1e+30, 81 -> 0.617446 */
    { 0x4054ca65u, 0x42e2ffafu, 0x40c0cb26u, 0x405147f8u },  /* 3.32485, 113.499, 6.0248 -> 3.27002 */
    { 0x3fd97f40u, 0x426db281u, 0x402dd92du, 0x3fd67766u },  /* 1.6992, 59.4243, 2.71638 -> 1.67552 */
    { 0x7fc00000u, 0xff800000u, 0xff800000u, 0x3fd5f532u },  /* nan, -inf, -inf -> 1.67155 */
    { 0x4037e929u, 0xc1055a2fu, 0x41b353dbu, 0x4038003eu },  /* 2.87361, -8.33452, 22.4159 -> 2.87501 */
    { 0x40603901u, 0x42b4ed3bu, 0x4143dc08u, 0x405f9acfu },  /* 3.50348, 90.4633, 12.2412 -> 3.49382 */
    { 0x00000000u, 0xc1a00000u, 0x7f800000u, 0x3f2d9fcbu },  /* 0, -20, inf -> 0.678219 */
    { 0x40051f51u, 0x426bce0cu, 0x416fbf64u, 0x4005ab81u },  /* 2.08004, 58.9512, 14.9842 -> 2.08859 */
    { 0x3fffe6ccu, 0x4291b005u, 0x406f2000u, 0x400063fbu },  /* 1.99923, 72.8438, 3.73633 -> 2.0061 */
    { 0x40d9f3b6u, 0x7fc00000u, 0x80000000u, 0x406d303fu },  /* 6.811, nan, -0 -> 3.70607 */
    { 0x3ff8895cu, 0x42a43af7u, 0x40515c8au, 0x3ffcccb4u },  /* 1.94169, 82.1152, 3.27127 -> 1.975 */
    { 0x403b66d1u, 0x41efe1d4u, 0x41927839u, 0x403cede4u },  /* 2.92815, 29.9853, 18.3087 -> 2.95202 */
    { 0x406f18fcu, 0x42f00000u, 0x000116c2u, 0x40705f1eu },  /* 3.7359, 120, 9.99995e-41 -> 3.75581 */
    { 0x400bbf81u, 0x42bd456eu, 0x40d12b68u, 0x400d43f8u },  /* 2.18356, 94.6356, 6.53655 -> 2.20727 */
    { 0x3fe0ca87u, 0x419110cdu, 0x420111e2u, 0x3fe751e9u },  /* 1.75618, 18.1332, 32.2675 -> 1.80719 */
    { 0x80000000u, 0xc3200000u, 0x42200000u, 0x3f436551u },  /* -0, -160, 40 -> 0.763265 */
    { 0x40452245u, 0x40247e78u, 0x41e18009u, 0x4046e4ceu },  /* 3.08022, 2.57022, 28.1875 -> 3.10772 */
    { 0x400623f8u, 0x428ec970u, 0x421709d7u, 0x4005fbaeu },  /* 2.09595, 71.3934, 37.7596 -> 2.09349 */
    { 0xf149f2cau, 0x000116c2u, 0x7fc00000u, 0x3f2346aeu },  /* -1e+30, 9.99995e-41, nan -> 0.637797 */
    { 0x40103482u, 0x42e2ea73u, 0x421608e4u, 0x400e00dbu },  /* 2.2532, 113.458, 37.5087 -> 2.2188 */
    { 0x40509284u, 0x40ad7765u, 0x406edd2fu, 0x404cb559u },  /* 3.25894, 5.42082, 3.73225 -> 3.19857 */
    { 0xff800000u, 0x7f800000u, 0xc2280000u, 0x404a3ea9u },  /* -inf, inf, -42 -> 3.16007 */
    { 0x3ffef8acu, 0x42eb0910u, 0x40cd449fu, 0x3ffcd6c1u },  /* 1.99196, 117.518, 6.41463 -> 1.9753 */
    { 0x3ffd6a37u, 0x42cac53cu, 0x41ff9794u, 0x3ff6810bu },  /* 1.9798, 101.385, 31.949 -> 1.92581 */
    { 0x7f800000u, 0x80000000u, 0x00000000u, 0x3ff30c54u },  /* inf, -0, 0 -> 1.89881 */
    { 0x3fff579du, 0x4107ea96u, 0x41e7929bu, 0x4001f555u },  /* 1.99486, 8.49477, 28.9466 -> 2.0306 */
    { 0x4005525au, 0x42ce6710u, 0x4123f69cu, 0x40074ff2u },  /* 2.08315, 103.201, 10.2477 -> 2.11425 */
    { 0x3f292a30u, 0x00000000u, 0xf149f2cau, 0x3f2c08e4u },  /* 0.6608, 0, -1e+30 -> 0.672011 */
    { 0x4069e6a1u, 0x42b69faeu, 0x42193f1fu, 0x4067f15au },  /* 3.6547, 91.3119, 38.3116 -> 3.62411 */
    { 0x3f554929u, 0xc177c691u, 0x4018f725u, 0x3f5b3d41u },  /* 0.833148, -15.486, 2.39008 -> 0.856403 */
};

/* simulate: arguments, auxiliary channels, expected result. */
#define EVERYTHING_SELFTEST_SIMULATE_START_Y 0x400cb1c4u
#define EVERYTHING_SELFTEST_SIMULATE_START_U 0x00000000u
#define EVERYTHING_SELFTEST_SIMULATE_STATUS 0x000000cau
#define EVERYTHING_SELFTEST_SIMULATE_Y_CLAMPED 0u
#define EVERYTHING_SELFTEST_SIMULATE_U_CLAMPED 3u
#define EVERYTHING_SELFTEST_SIMULATE_Y_REJECTED 0u
#define EVERYTHING_SELFTEST_SIMULATE_U_REJECTED 2u

static const uint32_t everything_selftest_simulate_rows[32][3] = {
    { 0x429f4944u, 0x41237b55u, 0x4007a060u },  /* 79.6431, 10.2176 -> 2.11916 */
    { 0xbf41a05bu, 0x41a24316u, 0x4002a770u },  /* -0.756353, 20.2828 -> 2.04147 */
    { 0xc3200000u, 0x00000000u, 0x40003992u },  /* -160, 0 -> 2.00351 */
    { 0x428d34ddu, 0x42184987u, 0x3ffb49dau },  /* 70.6032, 38.0718 -> 1.96319 */
    { 0x4279bfd0u, 0x421bc533u, 0x3ff0b176u },  /* 62.4373, 38.9426 -> 1.88042 */
    { 0x000116c2u, 0x7f800000u, 0x3fe923d1u },  /* 9.99995e-41, inf -> 1.82141 */
    { 0x4202092cu, 0x40606654u, 0x3fe9996bu },  /* 32.509, 3.50625 -> 1.82499 */
    { 0x4266cbc5u, 0x4214725cu, 0x3fe974c2u },  /* 57.699, 37.1117 -> 1.82388 */
    { 0xf149f2cau, 0x000116c2u, 0x3fe6dbe6u },  /* -1e+30, 9.99995e-41 -> 1.80359 */
    { 0x422115cau, 0x41947063u, 0x3fe76a9bu },  /* 40.2713, 18.5549 -> 1.80794 */
    { 0x3fc31fb7u, 0x4031aa51u, 0x3fe656d7u },  /* 1.52441, 2.77602 -> 1.79953 */
    { 0x43820000u, 0x80000000u, 0x3fe45e25u },  /* 260, -0 -> 1.78412 */
    { 0x415884d8u, 0x4200ce7cu, 0x3fdfc603u },  /* 13.5324, 32.2016 -> 1.74823 */
    { 0x4261fa3du, 0x42168c86u, 0x3fddb852u },  /* 56.4944, 37.6372 -> 1.73219 */
    { 0x42f00000u, 0xbf800000u, 0x3fdb4a7eu },  /* 120, -1 -> 1.71321 */
    { 0x4217ca18u, 0x408bab62u, 0x3fdae8c6u },  /* 37.9474, 4.36467 -> 1.71023 */
    { 0x401918aeu, 0x41d55968u, 0x3fe2727au },  /* 2.39213, 26.6687 -> 1.76912 */
    { 0x80000000u, 0xf149f2cau, 0x3fe96d01u },  /* -0, -1e+30 -> 1.82364 */
    { 0xc030b7c5u, 0x408277d2u, 0x3fea1fc1u },  /* -2.76122, 4.07713 -> 1.82909 */
    { 0x42b4c6a3u, 0x420393f7u, 0x3fe4a75cu },  /* 90.388, 32.8945 -> 1.78636 */
    { 0xff800000u, 0x42200000u, 0x3fdba7ffu },  /* -inf, 40 -> 1.71606 */
    { 0x41cf0dbeu, 0x41cb5e5bu, 0x3fd6f91eu },  /* 25.8817, 25.4211 -> 1.67948 */
    { 0x42bd649fu, 0x415cf4f6u, 0x3fda98e4u },  /* 94.6965, 13.8098 -> 1.70779 */
    { 0x7fc00000u, 0xff800000u, 0x3fddc6c5u },  /* nan, -inf -> 1.73263 */
    { 0x42b4ea76u, 0x41a05b82u, 0x3fe35ccau },  /* 90.4579, 20.0447 -> 1.77627 */
    { 0x405df404u, 0x420dbeefu, 0x3fed0c3du },  /* 3.46802, 35.4365 -> 1.85194 */
    { 0xc1a00000u, 0x42a20000u, 0x3ff6a4d3u },  /* -20, 81 -> 1.92691 */
    { 0x42ed8cf3u, 0xbef9ecceu, 0x3ffc0600u },  /* 118.775, -0.488135 -> 1.96893 */
    { 0x42075ad3u, 0x40c99217u, 0x3ffb2b8du },  /* 33.8387, 6.29908 -> 1.96227 */
    { 0x00000000u, 0x7fc00000u, 0x3ffcc284u },  /* 0, nan -> 1.97469 */
    { 0xc1918f1fu, 0x410a64f2u, 0x3ffdea05u },  /* -18.1949, 8.64964 -> 1.9837 */
    { 0x42d72899u, 0x40c597ddu, 0x3ff8ea06u },  /* 107.579, 6.17479 -> 1.94464 */
};

/* inverse: arguments, auxiliary channels, expected result. */
#define EVERYTHING_SELFTEST_INVERSE_START_Y 0x400cb1c4u
#define EVERYTHING_SELFTEST_INVERSE_START_U 0x00000000u
#define EVERYTHING_SELFTEST_INVERSE_STATUS 0x000000f7u
#define EVERYTHING_SELFTEST_INVERSE_Y_CLAMPED 5u
#define EVERYTHING_SELFTEST_INVERSE_U_CLAMPED 6u
#define EVERYTHING_SELFTEST_INVERSE_Y_REJECTED 5u
#define EVERYTHING_SELFTEST_INVERSE_U_REJECTED 0u

static const uint32_t everything_selftest_inverse_rows[32][4] = {
    { 0x4059dc88u, 0x4052c69bu, 0x414eaf86u, 0x3b18ddb3u },  /* 3.40409, 3.29337, 12.9179 -> 0.00233255 */
    { 0x3fbf3b6bu, 0x3fb6ac62u, 0x41acd8cfu, 0x3aca7940u },  /* 1.494, 1.42714, 21.6059 -> 0.00154475 */
    { 0x406f18fcu, 0x3f292a30u, 0xbf800000u, 0xc0c01804u },  /* 3.7359, 0.6608, -1 -> -6.00293 */
    { 0x3f824051u, 0x3f75a4f1u, 0x41acc975u, 0xc10feaa4u },  /* 1.01759, 0.959548, 21.5984 -> -8.99479 */
    { 0x3f9065a1u, 0x3f88b4f4u, 0x421ccae5u, 0x3c4769a2u },  /* 1.1281, 1.06802, 39.1981 -> 0.0121712 */
    { 0xff800000u, 0x80000000u, 0x42200000u, 0xc0bfca8au },  /* -inf, -0, 40 -> -5.99347 */
    { 0x3f911acdu, 0x3f8966c7u, 0x417ece2au, 0xc10fcdcau },  /* 1.13363, 1.07345, 15.9253 -> -8.98774 */
    { 0x3fa4d84au, 0x3f9cc604u, 0x417572c9u, 0x3cd5018eu },  /* 1.28785, 1.22479, 15.3405 -> 0.0260017 */
    { 0x80000000u, 0xf149f2cau, 0xf149f2cau, 0xc0bfa26fu },  /* -0, -1e+30, -1e+30 -> -5.98858 */
    { 0x3f794288u, 0x3f6a9c61u, 0x42174abau, 0xc10ff42au },  /* 0.973671, 0.916449, 37.823 -> -8.99711 */
    { 0x3ffbdc0du, 0x3ff24322u, 0x41bde437u, 0x3c53b15eu },  /* 1.96765, 1.89267, 23.7364 -> 0.0129207 */
    { 0x7f800000u, 0x40d9f3b6u, 0x42a20000u, 0x41802bf6u },  /* inf, 6.811, 81 -> 16.0215 */
    { 0x40350e16u, 0x402f205du, 0x41d60a7bu, 0x41e02bf6u },  /* 2.82898, 2.73635, 26.7551 -> 28.0215 */
    { 0x4006ba40u, 0x4001c585u, 0x41cee51du, 0x40bfb02cu },  /* 2.10512, 2.02768, 25.8619 -> 5.99026 */
    { 0x3f292a30u, 0x000116c2u, 0x7f800000u, 0xc0c11602u },  /* 0.6608, 9.99995e-41, inf -> -6.03394 */
    { 0x404ec247u, 0x40480f57u, 0x41df62b3u, 0xc10faa58u },  /* 3.23061, 3.12594, 27.9232 -> -8.97909 */
    { 0x3f764e8cu, 0x3f67b696u, 0x42104b94u, 0x3d59e27du },  /* 0.962136, 0.90513, 36.0738 -> 0.0531945 */
    { 0x7fc00000u, 0xff800000u, 0xc2280000u, 0x415cb75bu },  /* nan, -inf, -42 -> 13.7948 */
    { 0x3fb8c7bcu, 0x3fb056a8u, 0x40bc45f6u, 0x41b33d90u },  /* 1.4436, 1.37764, 5.88354 -> 22.4051 */
    { 0x3f89abffu, 0x3f821b1bu, 0x40d54fd5u, 0x4027c16bu },  /* 1.07556, 1.01645, 6.666 -> 2.62118 */
    { 0x40d9f3b6u, 0x406f18fcu, 0x00000000u, 0x417f2033u },  /* 6.811, 3.7359, 0 -> 15.9454 */
    { 0x40652288u, 0x405da23eu, 0x40e9bc1bu, 0x41df901au },  /* 3.58023, 3.46303, 7.30421 -> 27.9454 */
    { 0x4056bef3u, 0x404fc565u, 0x41da92b7u, 0x40be212fu },  /* 3.3554, 3.24642, 27.3216 -> 5.94155 */
    { 0x00000000u, 0x00000000u, 0x7fc00000u, 0xc0c13b65u },  /* 0, 0, nan -> -6.0385 */
    { 0x4048ff21u, 0x40427ce6u, 0x41d2877cu, 0xc10fae78u },  /* 3.14057, 3.03887, 26.3162 -> -8.98009 */
    { 0x40314e01u, 0x402b7856u, 0x414d6233u, 0x3d60295du },  /* 2.77039, 2.67922, 12.8365 -> 0.0547269 */
    { 0xf149f2cau, 0x7fc00000u, 0x80000000u, 0x41467146u },  /* -1e+30, nan, -0 -> 12.4027 */
    { 0x4015142du, 0x400fd981u, 0x421eda1cu, 0x41974e97u },  /* 2.32936, 2.24765, 39.713 -> 18.9134 */
    { 0x3ff463d2u, 0x3feaebe5u, 0x41f742d6u, 0x3f06c9ccu },  /* 1.9093, 1.83532, 30.9076 -> 0.526517 */
    { 0x000116c2u, 0x7f800000u, 0xff800000u, 0x4144b5b9u },  /* 9.99995e-41, inf, -inf -> 12.2944 */
    { 0x40218d04u, 0x401c11ddu, 0x41488e0au, 0x41968854u },  /* 2.52423, 2.43859, 12.5347 -> 18.8166 */
    { 0x4067a433u, 0x40600b5eu, 0x42126525u, 0x3eedb383u },  /* 3.6194, 3.50069, 36.5988 -> 0.46426 */
};

#endif

#endif
