/* extended_params.h: the numbers of model `extended`. All that changes when the same structure is identified again.
 *
 * Part 1 comes with extended.h. extended.c defines EXTENDED_NUMBERS for part 2, extended_selftest.c
 * EXTENDED_SELFTEST_NUMBERS for part 3. Every float32 is written with 9 significant digits, which read back to the bits
 * in the comment behind it. */

#ifndef EXTENDED_PARAMS_H
#define EXTENDED_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define EXTENDED_NUMBERS_DIGEST "994a90af79ebbebf83ac7d3e8ed80492905e74c53e653c8b0c0283d1740afbcb"
#define EXTENDED_NUMBERS_WORD 0x994a90afu

/* Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value. */
#define EXTENDED_Y_MIN_UM           -0.0555000007f  /* 0xbd6353f8 */
#define EXTENDED_Y_MAX_UM              3.00884795f  /* 0x404090f7 */
#define EXTENDED_Y_REST_UM             1.47667408f  /* 0x3fbd03a8 */
#define EXTENDED_U_MIN_V                     22.0f  /* 0x41b00000 */
#define EXTENDED_U_MAX_V                     56.0f  /* 0x42600000 */
#define EXTENDED_U_REST_V                    22.0f  /* 0x41b00000 */
#define EXTENDED_U_STEP_MAX_V                68.0f  /* 0x42880000 */
#define EXTENDED_REFERENCE_MIN_UM     -3.11984801f  /* 0xc047ab97 */
#define EXTENDED_REFERENCE_MAX_UM      6.07319593f  /* 0x40c2579f */
#define EXTENDED_W_MIN                0.292959452f  /* 0x3e95fec8 */
#define EXTENDED_W_MAX                 3.41769004f  /* 0x405abb6f */
#define EXTENDED_W_TOLERANCE       2.97997531e-06f  /* 0x3647fb96 */

/* Commit: check points. */
#define EXTENDED_COMMIT_POINTS  0x00000020u

/* Worst error of one step against the float64 model, measured when this file was generated
 * over 20000 samples of the whole range, rounded up.
 * PATH_ERROR: part of the path, of w, along random ramps from rest; INVERSE_ERROR_UM: of y(k+1) against the
 * reference where no limit acts. */
#define EXTENDED_PREDICT_ERROR_UM  8.39999984e-07f  /* 0x35617c5c */
#define EXTENDED_PATH_ERROR        6.39999996e-07f  /* 0x352bcc77 */
#define EXTENDED_INVERSE_ERROR_UM  5.20000015e-07f  /* 0x350b9621 */

#endif

#ifdef EXTENDED_NUMBERS

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/um]. */
#define EXTENDED_ORIGIN_UM  1.47667408f  /* 0x3fbd03a8 */
#define EXTENDED_PER_STEP   2.35399985f  /* 0x4016a7ef */

EXTENDED_TABLE
static const float extended_strength[EXTENDED_RULES] = {
      0.0439369343f,  /* 0x3d33f737 */
       0.324652463f,  /* 0x3ea638d9 */
       0.882496893f,  /* 0x3f61eb51 */
       0.882496893f,  /* 0x3f61eb51 */
       0.324652463f,  /* 0x3ea638d9 */
      0.0439369343f,  /* 0x3d33f737 */
};

EXTENDED_TABLE
static const float extended_slope[EXTENDED_BANK_RULES] = {
      0.0430494361f,  /* 0x3d30549b */
       0.318094701f,  /* 0x3ea2dd4f */
       0.864671052f,  /* 0x3f5d5b15 */
       0.864671052f,  /* 0x3f5d5b15 */
       0.318094701f,  /* 0x3ea2dd4f */
      0.0430494361f,  /* 0x3d30549b */
};

EXTENDED_TABLE
static const float extended_offset[EXTENDED_BANK_RULES] = {
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
               0.0f,  /* 0x00000000 */
};

EXTENDED_TABLE
static const float extended_gain[EXTENDED_BANK_RULES] = {
    0.000887498201f,  /* 0x3a68a6ff */
      0.0065577738f,  /* 0x3bd6e298 */
      0.0178258773f,  /* 0x3c920793 */
      0.0178258773f,  /* 0x3c920793 */
      0.0065577738f,  /* 0x3bd6e298 */
    0.000887498201f,  /* 0x3a68a6ff */
};

/* Input block `delay`: input delayed by 1.8 samples. */

EXTENDED_TABLE
static const float extended_delay_part[1] = {
       0.800000012f,  /* 0x3f4ccccd */
};

/* Input block `hysteresis`: 12 plays of degree 3, 5 Duhem states, curve of degree 7. */

EXTENDED_TABLE
static const float extended_hysteresis_range[6] = {
              39.0f,  /* 0x421c0000 */
              17.0f,  /* 0x41880000 */
      0.0588235296f,  /* 0x3d70f0f1 */
      0.0245505683f,  /* 0x3cc91e46 */
        2.63873124f,  /* 0x4028e0f9 */
       0.814645112f,  /* 0x3f508c95 */
};

EXTENDED_TABLE
static const float extended_hysteresis_curve[208] = {
        1.75691712f,  /* 0x3fe0e2a9 */
        1.02223647f,  /* 0x3f82d8a5 */
      0.0172607098f,  /* 0x3c8d6655 */
     -0.0848241895f,  /* 0xbdadb84e */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.75877929f,  /* 0x3fe11fae */
       0.935653746f,  /* 0x3f6f8701 */
     -0.0168256555f,  /* 0xbc89d5f5 */
     -0.0260222331f,  /* 0xbcd52c94 */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.75734663f,  /* 0x3fe0f0bc */
       0.957970142f,  /* 0x3f753d88 */
       0.010167025f,  /* 0x3c269398 */
     -0.0820756927f,  /* 0xbda8174d */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.75141621f,  /* 0x3fe02e68 */
         1.0128808f,  /* 0x3f81a614 */
     -0.0059013553f,  /* 0xbbc16028 */
     -0.0523051694f,  /* 0xbd563df2 */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.74483407f,  /* 0x3fdf56b9 */
        1.05241919f,  /* 0x3f86b5ac */
     -0.0115283038f,  /* 0xbc3ce136 */
     -0.0527575575f,  /* 0xbd58184f */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.73103738f,  /* 0x3fdd92a2 */
         1.1079458f,  /* 0x3f8dd12b */
    -0.00559733948f,  /* 0xbbb769e3 */
     -0.0369402133f,  /* 0xbd174e9f */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.71241224f,  /* 0x3fdb3053 */
        1.16758609f,  /* 0x3f957376 */
    -0.00250917953f,  /* 0xbb24710c */
     -0.0492340922f,  /* 0xbd49a9b0 */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
         1.6916678f,  /* 0x3fd88892 */
        1.22154844f,  /* 0x3f9c5bb3 */
    -0.00215462525f,  /* 0xbb0d349d */
     -0.0594898611f,  /* 0xbd73aba4 */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.66647971f,  /* 0x3fd54f35 */
        1.27543819f,  /* 0x3fa3418f */
     -0.0211925395f,  /* 0xbcad9bfa */
     -0.0274038948f,  /* 0xbce07e22 */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.63718867f,  /* 0x3fd18f66 */
        1.26921415f,  /* 0x3fa2759c */
       0.151401564f,  /* 0x3e1b0903 */
      -0.155025393f,  /* 0xbe1ebefa */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.49303806f,  /* 0x3fbf1bdf */
        1.84212172f,  /* 0x3febcaa5 */
      -0.664573371f,  /* 0xbf2a217b */
       0.265177548f,  /* 0x3e87c55a */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.26101148f,  /* 0x3fa168d3 */
        2.68839145f,  /* 0x402c0e9b */
       -1.72116148f,  /* 0xbfdc4f05 */
       0.717824042f,  /* 0x3f37c351 */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        1.33378255f,  /* 0x3faab963 */
        2.22465158f,  /* 0x400e60b1 */
      -0.962193549f,  /* 0xbf765251 */
       0.347314954f,  /* 0x3eb1d344 */
     0.00196599145f,  /* 0x3b00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    0.000252557278f,  /* 0x398469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.75691712f,  /* 0xbfe0e2a9 */
        1.02223647f,  /* 0x3f82d8a5 */
     -0.0172607098f,  /* 0xbc8d6655 */
     -0.0848241895f,  /* 0xbdadb84e */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.75502729f,  /* 0xbfe0a4bc */
        0.93306601f,  /* 0x3f6edd6a */
     0.00929854903f,  /* 0x3c1858f1 */
     -0.0260222331f,  /* 0xbcd52c94 */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.75658262f,  /* 0xbfe0d7b3 */
       0.959448457f,  /* 0x3f759e6a */
     0.00260061608f,  /* 0x3b2a6f19 */
     -0.0820756927f,  /* 0xbda8174d */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.76236141f,  /* 0xbfe1950f */
        1.01162434f,  /* 0x3f817ce8 */
    -0.00113279989f,  /* 0xba947a75 */
     -0.0523051694f,  /* 0xbd563df2 */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.76860225f,  /* 0xbfe2618f */
        1.04716289f,  /* 0x3f86096f */
     0.00495742215f,  /* 0x3ba271df */
     -0.0527575575f,  /* 0xbd58184f */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.78436184f,  /* 0xbfe465f8 */
        1.11914766f,  /* 0x3f8f403b */
     -0.0236108471f,  /* 0xbcc16b89 */
     -0.0369402133f,  /* 0xbd174e9f */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
        -1.8013202f,  /* 0xbfe691a9 */
        1.16815698f,  /* 0x3f95862b */
    -0.00357026863f,  /* 0xbb69fb2b */
     -0.0492340922f,  /* 0xbd49a9b0 */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.81837952f,  /* 0xbfe8c0a9 */
        1.20346594f,  /* 0x3f9a0b2c */
       0.020388905f,  /* 0x3ca706a2 */
     -0.0594898611f,  /* 0xbd73aba4 */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.85635269f,  /* 0xbfed9cf7 */
        1.31032336f,  /* 0x3fa7b8ad */
     -0.0535096824f,  /* 0xbd5b2cf8 */
     -0.0274038948f,  /* 0xbce07e22 */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -1.85382307f,  /* 0xbfed4a13 */
         1.1936177f,  /* 0x3f98c877 */
       0.214982763f,  /* 0x3e5c2471 */
      -0.155025393f,  /* 0xbe1ebefa */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -2.02938676f,  /* 0xc001e179 */
        1.85964847f,  /* 0x3fee08f6 */
       -0.67000705f,  /* 0xbf2b8595 */
       0.265177548f,  /* 0x3e87c55a */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
       -2.26185179f,  /* 0xc010c22e */
         2.7070446f,  /* 0x402d4038 */
       -1.72731876f,  /* 0xbfdd18c8 */
       0.717824042f,  /* 0x3f37c351 */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
         -1.832304f,  /* 0xbfea88f0 */
        1.43872368f,  /* 0x3fb82819 */
      -0.514740586f,  /* 0xbf03c60a */
       0.347314954f,  /* 0x3eb1d344 */
    -0.00196599145f,  /* 0xbb00d7dd */
       0.099664934f,  /* 0x3dcc1d21 */
    -0.000252557278f,  /* 0xb98469aa */
     -0.0634113178f,  /* 0xbd81ddcb */
};

EXTENDED_TABLE
static const float extended_hysteresis_play[48] = {
      0.0213346221f,  /* 0x3caec5f2 */
     -0.0879569203f,  /* 0xbdb422c2 */
     -0.0303228125f,  /* 0xbcf8678c */
      0.0588019602f,  /* 0x3d70da53 */
      0.0603434257f,  /* 0x3d772aab */
      0.0249617361f,  /* 0x3ccc7c8e */
      0.0168453064f,  /* 0x3c89ff2b */
     -0.0560534596f,  /* 0xbd659850 */
       0.110857956f,  /* 0x3de3097f */
      0.0524456874f,  /* 0x3d56d14a */
    -0.00616748212f,  /* 0xbbca1897 */
      0.0297705252f,  /* 0x3cf3e151 */
       0.170676976f,  /* 0x3e2ec5f2 */
      0.0375780351f,  /* 0x3d19eb6d */
    -0.00585858524f,  /* 0xbbbff960 */
    -0.000452387612f,  /* 0xb9ed2e70 */
       0.238528341f,  /* 0x3e7440c6 */
      0.0610558502f,  /* 0x3d7a15b3 */
      0.0172496159f,  /* 0x3c8d4f11 */
      0.0158173405f,  /* 0x3c81935e */
       0.313553631f,  /* 0x3ea08a1a */
      0.0579508469f,  /* 0x3d6d5dde */
     -0.0084762089f,  /* 0xbc0adfcc */
     -0.0122938761f,  /* 0xbc496c41 */
       0.395122737f,  /* 0x3eca4d87 */
      0.0494391248f,  /* 0x3d4a80ae */
     -0.0118023092f,  /* 0xbc415e79 */
     -0.0102557698f,  /* 0xbc2807d1 */
       0.482747406f,  /* 0x3ef72aab */
       0.057941135f,  /* 0x3d6d53af */
      0.0274303369f,  /* 0x3ce0b596 */
      0.0320859663f,  /* 0x3d036c93 */
       0.576034844f,  /* 0x3f137705 */
      0.0655757934f,  /* 0x3d864c9a */
     -0.0479491688f,  /* 0xbd446659 */
      -0.127621487f,  /* 0xbe02af35 */
       0.674660027f,  /* 0x3f2cb685 */
      0.0456826575f,  /* 0x3d3b1dbd */
       0.034507446f,  /* 0x3d0d57ae */
       0.420202941f,  /* 0x3ed724d7 */
       0.778348327f,  /* 0x3f4741d6 */
      0.0241578408f,  /* 0x3cc5e6aa */
    0.000361791492f,  /* 0x39bdaed5 */
       0.452646494f,  /* 0x3ee7c148 */
       0.886863649f,  /* 0x3f63097f */
     0.00821577013f,  /* 0x3c069b70 */
      -0.226805136f,  /* 0xbe683f9b */
      -0.370509088f,  /* 0xbebdb35e */
};

EXTENDED_TABLE
static const float extended_hysteresis_rate[1] = {
       -1.44269502f,  /* 0xbfb8aa3b */
};

EXTENDED_TABLE
static const float extended_hysteresis_duhem[15] = {
     -0.0594909303f,  /* 0xbd73acc3 */
      0.0127239032f,  /* 0x3c5077eb */
               1.0f,  /* 0x3f800000 */
      0.0418700539f,  /* 0x3d2b7fef */
     0.00255209557f,  /* 0x3b27410f */
               2.0f,  /* 0x40000000 */
     -0.0170493387f,  /* 0xbc8bab0e */
    -0.00653710915f,  /* 0xbbd6353f */
               4.0f,  /* 0x40800000 */
     0.00915242359f,  /* 0x3c15f40c */
     0.00572888134f,  /* 0x3bbbb957 */
               8.0f,  /* 0x41000000 */
    -0.00555880927f,  /* 0xbbb626ac */
    -0.00333816372f,  /* 0xbb5ac518 */
              16.0f,  /* 0x41800000 */
};

/* Input block `creep`: creep by 0.012 per state, 4 states of 0.03 .. 30 s. */

EXTENDED_TABLE
static const float extended_creep_rate[4] = {
    0.000666444481f,  /* 0x3a2eb455 */
     6.6664441e-05f,  /* 0x388bce33 */
    6.66664437e-06f,  /* 0x36dfb20a */
    6.66666438e-07f,  /* 0x3532f4f8 */
};

EXTENDED_TABLE
static const float extended_creep_amount[1] = {
      0.0120000001f,  /* 0x3c449ba6 */
};

/* Learner: plausible displacements, rest, levels of the innovation and how fast they follow. */
#define EXTENDED_LEARN_Y_LOW_UM         -3.11984801f  /* 0xc047ab97 */
#define EXTENDED_LEARN_Y_HIGH_UM         6.07319593f  /* 0x40c2579f */
#define EXTENDED_LEARN_REST_V         0.00207519531f  /* 0x3b080000 */
#define EXTENDED_LEARN_FLOOR_UM       6.2500003e-05f  /* 0x3883126f */
#define EXTENDED_LEARN_FLOOR_SQUARE  3.90625043e-09f  /* 0x318637be */
#define EXTENDED_LEARN_LEVEL_UM          3.06434798f  /* 0x40441e47 */
#define EXTENDED_LEARN_FAST              0.00390625f  /* 0x3b800000 */
#define EXTENDED_LEARN_SLOW          0.000244140625f  /* 0x39800000 */

/* Learner: outlier gate, dead zone, restart (ratios of mean squares), limits, updates, forgetting
 * 1/lambda. */
#define EXTENDED_LEARN_GATE                            8.0f  /* 0x41000000 */
#define EXTENDED_LEARN_GATE_FLOOR_UM         0.00300000003f  /* 0x3b449ba6 */
#define EXTENDED_LEARN_DEAD_ZONE_UM         0.000250000012f  /* 0x3983126f */
#define EXTENDED_LEARN_WORSE                    1.21198082f  /* 0x3f9b2230 */
#define EXTENDED_LEARN_LOST                            4.0f  /* 0x40800000 */
#define EXTENDED_LEARN_STEP_UM                 0.766086996f  /* 0x3f441e47 */
#define EXTENDED_LEARN_LIMIT_UM                 784.473083f  /* 0x44441e47 */
#define EXTENDED_LEARN_LEAST_VARIANCE       9.09494702e-13f  /* 0x2b800000 */
#define EXTENDED_LEARN_LARGEST_DENOMINATOR      16.8360367f  /* 0x4186b034 */
#define EXTENDED_LEARN_OUTLIER_RUN              0x00000008u
#define EXTENDED_LEARN_SETTLING                 0x00001000u
#define EXTENDED_LEARN_SETTLED                  0x00002000u
#define EXTENDED_LEARN_REFRESH_EVERY            0x00000008u
#define EXTENDED_LEARN_WINDOW                   0x00020000u
#define EXTENDED_LEARN_INFLATE_FIRST                   1.0f  /* 0x3f800000 */
#define EXTENDED_LEARN_INFLATE                  1.00010002f  /* 0x3f800347 */
#define EXTENDED_LEARN_PER_Y                          0.25f  /* 0x3e800000 */
#define EXTENDED_LEARN_PER_U                          0.25f  /* 0x3e800000 */

/* Learner, per parameter: theta per number in the bank, and back; D(0) and largest D; what puts the prior
 * back; powers of two that scale the regressors. */

EXTENDED_TABLE
static const float extended_learn_scale[EXTENDED_LEARNED] = {
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

EXTENDED_TABLE
static const float extended_learn_per_scale[EXTENDED_LEARNED] = {
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

EXTENDED_TABLE
static const float extended_learn_prior[EXTENDED_LEARNED] = {
    3.16285623e-05f,  /* 0x3804a8e9 */
    3.16285623e-05f,  /* 0x3804a8e9 */
    1.97678514e-06f,  /* 0x3604a8e9 */
    2.69822012e-05f,  /* 0x37e257d6 */
    2.69822012e-05f,  /* 0x37e257d6 */
    1.68638758e-06f,  /* 0x35e257d6 */
    1.24608123e-05f,  /* 0x37510ec8 */
    1.24608123e-05f,  /* 0x37510ec8 */
    7.78800768e-07f,  /* 0x35510ec8 */
    1.24608123e-05f,  /* 0x37510ec8 */
    1.24608123e-05f,  /* 0x37510ec8 */
    7.78800768e-07f,  /* 0x35510ec8 */
    2.69822012e-05f,  /* 0x37e257d6 */
    2.69822012e-05f,  /* 0x37e257d6 */
    1.68638758e-06f,  /* 0x35e257d6 */
    3.16285623e-05f,  /* 0x3804a8e9 */
    3.16285623e-05f,  /* 0x3804a8e9 */
    1.97678514e-06f,  /* 0x3604a8e9 */
};

EXTENDED_TABLE
static const float extended_learn_ceiling[EXTENDED_LEARNED] = {
     6.4059248e-05f,  /* 0x3886578c */
     6.4059248e-05f,  /* 0x3886578c */
      4.003703e-06f,  /* 0x3686578c */
    5.46486881e-05f,  /* 0x38653695 */
    5.46486881e-05f,  /* 0x38653695 */
    3.41554301e-06f,  /* 0x36653695 */
    2.52376394e-05f,  /* 0x37d3b56b */
    2.52376394e-05f,  /* 0x37d3b56b */
    1.57735246e-06f,  /* 0x35d3b56b */
    2.52376394e-05f,  /* 0x37d3b56b */
    2.52376394e-05f,  /* 0x37d3b56b */
    1.57735246e-06f,  /* 0x35d3b56b */
    5.46486881e-05f,  /* 0x38653695 */
    5.46486881e-05f,  /* 0x38653695 */
    3.41554301e-06f,  /* 0x36653695 */
     6.4059248e-05f,  /* 0x3886578c */
     6.4059248e-05f,  /* 0x3886578c */
      4.003703e-06f,  /* 0x3686578c */
};

EXTENDED_TABLE
static const float extended_learn_refresh[EXTENDED_LEARNED] = {
        19.8970985f,  /* 0x419f2d42 */
        19.8970985f,  /* 0x419f2d42 */
        79.5883942f,  /* 0x429f2d42 */
        21.5422363f,  /* 0x41ac5680 */
        21.5422363f,  /* 0x41ac5680 */
        86.1689453f,  /* 0x42ac5680 */
        31.6997833f,  /* 0x41fd9928 */
        31.6997833f,  /* 0x41fd9928 */
        126.799133f,  /* 0x42fd9928 */
        31.6997833f,  /* 0x41fd9928 */
        31.6997833f,  /* 0x41fd9928 */
        126.799133f,  /* 0x42fd9928 */
        21.5422363f,  /* 0x41ac5680 */
        21.5422363f,  /* 0x41ac5680 */
        86.1689453f,  /* 0x42ac5680 */
        19.8970985f,  /* 0x419f2d42 */
        19.8970985f,  /* 0x419f2d42 */
        79.5883942f,  /* 0x429f2d42 */
};

EXTENDED_TABLE
static const float extended_learn_firing[EXTENDED_RULES] = {
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
#define EXTENDED_COMMIT_MATURE                0x00000400u
#define EXTENDED_COMMIT_HALF_UM             0.0483592413f  /* 0x3d461457 */
#define EXTENDED_COMMIT_GAIN_REMAINDER     0.00320476922f  /* 0x3b52071b */
#define EXTENDED_COMMIT_SLOPE_REMAINDER_1  0.00961430743f  /* 0x3c1d8554 */
#define EXTENDED_COMMIT_SLOPE_REMAINDER_3  0.00765666971f  /* 0x3bfae4cd */
#define EXTENDED_COMMIT_SIGN                         1.0f  /* 0x3f800000 */
#define EXTENDED_COMMIT_GAIN_FLOOR           0.010099683f  /* 0x3c257924 */
#define EXTENDED_COMMIT_GAIN_CEILING        0.0807974637f  /* 0x3da57924 */
#define EXTENDED_COMMIT_SLOPE_LIMIT          0.997449815f  /* 0x3f7f58df */

EXTENDED_TABLE
static const float extended_commit_unfold[EXTENDED_RULES] = {
        22.7598953f,  /* 0x41b61444 */
        3.08021688f,  /* 0x40452246 */
        1.13314843f,  /* 0x3f910b02 */
        1.13314843f,  /* 0x3f910b02 */
        3.08021688f,  /* 0x40452246 */
        22.7598953f,  /* 0x41b61444 */
};

EXTENDED_TABLE
static const float extended_commit_y[32] = {
    -0.00761956163f,  /* 0xbbf9ad84 */
      0.0881413147f,  /* 0x3db4836f */
       0.183902189f,  /* 0x3e3c50db */
       0.279663056f,  /* 0x3e8f2fff */
       0.375423938f,  /* 0x3ec03791 */
        0.47118482f,  /* 0x3ef13f23 */
       0.566945672f,  /* 0x3f11235a */
       0.662706554f,  /* 0x3f29a723 */
       0.758467436f,  /* 0x3f422aec */
       0.854228318f,  /* 0x3f5aaeb5 */
         0.9499892f,  /* 0x3f73327e */
        1.04575002f,  /* 0x3f85db23 */
        1.14151096f,  /* 0x3f921d08 */
        1.23727179f,  /* 0x3f9e5eec */
        1.33303273f,  /* 0x3faaa0d1 */
        1.42879355f,  /* 0x3fb6e2b5 */
        1.52455449f,  /* 0x3fc3249a */
        1.62031531f,  /* 0x3fcf667e */
        1.71607625f,  /* 0x3fdba863 */
        1.81183708f,  /* 0x3fe7ea47 */
        1.90759802f,  /* 0x3ff42c2c */
        2.00335884f,  /* 0x40003708 */
        2.09911966f,  /* 0x400657fa */
        2.19488049f,  /* 0x400c78ec */
        2.29064155f,  /* 0x401299df */
        2.38640237f,  /* 0x4018bad1 */
        2.48216319f,  /* 0x401edbc3 */
        2.57792401f,  /* 0x4024fcb5 */
        2.67368507f,  /* 0x402b1da8 */
         2.7694459f,  /* 0x40313e9a */
        2.86520672f,  /* 0x40375f8c */
        2.96096754f,  /* 0x403d807e */
};

EXTENDED_TABLE
static const float extended_commit_table[576] = {
          12.44699f,  /* 0x414726df */
        1.10473323f,  /* 0x3f8d67e6 */
      0.0980506465f,  /* 0x3dc8cec7 */
     0.00870248955f,  /* 0x3c0e94e3 */
    0.000772389816f,  /* 0x3a4a7a34 */
    6.85534906e-05f,  /* 0x388fc460 */
       -11.2873535f,  /* 0xc1349900 */
       0.800748706f,  /* 0x3f4cfdde */
       0.231056631f,  /* 0x3e6c9a1c */
      0.0347070172f,  /* 0x3d0e28f2 */
     0.00434070732f,  /* 0x3b8e3c7e */
    0.000497116242f,  /* 0x3a0250e8 */
        -5.3092556f,  /* 0xc0a9e56c */
      -0.799287915f,  /* 0xbf4c9e22 */
       0.422030449f,  /* 0x3ed81460 */
       0.127549022f,  /* 0x3e029c36 */
      0.0234294441f,  /* 0x3cbfef1b */
      0.0035192261f,  /* 0x3b66a2d1 */
        11.3442059f,  /* 0x413581de */
        1.17713344f,  /* 0x3f96ac4f */
       0.122145437f,  /* 0x3dfa2763 */
      0.0126744406f,  /* 0x3c4fa875 */
     0.00131516543f,  /* 0x3aac61a1 */
    0.000136468341f,  /* 0x390f18f1 */
       -11.7175331f,  /* 0xc13b7b04 */
       0.704819739f,  /* 0x3f346f11 */
       0.272436589f,  /* 0x3e8b7ccf */
      0.0489499122f,  /* 0x3d487fb4 */
     0.00722520938f,  /* 0x3becc173 */
    0.000972396112f,  /* 0x3a7ee866 */
       -3.60926056f,  /* 0xc066fe20 */
       -1.20838284f,  /* 0xbf9aac4a */
       0.438471407f,  /* 0x3ee07f53 */
       0.171494409f,  /* 0x3e2f9c3b */
      0.0378720202f,  /* 0x3d1b1fb1 */
     0.00673972676f,  /* 0x3bdcd8ed */
        10.2086086f,  /* 0x41235676 */
        1.23844481f,  /* 0x3f9e855c */
       0.150240391f,  /* 0x3e19d89e */
      0.0182262287f,  /* 0x3c954f2c */
     0.00221109227f,  /* 0x3b10e7f9 */
    0.000268235919f,  /* 0x398ca204 */
        -11.966794f,  /* 0xc13f77fd */
       0.568994343f,  /* 0x3f11a99d */
       0.314169347f,  /* 0x3ea0dace */
      0.0678522289f,  /* 0x3d8af61c */
      0.0118391784f,  /* 0x3c41f91d */
     0.00187392742f,  /* 0x3af59e92 */
       -1.54085231f,  /* 0xbfc53aa6 */
       -1.62726963f,  /* 0xbfd04a5f */
       0.427838951f,  /* 0x3edb0db5 */
       0.224802986f,  /* 0x3e6632c1 */
      0.0600202419f,  /* 0x3d75d7c9 */
      0.0126824016f,  /* 0x3c4fc9d9 */
         9.0590992f,  /* 0x4110f212 */
        1.28485358f,  /* 0x3fa47615 */
       0.182230979f,  /* 0x3e3a9ac2 */
      0.0258458499f,  /* 0x3cd3baad */
     0.00366572081f,  /* 0x3b703c97 */
     0.00051990978f,  /* 0x3a084a8e */
       -12.0035486f,  /* 0xc1400e89 */
       0.393989682f,  /* 0x3ec9b904 */
       0.353220165f,  /* 0x3eb4d946 */
      0.0922691301f,  /* 0x3dbcf799 */
      0.0190677866f,  /* 0x3c9c340c */
     0.00355270738f,  /* 0x3b68d48a */
       0.810729325f,  /* 0x3f4f8bf5 */
       -2.02001238f,  /* 0xc00147e2 */
       0.381016523f,  /* 0x3ec31499 */
       0.286334395f,  /* 0x3e929a6c */
      0.0930760577f,  /* 0x3dbe9ea9 */
      0.0234104954f,  /* 0x3cbfc75e */
        7.91714096f,  /* 0x40fd5938 */
        1.31279075f,  /* 0x3fa80987 */
       0.217682034f,  /* 0x3e5ee80a */
      0.0360952206f,  /* 0x3d13d895 */
     0.00598517433f,  /* 0x3bc41f48 */
    0.000992439222f,  /* 0x3a8214bc */
       -11.8066769f,  /* 0xc13ce826 */
       0.184300229f,  /* 0x3e3cb933 */
         0.3857449f,  /* 0x3ec5805b */
       0.122858204f,  /* 0x3dfb9d15 */
      0.0301377084f,  /* 0x3cf6e35b */
     0.00661665341f,  /* 0x3bd8d083 */
         3.3127768f,  /* 0x40540489 */
       -2.34435177f,  /* 0xc01609dc */
       0.290539891f,  /* 0x3e94c1a5 */
       0.353006124f,  /* 0x3eb4bd38 */
        0.14094907f,  /* 0x3e1054f4 */
      0.0423218012f,  /* 0x3d2d59a0 */
        6.80554628f,  /* 0x40d9c709 */
        1.31931543f,  /* 0x3fa8df54 */
       0.255760968f,  /* 0x3e82f31a */
       0.049581524f,  /* 0x3d4b15ff */
     0.00961181708f,  /* 0x3c1d7ae2 */
     0.00186333561f,  /* 0x3af43b2b */
       -11.3697176f,  /* 0xc135ea5d */
     -0.0514350943f,  /* 0xbd52ad9b */
       0.407345921f,  /* 0x3ed08fa5 */
       0.159868211f,  /* 0x3e23b47e */
      0.0466751643f,  /* 0x3d3f2e75 */
      0.0120887393f,  /* 0x3c460fd9 */
        5.79415894f,  /* 0x40b969c0 */
       -2.55706978f,  /* 0xc023a708 */
       0.152673319f,  /* 0x3e1c5665 */
       0.419297963f,  /* 0x3ed6ae39 */
       0.208011463f,  /* 0x3e5500f5 */
      0.0748136491f,  /* 0x3d9937e6 */
        5.74692345f,  /* 0x40b7e6cc */
        1.30250549f,  /* 0x3fa6b880 */
       0.295204967f,  /* 0x3e97251b */
      0.0669064224f,  /* 0x3d89063c */
      0.0151639357f,  /* 0x3c787228 */
      0.0034368143f,  /* 0x3b613c2d */
        -10.703721f,  /* 0xc12b4271 */
      -0.300676554f,  /* 0xbe99f247 */
       0.413530111f,  /* 0x3ed3ba38 */
       0.202893198f,  /* 0x3e4fc33c */
       0.070727028f,  /* 0x3d90d955 */
      0.0216375943f,  /* 0x3cb14153 */
        8.06425095f,  /* 0x4101072c */
        -2.6212101f,  /* 0xc027c1e8 */
     -0.0305298809f,  /* 0xbcfa19cd */
       0.477061689f,  /* 0x3ef4416e */
       0.298557699f,  /* 0x3e98dc8e */
        0.12912707f,  /* 0x3e0439e3 */
        4.76194763f,  /* 0x409861e0 */
        1.26179051f,  /* 0x3fa1825a */
       0.334341198f,  /* 0x3eab2ec5 */
       0.088591598f,  /* 0x3db56f83 */
      0.0234744381f,  /* 0x3cc04d77 */
      0.0062201065f,  /* 0x3bcbd209 */
       -9.83788013f,  /* 0xc11d67f5 */
      -0.547955096f,  /* 0xbf0c46c9 */
       0.400340348f,  /* 0x3eccf969 */
        0.25063175f,  /* 0x3e8052ce */
       0.104713298f,  /* 0x3dd673ed */
       0.037895415f,  /* 0x3d1b3839 */
        9.93950844f,  /* 0x411f083a */
       -2.51377249f,  /* 0xc020e1a6 */
       -0.24976857f,  /* 0xbe7fc355 */
        0.51585263f,  /* 0x3f040eeb */
       0.415905148f,  /* 0x3ed4f185 */
       0.217309341f,  /* 0x3e5e8657 */
        3.86770177f,  /* 0x4077886d */
        1.19815814f,  /* 0x3f995d3f */
       0.371172071f,  /* 0x3ebe0a44 */
       0.114983745f,  /* 0x3deb7c99 */
       0.035620302f,  /* 0x3d11e698 */
      0.0110346545f,  /* 0x3c34cab2 */
       -8.81746483f,  /* 0xc10d1456 */
      -0.776526332f,  /* 0xbf46ca6e */
       0.365073115f,  /* 0x3ebaeadd */
       0.300709724f,  /* 0x3e99f6a0 */
       0.151276052f,  /* 0x3e1ae81c */
      0.0648680329f,  /* 0x3d84d988 */
          11.27248f,  /* 0x41345c14 */
       -2.23192215f,  /* 0xc00ed7d0 */
      -0.488247603f,  /* 0xbef9fb97 */
       0.523939073f,  /* 0x3f0620df */
        0.56114006f,  /* 0x3f0fa6e0 */
       0.356141299f,  /* 0x3eb65827 */
        3.07634258f,  /* 0x4044e2cc */
        1.11417747f,  /* 0x3f8e9d5e */
       0.403528333f,  /* 0x3ece9b44 */
       0.146148279f,  /* 0x3e15a7e5 */
      0.0529313982f,  /* 0x3d58ce98 */
      0.0191704817f,  /* 0x3c9d0b6a */
       -7.69912004f,  /* 0xc0f65f31 */
      -0.970468342f,  /* 0xbf78709d */
       0.306944102f,  /* 0x3e9d27c7 */
       0.349633306f,  /* 0x3eb30323 */
       0.212995291f,  /* 0x3e5a1b70 */
       0.108421646f,  /* 0x3dde0c2b */
        11.9762659f,  /* 0x413f9ec9 */
       -1.79577029f,  /* 0xbfe5dbcd */
      -0.723053336f,  /* 0xbf391a06 */
       0.490002036f,  /* 0x3efae18c */
       0.731620848f,  /* 0x3f3b4b81 */
       0.567753494f,  /* 0x3f11584b */
        2.39431381f,  /* 0x40193c70 */
        1.01381624f,  /* 0x3f81c4bb */
       0.429276824f,  /* 0x3edbca2c */
        0.18176724f,  /* 0x3e3a2131 */
      0.0769650936f,  /* 0x3d9d9fe0 */
      0.0325890705f,  /* 0x3d057c1e */
        -6.5443244f,  /* 0xc0d16b1b */
        -1.1168294f,  /* 0xbf8ef444 */
       0.227542087f,  /* 0x3e6900cb */
       0.392931253f,  /* 0x3ec92e49 */
       0.291959077f,  /* 0x3e957ba9 */
       0.176797807f,  /* 0x3e350a7c */
        12.0379486f,  /* 0x41409b70 */
       -1.24652779f,  /* 0xbf9f8e39 */
       -0.92814821f,  /* 0xbf6d9b1f */
       0.405337811f,  /* 0x3ecf8870 */
       0.919484258f,  /* 0x3f6b6352 */
       0.879521668f,  /* 0x3f612855 */
         1.8222276f,  /* 0x3fe93ec1 */
       0.902068138f,  /* 0x3f66edf0 */
       0.446556091f,  /* 0x3ee4a300 */
       0.221061304f,  /* 0x3e625de5 */
       0.109433278f,  /* 0x3de01e8e */
      0.0541733988f,  /* 0x3d5de4ed */
       -5.41223764f,  /* 0xc0ad310d */
         -1.207376f,  /* 0xbf9a8b4c */
       0.130937055f,  /* 0x3e06145d */
       0.425517291f,  /* 0x3ed9dd67 */
       0.389205158f,  /* 0x3ec745e6 */
       0.281063557f,  /* 0x3e8fe790 */
        11.5174265f,  /* 0x41384761 */
      -0.640148401f,  /* 0xbf23e0c4 */
       -1.07848966f,  /* 0xbf8a0bf3 */
       0.266174376f,  /* 0x3e884802 */
        1.11052465f,  /* 0x3f8e25ac */
        1.32272649f,  /* 0x3fa94f1a */
        1.35540164f,  /* 0x3fad7dcd */
       0.784446359f,  /* 0x3f48d17a */
       0.454002708f,  /* 0x3ee8730b */
       0.262756616f,  /* 0x3e868809 */
       0.152071863f,  /* 0x3e1bb8ba */
      0.0880124345f,  /* 0x3db43fdd */
       -4.35335112f,  /* 0xc08b4ea7 */
        -1.2395699f,  /* 0xbf9eaa3a */
      0.0233738441f,  /* 0x3cbf7a81 */
       0.442259401f,  /* 0x3ee26fd3 */
       0.504090965f,  /* 0x3f010c1b */
       0.435352564f,  /* 0x3edee688 */
        10.5323668f,  /* 0x41288493 */
     -0.0379323326f,  /* 0xbd1b5eef */
       -1.15438724f,  /* 0xbf93c2f6 */
      0.0755854249f,  /* 0x3d9acc88 */
         1.2838968f,  /* 0x3fa456bb */
        1.92944539f,  /* 0x3ff6f811 */
       0.984919369f,  /* 0x3f7c23ad */
       0.666429818f,  /* 0x3f2a9b25 */
       0.450928956f,  /* 0x3ee6e029 */
       0.305113792f,  /* 0x3e9c37e0 */
       0.206450313f,  /* 0x3e5367b6 */
       0.139691263f,  /* 0x3e0f0b3a */
        -3.4050703f,  /* 0xc059ecac */
        -1.2165935f,  /* 0xbf9bb956 */
       -0.08742176f,  /* 0xbdb30a2e */
       0.438692033f,  /* 0x3ee09c3e */
       0.633692324f,  /* 0x3f2239a9 */
       0.656707525f,  /* 0x3f281dfc */
        9.23391819f,  /* 0x4113be21 */
       0.503563285f,  /* 0x3f00e986 */
       -1.14508569f,  /* 0xbf92922b */
       -0.15552114f,  /* 0xbe1f40ef */
        1.41307938f,  /* 0x3fb4dfc9 */
         2.7272892f,  /* 0x402e8be8 */
       0.698995173f,  /* 0x3f32f159 */
        0.55295068f,  /* 0x3f0d8e2d */
       0.437420011f,  /* 0x3edff584 */
       0.346027702f,  /* 0x3eb12a8b */
       0.273730457f,  /* 0x3e8c2666 */
       0.216538608f,  /* 0x3e5dbc4c */
       -2.58980322f,  /* 0xc025bf56 */
       -1.14647079f,  /* 0xbf92bf8e */
      -0.193208635f,  /* 0xbe45d87c */
        0.41176188f,  /* 0x3ed2d274 */
       0.772367775f,  /* 0x3f45b9e5 */
       0.964312375f,  /* 0x3f76dd2d */
        7.77986097f,  /* 0x40f8f49f */
       0.940912485f,  /* 0x3f70dfa4 */
       -1.05074346f,  /* 0xbf867ec3 */
      -0.408732861f,  /* 0xbed1456f */
        1.46839797f,  /* 0x3fbbf477 */
        3.73197484f,  /* 0x406ed8ad */
       0.484403759f,  /* 0x3ef803c5 */
       0.448000252f,  /* 0x3ee5604a */
       0.414332509f,  /* 0x3ed42364 */
       0.383194923f,  /* 0x3ec43220 */
       0.354397357f,  /* 0x3eb57392 */
       0.327763975f,  /* 0x3ea7d0ae */
       -1.91547942f,  /* 0xbff52e6e */
       -1.04054105f,  /* 0xbf853073 */
      -0.286289841f,  /* 0xbe929495 */
       0.360472262f,  /* 0x3eb88fd2 */
       0.911641359f,  /* 0x3f696154 */
        1.37793255f,  /* 0x3fb06018 */
        6.31149912f,  /* 0x40c9f7cd */
        1.24881697f,  /* 0x3f9fd93c */
      -0.882388055f,  /* 0xbf61e42f */
      -0.659929037f,  /* 0xbf28f11c */
        1.42113125f,  /* 0x3fb5e7a1 */
        4.93836975f,  /* 0x409e0720 */
       0.327763975f,  /* 0x3ea7d0ae */
       0.354397357f,  /* 0x3eb57392 */
       0.383194923f,  /* 0x3ec43220 */
       0.414332509f,  /* 0x3ed42364 */
       0.448000252f,  /* 0x3ee5604a */
       0.484403759f,  /* 0x3ef803c5 */
       -1.37793255f,  /* 0xbfb06018 */
      -0.911641359f,  /* 0xbf696154 */
      -0.360472262f,  /* 0xbeb88fd2 */
       0.286289841f,  /* 0x3e929495 */
        1.04054105f,  /* 0x3f853073 */
        1.91547942f,  /* 0x3ff52e6e */
        4.93836975f,  /* 0x409e0720 */
        1.42113125f,  /* 0x3fb5e7a1 */
      -0.659929037f,  /* 0xbf28f11c */
      -0.882388055f,  /* 0xbf61e42f */
        1.24881697f,  /* 0x3f9fd93c */
        6.31149912f,  /* 0x40c9f7cd */
       0.216538608f,  /* 0x3e5dbc4c */
       0.273730457f,  /* 0x3e8c2666 */
       0.346027702f,  /* 0x3eb12a8b */
       0.437420011f,  /* 0x3edff584 */
        0.55295068f,  /* 0x3f0d8e2d */
       0.698995173f,  /* 0x3f32f159 */
      -0.964312375f,  /* 0xbf76dd2d */
      -0.772367775f,  /* 0xbf45b9e5 */
       -0.41176188f,  /* 0xbed2d274 */
       0.193208635f,  /* 0x3e45d87c */
        1.14647079f,  /* 0x3f92bf8e */
        2.58980322f,  /* 0x4025bf56 */
        3.73197484f,  /* 0x406ed8ad */
        1.46839797f,  /* 0x3fbbf477 */
      -0.408732861f,  /* 0xbed1456f */
       -1.05074346f,  /* 0xbf867ec3 */
       0.940912485f,  /* 0x3f70dfa4 */
        7.77986097f,  /* 0x40f8f49f */
       0.139691263f,  /* 0x3e0f0b3a */
       0.206450313f,  /* 0x3e5367b6 */
       0.305113792f,  /* 0x3e9c37e0 */
       0.450928956f,  /* 0x3ee6e029 */
       0.666429818f,  /* 0x3f2a9b25 */
       0.984919369f,  /* 0x3f7c23ad */
      -0.656707525f,  /* 0xbf281dfc */
      -0.633692324f,  /* 0xbf2239a9 */
      -0.438692033f,  /* 0xbee09c3e */
        0.08742176f,  /* 0x3db30a2e */
         1.2165935f,  /* 0x3f9bb956 */
         3.4050703f,  /* 0x4059ecac */
         2.7272892f,  /* 0x402e8be8 */
        1.41307938f,  /* 0x3fb4dfc9 */
       -0.15552114f,  /* 0xbe1f40ef */
       -1.14508569f,  /* 0xbf92922b */
       0.503563285f,  /* 0x3f00e986 */
        9.23391819f,  /* 0x4113be21 */
      0.0880124345f,  /* 0x3db43fdd */
       0.152071863f,  /* 0x3e1bb8ba */
       0.262756616f,  /* 0x3e868809 */
       0.454002708f,  /* 0x3ee8730b */
       0.784446359f,  /* 0x3f48d17a */
        1.35540164f,  /* 0x3fad7dcd */
      -0.435352564f,  /* 0xbedee688 */
      -0.504090965f,  /* 0xbf010c1b */
      -0.442259401f,  /* 0xbee26fd3 */
     -0.0233738441f,  /* 0xbcbf7a81 */
         1.2395699f,  /* 0x3f9eaa3a */
        4.35335112f,  /* 0x408b4ea7 */
        1.92944539f,  /* 0x3ff6f811 */
         1.2838968f,  /* 0x3fa456bb */
      0.0755854249f,  /* 0x3d9acc88 */
       -1.15438724f,  /* 0xbf93c2f6 */
     -0.0379323326f,  /* 0xbd1b5eef */
        10.5323668f,  /* 0x41288493 */
      0.0541733988f,  /* 0x3d5de4ed */
       0.109433278f,  /* 0x3de01e8e */
       0.221061304f,  /* 0x3e625de5 */
       0.446556091f,  /* 0x3ee4a300 */
       0.902068138f,  /* 0x3f66edf0 */
         1.8222276f,  /* 0x3fe93ec1 */
      -0.281063557f,  /* 0xbe8fe790 */
      -0.389205158f,  /* 0xbec745e6 */
      -0.425517291f,  /* 0xbed9dd67 */
      -0.130937055f,  /* 0xbe06145d */
          1.207376f,  /* 0x3f9a8b4c */
        5.41223764f,  /* 0x40ad310d */
        1.32272649f,  /* 0x3fa94f1a */
        1.11052465f,  /* 0x3f8e25ac */
       0.266174376f,  /* 0x3e884802 */
       -1.07848966f,  /* 0xbf8a0bf3 */
      -0.640148401f,  /* 0xbf23e0c4 */
        11.5174265f,  /* 0x41384761 */
      0.0325890705f,  /* 0x3d057c1e */
      0.0769650936f,  /* 0x3d9d9fe0 */
        0.18176724f,  /* 0x3e3a2131 */
       0.429276824f,  /* 0x3edbca2c */
        1.01381624f,  /* 0x3f81c4bb */
        2.39431381f,  /* 0x40193c70 */
      -0.176797807f,  /* 0xbe350a7c */
      -0.291959077f,  /* 0xbe957ba9 */
      -0.392931253f,  /* 0xbec92e49 */
      -0.227542087f,  /* 0xbe6900cb */
         1.1168294f,  /* 0x3f8ef444 */
         6.5443244f,  /* 0x40d16b1b */
       0.879521668f,  /* 0x3f612855 */
       0.919484258f,  /* 0x3f6b6352 */
       0.405337811f,  /* 0x3ecf8870 */
       -0.92814821f,  /* 0xbf6d9b1f */
       -1.24652779f,  /* 0xbf9f8e39 */
        12.0379486f,  /* 0x41409b70 */
      0.0191704817f,  /* 0x3c9d0b6a */
      0.0529313982f,  /* 0x3d58ce98 */
       0.146148279f,  /* 0x3e15a7e5 */
       0.403528333f,  /* 0x3ece9b44 */
        1.11417747f,  /* 0x3f8e9d5e */
        3.07634258f,  /* 0x4044e2cc */
      -0.108421646f,  /* 0xbdde0c2b */
      -0.212995291f,  /* 0xbe5a1b70 */
      -0.349633306f,  /* 0xbeb30323 */
      -0.306944102f,  /* 0xbe9d27c7 */
       0.970468342f,  /* 0x3f78709d */
        7.69912004f,  /* 0x40f65f31 */
       0.567753494f,  /* 0x3f11584b */
       0.731620848f,  /* 0x3f3b4b81 */
       0.490002036f,  /* 0x3efae18c */
      -0.723053336f,  /* 0xbf391a06 */
       -1.79577029f,  /* 0xbfe5dbcd */
        11.9762659f,  /* 0x413f9ec9 */
      0.0110346545f,  /* 0x3c34cab2 */
       0.035620302f,  /* 0x3d11e698 */
       0.114983745f,  /* 0x3deb7c99 */
       0.371172071f,  /* 0x3ebe0a44 */
        1.19815814f,  /* 0x3f995d3f */
        3.86770177f,  /* 0x4077886d */
     -0.0648680329f,  /* 0xbd84d988 */
      -0.151276052f,  /* 0xbe1ae81c */
      -0.300709724f,  /* 0xbe99f6a0 */
      -0.365073115f,  /* 0xbebaeadd */
       0.776526332f,  /* 0x3f46ca6e */
        8.81746483f,  /* 0x410d1456 */
       0.356141299f,  /* 0x3eb65827 */
        0.56114006f,  /* 0x3f0fa6e0 */
       0.523939073f,  /* 0x3f0620df */
      -0.488247603f,  /* 0xbef9fb97 */
       -2.23192215f,  /* 0xc00ed7d0 */
          11.27248f,  /* 0x41345c14 */
      0.0062201065f,  /* 0x3bcbd209 */
      0.0234744381f,  /* 0x3cc04d77 */
       0.088591598f,  /* 0x3db56f83 */
       0.334341198f,  /* 0x3eab2ec5 */
        1.26179051f,  /* 0x3fa1825a */
        4.76194763f,  /* 0x409861e0 */
      -0.037895415f,  /* 0xbd1b3839 */
      -0.104713298f,  /* 0xbdd673ed */
       -0.25063175f,  /* 0xbe8052ce */
      -0.400340348f,  /* 0xbeccf969 */
       0.547955096f,  /* 0x3f0c46c9 */
        9.83788013f,  /* 0x411d67f5 */
       0.217309341f,  /* 0x3e5e8657 */
       0.415905148f,  /* 0x3ed4f185 */
        0.51585263f,  /* 0x3f040eeb */
       -0.24976857f,  /* 0xbe7fc355 */
       -2.51377249f,  /* 0xc020e1a6 */
        9.93950844f,  /* 0x411f083a */
      0.0034368143f,  /* 0x3b613c2d */
      0.0151639357f,  /* 0x3c787228 */
      0.0669064224f,  /* 0x3d89063c */
       0.295204967f,  /* 0x3e97251b */
        1.30250549f,  /* 0x3fa6b880 */
        5.74692345f,  /* 0x40b7e6cc */
     -0.0216375943f,  /* 0xbcb14153 */
      -0.070727028f,  /* 0xbd90d955 */
      -0.202893198f,  /* 0xbe4fc33c */
      -0.413530111f,  /* 0xbed3ba38 */
       0.300676554f,  /* 0x3e99f247 */
         10.703721f,  /* 0x412b4271 */
        0.12912707f,  /* 0x3e0439e3 */
       0.298557699f,  /* 0x3e98dc8e */
       0.477061689f,  /* 0x3ef4416e */
     -0.0305298809f,  /* 0xbcfa19cd */
        -2.6212101f,  /* 0xc027c1e8 */
        8.06425095f,  /* 0x4101072c */
     0.00186333561f,  /* 0x3af43b2b */
     0.00961181708f,  /* 0x3c1d7ae2 */
       0.049581524f,  /* 0x3d4b15ff */
       0.255760968f,  /* 0x3e82f31a */
        1.31931543f,  /* 0x3fa8df54 */
        6.80554628f,  /* 0x40d9c709 */
     -0.0120887393f,  /* 0xbc460fd9 */
     -0.0466751643f,  /* 0xbd3f2e75 */
      -0.159868211f,  /* 0xbe23b47e */
      -0.407345921f,  /* 0xbed08fa5 */
      0.0514350943f,  /* 0x3d52ad9b */
        11.3697176f,  /* 0x4135ea5d */
      0.0748136491f,  /* 0x3d9937e6 */
       0.208011463f,  /* 0x3e5500f5 */
       0.419297963f,  /* 0x3ed6ae39 */
       0.152673319f,  /* 0x3e1c5665 */
       -2.55706978f,  /* 0xc023a708 */
        5.79415894f,  /* 0x40b969c0 */
    0.000992439222f,  /* 0x3a8214bc */
     0.00598517433f,  /* 0x3bc41f48 */
      0.0360952206f,  /* 0x3d13d895 */
       0.217682034f,  /* 0x3e5ee80a */
        1.31279075f,  /* 0x3fa80987 */
        7.91714096f,  /* 0x40fd5938 */
    -0.00661665341f,  /* 0xbbd8d083 */
     -0.0301377084f,  /* 0xbcf6e35b */
      -0.122858204f,  /* 0xbdfb9d15 */
        -0.3857449f,  /* 0xbec5805b */
      -0.184300229f,  /* 0xbe3cb933 */
        11.8066769f,  /* 0x413ce826 */
      0.0423218012f,  /* 0x3d2d59a0 */
        0.14094907f,  /* 0x3e1054f4 */
       0.353006124f,  /* 0x3eb4bd38 */
       0.290539891f,  /* 0x3e94c1a5 */
       -2.34435177f,  /* 0xc01609dc */
         3.3127768f,  /* 0x40540489 */
     0.00051990978f,  /* 0x3a084a8e */
     0.00366572081f,  /* 0x3b703c97 */
      0.0258458499f,  /* 0x3cd3baad */
       0.182230979f,  /* 0x3e3a9ac2 */
        1.28485358f,  /* 0x3fa47615 */
         9.0590992f,  /* 0x4110f212 */
    -0.00355270738f,  /* 0xbb68d48a */
     -0.0190677866f,  /* 0xbc9c340c */
     -0.0922691301f,  /* 0xbdbcf799 */
      -0.353220165f,  /* 0xbeb4d946 */
      -0.393989682f,  /* 0xbec9b904 */
        12.0035486f,  /* 0x41400e89 */
      0.0234104954f,  /* 0x3cbfc75e */
      0.0930760577f,  /* 0x3dbe9ea9 */
       0.286334395f,  /* 0x3e929a6c */
       0.381016523f,  /* 0x3ec31499 */
       -2.02001238f,  /* 0xc00147e2 */
       0.810729325f,  /* 0x3f4f8bf5 */
    0.000268235919f,  /* 0x398ca204 */
     0.00221109227f,  /* 0x3b10e7f9 */
      0.0182262287f,  /* 0x3c954f2c */
       0.150240391f,  /* 0x3e19d89e */
        1.23844481f,  /* 0x3f9e855c */
        10.2086086f,  /* 0x41235676 */
    -0.00187392742f,  /* 0xbaf59e92 */
     -0.0118391784f,  /* 0xbc41f91d */
     -0.0678522289f,  /* 0xbd8af61c */
      -0.314169347f,  /* 0xbea0dace */
      -0.568994343f,  /* 0xbf11a99d */
         11.966794f,  /* 0x413f77fd */
      0.0126824016f,  /* 0x3c4fc9d9 */
      0.0600202419f,  /* 0x3d75d7c9 */
       0.224802986f,  /* 0x3e6632c1 */
       0.427838951f,  /* 0x3edb0db5 */
       -1.62726963f,  /* 0xbfd04a5f */
       -1.54085231f,  /* 0xbfc53aa6 */
    0.000136468341f,  /* 0x390f18f1 */
     0.00131516543f,  /* 0x3aac61a1 */
      0.0126744406f,  /* 0x3c4fa875 */
       0.122145437f,  /* 0x3dfa2763 */
        1.17713344f,  /* 0x3f96ac4f */
        11.3442059f,  /* 0x413581de */
    -0.000972396112f,  /* 0xba7ee866 */
    -0.00722520938f,  /* 0xbbecc173 */
     -0.0489499122f,  /* 0xbd487fb4 */
      -0.272436589f,  /* 0xbe8b7ccf */
      -0.704819739f,  /* 0xbf346f11 */
        11.7175331f,  /* 0x413b7b04 */
     0.00673972676f,  /* 0x3bdcd8ed */
      0.0378720202f,  /* 0x3d1b1fb1 */
       0.171494409f,  /* 0x3e2f9c3b */
       0.438471407f,  /* 0x3ee07f53 */
       -1.20838284f,  /* 0xbf9aac4a */
       -3.60926056f,  /* 0xc066fe20 */
    6.85534906e-05f,  /* 0x388fc460 */
    0.000772389816f,  /* 0x3a4a7a34 */
     0.00870248955f,  /* 0x3c0e94e3 */
      0.0980506465f,  /* 0x3dc8cec7 */
        1.10473323f,  /* 0x3f8d67e6 */
          12.44699f,  /* 0x414726df */
    -0.000497116242f,  /* 0xba0250e8 */
    -0.00434070732f,  /* 0xbb8e3c7e */
     -0.0347070172f,  /* 0xbd0e28f2 */
      -0.231056631f,  /* 0xbe6c9a1c */
      -0.800748706f,  /* 0xbf4cfdde */
        11.2873535f,  /* 0x41349900 */
      0.0035192261f,  /* 0x3b66a2d1 */
      0.0234294441f,  /* 0x3cbfef1b */
       0.127549022f,  /* 0x3e029c36 */
       0.422030449f,  /* 0x3ed81460 */
      -0.799287915f,  /* 0xbf4c9e22 */
        -5.3092556f,  /* 0xc0a9e56c */
};

#endif

#ifdef EXTENDED_SELFTEST_NUMBERS

/* Self-test: where each function starts, what it is given, and the bits that the float32 reference answers. */

/* predict: arguments, expected result. */
#define EXTENDED_SELFTEST_PREDICT_START_Y 0x3fbd03a8u
#define EXTENDED_SELFTEST_PREDICT_START_U 0x00000000u
#define EXTENDED_SELFTEST_PREDICT_STATUS 0x0000000fu
#define EXTENDED_SELFTEST_PREDICT_Y_CLAMPED 2u
#define EXTENDED_SELFTEST_PREDICT_U_CLAMPED 6u
#define EXTENDED_SELFTEST_PREDICT_Y_REJECTED 3u
#define EXTENDED_SELFTEST_PREDICT_U_REJECTED 3u

EXTENDED_TABLE
static const uint32_t extended_selftest_predict_rows[32][3] = {
    { 0x3fc9aa59u, 0x41e48b5bu, 0x3fc70512u },  /* 1.57551, 28.568 -> 1.55484 */
    { 0x3fd536beu, 0x423deedau, 0x3fd28064u },  /* 1.66573, 47.4833 -> 1.64454 */
    { 0x000116c2u, 0xf149f2cau, 0x3cbe477au },  /* 9.99995e-41, -1e+30 -> 0.0232274 */
    { 0x402659ecu, 0x4259af64u, 0x4025680du },  /* 2.59924, 54.4213 -> 2.58448 */
    { 0x3f7ab11fu, 0x422527b2u, 0x3f7aea23u },  /* 0.979265, 41.2888 -> 0.980135 */
    { 0x7fc00000u, 0xff800000u, 0x3f81c065u },  /* nan, -inf -> 1.01368 */
    { 0x4009928au, 0x41c6aa14u, 0x400969a3u },  /* 2.14957, 24.833 -> 2.14707 */
    { 0x4031be4du, 0x42434ea7u, 0x40307bcdu },  /* 2.77724, 48.8268 -> 2.75756 */
    { 0x00000000u, 0x41b00000u, 0x3cc44683u },  /* 0, 22 -> 0.0239594 */
    { 0x3fadec4fu, 0x4224b20au, 0x3fafa7f0u },  /* 1.35877, 41.1739 -> 1.37231 */
    { 0x3fa39dbbu, 0x423230ecu, 0x3fa29809u },  /* 1.27825, 44.5478 -> 1.27026 */
    { 0x40c2579fu, 0x7fc00000u, 0x403f1a78u },  /* 6.0732, nan -> 2.98599 */
    { 0x3f9c46e3u, 0x423b3295u, 0x3f9e7c37u },  /* 1.22091, 46.7994 -> 1.23817 */
    { 0x400d0d12u, 0x42088e9fu, 0x400ced5eu },  /* 2.20392, 34.1393 -> 2.20199 */
    { 0x404090f7u, 0x42600000u, 0x403f59b9u },  /* 3.00885, 56 -> 2.98985 */
    { 0x3fbb20d3u, 0x42475c3du, 0x3fbbd9bbu },  /* 1.46194, 49.8401 -> 1.46758 */
    { 0x3f849d4fu, 0x41fa165eu, 0x3f8969e8u },  /* 1.03605, 31.2609 -> 1.07354 */
    { 0x80000000u, 0xc1400000u, 0x3d46b098u },  /* -0, -12 -> 0.0485083 */
    { 0x4016bfd0u, 0x41dbd9c8u, 0x40153b77u },  /* 2.35546, 27.4813 -> 2.33175 */
    { 0x3faff3cau, 0x4230c83eu, 0x3fae1b2bu },  /* 1.37463, 44.1955 -> 1.3602 */
    { 0xf149f2cau, 0x000116c2u, 0xbd041412u },  /* -1e+30, 9.99995e-41 -> -0.0322457 */
    { 0x3fc402dbu, 0x4259a513u, 0x3fc470f1u },  /* 1.53134, 54.4112 -> 1.5347 */
    { 0x402225d2u, 0x41e16398u, 0x40203410u },  /* 2.53356, 28.1736 -> 2.50318 */
    { 0xff800000u, 0x7f800000u, 0x40201b2eu },  /* -inf, inf -> 2.50166 */
    { 0x3fa2b070u, 0x425d96b0u, 0x3fa226a1u },  /* 1.27101, 55.3972 -> 1.2668 */
    { 0x3fa12360u, 0x424deac5u, 0x3fa1688eu },  /* 1.25889, 51.4793 -> 1.261 */
    { 0x7f800000u, 0x80000000u, 0x3fa59864u },  /* inf, -0 -> 1.29371 */
    { 0x3fa30f0du, 0x41e75c7cu, 0x3fa5df97u },  /* 1.2739, 28.9202 -> 1.29589 */
    { 0x3fae5207u, 0x424fae67u, 0x3fac91fcu },  /* 1.36188, 51.9203 -> 1.34821 */
    { 0xbd6353f8u, 0x00000000u, 0xbcead3acu },  /* -0.0555, 0 -> -0.0286654 */
    { 0x403b6343u, 0x424421acu, 0x403a67e1u },  /* 2.92793, 49.0329 -> 2.91259 */
    { 0x3dee11dcu, 0x41b8c525u, 0x3e09106fu },  /* 0.116245, 23.0963 -> 0.133852 */
};

/* simulate: arguments, expected result. */
#define EXTENDED_SELFTEST_SIMULATE_START_Y 0x3fbd03a8u
#define EXTENDED_SELFTEST_SIMULATE_START_U 0x00000000u
#define EXTENDED_SELFTEST_SIMULATE_STATUS 0x0000000au
#define EXTENDED_SELFTEST_SIMULATE_Y_CLAMPED 0u
#define EXTENDED_SELFTEST_SIMULATE_U_CLAMPED 7u
#define EXTENDED_SELFTEST_SIMULATE_Y_REJECTED 0u
#define EXTENDED_SELFTEST_SIMULATE_U_REJECTED 2u

EXTENDED_TABLE
static const uint32_t extended_selftest_simulate_rows[32][2] = {
    { 0x4238cbd0u, 0x3fba9fceu },  /* 46.199 -> 1.458 */
    { 0x41d5633du, 0x3fb8f115u },  /* 26.6735 -> 1.44486 */
    { 0xc1400000u, 0x3fba04b0u },  /* -12 -> 1.45327 */
    { 0x423003bcu, 0x3fb8670du },  /* 44.0036 -> 1.44064 */
    { 0x422814fcu, 0x3fb6e72bu },  /* 42.0205 -> 1.42893 */
    { 0x000116c2u, 0x3fb84a5eu },  /* 9.99995e-41 -> 1.43977 */
    { 0x420b023au, 0x3fb8d6eeu },  /* 34.7522 -> 1.44406 */
    { 0x42237aa1u, 0x3fb70aa2u },  /* 40.8698 -> 1.43001 */
    { 0xf149f2cau, 0x3fb705e0u },  /* -1e+30 -> 1.42987 */
    { 0x42128c9bu, 0x3fb73383u },  /* 36.6373 -> 1.43126 */
    { 0x41d9d1a0u, 0x3fb5807bu },  /* 27.2274 -> 1.41798 */
    { 0x42b40000u, 0x3fb54e1au },  /* 90 -> 1.41645 */
    { 0x41f12613u, 0x3fb4def6u },  /* 30.1436 -> 1.41305 */
    { 0x42224f0fu, 0x3fb7d73fu },  /* 40.5772 -> 1.43626 */
    { 0x42600000u, 0x3fb7b05du },  /* 56 -> 1.43507 */
    { 0x42104aaeu, 0x3fb94d07u },  /* 36.0729 -> 1.44766 */
    { 0x41db8135u, 0x3fbc70d4u },  /* 27.4381 -> 1.47219 */
    { 0x80000000u, 0x3fbca167u },  /* -0 -> 1.47368 */
    { 0x41d17e14u, 0x3fbb36d6u },  /* 26.1866 -> 1.46261 */
    { 0x42433be9u, 0x3fb91393u },  /* 48.8085 -> 1.44591 */
    { 0xff800000u, 0x3fb82073u },  /* -inf -> 1.43849 */
    { 0x42049220u, 0x3fba9ad4u },  /* 33.1427 -> 1.45785 */
    { 0x42476b63u, 0x3fbc98e8u },  /* 49.8549 -> 1.47342 */
    { 0x7fc00000u, 0x3fbd1259u },  /* nan -> 1.47712 */
    { 0x42434d4fu, 0x3fbfac57u },  /* 48.8255 -> 1.49745 */
    { 0x41dd9852u, 0x3fc2322du },  /* 27.6994 -> 1.51716 */
    { 0x41b00000u, 0x3fc3f310u },  /* 22 -> 1.53086 */
    { 0x425ecf6eu, 0x3fc26ae4u },  /* 55.7026 -> 1.51889 */
    { 0x420c4ceau, 0x3fc137e0u },  /* 35.0751 -> 1.50952 */
    { 0x00000000u, 0x3fc41ad5u },  /* 0 -> 1.53207 */
    { 0x41b381d0u, 0x3fc3c475u },  /* 22.4384 -> 1.52943 */
    { 0x4253ef26u, 0x3fc14aa8u },  /* 52.9835 -> 1.51009 */
};

/* inverse: arguments, expected result. */
#define EXTENDED_SELFTEST_INVERSE_START_Y 0x3fbd03a8u
#define EXTENDED_SELFTEST_INVERSE_START_U 0x00000000u
#define EXTENDED_SELFTEST_INVERSE_STATUS 0x00000037u
#define EXTENDED_SELFTEST_INVERSE_Y_CLAMPED 2u
#define EXTENDED_SELFTEST_INVERSE_U_CLAMPED 1u
#define EXTENDED_SELFTEST_INVERSE_Y_REJECTED 5u
#define EXTENDED_SELFTEST_INVERSE_U_REJECTED 0u

EXTENDED_TABLE
static const uint32_t extended_selftest_inverse_rows[32][3] = {
    { 0x402b6785u, 0x4028a7f3u, 0x41b00000u },  /* 2.67819, 2.63525 -> 22 */
    { 0x3f46587au, 0x3f4531e9u, 0x41b00000u },  /* 0.774788, 0.770293 -> 22 */
    { 0x404090f7u, 0xbd6353f8u, 0x41b00000u },  /* 3.00885, -0.0555 -> 22 */
    { 0x3e999ee3u, 0x3e9c3aabu, 0x41b00000u },  /* 0.30004, 0.305135 -> 22 */
    { 0x3ed2017bu, 0x3ed379b2u, 0x41b00000u },  /* 0.410168, 0.413038 -> 22 */
    { 0xff800000u, 0x80000000u, 0x41b00000u },  /* -inf, -0 -> 22 */
    { 0x3ed4d3a2u, 0x3ed63d43u, 0x41b00000u },  /* 0.415677, 0.418436 -> 22 */
    { 0x3f11c175u, 0x3f11aad5u, 0x41b00010u },  /* 0.569358, 0.569013 -> 22 */
    { 0x80000000u, 0xf149f2cau, 0x41b00004u },  /* -0, -1e+30 -> 22 */
    { 0x3e8336cdu, 0x3e86d800u, 0x41b752fau },  /* 0.256277, 0.263367 -> 22.9155 */
    { 0x3f9f969au, 0x3f9e60f7u, 0x41cdba33u },  /* 1.24678, 1.23733 -> 25.7159 */
    { 0x7f800000u, 0x40c2579fu, 0x4248497cu },  /* inf, 6.0732 -> 50.0718 */
    { 0x4006ba05u, 0x4005875du, 0x420ac14au },  /* 2.1051, 2.08639 -> 34.6888 */
    { 0x3fb11f4eu, 0x3fb128fcu, 0x42053716u },  /* 1.38377, 1.38406 -> 33.3038 */
    { 0xbd6353f8u, 0x000116c2u, 0x42431decu },  /* -0.0555, 9.99995e-41 -> 48.7792 */
    { 0x40205734u, 0x401f858fu, 0x42263ad1u },  /* 2.50532, 2.49253 -> 41.5574 */
    { 0x3e7aa83eu, 0x3e90ca75u, 0x422ecc05u },  /* 0.244782, 0.282795 -> 43.6992 */
    { 0x7fc00000u, 0xff800000u, 0x41d4a8f0u },  /* nan, -inf -> 26.5825 */
    { 0x3f397ca8u, 0x3f4332f8u, 0x4235d026u },  /* 0.724558, 0.762496 -> 45.4533 */
    { 0x3eb7330au, 0x3ece38dcu, 0x424bfb08u },  /* 0.357811, 0.402778 -> 50.9951 */
    { 0x40c2579fu, 0x404090f7u, 0x425bee8cu },  /* 6.0732, 3.00885 -> 54.983 */
    { 0x4036a36eu, 0x40363cc4u, 0x42460f60u },  /* 2.85372, 2.84746 -> 49.515 */
    { 0x40284cbau, 0x402829cau, 0x4241ca44u },  /* 2.62968, 2.62755 -> 48.4475 */
    { 0x00000000u, 0x00000000u, 0x41da899cu },  /* 0, 0 -> 27.3172 */
    { 0x401a9936u, 0x401ab01bu, 0x423135d4u },  /* 2.4156, 2.417 -> 44.3026 */
    { 0x4002fd4cu, 0x400387b9u, 0x42449d9au },  /* 2.04671, 2.05516 -> 49.1539 */
    { 0xf149f2cau, 0x7fc00000u, 0x41db2812u },  /* -1e+30, nan -> 27.3946 */
    { 0x3fcdb977u, 0x3fcfd6a5u, 0x422ef225u },  /* 1.60722, 1.62374 -> 43.7365 */
    { 0x3f98250fu, 0x3f9b4a06u, 0x42416d31u },  /* 1.18863, 1.2132 -> 48.3566 */
    { 0x000116c2u, 0x7f800000u, 0x41d9d854u },  /* 9.99995e-41, inf -> 27.2306 */
    { 0x3fe694d1u, 0x3fe807edu, 0x422c98a0u },  /* 1.80142, 1.81274 -> 43.149 */
    { 0x403922dbu, 0x40386c22u, 0x423e0bb1u },  /* 2.89275, 2.8816 -> 47.5114 */
};

/* learn: arguments, hash of every word of the learner afterwards. */
#define EXTENDED_SELFTEST_LEARN_START_Y 0x3fbd03a8u
#define EXTENDED_SELFTEST_LEARN_START_U 0x00000000u
#define EXTENDED_SELFTEST_LEARN_CALLS 40u  /* more than any commit takes */
#define EXTENDED_SELFTEST_LEARN_AGE 131073u  /* set before row 32: past all waiting times */

static const uint32_t extended_selftest_learn_rows[64][3] = {
    { 0x3fbcf85fu, 0x422062f4u, 0x6301e400u },  /* 1.47633, 40.0966 */
    { 0x3fba93e6u, 0x42246405u, 0x42dccc01u },  /* 1.45764, 41.0977 */
    { 0x3fb8d1a6u, 0x41dcec34u, 0x27356aedu },  /* 1.4439, 27.6153 */
    { 0x3fb964a1u, 0x424dd22au, 0x5eff9ab6u },  /* 1.44838, 51.4552 */
    { 0x3fb9e9afu, 0x4205eca0u, 0xa87bb07fu },  /* 1.45244, 33.4811 */
    { 0x3fb949fdu, 0x421af011u, 0xd21c9ee5u },  /* 1.44757, 38.7344 */
    { 0x3fbb937bu, 0x4239dd30u, 0x5c98599au },  /* 1.46544, 46.466 */
    { 0x3fbbb7afu, 0x4255b88eu, 0x1a982db2u },  /* 1.46654, 53.4302 */
    { 0xbd6353f8u, 0x42366827u, 0x76f9e4c1u },  /* -0.0555, 45.6017 */
    { 0x3fbedd3bu, 0x4216c477u, 0x334197f6u },  /* 1.49113, 37.6919 */
    { 0x3fc1c132u, 0x42133197u, 0x082b4a04u },  /* 1.51371, 36.7984 */
    { 0x3fc3902du, 0x420705e5u, 0x42118e0cu },  /* 1.52784, 33.7558 */
    { 0x3fc44f59u, 0x4210a624u, 0x30a7c83cu },  /* 1.53367, 36.1622 */
    { 0x3fc4a63eu, 0x423c46bcu, 0xf790596au },  /* 1.53632, 47.0691 */
    { 0x3fc49b98u, 0x42518298u, 0x47d759bbu },  /* 1.536, 52.3775 */
    { 0x3fc532cdu, 0x423ce038u, 0x5acab5d1u },  /* 1.54061, 47.219 */
    { 0x3fc756a6u, 0x420871cdu, 0x74861fb4u },  /* 1.55733, 34.1111 */
    { 0x00000000u, 0x422b7b78u, 0x65a134f5u },  /* 0, 42.8706 */
    { 0x3fca4964u, 0x4243006au, 0xb8fd23aau },  /* 1.58036, 48.7504 */
    { 0x3fca90ceu, 0x42177896u, 0x003bac8bu },  /* 1.58254, 37.8678 */
    { 0x3fcbf262u, 0x41bc3036u, 0xf1f132d8u },  /* 1.59333, 23.5235 */
    { 0x3fcdb91fu, 0x421e6d10u, 0x9f227bfbu },  /* 1.60721, 39.6065 */
    { 0x3fcdacd2u, 0x424ae7efu, 0x1473103fu },  /* 1.60684, 50.7265 */
    { 0x3fcbee14u, 0x4240990du, 0xee9e5a01u },  /* 1.5932, 48.1495 */
    { 0x3fccb7e3u, 0x4212df51u, 0x59170c50u },  /* 1.59936, 36.7181 */
    { 0x3fcf079fu, 0x421255a4u, 0x469db753u },  /* 1.61742, 36.5836 */
    { 0xf149f2cau, 0x425a0f8cu, 0x845855abu },  /* -1e+30, 54.5152 */
    { 0x3fd0f4eeu, 0x4213001fu, 0xbaadacf2u },  /* 1.63247, 36.7501 */
    { 0x3fd18f7eu, 0x4216e7bcu, 0x3d6f45f5u },  /* 1.63719, 37.7263 */
    { 0x3fd3ffafu, 0x422ee5afu, 0x73503f39u },  /* 1.65624, 43.7243 */
    { 0x3fd43c0au, 0x425c68aeu, 0xea356e18u },  /* 1.65808, 55.1022 */
    { 0x3fd4be9cu, 0x42114851u, 0x69fcf4f8u },  /* 1.66207, 36.3206 */
    { 0x3fd6244eu, 0x4219fa49u, 0xa708163cu },  /* 1.67298, 38.4944 */
    { 0x3fd82351u, 0x4245776eu, 0xf4f2774cu },  /* 1.68858, 49.3666 */
    { 0x3fd63fb9u, 0x422a9072u, 0xf818f9d0u },  /* 1.67382, 42.6411 */
    { 0x3f5c0602u, 0x421a9707u, 0x330b7ed4u },  /* 0.859467, 38.6475 */
    { 0x3fd85cdau, 0x420a44eau, 0x6921dd6bu },  /* 1.69033, 34.5673 */
    { 0x3fd932b8u, 0x420a3eb4u, 0x966b90b1u },  /* 1.69686, 34.5612 */
    { 0x3fd93e1eu, 0x41e48b5bu, 0xd76c2139u },  /* 1.69721, 28.568 */
    { 0x3fd8d6deu, 0x423deedau, 0x32ee3c63u },  /* 1.69406, 47.4833 */
    { 0x3fd83158u, 0x423a2358u, 0x28d5c4ecu },  /* 1.68901, 46.5345 */
    { 0x3fd7658au, 0x4259af64u, 0xa28dcde8u },  /* 1.68279, 54.4213 */
    { 0x3fd9007au, 0x422527b2u, 0x872dec6bu },  /* 1.69533, 41.2888 */
    { 0x3fdaaf08u, 0x4215a1a2u, 0x55ad5c58u },  /* 1.70847, 37.4078 */
    { 0x3eba3922u, 0x41c6aa14u, 0x5937cccdu },  /* 0.363717, 24.833 */
    { 0x3fddb9f7u, 0x42434ea7u, 0x13173cdau },  /* 1.73224, 48.8268 */
    { 0x3fdd6c09u, 0x4257da81u, 0x53b348aeu },  /* 1.72986, 53.9634 */
    { 0x3fdbe74fu, 0x423ce038u, 0x6754793du },  /* 1.718, 47.219 */
    { 0x3fddede3u, 0x423230ecu, 0xba0a7ab4u },  /* 1.73382, 44.5478 */
    { 0x3fe045dcu, 0x41fa9b31u, 0xdbd7e379u },  /* 1.75213, 31.3258 */
    { 0x3fe100beu, 0x423b3295u, 0x73868328u },  /* 1.75784, 46.7994 */
    { 0x3fe1dfa2u, 0x42088e9fu, 0x87a24a38u },  /* 1.76464, 34.1393 */
    { 0x3fe15046u, 0x425692e9u, 0x1878c8f6u },  /* 1.76026, 53.6435 */
    { 0x3e6398e9u, 0x42475c3du, 0x6311e147u },  /* 0.222263, 49.8401 */
    { 0x3fe237f1u, 0x41fa165eu, 0x5a27de0eu },  /* 1.76733, 31.2609 */
    { 0x3fe4c28au, 0x42081c2du, 0x56d14b3cu },  /* 1.78719, 34.0275 */
    { 0x3fe63470u, 0x41dbd9c8u, 0xdff0da0eu },  /* 1.79848, 27.4813 */
    { 0x3fe5188au, 0x4230c83eu, 0x9bd53960u },  /* 1.78981, 44.1955 */
    { 0x3fe41565u, 0x422127cau, 0x04172c0eu },  /* 1.7819, 40.2889 */
    { 0x3fe2eb5du, 0x4259a513u, 0xe762acd6u },  /* 1.77281, 54.4112 */
    { 0x3fe38245u, 0x41e16398u, 0xbdbde6a7u },  /* 1.77741, 28.1736 */
    { 0x3fe43c07u, 0x41ec4fd8u, 0x2c66dc4fu },  /* 1.78308, 29.539 */
    { 0x3fb19e10u, 0x425d96b0u, 0xae60b769u },  /* 1.38764, 55.3972 */
    { 0x3fe41e8bu, 0x42114851u, 0x1aacb784u },  /* 1.78218, 36.3206 */
};

/* commit: age, calls, answer, hash of every word of instance and learner afterwards, theta before. */
static const uint32_t extended_selftest_commit_rows[8][22] = {
    { 0u, 1u, 2u, 0x7e2cb79cu,
0x40b0549eu, 0x3de8b891u, 0x368497eeu, 0x40a2dd4au, 0x3dd6ed4bu, 0x36264b37u, 0x405d5ae7u, 0x3d920283u,
0xb5892dc2u, 0x405d5ad3u, 0x3d91fca9u, 0xb6196b77u, 0x40a2dd36u, 0x3dd6da38u, 0xb5ea8c6du, 0x40b05496u,
0x3de8a549u, 0xb4beb14au
    },
    { 131073u, 35u, 1u, 0x97c3fdc9u,
0x40b0549bu, 0x3de8a6ffu, 0x00000000u, 0x40a2dd4fu, 0x3dd6e298u, 0x00000000u, 0x405d5b15u, 0x3d920793u,
0x00000000u, 0x405d5b15u, 0x3d920793u, 0x00000000u, 0x40a2dd4fu, 0x3dd6e298u, 0x00000000u, 0x40b0549bu,
0x3de8a6ffu, 0x00000000u
    },
    { 131073u, 35u, 1u, 0x893468f0u,
0x40b0549eu, 0x3de8b891u, 0x368497eeu, 0x40a2dd4au, 0x3dd6ed4bu, 0x36264b37u, 0x405d5ae7u, 0x3d920283u,
0xb5892dc2u, 0x405d5ad3u, 0x3d91fca9u, 0xb6196b77u, 0x40a2dd36u, 0x3dd6da38u, 0xb5ea8c6du, 0x40b05496u,
0x3de8a549u, 0xb4beb14au
    },
    { 131073u, 2u, 4u, 0x168be31du,
0x40b0549bu, 0x3b14e5c2u, 0x00000000u, 0x40a2dd4fu, 0x3b0986c7u, 0x00000000u, 0x405d5b15u, 0x3abaeaf9u,
0x00000000u, 0x405d5b15u, 0x3abaeaf9u, 0x00000000u, 0x40a2dd4fu, 0x3b0986c7u, 0x00000000u, 0x40b0549bu,
0x3b14e5c2u, 0x00000000u
    },
    { 131073u, 2u, 4u, 0xd1cab6c2u,
0x40b0549bu, 0xbde8a6ffu, 0x00000000u, 0x40a2dd4fu, 0xbdd6e298u, 0x00000000u, 0x405d5b15u, 0xbd920793u,
0x00000000u, 0x405d5b15u, 0xbd920793u, 0x00000000u, 0x40a2dd4fu, 0xbdd6e298u, 0x00000000u, 0x40b0549bu,
0xbde8a6ffu, 0x00000000u
    },
    { 131073u, 2u, 5u, 0xf415c5c9u,
0x40e53ac9u, 0x3de8a6ffu, 0x00000000u, 0x40d3b94du, 0x3dd6e298u, 0x00000000u, 0x408fe19au, 0x3d920793u,
0x00000000u, 0x408fe19au, 0x3d920793u, 0x00000000u, 0x40d3b94du, 0x3dd6e298u, 0x00000000u, 0x40e53ac9u,
0x3de8a6ffu, 0x00000000u
    },
    { 131073u, 2u, 5u, 0x1555896du,
0xc0e53ac9u, 0x3de8a6ffu, 0x00000000u, 0xc0d3b94du, 0x3dd6e298u, 0x00000000u, 0xc08fe19au, 0x3d920793u,
0x00000000u, 0xc08fe19au, 0x3d920793u, 0x00000000u, 0xc0d3b94du, 0x3dd6e298u, 0x00000000u, 0xc0e53ac9u,
0x3de8a6ffu, 0x00000000u
    },
    { 131073u, 1u, 3u, 0x3bb75aa1u,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u
    },
};

#endif
