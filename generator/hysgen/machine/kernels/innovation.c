/* A signal that is a fading misfit plus white noise, seen by the scalar Kalman filter that knows their variances, float64:
 *
 *   m(k) = keep(k) m(k-1) + sqrt(misfit (1 - keep(k)^2)) w(k),    z(k) = m(k) + n(k)  where heard(k), else nothing
 */

#include <stddef.h>

/* Gain of each correction, and variance of each innovation; a sample that is not heard corrects nothing. */
void hysgen_gains(size_t samples, const double *keep, const double *heard, double misfit, double noise, double *gain,
                  double *variance)
{
    double spread = misfit;
    for (size_t k = 0; k < samples; ++k) {
        const double kept = keep[k] * keep[k];
        spread = kept * spread + (1.0 - kept) * misfit;
        variance[k] = spread + noise;
        gain[k] = heard[k] * (spread / variance[k]);
        spread *= 1.0 - gain[k];
    }
}

/* Each row of z, (rows, samples), becomes its innovations divided by their standard deviations. */
void hysgen_innovations(size_t rows, size_t samples, const double *keep, const double *gain, const double *weight,
                        double *z)
{
    for (size_t i = 0; i < rows; ++i, z += samples) {
        double foreseen = 0.0;
        for (size_t k = 0; k < samples; ++k) {
            foreseen *= keep[k];
            const double news = z[k] - foreseen;
            foreseen += gain[k] * news;
            z[k] = weight[k] * news;
        }
    }
}
