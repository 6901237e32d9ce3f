/* smooth_50_params.h: the numbers of model `smooth_50`. All that changes when the same structure is identified again.
 *
 * Part 1 comes with smooth_50.h. smooth_50.c defines SMOOTH_50_NUMBERS for part 2, smooth_50_selftest.c
 * SMOOTH_50_SELFTEST_NUMBERS for part 3. Every float32 is written with 9 significant digits, which read back to the bits
 * in the comment behind it. */

#ifndef SMOOTH_50_PARAMS_H
#define SMOOTH_50_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define SMOOTH_50_NUMBERS_DIGEST "d77bd2aa4deee7473b5e9709d85bf15a81a7328309ee9f47aadf4ddbfd9d28e9"
#define SMOOTH_50_NUMBERS_WORD 0xd77bd2aau

/* Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value. */
#define SMOOTH_50_Y_MIN_UM            0.5f  /* 0x3f000000 */
#define SMOOTH_50_Y_MAX_UM            9.0f  /* 0x41100000 */
#define SMOOTH_50_Y_REST_UM          4.75f  /* 0x40980000 */
#define SMOOTH_50_U_MIN_V           -20.0f  /* 0xc1a00000 */
#define SMOOTH_50_U_MAX_V           120.0f  /* 0x42f00000 */
#define SMOOTH_50_U_REST_V            0.0f  /* 0x00000000 */
#define SMOOTH_50_U_STEP_MAX_V      280.0f  /* 0x438c0000 */
#define SMOOTH_50_REFERENCE_MIN_UM   -8.0f  /* 0xc1000000 */
#define SMOOTH_50_REFERENCE_MAX_UM   17.5f  /* 0x418c0000 */

/* Worst error of one step against the float64 model, measured when this file was generated
 * over 20000 samples of the whole range, rounded up. */
#define SMOOTH_50_PREDICT_ERROR_UM  2.79999995e-06f  /* 0x363be7a2 */
#define SMOOTH_50_INVERSE_ERROR_V    0.00109999999f  /* 0x3a902de0 */

#endif

#ifdef SMOOTH_50_NUMBERS

/* Rules, Eqs (1) to (7): steps per um from the lowest centre; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/V]. */
#define SMOOTH_50_ORIGIN_UM         0.5f  /* 0x3f000000 */
#define SMOOTH_50_PER_STEP   5.76470566f  /* 0x40b87878 */

SMOOTH_50_TABLE
static const float smooth_50_strength[SMOOTH_50_WINDOW] = {
    3.72665318e-06f,  /* 0x367a176a */
    0.000335462624f,  /* 0x39afe108 */
      0.0111089963f,  /* 0x3c360282 */
       0.135335281f,  /* 0x3e0a9555 */
       0.606530666f,  /* 0x3f1b4598 */
               1.0f,  /* 0x3f800000 */
       0.606530666f,  /* 0x3f1b4598 */
       0.135335281f,  /* 0x3e0a9555 */
      0.0111089963f,  /* 0x3c360282 */
    0.000335462624f,  /* 0x39afe108 */
    3.72665318e-06f,  /* 0x367a176a */
};

SMOOTH_50_TABLE
static const float smooth_50_present[SMOOTH_50_BANK_RULES] = {
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
};

SMOOTH_50_TABLE
static const float smooth_50_slope[SMOOTH_50_BANK_RULES] = {
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
       0.899999976f,  /* 0x3f666666 */
       0.901020408f,  /* 0x3f66a946 */
       0.902040839f,  /* 0x3f66ec26 */
       0.903061211f,  /* 0x3f672f05 */
       0.904081643f,  /* 0x3f6771e5 */
       0.905102015f,  /* 0x3f67b4c4 */
       0.906122446f,  /* 0x3f67f7a4 */
       0.907142878f,  /* 0x3f683a84 */
       0.908163249f,  /* 0x3f687d63 */
       0.909183681f,  /* 0x3f68c043 */
       0.910204053f,  /* 0x3f690322 */
       0.911224484f,  /* 0x3f694602 */
       0.912244916f,  /* 0x3f6988e2 */
       0.913265288f,  /* 0x3f69cbc1 */
       0.914285719f,  /* 0x3f6a0ea1 */
       0.915306151f,  /* 0x3f6a5181 */
       0.916326523f,  /* 0x3f6a9460 */
       0.917346954f,  /* 0x3f6ad740 */
       0.918367326f,  /* 0x3f6b1a1f */
       0.919387758f,  /* 0x3f6b5cff */
       0.920408189f,  /* 0x3f6b9fdf */
       0.921428561f,  /* 0x3f6be2be */
       0.922448993f,  /* 0x3f6c259e */
       0.923469365f,  /* 0x3f6c687d */
       0.924489796f,  /* 0x3f6cab5d */
       0.925510228f,  /* 0x3f6cee3d */
         0.9265306f,  /* 0x3f6d311c */
       0.927551031f,  /* 0x3f6d73fc */
       0.928571403f,  /* 0x3f6db6db */
       0.929591835f,  /* 0x3f6df9bb */
       0.930612266f,  /* 0x3f6e3c9b */
       0.931632638f,  /* 0x3f6e7f7a */
       0.932653069f,  /* 0x3f6ec25a */
       0.933673441f,  /* 0x3f6f0539 */
       0.934693873f,  /* 0x3f6f4819 */
       0.935714304f,  /* 0x3f6f8af9 */
       0.936734676f,  /* 0x3f6fcdd8 */
       0.937755108f,  /* 0x3f7010b8 */
       0.938775539f,  /* 0x3f705398 */
       0.939795911f,  /* 0x3f709677 */
       0.940816343f,  /* 0x3f70d957 */
       0.941836715f,  /* 0x3f711c36 */
       0.942857146f,  /* 0x3f715f16 */
       0.943877578f,  /* 0x3f71a1f6 */
        0.94489795f,  /* 0x3f71e4d5 */
       0.945918381f,  /* 0x3f7227b5 */
       0.946938753f,  /* 0x3f726a94 */
       0.947959185f,  /* 0x3f72ad74 */
       0.948979616f,  /* 0x3f72f054 */
       0.949999988f,  /* 0x3f733333 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
};

SMOOTH_50_TABLE
static const float smooth_50_offset[SMOOTH_50_BANK_RULES] = {
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
      0.0199999996f,  /* 0x3ca3d70a */
      0.0299958345f,  /* 0x3cf5b9d3 */
      0.0395751782f,  /* 0x3d221995 */
      0.0487380251f,  /* 0x3d47a186 */
      0.0574843809f,  /* 0x3d6b74be */
      0.0658142418f,  /* 0x3d86c99e */
      0.0737276152f,  /* 0x3d96fe81 */
      0.0812244862f,  /* 0x3da65906 */
      0.0883048698f,  /* 0x3db4d92f */
       0.094968766f,  /* 0x3dc27efc */
        0.10121616f,  /* 0x3dcf4a6b */
       0.107047066f,  /* 0x3ddb3b7e */
       0.112461478f,  /* 0x3de65234 */
       0.117459394f,  /* 0x3df08e8d */
       0.122040816f,  /* 0x3df9f089 */
       0.126205742f,  /* 0x3e013c14 */
       0.129954189f,  /* 0x3e0512b6 */
       0.133286133f,  /* 0x3e087c29 */
       0.136201575f,  /* 0x3e0b786d */
       0.138700545f,  /* 0x3e0e0784 */
       0.140783012f,  /* 0x3e10296c */
       0.142448977f,  /* 0x3e11de25 */
       0.143698454f,  /* 0x3e1325b0 */
       0.144531444f,  /* 0x3e14000d */
       0.144947931f,  /* 0x3e146d3b */
       0.144947931f,  /* 0x3e146d3b */
       0.144531444f,  /* 0x3e14000d */
       0.143698454f,  /* 0x3e1325b0 */
       0.142448977f,  /* 0x3e11de25 */
       0.140783012f,  /* 0x3e10296c */
       0.138700545f,  /* 0x3e0e0784 */
       0.136201575f,  /* 0x3e0b786d */
       0.133286133f,  /* 0x3e087c29 */
       0.129954189f,  /* 0x3e0512b6 */
       0.126205742f,  /* 0x3e013c14 */
       0.122040816f,  /* 0x3df9f089 */
       0.117459394f,  /* 0x3df08e8d */
       0.112461478f,  /* 0x3de65234 */
       0.107047066f,  /* 0x3ddb3b7e */
        0.10121616f,  /* 0x3dcf4a6b */
       0.094968766f,  /* 0x3dc27efc */
      0.0883048698f,  /* 0x3db4d92f */
      0.0812244862f,  /* 0x3da65906 */
      0.0737276152f,  /* 0x3d96fe81 */
      0.0658142418f,  /* 0x3d86c99e */
      0.0574843809f,  /* 0x3d6b74be */
      0.0487380251f,  /* 0x3d47a186 */
      0.0395751782f,  /* 0x3d221995 */
      0.0299958345f,  /* 0x3cf5b9d3 */
      0.0199999996f,  /* 0x3ca3d70a */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
};

SMOOTH_50_TABLE
static const float smooth_50_gain[SMOOTH_50_BANK_RULES] = {
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
     0.00150000001f,  /* 0x3ac49ba6 */
     0.00151020405f,  /* 0x3ac5f20a */
      0.0015204082f,  /* 0x3ac7486f */
     0.00153061224f,  /* 0x3ac89ed3 */
     0.00154081627f,  /* 0x3ac9f537 */
     0.00155102042f,  /* 0x3acb4b9c */
     0.00156122446f,  /* 0x3acca200 */
     0.00157142861f,  /* 0x3acdf865 */
     0.00158163265f,  /* 0x3acf4ec9 */
     0.00159183668f,  /* 0x3ad0a52d */
     0.00160204084f,  /* 0x3ad1fb92 */
     0.00161224487f,  /* 0x3ad351f6 */
     0.00162244902f,  /* 0x3ad4a85b */
     0.00163265306f,  /* 0x3ad5febf */
      0.0016428571f,  /* 0x3ad75523 */
     0.00165306125f,  /* 0x3ad8ab88 */
     0.00166326528f,  /* 0x3ada01ec */
     0.00167346944f,  /* 0x3adb5851 */
     0.00168367347f,  /* 0x3adcaeb5 */
     0.00169387751f,  /* 0x3ade0519 */
     0.00170408166f,  /* 0x3adf5b7e */
      0.0017142857f,  /* 0x3ae0b1e2 */
     0.00172448985f,  /* 0x3ae20847 */
     0.00173469388f,  /* 0x3ae35eab */
     0.00174489792f,  /* 0x3ae4b50f */
     0.00175510207f,  /* 0x3ae60b74 */
     0.00176530611f,  /* 0x3ae761d8 */
     0.00177551026f,  /* 0x3ae8b83d */
      0.0017857143f,  /* 0x3aea0ea1 */
     0.00179591833f,  /* 0x3aeb6505 */
     0.00180612248f,  /* 0x3aecbb6a */
     0.00181632652f,  /* 0x3aee11ce */
     0.00182653056f,  /* 0x3aef6832 */
     0.00183673471f,  /* 0x3af0be97 */
     0.00184693874f,  /* 0x3af214fb */
      0.0018571429f,  /* 0x3af36b60 */
     0.00186734693f,  /* 0x3af4c1c4 */
     0.00187755097f,  /* 0x3af61828 */
     0.00188775512f,  /* 0x3af76e8d */
     0.00189795916f,  /* 0x3af8c4f1 */
     0.00190816331f,  /* 0x3afa1b56 */
     0.00191836734f,  /* 0x3afb71ba */
     0.00192857138f,  /* 0x3afcc81e */
     0.00193877553f,  /* 0x3afe1e83 */
     0.00194897957f,  /* 0x3aff74e7 */
     0.00195918372f,  /* 0x3b0065a6 */
     0.00196938775f,  /* 0x3b0110d8 */
     0.00197959179f,  /* 0x3b01bc0a */
     0.00198979583f,  /* 0x3b02673c */
     0.00200000009f,  /* 0x3b03126f */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
};

#endif

#ifdef SMOOTH_50_SELFTEST_NUMBERS

/* Self-test: where each function starts, what it is given, and the bits that the float32 reference answers. */

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
