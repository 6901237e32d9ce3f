/* smooth_50_params.h: the numbers of model `smooth_50`. All that changes when the same structure is identified again.
 *
 * smooth_50.h includes part 1; smooth_50.c defines SMOOTH_50_NUMBERS and includes part 2. Every float32 is written with
 * 9 significant digits, which read back to the same bits; the bits of a constant stand in the comment behind it. */

#ifndef SMOOTH_50_PARAMS_H
#define SMOOTH_50_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define SMOOTH_50_NUMBERS_DIGEST "6e13070df8a0d441c7989d164955794f2deb72c7673c1754eea7798c79f13fa0"
#define SMOOTH_50_NUMBERS_WORD 0x6e13070du

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

/* Error of one step from any state. FOUND: the largest against float64 over 20000 samples of the
 * whole range, rounded up; larger ones exist.
 * BOUND: proved against real arithmetic, for every input and state and these numbers;
 * ANY_BANK: for all numbers that a learner may commit, at the limits of its parameters. */
#define SMOOTH_50_PREDICT_FOUND_UM  2.90000003e-06f  /* 0x36429d9f */
#define SMOOTH_50_INVERSE_FOUND_V    0.00120000006f  /* 0x3a9d4952 */
#define SMOOTH_50_PREDICT_BOUND_UM  1.10000001e-05f  /* 0x37388ca4 */
#define SMOOTH_50_INVERSE_BOUND_V    0.00430000015f  /* 0x3b8ce704 */

#endif

#ifdef SMOOTH_50_NUMBERS

/* Rules, Eqs (1) to (7): steps per um from the lowest centre; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/V]. */
#define SMOOTH_50_ORIGIN_UM         0.5f  /* 0x3f000000 */
#define SMOOTH_50_PER_STEP   5.76470566f  /* 0x40b87878 */

SMOOTH_50_TABLE
static const float smooth_50_strength[SMOOTH_50_WINDOW] = {
    3.72665318e-06f, 0.000335462624f,   0.0111089963f,    0.135335281f,    0.606530666f,            1.0f,    0.606530666f,    0.135335281f,
      0.0111089963f, 0.000335462624f, 3.72665318e-06f,
};

SMOOTH_50_TABLE
static const float smooth_50_present[SMOOTH_50_BANK_RULES] = {
    0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f,
    1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f,
    1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f,
    1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f,
    1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f,
    1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f,
    1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 0.0f,
    0.0f, 0.0f, 0.0f, 0.0f,
};

SMOOTH_50_TABLE
static const float smooth_50_slope[SMOOTH_50_BANK_RULES] = {
            0.0f,         0.0f,         0.0f,         0.0f,         0.0f, 0.899999976f, 0.901020408f, 0.902040839f,
    0.903061211f, 0.904081643f, 0.905102015f, 0.906122446f, 0.907142878f, 0.908163249f, 0.909183681f, 0.910204053f,
    0.911224484f, 0.912244916f, 0.913265288f, 0.914285719f, 0.915306151f, 0.916326523f, 0.917346954f, 0.918367326f,
    0.919387758f, 0.920408189f, 0.921428561f, 0.922448993f, 0.923469365f, 0.924489796f, 0.925510228f,   0.9265306f,
    0.927551031f, 0.928571403f, 0.929591835f, 0.930612266f, 0.931632638f, 0.932653069f, 0.933673441f, 0.934693873f,
    0.935714304f, 0.936734676f, 0.937755108f, 0.938775539f, 0.939795911f, 0.940816343f, 0.941836715f, 0.942857146f,
    0.943877578f,  0.94489795f, 0.945918381f, 0.946938753f, 0.947959185f, 0.948979616f, 0.949999988f,         0.0f,
            0.0f,         0.0f,         0.0f,         0.0f,
};

SMOOTH_50_TABLE
static const float smooth_50_offset[SMOOTH_50_BANK_RULES] = {
             0.0f,          0.0f,          0.0f,          0.0f,          0.0f, 0.0199999996f, 0.0299958345f, 0.0395751782f,
    0.0487380251f, 0.0574843809f, 0.0658142418f, 0.0737276152f, 0.0812244862f, 0.0883048698f,  0.094968766f,   0.10121616f,
     0.107047066f,  0.112461478f,  0.117459394f,  0.122040816f,  0.126205742f,  0.129954189f,  0.133286133f,  0.136201575f,
     0.138700545f,  0.140783012f,  0.142448977f,  0.143698454f,  0.144531444f,  0.144947931f,  0.144947931f,  0.144531444f,
     0.143698454f,  0.142448977f,  0.140783012f,  0.138700545f,  0.136201575f,  0.133286133f,  0.129954189f,  0.126205742f,
     0.122040816f,  0.117459394f,  0.112461478f,  0.107047066f,   0.10121616f,  0.094968766f, 0.0883048698f, 0.0812244862f,
    0.0737276152f, 0.0658142418f, 0.0574843809f, 0.0487380251f, 0.0395751782f, 0.0299958345f, 0.0199999996f,          0.0f,
             0.0f,          0.0f,          0.0f,          0.0f,
};

SMOOTH_50_TABLE
static const float smooth_50_gain[SMOOTH_50_BANK_RULES] = {
              0.0f,           0.0f,           0.0f,           0.0f,           0.0f, 0.00150000001f, 0.00151020405f,  0.0015204082f,
    0.00153061224f, 0.00154081627f, 0.00155102042f, 0.00156122446f, 0.00157142861f, 0.00158163265f, 0.00159183668f, 0.00160204084f,
    0.00161224487f, 0.00162244902f, 0.00163265306f,  0.0016428571f, 0.00165306125f, 0.00166326528f, 0.00167346944f, 0.00168367347f,
    0.00169387751f, 0.00170408166f,  0.0017142857f, 0.00172448985f, 0.00173469388f, 0.00174489792f, 0.00175510207f, 0.00176530611f,
    0.00177551026f,  0.0017857143f, 0.00179591833f, 0.00180612248f, 0.00181632652f, 0.00182653056f, 0.00183673471f, 0.00184693874f,
     0.0018571429f, 0.00186734693f, 0.00187755097f, 0.00188775512f, 0.00189795916f, 0.00190816331f, 0.00191836734f, 0.00192857138f,
    0.00193877553f, 0.00194897957f, 0.00195918372f, 0.00196938775f, 0.00197959179f, 0.00198979583f, 0.00200000009f,           0.0f,
              0.0f,           0.0f,           0.0f,           0.0f,
};

#endif
