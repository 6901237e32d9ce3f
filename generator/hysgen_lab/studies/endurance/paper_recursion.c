/* Eq. (10) in float32 exactly as printed: K = P x / (lambda + x' P x), q += K e, P = (I - K x') P / lambda.
 *
 * regressors: rows of `size`; target in um; P and q are updated in place.
 * Returns 1 + index of the first row after which a diagonal element of P is not positive or a value is not finite;
 * 0 if there is no such row. */

#include <math.h>
#include <stddef.h>
#include <stdint.h>

enum { MOST_PARAMETERS = 64 };

uint64_t paper_recursion(size_t rows, size_t size, const float *regressors, const float *target, float lambda, float *P,
    float *q)
{
    for (size_t k = 0; k < rows; ++k) {
        const float *x = &regressors[k * size];
        float Px[MOST_PARAMETERS], xP[MOST_PARAMETERS], K[MOST_PARAMETERS];
        float error = target[k];
        float denominator = lambda;
        int valid = 1;

        for (size_t i = 0; i < size; ++i) {
            Px[i] = 0.0f;
            xP[i] = 0.0f;
            for (size_t j = 0; j < size; ++j) {
                Px[i] += P[i * size + j] * x[j];
                xP[i] += x[j] * P[j * size + i];
            }
            error -= x[i] * q[i];
        }
        for (size_t i = 0; i < size; ++i) {
            denominator += x[i] * Px[i];
        }
        for (size_t i = 0; i < size; ++i) {
            K[i] = Px[i] / denominator;
            q[i] += K[i] * error;
        }
        for (size_t i = 0; i < size; ++i) {
            for (size_t j = 0; j < size; ++j) {
                P[i * size + j] = (P[i * size + j] - K[i] * xP[j]) / lambda;
            }
        }
        for (size_t i = 0; i < size; ++i) {
            valid &= P[i * size + i] > 0.0f && isfinite(P[i * size + i]) && isfinite(q[i]);
        }
        if (!valid) {
            return (uint64_t)k + 1u;
        }
    }
    return 0u;
}
