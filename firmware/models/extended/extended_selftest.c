/* extended_selftest.c: inputs and expected bits from the float32 reference. */

#include "extended_selftest.h"

#include "extended.h"

static float extended_selftest_float(uint32_t bits)
{
    const union {
        uint32_t bits;
        float number;
    } pattern = { .bits = bits };

    return pattern.number;
}

static uint32_t extended_selftest_bits(float x)
{
    const union {
        float number;
        uint32_t bits;
    } pattern = { .number = x };

    return pattern.bits;
}

/* predict: arguments, expected result. */
static const uint32_t extended_selftest_predict_rows[32][3] = {
    { 0x3fc7c4a7u, 0x41e48b5bu, 0x3fc49881u },  /* 1.56069, 28.568 -> 1.5359 */
    { 0x3fd3362fu, 0x423deedau, 0x3fcfff39u },  /* 1.65009, 47.4833 -> 1.62498 */
    { 0x000116c2u, 0xf149f2cau, 0x3c25c79cu },  /* 9.99995e-41, -1e+30 -> 0.0101184 */
    { 0x4024cea6u, 0x4259af64u, 0x40237423u },  /* 2.57511, 54.4213 -> 2.55396 */
    { 0x3f7848d8u, 0x422527b2u, 0x3f791045u },  /* 0.969862, 41.2888 -> 0.972905 */
    { 0x7fc00000u, 0xff800000u, 0x3f7efd0eu },  /* nan, -inf -> 0.996049 */
    { 0x40084a38u, 0x41c6aa14u, 0x40083c33u },  /* 2.12953, 24.833 -> 2.12867 */
    { 0x40301886u, 0x42434ea7u, 0x402eee7du },  /* 2.7515, 48.8268 -> 2.73331 */
    { 0x00000000u, 0x41b00000u, 0x3ca1daecu },  /* 0, 22 -> 0.0197577 */
    { 0x3fac4728u, 0x4224b20au, 0x3fadc705u },  /* 1.34592, 41.1739 -> 1.35764 */
    { 0x3fa2108fu, 0x423230ecu, 0x3fa19f42u },  /* 1.26613, 44.5478 -> 1.26267 */
    { 0x40c08f5cu, 0x7fc00000u, 0x403d2cd3u },  /* 6.0175, nan -> 2.95586 */
    { 0x3f9acac9u, 0x423b3295u, 0x3f9cd97du },  /* 1.20931, 46.7994 -> 1.22539 */
    { 0x400bbca8u, 0x42088e9fu, 0x400b9d91u },  /* 2.18339, 34.1393 -> 2.18149 */
    { 0x403ec8b4u, 0x42600000u, 0x403d9a0fu },  /* 2.981, 56 -> 2.96253 */
    { 0x3fb95cf3u, 0x42475c3du, 0x3fba2d2cu },  /* 1.44815, 49.8401 -> 1.4545 */
    { 0x3f835843u, 0x41fa165eu, 0x3f8722edu },  /* 1.02613, 31.2609 -> 1.05575 */
    { 0x80000000u, 0xc1400000u, 0x3d27226fu },  /* -0, -12 -> 0.0408043 */
    { 0x401558d6u, 0x41dbd9c8u, 0x401441a8u },  /* 2.33355, 27.4813 -> 2.31651 */
    { 0x3fae49ebu, 0x4230c83eu, 0x3facebb0u },  /* 1.36163, 44.1955 -> 1.35094 */
    { 0xf149f2cau, 0x000116c2u, 0xbd23a968u },  /* -1e+30, 9.99995e-41 -> -0.0399565 */
    { 0x3fc22a51u, 0x4259a513u, 0x3fc249e7u },  /* 1.51692, 54.4112 -> 1.51788 */
    { 0x4020a453u, 0x41e16398u, 0x401ec3a1u },  /* 2.51003, 28.1736 -> 2.48069 */
    { 0xff800000u, 0x7f800000u, 0x401e490du },  /* -inf, inf -> 2.47321 */
    { 0x3fa1256cu, 0x425d96b0u, 0x3fa14b05u },  /* 1.25895, 55.3972 -> 1.2601 */
    { 0x3f9f9bf8u, 0x424deac5u, 0x3f9fe06eu },  /* 1.24695, 51.4793 -> 1.24904 */
    { 0x7f800000u, 0x80000000u, 0x3fa30b4au },  /* inf, -0 -> 1.27378 */
    { 0x3fa1832cu, 0x41e75c7cu, 0x3fa4790fu },  /* 1.26182, 28.9202 -> 1.28494 */
    { 0x3facabf3u, 0x424fae67u, 0x3fac3ef5u },  /* 1.349, 51.9203 -> 1.34567 */
    { 0xbd6353f8u, 0x00000000u, 0xbd170727u },  /* -0.0555, 0 -> -0.0368721 */
    { 0x4039a70cu, 0x424421acu, 0x4038603fu },  /* 2.90082, 49.0329 -> 2.88087 */
    { 0x3deadf91u, 0x41b8c525u, 0x3e031d96u },  /* 0.114684, 23.0963 -> 0.128043 */
};

static uint32_t extended_selftest_predict(void)
{
    extended_t self;
    uint32_t mismatches = 0u;

    extended_init(&self, extended_selftest_float(0x3fbb3b64u), extended_selftest_float(0x00000000u));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = extended_selftest_predict_rows[k];
        float result;

        result = extended_predict(&self, extended_selftest_float(row[0]), extended_selftest_float(row[1]));
        mismatches += (uint32_t)(extended_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != 0x0000000fu);
    mismatches += (uint32_t)(self.y_clamped != 2u);
    mismatches += (uint32_t)(self.u_clamped != 6u);
    mismatches += (uint32_t)(self.y_rejected != 3u);
    mismatches += (uint32_t)(self.u_rejected != 3u);

    return mismatches;
}

/* simulate: arguments, expected result. */
static const uint32_t extended_selftest_simulate_rows[32][2] = {
    { 0x4238cbd0u, 0x3fb84f46u },  /* 46.199 -> 1.43992 */
    { 0x41d5633du, 0x3fb61f17u },  /* 26.6735 -> 1.42282 */
    { 0xc1400000u, 0x3fb6313eu },  /* -12 -> 1.42338 */
    { 0x423003bcu, 0x3fb50079u },  /* 44.0036 -> 1.41408 */
    { 0x422814fcu, 0x3fb38342u },  /* 42.0205 -> 1.40244 */
    { 0x000116c2u, 0x3fb47321u },  /* 9.99995e-41 -> 1.40976 */
    { 0x420b023au, 0x3fb51c92u },  /* 34.7522 -> 1.41493 */
    { 0x42237aa1u, 0x3fb3d7cbu },  /* 40.8698 -> 1.40502 */
    { 0xf149f2cau, 0x3fb3b064u },  /* -1e+30 -> 1.40382 */
    { 0x42128c9bu, 0x3fb3e293u },  /* 36.6373 -> 1.40535 */
    { 0x41d9d1a0u, 0x3fb26d48u },  /* 27.2274 -> 1.39396 */
    { 0x42b40000u, 0x3fb2257du },  /* 90 -> 1.39177 */
    { 0x41f12613u, 0x3fb1c0bbu },  /* 30.1436 -> 1.38869 */
    { 0x42224f0fu, 0x3fb3d9a1u },  /* 40.5772 -> 1.40508 */
    { 0x42600000u, 0x3fb44e0au },  /* 56 -> 1.40863 */
    { 0x42104aaeu, 0x3fb5d27cu },  /* 36.0729 -> 1.42049 */
    { 0x41db8135u, 0x3fb8aa17u },  /* 27.4381 -> 1.44269 */
    { 0x80000000u, 0x3fb969b6u },  /* -0 -> 1.44854 */
    { 0x41d17e14u, 0x3fb88f29u },  /* 26.1866 -> 1.44187 */
    { 0x42433be9u, 0x3fb6b1efu },  /* 48.8085 -> 1.42731 */
    { 0xff800000u, 0x3fb5b00cu },  /* -inf -> 1.41944 */
    { 0x42049220u, 0x3fb74e9eu },  /* 33.1427 -> 1.43209 */
    { 0x42476b63u, 0x3fb9682fu },  /* 49.8549 -> 1.44849 */
    { 0x7fc00000u, 0x3fba2ba2u },  /* nan -> 1.45446 */
    { 0x42434d4fu, 0x3fbc91c1u },  /* 48.8255 -> 1.4732 */
    { 0x41dd9852u, 0x3fbf326fu },  /* 27.6994 -> 1.49373 */
    { 0x41b00000u, 0x3fc1112bu },  /* 22 -> 1.50834 */
    { 0x425ecf6eu, 0x3fc0599fu },  /* 55.7026 -> 1.50274 */
    { 0x420c4ceau, 0x3fbf2806u },  /* 35.0751 -> 1.49341 */
    { 0x00000000u, 0x3fc12c49u },  /* 0 -> 1.50916 */
    { 0x41b381d0u, 0x3fc1736fu },  /* 22.4384 -> 1.51134 */
    { 0x4253ef26u, 0x3fbfbb3eu },  /* 52.9835 -> 1.4979 */
};

static uint32_t extended_selftest_simulate(void)
{
    extended_t self;
    uint32_t mismatches = 0u;

    extended_init(&self, extended_selftest_float(0x3fbb3b64u), extended_selftest_float(0x00000000u));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = extended_selftest_simulate_rows[k];
        float result;

        result = extended_simulate(&self, extended_selftest_float(row[0]));
        mismatches += (uint32_t)(extended_selftest_bits(result) != row[1]);
    }
    mismatches += (uint32_t)(self.status != 0x0000000au);
    mismatches += (uint32_t)(self.y_clamped != 0u);
    mismatches += (uint32_t)(self.u_clamped != 7u);
    mismatches += (uint32_t)(self.y_rejected != 0u);
    mismatches += (uint32_t)(self.u_rejected != 2u);

    return mismatches;
}

/* inverse: arguments, expected result. */
static const uint32_t extended_selftest_inverse_rows[32][3] = {
    { 0x4029d07du, 0x4026cba5u, 0x41b0004cu },  /* 2.65335, 2.60618 -> 22.0001 */
    { 0x3f4469fbu, 0x3f426473u, 0x41b0001au },  /* 0.767242, 0.759345 -> 22 */
    { 0x403ec8b4u, 0xbd6353f8u, 0x41b00002u },  /* 2.981, -0.0555 -> 22 */
    { 0x3e97f763u, 0x3e95be0fu, 0x41b00002u },  /* 0.296809, 0.292466 -> 22 */
    { 0x3ecfd6cdu, 0x3ecd6e1du, 0x41b00000u },  /* 0.405936, 0.401231 -> 22 */
    { 0xff800000u, 0x80000000u, 0x41b00000u },  /* -inf, -0 -> 22 */
    { 0x3ed2a264u, 0x3ed0375eu, 0x41b00001u },  /* 0.411395, 0.406672 -> 22 */
    { 0x3f104d4eu, 0x3f0ee61du, 0x41b00000u },  /* 0.56368, 0.558199 -> 22 */
    { 0x80000000u, 0xf149f2cau, 0x41b00000u },  /* -0, -1e+30 -> 22 */
    { 0x3e81c36eu, 0x3e7f491au, 0x41b00000u },  /* 0.253444, 0.249302 -> 22 */
    { 0x3f9e12cdu, 0x3f9bc5fdu, 0x41b00012u },  /* 1.23495, 1.21698 -> 22 */
    { 0x7f800000u, 0x40c08f5cu, 0x4244cccfu },  /* inf, 6.0175 -> 49.2 */
    { 0x40057852u, 0x400333efu, 0x41e66666u },  /* 2.08547, 2.05004 -> 28.8 */
    { 0x3faf72b6u, 0x3facc4f2u, 0x41b00000u },  /* 1.37069, 1.34976 -> 22 */
    { 0xbd6353f8u, 0x000116c2u, 0x4244cccdu },  /* -0.0555, 9.99995e-41 -> 49.2 */
    { 0x401ed9eau, 0x401c074bu, 0x41e66666u },  /* 2.48205, 2.43795 -> 28.8 */
    { 0x3e77dce1u, 0x3e73aff6u, 0x41b00000u },  /* 0.242054, 0.237976 -> 22 */
    { 0x7fc00000u, 0xff800000u, 0x41b00000u },  /* nan, -inf -> 22 */
    { 0x3f37ac13u, 0x3f35d867u, 0x41b00000u },  /* 0.717469, 0.710333 -> 22 */
    { 0x3eb546b9u, 0x3eb2f33cu, 0x41b00000u },  /* 0.354055, 0.349512 -> 22 */
    { 0x40c08f5cu, 0x403ec8b4u, 0x4244cccdu },  /* 6.0175, 2.981 -> 49.2 */
    { 0x4034f244u, 0x4031c6bcu, 0x41e66666u },  /* 2.82729, 2.77775 -> 28.8 */
    { 0x4026bcecu, 0x4023c4f2u, 0x41b00000u },  /* 2.60528, 2.5589 -> 22 */
    { 0x00000000u, 0x00000000u, 0x41b00000u },  /* 0, 0 -> 22 */
    { 0x40192948u, 0x401674dau, 0x41b00000u },  /* 2.39314, 2.35088 -> 22 */
    { 0x4001c44au, 0x3fff2909u, 0x41b00000u },  /* 2.02761, 1.99344 -> 22 */
    { 0xf149f2cau, 0x7fc00000u, 0x41b00000u },  /* -1e+30, nan -> 22 */
    { 0x3fcbca54u, 0x3fc889f6u, 0x41b00000u },  /* 1.59211, 1.56671 -> 22 */
    { 0x3f96b292u, 0x3f9490a2u, 0x41b00000u },  /* 1.17732, 1.16066 -> 22 */
    { 0x000116c2u, 0x7f800000u, 0x41b00000u },  /* 9.99995e-41, inf -> 22 */
    { 0x3fe46bd9u, 0x3fe0b026u, 0x41b00000u },  /* 1.78454, 1.75538 -> 22 */
    { 0x40376be1u, 0x4034390fu, 0x41b00000u },  /* 2.86596, 2.81598 -> 22 */
};

static uint32_t extended_selftest_inverse(void)
{
    extended_t self;
    uint32_t mismatches = 0u;

    extended_init(&self, extended_selftest_float(0x3fbb3b64u), extended_selftest_float(0x00000000u));
    for (uint32_t k = 0u; k < 32u; ++k) {
        const uint32_t *row = extended_selftest_inverse_rows[k];
        float result;

        result = extended_inverse(&self, extended_selftest_float(row[0]), extended_selftest_float(row[1]));
        mismatches += (uint32_t)(extended_selftest_bits(result) != row[2]);
    }
    mismatches += (uint32_t)(self.status != 0x00000037u);
    mismatches += (uint32_t)(self.y_clamped != 2u);
    mismatches += (uint32_t)(self.u_clamped != 28u);
    mismatches += (uint32_t)(self.y_rejected != 5u);
    mismatches += (uint32_t)(self.u_rejected != 0u);

    return mismatches;
}

uint32_t extended_selftest(void)
{
    uint32_t mismatches = 0u;

    mismatches += extended_selftest_predict();
    mismatches += extended_selftest_simulate();
    mismatches += extended_selftest_inverse();

    return mismatches;
}
