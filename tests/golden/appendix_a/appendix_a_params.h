/* appendix_a_params.h: the numbers of model `appendix_a`. All that changes when the same structure is identified again.
 *
 * Every float32 is written with 9 significant digits, which read back to the bits in the comment behind it. */

#ifndef APPENDIX_A_PARAMS_H
#define APPENDIX_A_PARAMS_H

#include <stdint.h>

#include "appendix_a.h"

/* Ranges: inputs outside are limited and counted; a start that is not finite becomes the rest value. */
#define APPENDIX_A_Y_MIN_UM           0.66079998f  /* 0x3f292a30 */
#define APPENDIX_A_Y_MAX_UM           3.73589993f  /* 0x406f18fc */
#define APPENDIX_A_Y_REST_UM          2.19834995f  /* 0x400cb1c4 */
#define APPENDIX_A_U_MIN_V                 -20.0f  /* 0xc1a00000 */
#define APPENDIX_A_U_MAX_V                 120.0f  /* 0x42f00000 */
#define APPENDIX_A_U_REST_V                  0.0f  /* 0x00000000 */
#define APPENDIX_A_REFERENCE_MIN_UM  -2.41429996f  /* 0xc01a83e4 */
#define APPENDIX_A_REFERENCE_MAX_UM   6.81099987f  /* 0x40d9f3b6 */

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/V]. */
#define APPENDIX_A_ORIGIN_UM  2.19834995f  /* 0x400cb1c4 */
#define APPENDIX_A_PER_STEP   2.34576941f  /* 0x40162116 */

static const float appendix_a_strength[APPENDIX_A_RULES] = {
      0.0439369343f,  /* 0x3d33f737 */
       0.324652463f,  /* 0x3ea638d9 */
       0.882496893f,  /* 0x3f61eb51 */
       0.882496893f,  /* 0x3f61eb51 */
       0.324652463f,  /* 0x3ea638d9 */
      0.0439369343f,  /* 0x3d33f737 */
};

static const float appendix_a_slope[APPENDIX_A_BANK_RULES] = {
      0.0268937983f,  /* 0x3cdc5062 */
      0.0225958116f,  /* 0x3cb91ada */
       0.530115902f,  /* 0x3f07b5ad */
       0.911089778f,  /* 0x3f693d2e */
       0.270305634f,  /* 0x3e8a6580 */
       0.038370125f,  /* 0x3d1d29fe */
};

static const float appendix_a_offset[APPENDIX_A_BANK_RULES] = {
     -0.0112039177f,  /* 0xbc3790a3 */
       0.362019956f,  /* 0x3eb95aae */
        1.02466714f,  /* 0x3f83284b */
      -0.154966459f,  /* 0xbe1eaf87 */
       0.106615864f,  /* 0x3dda596b */
      0.0197320767f,  /* 0x3ca1a52a */
};

static const float appendix_a_gain[APPENDIX_A_BANK_RULES] = {
    7.02990947e-05f,  /* 0x38936d8a */
    0.000551909208f,  /* 0x3a10ae00 */
     0.00132374535f,  /* 0x3aad8186 */
     0.00150024472f,  /* 0x3ac4a3dc */
    0.000454513443f,  /* 0x39ee4bc3 */
    9.22675608e-05f,  /* 0x38c17fc5 */
};

/* Worst error of one step against the float64 model, measured when this file was generated
 * over 20000 samples of the whole range, rounded up. */
#define APPENDIX_A_PREDICT_ERROR_UM  1.09999996e-06f  /* 0x3593a3b6 */
#define APPENDIX_A_INVERSE_ERROR_V   0.000479999988f  /* 0x39fba882 */

#endif
