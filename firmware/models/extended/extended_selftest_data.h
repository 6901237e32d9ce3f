/* extended_selftest_data.h: inputs of the self-test, and the bits that the float32 reference computes from them. */

#ifndef EXTENDED_SELFTEST_DATA_H
#define EXTENDED_SELFTEST_DATA_H

#include <stdint.h>

#include "extended.h"

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
    { 0xf149f2cau, 0x7fc00000u, 0x41db2813u },  /* -1e+30, nan -> 27.3946 */
    { 0x3fcdb977u, 0x3fcfd6a5u, 0x422ef224u },  /* 1.60722, 1.62374 -> 43.7365 */
    { 0x3f98250fu, 0x3f9b4a06u, 0x42416d31u },  /* 1.18863, 1.2132 -> 48.3566 */
    { 0x000116c2u, 0x7f800000u, 0x41d9d854u },  /* 9.99995e-41, inf -> 27.2306 */
    { 0x3fe694d1u, 0x3fe807edu, 0x422c98a0u },  /* 1.80142, 1.81274 -> 43.149 */
    { 0x403922dbu, 0x40386c22u, 0x423e0bb1u },  /* 2.89275, 2.8816 -> 47.5114 */
};

/* correct: arguments, expected result. */
#define EXTENDED_SELFTEST_CORRECT_START_Y 0x3fbd03a8u
#define EXTENDED_SELFTEST_CORRECT_START_U 0x00000000u
#define EXTENDED_SELFTEST_CORRECT_STATUS 0x00000007u
#define EXTENDED_SELFTEST_CORRECT_Y_CLAMPED 2u
#define EXTENDED_SELFTEST_CORRECT_U_CLAMPED 1u
#define EXTENDED_SELFTEST_CORRECT_Y_REJECTED 3u
#define EXTENDED_SELFTEST_CORRECT_U_REJECTED 0u

EXTENDED_TABLE
static const uint32_t extended_selftest_correct_rows[32][2] = {
    { 0xbf3e0f84u, 0x00000000u },  /* -0.742424 -> 0 */
    { 0xbeae2e5cu, 0x00000000u },  /* -0.340197 -> 0 */
    { 0xbfbd03a8u, 0x00000000u },  /* -1.47667 -> 0 */
    { 0x3f829a76u, 0x00000000u },  /* 1.02034 -> 0 */
    { 0xbf944bdfu, 0x00000000u },  /* -1.15857 -> 0 */
    { 0xbfbd03a8u, 0x00000000u },  /* -1.47667 -> 0 */
    { 0xbfb3a949u, 0x00000000u },  /* -1.4036 -> 0 */
    { 0xbe862f8cu, 0x00000000u },  /* -0.262082 -> 0 */
    { 0xf149f2cau, 0x00000000u },  /* -1e+30 -> 0 */
    { 0x3fb88ed2u, 0x00000000u },  /* 1.44186 -> 0 */
    { 0x3fba771au, 0x3bbdf6bfu },  /* 1.45676 -> 0.00579724 */
    { 0xff800000u, 0x3c0eb78fu },  /* -inf -> 0.00871076 */
    { 0x3ec6251cu, 0x3c1b65f7u },  /* 0.387002 -> 0.00948476 */
    { 0xbfbb2d23u, 0x3c1b65f7u },  /* -1.46231 -> 0.00948476 */
    { 0xbfc41e48u, 0x3c1b65f7u },  /* -1.53217 -> 0.00948476 */
    { 0x3fa1445au, 0x3c1b65f7u },  /* 1.2599 -> 0.00948476 */
    { 0x3f671dfcu, 0x3c624402u },  /* 0.902801 -> 0.0138102 */
    { 0x7fc00000u, 0x3c7fd941u },  /* nan -> 0.0156158 */
    { 0xbfae83d8u, 0x3c7fd941u },  /* -1.3634 -> 0.0156158 */
    { 0x3fa35f12u, 0x3c7fd941u },  /* 1.27634 -> 0.0156158 */
    { 0x3fc41e46u, 0x3cadf062u },  /* 1.53217 -> 0.0212328 */
    { 0xbf9e5172u, 0x3cb2c704u },  /* -1.23686 -> 0.0218234 */
    { 0x3ea79120u, 0x3cb2c704u },  /* 0.327279 -> 0.0218234 */
    { 0x7f800000u, 0x3cb823b9u },  /* inf -> 0.022478 */
    { 0x3e89ea68u, 0x3cbc8d87u },  /* 0.269367 -> 0.0230167 */
    { 0xbf791ba1u, 0x3cbc8d87u },  /* -0.973078 -> 0.0230167 */
    { 0xbfbd03a8u, 0x3cbc8d87u },  /* -1.47667 -> 0.0230167 */
    { 0xbe86812cu, 0x3cbc8d87u },  /* -0.262704 -> 0.0230167 */
    { 0xbf02dbf3u, 0x3cbc8d87u },  /* -0.511169 -> 0.0230167 */
    { 0xc09316b6u, 0x3cbc8d87u },  /* -4.59652 -> 0.0230167 */
    { 0xbf1dcb8bu, 0x3cbc8d87u },  /* -0.616387 -> 0.0230167 */
    { 0xbed40068u, 0x3cbc8d87u },  /* -0.414066 -> 0.0230167 */
};

/* learn: arguments, hash of every word of the learner afterwards. */
#define EXTENDED_SELFTEST_LEARN_START_Y 0x3fbd03a8u
#define EXTENDED_SELFTEST_LEARN_START_U 0x00000000u
#define EXTENDED_SELFTEST_LEARN_CALLS 40u  /* more than any commit takes */
#define EXTENDED_SELFTEST_LEARN_AGE 131073u  /* set before row 32: past all waiting times */

EXTENDED_TABLE
static const uint32_t extended_selftest_learn_rows[64][3] = {
    { 0x3fbcf85fu, 0x422062f4u, 0x9aaf65c2u },  /* 1.47633, 40.0966 */
    { 0x3fba93e6u, 0x42246405u, 0xdfddb8b9u },  /* 1.45764, 41.0977 */
    { 0x3fb8d1a6u, 0x41dcec34u, 0xc2177bacu },  /* 1.4439, 27.6153 */
    { 0x3fb964a1u, 0x424dd22au, 0x0d38d856u },  /* 1.44838, 51.4552 */
    { 0x3fb9e9afu, 0x4205eca0u, 0x039f07b1u },  /* 1.45244, 33.4811 */
    { 0x3fb949fdu, 0x421af011u, 0x545737deu },  /* 1.44757, 38.7344 */
    { 0x3fbb937bu, 0x4239dd30u, 0x747f3c7eu },  /* 1.46544, 46.466 */
    { 0x3fbbb7afu, 0x4255b88eu, 0xebd8180au },  /* 1.46654, 53.4302 */
    { 0xbd6353f8u, 0x42366827u, 0x285fceeau },  /* -0.0555, 45.6017 */
    { 0x3fbedd3bu, 0x4216c477u, 0xf96ebba8u },  /* 1.49113, 37.6919 */
    { 0x3fc1c132u, 0x42133197u, 0x5eb38a9cu },  /* 1.51371, 36.7984 */
    { 0x3fc3902du, 0x420705e5u, 0x3e33d4b1u },  /* 1.52784, 33.7558 */
    { 0x3fc44f59u, 0x4210a624u, 0xe7d7c8eau },  /* 1.53367, 36.1622 */
    { 0x3fc4a63eu, 0x423c46bcu, 0x14f58ac6u },  /* 1.53632, 47.0691 */
    { 0x3fc49b98u, 0x42518298u, 0xb210fc99u },  /* 1.536, 52.3775 */
    { 0x3fc532cdu, 0x423ce038u, 0xa04457b7u },  /* 1.54061, 47.219 */
    { 0x3fc756a6u, 0x420871cdu, 0xcc2b5ed0u },  /* 1.55733, 34.1111 */
    { 0x00000000u, 0x422b7b78u, 0xbd655fbau },  /* 0, 42.8706 */
    { 0x3fca4964u, 0x4243006au, 0x0cf8627fu },  /* 1.58036, 48.7504 */
    { 0x3fca90ceu, 0x42177896u, 0x0e8a20a6u },  /* 1.58254, 37.8678 */
    { 0x3fcbf262u, 0x41bc3036u, 0xb8917303u },  /* 1.59333, 23.5235 */
    { 0x3fcdb91fu, 0x421e6d10u, 0x00bcf5e7u },  /* 1.60721, 39.6065 */
    { 0x3fcdacd2u, 0x424ae7efu, 0x9b46ed16u },  /* 1.60684, 50.7265 */
    { 0x3fcbee14u, 0x4240990du, 0xfa3ee054u },  /* 1.5932, 48.1495 */
    { 0x3fccb7e3u, 0x4212df51u, 0x630ab9d9u },  /* 1.59936, 36.7181 */
    { 0x3fcf079fu, 0x421255a4u, 0xbf80be45u },  /* 1.61742, 36.5836 */
    { 0xf149f2cau, 0x425a0f8cu, 0xe4bdfa55u },  /* -1e+30, 54.5152 */
    { 0x3fd0f4eeu, 0x4213001fu, 0xe404db2au },  /* 1.63247, 36.7501 */
    { 0x3fd18f7eu, 0x4216e7bcu, 0xbc7e9c2du },  /* 1.63719, 37.7263 */
    { 0x3fd3ffafu, 0x422ee5afu, 0x4cf41533u },  /* 1.65624, 43.7243 */
    { 0x3fd43c0au, 0x425c68aeu, 0x6d9c4885u },  /* 1.65808, 55.1022 */
    { 0x3fd4be9cu, 0x42114851u, 0x9c324a93u },  /* 1.66207, 36.3206 */
    { 0x3fd6244eu, 0x4219fa49u, 0x859328a7u },  /* 1.67298, 38.4944 */
    { 0x3fd82351u, 0x4245776eu, 0x4cd54d86u },  /* 1.68858, 49.3666 */
    { 0x3fd63fb9u, 0x422a9072u, 0xd30ec004u },  /* 1.67382, 42.6411 */
    { 0x3f5c0602u, 0x421a9707u, 0xd64a9b19u },  /* 0.859467, 38.6475 */
    { 0x3fd85cdau, 0x420a44eau, 0x57d08f86u },  /* 1.69033, 34.5673 */
    { 0x3fd932b8u, 0x420a3eb4u, 0x71b54f77u },  /* 1.69686, 34.5612 */
    { 0x3fd93e1eu, 0x41e48b5bu, 0x2a245ef2u },  /* 1.69721, 28.568 */
    { 0x3fd8d6deu, 0x423deedau, 0x821abe7au },  /* 1.69406, 47.4833 */
    { 0x3fd83158u, 0x423a2358u, 0x6f7b8414u },  /* 1.68901, 46.5345 */
    { 0x3fd7658au, 0x4259af64u, 0xd08b69d8u },  /* 1.68279, 54.4213 */
    { 0x3fd9007au, 0x422527b2u, 0x4a1814e8u },  /* 1.69533, 41.2888 */
    { 0x3fdaaf08u, 0x4215a1a2u, 0x8f3476d0u },  /* 1.70847, 37.4078 */
    { 0x3eba3922u, 0x41c6aa14u, 0x14e22497u },  /* 0.363717, 24.833 */
    { 0x3fddb9f7u, 0x42434ea7u, 0x67d6cbcdu },  /* 1.73224, 48.8268 */
    { 0x3fdd6c09u, 0x4257da81u, 0x79215cb4u },  /* 1.72986, 53.9634 */
    { 0x3fdbe74fu, 0x423ce038u, 0x2552242cu },  /* 1.718, 47.219 */
    { 0x3fddede3u, 0x423230ecu, 0x23fb33d2u },  /* 1.73382, 44.5478 */
    { 0x3fe045dcu, 0x41fa9b31u, 0x40a6354cu },  /* 1.75213, 31.3258 */
    { 0x3fe100beu, 0x423b3295u, 0xf53c7b61u },  /* 1.75784, 46.7994 */
    { 0x3fe1dfa2u, 0x42088e9fu, 0xbf0b5f2bu },  /* 1.76464, 34.1393 */
    { 0x3fe15046u, 0x425692e9u, 0x486fa473u },  /* 1.76026, 53.6435 */
    { 0x3e6398e9u, 0x42475c3du, 0x820e4cb9u },  /* 0.222263, 49.8401 */
    { 0x3fe237f1u, 0x41fa165eu, 0xf1555c93u },  /* 1.76733, 31.2609 */
    { 0x3fe4c28au, 0x42081c2du, 0x50777a7fu },  /* 1.78719, 34.0275 */
    { 0x3fe63470u, 0x41dbd9c8u, 0x0691559cu },  /* 1.79848, 27.4813 */
    { 0x3fe5188au, 0x4230c83eu, 0x77c2ca10u },  /* 1.78981, 44.1955 */
    { 0x3fe41565u, 0x422127cau, 0x63e4856au },  /* 1.7819, 40.2889 */
    { 0x3fe2eb5du, 0x4259a513u, 0xbd1e1f55u },  /* 1.77281, 54.4112 */
    { 0x3fe38245u, 0x41e16398u, 0xbf457c72u },  /* 1.77741, 28.1736 */
    { 0x3fe43c07u, 0x41ec4fd8u, 0xf17f3838u },  /* 1.78308, 29.539 */
    { 0x3fb19e10u, 0x425d96b0u, 0x6a8411bcu },  /* 1.38764, 55.3972 */
    { 0x3fe41e8bu, 0x42114851u, 0xab64b839u },  /* 1.78218, 36.3206 */
};

/* commit: age, calls, answer, hash of every word of instance and learner afterwards, theta before. */
EXTENDED_TABLE
static const uint32_t extended_selftest_commit_rows[10][22] = {
    { 0u, 1u, 2u, 0x7afa4d86u,
0x40b0549eu, 0x3de8b891u, 0x368497eeu, 0x40a2dd4au, 0x3dd6ed4bu, 0x36264b37u, 0x405d5ae7u, 0x3d920283u,
0xb5892dc2u, 0x405d5ad3u, 0x3d91fca9u, 0xb6196b77u, 0x40a2dd36u, 0x3dd6da38u, 0xb5ea8c6du, 0x40b05496u,
0x3de8a549u, 0xb4beb14au
    },
    { 131073u, 37u, 1u, 0x53f68956u,
0x40b0549bu, 0x3de8a6ffu, 0x00000000u, 0x40a2dd4fu, 0x3dd6e298u, 0x00000000u, 0x405d5b15u, 0x3d920793u,
0x00000000u, 0x405d5b15u, 0x3d920793u, 0x00000000u, 0x40a2dd4fu, 0x3dd6e298u, 0x00000000u, 0x40b0549bu,
0x3de8a6ffu, 0x00000000u
    },
    { 131073u, 37u, 1u, 0x078b7625u,
0x40b0549eu, 0x3de8b891u, 0x368497eeu, 0x40a2dd4au, 0x3dd6ed4bu, 0x36264b37u, 0x405d5ae7u, 0x3d920283u,
0xb5892dc2u, 0x405d5ad3u, 0x3d91fca9u, 0xb6196b77u, 0x40a2dd36u, 0x3dd6da38u, 0xb5ea8c6du, 0x40b05496u,
0x3de8a549u, 0xb4beb14au
    },
    { 131073u, 35u, 6u, 0x8d8f732du,
0x40b0549bu, 0x3de8a6ffu, 0x3b48d33bu, 0x40a2dd4fu, 0x3dd6e298u, 0x3b48d33bu, 0x405d5b15u, 0x3d920793u,
0x3b48d33bu, 0x405d5b15u, 0x3d920793u, 0x3b48d33bu, 0x40a2dd4fu, 0x3dd6e298u, 0x3b48d33bu, 0x40b0549bu,
0x3de8a6ffu, 0x3b48d33bu
    },
    { 131073u, 37u, 1u, 0xd94c5877u,
0x40b0549bu, 0x3de8a6ffu, 0xbb48d33bu, 0x40a2dd4fu, 0x3dd6e298u, 0xbb48d33bu, 0x405d5b15u, 0x3d920793u,
0xbb48d33bu, 0x405d5b15u, 0x3d920793u, 0xbb48d33bu, 0x40a2dd4fu, 0x3dd6e298u, 0xbb48d33bu, 0x40b0549bu,
0x3de8a6ffu, 0xbb48d33bu
    },
    { 131073u, 2u, 4u, 0xdb03c3f6u,
0x40b0549bu, 0x3b14e5c2u, 0x00000000u, 0x40a2dd4fu, 0x3b0986c7u, 0x00000000u, 0x405d5b15u, 0x3abaeaf9u,
0x00000000u, 0x405d5b15u, 0x3abaeaf9u, 0x00000000u, 0x40a2dd4fu, 0x3b0986c7u, 0x00000000u, 0x40b0549bu,
0x3b14e5c2u, 0x00000000u
    },
    { 131073u, 2u, 4u, 0x7b6b25bdu,
0x40b0549bu, 0xbde8a6ffu, 0x00000000u, 0x40a2dd4fu, 0xbdd6e298u, 0x00000000u, 0x405d5b15u, 0xbd920793u,
0x00000000u, 0x405d5b15u, 0xbd920793u, 0x00000000u, 0x40a2dd4fu, 0xbdd6e298u, 0x00000000u, 0x40b0549bu,
0xbde8a6ffu, 0x00000000u
    },
    { 131073u, 2u, 5u, 0x91dad2e2u,
0x40e53ac9u, 0x3de8a6ffu, 0x00000000u, 0x40d3b94du, 0x3dd6e298u, 0x00000000u, 0x408fe19au, 0x3d920793u,
0x00000000u, 0x408fe19au, 0x3d920793u, 0x00000000u, 0x40d3b94du, 0x3dd6e298u, 0x00000000u, 0x40e53ac9u,
0x3de8a6ffu, 0x00000000u
    },
    { 131073u, 2u, 5u, 0x1e16195eu,
0xc0e53ac9u, 0x3de8a6ffu, 0x00000000u, 0xc0d3b94du, 0x3dd6e298u, 0x00000000u, 0xc08fe19au, 0x3d920793u,
0x00000000u, 0xc08fe19au, 0x3d920793u, 0x00000000u, 0xc0d3b94du, 0x3dd6e298u, 0x00000000u, 0xc0e53ac9u,
0x3de8a6ffu, 0x00000000u
    },
    { 131073u, 1u, 3u, 0x6cbabcdeu,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u, 0x4e6e6b28u,
0x4e6e6b28u, 0x4e6e6b28u
    },
};

#endif
