/* diagnosed_params.h: the numbers of model `diagnosed`. All that changes when the same structure is identified again.
 *
 * diagnosed.h includes part 1; diagnosed.c defines DIAGNOSED_NUMBERS and includes part 2. Every float32 is written with
 * 9 significant digits, which read back to the same bits; the bits of a constant stand in the comment behind it. */

#ifndef DIAGNOSED_PARAMS_H
#define DIAGNOSED_PARAMS_H

#include <stdint.h>

/* SHA-256 of the 32-bit words of parts 1 and 2 in their order, little endian, and its first 32 bits. */
#define DIAGNOSED_NUMBERS_DIGEST "7d3a5c30203ea71631c502ef4decaf0a086a90469bf37daac777f10aa4f3b8f7"
#define DIAGNOSED_NUMBERS_WORD 0x7d3a5c30u

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
#define DIAGNOSED_W_MIN                -4.55189085f  /* 0xc091a917 */
#define DIAGNOSED_W_MAX                  9.2256937f  /* 0x41139c71 */
#define DIAGNOSED_W_TOLERANCE       1.31393281e-05f  /* 0x375c70fc */

/* Commit: check points. */
#define DIAGNOSED_COMMIT_POINTS  0x00000020u

/* Error of one step from any state. FOUND: the largest against float64 over 20000 samples of the
 * whole range, rounded up; larger ones exist. PATH: part of the path, of w; INVERSE: of y(k+1) against
 * the reference where no limit acts.
 * BOUND: proved against real arithmetic, for every input and state and these numbers;
 * ANY_BANK: for all numbers that a learner may commit, at the limits of its parameters. */
#define DIAGNOSED_PREDICT_FOUND_UM           1.39999997e-06f  /* 0x35bbe7a2 */
#define DIAGNOSED_PATH_FOUND                 6.39999996e-07f  /* 0x352bcc77 */
#define DIAGNOSED_INVERSE_FOUND_UM           1.09999996e-06f  /* 0x3593a3b6 */
#define DIAGNOSED_PREDICT_BOUND_UM           3.39999997e-06f  /* 0x36642b8e */
#define DIAGNOSED_PATH_BOUND                 3.29999989e-06f  /* 0x365d7591 */
#define DIAGNOSED_INVERSE_BOUND_UM           3.29999989e-06f  /* 0x365d7591 */
#define DIAGNOSED_PREDICT_BOUND_ANY_BANK_UM    0.0109999999f  /* 0x3c343958 */

#endif

#ifdef DIAGNOSED_NUMBERS

/* Rules, Eqs (1) to (7): octaves per um from the middle; strengths w;
 * consequents times w, slope q1 [um/um], offset q3 [um], gain q2 [um/um]. */
#define DIAGNOSED_ORIGIN_UM  2.19834995f  /* 0x400cb1c4 */
#define DIAGNOSED_PER_STEP   2.34576941f  /* 0x40162116 */

DIAGNOSED_TABLE
static const float diagnosed_strength[DIAGNOSED_RULES] = {
    0.0439369343f,  0.324652463f,  0.882496893f,  0.882496893f,  0.324652463f, 0.0439369343f,
};

DIAGNOSED_TABLE
static const float diagnosed_slope[DIAGNOSED_BANK_RULES] = {
    0.0417400859f,  0.309069157f,  0.841902018f,   0.84366703f,  0.311017066f, 0.0421794578f,
};

DIAGNOSED_TABLE
static const float diagnosed_offset[DIAGNOSED_BANK_RULES] = {
                0.0f,  0.000273185608f,  0.000802452152f,  0.000124537968f, -0.000245697796f, -4.21321929e-05f,
};

DIAGNOSED_TABLE
static const float diagnosed_gain[DIAGNOSED_BANK_RULES] = {
    0.00224078353f,   0.015751712f,  0.0402569883f,  0.0380610377f,  0.0134571502f, 0.00176744792f,
};

/* Input block `delay`: input delayed by 0.4 samples. */

DIAGNOSED_TABLE
static const float diagnosed_delay_part[1] = {
    0.400000006f,
};

/* Input block `hysteresis`: 12 plays of degree 3, 2 Duhem states, curve of degree 3. */

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_range[6] = {
            50.0f,         70.0f, 0.0142857144f,   1.08666754f,   2.11040545f,  0.711975217f,
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_curve[104] = {
      2.13800001f,   1.16999996f,  0.100000001f, 0.0399999991f,   2.13669157f,    1.1983285f,  0.101723678f, 0.0419999994f,
      2.13369608f,    1.2264725f,  0.103088848f, 0.0439999998f,   2.12883997f,   1.25446177f,  0.104056172f, 0.0460000001f,
      2.12200165f,   1.28234398f,  0.104597725f, 0.0480000004f,   2.11308479f,   1.31017876f,  0.104691461f, 0.0500000007f,
      2.10200453f,   1.33803523f,  0.104318991f, 0.0520000011f,   2.08868289f,   1.36599028f,   0.10346444f, 0.0540000014f,
      2.07304263f,   1.39412761f,  0.102113806f, 0.0560000017f,   2.05500603f,   1.42253709f,  0.100254491f, 0.0579999983f,
      2.03449154f,   1.45131409f, 0.0978750437f, 0.0599999987f,   2.01141191f,   1.48055887f, 0.0949649438f,  0.061999999f,
      1.98567319f,   1.51037657f, 0.0915144384f,  0.064000003f,  -2.13800001f,   1.16999996f, -0.100000001f, 0.0399999991f,
     -2.13931704f,   1.19869697f, -0.102276325f, 0.0419999994f,  -2.14235711f,   1.22768736f, -0.104911149f, 0.0439999998f,
     -2.14733171f,   1.25705349f, -0.107943825f, 0.0460000001f,  -2.15440631f,   1.28688037f, -0.111402281f, 0.0480000004f,
     -2.16372705f,   1.31725681f, -0.115308546f, 0.0500000007f,  -2.17543268f,   1.34827662f, -0.119681016f, 0.0520000011f,
     -2.18965983f,   1.38003767f, -0.124535561f, 0.0540000014f,   -2.2065475f,    1.4126426f, -0.129886195f, 0.0560000017f,
     -2.22623873f,   1.44619787f,  -0.13574551f, 0.0579999983f,  -2.24888444f,   1.48081398f, -0.142124951f, 0.0599999987f,
     -2.27464294f,   1.51660562f, -0.149035051f,  0.061999999f,  -2.30368257f,   1.55369067f, -0.156485558f,  0.064000003f,
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_play[48] = {
     0.0460540652f,        0.0285f, 0.00200000009f, 0.00200000009f,   0.105804458f,        0.0285f, 0.00200000009f, 0.00200000009f,
      0.172112927f,        0.0285f, 0.00200000009f, 0.00200000009f,   0.243074819f,        0.0285f, 0.00200000009f, 0.00200000009f,
      0.317710817f,        0.0285f, 0.00200000009f, 0.00200000009f,    0.39541167f,        0.0285f, 0.00200000009f, 0.00200000009f,
       0.47575748f,        0.0285f, 0.00200000009f, 0.00200000009f,   0.558439255f,        0.0285f, 0.00200000009f, 0.00200000009f,
      0.643219173f,        0.0285f, 0.00200000009f, 0.00200000009f,   0.729907751f,        0.0285f, 0.00200000009f, 0.00200000009f,
      0.818350196f,        0.0285f, 0.00200000009f, 0.00200000009f,   0.908417463f,        0.0285f, 0.00200000009f, 0.00200000009f,
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_rate[1] = {
    -1.80336881f,
};

DIAGNOSED_TABLE
static const float diagnosed_hysteresis_duhem[6] = {
      0.0299999993f,  0.00999999978f,           1.25f,   0.0199999996f, 9.09494702e-13f,            2.5f,
};

/* Input block `creep`: creep by 0.01 per state, 4 states of 0.001 .. 1 s. */

DIAGNOSED_TABLE
static const float diagnosed_creep_rate[4] = {
      0.0198013261f,  0.00199800124f, 0.000199980001f, 1.99997994e-05f,
};

DIAGNOSED_TABLE
static const float diagnosed_creep_amount[1] = {
    0.00999999978f,
};

/* Input block `modes`: modes at 730 Hz (damping 0.05, share 0.3). */

DIAGNOSED_TABLE
static const float diagnosed_modes_real[1] = {
    0.00875118468f,
};

DIAGNOSED_TABLE
static const float diagnosed_modes_imag[1] = {
    0.0910729542f,
};

DIAGNOSED_TABLE
static const float diagnosed_modes_of_position[1] = {
    0.29957512f,
};

DIAGNOSED_TABLE
static const float diagnosed_modes_of_velocity[1] = {
    -0.00115762639f,
};

DIAGNOSED_TABLE
static const float diagnosed_modes_direct[1] = {
    0.70042485f,
};

DIAGNOSED_TABLE
static const float diagnosed_modes_per_direct[1] = {
    1.42770481f,
};

DIAGNOSED_TABLE
static const float diagnosed_modes_calm[1] = {
    -1.0f,
};

/* Learner: plausible displacements, rest, levels of the innovation and how fast they follow. */
#define DIAGNOSED_LEARN_Y_LOW_UM         -2.41429996f  /* 0xc01a83e4 */
#define DIAGNOSED_LEARN_Y_HIGH_UM         6.81099987f  /* 0x40d9f3b6 */
#define DIAGNOSED_LEARN_REST_V         0.00854492188f  /* 0x3c0c0000 */
#define DIAGNOSED_LEARN_FLOOR_UM       6.2500003e-05f  /* 0x3883126f */
#define DIAGNOSED_LEARN_FLOOR_SQUARE  3.90625043e-09f  /* 0x318637be */
#define DIAGNOSED_LEARN_LEVEL_UM          3.07509995f  /* 0x4044ce70 */
#define DIAGNOSED_LEARN_CARRIED          0.953613281f  /* 0x3f742000 */
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
#define DIAGNOSED_LEARN_LARGEST_DENOMINATOR        2314.646f  /* 0x4510aa56 */
#define DIAGNOSED_LEARN_OUTLIER_RUN              0x00000008u
#define DIAGNOSED_LEARN_SETTLING                 0x00001000u
#define DIAGNOSED_LEARN_SETTLED                  0x00002000u
#define DIAGNOSED_LEARN_REFRESH_EVERY            0x00000008u
#define DIAGNOSED_LEARN_WINDOW                   0x00020000u
#define DIAGNOSED_LEARN_INFLATE_FIRST              1.001001f  /* 0x3f8020cd */
#define DIAGNOSED_LEARN_INFLATE                    1.001001f  /* 0x3f8020cd */
#define DIAGNOSED_LEARN_PER_Y                          0.25f  /* 0x3e800000 */
#define DIAGNOSED_LEARN_PER_U                         0.125f  /* 0x3e000000 */

/* Learner, per parameter: theta per number in the bank, and back; D(0) and largest D; what puts the prior
 * back; powers of two that scale the regressors. */

DIAGNOSED_TABLE
static const float diagnosed_learn_scale[DIAGNOSED_LEARNED] = {
    128.0f, 256.0f,  32.0f,  16.0f,  32.0f,   4.0f,   4.0f,   8.0f,
      1.0f,   4.0f,   8.0f,   1.0f,  16.0f,  32.0f,   4.0f, 128.0f,
    256.0f,  32.0f,
};

DIAGNOSED_TABLE
static const float diagnosed_learn_per_scale[DIAGNOSED_LEARNED] = {
     0.0078125f, 0.00390625f,    0.03125f,     0.0625f,    0.03125f,       0.25f,       0.25f,      0.125f,
           1.0f,       0.25f,      0.125f,        1.0f,     0.0625f,    0.03125f,       0.25f,  0.0078125f,
    0.00390625f,    0.03125f,
};

DIAGNOSED_TABLE
static const float diagnosed_learn_prior[DIAGNOSED_LEARNED] = {
     0.0316285603f,   0.126514241f, 0.00197678502f,  0.0269822013f,   0.107928805f, 0.00168638758f,   0.012460812f,   0.049843248f,
    0.00077880075f,   0.012460812f,   0.049843248f, 0.00077880075f,  0.0269822013f,   0.107928805f, 0.00168638758f,  0.0316285603f,
      0.126514241f, 0.00197678502f,
};

DIAGNOSED_TABLE
static const float diagnosed_learn_ceiling[DIAGNOSED_LEARNED] = {
     0.0717559531f,   0.287023813f, 0.00448474707f,   0.061214719f,   0.244858876f, 0.00382591994f,  0.0282699373f,   0.113079749f,
    0.00176687108f,  0.0282699373f,   0.113079749f, 0.00176687108f,   0.061214719f,   0.244858876f, 0.00382591994f,  0.0717559531f,
      0.287023813f, 0.00448474707f,
};

DIAGNOSED_TABLE
static const float diagnosed_learn_refresh[DIAGNOSED_LEARNED] = {
    1.93513298f, 0.96756649f, 7.74053192f, 2.09513426f, 1.04756713f, 8.38053703f, 3.08302712f, 1.54151356f,
    12.3321085f, 3.08302712f, 1.54151356f, 12.3321085f, 2.09513426f, 1.04756713f, 8.38053703f, 1.93513298f,
    0.96756649f, 7.74053192f,
};

DIAGNOSED_TABLE
static const float diagnosed_learn_firing[DIAGNOSED_RULES] = {
    0.03125f,    0.25f,     1.0f,     1.0f,    0.25f, 0.03125f,
};

/* Commit: half the distance h of the check points; what Taylor's theorem leaves, h^2/2 times bounds of the
 * memberships' second and third derivatives; limits of |b(y)| [um/V] and |df/dy|; rows of p_l, p_l', p_l''
 * over the strengths w_l at each check point. */
#define DIAGNOSED_COMMIT_MATURE                0x00000400u
#define DIAGNOSED_COMMIT_TRIAL                 0x00000800u
#define DIAGNOSED_COMMIT_HALF_UM             0.0485289209f  /* 0x3d46c643 */
#define DIAGNOSED_COMMIT_GAIN_REMAINDER     0.00320476922f  /* 0x3b52071b */
#define DIAGNOSED_COMMIT_SLOPE_REMAINDER_1  0.00961430743f  /* 0x3c1d8554 */
#define DIAGNOSED_COMMIT_SLOPE_REMAINDER_3  0.00762989838f  /* 0x3bfa043a */
#define DIAGNOSED_COMMIT_SIGN                         1.0f  /* 0x3f800000 */
#define DIAGNOSED_COMMIT_GAIN_FLOOR          0.0204550549f  /* 0x3ca7915c */
#define DIAGNOSED_COMMIT_GAIN_CEILING         0.198697671f  /* 0x3e4b7767 */
#define DIAGNOSED_COMMIT_SLOPE_LIMIT          0.997240305f  /* 0x3f7f4b24 */

DIAGNOSED_TABLE
static const float diagnosed_commit_unfold[DIAGNOSED_RULES] = {
    22.7598953f, 3.08021688f, 1.13314843f, 1.13314843f, 3.08021688f, 22.7598953f,
};

DIAGNOSED_TABLE
static const float diagnosed_commit_y[32] = {
    0.708848417f,  0.80494529f, 0.901042163f, 0.997139037f,  1.09323597f,  1.18933284f,  1.28542972f,  1.38152659f,
     1.47762346f,  1.57372034f,  1.66981721f,  1.76591408f,  1.86201096f,  1.95810783f,   2.0542047f,  2.15030146f,
     2.24639845f,   2.3424952f,   2.4385922f,  2.53468895f,  2.63078594f,   2.7268827f,  2.82297969f,  2.91907668f,
     3.01517344f,  3.11127043f,  3.20736718f,  3.30346417f,  3.39956093f,  3.49565792f,  3.59175467f,  3.68785167f,
};

DIAGNOSED_TABLE
static const float diagnosed_commit_table[576] = {
           12.44699f,      1.10473323f,    0.0980506465f,   0.00870248955f,  0.000772389816f,  6.85534906e-05f,     -11.2478876f,     0.797948897f,
        0.230248749f,    0.0345856659f,   0.00432553003f,  0.000495378103f,     -5.27219343f,    -0.793708384f,      0.41908437f,     0.126658648f,
       0.0232658889f,   0.00349465944f,      11.3442059f,      1.17713344f,     0.122145437f,    0.0126744406f,   0.00131516543f,  0.000136468341f,
        -11.6765633f,     0.702355385f,     0.271484017f,    0.0487787612f,   0.00719994679f,  0.000968996144f,     -3.58406544f,     -1.19994748f,
        0.435410589f,     0.170297265f,    0.0376076438f,   0.00669267867f,      10.2086086f,      1.23844481f,     0.150240391f,    0.0182262287f,
      0.00221109227f,  0.000268235919f,     -11.9249525f,     0.567004919f,     0.313070893f,    0.0676149875f,    0.0117977839f,   0.00186737522f,
        -1.53009605f,     -1.61591017f,     0.424852341f,       0.2232337f,    0.0596012585f,    0.0125938701f,       9.0590992f,      1.28485358f,
        0.182230979f,    0.0258458499f,   0.00366572081f,   0.00051990978f,     -11.9615793f,     0.392612129f,     0.351985127f,    0.0919465125f,
        0.019001117f,   0.00354028563f,     0.805069864f,     -2.00591135f,     0.378356755f,     0.284335583f,    0.0924263224f,    0.0232470743f,
         7.91714096f,      1.31279075f,     0.217682034f,    0.0360952206f,   0.00598517433f,  0.000992439222f,     -11.7653952f,     0.183655843f,
        0.384396136f,     0.122428641f,     0.030032333f,   0.00659351842f,      3.28965139f,     -2.32798648f,     0.288511723f,     0.350541919f,
        0.139965147f,     0.042026367f,      6.80554628f,      1.31931543f,     0.255760968f,     0.049581524f,   0.00961181708f,   0.00186333561f,
        -11.3299637f,   -0.0512552559f,     0.405921668f,     0.159309238f,    0.0465119667f,    0.0120464712f,       5.7537117f,     -2.53921962f,
        0.151607558f,     0.416370958f,     0.206559405f,    0.0742914006f,      5.74692345f,      1.30250549f,     0.295204967f,    0.0669064224f,
       0.0151639357f,    0.0034368143f,      -10.666296f,    -0.299625248f,     0.412084222f,     0.202183798f,    0.0704797357f,    0.0215619393f,
          8.0079565f,     -2.60291219f,   -0.0303167608f,     0.473731458f,     0.296473563f,     0.128225684f,      4.76194763f,      1.26179051f,
        0.334341198f,     0.088591598f,    0.0234744381f,    0.0062201065f,     -9.80348301f,    -0.546039224f,     0.398940563f,     0.249755427f,
        0.104347177f,    0.0377629139f,      9.87012386f,     -2.49622464f,    -0.248025015f,     0.512251616f,     0.413001835f,     0.215792373f,
         3.86770177f,      1.19815814f,     0.371172071f,     0.114983745f,     0.035620302f,    0.0110346545f,     -8.78663445f,    -0.773811221f,
        0.363796651f,     0.299658298f,      0.15074712f,    0.0646412224f,      11.1937904f,     -2.21634173f,     -0.48483932f,     0.520281613f,
        0.557222903f,     0.353655159f,      3.07634258f,      1.11417747f,     0.403528333f,     0.146148279f,    0.0529313982f,    0.0191704817f,
         -7.6722002f,    -0.967075169f,     0.305870861f,     0.348410845f,     0.212250561f,     0.108042553f,       11.892663f,      -1.7832346f,
       -0.718005896f,     0.486581504f,     0.726513624f,     0.563790202f,      2.39431381f,      1.01381624f,     0.429276824f,      0.18176724f,
       0.0769650936f,    0.0325890705f,     -6.52144241f,     -1.11292446f,       0.2267465f,     0.391557395f,     0.290938258f,     0.176179633f,
         11.9539156f,     -1.23782623f,    -0.921669126f,     0.402508289f,     0.913065612f,     0.873381972f,       1.8222276f,     0.902068138f,
        0.446556091f,     0.221061304f,     0.109433278f,    0.0541733988f,     -5.39331388f,     -1.20315444f,     0.130479231f,     0.424029469f,
        0.387844324f,     0.280080825f,       11.437027f,    -0.635679722f,     -1.07096112f,     0.264316291f,      1.10277236f,      1.31349289f,
         1.35540164f,     0.784446359f,     0.454002708f,     0.262756616f,     0.152071863f,    0.0880124345f,     -4.33812952f,     -1.23523581f,
       0.0232921187f,     0.440713078f,     0.502328455f,      0.43383038f,      10.4588432f,    -0.037667539f,     -1.14632881f,    0.0750577897f,
         1.27493441f,      1.91597652f,     0.984919369f,     0.666429818f,     0.450928956f,     0.305113792f,     0.206450313f,     0.139691263f,
        -3.39316463f,     -1.21233964f,   -0.0871160924f,     0.437158167f,     0.631476641f,     0.654411376f,      9.16945839f,     0.500048041f,
        -1.13709223f,    -0.154435501f,      1.40321517f,        2.708251f,     0.698995173f,      0.55295068f,     0.437420011f,     0.346027702f,
        0.273730457f,     0.216538608f,     -2.58074808f,     -1.14246225f,    -0.192533091f,      0.41032216f,     0.769667268f,     0.960940719f,
         7.72555208f,     0.934344232f,     -1.04340863f,    -0.405879617f,      1.45814753f,      3.70592308f,     0.484403759f,     0.448000252f,
        0.414332509f,     0.383194923f,     0.354397357f,     0.327763975f,     -1.90878201f,     -1.03690279f,    -0.285288841f,     0.359211862f,
        0.908453822f,      1.37311459f,      6.26744032f,      1.24009943f,    -0.876228333f,    -0.655322254f,      1.41121078f,      4.90389633f,
        0.327763975f,     0.354397357f,     0.383194923f,     0.414332509f,     0.448000252f,     0.484403759f,     -1.37311459f,    -0.908453822f,
       -0.359211862f,     0.285288841f,      1.03690279f,      1.90878201f,      4.90389633f,      1.41121078f,    -0.655322254f,    -0.876228333f,
         1.24009943f,      6.26744032f,     0.216538608f,     0.273730457f,     0.346027702f,     0.437420011f,      0.55295068f,     0.698995173f,
       -0.960940719f,    -0.769667268f,     -0.41032216f,     0.192533091f,      1.14246225f,      2.58074808f,      3.70592308f,      1.45814753f,
       -0.405879617f,     -1.04340863f,     0.934344232f,      7.72555208f,     0.139691263f,     0.206450313f,     0.305113792f,     0.450928956f,
        0.666429818f,     0.984919369f,    -0.654411376f,    -0.631476641f,    -0.437158167f,    0.0871160924f,      1.21233964f,      3.39316463f,
           2.708251f,      1.40321517f,    -0.154435501f,     -1.13709223f,     0.500048041f,      9.16945839f,    0.0880124345f,     0.152071863f,
        0.262756616f,     0.454002708f,     0.784446359f,      1.35540164f,     -0.43383038f,    -0.502328455f,    -0.440713078f,   -0.0232921187f,
         1.23523581f,      4.33812952f,      1.91597652f,      1.27493441f,    0.0750577897f,     -1.14632881f,    -0.037667539f,      10.4588432f,
       0.0541733988f,     0.109433278f,     0.221061304f,     0.446556091f,     0.902068138f,       1.8222276f,    -0.280080825f,    -0.387844324f,
       -0.424029469f,    -0.130479231f,      1.20315444f,      5.39331388f,      1.31349289f,      1.10277236f,     0.264316291f,     -1.07096112f,
       -0.635679722f,       11.437027f,    0.0325890705f,    0.0769650936f,      0.18176724f,     0.429276824f,      1.01381624f,      2.39431381f,
       -0.176179633f,    -0.290938258f,    -0.391557395f,      -0.2267465f,      1.11292446f,      6.52144241f,     0.873381972f,     0.913065612f,
        0.402508289f,    -0.921669126f,     -1.23782623f,      11.9539156f,    0.0191704817f,    0.0529313982f,     0.146148279f,     0.403528333f,
         1.11417747f,      3.07634258f,    -0.108042553f,    -0.212250561f,    -0.348410845f,    -0.305870861f,     0.967075169f,       7.6722002f,
        0.563790202f,     0.726513624f,     0.486581504f,    -0.718005896f,      -1.7832346f,       11.892663f,    0.0110346545f,     0.035620302f,
        0.114983745f,     0.371172071f,      1.19815814f,      3.86770177f,   -0.0646412224f,     -0.15074712f,    -0.299658298f,    -0.363796651f,
        0.773811221f,      8.78663445f,     0.353655159f,     0.557222903f,     0.520281613f,     -0.48483932f,     -2.21634173f,      11.1937904f,
       0.0062201065f,    0.0234744381f,     0.088591598f,     0.334341198f,      1.26179051f,      4.76194763f,   -0.0377629139f,    -0.104347177f,
       -0.249755427f,    -0.398940563f,     0.546039224f,      9.80348301f,     0.215792373f,     0.413001835f,     0.512251616f,    -0.248025015f,
        -2.49622464f,      9.87012386f,    0.0034368143f,    0.0151639357f,    0.0669064224f,     0.295204967f,      1.30250549f,      5.74692345f,
      -0.0215619393f,   -0.0704797357f,    -0.202183798f,    -0.412084222f,     0.299625248f,       10.666296f,     0.128225684f,     0.296473563f,
        0.473731458f,   -0.0303167608f,     -2.60291219f,       8.0079565f,   0.00186333561f,   0.00961181708f,     0.049581524f,     0.255760968f,
         1.31931543f,      6.80554628f,   -0.0120464712f,   -0.0465119667f,    -0.159309238f,    -0.405921668f,    0.0512552559f,      11.3299637f,
       0.0742914006f,     0.206559405f,     0.416370958f,     0.151607558f,     -2.53921962f,       5.7537117f,  0.000992439222f,   0.00598517433f,
       0.0360952206f,     0.217682034f,      1.31279075f,      7.91714096f,  -0.00659351842f,    -0.030032333f,    -0.122428641f,    -0.384396136f,
       -0.183655843f,      11.7653952f,     0.042026367f,     0.139965147f,     0.350541919f,     0.288511723f,     -2.32798648f,      3.28965139f,
      0.00051990978f,   0.00366572081f,    0.0258458499f,     0.182230979f,      1.28485358f,       9.0590992f,  -0.00354028563f,    -0.019001117f,
      -0.0919465125f,    -0.351985127f,    -0.392612129f,      11.9615793f,    0.0232470743f,    0.0924263224f,     0.284335583f,     0.378356755f,
        -2.00591135f,     0.805069864f,  0.000268235919f,   0.00221109227f,    0.0182262287f,     0.150240391f,      1.23844481f,      10.2086086f,
     -0.00186737522f,   -0.0117977839f,   -0.0676149875f,    -0.313070893f,    -0.567004919f,      11.9249525f,    0.0125938701f,    0.0596012585f,
          0.2232337f,     0.424852341f,     -1.61591017f,     -1.53009605f,  0.000136468341f,   0.00131516543f,    0.0126744406f,     0.122145437f,
         1.17713344f,      11.3442059f, -0.000968996144f,  -0.00719994679f,   -0.0487787612f,    -0.271484017f,    -0.702355385f,      11.6765633f,
      0.00669267867f,    0.0376076438f,     0.170297265f,     0.435410589f,     -1.19994748f,     -3.58406544f,  6.85534906e-05f,  0.000772389816f,
      0.00870248955f,    0.0980506465f,      1.10473323f,        12.44699f, -0.000495378103f,  -0.00432553003f,   -0.0345856659f,    -0.230248749f,
       -0.797948897f,      11.2478876f,   0.00349465944f,    0.0232658889f,     0.126658648f,      0.41908437f,    -0.793708384f,     -5.27219343f,
};

#endif
