/* Recursive least squares, Eq. (10) as printed, float64:
 *
 *   K(k) = P(k-1) x / (lambda + x' P(k-1) x)
 *   q(k) = q(k-1) + K(k) (y(k+1) - x' q(k-1))
 *   P(k) = (I - K(k) x') P(k-1) / lambda */

#include <stddef.h>

/* regressors (samples, size), target (samples); q (size) and P (size, size) are updated; work (2 size). */
void hysgen_rls(size_t samples, size_t size, const double *regressors, const double *target, double lambda, double *q,
                double *P, double *work)
{
    double *Px = work;
    double *xP = work + size;
    for (size_t k = 0; k < samples; ++k) {
        const double *x = regressors + k * size;
        double variance = lambda;
        double error = target[k];
        for (size_t i = 0; i < size; ++i) {
            Px[i] = 0.0;
            xP[i] = 0.0;
        }
        for (size_t i = 0; i < size; ++i) {
            const double *row = P + i * size;
            double sum = 0.0;
            for (size_t j = 0; j < size; ++j) {
                sum += row[j] * x[j];
                xP[j] += x[i] * row[j];
            }
            Px[i] = sum;
        }
        for (size_t i = 0; i < size; ++i) {
            variance += x[i] * Px[i];
            error -= x[i] * q[i];
        }
        for (size_t i = 0; i < size; ++i) {
            const double K = Px[i] / variance;
            double *row = P + i * size;
            q[i] += K * error;
            for (size_t j = 0; j < size; ++j) {
                row[j] = (row[j] - K * xP[j]) / lambda;
            }
        }
    }
}
