/* diagnosed_selftest_data.h: inputs of the self-test, and the bits that the float32 reference computes from them. */

#ifndef DIAGNOSED_SELFTEST_DATA_H
#define DIAGNOSED_SELFTEST_DATA_H

#include <stdint.h>

#include "diagnosed.h"

/* predict: arguments, expected result. */
#define DIAGNOSED_SELFTEST_PREDICT_START_Y 0x400cb1c4u
#define DIAGNOSED_SELFTEST_PREDICT_START_U 0x00000000u
#define DIAGNOSED_SELFTEST_PREDICT_STATUS 0x0000000fu
#define DIAGNOSED_SELFTEST_PREDICT_Y_CLAMPED 5u
#define DIAGNOSED_SELFTEST_PREDICT_U_CLAMPED 2u
#define DIAGNOSED_SELFTEST_PREDICT_Y_REJECTED 3u
#define DIAGNOSED_SELFTEST_PREDICT_U_REJECTED 3u

DIAGNOSED_TABLE
static const uint32_t diagnosed_selftest_predict_rows[32][3] = {
    { 0x40130acbu, 0x40e16fbau, 0x401012f1u },  /* 2.29753, 7.04489 -> 2.25116 */
    { 0x4018d62eu, 0x42a9dcb1u, 0x40177070u },  /* 2.38807, 84.931 -> 2.36624 */
    { 0x000116c2u, 0xf149f2cau, 0x3f341a39u },  /* 9.99995e-41, -1e+30 -> 0.703525 */
    { 0x4054ca65u, 0x42e2ffafu, 0x40512b57u },  /* 3.32485, 113.499 -> 3.26827 */
    { 0x3fd97f40u, 0x426db281u, 0x3fdd4c2du },  /* 1.6992, 59.4243 -> 1.72889 */
    { 0x7fc00000u, 0xff800000u, 0x3fdf2c38u },  /* nan, -inf -> 1.74354 */
    { 0x4037e929u, 0xc1055a2fu, 0x403418e9u },  /* 2.87361, -8.33452 -> 2.81402 */
    { 0x40603901u, 0x42b4ed3bu, 0x405bfd3fu },  /* 3.50348, 90.4633 -> 3.43733 */
    { 0x00000000u, 0xc1a00000u, 0x3f357ad2u },  /* 0, -20 -> 0.708905 */
    { 0x40051f51u, 0x426bce0cu, 0x4003ea54u },  /* 2.08004, 58.9512 -> 2.06118 */
    { 0x3fffe6ccu, 0x4291b005u, 0x40008bc2u },  /* 1.99923, 72.8438 -> 2.00853 */
    { 0x40d9f3b6u, 0x7fc00000u, 0x406b4459u },  /* 6.811, nan -> 3.67605 */
    { 0x3ff8895cu, 0x42a43af7u, 0x3ffb40aau },  /* 1.94169, 82.1152 -> 1.96291 */
    { 0x403b66d1u, 0x41efe1d4u, 0x4038ebacu },  /* 2.92815, 29.9853 -> 2.88938 */
    { 0x406f18fcu, 0x42f00000u, 0x406bddceu },  /* 3.7359, 120 -> 3.68541 */
    { 0x400bbf81u, 0x42bd456eu, 0x400dcca1u },  /* 2.18356, 94.6356 -> 2.21561 */
    { 0x3fe0ca87u, 0x419110cdu, 0x3fe3186au },  /* 1.75618, 18.1332 -> 1.77418 */
    { 0x80000000u, 0xc3200000u, 0x3f333b63u },  /* -0, -160 -> 0.700125 */
    { 0x40452245u, 0x40247e78u, 0x40409dbcu },  /* 3.08022, 2.57022 -> 3.00963 */
    { 0x400623f8u, 0x428ec970u, 0x4006277cu },  /* 2.09595, 71.3934 -> 2.09616 */
    { 0xf149f2cau, 0x000116c2u, 0x3f399eb1u },  /* -1e+30, 9.99995e-41 -> 0.725078 */
    { 0x40103482u, 0x42e2ea73u, 0x4010d504u },  /* 2.2532, 113.458 -> 2.263 */
    { 0x40509284u, 0x40ad7765u, 0x404dc76cu },  /* 3.25894, 5.42082 -> 3.2153 */
    { 0xff800000u, 0x7f800000u, 0x4049a967u },  /* -inf, inf -> 3.15096 */
    { 0x3ffef8acu, 0x42eb0910u, 0x40014d02u },  /* 1.99196, 117.518 -> 2.02033 */
    { 0x3ffd6a37u, 0x42cac53cu, 0x40024640u },  /* 1.9798, 101.385 -> 2.03554 */
    { 0x7f800000u, 0x80000000u, 0x4002e331u },  /* inf, -0 -> 2.04512 */
    { 0x3fff579du, 0x4107ea96u, 0x3ffe1a3eu },  /* 1.99486, 8.49477 -> 1.98518 */
    { 0x4005525au, 0x42ce6710u, 0x4006c15du },  /* 2.08315, 103.201 -> 2.10555 */
    { 0x3f292a30u, 0x00000000u, 0x3f3dfdcau },  /* 0.6608, 0 -> 0.742154 */
    { 0x4069e6a1u, 0x42b69faeu, 0x4066af7cu },  /* 3.6547, 91.3119 -> 3.60446 */
    { 0x3f554929u, 0xc177c691u, 0x3f65c162u },  /* 0.833148, -15.486 -> 0.897482 */
};

/* simulate: arguments, expected result. */
#define DIAGNOSED_SELFTEST_SIMULATE_START_Y 0x400cb1c4u
#define DIAGNOSED_SELFTEST_SIMULATE_START_U 0x00000000u
#define DIAGNOSED_SELFTEST_SIMULATE_STATUS 0x0000000au
#define DIAGNOSED_SELFTEST_SIMULATE_Y_CLAMPED 0u
#define DIAGNOSED_SELFTEST_SIMULATE_U_CLAMPED 3u
#define DIAGNOSED_SELFTEST_SIMULATE_Y_REJECTED 0u
#define DIAGNOSED_SELFTEST_SIMULATE_U_REJECTED 2u

DIAGNOSED_TABLE
static const uint32_t diagnosed_selftest_simulate_rows[32][2] = {
    { 0x429f4944u, 0x400b9b17u },  /* 79.6431 -> 2.18134 */
    { 0xbf41a05bu, 0x4009f779u },  /* -0.756353 -> 2.15573 */
    { 0xc3200000u, 0x4006d317u },  /* -160 -> 2.10663 */
    { 0x428d34ddu, 0x40058201u },  /* 70.6032 -> 2.08606 */
    { 0x4279bfd0u, 0x40058508u },  /* 62.4373 -> 2.08624 */
    { 0x000116c2u, 0x400400edu },  /* 9.99995e-41 -> 2.06256 */
    { 0x4202092cu, 0x400260c6u },  /* 32.509 -> 2.03716 */
    { 0x4266cbc5u, 0x4001e12au },  /* 57.699 -> 2.02937 */
    { 0xf149f2cau, 0x40001997u },  /* -1e+30 -> 2.00156 */
    { 0x422115cau, 0x3ffd3a53u },  /* 40.2713 -> 1.97834 */
    { 0x3fc31fb7u, 0x3ffa8444u },  /* 1.52441 -> 1.95716 */
    { 0x43820000u, 0x3ffc4d1bu },  /* 260 -> 1.9711 */
    { 0x415884d8u, 0x3ffcc420u },  /* 13.5324 -> 1.97474 */
    { 0x4261fa3du, 0x3ffc037eu },  /* 56.4944 -> 1.96886 */
    { 0x42f00000u, 0x40000193u },  /* 120 -> 2.0001 */
    { 0x4217ca18u, 0x4000f6c7u },  /* 37.9474 -> 2.01506 */
    { 0x401918aeu, 0x3fffa21cu },  /* 2.39213 -> 1.99713 */
    { 0x80000000u, 0x3ffc576cu },  /* -0 -> 1.97142 */
    { 0xc030b7c5u, 0x3ff91af9u },  /* -2.76122 -> 1.94614 */
    { 0x42b4c6a3u, 0x3ffa3d66u },  /* 90.388 -> 1.955 */
    { 0xff800000u, 0x3ffea57du },  /* -inf -> 1.98943 */
    { 0x41cf0dbeu, 0x3fffc774u },  /* 25.8817 -> 1.99827 */
    { 0x42bd649fu, 0x40011452u },  /* 94.6965 -> 2.01687 */
    { 0x7fc00000u, 0x40036f69u },  /* nan -> 2.05367 */
    { 0x42b4ea76u, 0x4005a10fu },  /* 90.4579 -> 2.08796 */
    { 0x405df404u, 0x4005a1cau },  /* 3.46802 -> 2.088 */
    { 0xc1a00000u, 0x4003cea2u },  /* -20 -> 2.05949 */
    { 0x42ed8cf3u, 0x4004ea8du },  /* 118.775 -> 2.07682 */
    { 0x42075ad3u, 0x4006375cu },  /* 33.8387 -> 2.09713 */
    { 0x00000000u, 0x4005741du },  /* 0 -> 2.08521 */
    { 0xc1918f1fu, 0x4003d9aau },  /* -18.1949 -> 2.06016 */
    { 0x42d72899u, 0x4004e5b9u },  /* 107.579 -> 2.07652 */
};

/* inverse: arguments, expected result. */
#define DIAGNOSED_SELFTEST_INVERSE_START_Y 0x400cb1c4u
#define DIAGNOSED_SELFTEST_INVERSE_START_U 0x00000000u
#define DIAGNOSED_SELFTEST_INVERSE_STATUS 0x00000035u
#define DIAGNOSED_SELFTEST_INVERSE_Y_CLAMPED 5u
#define DIAGNOSED_SELFTEST_INVERSE_U_CLAMPED 0u
#define DIAGNOSED_SELFTEST_INVERSE_Y_REJECTED 5u
#define DIAGNOSED_SELFTEST_INVERSE_U_REJECTED 0u

DIAGNOSED_TABLE
static const uint32_t diagnosed_selftest_inverse_rows[32][3] = {
    { 0x4059dc88u, 0x4053f8cdu, 0x38d33333u },  /* 3.40409, 3.31206 -> 0.000100708 */
    { 0x3fbf3b6bu, 0x3fbdee83u, 0x3fc24dcdu },  /* 1.494, 1.48384 -> 1.518 */
    { 0x406f18fcu, 0x3f292a30u, 0xc0b724aeu },  /* 3.7359, 0.6608 -> -5.72323 */
    { 0x3f824051u, 0x3f84e1f0u, 0x42100000u },  /* 1.01759, 1.03815 -> 36 */
    { 0x3f9065a1u, 0x3f92d5ebu, 0x42e8d024u },  /* 1.1281, 1.14715 -> 116.407 */
    { 0xff800000u, 0x80000000u, 0x426a706cu },  /* -inf, -0 -> 58.6098 */
    { 0x3f911acdu, 0x3f9491deu, 0x42100000u },  /* 1.13363, 1.1607 -> 36 */
    { 0x3fa4d84au, 0x3fa7e0bcu, 0x42f00000u },  /* 1.28785, 1.31155 -> 120 */
    { 0x80000000u, 0xf149f2cau, 0x42800000u },  /* -0, -1e+30 -> 64 */
    { 0x3f794288u, 0x3f82e2d2u, 0x42100000u },  /* 0.973671, 1.02255 -> 36 */
    { 0x3ffbdc0du, 0x3ffc596eu, 0x42f00000u },  /* 1.96765, 1.97148 -> 120 */
    { 0x7f800000u, 0x40d9f3b6u, 0x42f00000u },  /* inf, 6.811 -> 120 */
    { 0x40350e16u, 0x40336ca2u, 0x42800000u },  /* 2.82898, 2.80351 -> 64 */
    { 0x4006ba40u, 0x40078378u, 0xc1a00000u },  /* 2.10512, 2.1174 -> -20 */
    { 0x3f292a30u, 0x000116c2u, 0xc1a00000u },  /* 0.6608, 9.99995e-41 -> -20 */
    { 0x404ec247u, 0x404d10dfu, 0x42100000u },  /* 3.23061, 3.20415 -> 36 */
    { 0x3f764e8cu, 0x3f86a2a8u, 0x42800000u },  /* 0.962136, 1.05184 -> 64 */
    { 0x7fc00000u, 0xff800000u, 0xc1a00000u },  /* nan, -inf -> -20 */
    { 0x3fb8c7bcu, 0x3fc16641u, 0x42100000u },  /* 1.4436, 1.51093 -> 36 */
    { 0x3f89abffu, 0x3f94e909u, 0x42800000u },  /* 1.07556, 1.16336 -> 64 */
    { 0x40d9f3b6u, 0x406f18fcu, 0x42100000u },  /* 6.811, 3.7359 -> 36 */
    { 0x40652288u, 0x40633c58u, 0x42800000u },  /* 3.58023, 3.55056 -> 64 */
    { 0x4056bef3u, 0x40557815u, 0xc1a00000u },  /* 3.3554, 3.33545 -> -20 */
    { 0x00000000u, 0x00000000u, 0xc1a00000u },  /* 0, 0 -> -20 */
    { 0x4048ff21u, 0x404864b6u, 0x42100000u },  /* 3.14057, 3.13115 -> 36 */
    { 0x40314e01u, 0x4031c5f3u, 0x42800000u },  /* 2.77039, 2.77771 -> 64 */
    { 0xf149f2cau, 0x7fc00000u, 0xc1a00000u },  /* -1e+30, nan -> -20 */
    { 0x4015142du, 0x4016fbedu, 0x42100000u },  /* 2.32936, 2.35913 -> 36 */
    { 0x3ff463d2u, 0x3ffb0b08u, 0x42800000u },  /* 1.9093, 1.96127 -> 64 */
    { 0x000116c2u, 0x7f800000u, 0xc1a00000u },  /* 9.99995e-41, inf -> -20 */
    { 0x40218d04u, 0x402303b8u, 0x42100000u },  /* 2.52423, 2.5471 -> 36 */
    { 0x4067a433u, 0x40662c54u, 0x42f00000u },  /* 3.6194, 3.59646 -> 120 */
};

/* learn: arguments, hash of every word of the learner afterwards. */
#define DIAGNOSED_SELFTEST_LEARN_START_Y 0x400cb1c4u
#define DIAGNOSED_SELFTEST_LEARN_START_U 0x00000000u
#define DIAGNOSED_SELFTEST_LEARN_CALLS 40u  /* more than any commit takes */
#define DIAGNOSED_SELFTEST_LEARN_AGE 131073u  /* set before row 32: past all waiting times */

DIAGNOSED_TABLE
static const uint32_t diagnosed_selftest_learn_rows[64][3] = {
    { 0x400cac1bu, 0x425a0febu, 0x57638b7du },  /* 2.198, 54.5155 */
    { 0x400b00c6u, 0x426a8ccbu, 0x049dc04au },  /* 2.17192, 58.6375 */
    { 0x400a6addu, 0x4047ce44u, 0x9befcaffu },  /* 2.16277, 3.12196 */
    { 0x40089410u, 0x42ca9294u, 0x462dd87au },  /* 2.13404, 101.286 */
    { 0x40084f89u, 0x41da3340u, 0x63702a12u },  /* 2.12985, 27.275 */
    { 0x4007c56eu, 0x4243a045u, 0x1cba8f64u },  /* 2.12143, 48.9065 */
    { 0x4006bfaau, 0x42a17c18u, 0xe346d48du },  /* 2.10545, 80.7424 */
    { 0x4006dc78u, 0x42dad652u, 0x4e0fbdb5u },  /* 2.10721, 109.419 */
    { 0x3f292a30u, 0x429a5df6u, 0xf1c4a9f0u },  /* 0.6608, 77.1835 */
    { 0x40098f82u, 0x42327443u, 0xabcf64c0u },  /* 2.14938, 44.6135 */
    { 0x40095c6fu, 0x4223bd24u, 0x6314af37u },  /* 2.14627, 40.9347 */
    { 0x4008b4f2u, 0x41e33f9bu, 0x5d0c9a43u },  /* 2.13604, 28.4061 */
    { 0x4007db71u, 0x421942b2u, 0xa8e75a7du },  /* 2.12277, 38.3151 */
    { 0x40071483u, 0x42a67383u, 0x5cef5f3eu },  /* 2.11063, 83.2256 */
    { 0x400794d3u, 0x42d22afeu, 0x6ce30e11u },  /* 2.11846, 105.084 */
    { 0x400979fdu, 0x42a7af82u, 0x73acf66fu },  /* 2.14807, 83.8428 */
    { 0x400a5085u, 0x41eef478u, 0xb1e6ae2au },  /* 2.16116, 29.8694 */
    { 0x00000000u, 0x4283e016u, 0x0061562bu },  /* 0, 65.9377 */
    { 0x400a1435u, 0x42b44c26u, 0xf292ecd4u },  /* 2.15748, 90.1487 */
    { 0x400b8b43u, 0x423559efu, 0x55f506dfu },  /* 2.18037, 45.3378 */
    { 0x400c4bf0u, 0xc15ba026u, 0x415549fdu },  /* 2.19213, -13.7266 */
    { 0x400b102eu, 0x4251fd51u, 0x84757b60u },  /* 2.17286, 52.4974 */
    { 0x400a8b27u, 0x42c49237u, 0x0bcc6b69u },  /* 2.16474, 98.2856 */
    { 0x400c322cu, 0x42af5938u, 0x9d7838d2u },  /* 2.19056, 87.6743 */
    { 0x400e69c2u, 0x42226a5bu, 0x8bf59948u },  /* 2.2252, 40.6039 */
    { 0x400f3ae4u, 0x42203378u, 0x094f9200u },  /* 2.23797, 40.0503 */
    { 0xf149f2cau, 0x42e3c5a8u, 0xb65552adu },  /* -1e+30, 113.886 */
    { 0x4011486eu, 0x4222f16fu, 0x59b32886u },  /* 2.27005, 40.7358 */
    { 0x40128b20u, 0x4233057du, 0x1fc47bb2u },  /* 2.28974, 44.7554 */
    { 0x4012cd3bu, 0x428ae7f0u, 0xbccf6a7au },  /* 2.29378, 69.453 */
    { 0x4013b994u, 0x42e89b47u, 0x68ca03dfu },  /* 2.3082, 116.303 */
    { 0x401635bdu, 0x421bde7bu, 0x841112b5u },  /* 2.34703, 38.9673 */
    { 0x401634fbu, 0x423fac3bu, 0xc10739bdu },  /* 2.34698, 47.9182 */
    { 0x4015b850u, 0x42b95f4bu, 0x0bbafd2fu },  /* 2.33937, 92.6861 */
    { 0x40172ad0u, 0x4281fc35u, 0x8d8af01fu },  /* 2.36199, 64.9926 */
    { 0x3fca1becu, 0x424231a6u, 0xf41ac1eeu },  /* 1.57898, 48.5485 */
    { 0x40193875u, 0x41fdfb4au, 0x6f35411eu },  /* 2.39407, 31.7477 */
    { 0x40192d24u, 0x41fdc827u, 0x82b243fbu },  /* 2.39338, 31.7227 */
    { 0x4018d078u, 0x40e16fbau, 0x47bf584du },  /* 2.38772, 7.04489 */
    { 0x4017f401u, 0x42a9dcb1u, 0xb787d4cau },  /* 2.37427, 84.931 */
    { 0x40186997u, 0x42a20c87u, 0xf769eb7au },  /* 2.38144, 81.0245 */
    { 0x4019f8ceu, 0x42e2ffafu, 0xb557b63cu },  /* 2.40581, 113.499 */
    { 0x401c3775u, 0x426db281u, 0x846cc8bcu },  /* 2.44088, 59.4243 */
    { 0x401d79b7u, 0x422dc6bau, 0xf0fbf450u },  /* 2.46055, 43.4441 */
    { 0x3f8a6e33u, 0xc1055a2fu, 0xdb432851u },  /* 1.08149, -8.33452 */
    { 0x401be36cu, 0x42b4ed3bu, 0x4bc53338u },  /* 2.43576, 90.4633 */
    { 0x401bcdc5u, 0x42df3a54u, 0x71015987u },  /* 2.43443, 111.614 */
    { 0x401dc0bdu, 0x42a7af82u, 0x1dfa41ffu },  /* 2.46489, 83.8428 */
    { 0x401ea4eau, 0x4291b005u, 0x390a19e5u },  /* 2.47882, 72.8438 */
    { 0x401ef3f0u, 0x419333bcu, 0x47fac5d1u },  /* 2.48364, 18.4003 */
    { 0x401e139bu, 0x42a43af7u, 0x0f1eac10u },  /* 2.46995, 82.1152 */
    { 0x401dd983u, 0x41efe1d4u, 0xf788a31fu },  /* 2.4664, 29.9853 */
    { 0x401d52a7u, 0x42dc97e0u, 0xdf57f855u },  /* 2.45817, 110.297 */
    { 0x3f708589u, 0x42bd456eu, 0xebac4ebau },  /* 0.939538, 94.6356 */
    { 0x401f1c36u, 0x419110cdu, 0x5e8c8f17u },  /* 2.4861, 18.1332 */
    { 0x401e4837u, 0x41ec3355u, 0x08b57c3fu },  /* 2.47316, 29.5251 */
    { 0x401c8028u, 0x40247e78u, 0x0e0ab96eu },  /* 2.44532, 2.57022 */
    { 0x401a51c3u, 0x428ec970u, 0x6ebbcb0bu },  /* 2.41124, 71.3934 */
    { 0x40193dd4u, 0x425d3a6eu, 0x80117390u },  /* 2.3944, 55.3071 */
    { 0x4018e67cu, 0x42e2ea73u, 0x7491da30u },  /* 2.38907, 113.458 */
    { 0x4019960fu, 0x40ad7765u, 0xa2ff5be8u },  /* 2.39978, 5.42082 */
    { 0x4018a662u, 0x4130afaau, 0x641be176u },  /* 2.38516, 11.0429 */
    { 0x4006f9dau, 0x42eb0910u, 0x289866c4u },  /* 2.109, 117.518 */
    { 0x401637ebu, 0x421bde7bu, 0xaa67d755u },  /* 2.34716, 38.9673 */
};

/* commit: age, calls, answer, hash of every word of instance and learner afterwards, theta before. */
DIAGNOSED_TABLE
static const uint32_t diagnosed_selftest_commit_rows[10][22] = {
    { 0u, 1u, 2u, 0xe853f249u,
0x40ab28bcu, 0x3f1ad548u, 0x3ac7841fu, 0x409e5d6fu, 0x3f0705dbu, 0x3b1504f4u, 0x40575259u, 0x3ea31149u,
0x3a31023bu, 0x40577d0bu, 0x3e939e35u, 0xba2358dcu, 0x409f09b0u, 0x3ed566adu, 0xbad593e4u, 0x40acb919u,
0x3ee61f85u, 0xbac332ffu
    },
    { 131073u, 37u, 1u, 0x28717255u,
0x40aaf7a7u, 0x3f12da1cu, 0x00000000u, 0x409e3e50u, 0x3f0109bcu, 0x3a8f3a5au, 0x405786e4u, 0x3ea4e483u,
0x3a525ba7u, 0x4057fa90u, 0x3e9be5e4u, 0x39029668u, 0x409f3da1u, 0x3edc7b61u, 0xba80d100u, 0x40acc45eu,
0x3ee7a9b6u, 0xbab0b719u
    },
    { 131073u, 35u, 6u, 0xe72f3605u,
0x40ab28bcu, 0x3f1ad548u, 0x3ac7841fu, 0x409e5d6fu, 0x3f0705dbu, 0x3b1504f4u, 0x40575259u, 0x3ea31149u,
0x3a31023bu, 0x40577d0bu, 0x3e939e35u, 0xba2358dcu, 0x409f09b0u, 0x3ed566adu, 0xbad593e4u, 0x40acb919u,
0x3ee61f85u, 0xbac332ffu
    },
    { 131073u, 37u, 1u, 0x92f5f25du,
0x40aaf7a7u, 0x3f12da1cu, 0x3b49879eu, 0x409e3e50u, 0x3f0109bcu, 0x3b889266u, 0x405786e4u, 0x3ea4e483u,
0x3b7e1e88u, 0x4057fa90u, 0x3e9be5e4u, 0x3b51b104u, 0x409f3da1u, 0x3edc7b61u, 0x3b091f1eu, 0x40acc45eu,
0x3ee7a9b6u, 0x3ae25823u
    },
    { 131073u, 35u, 6u, 0xe14e1667u,
0x40aaf7a7u, 0x3f12da1cu, 0xbb49879eu, 0x409e3e50u, 0x3f0109bcu, 0xbb01ea71u, 0x405786e4u, 0x3ea4e483u,
0xbb14f0b4u, 0x4057fa90u, 0x3e9be5e4u, 0xbb415e38u, 0x409f3da1u, 0x3edc7b61u, 0xbb84f80fu, 0x40acc45eu,
0x3ee7a9b6u, 0xbb90f195u
    },
    { 131073u, 2u, 4u, 0x614d5dc4u,
0x40aaf7a7u, 0x3c3bf875u, 0x00000000u, 0x409e3e50u, 0x3c252b2eu, 0x3a8f3a5au, 0x405786e4u, 0x3bd31004u,
0x3a525ba7u, 0x4057fa90u, 0x3bc78ca9u, 0x39029668u, 0x409f3da1u, 0x3c0d1bc3u, 0xba80d100u, 0x40acc45eu,
0x3c1443a7u, 0xbab0b719u
    },
    { 131073u, 2u, 4u, 0x783cb175u,
0x40aaf7a7u, 0xbf12da1cu, 0x00000000u, 0x409e3e50u, 0xbf0109bcu, 0x3a8f3a5au, 0x405786e4u, 0xbea4e483u,
0x3a525ba7u, 0x4057fa90u, 0xbe9be5e4u, 0x39029668u, 0x409f3da1u, 0xbedc7b61u, 0xba80d100u, 0x40acc45eu,
0xbee7a9b6u, 0xbab0b719u
    },
    { 131073u, 2u, 5u, 0x5523269eu,
0x40de41f2u, 0x3f12da1cu, 0x00000000u, 0x40cdb768u, 0x3f0109bcu, 0x3a8f3a5au, 0x408c17adu, 0x3ea4e483u,
0x3a525ba7u, 0x408c62ddu, 0x3e9be5e4u, 0x39029668u, 0x40cf0351u, 0x3edc7b61u, 0xba80d100u, 0x40e098e0u,
0x3ee7a9b6u, 0xbab0b719u
    },
    { 131073u, 2u, 5u, 0x94ab36ccu,
0xc0de41f2u, 0x3f12da1cu, 0x00000000u, 0xc0cdb768u, 0x3f0109bcu, 0x3a8f3a5au, 0xc08c17adu, 0x3ea4e483u,
0x3a525ba7u, 0xc08c62ddu, 0x3e9be5e4u, 0x39029668u, 0xc0cf0351u, 0x3edc7b61u, 0xba80d100u, 0xc0e098e0u,
0x3ee7a9b6u, 0xbab0b719u
    },
    { 131073u, 1u, 3u, 0x8d1aa3d3u,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u
    },
};

#endif
