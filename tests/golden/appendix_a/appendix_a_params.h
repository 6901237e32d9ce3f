/* appendix_a_params.h: the numbers of model `appendix_a`. All that changes when the same structure is identified again.
 *
 * appendix_a.h includes part 1; appendix_a.c defines APPENDIX_A_NUMBERS and includes part 2. Every float32 is written with
 * 9 significant digits, which read back to the same bits; the bits of a constant stand in the comment behind it. */

#ifndef APPENDIX_A_PARAMS_H
#define APPENDIX_A_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define APPENDIX_A_NUMBERS_DIGEST "4ac22b42e5fd5259521f719d446f746688477114e2a6efef7dc5b3c46cbd6e99"
#define APPENDIX_A_NUMBERS_WORD 0x4ac22b42u

/* Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value. */
#define APPENDIX_A_Y_MIN_UM           0.66079998f  /* 0x3f292a30 */
#define APPENDIX_A_Y_MAX_UM           3.73589993f  /* 0x406f18fc */
#define APPENDIX_A_Y_REST_UM          2.19834995f  /* 0x400cb1c4 */
#define APPENDIX_A_U_MIN_V                 -20.0f  /* 0xc1a00000 */
#define APPENDIX_A_U_MAX_V                 120.0f  /* 0x42f00000 */
#define APPENDIX_A_U_REST_V                  0.0f  /* 0x00000000 */
#define APPENDIX_A_U_STEP_MAX_V            280.0f  /* 0x438c0000 */
#define APPENDIX_A_REFERENCE_MIN_UM  -2.41429996f  /* 0xc01a83e4 */
#define APPENDIX_A_REFERENCE_MAX_UM   6.81099987f  /* 0x40d9f3b6 */

/* Error of one step from any state. FOUND: the largest against float64 over 20000 samples of the
 * whole range, rounded up; larger ones exist.
 * BOUND: proved against real arithmetic, for every input and state and these numbers;
 * ANY_BANK: for all numbers that a learner may commit, at the limits of its parameters. */
#define APPENDIX_A_PREDICT_FOUND_UM  1.30000001e-06f  /* 0x35ae7ba9 */
#define APPENDIX_A_INVERSE_FOUND_V   0.000509999983f  /* 0x3a05b185 */
#define APPENDIX_A_PREDICT_BOUND_UM  2.79999995e-06f  /* 0x363be7a2 */
#define APPENDIX_A_INVERSE_BOUND_V    0.00120000006f  /* 0x3a9d4952 */

#endif

#ifdef APPENDIX_A_NUMBERS

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/V]. */
#define APPENDIX_A_ORIGIN_UM  2.19834995f  /* 0x400cb1c4 */
#define APPENDIX_A_PER_STEP   2.34576941f  /* 0x40162116 */

APPENDIX_A_TABLE
static const float appendix_a_strength[APPENDIX_A_RULES] = {
    0.0439369343f,  0.324652463f,  0.882496893f,  0.882496893f,  0.324652463f, 0.0439369343f,
};

APPENDIX_A_TABLE
static const float appendix_a_slope[APPENDIX_A_BANK_RULES] = {
    0.0268937983f, 0.0225958116f,  0.530115902f,  0.911089778f,  0.270305634f,  0.038370125f,
};

APPENDIX_A_TABLE
static const float appendix_a_offset[APPENDIX_A_BANK_RULES] = {
    -0.0112039177f,   0.362019956f,    1.02466714f,  -0.154966459f,   0.106615864f,  0.0197320767f,
};

APPENDIX_A_TABLE
static const float appendix_a_gain[APPENDIX_A_BANK_RULES] = {
    7.02990947e-05f, 0.000551909208f,  0.00132374535f,  0.00150024472f, 0.000454513443f, 9.22675608e-05f,
};

#endif
