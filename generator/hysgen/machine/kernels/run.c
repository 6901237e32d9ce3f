/* The model over whole records, float64:  y(k+1) = a(y) y + b(y) u(k) + c(y) + w(k),  w = theta . phi. */

#include "rules.h"

#include <stdint.h>

/* Free run: out[0] = y0, out[k+1] from out[k]. Returns the number of samples in which y was clamped. */
int64_t hysgen_free_run(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                        const double *w, double y0, double *out)
{
    const partition_t grid = {rules, range[0], range[1], range[2], range[3], q};
    int64_t outside = 0;
    double y = y0;
    for (size_t k = 0; k < samples; ++k) {
        int clamped;
        out[k] = y;
        y = step_ahead(&grid, y, u[k], w[k], &clamped);
        outside += clamped;
    }
    return outside;
}

/* One step ahead: out[0] = measured[0], out[k+1] from measured[k]. Returns the number of samples in which y was clamped. */
int64_t hysgen_one_step(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                        const double *w, const double *measured, double *out)
{
    const partition_t grid = {rules, range[0], range[1], range[2], range[3], q};
    int64_t outside = 0;
    out[0] = measured[0];
    for (size_t k = 0; k + 1 < samples; ++k) {
        int clamped;
        out[k + 1] = step_ahead(&grid, measured[k], u[k], w[k], &clamped);
        outside += clamped;
    }
    return outside;
}

/* From measured[s] at s = 0, stride, 2 stride, ..., free run to the last of the rising `horizons`; at each horizon
 * accumulate the squared error and the largest error. held[s], a bias estimated from samples up to s, is added to every
 * step from s. Starts without room for the last horizon are left out: every horizon is scored from the same starts. */
void hysgen_horizon(size_t rules, const double *range, const double *q, size_t samples, const double *u,
                    const double *w, const double *held, const double *measured, size_t stride, size_t count,
                    const int64_t *horizons, double *square, double *largest, int64_t *starts)
{
    const partition_t grid = {rules, range[0], range[1], range[2], range[3], q};
    const size_t longest = (size_t)horizons[count - 1];
    for (size_t start = 0; start + longest < samples; start += stride) {
        double y = measured[start];
        size_t next = 0;
        for (size_t h = 1; h <= longest; ++h) {
            int clamped;
            const size_t k = start + h;
            y = step_ahead(&grid, y, u[k - 1], w[k - 1] + held[start], &clamped);
            if ((size_t)horizons[next] == h) {
                const double error = y - measured[k];
                square[next] += error * error;
                largest[next] = (fabs(error) > largest[next]) ? fabs(error) : largest[next];
                ++next;
            }
        }
        *starts += 1;
    }
}

/* Regressors of the consequents, Eq. (9): row k is [p_1 y, p_1 u, p_1, p_2 y, ...]; out is (samples, columns), of
 * which the first 3 rules columns are written. */
void hysgen_regressors(size_t rules, const double *range, size_t samples, const double *u, const double *y,
                       size_t columns, double *out)
{
    const partition_t grid = {rules, range[0], range[1], range[2], range[3], NULL};
    for (size_t k = 0; k < samples; ++k) {
        firing_t f;
        double *row = out + k * columns;
        fire(&grid, y[k], &f);
        for (size_t i = 0; i < 3 * rules; ++i) {
            row[i] = 0.0;
        }
        for (size_t i = 0; i < f.count; ++i) {
            row[3 * (f.first + i)] = f.p[i] * f.y;
            row[3 * (f.first + i) + 1] = f.p[i] * u[k];
            row[3 * (f.first + i) + 2] = f.p[i];
        }
    }
}
