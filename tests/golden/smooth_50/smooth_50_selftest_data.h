/* smooth_50_selftest_data.h: inputs of the self-test, and the bits that the float32 reference computes from them. */

#ifndef SMOOTH_50_SELFTEST_DATA_H
#define SMOOTH_50_SELFTEST_DATA_H

#include <stdint.h>

#include "smooth_50.h"

/* predict: arguments, expected result. */
#define SMOOTH_50_SELFTEST_PREDICT_START_Y 0x40980000u
#define SMOOTH_50_SELFTEST_PREDICT_START_U 0x00000000u
#define SMOOTH_50_SELFTEST_PREDICT_STATUS 0x0000000fu
#define SMOOTH_50_SELFTEST_PREDICT_Y_CLAMPED 5u
#define SMOOTH_50_SELFTEST_PREDICT_U_CLAMPED 2u
#define SMOOTH_50_SELFTEST_PREDICT_Y_REJECTED 3u
#define SMOOTH_50_SELFTEST_PREDICT_U_REJECTED 3u

SMOOTH_50_TABLE
static const uint32_t smooth_50_selftest_predict_rows[32][3] = {
    { 0x40a0c5e7u, 0x40e16fbau, 0x4099fd3cu },  /* 5.02416, 7.04489 -> 4.81216 */
    { 0x40a8c80bu, 0x42a9dcb1u, 0x40a60e4fu },  /* 5.27442, 84.931 -> 5.18925 */
    { 0x000116c2u, 0xf149f2cau, 0x3ee400a8u },  /* 9.99995e-41, -1e+30 -> 0.445318 */
    { 0x40fba455u, 0x42e2ffafu, 0x40f6e2a7u },  /* 7.86381, 113.499 -> 7.71517 */
    { 0x4057b27eu, 0x426db281u, 0x40548a2bu },  /* 3.37027, 59.4243 -> 3.32093 */
    { 0x7fc00000u, 0xff800000u, 0x405182b2u },  /* nan, -inf -> 3.2736 */
    { 0x40d3ba60u, 0xc1055a2fu, 0x40c989f3u },  /* 6.6165, -8.33452 -> 6.29809 */
    { 0x4105b88eu, 0x42b4ed3bu, 0x41023ecbu },  /* 8.35756, 90.4633 -> 8.14033 */
    { 0x00000000u, 0xc1a00000u, 0x3ee400a8u },  /* 0, -20 -> 0.445318 */
    { 0x408d88edu, 0x426bce0cu, 0x408a85a8u },  /* 4.42296, 58.9512 -> 4.32882 */
    { 0x4086632fu, 0x4291b005u, 0x4084717du },  /* 4.19961, 72.8438 -> 4.13885 */
    { 0x418c0000u, 0x7fc00000u, 0x410b736fu },  /* 17.5, nan -> 8.71568 */
    { 0x40814c48u, 0x42a43af7u, 0x4080125cu },  /* 4.04056, 82.1152 -> 4.00224 */
    { 0x40d88d78u, 0x41efe1d4u, 0x40d067f1u },  /* 6.76727, 29.9853 -> 6.51269 */
    { 0x41100000u, 0x42f00000u, 0x410cf4b7u },  /* 9, 120 -> 8.80974 */
    { 0x4096b12eu, 0x42bd456eu, 0x4095477fu },  /* 4.70913, 94.6356 -> 4.66498 */
    { 0x4061c733u, 0x419110cdu, 0x4059c629u },  /* 3.52778, 18.1332 -> 3.40272 */
    { 0x80000000u, 0xc3200000u, 0x3ee400a8u },  /* -0, -160 -> 0.445318 */
    { 0x40e600d4u, 0x40247e78u, 0x40db862fu },  /* 7.1876, 2.57022 -> 6.86013 */
    { 0x408ef12bu, 0x428ec970u, 0x408c8f19u },  /* 4.46694, 71.3934 -> 4.39247 */
    { 0xf149f2cau, 0x000116c2u, 0x3ef36abau },  /* -1e+30, 9.99995e-41 -> 0.475424 */
    { 0x409cda20u, 0x42e2ea73u, 0x409c3e07u },  /* 4.90163, 113.458 -> 4.88257 */
    { 0x40f5cfddu, 0x40ad7765u, 0x40eaadb8u },  /* 7.68162, 5.42082 -> 7.33371 */
    { 0xff800000u, 0x7f800000u, 0x40e0211du },  /* -inf, inf -> 7.00404 */
    { 0x4085bea1u, 0x42eb0910u, 0x408647f1u },  /* 4.17952, 117.518 -> 4.19628 */
    { 0x4084ab49u, 0x42cac53cu, 0x40845cbfu },  /* 4.14591, 101.385 -> 4.13632 */
    { 0x7f800000u, 0x80000000u, 0x407d03b2u },  /* inf, -0 -> 3.95335 */
    { 0x4086003du, 0x4107ea96u, 0x40808998u },  /* 4.18753, 8.49477 -> 4.0168 */
    { 0x408dcf77u, 0x42ce6710u, 0x408d3cc2u },  /* 4.43158, 103.201 -> 4.41367 */
    { 0x3f000000u, 0x00000000u, 0x3ef36abau },  /* 0.5, 0 -> 0.475424 */
    { 0x410c68aeu, 0x42b69faeu, 0x4108a0dau },  /* 8.77556, 91.3119 -> 8.53927 */
    { 0x3f79f4ddu, 0xc177c691u, 0x3f677224u },  /* 0.976393, -15.486 -> 0.904085 */
};

/* simulate: arguments, expected result. */
#define SMOOTH_50_SELFTEST_SIMULATE_START_Y 0x40980000u
#define SMOOTH_50_SELFTEST_SIMULATE_START_U 0x00000000u
#define SMOOTH_50_SELFTEST_SIMULATE_STATUS 0x0000000au
#define SMOOTH_50_SELFTEST_SIMULATE_Y_CLAMPED 0u
#define SMOOTH_50_SELFTEST_SIMULATE_U_CLAMPED 3u
#define SMOOTH_50_SELFTEST_SIMULATE_Y_REJECTED 0u
#define SMOOTH_50_SELFTEST_SIMULATE_U_REJECTED 2u

SMOOTH_50_TABLE
static const uint32_t smooth_50_selftest_simulate_rows[32][2] = {
    { 0x429f4944u, 0x4095b180u },  /* 79.6431 -> 4.67792 */
    { 0xbf41a05bu, 0x408efe29u },  /* -0.756353 -> 4.46853 */
    { 0xc3200000u, 0x408789bau },  /* -160 -> 4.23556 */
    { 0x428d34ddu, 0x40856c32u },  /* 70.6032 -> 4.16946 */
    { 0x4279bfd0u, 0x4082f280u },  /* 62.4373 -> 4.0921 */
    { 0x000116c2u, 0x407a505du },  /* 9.99995e-41 -> 3.91115 */
    { 0x4202092cu, 0x4072cc72u },  /* 32.509 -> 3.79373 */
    { 0x4266cbc5u, 0x406e56d3u },  /* 57.699 -> 3.72405 */
    { 0xf149f2cau, 0x4061a9c1u },  /* -1e+30 -> 3.52599 */
    { 0x422115cau, 0x405c0a9fu },  /* 40.2713 -> 3.43815 */
    { 0x3fc31fb7u, 0x4052820du },  /* 1.52441 -> 3.28919 */
    { 0x43820000u, 0x40560339u },  /* 260 -> 3.34395 */
    { 0x415884d8u, 0x404e06d0u },  /* 13.5324 -> 3.21917 */
    { 0x4261fa3du, 0x404af32cu },  /* 56.4944 -> 3.17109 */
    { 0x42f00000u, 0x404ebba3u },  /* 120 -> 3.2302 */
    { 0x4217ca18u, 0x4049a80au },  /* 37.9474 -> 3.15088 */
    { 0x401918aeu, 0x404105dau },  /* 2.39213 -> 3.01598 */
    { 0x80000000u, 0x40388320u },  /* -0 -> 2.883 */
    { 0xc030b7c5u, 0x40301495u },  /* -2.76122 -> 2.75126 */
    { 0x42b4c6a3u, 0x4031bea8u },  /* 90.388 -> 2.77726 */
    { 0xff800000u, 0x403358b3u },  /* -inf -> 2.80229 */
    { 0x41cf0dbeu, 0x402e22dcu },  /* 25.8817 -> 2.72088 */
    { 0x42bd649fu, 0x403052bcu },  /* 94.6965 -> 2.75505 */
    { 0x7fc00000u, 0x40326db7u },  /* nan -> 2.78795 */
    { 0x42b4ea76u, 0x40340308u },  /* 90.4579 -> 2.81269 */
    { 0x405df404u, 0x402c6d50u },  /* 3.46802 -> 2.69417 */
    { 0xc1a00000u, 0x4022b826u },  /* -20 -> 2.54249 */
    { 0x42ed8cf3u, 0x4027d396u },  /* 118.775 -> 2.62229 */
    { 0x42075ad3u, 0x4023eb61u },  /* 33.8387 -> 2.56124 */
    { 0x00000000u, 0x401ca8eeu },  /* 0 -> 2.44781 */
    { 0xc1918f1fu, 0x4013d3f5u },  /* -18.1949 -> 2.30981 */
    { 0x42d72899u, 0x40184f14u },  /* 107.579 -> 2.37983 */
};

/* inverse: arguments, expected result. */
#define SMOOTH_50_SELFTEST_INVERSE_START_Y 0x40980000u
#define SMOOTH_50_SELFTEST_INVERSE_START_U 0x00000000u
#define SMOOTH_50_SELFTEST_INVERSE_STATUS 0x00000037u
#define SMOOTH_50_SELFTEST_INVERSE_Y_CLAMPED 5u
#define SMOOTH_50_SELFTEST_INVERSE_U_CLAMPED 7u
#define SMOOTH_50_SELFTEST_INVERSE_Y_REJECTED 5u
#define SMOOTH_50_SELFTEST_INVERSE_U_REJECTED 0u

SMOOTH_50_TABLE
static const uint32_t smooth_50_selftest_inverse_rows[32][3] = {
    { 0x41015339u, 0x40fccc15u, 0x42ca619au },  /* 8.08282, 7.89991 -> 101.191 */
    { 0x403365b2u, 0x40338bb6u, 0x429a32adu },  /* 2.80308, 2.8054 -> 77.099 */
    { 0x41100000u, 0x3f000000u, 0xc1a00000u },  /* 9, 0.5 -> -20 */
    { 0x3fbe3c27u, 0x3fb361c4u, 0xc122ea3cu },  /* 1.48621, 1.40142 -> -10.1822 */
    { 0x3fe555f4u, 0x3fef5b6au, 0x42ca90c3u },  /* 1.79169, 1.86998 -> 101.283 */
    { 0xff800000u, 0x80000000u, 0xc1a00000u },  /* -inf, -0 -> -20 */
    { 0x3fe74abdu, 0x3fe77ff0u, 0x425401afu },  /* 1.80697, 1.80859 -> 53.0016 */
    { 0x400eeda3u, 0x40083e74u, 0xc04188ddu },  /* 2.23325, 2.12881 -> -3.02398 */
    { 0x80000000u, 0xf149f2cau, 0xc1a00000u },  /* -0, -1e+30 -> -20 */
    { 0x3faeb26au, 0x3fb45872u, 0x428b8260u },  /* 1.36482, 1.40895 -> 69.7546 */
    { 0x40839823u, 0x407de7d5u, 0x41ac08c5u },  /* 4.11232, 3.96727 -> 21.5043 */
    { 0x7f800000u, 0x418c0000u, 0x42f00000u },  /* inf, 17.5 -> 120 */
    { 0x40cfc7fbu, 0x40c6d7c5u, 0x4115981du },  /* 6.49316, 6.21384 -> 9.34964 */
    { 0x408fc0dfu, 0x408be88du, 0x4236b62du },  /* 4.49229, 4.37214 -> 45.6779 */
    { 0x3f000000u, 0x000116c2u, 0xc1a00000u },  /* 0.5, 9.99995e-41 -> -20 */
    { 0x40f34e41u, 0x40ebcbdcu, 0x427944c6u },  /* 7.6033, 7.36864 -> 62.3172 */
    { 0x3faa9d97u, 0x3fad03b5u, 0x425280efu },  /* 1.33293, 1.35168 -> 52.6259 */
    { 0x7fc00000u, 0xff800000u, 0x4223ed05u },  /* nan, -inf -> 40.9815 */
    { 0x402a7af3u, 0x402291ecu, 0xc064071du },  /* 2.66375, 2.54016 -> -3.56293 */
    { 0x3fd2bf22u, 0x3fd67c5cu, 0x42857dd5u },  /* 1.64646, 1.67567 -> 66.7458 */
    { 0x418c0000u, 0x41100000u, 0x42f00000u },  /* 17.5, 9 -> 120 */
    { 0x41091d8du, 0x4102c228u, 0x4092776cu },  /* 8.56971, 8.1724 -> 4.57708 */
    { 0x40fe5822u, 0x40f8db27u, 0x42cf7e82u },  /* 7.94826, 7.77675 -> 103.747 */
    { 0x00000000u, 0x00000000u, 0xc1a00000u },  /* 0, 0 -> -20 */
    { 0x40eb5780u, 0x40e33741u, 0x42371ca1u },  /* 7.35443, 7.10049 -> 45.778 */
    { 0x40ca9915u, 0x40c08312u, 0xc1680228u },  /* 6.33119, 6.016 -> -14.5005 */
    { 0xf149f2cau, 0x7fc00000u, 0x41829ca4u },  /* -1e+30, nan -> 16.3265 */
    { 0x40a3967du, 0x409b95c5u, 0xc141c690u },  /* 5.11212, 4.86203 -> -12.111 */
    { 0x407cdd71u, 0x407365eau, 0x4179ed10u },  /* 3.95102, 3.8031 -> 15.6204 */
    { 0x000116c2u, 0x7f800000u, 0x41829ca4u },  /* 9.99995e-41, inf -> 16.3265 */
    { 0x40b4d336u, 0x40b1f0ecu, 0x42b68ca1u },  /* 5.65078, 5.56066 -> 91.2747 */
    { 0x410ad8f7u, 0x410523f8u, 0x41e095c9u },  /* 8.67797, 8.32128 -> 28.0731 */
};

#endif
