/* appendix_a_selftest_data.h: inputs of the self-test, and the bits that the float32 reference computes from them. */

#ifndef APPENDIX_A_SELFTEST_DATA_H
#define APPENDIX_A_SELFTEST_DATA_H

#include <stdint.h>

#include "appendix_a.h"

/* predict: arguments, expected result. */
#define APPENDIX_A_SELFTEST_PREDICT_START_Y 0x400cb1c4u
#define APPENDIX_A_SELFTEST_PREDICT_START_U 0x00000000u
#define APPENDIX_A_SELFTEST_PREDICT_STATUS 0x0000000fu
#define APPENDIX_A_SELFTEST_PREDICT_Y_CLAMPED 5u
#define APPENDIX_A_SELFTEST_PREDICT_U_CLAMPED 2u
#define APPENDIX_A_SELFTEST_PREDICT_Y_REJECTED 3u
#define APPENDIX_A_SELFTEST_PREDICT_U_REJECTED 3u

APPENDIX_A_TABLE
static const uint32_t appendix_a_selftest_predict_rows[32][3] = {
    { 0x40130acbu, 0x40e16fbau, 0x400e925fu },  /* 2.29753, 7.04489 -> 2.22768 */
    { 0x4018d62eu, 0x42a9dcb1u, 0x401c368bu },  /* 2.38807, 84.931 -> 2.44083 */
    { 0x000116c2u, 0xf149f2cau, 0x3f13f84cu },  /* 9.99995e-41, -1e+30 -> 0.578007 */
    { 0x4054ca65u, 0x42e2ffafu, 0x405a4e8cu },  /* 3.32485, 113.499 -> 3.41104 */
    { 0x3fd97f40u, 0x426db281u, 0x3fdcb1aeu },  /* 1.6992, 59.4243 -> 1.72417 */
    { 0x7fc00000u, 0xff800000u, 0x3fdfd4a0u },  /* nan, -inf -> 1.74868 */
    { 0x4037e929u, 0xc1055a2fu, 0x40310a36u },  /* 2.87361, -8.33452 -> 2.76625 */
    { 0x40603901u, 0x42b4ed3bu, 0x406314e1u },  /* 3.50348, 90.4633 -> 3.54815 */
    { 0x00000000u, 0xc1a00000u, 0x3f13f84cu },  /* 0, -20 -> 0.578007 */
    { 0x40051f51u, 0x426bce0cu, 0x400637fdu },  /* 2.08004, 58.9512 -> 2.09717 */
    { 0x3fffe6ccu, 0x4291b005u, 0x40029080u },  /* 1.99923, 72.8438 -> 2.04007 */
    { 0x40d9f3b6u, 0x7fc00000u, 0x406fb43fu },  /* 6.811, nan -> 3.74538 */
    { 0x3ff8895cu, 0x42a43af7u, 0x3fffccbeu },  /* 1.94169, 82.1152 -> 1.99844 */
    { 0x403b66d1u, 0x41efe1d4u, 0x40386f44u },  /* 2.92815, 29.9853 -> 2.88179 */
    { 0x406f18fcu, 0x42f00000u, 0x407534c8u },  /* 3.7359, 120 -> 3.83135 */
    { 0x400bbf81u, 0x42bd456eu, 0x40105d0eu },  /* 2.18356, 94.6356 -> 2.25568 */
    { 0x3fe0ca87u, 0x419110cdu, 0x3fdb5fcfu },  /* 1.75618, 18.1332 -> 1.71386 */
    { 0x80000000u, 0xc3200000u, 0x3f13f84cu },  /* -0, -160 -> 0.578007 */
    { 0x40452245u, 0x40247e78u, 0x403f0500u },  /* 3.08022, 2.57022 -> 2.98468 */
    { 0x400623f8u, 0x428ec970u, 0x40087d27u },  /* 2.09595, 71.3934 -> 2.13264 */
    { 0xf149f2cau, 0x000116c2u, 0x3f1c4d75u },  /* -1e+30, 9.99995e-41 -> 0.610557 */
    { 0x40103482u, 0x42e2ea73u, 0x4016a867u },  /* 2.2532, 113.458 -> 2.35403 */
    { 0x40509284u, 0x40ad7765u, 0x404a6626u },  /* 3.25894, 5.42082 -> 3.16248 */
    { 0xff800000u, 0x7f800000u, 0x40446ca9u },  /* -inf, inf -> 3.06913 */
    { 0x3ffef8acu, 0x42eb0910u, 0x4006ad2cu },  /* 1.99196, 117.518 -> 2.10432 */
    { 0x3ffd6a37u, 0x42cac53cu, 0x4004437au },  /* 1.9798, 101.385 -> 2.06662 */
    { 0x7f800000u, 0x80000000u, 0x3ffeb426u },  /* inf, -0 -> 1.98987 */
    { 0x3fff579du, 0x4107ea96u, 0x3ff76b81u },  /* 1.99486, 8.49477 -> 1.93297 */
    { 0x4005525au, 0x42ce6710u, 0x400aef89u },  /* 2.08315, 103.201 -> 2.17087 */
    { 0x3f292a30u, 0x00000000u, 0x3f1c4d75u },  /* 0.6608, 0 -> 0.610557 */
    { 0x4069e6a1u, 0x42b69faeu, 0x406cbc77u },  /* 3.6547, 91.3119 -> 3.699 */
    { 0x3f554929u, 0xc177c691u, 0x3f40e28du },  /* 0.833148, -15.486 -> 0.753457 */
};

/* simulate: arguments, expected result. */
#define APPENDIX_A_SELFTEST_SIMULATE_START_Y 0x400cb1c4u
#define APPENDIX_A_SELFTEST_SIMULATE_START_U 0x00000000u
#define APPENDIX_A_SELFTEST_SIMULATE_STATUS 0x0000000au
#define APPENDIX_A_SELFTEST_SIMULATE_Y_CLAMPED 0u
#define APPENDIX_A_SELFTEST_SIMULATE_U_CLAMPED 3u
#define APPENDIX_A_SELFTEST_SIMULATE_Y_REJECTED 0u
#define APPENDIX_A_SELFTEST_SIMULATE_U_REJECTED 2u

APPENDIX_A_TABLE
static const uint32_t appendix_a_selftest_simulate_rows[32][2] = {
    { 0x429f4944u, 0x400fc2b2u },  /* 79.6431 -> 2.24626 */
    { 0xbf41a05bu, 0x400a8e8au },  /* -0.756353 -> 2.16495 */
    { 0xc3200000u, 0x40037c81u },  /* -160 -> 2.05447 */
    { 0x428d34ddu, 0x4005cde3u },  /* 70.6032 -> 2.09069 */
    { 0x4279bfd0u, 0x40073e73u },  /* 62.4373 -> 2.11319 */
    { 0x000116c2u, 0x4002471fu },  /* 9.99995e-41 -> 2.03559 */
    { 0x4202092cu, 0x4000b987u },  /* 32.509 -> 2.01132 */
    { 0x4266cbc5u, 0x4001c683u },  /* 57.699 -> 2.02774 */
    { 0xf149f2cau, 0x3ff5ba54u },  /* -1e+30 -> 1.91975 */
    { 0x422115cau, 0x3ff47a95u },  /* 40.2713 -> 1.90999 */
    { 0x3fc31fb7u, 0x3feb51d5u },  /* 1.52441 -> 1.83843 */
    { 0x43820000u, 0x3ffa9974u },  /* 260 -> 1.95781 */
    { 0x415884d8u, 0x3ff3ca9du },  /* 13.5324 -> 1.90462 */
    { 0x4261fa3du, 0x3ff5e624u },  /* 56.4944 -> 1.92109 */
    { 0x42f00000u, 0x40027bcfu },  /* 120 -> 2.03881 */
    { 0x4217ca18u, 0x40017b8du },  /* 37.9474 -> 2.02317 */
    { 0x401918aeu, 0x3ff9bb0cu },  /* 2.39213 -> 1.95102 */
    { 0x80000000u, 0x3ff02b45u },  /* -0 -> 1.87632 */
    { 0xc030b7c5u, 0x3fe634a0u },  /* -2.76122 -> 1.79848 */
    { 0x42b4c6a3u, 0x3fef83eeu },  /* 90.388 -> 1.87121 */
    { 0xff800000u, 0x3ff8a50du },  /* -inf -> 1.94254 */
    { 0x41cf0dbeu, 0x3ff465f7u },  /* 25.8817 -> 1.90936 */
    { 0x42bd649fu, 0x3ffe50e2u },  /* 94.6965 -> 1.98684 */
    { 0x7fc00000u, 0x40040579u },  /* nan -> 2.06283 */
    { 0x42b4ea76u, 0x40085bb3u },  /* 90.4579 -> 2.1306 */
    { 0x405df404u, 0x4003b9ccu },  /* 3.46802 -> 2.05822 */
    { 0xc1a00000u, 0x3ff98f46u },  /* -20 -> 1.94968 */
    { 0x42ed8cf3u, 0x40042707u },  /* 118.775 -> 2.06488 */
    { 0x42075ad3u, 0x4002b365u },  /* 33.8387 -> 2.0422 */
    { 0x00000000u, 0x3ffba264u },  /* 0 -> 1.96589 */
    { 0xc1918f1fu, 0x3fee513du },  /* -18.1949 -> 1.86185 */
    { 0x42d72899u, 0x3ffafdf8u },  /* 107.579 -> 1.96088 */
};

/* inverse: arguments, expected result. */
#define APPENDIX_A_SELFTEST_INVERSE_START_Y 0x400cb1c4u
#define APPENDIX_A_SELFTEST_INVERSE_START_U 0x00000000u
#define APPENDIX_A_SELFTEST_INVERSE_STATUS 0x00000037u
#define APPENDIX_A_SELFTEST_INVERSE_Y_CLAMPED 5u
#define APPENDIX_A_SELFTEST_INVERSE_U_CLAMPED 6u
#define APPENDIX_A_SELFTEST_INVERSE_Y_REJECTED 5u
#define APPENDIX_A_SELFTEST_INVERSE_U_REJECTED 0u

APPENDIX_A_TABLE
static const uint32_t appendix_a_selftest_inverse_rows[32][3] = {
    { 0x4059dc88u, 0x405dfbcbu, 0x42ca6194u },  /* 3.40409, 3.46849 -> 101.191 */
    { 0x3fbf3b6bu, 0x3fc69891u, 0x429a32bdu },  /* 1.494, 1.55153 -> 77.0991 */
    { 0x406f18fcu, 0x3f292a30u, 0xc1a00000u },  /* 3.7359, 0.6608 -> -20 */
    { 0x3f824051u, 0x3f71664fu, 0xc122e9d5u },  /* 1.01759, 0.942967 -> -10.1821 */
    { 0x3f9065a1u, 0x3f9dc775u, 0x42ca90c2u },  /* 1.1281, 1.23265 -> 101.283 */
    { 0xff800000u, 0x80000000u, 0xc1a00000u },  /* -inf, -0 -> -20 */
    { 0x3f911acdu, 0x3f946d5fu, 0x425401a6u },  /* 1.13363, 1.15959 -> 53.0016 */
    { 0x3fa4d84au, 0x3f9c250du, 0xc04186d6u },  /* 1.28785, 1.21988 -> -3.02385 */
    { 0x80000000u, 0xf149f2cau, 0xc1a00000u },  /* -0, -1e+30 -> -20 */
    { 0x3f794288u, 0x3f83d6dbu, 0x428b8260u },  /* 0.973671, 1.02999 -> 69.7546 */
    { 0x3ffbdc0du, 0x3ff6a902u, 0x41ac0853u },  /* 1.96765, 1.92703 -> 21.5041 */
    { 0x7f800000u, 0x40d9f3b6u, 0x42f00000u },  /* inf, 6.811 -> 120 */
    { 0x40350e16u, 0x40301868u, 0x4115990au },  /* 2.82898, 2.75149 -> 9.34986 */
    { 0x4006ba40u, 0x40067004u, 0x4236b627u },  /* 2.10512, 2.10059 -> 45.6779 */
    { 0x3f292a30u, 0x000116c2u, 0xc1a00000u },  /* 0.6608, 9.99995e-41 -> -20 */
    { 0x404ec247u, 0x404eca37u, 0x4279449du },  /* 3.23061, 3.23109 -> 62.317 */
    { 0x3f764e8cu, 0x3f7da4d7u, 0x425280d5u },  /* 0.962136, 0.990797 -> 52.6258 */
    { 0x7fc00000u, 0xff800000u, 0x420d6d8bu },  /* nan, -inf -> 35.357 */
    { 0x3fb8c7bcu, 0x3faf99b7u, 0xc0640667u },  /* 1.4436, 1.37188 -> -3.56289 */
    { 0x3f89abffu, 0x3f90003fu, 0x42857dcfu },  /* 1.07556, 1.12501 -> 66.7457 */
    { 0x40d9f3b6u, 0x406f18fcu, 0x42874ab0u },  /* 6.811, 3.7359 -> 67.6459 */
    { 0x40652288u, 0x405e2780u, 0x409274e2u },  /* 3.58023, 3.47116 -> 4.57677 */
    { 0x4056bef3u, 0x405b2d73u, 0x42cf7e91u },  /* 3.3554, 3.42465 -> 103.747 */
    { 0x00000000u, 0x00000000u, 0xc1a00000u },  /* 0, 0 -> -20 */
    { 0x4048ff21u, 0x40475fe2u, 0x42371cc3u },  /* 3.14057, 3.11523 -> 45.7781 */
    { 0x40314e01u, 0x4029f891u, 0xc168019fu },  /* 2.77039, 2.6558 -> -14.5004 */
    { 0xf149f2cau, 0x7fc00000u, 0x41f6f9a3u },  /* -1e+30, nan -> 30.8719 */
    { 0x4015142du, 0x400e9c97u, 0xc141c7ffu },  /* 2.32936, 2.22831 -> -12.1113 */
    { 0x3ff463d2u, 0x3fee1e42u, 0x4179ecfeu },  /* 1.9093, 1.8603 -> 15.6204 */
    { 0x000116c2u, 0x7f800000u, 0x41f6f9a3u },  /* 9.99995e-41, inf -> 30.8719 */
    { 0x40218d04u, 0x40256ad9u, 0x42b68caau },  /* 2.52423, 2.58465 -> 91.2747 */
    { 0x4067a433u, 0x406342a9u, 0x41e09692u },  /* 3.6194, 3.55094 -> 28.0735 */
};

/* correct: arguments, expected result. */
#define APPENDIX_A_SELFTEST_CORRECT_START_Y 0x400cb1c4u
#define APPENDIX_A_SELFTEST_CORRECT_START_U 0x00000000u
#define APPENDIX_A_SELFTEST_CORRECT_STATUS 0x00000005u
#define APPENDIX_A_SELFTEST_CORRECT_Y_CLAMPED 2u
#define APPENDIX_A_SELFTEST_CORRECT_U_CLAMPED 0u
#define APPENDIX_A_SELFTEST_CORRECT_Y_REJECTED 3u
#define APPENDIX_A_SELFTEST_CORRECT_U_REJECTED 0u

APPENDIX_A_TABLE
static const uint32_t appendix_a_selftest_correct_rows[32][2] = {
    { 0xbf3eba3au, 0xbac34e0fu },  /* -0.745029 -> -0.00149006 */
    { 0xbeaecaccu, 0xbb700d3eu },  /* -0.341391 -> -0.0036629 */
    { 0xc00cb1c4u, 0xbc0f3c34u },  /* -2.19835 -> -0.00874238 */
    { 0x3f830fc6u, 0xbc35b80cu },  /* 1.02392 -> -0.0110912 */
    { 0xbf94d113u, 0xbc3a43a5u },  /* -1.16263 -> -0.0113687 */
    { 0xc00cb1c4u, 0xbc9432ccu },  /* -2.19835 -> -0.0180906 */
    { 0xbfb44aaau, 0xbccf4b24u },  /* -1.40853 -> -0.0253044 */
    { 0xbe86a814u, 0xbceaae0bu },  /* -0.263001 -> -0.0286474 */
    { 0xf149f2cau, 0xbd10af87u },  /* -1e+30 -> -0.0353236 */
    { 0x3fb93498u, 0xbd1e0613u },  /* 1.44692 -> -0.03858 */
    { 0x3fbb1e98u, 0xbd0631e7u },  /* 1.46187 -> -0.0327624 */
    { 0xff800000u, 0xbcf47046u },  /* -inf -> -0.0298387 */
    { 0x3ec6d718u, 0xbcee1360u },  /* 0.38836 -> -0.029062 */
    { 0xbfbbd542u, 0xbcffc164u },  /* -1.46745 -> -0.0312201 */
    { 0xbfc4ce70u, 0xbd187ea1u },  /* -1.53755 -> -0.0372301 */
    { 0x3fa1d536u, 0xbd1abba3u },  /* 1.26432 -> -0.0377766 */
    { 0x3f67ed98u, 0xbd08f436u },  /* 0.905969 -> -0.033436 */
    { 0x7fc00000u, 0xbd018842u },  /* nan -> -0.0316241 */
    { 0xbfaf2098u, 0xbd0cbd8bu },  /* -1.36818 -> -0.0343604 */
    { 0x3fa3f1d2u, 0xbd0d74c3u },  /* 1.28082 -> -0.0345352 */
    { 0x3fc4ce70u, 0xbcecbc6fu },  /* 1.53755 -> -0.0288984 */
    { 0xbf9edfa6u, 0xbce7e174u },  /* -1.2412 -> -0.0283057 */
    { 0x3ea827a8u, 0xbcf6d5e6u },  /* 0.328428 -> -0.0301313 */
    { 0x7f800000u, 0xbcf17460u },  /* inf -> -0.0294744 */
    { 0x3e8a6648u, 0xbced069bu },  /* 0.270312 -> -0.0289338 */
    { 0xbf79fb62u, 0xbcf8988au },  /* -0.976492 -> -0.0303462 */
    { 0xc00cb1c4u, 0xbd164e65u },  /* -2.19835 -> -0.0366959 */
    { 0xbe86f9fcu, 0xbd2a7988u },  /* -0.263626 -> -0.0416198 */
    { 0xbf03517cu, 0xbd30d628u },  /* -0.512962 -> -0.043173 */
    { 0xc0939ad4u, 0xbd4e3adeu },  /* -4.61265 -> -0.0503491 */
    { 0xbf1e5946u, 0xbd6c7d03u },  /* -0.61855 -> -0.0577364 */
    { 0xbed4bed4u, 0xbd74f59cu },  /* -0.415518 -> -0.0598045 */
};

/* learn: arguments, hash of every word of the learner afterwards. */
#define APPENDIX_A_SELFTEST_LEARN_START_Y 0x400cb1c4u
#define APPENDIX_A_SELFTEST_LEARN_START_U 0x00000000u
#define APPENDIX_A_SELFTEST_LEARN_CALLS 264u  /* more than any commit takes */
#define APPENDIX_A_SELFTEST_LEARN_AGE 131073u  /* set before row 32: past all waiting times */

APPENDIX_A_TABLE
static const uint32_t appendix_a_selftest_learn_rows[64][3] = {
    { 0x400cac1bu, 0x425a0febu, 0x51fe1744u },  /* 2.198, 54.5155 */
    { 0x400d2bbeu, 0x426a8ccbu, 0xf6c1d8a5u },  /* 2.20579, 58.6375 */
    { 0x400e22a7u, 0x4047ce44u, 0x4719b910u },  /* 2.22087, 3.12196 */
    { 0x40094cdcu, 0x42ca9294u, 0x2a9e0e70u },  /* 2.14532, 101.286 */
    { 0x400eb1a0u, 0x41da3340u, 0xa0d9b173u },  /* 2.22959, 27.275 */
    { 0x400c5057u, 0x4243a045u, 0x99242e6bu },  /* 2.1924, 48.9065 */
    { 0x400c4624u, 0x42a17c18u, 0x554261a9u },  /* 2.19178, 80.7424 */
    { 0x400f7a55u, 0x42dad652u, 0x151f80e5u },  /* 2.24184, 109.419 */
    { 0x3f292a30u, 0x429a5df6u, 0xa6aba873u },  /* 0.6608, 77.1835 */
    { 0x401831e8u, 0x42327443u, 0xb4d912c1u },  /* 2.37805, 44.6135 */
    { 0x4017695bu, 0x4223bd24u, 0xb8cb2454u },  /* 2.36581, 40.9347 */
    { 0x401653cdu, 0x41e33f9bu, 0xdc471ae9u },  /* 2.34886, 28.4061 */
    { 0x40140887u, 0x421942b2u, 0x9b8c254fu },  /* 2.31302, 38.3151 */
    { 0x4012b841u, 0x42a67383u, 0xd7eb1c74u },  /* 2.2925, 83.2256 */
    { 0x40160424u, 0x42d22afeu, 0xb21dbb92u },  /* 2.344, 105.084 */
    { 0x401b81f5u, 0x42a7af82u, 0x02b5bf39u },  /* 2.42981, 83.8428 */
    { 0x401b2c8eu, 0x41eef478u, 0x7909d0d2u },  /* 2.42459, 29.8694 */
    { 0x00000000u, 0x4283e016u, 0x984a76bcu },  /* 0, 65.9377 */
    { 0x401a4d2cu, 0x42b44c26u, 0x1e657e2cu },  /* 2.41096, 90.1487 */
    { 0x401e3b5eu, 0x423559efu, 0x6c63f544u },  /* 2.47237, 45.3378 */
    { 0x401d73d9u, 0xc15ba026u, 0x6a93d8dau },  /* 2.4602, -13.7266 */
    { 0x4016a61bu, 0x4251fd51u, 0xce529568u },  /* 2.35389, 52.4974 */
    { 0x4016bfd8u, 0x42c49237u, 0xe985ec12u },  /* 2.35546, 98.2856 */
    { 0x401b7f0au, 0x42af5938u, 0xc25ba368u },  /* 2.42963, 87.6743 */
    { 0x401f1e5cu, 0x42226a5bu, 0xcac4a8efu },  /* 2.48623, 40.6039 */
    { 0x401dd008u, 0x42203378u, 0xc72b92a6u },  /* 2.46582, 40.0503 */
    { 0xf149f2cau, 0x42e3c5a8u, 0xeb1137e8u },  /* -1e+30, 113.886 */
    { 0x4022cc87u, 0x4222f16fu, 0x95d5a129u },  /* 2.54373, 40.7358 */
    { 0x40217098u, 0x4233057du, 0x2dc14194u },  /* 2.5225, 44.7554 */
    { 0x40208c36u, 0x428ae7f0u, 0xabe5e054u },  /* 2.50856, 69.453 */
    { 0x40223a78u, 0x42e89b47u, 0xc1b8e194u },  /* 2.53482, 116.303 */
    { 0x4028ae49u, 0x421bde7bu, 0xffd56f85u },  /* 2.63564, 38.9673 */
    { 0x4021bcf2u, 0x423fac3bu, 0xed770efau },  /* 2.52716, 47.9182 */
    { 0x40212c3du, 0x42b95f4bu, 0xfcaffc87u },  /* 2.51833, 92.6861 */
    { 0x40252e97u, 0x4281fc35u, 0x2d39d471u },  /* 2.58097, 64.9926 */
    { 0x3fca1becu, 0x424231a6u, 0x51aa8095u },  /* 1.57898, 48.5485 */
    { 0x4025b580u, 0x41fdfb4au, 0x30685060u },  /* 2.5892, 31.7477 */
    { 0x402369bdu, 0x41fdc827u, 0xb4d8d100u },  /* 2.55333, 31.7227 */
    { 0x40211930u, 0x40e16fbau, 0xfdd71201u },  /* 2.51716, 7.04489 */
    { 0x401c5cf7u, 0x42a9dcb1u, 0xb0561d90u },  /* 2.44317, 84.931 */
    { 0x401fac66u, 0x42a20c87u, 0x1743f8e1u },  /* 2.4949, 81.0245 */
    { 0x402288aau, 0x42e2ffafu, 0xd572314du },  /* 2.53959, 113.499 */
    { 0x4028abf6u, 0x426db281u, 0x1226981du },  /* 2.6355, 59.4243 */
    { 0x40292208u, 0x422dc6bau, 0x5aac289bu },  /* 2.6427, 43.4441 */
    { 0x3f8a6e33u, 0xc1055a2fu, 0xd105cdbeu },  /* 1.08149, -8.33452 */
    { 0x40217749u, 0x42b4ed3bu, 0xa1f41440u },  /* 2.52291, 90.4633 */
    { 0x402549f9u, 0x42df3a54u, 0x46fcccaau },  /* 2.58264, 111.614 */
    { 0x402b1dd9u, 0x42a7af82u, 0x70308d6eu },  /* 2.6737, 83.8428 */
    { 0x402b8014u, 0x4291b005u, 0xdfb4bf3au },  /* 2.67969, 72.8438 */
    { 0x402d5496u, 0x419333bcu, 0x5788d1d3u },  /* 2.70829, 18.4003 */
    { 0x40297366u, 0x42a43af7u, 0xbdb1c127u },  /* 2.64767, 82.1152 */
    { 0x402c4722u, 0x41efe1d4u, 0x28aef1f3u },  /* 2.69184, 29.9853 */
    { 0x4029a5ceu, 0x42dc97e0u, 0xd5d8be61u },  /* 2.65074, 110.297 */
    { 0x3f708589u, 0x42bd456eu, 0x136b2c10u },  /* 0.939538, 94.6356 */
    { 0x4033462eu, 0x419110cdu, 0xf99e1a36u },  /* 2.80116, 18.1332 */
    { 0x402f490eu, 0x41ec3355u, 0x31c2cb30u },  /* 2.73883, 29.5251 */
    { 0x402c8746u, 0x40247e78u, 0x8cf6b58cu },  /* 2.69576, 2.57022 */
    { 0x402713f9u, 0x428ec970u, 0x7d595db4u },  /* 2.61059, 71.3934 */
    { 0x4028c9f8u, 0x425d3a6eu, 0xddf16048u },  /* 2.63733, 55.3071 */
    { 0x4028e3b3u, 0x42e2ea73u, 0xf2a8dc3au },  /* 2.6389, 113.458 */
    { 0x402ed914u, 0x40ad7765u, 0xfdc7ed95u },  /* 2.732, 5.42082 */
    { 0x4029aa92u, 0x4130afaau, 0xa5321340u },  /* 2.65104, 11.0429 */
    { 0x4006f9dau, 0x42eb0910u, 0x12116111u },  /* 2.109, 117.518 */
    { 0x402b9e14u, 0x421bde7bu, 0x523bbcdeu },  /* 2.68152, 38.9673 */
};

/* commit: age, calls, answer, hash of every word of instance and learner afterwards, theta before. */
APPENDIX_A_TABLE
static const uint32_t appendix_a_selftest_commit_rows[10][22] = {
    { 0u, 1u, 2u, 0x50f4e6bcu,
0x405c5091u, 0x3ea04e5eu, 0xbeb79038u, 0x3eb91b92u, 0x3e9819d1u, 0x3fb95ac1u, 0x4007b572u, 0x3e22bfc3u,
0x3f832843u, 0x40693cb5u, 0x3e2c547au, 0xbe1eb042u, 0x408a6546u, 0x3e573a76u, 0x3eda5910u, 0x409d29eeu,
0x3ebe6f47u, 0x3f21a51eu
    },
    { 131073u, 261u, 1u, 0xbfb7b51eu,
0x405c5062u, 0x3e936d8au, 0xbeb790a3u, 0x3eb91adau, 0x3e90ae00u, 0x3fb95aaeu, 0x4007b5adu, 0x3e2d8186u,
0x3f83284bu, 0x40693d2eu, 0x3e44a3dcu, 0xbe1eaf87u, 0x408a6580u, 0x3e6e4bc3u, 0x3eda596bu, 0x409d29feu,
0x3ec17fc5u, 0x3f21a52au
    },
    { 131073u, 206u, 5u, 0x0f19a3e2u,
0x405c5091u, 0x3ea04e5eu, 0xbeb79038u, 0x3eb91b92u, 0x3e9819d1u, 0x3fb95ac1u, 0x4007b572u, 0x3e22bfc3u,
0x3f832843u, 0x40693cb5u, 0x3e2c547au, 0xbe1eb042u, 0x408a6546u, 0x3e573a76u, 0x3eda5910u, 0x409d29eeu,
0x3ebe6f47u, 0x3f21a51eu
    },
    { 131073u, 259u, 6u, 0xece6fd6cu,
0x405c5062u, 0x3e936d8au, 0xbeb5fd94u, 0x3eb91adau, 0x3e90ae00u, 0x3fb9bf72u, 0x4007b5adu, 0x3e2d8186u,
0x3f838d0fu, 0x40693d2eu, 0x3e44a3dcu, 0xbe1b8969u, 0x408a6580u, 0x3e6e4bc3u, 0x3edbec7au, 0x409d29feu,
0x3ec17fc5u, 0x3f226eb2u
    },
    { 131073u, 261u, 1u, 0x0ae738bcu,
0x405c5062u, 0x3e936d8au, 0xbeb923b2u, 0x3eb91adau, 0x3e90ae00u, 0x3fb8f5eau, 0x4007b5adu, 0x3e2d8186u,
0x3f82c387u, 0x40693d2eu, 0x3e44a3dcu, 0xbe21d5a5u, 0x408a6580u, 0x3e6e4bc3u, 0x3ed8c65cu, 0x409d29feu,
0x3ec17fc5u, 0x3f20dba2u
    },
    { 131073u, 2u, 4u, 0x39e38c06u,
0x405c5062u, 0x3bbcb52bu, 0xbeb790a3u, 0x3eb91adau, 0x3bb930a4u, 0x3fb95aaeu, 0x4007b5adu, 0x3b5e166eu,
0x3f83284bu, 0x40693d2eu, 0x3b7bb305u, 0xbe1eaf87u, 0x408a6580u, 0x3b988268u, 0x3eda596bu, 0x409d29feu,
0x3bf7adc9u, 0x3f21a52au
    },
    { 131073u, 2u, 4u, 0x2ef4d2fdu,
0x405c5062u, 0xbe936d8au, 0xbeb790a3u, 0x3eb91adau, 0xbe90ae00u, 0x3fb95aaeu, 0x4007b5adu, 0xbe2d8186u,
0x3f83284bu, 0x40693d2eu, 0xbe44a3dcu, 0xbe1eaf87u, 0x408a6580u, 0xbe6e4bc3u, 0x3eda596bu, 0x409d29feu,
0xbec17fc5u, 0x3f21a52au
    },
    { 131073u, 2u, 5u, 0x6d5c43d2u,
0x408f343fu, 0x3e936d8au, 0xbeb790a3u, 0x3ef0a2e8u, 0x3e90ae00u, 0x3fb95aaeu, 0x40306c2du, 0x3e2d8186u,
0x3f83284bu, 0x40979af7u, 0x3e44a3dcu, 0xbe1eaf87u, 0x40b3ea59u, 0x3e6e4bc3u, 0x3eda596bu, 0x40cc5030u,
0x3ec17fc5u, 0x3f21a52au
    },
    { 131073u, 72u, 5u, 0x2952b443u,
0xc08f343fu, 0x3e936d8au, 0xbeb790a3u, 0xbef0a2e8u, 0x3e90ae00u, 0x3fb95aaeu, 0xc0306c2du, 0x3e2d8186u,
0x3f83284bu, 0xc0979af7u, 0x3e44a3dcu, 0xbe1eaf87u, 0xc0b3ea59u, 0x3e6e4bc3u, 0x3eda596bu, 0xc0cc5030u,
0x3ec17fc5u, 0x3f21a52au
    },
    { 131073u, 1u, 3u, 0x3a9c9b2bu,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u
    },
};

#endif
