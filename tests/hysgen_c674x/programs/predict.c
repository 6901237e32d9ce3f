/* One step of a Takagi-Sugeno model with six rules: one exponential, Estrin's scheme, one reciprocal, no branch.
 *
 *     y(k+1) = sum_l p_l (a_l y + b_l u + c_l),   p_l = w_l r^l / sum_j w_j r^j,   r = exp((y - centre) / h)
 */
#include <stdint.h>

float predict(float y_um, float u_V);

typedef union {
    float value;
    uint32_t bits;
} image_t;

static float from_bits(uint32_t bits)
{
    image_t image;
    image.bits = bits;
    return image.value;
}

static uint32_t to_bits(float value)
{
    image_t image;
    image.value = value;
    return image.bits;
}

static float clamped(float x, float low, float high)
{
    uint32_t below = 0u - (uint32_t)(x < low), above = 0u - (uint32_t)(x > high);
    return from_bits((to_bits(x) & ~(below | above)) | (to_bits(low) & below) | (to_bits(high) & above));
}

/* 2^k (1 + f + f^2/2 + ...): k by adding 1.5 * 2^23, whose last bits then hold it. */
static float exponential(float x)
{
    const float shifted = x * 1.44269504f + 12582912.0f;
    const float k = shifted - 12582912.0f;
    const float f = (x - k * 0.693359375f) - k * -2.12194440e-4f;
    const float f2 = f * f;
    const float p = (1.0f + f) + f2 * ((0.5f + 0.166666567f * f) + f2 * (0.0416648909f + 0.00836344343f * f));
    return from_bits(to_bits(p) + (to_bits(shifted) << 23));
}

static float reciprocal(float d)
{
    float r = from_bits(0x7EF311C7u - to_bits(d));
    r = r * (2.0f - d * r);
    r = r * (2.0f - d * r);
    return r * (2.0f - d * r);
}

#define QUINTIC(c0, c1, c2, c3, c4, c5) ((c0 + c1 * r) + r2 * ((c2 + c3 * r) + r2 * (c4 + c5 * r)))

float predict(float y_um, float u_V)
{
    const float y = clamped(y_um, 0.6608f, 3.7359f), u = clamped(u_V, -20.0f, 120.0f);
    const float r = exponential((y - 2.19835f) * 1.6259633f), r2 = r * r;
    const float of_y = QUINTIC(0.9f, 6.5f, 11.2f, 11.1f, 6.8f, 1.05f);
    const float of_u = QUINTIC(0.002f, 0.013f, 0.022f, 0.021f, 0.012f, 0.0021f);
    const float of_1 = QUINTIC(0.01f, 0.07f, 0.12f, 0.11f, 0.06f, 0.012f);
    const float sum = QUINTIC(1.0f, 7.389f, 12.18f, 12.1f, 7.3f, 1.1f);
    return ((of_y * y + of_u * u) + of_1) * reciprocal(sum);
}
