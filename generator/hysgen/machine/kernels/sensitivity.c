/* Free run with exact sensitivities, and the sums that a Gauss-Newton step needs, float64, in one pass:
 *
 *   S(k) = dy(k)/d(parameters),   S(k+1) = f_y(y(k), u(k)) S(k) + [regressors of the rules, extra(k)],   S(0) = 0
 *   H = sum_k t(k) S(k) S(k)',   g = sum_k t(k) S(k) e(k),   e(k) = y(k) - measured(k)
 *
 * The extra columns enter the next output directly: regressors of terms, or derivatives by shape parameters. */

#include "rules.h"

#include <stdint.h>

/* Adds to hessian (upper triangle of (size, size)), gradient (size) and sums (2): weighted square error and weight.
 * sensitivity (size): work space for S. Returns the number of samples in which y was clamped. */
int64_t hysgen_sensitivity(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                           const double *w, size_t extras, const double *extra, const double *measured,
                           const double *trust, double *sensitivity, double *hessian, double *gradient, double *sums)
{
    const partition_t grid = {rules, range[0], range[1], range[2], range[3], q};
    const size_t size = 3 * rules + extras;
    int64_t outside = 0;
    double y = measured[0];
    for (size_t i = 0; i < size; ++i) {
        sensitivity[i] = 0.0;
    }
    for (size_t k = 0; k + 1 < samples; ++k) {
        firing_t f;
        fire(&grid, y, &f);
        const local_t mean = consequent(&grid, &f);
        const double gain = slope(&grid, &f, &mean, u[k]);
        y = mean.a * f.y + mean.b * u[k] + mean.c + w[k];
        outside += f.clamped;
        for (size_t i = 0; i < size; ++i) {
            sensitivity[i] *= gain;
        }
        for (size_t i = 0; i < f.count; ++i) {
            double *rule = sensitivity + 3 * (f.first + i);
            rule[0] += f.p[i] * f.y;
            rule[1] += f.p[i] * u[k];
            rule[2] += f.p[i];
        }
        for (size_t i = 0; i < extras; ++i) {
            sensitivity[3 * rules + i] += extra[k * extras + i];
        }
        const double weight = trust[k + 1];
        if (weight > 0.0) {
            const double error = y - measured[k + 1];
            sums[0] += weight * error * error;
            sums[1] += weight;
            for (size_t i = 0; i < size; ++i) {
                const double scaled = weight * sensitivity[i];
                double *row = hessian + i * size;
                gradient[i] += scaled * error;
                for (size_t j = i; j < size; ++j) {
                    row[j] += scaled * sensitivity[j];
                }
            }
        }
    }
    return outside;
}
