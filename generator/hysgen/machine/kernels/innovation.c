/* Scalar Kalman filter for a first-order Gauss-Markov misfit m plus white noise n of known variances, float64:
 *
 *   m(k) = keep(k) m(k-1) + sqrt(misfit (1 - keep(k)^2)) w(k),    z(k) = m(k) + n(k)  measured where observed(k) = 1
 */

#include <stddef.h>

/* Kalman gain and innovation variance of each sample; the gain is 0 where observed(k) = 0. */
void hysgen_gains(size_t samples, const double *keep, const double *observed, double misfit, double noise, double *gain,
                  double *variance)
{
    double prior = misfit;
    for (size_t k = 0; k < samples; ++k) {
        const double kept = keep[k] * keep[k];
        prior = kept * prior + (1.0 - kept) * misfit;
        variance[k] = prior + noise;
        gain[k] = observed[k] * (prior / variance[k]);
        prior *= 1.0 - gain[k];
    }
}

/* Replaces each row of z, (rows, samples), by its innovations, times weight(k) = 1/standard deviation. */
void hysgen_innovations(size_t rows, size_t samples, const double *keep, const double *gain, const double *weight,
                        double *z)
{
    for (size_t i = 0; i < rows; ++i, z += samples) {
        double predicted = 0.0;
        for (size_t k = 0; k < samples; ++k) {
            predicted *= keep[k];
            const double innovation = z[k] - predicted;
            predicted += gain[k] * innovation;
            z[k] = weight[k] * innovation;
        }
    }
}
