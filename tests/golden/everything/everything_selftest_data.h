/* everything_selftest_data.h: inputs of the self-test, and the bits that the float32 reference computes from them. */

#ifndef EVERYTHING_SELFTEST_DATA_H
#define EVERYTHING_SELFTEST_DATA_H

#include <stdint.h>

#include "everything.h"

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
    { 0x3f824051u, 0x3f83e3f7u, 0x421c2225u, 0x3f800000u },  /* 1.01759, 1.03039, 39.0333 -> 1 */
    { 0x3f9065a1u, 0x3f91d02cu, 0x41a3084au, 0x42240000u },  /* 1.1281, 1.13917, 20.379 -> 41 */
    { 0xff800000u, 0x80000000u, 0x42a20000u, 0x42540000u },  /* -inf, -0, 81 -> 53 */
    { 0x3f911acdu, 0x3f937b5du, 0x41a23091u, 0x424c0000u },  /* 1.13363, 1.1522, 20.2737 -> 51 */
    { 0x3fa4d84au, 0x3fa6c1cau, 0x41ca4847u, 0x42b20000u },  /* 1.28785, 1.30279, 25.2853 -> 89 */
    { 0x80000000u, 0xf149f2cau, 0x42200000u, 0x42c40000u },  /* -0, -1e+30, 40 -> 98 */
    { 0x3f794288u, 0x3f81a981u, 0x4199a3c4u, 0x42b80000u },  /* 0.973671, 1.01299, 19.205 -> 92 */
    { 0x3ffbdc0du, 0x3ffb29a0u, 0x40f30d07u, 0x42dc0000u },  /* 1.96765, 1.96221, 7.59534 -> 110 */
    { 0x7f800000u, 0x40d9f3b6u, 0x000116c2u, 0x42dc0000u },  /* inf, 6.811, 9.99995e-41 -> 110 */
    { 0x40350e16u, 0x4032d218u, 0x42011eb0u, 0x42c40000u },  /* 2.82898, 2.79407, 32.28 -> 98 */
    { 0x4006ba40u, 0x4006d88du, 0x41b8db8du, 0x42880000u },  /* 2.10512, 2.10697, 23.1072 -> 68 */
    { 0x3f292a30u, 0x000116c2u, 0xf149f2cau, 0x42180000u },  /* 0.6608, 9.99995e-41, -1e+30 -> 38 */
    { 0x404ec247u, 0x404c6333u, 0x410c78fau, 0x42100000u },  /* 3.23061, 3.19355, 8.77954 -> 36 */
    { 0x3f764e8cu, 0x3f84f675u, 0x40741415u, 0x42400000u },  /* 0.962136, 1.03877, 3.81373 -> 48 */
    { 0x7fc00000u, 0xff800000u, 0x7fc00000u, 0x41900000u },  /* nan, -inf, nan -> 18 */
    { 0x3fb8c7bcu, 0x3fc0f281u, 0x40ea0454u, 0x41800000u },  /* 1.4436, 1.5074, 7.31303 -> 16 */
    { 0x3f89abffu, 0x3f94bb7bu, 0x40c65246u, 0x41e00000u },  /* 1.07556, 1.16197, 6.19754 -> 28 */
    { 0x40d9f3b6u, 0x406f18fcu, 0xff800000u, 0x41d00000u },  /* 6.811, 3.7359, -inf -> 26 */
    { 0x40652288u, 0x4063221au, 0x4218d5d2u, 0x42180000u },  /* 3.58023, 3.54896, 38.2088 -> 38 */
    { 0x4056bef3u, 0x40555b3fu, 0x41921bc7u, 0x41000000u },  /* 3.3554, 3.33369, 18.2636 -> 8 */
    { 0x00000000u, 0x00000000u, 0xc2280000u, 0xc1400000u },  /* 0, 0, -42 -> -12 */
    { 0x4048ff21u, 0x404844e4u, 0x40421597u, 0x3f800000u },  /* 3.14057, 3.1292, 3.03257 -> 1 */
    { 0x40314e01u, 0x4031a50du, 0x3fa7b779u, 0x41500000u },  /* 2.77039, 2.7757, 1.31029 -> 13 */
    { 0xf149f2cau, 0x7fc00000u, 0x7f800000u, 0xc1100000u },  /* -1e+30, nan, inf -> -9 */
    { 0x4015142du, 0x4016db34u, 0x4219ff23u, 0x3f800000u },  /* 2.32936, 2.35713, 38.4992 -> 1 */
    { 0x3ff463d2u, 0x3ffacb44u, 0x41fcb356u, 0x41500000u },  /* 1.9093, 1.95933, 31.5876 -> 13 */
    { 0x000116c2u, 0x7f800000u, 0x00000000u, 0xc1100000u },  /* 9.99995e-41, inf, 0 -> -9 */
    { 0x40218d04u, 0x4022e9b2u, 0x414eaf86u, 0x3f800000u },  /* 2.52423, 2.54551, 12.9179 -> 1 */
    { 0x4067a433u, 0x4066169bu, 0x41acd8cfu, 0x42240000u },  /* 3.6194, 3.59513, 21.6059 -> 41 */
};

/* correct: arguments, auxiliary channels, expected result. */
#define EVERYTHING_SELFTEST_CORRECT_START_Y 0x400cb1c4u
#define EVERYTHING_SELFTEST_CORRECT_START_U 0x00000000u
#define EVERYTHING_SELFTEST_CORRECT_STATUS 0x000000c5u
#define EVERYTHING_SELFTEST_CORRECT_Y_CLAMPED 2u
#define EVERYTHING_SELFTEST_CORRECT_U_CLAMPED 0u
#define EVERYTHING_SELFTEST_CORRECT_Y_REJECTED 3u
#define EVERYTHING_SELFTEST_CORRECT_U_REJECTED 0u

EVERYTHING_TABLE
static const uint32_t everything_selftest_correct_rows[32][3] = {
    { 0xbf3eba3au, 0x421027a6u, 0xbc0f712bu },  /* -0.745029, 36.0387 -> -0.00875501 */
    { 0xbeaecaccu, 0x41f5c845u, 0xbcbb34a3u },  /* -0.341391, 30.7228 -> -0.0228522 */
    { 0xc00cb1c4u, 0x42200000u, 0xbd6515c8u },  /* -2.19835, 40 -> -0.055929 */
    { 0x3f830fc6u, 0x4188af40u, 0xbd9e6ddau },  /* 1.02392, 17.0856 -> -0.077358 */
    { 0xbf94d113u, 0x401c3c3au, 0xbdb4f19bu },  /* -1.16263, 2.44118 -> -0.0883515 */
    { 0xc00cb1c4u, 0x000116c2u, 0xbe0c1e4du },  /* -2.19835, 9.99995e-41 -> -0.136834 */
    { 0xbfb44aaau, 0x41b85423u, 0xbe4608f5u },  /* -1.40853, 23.0411 -> -0.193394 */
    { 0xbe86a814u, 0x4198774au, 0xbe6e23ccu },  /* -0.263001, 19.0582 -> -0.232558 */
    { 0xf149f2cau, 0x00000000u, 0xbe95e7c8u },  /* -1e+30, 0 -> -0.292784 */
    { 0x3fb93498u, 0x420be0eau, 0xbe99999au },  /* 1.44692, 34.9696 -> -0.3 */
    { 0x3fbb1e98u, 0x420bce2au, 0xbe953a12u },  /* 1.46187, 34.9513 -> -0.291459 */
    { 0xff800000u, 0x7fc00000u, 0xbe95881fu },  /* -inf, nan -> -0.292054 */
    { 0x3ec6d718u, 0x420e58e9u, 0xbe9994deu },  /* 0.38836, 35.5868 -> -0.299964 */
    { 0xbfbbd542u, 0xbe7d54f8u, 0xbe99999au },  /* -1.46745, -0.247394 -> -0.3 */
    { 0xbfc4ce70u, 0xff800000u, 0xbe99999au },  /* -1.53755, -inf -> -0.3 */
    { 0x3fa1d536u, 0xbf00584bu, 0xbe99999au },  /* 1.26432, -0.501347 -> -0.3 */
    { 0x3f67ed98u, 0x412ed29eu, 0xbe9264ebu },  /* 0.905969, 10.9264 -> -0.285926 */
    { 0x7fc00000u, 0x42a20000u, 0xbe8ff0fcu },  /* nan, 81 -> -0.281135 */
    { 0xbfaf2098u, 0x41790ac7u, 0xbe999516u },  /* -1.36818, 15.5651 -> -0.299966 */
    { 0x3fa3f1d2u, 0x41c9d179u, 0xbe99999au },  /* 1.28082, 25.2273 -> -0.3 */
    { 0x3fc4ce70u, 0xf149f2cau, 0xbe8a4ad8u },  /* 1.53755, -1e+30 -> -0.270102 */
    { 0xbf9edfa6u, 0x40f00a2eu, 0xbe872be5u },  /* -1.2412, 7.50124 -> -0.264007 */
    { 0x3ea827a8u, 0x41b6afe6u, 0xbe8aca88u },  /* 0.328428, 22.8359 -> -0.271076 */
    { 0x7f800000u, 0x7f800000u, 0xbe87abaau },  /* inf, inf -> -0.264982 */
    { 0x3e8a6648u, 0x40f079e3u, 0xbe8495c5u },  /* 0.270312, 7.51488 -> -0.258955 */
    { 0xbf79fb62u, 0x41bdaeb8u, 0xbe872d08u },  /* -0.976492, 23.7103 -> -0.264015 */
    { 0xc00cb1c4u, 0xbf800000u, 0xbe995ddfu },  /* -2.19835, -1 -> -0.299544 */
    { 0xbe86f9fcu, 0x3f8a95edu, 0xbe99999au },  /* -0.263626, 1.0827 -> -0.3 */
    { 0xbf03517cu, 0x41f26908u, 0xbe99999au },  /* -0.512962, 30.3013 -> -0.3 */
    { 0xc0939ad4u, 0xc2280000u, 0xbe99999au },  /* -4.61265, -42 -> -0.3 */
    { 0xbf1e5946u, 0xbe4d1aafu, 0xbe99999au },  /* -0.61855, -0.200297 -> -0.3 */
    { 0xbed4bed4u, 0x41bb9c4eu, 0xbe99999au },  /* -0.415518, 23.4513 -> -0.3 */
};

#endif
