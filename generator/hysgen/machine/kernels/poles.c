/* Banks of first-order states over a whole record, float64; what is written is the state before u(k) acts.
 *
 * lags   s(k+1) = s(k) + q (u(k) - s(k))                                           q real
 * modes  c(k+1) = c(k) + q (u(k) - c(k)),  c = position + i velocity, q = 1 - p      p the discrete pole below the axis
 */

#include <stddef.h>

void hysgen_lags(size_t samples, size_t lags, const double *u, const double *q, double *s, double *out)
{
    for (size_t k = 0; k < samples; ++k) {
        for (size_t j = 0; j < lags; ++j) {
            out[k * lags + j] = s[j];
            s[j] += q[j] * (u[k] - s[j]);
        }
    }
}

/* state and out hold position and velocity of each mode side by side; q real and imaginary part likewise. */
void hysgen_modes(size_t samples, size_t modes, const double *u, const double *q, double *state, double *out)
{
    for (size_t k = 0; k < samples; ++k) {
        for (size_t j = 0; j < modes; ++j) {
            const double position = state[2 * j], velocity = state[2 * j + 1];
            const double away = u[k] - position;
            out[2 * (k * modes + j)] = position;
            out[2 * (k * modes + j) + 1] = velocity;
            state[2 * j] = position + (q[2 * j] * away + q[2 * j + 1] * velocity);
            state[2 * j + 1] = velocity + (q[2 * j + 1] * away - q[2 * j] * velocity);
        }
    }
}
