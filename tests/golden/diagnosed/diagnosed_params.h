/* diagnosed_params.h: the numbers of model `diagnosed`. All that changes when the same structure is identified again.
 *
 * Part 1 comes with diagnosed.h. diagnosed.c defines DIAGNOSED_NUMBERS for part 2, diagnosed_selftest.c
 * DIAGNOSED_SELFTEST_NUMBERS for part 3. Every float32 is written with 9 significant digits, which read back to the bits
 * in the comment behind it. */

#ifndef DIAGNOSED_PARAMS_H
#define DIAGNOSED_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define DIAGNOSED_NUMBERS_DIGEST "a26646523913c5453b9a150da174a9e2275697156587c600ea1a848e12040e0f"
#define DIAGNOSED_NUMBERS_WORD 0xa2664652u

/* Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value. */
#define DIAGNOSED_Y_MIN_UM              0.66079998f  /* 0x3f292a30 */
#define DIAGNOSED_Y_MAX_UM              3.73589993f  /* 0x406f18fc */
#define DIAGNOSED_Y_REST_UM             2.19834995f  /* 0x400cb1c4 */
#define DIAGNOSED_U_MIN_V                    -20.0f  /* 0xc1a00000 */
#define DIAGNOSED_U_MAX_V                    120.0f  /* 0x42f00000 */
#define DIAGNOSED_U_REST_V                     0.0f  /* 0x00000000 */
#define DIAGNOSED_U_STEP_MAX_V               280.0f  /* 0x438c0000 */
#define DIAGNOSED_REFERENCE_MIN_UM     -2.41429996f  /* 0xc01a83e4 */
#define DIAGNOSED_REFERENCE_MAX_UM      6.81099987f  /* 0x40d9f3b6 */
#define DIAGNOSED_W_MIN               -0.709348381f  /* 0xbf3597db */
#define DIAGNOSED_W_MAX                 5.38315153f  /* 0x40ac42c7 */
#define DIAGNOSED_W_TOLERANCE       5.81026097e-06f  /* 0x36c2f5c3 */

/* Commit: check points. */
#define DIAGNOSED_COMMIT_POINTS  0x00000020u

/* Worst error of one step against the float64 model, measured when this file was generated
 * over 20000 samples of the whole range, rounded up.
 * PATH_ERROR: part of the path, of w, along random ramps from rest; INVERSE_ERROR_UM: of y(k+1) against the
 * reference where no limit acts. */
#define DIAGNOSED_PREDICT_ERROR_UM  1.09999996e-06f  /* 0x3593a3b6 */
#define DIAGNOSED_PATH_ERROR        7.09999995e-07f  /* 0x353e96d4 */
#define DIAGNOSED_INVERSE_ERROR_UM  5.30000023e-07f  /* 0x350e4553 */

#endif

#ifdef DIAGNOSED_NUMBERS

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/um]. */
#define DIAGNOSED_ORIGIN_UM  2.19834995f  /* 0x400cb1c4 */
#define DIAGNOSED_PER_STEP   2.34576941f  /* 0x40162116 */

DIAGNOSED_TABLE
static const float diagnosed_strength[DIAGNOSED_RULES] = {
      0.0439369343f,  /* 0x3d33f737 */
       0.324652463f,  /* 0x3ea638d9 */
       0.882496893f,  /* 0x3f61eb51 */
       0.882496893f,  /* 0x3f61eb51 */
       0.324652463f,  /* 0x3ea638d9 */
      0.0439369343f,  /* 0x3d33f737 */
};

DIAGNOSED_TABLE
static const float diagnosed_slope[DIAGNOSED_BANK_RULES] = {
      0.0417400859f,  /* 0x3d2af7a7 */
       0.309069157f,  /* 0x3e9e3e50 */
       0.841902018f,  /* 0x3f5786e4 */
        0.84366703f,  /* 0x3f57fa90 */
       0.311017066f,  /* 0x3e9f3da1 */
      0.0421794578f,  /* 0x3d2cc45e */
};

DIAGNOSED_TABLE
static const float diagnosed_offset[DIAGNOSED_BANK_RULES] = {
               0.0f,  /* 0x00000000 */
    0.000273185608f,  /* 0x398f3a5a */
    0.000802452152f,  /* 0x3a525ba7 */
    0.000124537968f,  /* 0x39029668 */
    -0.000245697796f,  /* 0xb980d100 */
    -4.21321929e-05f,  /* 0xb830b719 */
};

DIAGNOSED_TABLE
static const float diagnosed_gain[DIAGNOSED_BANK_RULES] = {
     0.00224078353f,  /* 0x3b12da1c */
       0.015751712f,  /* 0x3c8109bc */
      0.0402569883f,  /* 0x3d24e483 */
      0.0380610377f,  /* 0x3d1be5e4 */
      0.0134571502f,  /* 0x3c5c7b61 */
     0.00176744792f,  /* 0x3ae7a9b6 */
};

/* Input block `delay`: input delayed by 0.4 samples. */

DIAGNOSED_TABLE
static const float diagnosed_delay_part[1] = {
       0.400000006f,  /* 0x3ecccccd */
};

/* Input block `hysteresis`: 12 plays of degree 3, 2 Duhem states, curve of degree 3. */

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_range[6] = {
              50.0f,  /* 0x42480000 */
              70.0f,  /* 0x428c0000 */
      0.0142857144f,  /* 0x3c6a0ea1 */
        1.08666754f,  /* 0x3f8b17ec */
        2.11040545f,  /* 0x400710e2 */
       0.711975217f,  /* 0x3f364402 */
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_curve[104] = {
        2.13800001f,  /* 0x4008d4fe */
        1.16999996f,  /* 0x3f95c28f */
       0.100000001f,  /* 0x3dcccccd */
      0.0399999991f,  /* 0x3d23d70a */
        2.13669157f,  /* 0x4008bf8e */
         1.1983285f,  /* 0x3f9962d4 */
       0.101723678f,  /* 0x3dd05481 */
      0.0419999994f,  /* 0x3d2c0831 */
        2.13369608f,  /* 0x40088e7a */
         1.2264725f,  /* 0x3f9cfd0d */
       0.103088848f,  /* 0x3dd3203f */
      0.0439999998f,  /* 0x3d343958 */
        2.12883997f,  /* 0x40083eea */
        1.25446177f,  /* 0x3fa09234 */
       0.104056172f,  /* 0x3dd51b67 */
      0.0460000001f,  /* 0x3d3c6a7f */
        2.12200165f,  /* 0x4007cee0 */
        1.28234398f,  /* 0x3fa423d9 */
       0.104597725f,  /* 0x3dd63755 */
      0.0480000004f,  /* 0x3d449ba6 */
        2.11308479f,  /* 0x40073cc8 */
        1.31017876f,  /* 0x3fa7b3f0 */
       0.104691461f,  /* 0x3dd6687a */
      0.0500000007f,  /* 0x3d4ccccd */
        2.10200453f,  /* 0x4006873e */
        1.33803523f,  /* 0x3fab44bd */
       0.104318991f,  /* 0x3dd5a532 */
      0.0520000011f,  /* 0x3d54fdf4 */
        2.08868289f,  /* 0x4005acfb */
        1.36599028f,  /* 0x3faed8c5 */
        0.10346444f,  /* 0x3dd3e52a */
      0.0540000014f,  /* 0x3d5d2f1b */
        2.07304263f,  /* 0x4004acbb */
        1.39412761f,  /* 0x3fb272c6 */
       0.102113806f,  /* 0x3dd1210b */
      0.0560000017f,  /* 0x3d656042 */
        2.05500603f,  /* 0x40038538 */
        1.42253709f,  /* 0x3fb615b2 */
       0.100254491f,  /* 0x3dcd523a */
      0.0579999983f,  /* 0x3d6d9168 */
        2.03449154f,  /* 0x4002351c */
        1.45131409f,  /* 0x3fb9c4a9 */
      0.0978750437f,  /* 0x3dc872b6 */
      0.0599999987f,  /* 0x3d75c28f */
        2.01141191f,  /* 0x4000baf9 */
        1.48055887f,  /* 0x3fbd82f4 */
      0.0949649438f,  /* 0x3dc27cfb */
       0.061999999f,  /* 0x3d7df3b6 */
        1.98567319f,  /* 0x3ffe2a8a */
        1.51037657f,  /* 0x3fc15405 */
      0.0915144384f,  /* 0x3dbb6bec */
       0.064000003f,  /* 0x3d83126f */
       -2.13800001f,  /* 0xc008d4fe */
        1.16999996f,  /* 0x3f95c28f */
      -0.100000001f,  /* 0xbdcccccd */
      0.0399999991f,  /* 0x3d23d70a */
       -2.13931704f,  /* 0xc008ea92 */
        1.19869697f,  /* 0x3f996ee7 */
      -0.102276325f,  /* 0xbdd17640 */
      0.0419999994f,  /* 0x3d2c0831 */
       -2.14235711f,  /* 0xc0091c61 */
        1.22768736f,  /* 0x3f9d24dc */
      -0.104911149f,  /* 0xbdd6dba8 */
      0.0439999998f,  /* 0x3d343958 */
       -2.14733171f,  /* 0xc0096de2 */
        1.25705349f,  /* 0x3fa0e721 */
      -0.107943825f,  /* 0xbddd11a7 */
      0.0460000001f,  /* 0x3d3c6a7f */
       -2.15440631f,  /* 0xc009e1cb */
        1.28688037f,  /* 0x3fa4b87f */
      -0.111402281f,  /* 0xbde426e1 */
      0.0480000004f,  /* 0x3d449ba6 */
       -2.16372705f,  /* 0xc00a7a81 */
        1.31725681f,  /* 0x3fa89bdf */
      -0.115308546f,  /* 0xbdec26e3 */
      0.0500000007f,  /* 0x3d4ccccd */
       -2.17543268f,  /* 0xc00b3a4a */
        1.34827662f,  /* 0x3fac9454 */
      -0.119681016f,  /* 0xbdf51b52 */
      0.0520000011f,  /* 0x3d54fdf4 */
       -2.18965983f,  /* 0xc00c2363 */
        1.38003767f,  /* 0x3fb0a513 */
      -0.124535561f,  /* 0xbdff0c80 */
      0.0540000014f,  /* 0x3d5d2f1b */
        -2.2065475f,  /* 0xc00d3813 */
         1.4126426f,  /* 0x3fb4d179 */
      -0.129886195f,  /* 0xbe0500e3 */
      0.0560000017f,  /* 0x3d656042 */
       -2.22623873f,  /* 0xc00e7ab2 */
        1.44619787f,  /* 0x3fb91d03 */
       -0.13574551f,  /* 0xbe0b00df */
      0.0579999983f,  /* 0x3d6d9168 */
       -2.24888444f,  /* 0xc00fedb9 */
        1.48081398f,  /* 0x3fbd8b50 */
      -0.142124951f,  /* 0xbe118934 */
      0.0599999987f,  /* 0x3d75c28f */
       -2.27464294f,  /* 0xc01193c0 */
        1.51660562f,  /* 0x3fc22022 */
      -0.149035051f,  /* 0xbe189ca5 */
       0.061999999f,  /* 0x3d7df3b6 */
       -2.30368257f,  /* 0xc0136f89 */
        1.55369067f,  /* 0x3fc6df56 */
      -0.156485558f,  /* 0xbe203dc0 */
       0.064000003f,  /* 0x3d83126f */
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_play[48] = {
      0.0460540652f,  /* 0x3d3ca330 */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.105804458f,  /* 0x3dd8b002 */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.172112927f,  /* 0x3e303e5f */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.243074819f,  /* 0x3e78e89b */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.317710817f,  /* 0x3ea2aafe */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
        0.39541167f,  /* 0x3eca7366 */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
        0.47575748f,  /* 0x3ef3967c */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.558439255f,  /* 0x3f0ef5e0 */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.643219173f,  /* 0x3f24aa03 */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.729907751f,  /* 0x3f3adb3c */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.818350196f,  /* 0x3f517f66 */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
       0.908417463f,  /* 0x3f688e0c */
            0.0285f,  /* 0x3ce978d5 */
     0.00200000009f,  /* 0x3b03126f */
     0.00200000009f,  /* 0x3b03126f */
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_rate[1] = {
       -1.80336881f,  /* 0xbfe6d4ca */
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_duhem[6] = {
      0.0299999993f,  /* 0x3cf5c28f */
     0.00999999978f,  /* 0x3c23d70a */
              1.25f,  /* 0x3fa00000 */
      0.0199999996f,  /* 0x3ca3d70a */
    9.09494702e-13f,  /* 0x2b800000 */
               2.5f,  /* 0x40200000 */
};

/* Input block `creep`: creep by 0.01 per state, 4 states of 0.001 .. 1 s. */

DIAGNOSED_TABLE
static const float diagnosed_creep_rate[4] = {
      0.0198013261f,  /* 0x3ca23664 */
     0.00199800124f,  /* 0x3b02f0e6 */
    0.000199980001f,  /* 0x3951b1b9 */
    1.99997994e-05f,  /* 0x37a7c53e */
};

DIAGNOSED_TABLE
static const float diagnosed_creep_amount[1] = {
     0.00999999978f,  /* 0x3c23d70a */
};

/* Input block `modes`: modes at 730 Hz (damping 0.05, share 0.3). */

DIAGNOSED_TABLE
static const float diagnosed_modes_real[1] = {
     0.00875118468f,  /* 0x3c0f6121 */
};

DIAGNOSED_TABLE
static const float diagnosed_modes_imag[1] = {
      0.0910729542f,  /* 0x3dba8475 */
};

DIAGNOSED_TABLE
static const float diagnosed_modes_of_position[1] = {
        0.29957512f,  /* 0x3e9961e9 */
};

DIAGNOSED_TABLE
static const float diagnosed_modes_of_velocity[1] = {
    -0.00115762639f,  /* 0xba97bb7f */
};

DIAGNOSED_TABLE
static const float diagnosed_modes_direct[1] = {
        0.70042485f,  /* 0x3f334f0b */
};

DIAGNOSED_TABLE
static const float diagnosed_modes_per_direct[1] = {
        1.42770481f,  /* 0x3fb6bf08 */
};

/* Learner: plausible displacements, rest, levels of the innovation and how fast they follow. */
#define DIAGNOSED_LEARN_Y_LOW_UM         -2.41429996f  /* 0xc01a83e4 */
#define DIAGNOSED_LEARN_Y_HIGH_UM         6.81099987f  /* 0x40d9f3b6 */
#define DIAGNOSED_LEARN_REST_V         0.00854492188f  /* 0x3c0c0000 */
#define DIAGNOSED_LEARN_FLOOR_UM       6.2500003e-05f  /* 0x3883126f */
#define DIAGNOSED_LEARN_FLOOR_SQUARE  3.90625043e-09f  /* 0x318637be */
#define DIAGNOSED_LEARN_LEVEL_UM          3.07509995f  /* 0x4044ce70 */
#define DIAGNOSED_LEARN_FAST              0.00390625f  /* 0x3b800000 */
#define DIAGNOSED_LEARN_SLOW          0.000244140625f  /* 0x39800000 */

/* Learner: outlier gate, dead zone, restart (ratios of mean squares), limits, updates, forgetting
 * 1/lambda. */
#define DIAGNOSED_LEARN_GATE                            8.0f  /* 0x41000000 */
#define DIAGNOSED_LEARN_GATE_FLOOR_UM         0.00300000003f  /* 0x3b449ba6 */
#define DIAGNOSED_LEARN_DEAD_ZONE_UM         0.000250000012f  /* 0x3983126f */
#define DIAGNOSED_LEARN_WORSE                    1.22988105f  /* 0x3f9d6cbe */
#define DIAGNOSED_LEARN_LOST                            4.0f  /* 0x40800000 */
#define DIAGNOSED_LEARN_STEP_UM                 0.768774986f  /* 0x3f44ce70 */
#define DIAGNOSED_LEARN_LIMIT_UM                 787.225586f  /* 0x4444ce70 */
#define DIAGNOSED_LEARN_LEAST_VARIANCE       9.09494702e-13f  /* 0x2b800000 */
#define DIAGNOSED_LEARN_LARGEST_DENOMINATOR      952.485413f  /* 0x446e1f11 */
#define DIAGNOSED_LEARN_OUTLIER_RUN              0x00000008u
#define DIAGNOSED_LEARN_SETTLING                 0x00001000u
#define DIAGNOSED_LEARN_SETTLED                  0x00002000u
#define DIAGNOSED_LEARN_REFRESH_EVERY            0x00000008u
#define DIAGNOSED_LEARN_WINDOW                   0x00020000u
#define DIAGNOSED_LEARN_INFLATE_FIRST              1.001001f  /* 0x3f8020cd */
#define DIAGNOSED_LEARN_INFLATE                    1.001001f  /* 0x3f8020cd */
#define DIAGNOSED_LEARN_PER_Y                          0.25f  /* 0x3e800000 */
#define DIAGNOSED_LEARN_PER_U                          0.25f  /* 0x3e800000 */

/* Learner, per parameter: theta per number in the bank, and back; D(0) and largest D; what puts the prior
 * back; powers of two that scale the regressors. */

DIAGNOSED_TABLE
static const float diagnosed_learn_scale[DIAGNOSED_LEARNED] = {
             128.0f,  /* 0x43000000 */
             128.0f,  /* 0x43000000 */
              32.0f,  /* 0x42000000 */
              16.0f,  /* 0x41800000 */
              16.0f,  /* 0x41800000 */
               4.0f,  /* 0x40800000 */
               4.0f,  /* 0x40800000 */
               4.0f,  /* 0x40800000 */
               1.0f,  /* 0x3f800000 */
               4.0f,  /* 0x40800000 */
               4.0f,  /* 0x40800000 */
               1.0f,  /* 0x3f800000 */
              16.0f,  /* 0x41800000 */
              16.0f,  /* 0x41800000 */
               4.0f,  /* 0x40800000 */
             128.0f,  /* 0x43000000 */
             128.0f,  /* 0x43000000 */
              32.0f,  /* 0x42000000 */
};

DIAGNOSED_TABLE
static const float diagnosed_learn_per_scale[DIAGNOSED_LEARNED] = {
         0.0078125f,  /* 0x3c000000 */
         0.0078125f,  /* 0x3c000000 */
           0.03125f,  /* 0x3d000000 */
            0.0625f,  /* 0x3d800000 */
            0.0625f,  /* 0x3d800000 */
              0.25f,  /* 0x3e800000 */
              0.25f,  /* 0x3e800000 */
              0.25f,  /* 0x3e800000 */
               1.0f,  /* 0x3f800000 */
              0.25f,  /* 0x3e800000 */
              0.25f,  /* 0x3e800000 */
               1.0f,  /* 0x3f800000 */
            0.0625f,  /* 0x3d800000 */
            0.0625f,  /* 0x3d800000 */
              0.25f,  /* 0x3e800000 */
         0.0078125f,  /* 0x3c000000 */
         0.0078125f,  /* 0x3c000000 */
           0.03125f,  /* 0x3d000000 */
};

DIAGNOSED_TABLE
static const float diagnosed_learn_prior[DIAGNOSED_LEARNED] = {
      0.0316285603f,  /* 0x3d018cf3 */
      0.0316285603f,  /* 0x3d018cf3 */
     0.00197678502f,  /* 0x3b018cf3 */
      0.0269822013f,  /* 0x3cdd09c7 */
      0.0269822013f,  /* 0x3cdd09c7 */
     0.00168638758f,  /* 0x3add09c7 */
       0.012460812f,  /* 0x3c4c286f */
       0.012460812f,  /* 0x3c4c286f */
     0.00077880075f,  /* 0x3a4c286f */
       0.012460812f,  /* 0x3c4c286f */
       0.012460812f,  /* 0x3c4c286f */
     0.00077880075f,  /* 0x3a4c286f */
      0.0269822013f,  /* 0x3cdd09c7 */
      0.0269822013f,  /* 0x3cdd09c7 */
     0.00168638758f,  /* 0x3add09c7 */
      0.0316285603f,  /* 0x3d018cf3 */
      0.0316285603f,  /* 0x3d018cf3 */
     0.00197678502f,  /* 0x3b018cf3 */
};

DIAGNOSED_TABLE
static const float diagnosed_learn_ceiling[DIAGNOSED_LEARNED] = {
      0.0717559531f,  /* 0x3d92f4c9 */
      0.0717559531f,  /* 0x3d92f4c9 */
     0.00448474707f,  /* 0x3b92f4c9 */
       0.061214719f,  /* 0x3d7abc49 */
       0.061214719f,  /* 0x3d7abc49 */
     0.00382591994f,  /* 0x3b7abc49 */
      0.0282699373f,  /* 0x3ce7965b */
      0.0282699373f,  /* 0x3ce7965b */
     0.00176687108f,  /* 0x3ae7965b */
      0.0282699373f,  /* 0x3ce7965b */
      0.0282699373f,  /* 0x3ce7965b */
     0.00176687108f,  /* 0x3ae7965b */
       0.061214719f,  /* 0x3d7abc49 */
       0.061214719f,  /* 0x3d7abc49 */
     0.00382591994f,  /* 0x3b7abc49 */
      0.0717559531f,  /* 0x3d92f4c9 */
      0.0717559531f,  /* 0x3d92f4c9 */
     0.00448474707f,  /* 0x3b92f4c9 */
};

DIAGNOSED_TABLE
static const float diagnosed_learn_refresh[DIAGNOSED_LEARNED] = {
        1.93513298f,  /* 0x3ff7b270 */
        1.93513298f,  /* 0x3ff7b270 */
        7.74053192f,  /* 0x40f7b270 */
        2.09513426f,  /* 0x400616ae */
        2.09513426f,  /* 0x400616ae */
        8.38053703f,  /* 0x410616ae */
        3.08302712f,  /* 0x40455051 */
        3.08302712f,  /* 0x40455051 */
        12.3321085f,  /* 0x41455051 */
        3.08302712f,  /* 0x40455051 */
        3.08302712f,  /* 0x40455051 */
        12.3321085f,  /* 0x41455051 */
        2.09513426f,  /* 0x400616ae */
        2.09513426f,  /* 0x400616ae */
        8.38053703f,  /* 0x410616ae */
        1.93513298f,  /* 0x3ff7b270 */
        1.93513298f,  /* 0x3ff7b270 */
        7.74053192f,  /* 0x40f7b270 */
};

DIAGNOSED_TABLE
static const float diagnosed_learn_firing[DIAGNOSED_RULES] = {
           0.03125f,  /* 0x3d000000 */
              0.25f,  /* 0x3e800000 */
               1.0f,  /* 0x3f800000 */
               1.0f,  /* 0x3f800000 */
              0.25f,  /* 0x3e800000 */
           0.03125f,  /* 0x3d000000 */
};

/* Commit: half the distance h of the check points; what Taylor's theorem leaves, h^2/2 times bounds of the
 * memberships' second and third derivatives; limits of |b(y)| [um/V] and |df/dy|; rows of p_l, p_l', p_l''
 * over the strengths w_l at each check point. */
#define DIAGNOSED_COMMIT_MATURE                0x00000400u
#define DIAGNOSED_COMMIT_HALF_UM             0.0485289209f  /* 0x3d46c643 */
#define DIAGNOSED_COMMIT_GAIN_REMAINDER     0.00320476922f  /* 0x3b52071b */
#define DIAGNOSED_COMMIT_SLOPE_REMAINDER_1  0.00961430743f  /* 0x3c1d8554 */
#define DIAGNOSED_COMMIT_SLOPE_REMAINDER_3  0.00762989838f  /* 0x3bfa043a */
#define DIAGNOSED_COMMIT_SIGN                         1.0f  /* 0x3f800000 */
#define DIAGNOSED_COMMIT_GAIN_FLOOR          0.0204550549f  /* 0x3ca7915c */
#define DIAGNOSED_COMMIT_GAIN_CEILING         0.198697671f  /* 0x3e4b7767 */
#define DIAGNOSED_COMMIT_SLOPE_LIMIT          0.995746553f  /* 0x3f7ee93f */

DIAGNOSED_TABLE
static const float diagnosed_commit_unfold[DIAGNOSED_RULES] = {
        22.7598953f,  /* 0x41b61444 */
        3.08021688f,  /* 0x40452246 */
        1.13314843f,  /* 0x3f910b02 */
        1.13314843f,  /* 0x3f910b02 */
        3.08021688f,  /* 0x40452246 */
        22.7598953f,  /* 0x41b61444 */
};

DIAGNOSED_TABLE
static const float diagnosed_commit_y[32] = {
       0.708848417f,  /* 0x3f357717 */
        0.80494529f,  /* 0x3f4e10e5 */
       0.901042163f,  /* 0x3f66aab3 */
       0.997139037f,  /* 0x3f7f4481 */
        1.09323597f,  /* 0x3f8bef28 */
        1.18933284f,  /* 0x3f983c0f */
        1.28542972f,  /* 0x3fa488f6 */
        1.38152659f,  /* 0x3fb0d5dd */
        1.47762346f,  /* 0x3fbd22c4 */
        1.57372034f,  /* 0x3fc96fab */
        1.66981721f,  /* 0x3fd5bc92 */
        1.76591408f,  /* 0x3fe20979 */
        1.86201096f,  /* 0x3fee5660 */
        1.95810783f,  /* 0x3ffaa347 */
         2.0542047f,  /* 0x40037817 */
        2.15030146f,  /* 0x40099e8a */
        2.24639845f,  /* 0x400fc4fe */
         2.3424952f,  /* 0x4015eb71 */
         2.4385922f,  /* 0x401c11e5 */
        2.53468895f,  /* 0x40223858 */
        2.63078594f,  /* 0x40285ecc */
         2.7268827f,  /* 0x402e853f */
        2.82297969f,  /* 0x4034abb3 */
        2.91907668f,  /* 0x403ad227 */
        3.01517344f,  /* 0x4040f89a */
        3.11127043f,  /* 0x40471f0e */
        3.20736718f,  /* 0x404d4581 */
        3.30346417f,  /* 0x40536bf5 */
        3.39956093f,  /* 0x40599268 */
        3.49565792f,  /* 0x405fb8dc */
        3.59175467f,  /* 0x4065df4f */
        3.68785167f,  /* 0x406c05c3 */
};

DIAGNOSED_TABLE
static const float diagnosed_commit_table[576] = {
          12.44699f,  /* 0x414726df */
        1.10473323f,  /* 0x3f8d67e6 */
      0.0980506465f,  /* 0x3dc8cec7 */
     0.00870248955f,  /* 0x3c0e94e3 */
    0.000772389816f,  /* 0x3a4a7a34 */
    6.85534906e-05f,  /* 0x388fc460 */
       -11.2478876f,  /* 0xc133f759 */
       0.797948897f,  /* 0x3f4c4661 */
       0.230248749f,  /* 0x3e6bc654 */
      0.0345856659f,  /* 0x3d0da9b3 */
     0.00432553003f,  /* 0x3b8dbd2d */
    0.000495378103f,  /* 0x3a01dc43 */
       -5.27219343f,  /* 0xc0a8b5cf */
      -0.793708384f,  /* 0xbf4b3079 */
        0.41908437f,  /* 0x3ed6923a */
       0.126658648f,  /* 0x3e01b2ce */
      0.0232658889f,  /* 0x3cbe981b */
     0.00349465944f,  /* 0x3b6506a8 */
        11.3442059f,  /* 0x413581de */
        1.17713344f,  /* 0x3f96ac4f */
       0.122145437f,  /* 0x3dfa2763 */
      0.0126744406f,  /* 0x3c4fa875 */
     0.00131516543f,  /* 0x3aac61a1 */
    0.000136468341f,  /* 0x390f18f1 */
       -11.6765633f,  /* 0xc13ad334 */
       0.702355385f,  /* 0x3f33cd90 */
       0.271484017f,  /* 0x3e8afff4 */
      0.0487787612f,  /* 0x3d47cc3d */
     0.00719994679f,  /* 0x3bebed88 */
    0.000968996144f,  /* 0x3a7e043b */
       -3.58406544f,  /* 0xc0656154 */
       -1.19994748f,  /* 0xbf9997e1 */
       0.435410589f,  /* 0x3edeee23 */
       0.170297265f,  /* 0x3e2e6268 */
      0.0376076438f,  /* 0x3d1a0a79 */
     0.00669267867f,  /* 0x3bdb4e42 */
        10.2086086f,  /* 0x41235676 */
        1.23844481f,  /* 0x3f9e855c */
       0.150240391f,  /* 0x3e19d89e */
      0.0182262287f,  /* 0x3c954f2c */
     0.00221109227f,  /* 0x3b10e7f9 */
    0.000268235919f,  /* 0x398ca204 */
       -11.9249525f,  /* 0xc13ecc9b */
       0.567004919f,  /* 0x3f11273c */
       0.313070893f,  /* 0x3ea04ad4 */
      0.0676149875f,  /* 0x3d8a79ba */
      0.0117977839f,  /* 0x3c414b7e */
     0.00186737522f,  /* 0x3af4c2b7 */
       -1.53009605f,  /* 0xbfc3da30 */
       -1.61591017f,  /* 0xbfced625 */
       0.424852341f,  /* 0x3ed9863f */
         0.2232337f,  /* 0x3e649760 */
      0.0596012585f,  /* 0x3d742073 */
      0.0125938701f,  /* 0x3c4e5685 */
         9.0590992f,  /* 0x4110f212 */
        1.28485358f,  /* 0x3fa47615 */
       0.182230979f,  /* 0x3e3a9ac2 */
      0.0258458499f,  /* 0x3cd3baad */
     0.00366572081f,  /* 0x3b703c97 */
     0.00051990978f,  /* 0x3a084a8e */
       -11.9615793f,  /* 0xc13f62a1 */
       0.392612129f,  /* 0x3ec90475 */
       0.351985127f,  /* 0x3eb43765 */
      0.0919465125f,  /* 0x3dbc4e74 */
       0.019001117f,  /* 0x3c9ba83b */
     0.00354028563f,  /* 0x3b680423 */
       0.805069864f,  /* 0x3f4e190f */
       -2.00591135f,  /* 0xc00060da */
       0.378356755f,  /* 0x3ec1b7fa */
       0.284335583f,  /* 0x3e91946f */
      0.0924263224f,  /* 0x3dbd4a03 */
      0.0232470743f,  /* 0x3cbe70a6 */
        7.91714096f,  /* 0x40fd5938 */
        1.31279075f,  /* 0x3fa80987 */
       0.217682034f,  /* 0x3e5ee80a */
      0.0360952206f,  /* 0x3d13d895 */
     0.00598517433f,  /* 0x3bc41f48 */
    0.000992439222f,  /* 0x3a8214bc */
       -11.7653952f,  /* 0xc13c3f0f */
       0.183655843f,  /* 0x3e3c1047 */
       0.384396136f,  /* 0x3ec4cf92 */
       0.122428641f,  /* 0x3dfabbde */
       0.030032333f,  /* 0x3cf6065e */
     0.00659351842f,  /* 0x3bd80e71 */
        3.28965139f,  /* 0x405289a6 */
       -2.32798648f,  /* 0xc014fdbb */
       0.288511723f,  /* 0x3e93b7cf */
       0.350541919f,  /* 0x3eb37a3b */
       0.139965147f,  /* 0x3e0f5306 */
       0.042026367f,  /* 0x3d2c23d7 */
        6.80554628f,  /* 0x40d9c709 */
        1.31931543f,  /* 0x3fa8df54 */
       0.255760968f,  /* 0x3e82f31a */
       0.049581524f,  /* 0x3d4b15ff */
     0.00961181708f,  /* 0x3c1d7ae2 */
     0.00186333561f,  /* 0x3af43b2b */
       -11.3299637f,  /* 0xc1354788 */
     -0.0512552559f,  /* 0xbd51f108 */
       0.405921668f,  /* 0x3ecfd4f7 */
       0.159309238f,  /* 0x3e2321f6 */
      0.0465119667f,  /* 0x3d3e8355 */
      0.0120464712f,  /* 0x3c455e90 */
         5.7537117f,  /* 0x40b81e68 */
       -2.53921962f,  /* 0xc0228293 */
       0.151607558f,  /* 0x3e1b3f03 */
       0.416370958f,  /* 0x3ed52e93 */
       0.206559405f,  /* 0x3e53844f */
      0.0742914006f,  /* 0x3d982617 */
        5.74692345f,  /* 0x40b7e6cc */
        1.30250549f,  /* 0x3fa6b880 */
       0.295204967f,  /* 0x3e97251b */
      0.0669064224f,  /* 0x3d89063c */
      0.0151639357f,  /* 0x3c787228 */
      0.0034368143f,  /* 0x3b613c2d */
        -10.666296f,  /* 0xc12aa926 */
      -0.299625248f,  /* 0xbe99687b */
       0.412084222f,  /* 0x3ed2fcb4 */
       0.202183798f,  /* 0x3e4f0945 */
      0.0704797357f,  /* 0x3d9057ae */
      0.0215619393f,  /* 0x3cb0a2aa */
         8.0079565f,  /* 0x41002097 */
       -2.60291219f,  /* 0xc026961d */
     -0.0303167608f,  /* 0xbcf85adb */
       0.473731458f,  /* 0x3ef28cee */
       0.296473563f,  /* 0x3e97cb62 */
       0.128225684f,  /* 0x3e034d98 */
        4.76194763f,  /* 0x409861e0 */
        1.26179051f,  /* 0x3fa1825a */
       0.334341198f,  /* 0x3eab2ec5 */
       0.088591598f,  /* 0x3db56f83 */
      0.0234744381f,  /* 0x3cc04d77 */
      0.0062201065f,  /* 0x3bcbd209 */
       -9.80348301f,  /* 0xc11cdb11 */
      -0.546039224f,  /* 0xbf0bc93a */
       0.398940563f,  /* 0x3ecc41f0 */
       0.249755427f,  /* 0x3e7fbfe3 */
       0.104347177f,  /* 0x3dd5b3f9 */
      0.0377629139f,  /* 0x3d1aad49 */
        9.87012386f,  /* 0x411dec07 */
       -2.49622464f,  /* 0xc01fc225 */
      -0.248025015f,  /* 0xbe7dfa45 */
       0.512251616f,  /* 0x3f0322ec */
       0.413001835f,  /* 0x3ed374fa */
       0.215792373f,  /* 0x3e5cf8ad */
        3.86770177f,  /* 0x4077886d */
        1.19815814f,  /* 0x3f995d3f */
       0.371172071f,  /* 0x3ebe0a44 */
       0.114983745f,  /* 0x3deb7c99 */
       0.035620302f,  /* 0x3d11e698 */
      0.0110346545f,  /* 0x3c34cab2 */
       -8.78663445f,  /* 0xc10c960e */
      -0.773811221f,  /* 0xbf46187e */
       0.363796651f,  /* 0x3eba438e */
       0.299658298f,  /* 0x3e996cd0 */
        0.15074712f,  /* 0x3e1a5d74 */
      0.0646412224f,  /* 0x3d84629e */
        11.1937904f,  /* 0x413319c4 */
       -2.21634173f,  /* 0xc00dd88b */
       -0.48483932f,  /* 0xbef83cdc */
       0.520281613f,  /* 0x3f05312d */
       0.557222903f,  /* 0x3f0ea629 */
       0.353655159f,  /* 0x3eb5124a */
        3.07634258f,  /* 0x4044e2cc */
        1.11417747f,  /* 0x3f8e9d5e */
       0.403528333f,  /* 0x3ece9b44 */
       0.146148279f,  /* 0x3e15a7e5 */
      0.0529313982f,  /* 0x3d58ce98 */
      0.0191704817f,  /* 0x3c9d0b6a */
        -7.6722002f,  /* 0xc0f582aa */
      -0.967075169f,  /* 0xbf77923d */
       0.305870861f,  /* 0x3e9c9b1b */
       0.348410845f,  /* 0x3eb262e8 */
       0.212250561f,  /* 0x3e595836 */
       0.108042553f,  /* 0x3ddd456a */
         11.892663f,  /* 0x413e4859 */
        -1.7832346f,  /* 0xbfe44108 */
      -0.718005896f,  /* 0xbf37cf3c */
       0.486581504f,  /* 0x3ef92136 */
       0.726513624f,  /* 0x3f39fccc */
       0.563790202f,  /* 0x3f10548e */
        2.39431381f,  /* 0x40193c70 */
        1.01381624f,  /* 0x3f81c4bb */
       0.429276824f,  /* 0x3edbca2c */
        0.18176724f,  /* 0x3e3a2131 */
      0.0769650936f,  /* 0x3d9d9fe0 */
      0.0325890705f,  /* 0x3d057c1e */
       -6.52144241f,  /* 0xc0d0afa8 */
       -1.11292446f,  /* 0xbf8e744f */
         0.2267465f,  /* 0x3e68303c */
       0.391557395f,  /* 0x3ec87a36 */
       0.290938258f,  /* 0x3e94f5dc */
       0.176179633f,  /* 0x3e34686f */
        11.9539156f,  /* 0x413f433d */
       -1.23782623f,  /* 0xbf9e7117 */
      -0.921669126f,  /* 0xbf6bf282 */
       0.402508289f,  /* 0x3ece1591 */
       0.913065612f,  /* 0x3f69beab */
       0.873381972f,  /* 0x3f5f95f6 */
         1.8222276f,  /* 0x3fe93ec1 */
       0.902068138f,  /* 0x3f66edf0 */
       0.446556091f,  /* 0x3ee4a300 */
       0.221061304f,  /* 0x3e625de5 */
       0.109433278f,  /* 0x3de01e8e */
      0.0541733988f,  /* 0x3d5de4ed */
       -5.39331388f,  /* 0xc0ac9607 */
       -1.20315444f,  /* 0xbf9a00f7 */
       0.130479231f,  /* 0x3e059c59 */
       0.424029469f,  /* 0x3ed91a64 */
       0.387844324f,  /* 0x3ec69388 */
       0.280080825f,  /* 0x3e8f66c1 */
         11.437027f,  /* 0x4136fe10 */
      -0.635679722f,  /* 0xbf22bbe8 */
       -1.07096112f,  /* 0xbf891541 */
       0.264316291f,  /* 0x3e875477 */
        1.10277236f,  /* 0x3f8d27a5 */
        1.31349289f,  /* 0x3fa82089 */
        1.35540164f,  /* 0x3fad7dcd */
       0.784446359f,  /* 0x3f48d17a */
       0.454002708f,  /* 0x3ee8730b */
       0.262756616f,  /* 0x3e868809 */
       0.152071863f,  /* 0x3e1bb8ba */
      0.0880124345f,  /* 0x3db43fdd */
       -4.33812952f,  /* 0xc08ad1f5 */
       -1.23523581f,  /* 0xbf9e1c35 */
      0.0232921187f,  /* 0x3cbecf1d */
       0.440713078f,  /* 0x3ee1a525 */
       0.502328455f,  /* 0x3f009899 */
        0.43383038f,  /* 0x3ede1f04 */
        10.4588432f,  /* 0x4127576c */
      -0.037667539f,  /* 0xbd1a4947 */
       -1.14632881f,  /* 0xbf92bae7 */
      0.0750577897f,  /* 0x3d99b7e6 */
        1.27493441f,  /* 0x3fa3310d */
        1.91597652f,  /* 0x3ff53eb8 */
       0.984919369f,  /* 0x3f7c23ad */
       0.666429818f,  /* 0x3f2a9b25 */
       0.450928956f,  /* 0x3ee6e029 */
       0.305113792f,  /* 0x3e9c37e0 */
       0.206450313f,  /* 0x3e5367b6 */
       0.139691263f,  /* 0x3e0f0b3a */
       -3.39316463f,  /* 0xc059299c */
       -1.21233964f,  /* 0xbf9b2df2 */
     -0.0871160924f,  /* 0xbdb269ec */
       0.437158167f,  /* 0x3edfd332 */
       0.631476641f,  /* 0x3f21a874 */
       0.654411376f,  /* 0x3f278781 */
        9.16945839f,  /* 0x4112b61a */
       0.500048041f,  /* 0x3f000326 */
       -1.13709223f,  /* 0xbf918c3d */
      -0.154435501f,  /* 0xbe1e2457 */
        1.40321517f,  /* 0x3fb39c8e */
          2.708251f,  /* 0x402d53fc */
       0.698995173f,  /* 0x3f32f159 */
        0.55295068f,  /* 0x3f0d8e2d */
       0.437420011f,  /* 0x3edff584 */
       0.346027702f,  /* 0x3eb12a8b */
       0.273730457f,  /* 0x3e8c2666 */
       0.216538608f,  /* 0x3e5dbc4c */
       -2.58074808f,  /* 0xc0252afa */
       -1.14246225f,  /* 0xbf923c34 */
      -0.192533091f,  /* 0xbe452765 */
        0.41032216f,  /* 0x3ed215bf */
       0.769667268f,  /* 0x3f4508ea */
       0.960940719f,  /* 0x3f760036 */
        7.72555208f,  /* 0x40f737b9 */
       0.934344232f,  /* 0x3f6f312f */
       -1.04340863f,  /* 0xbf858e6a */
      -0.405879617f,  /* 0xbecfcf74 */
        1.45814753f,  /* 0x3fbaa494 */
        3.70592308f,  /* 0x406d2dd8 */
       0.484403759f,  /* 0x3ef803c5 */
       0.448000252f,  /* 0x3ee5604a */
       0.414332509f,  /* 0x3ed42364 */
       0.383194923f,  /* 0x3ec43220 */
       0.354397357f,  /* 0x3eb57392 */
       0.327763975f,  /* 0x3ea7d0ae */
       -1.90878201f,  /* 0xbff452f8 */
       -1.03690279f,  /* 0xbf84b93b */
      -0.285288841f,  /* 0xbe921161 */
       0.359211862f,  /* 0x3eb7ea9e */
       0.908453822f,  /* 0x3f68906e */
        1.37311459f,  /* 0x3fafc238 */
        6.26744032f,  /* 0x40c88edf */
        1.24009943f,  /* 0x3f9ebb94 */
      -0.876228333f,  /* 0xbf605080 */
      -0.655322254f,  /* 0xbf27c333 */
        1.41121078f,  /* 0x3fb4a28e */
        4.90389633f,  /* 0x409cecb8 */
       0.327763975f,  /* 0x3ea7d0ae */
       0.354397357f,  /* 0x3eb57392 */
       0.383194923f,  /* 0x3ec43220 */
       0.414332509f,  /* 0x3ed42364 */
       0.448000252f,  /* 0x3ee5604a */
       0.484403759f,  /* 0x3ef803c5 */
       -1.37311459f,  /* 0xbfafc238 */
      -0.908453822f,  /* 0xbf68906e */
      -0.359211862f,  /* 0xbeb7ea9e */
       0.285288841f,  /* 0x3e921161 */
        1.03690279f,  /* 0x3f84b93b */
        1.90878201f,  /* 0x3ff452f8 */
        4.90389633f,  /* 0x409cecb8 */
        1.41121078f,  /* 0x3fb4a28e */
      -0.655322254f,  /* 0xbf27c333 */
      -0.876228333f,  /* 0xbf605080 */
        1.24009943f,  /* 0x3f9ebb94 */
        6.26744032f,  /* 0x40c88edf */
       0.216538608f,  /* 0x3e5dbc4c */
       0.273730457f,  /* 0x3e8c2666 */
       0.346027702f,  /* 0x3eb12a8b */
       0.437420011f,  /* 0x3edff584 */
        0.55295068f,  /* 0x3f0d8e2d */
       0.698995173f,  /* 0x3f32f159 */
      -0.960940719f,  /* 0xbf760036 */
      -0.769667268f,  /* 0xbf4508ea */
       -0.41032216f,  /* 0xbed215bf */
       0.192533091f,  /* 0x3e452765 */
        1.14246225f,  /* 0x3f923c34 */
        2.58074808f,  /* 0x40252afa */
        3.70592308f,  /* 0x406d2dd8 */
        1.45814753f,  /* 0x3fbaa494 */
      -0.405879617f,  /* 0xbecfcf74 */
       -1.04340863f,  /* 0xbf858e6a */
       0.934344232f,  /* 0x3f6f312f */
        7.72555208f,  /* 0x40f737b9 */
       0.139691263f,  /* 0x3e0f0b3a */
       0.206450313f,  /* 0x3e5367b6 */
       0.305113792f,  /* 0x3e9c37e0 */
       0.450928956f,  /* 0x3ee6e029 */
       0.666429818f,  /* 0x3f2a9b25 */
       0.984919369f,  /* 0x3f7c23ad */
      -0.654411376f,  /* 0xbf278781 */
      -0.631476641f,  /* 0xbf21a874 */
      -0.437158167f,  /* 0xbedfd332 */
      0.0871160924f,  /* 0x3db269ec */
        1.21233964f,  /* 0x3f9b2df2 */
        3.39316463f,  /* 0x4059299c */
          2.708251f,  /* 0x402d53fc */
        1.40321517f,  /* 0x3fb39c8e */
      -0.154435501f,  /* 0xbe1e2457 */
       -1.13709223f,  /* 0xbf918c3d */
       0.500048041f,  /* 0x3f000326 */
        9.16945839f,  /* 0x4112b61a */
      0.0880124345f,  /* 0x3db43fdd */
       0.152071863f,  /* 0x3e1bb8ba */
       0.262756616f,  /* 0x3e868809 */
       0.454002708f,  /* 0x3ee8730b */
       0.784446359f,  /* 0x3f48d17a */
        1.35540164f,  /* 0x3fad7dcd */
       -0.43383038f,  /* 0xbede1f04 */
      -0.502328455f,  /* 0xbf009899 */
      -0.440713078f,  /* 0xbee1a525 */
     -0.0232921187f,  /* 0xbcbecf1d */
        1.23523581f,  /* 0x3f9e1c35 */
        4.33812952f,  /* 0x408ad1f5 */
        1.91597652f,  /* 0x3ff53eb8 */
        1.27493441f,  /* 0x3fa3310d */
      0.0750577897f,  /* 0x3d99b7e6 */
       -1.14632881f,  /* 0xbf92bae7 */
      -0.037667539f,  /* 0xbd1a4947 */
        10.4588432f,  /* 0x4127576c */
      0.0541733988f,  /* 0x3d5de4ed */
       0.109433278f,  /* 0x3de01e8e */
       0.221061304f,  /* 0x3e625de5 */
       0.446556091f,  /* 0x3ee4a300 */
       0.902068138f,  /* 0x3f66edf0 */
         1.8222276f,  /* 0x3fe93ec1 */
      -0.280080825f,  /* 0xbe8f66c1 */
      -0.387844324f,  /* 0xbec69388 */
      -0.424029469f,  /* 0xbed91a64 */
      -0.130479231f,  /* 0xbe059c59 */
        1.20315444f,  /* 0x3f9a00f7 */
        5.39331388f,  /* 0x40ac9607 */
        1.31349289f,  /* 0x3fa82089 */
        1.10277236f,  /* 0x3f8d27a5 */
       0.264316291f,  /* 0x3e875477 */
       -1.07096112f,  /* 0xbf891541 */
      -0.635679722f,  /* 0xbf22bbe8 */
         11.437027f,  /* 0x4136fe10 */
      0.0325890705f,  /* 0x3d057c1e */
      0.0769650936f,  /* 0x3d9d9fe0 */
        0.18176724f,  /* 0x3e3a2131 */
       0.429276824f,  /* 0x3edbca2c */
        1.01381624f,  /* 0x3f81c4bb */
        2.39431381f,  /* 0x40193c70 */
      -0.176179633f,  /* 0xbe34686f */
      -0.290938258f,  /* 0xbe94f5dc */
      -0.391557395f,  /* 0xbec87a36 */
        -0.2267465f,  /* 0xbe68303c */
        1.11292446f,  /* 0x3f8e744f */
        6.52144241f,  /* 0x40d0afa8 */
       0.873381972f,  /* 0x3f5f95f6 */
       0.913065612f,  /* 0x3f69beab */
       0.402508289f,  /* 0x3ece1591 */
      -0.921669126f,  /* 0xbf6bf282 */
       -1.23782623f,  /* 0xbf9e7117 */
        11.9539156f,  /* 0x413f433d */
      0.0191704817f,  /* 0x3c9d0b6a */
      0.0529313982f,  /* 0x3d58ce98 */
       0.146148279f,  /* 0x3e15a7e5 */
       0.403528333f,  /* 0x3ece9b44 */
        1.11417747f,  /* 0x3f8e9d5e */
        3.07634258f,  /* 0x4044e2cc */
      -0.108042553f,  /* 0xbddd456a */
      -0.212250561f,  /* 0xbe595836 */
      -0.348410845f,  /* 0xbeb262e8 */
      -0.305870861f,  /* 0xbe9c9b1b */
       0.967075169f,  /* 0x3f77923d */
         7.6722002f,  /* 0x40f582aa */
       0.563790202f,  /* 0x3f10548e */
       0.726513624f,  /* 0x3f39fccc */
       0.486581504f,  /* 0x3ef92136 */
      -0.718005896f,  /* 0xbf37cf3c */
        -1.7832346f,  /* 0xbfe44108 */
         11.892663f,  /* 0x413e4859 */
      0.0110346545f,  /* 0x3c34cab2 */
       0.035620302f,  /* 0x3d11e698 */
       0.114983745f,  /* 0x3deb7c99 */
       0.371172071f,  /* 0x3ebe0a44 */
        1.19815814f,  /* 0x3f995d3f */
        3.86770177f,  /* 0x4077886d */
     -0.0646412224f,  /* 0xbd84629e */
       -0.15074712f,  /* 0xbe1a5d74 */
      -0.299658298f,  /* 0xbe996cd0 */
      -0.363796651f,  /* 0xbeba438e */
       0.773811221f,  /* 0x3f46187e */
        8.78663445f,  /* 0x410c960e */
       0.353655159f,  /* 0x3eb5124a */
       0.557222903f,  /* 0x3f0ea629 */
       0.520281613f,  /* 0x3f05312d */
       -0.48483932f,  /* 0xbef83cdc */
       -2.21634173f,  /* 0xc00dd88b */
        11.1937904f,  /* 0x413319c4 */
      0.0062201065f,  /* 0x3bcbd209 */
      0.0234744381f,  /* 0x3cc04d77 */
       0.088591598f,  /* 0x3db56f83 */
       0.334341198f,  /* 0x3eab2ec5 */
        1.26179051f,  /* 0x3fa1825a */
        4.76194763f,  /* 0x409861e0 */
     -0.0377629139f,  /* 0xbd1aad49 */
      -0.104347177f,  /* 0xbdd5b3f9 */
      -0.249755427f,  /* 0xbe7fbfe3 */
      -0.398940563f,  /* 0xbecc41f0 */
       0.546039224f,  /* 0x3f0bc93a */
        9.80348301f,  /* 0x411cdb11 */
       0.215792373f,  /* 0x3e5cf8ad */
       0.413001835f,  /* 0x3ed374fa */
       0.512251616f,  /* 0x3f0322ec */
      -0.248025015f,  /* 0xbe7dfa45 */
       -2.49622464f,  /* 0xc01fc225 */
        9.87012386f,  /* 0x411dec07 */
      0.0034368143f,  /* 0x3b613c2d */
      0.0151639357f,  /* 0x3c787228 */
      0.0669064224f,  /* 0x3d89063c */
       0.295204967f,  /* 0x3e97251b */
        1.30250549f,  /* 0x3fa6b880 */
        5.74692345f,  /* 0x40b7e6cc */
     -0.0215619393f,  /* 0xbcb0a2aa */
     -0.0704797357f,  /* 0xbd9057ae */
      -0.202183798f,  /* 0xbe4f0945 */
      -0.412084222f,  /* 0xbed2fcb4 */
       0.299625248f,  /* 0x3e99687b */
         10.666296f,  /* 0x412aa926 */
       0.128225684f,  /* 0x3e034d98 */
       0.296473563f,  /* 0x3e97cb62 */
       0.473731458f,  /* 0x3ef28cee */
     -0.0303167608f,  /* 0xbcf85adb */
       -2.60291219f,  /* 0xc026961d */
         8.0079565f,  /* 0x41002097 */
     0.00186333561f,  /* 0x3af43b2b */
     0.00961181708f,  /* 0x3c1d7ae2 */
       0.049581524f,  /* 0x3d4b15ff */
       0.255760968f,  /* 0x3e82f31a */
        1.31931543f,  /* 0x3fa8df54 */
        6.80554628f,  /* 0x40d9c709 */
     -0.0120464712f,  /* 0xbc455e90 */
     -0.0465119667f,  /* 0xbd3e8355 */
      -0.159309238f,  /* 0xbe2321f6 */
      -0.405921668f,  /* 0xbecfd4f7 */
      0.0512552559f,  /* 0x3d51f108 */
        11.3299637f,  /* 0x41354788 */
      0.0742914006f,  /* 0x3d982617 */
       0.206559405f,  /* 0x3e53844f */
       0.416370958f,  /* 0x3ed52e93 */
       0.151607558f,  /* 0x3e1b3f03 */
       -2.53921962f,  /* 0xc0228293 */
         5.7537117f,  /* 0x40b81e68 */
    0.000992439222f,  /* 0x3a8214bc */
     0.00598517433f,  /* 0x3bc41f48 */
      0.0360952206f,  /* 0x3d13d895 */
       0.217682034f,  /* 0x3e5ee80a */
        1.31279075f,  /* 0x3fa80987 */
        7.91714096f,  /* 0x40fd5938 */
    -0.00659351842f,  /* 0xbbd80e71 */
      -0.030032333f,  /* 0xbcf6065e */
      -0.122428641f,  /* 0xbdfabbde */
      -0.384396136f,  /* 0xbec4cf92 */
      -0.183655843f,  /* 0xbe3c1047 */
        11.7653952f,  /* 0x413c3f0f */
       0.042026367f,  /* 0x3d2c23d7 */
       0.139965147f,  /* 0x3e0f5306 */
       0.350541919f,  /* 0x3eb37a3b */
       0.288511723f,  /* 0x3e93b7cf */
       -2.32798648f,  /* 0xc014fdbb */
        3.28965139f,  /* 0x405289a6 */
     0.00051990978f,  /* 0x3a084a8e */
     0.00366572081f,  /* 0x3b703c97 */
      0.0258458499f,  /* 0x3cd3baad */
       0.182230979f,  /* 0x3e3a9ac2 */
        1.28485358f,  /* 0x3fa47615 */
         9.0590992f,  /* 0x4110f212 */
    -0.00354028563f,  /* 0xbb680423 */
      -0.019001117f,  /* 0xbc9ba83b */
     -0.0919465125f,  /* 0xbdbc4e74 */
      -0.351985127f,  /* 0xbeb43765 */
      -0.392612129f,  /* 0xbec90475 */
        11.9615793f,  /* 0x413f62a1 */
      0.0232470743f,  /* 0x3cbe70a6 */
      0.0924263224f,  /* 0x3dbd4a03 */
       0.284335583f,  /* 0x3e91946f */
       0.378356755f,  /* 0x3ec1b7fa */
       -2.00591135f,  /* 0xc00060da */
       0.805069864f,  /* 0x3f4e190f */
    0.000268235919f,  /* 0x398ca204 */
     0.00221109227f,  /* 0x3b10e7f9 */
      0.0182262287f,  /* 0x3c954f2c */
       0.150240391f,  /* 0x3e19d89e */
        1.23844481f,  /* 0x3f9e855c */
        10.2086086f,  /* 0x41235676 */
    -0.00186737522f,  /* 0xbaf4c2b7 */
     -0.0117977839f,  /* 0xbc414b7e */
     -0.0676149875f,  /* 0xbd8a79ba */
      -0.313070893f,  /* 0xbea04ad4 */
      -0.567004919f,  /* 0xbf11273c */
        11.9249525f,  /* 0x413ecc9b */
      0.0125938701f,  /* 0x3c4e5685 */
      0.0596012585f,  /* 0x3d742073 */
         0.2232337f,  /* 0x3e649760 */
       0.424852341f,  /* 0x3ed9863f */
       -1.61591017f,  /* 0xbfced625 */
       -1.53009605f,  /* 0xbfc3da30 */
    0.000136468341f,  /* 0x390f18f1 */
     0.00131516543f,  /* 0x3aac61a1 */
      0.0126744406f,  /* 0x3c4fa875 */
       0.122145437f,  /* 0x3dfa2763 */
        1.17713344f,  /* 0x3f96ac4f */
        11.3442059f,  /* 0x413581de */
    -0.000968996144f,  /* 0xba7e043b */
    -0.00719994679f,  /* 0xbbebed88 */
     -0.0487787612f,  /* 0xbd47cc3d */
      -0.271484017f,  /* 0xbe8afff4 */
      -0.702355385f,  /* 0xbf33cd90 */
        11.6765633f,  /* 0x413ad334 */
     0.00669267867f,  /* 0x3bdb4e42 */
      0.0376076438f,  /* 0x3d1a0a79 */
       0.170297265f,  /* 0x3e2e6268 */
       0.435410589f,  /* 0x3edeee23 */
       -1.19994748f,  /* 0xbf9997e1 */
       -3.58406544f,  /* 0xc0656154 */
    6.85534906e-05f,  /* 0x388fc460 */
    0.000772389816f,  /* 0x3a4a7a34 */
     0.00870248955f,  /* 0x3c0e94e3 */
      0.0980506465f,  /* 0x3dc8cec7 */
        1.10473323f,  /* 0x3f8d67e6 */
          12.44699f,  /* 0x414726df */
    -0.000495378103f,  /* 0xba01dc43 */
    -0.00432553003f,  /* 0xbb8dbd2d */
     -0.0345856659f,  /* 0xbd0da9b3 */
      -0.230248749f,  /* 0xbe6bc654 */
      -0.797948897f,  /* 0xbf4c4661 */
        11.2478876f,  /* 0x4133f759 */
     0.00349465944f,  /* 0x3b6506a8 */
      0.0232658889f,  /* 0x3cbe981b */
       0.126658648f,  /* 0x3e01b2ce */
        0.41908437f,  /* 0x3ed6923a */
      -0.793708384f,  /* 0xbf4b3079 */
       -5.27219343f,  /* 0xc0a8b5cf */
};

#endif

#ifdef DIAGNOSED_SELFTEST_NUMBERS

/* Self-test: where each function starts, what it is given, and the bits that the float32 reference answers. */

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
    { 0x3f824051u, 0x3f84e1f0u, 0xc0af3d3au },  /* 1.01759, 1.03815 -> -5.47622 */
    { 0x3f9065a1u, 0x3f92d5ebu, 0x4197926au },  /* 1.1281, 1.14715 -> 18.9465 */
    { 0xff800000u, 0x80000000u, 0x40b7b83cu },  /* -inf, -0 -> 5.74124 */
    { 0x3f911acdu, 0x3f9491deu, 0x40162f78u },  /* 1.13363, 1.1607 -> 2.34665 */
    { 0x3fa4d84au, 0x3fa7e0bcu, 0x421a16a4u },  /* 1.28785, 1.31155 -> 38.5221 */
    { 0x80000000u, 0xf149f2cau, 0x418c0691u },  /* -0, -1e+30 -> 17.5032 */
    { 0x3f794288u, 0x3f82e2d2u, 0x41258200u },  /* 0.973671, 1.02255 -> 10.3442 */
    { 0x3ffbdc0du, 0x3ffc596eu, 0x426a34bfu },  /* 1.96765, 1.97148 -> 58.5515 */
    { 0x7f800000u, 0x40d9f3b6u, 0x42ab1affu },  /* inf, 6.811 -> 85.5527 */
    { 0x40350e16u, 0x40336ca2u, 0x42c89b13u },  /* 2.82898, 2.80351 -> 100.303 */
    { 0x4006ba40u, 0x40078378u, 0x42961ce1u },  /* 2.10512, 2.1174 -> 75.0564 */
    { 0x3f292a30u, 0x000116c2u, 0x42239ccdu },  /* 0.6608, 9.99995e-41 -> 40.9031 */
    { 0x404ec247u, 0x404d10dfu, 0x41d0b49au },  /* 3.23061, 3.20415 -> 26.0882 */
    { 0x3f764e8cu, 0x3f86a2a8u, 0x42c3e060u },  /* 0.962136, 1.05184 -> 97.9382 */
    { 0x7fc00000u, 0xff800000u, 0x4254d5f2u },  /* nan, -inf -> 53.2089 */
    { 0x3fb8c7bcu, 0x3fc16641u, 0x41e9be6eu },  /* 1.4436, 1.51093 -> 29.218 */
    { 0x3f89abffu, 0x3f94e909u, 0x42cd9d5eu },  /* 1.07556, 1.16336 -> 102.807 */
    { 0x40d9f3b6u, 0x406f18fcu, 0x42daf0efu },  /* 6.811, 3.7359 -> 109.471 */
    { 0x40652288u, 0x40633c58u, 0x42de82bau },  /* 3.58023, 3.55056 -> 111.255 */
    { 0x4056bef3u, 0x40557815u, 0x42c49cbdu },  /* 3.3554, 3.33545 -> 98.3061 */
    { 0x00000000u, 0x00000000u, 0x424c89f3u },  /* 0, 0 -> 51.1347 */
    { 0x4048ff21u, 0x404864b6u, 0x41d936f4u },  /* 3.14057, 3.13115 -> 27.1518 */
    { 0x40314e01u, 0x4031c5f3u, 0x42c27638u },  /* 2.77039, 2.77771 -> 97.2309 */
    { 0xf149f2cau, 0x7fc00000u, 0x424704d6u },  /* -1e+30, nan -> 49.7547 */
    { 0x4015142du, 0x4016fbedu, 0x41d1857au },  /* 2.32936, 2.35913 -> 26.1902 */
    { 0x3ff463d2u, 0x3ffb0b08u, 0x42bd7212u },  /* 1.9093, 1.96127 -> 94.7228 */
    { 0x000116c2u, 0x7f800000u, 0x4240a00cu },  /* 9.99995e-41, inf -> 48.1563 */
    { 0x40218d04u, 0x402303b8u, 0x41ca1348u },  /* 2.52423, 2.5471 -> 25.2594 */
    { 0x4067a433u, 0x40662c54u, 0x42b8a31eu },  /* 3.6194, 3.59646 -> 92.3186 */
};

/* learn: arguments, hash of every word of the learner afterwards. */
#define DIAGNOSED_SELFTEST_LEARN_START_Y 0x400cb1c4u
#define DIAGNOSED_SELFTEST_LEARN_START_U 0x00000000u
#define DIAGNOSED_SELFTEST_LEARN_CALLS 40u  /* more than any commit takes */
#define DIAGNOSED_SELFTEST_LEARN_AGE 131073u  /* set before row 32: past all waiting times */

static const uint32_t diagnosed_selftest_learn_rows[64][3] = {
    { 0x400cac1bu, 0x425a0febu, 0x5ee565c4u },  /* 2.198, 54.5155 */
    { 0x400b00c6u, 0x426a8ccbu, 0x70b9aadcu },  /* 2.17192, 58.6375 */
    { 0x400a6addu, 0x4047ce44u, 0x8474e39fu },  /* 2.16277, 3.12196 */
    { 0x40089410u, 0x42ca9294u, 0x7c559abbu },  /* 2.13404, 101.286 */
    { 0x40084f89u, 0x41da3340u, 0x2186746au },  /* 2.12985, 27.275 */
    { 0x4007c56eu, 0x4243a045u, 0x5f0ebe3du },  /* 2.12143, 48.9065 */
    { 0x4006bfaau, 0x42a17c18u, 0x816f856cu },  /* 2.10545, 80.7424 */
    { 0x4006dc78u, 0x42dad652u, 0x2e4025cfu },  /* 2.10721, 109.419 */
    { 0x3f292a30u, 0x429a5df6u, 0x02a07308u },  /* 0.6608, 77.1835 */
    { 0x40098f82u, 0x42327443u, 0x147f73b2u },  /* 2.14938, 44.6135 */
    { 0x40095c6fu, 0x4223bd24u, 0x788d8f85u },  /* 2.14627, 40.9347 */
    { 0x4008b4f2u, 0x41e33f9bu, 0xf5cf72c3u },  /* 2.13604, 28.4061 */
    { 0x4007db71u, 0x421942b2u, 0x27db780du },  /* 2.12277, 38.3151 */
    { 0x40071483u, 0x42a67383u, 0x8a6d1193u },  /* 2.11063, 83.2256 */
    { 0x400794d3u, 0x42d22afeu, 0x643d0986u },  /* 2.11846, 105.084 */
    { 0x400979fdu, 0x42a7af82u, 0x8f12c112u },  /* 2.14807, 83.8428 */
    { 0x400a5085u, 0x41eef478u, 0x99c3d1c5u },  /* 2.16116, 29.8694 */
    { 0x00000000u, 0x4283e016u, 0xfbd1a251u },  /* 0, 65.9377 */
    { 0x400a1435u, 0x42b44c26u, 0xd769d924u },  /* 2.15748, 90.1487 */
    { 0x400b8b43u, 0x423559efu, 0x94a67db3u },  /* 2.18037, 45.3378 */
    { 0x400c4bf0u, 0xc15ba026u, 0xfdf0f1fdu },  /* 2.19213, -13.7266 */
    { 0x400b102eu, 0x4251fd51u, 0xcba22bb4u },  /* 2.17286, 52.4974 */
    { 0x400a8b27u, 0x42c49237u, 0x4a0f54e3u },  /* 2.16474, 98.2856 */
    { 0x400c322cu, 0x42af5938u, 0xc6aab6e3u },  /* 2.19056, 87.6743 */
    { 0x400e69c2u, 0x42226a5bu, 0x69caa161u },  /* 2.2252, 40.6039 */
    { 0x400f3ae4u, 0x42203378u, 0x6917616bu },  /* 2.23797, 40.0503 */
    { 0xf149f2cau, 0x42e3c5a8u, 0x46543aceu },  /* -1e+30, 113.886 */
    { 0x4011486eu, 0x4222f16fu, 0x6dcf30c9u },  /* 2.27005, 40.7358 */
    { 0x40128b20u, 0x4233057du, 0x5ce7bf76u },  /* 2.28974, 44.7554 */
    { 0x4012cd3bu, 0x428ae7f0u, 0x79582c59u },  /* 2.29378, 69.453 */
    { 0x4013b994u, 0x42e89b47u, 0x8cfee910u },  /* 2.3082, 116.303 */
    { 0x401635bdu, 0x421bde7bu, 0xa8b55a88u },  /* 2.34703, 38.9673 */
    { 0x401634fbu, 0x423fac3bu, 0x4dc864a5u },  /* 2.34698, 47.9182 */
    { 0x4015b850u, 0x42b95f4bu, 0xd31c151bu },  /* 2.33937, 92.6861 */
    { 0x40172ad0u, 0x4281fc35u, 0x7c88dee2u },  /* 2.36199, 64.9926 */
    { 0x3fca1becu, 0x424231a6u, 0x9a1f2745u },  /* 1.57898, 48.5485 */
    { 0x40193875u, 0x41fdfb4au, 0xabae5c54u },  /* 2.39407, 31.7477 */
    { 0x40192d24u, 0x41fdc827u, 0x08b2e2ccu },  /* 2.39338, 31.7227 */
    { 0x4018d078u, 0x40e16fbau, 0x88521488u },  /* 2.38772, 7.04489 */
    { 0x4017f401u, 0x42a9dcb1u, 0x3ce9ce8cu },  /* 2.37427, 84.931 */
    { 0x40186997u, 0x42a20c87u, 0x5e611a19u },  /* 2.38144, 81.0245 */
    { 0x4019f8ceu, 0x42e2ffafu, 0x41102aebu },  /* 2.40581, 113.499 */
    { 0x401c3775u, 0x426db281u, 0x9502b7bdu },  /* 2.44088, 59.4243 */
    { 0x401d79b7u, 0x422dc6bau, 0x2745e37bu },  /* 2.46055, 43.4441 */
    { 0x3f8a6e33u, 0xc1055a2fu, 0xbac86440u },  /* 1.08149, -8.33452 */
    { 0x401be36cu, 0x42b4ed3bu, 0x3f419967u },  /* 2.43576, 90.4633 */
    { 0x401bcdc5u, 0x42df3a54u, 0xfbcde2b0u },  /* 2.43443, 111.614 */
    { 0x401dc0bdu, 0x42a7af82u, 0x53d05729u },  /* 2.46489, 83.8428 */
    { 0x401ea4eau, 0x4291b005u, 0x3e71784eu },  /* 2.47882, 72.8438 */
    { 0x401ef3f0u, 0x419333bcu, 0xc4e6b0a0u },  /* 2.48364, 18.4003 */
    { 0x401e139bu, 0x42a43af7u, 0xe297c982u },  /* 2.46995, 82.1152 */
    { 0x401dd983u, 0x41efe1d4u, 0x477f363eu },  /* 2.4664, 29.9853 */
    { 0x401d52a7u, 0x42dc97e0u, 0xf6a362c8u },  /* 2.45817, 110.297 */
    { 0x3f708589u, 0x42bd456eu, 0xf1bc1ac4u },  /* 0.939538, 94.6356 */
    { 0x401f1c36u, 0x419110cdu, 0x11d7b435u },  /* 2.4861, 18.1332 */
    { 0x401e4837u, 0x41ec3355u, 0x759757fdu },  /* 2.47316, 29.5251 */
    { 0x401c8028u, 0x40247e78u, 0xd8e33e2bu },  /* 2.44532, 2.57022 */
    { 0x401a51c3u, 0x428ec970u, 0x2747afa2u },  /* 2.41124, 71.3934 */
    { 0x40193dd4u, 0x425d3a6eu, 0xe24c2a2fu },  /* 2.3944, 55.3071 */
    { 0x4018e67cu, 0x42e2ea73u, 0x70b5c146u },  /* 2.38907, 113.458 */
    { 0x4019960fu, 0x40ad7765u, 0x0b967eeeu },  /* 2.39978, 5.42082 */
    { 0x4018a662u, 0x4130afaau, 0x7076070au },  /* 2.38516, 11.0429 */
    { 0x4006f9dau, 0x42eb0910u, 0xc129fbefu },  /* 2.109, 117.518 */
    { 0x401637ebu, 0x421bde7bu, 0x84e247cdu },  /* 2.34716, 38.9673 */
};

/* commit: age, calls, answer, hash of every word of instance and learner afterwards, theta before. */
static const uint32_t diagnosed_selftest_commit_rows[8][22] = {
    { 0u, 1u, 2u, 0xb1e9e845u,
0x40ab28bcu, 0x3e9ad548u, 0x3ac7841fu, 0x409e5d6fu, 0x3e8705dbu, 0x3b1504f4u, 0x40575259u, 0x3e231149u,
0x3a31023bu, 0x40577d0bu, 0x3e139e35u, 0xba2358dcu, 0x409f09b0u, 0x3e5566adu, 0xbad593e4u, 0x40acb919u,
0x3e661f85u, 0xbac332ffu
    },
    { 131073u, 35u, 1u, 0xcde24c9au,
0x40aaf7a7u, 0x3e92da1cu, 0x00000000u, 0x409e3e50u, 0x3e8109bcu, 0x3a8f3a5au, 0x405786e4u, 0x3e24e483u,
0x3a525ba7u, 0x4057fa90u, 0x3e1be5e4u, 0x39029668u, 0x409f3da1u, 0x3e5c7b61u, 0xba80d100u, 0x40acc45eu,
0x3e67a9b6u, 0xbab0b719u
    },
    { 131073u, 35u, 1u, 0x0e665381u,
0x40ab28bcu, 0x3e9ad548u, 0x3ac7841fu, 0x409e5d6fu, 0x3e8705dbu, 0x3b1504f4u, 0x40575259u, 0x3e231149u,
0x3a31023bu, 0x40577d0bu, 0x3e139e35u, 0xba2358dcu, 0x409f09b0u, 0x3e5566adu, 0xbad593e4u, 0x40acb919u,
0x3e661f85u, 0xbac332ffu
    },
    { 131073u, 2u, 4u, 0xc69b6bbcu,
0x40aaf7a7u, 0x3bbbf875u, 0x00000000u, 0x409e3e50u, 0x3ba52b2eu, 0x3a8f3a5au, 0x405786e4u, 0x3b531004u,
0x3a525ba7u, 0x4057fa90u, 0x3b478ca9u, 0x39029668u, 0x409f3da1u, 0x3b8d1bc3u, 0xba80d100u, 0x40acc45eu,
0x3b9443a7u, 0xbab0b719u
    },
    { 131073u, 2u, 4u, 0xef142226u,
0x40aaf7a7u, 0xbe92da1cu, 0x00000000u, 0x409e3e50u, 0xbe8109bcu, 0x3a8f3a5au, 0x405786e4u, 0xbe24e483u,
0x3a525ba7u, 0x4057fa90u, 0xbe1be5e4u, 0x39029668u, 0x409f3da1u, 0xbe5c7b61u, 0xba80d100u, 0x40acc45eu,
0xbe67a9b6u, 0xbab0b719u
    },
    { 131073u, 2u, 5u, 0xf7535b6eu,
0x40de41f2u, 0x3e92da1cu, 0x00000000u, 0x40cdb768u, 0x3e8109bcu, 0x3a8f3a5au, 0x408c17adu, 0x3e24e483u,
0x3a525ba7u, 0x408c62ddu, 0x3e1be5e4u, 0x39029668u, 0x40cf0351u, 0x3e5c7b61u, 0xba80d100u, 0x40e098e0u,
0x3e67a9b6u, 0xbab0b719u
    },
    { 131073u, 2u, 5u, 0x1f536e4eu,
0xc0de41f2u, 0x3e92da1cu, 0x00000000u, 0xc0cdb768u, 0x3e8109bcu, 0x3a8f3a5au, 0xc08c17adu, 0x3e24e483u,
0x3a525ba7u, 0xc08c62ddu, 0x3e1be5e4u, 0x39029668u, 0xc0cf0351u, 0x3e5c7b61u, 0xba80d100u, 0xc0e098e0u,
0x3e67a9b6u, 0xbab0b719u
    },
    { 131073u, 1u, 3u, 0x4fe8890fu,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u
    },
};

#endif
