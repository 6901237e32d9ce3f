/* States that recur from sample to sample, over a whole record, float64.
 *
 * play   z_j(k) = max(u(k) - r_j, min(u(k) + r_j, z_j(k-1)))
 * lag    s_j(k+1) = s_j(k) + q_j (u(k) - s_j(k))                                         q real
 * mode   c_j(k+1) = c_j(k) + q_j (u(k) - c_j(k)),  c = position + i velocity, q = 1 - p    p the discrete pole below the axis
 * slew   v(k) = max(v(k-1) - fall, min(v(k-1) + rise, u(k)))
 *
 * Plays and slew return the state after u(k) acts, lags and modes the state before u(k) acts.
 */

#include <stddef.h>
#include <stdint.h>

void hysgen_play(size_t samples, size_t plays, const double *u, const double *half_width, double *state, double *out)
{
    for (size_t k = 0; k < samples; ++k) {
        for (size_t j = 0; j < plays; ++j) {
            const double low = u[k] - half_width[j];
            const double high = u[k] + half_width[j];
            double z = state[j];
            z = (z > high) ? high : z;
            z = (z < low) ? low : z;
            state[j] = z;
            out[k * plays + j] = z;
        }
    }
}

void hysgen_lags(size_t samples, size_t lags, const double *u, const double *q, double *s, double *out)
{
    for (size_t k = 0; k < samples; ++k) {
        for (size_t j = 0; j < lags; ++j) {
            out[k * lags + j] = s[j];
            s[j] += q[j] * (u[k] - s[j]);
        }
    }
}

enum { TOGETHER = 8 };

/* One lag of several signals: out[l * count + i] is the state of signal l before its sample rows[i] acts; rows rising.
 * Signal l is u[l * samples ...]; s_l(0) = u_l(0). The recurrences of TOGETHER signals run side by side, because each
 * step of one waits for the step before it. Columns left over repeat the last signal. */
void hysgen_lag_signals(size_t signals, size_t samples, const double *u, double q, size_t count, const int64_t *rows,
                        double *out)
{
    for (size_t first = 0; first < signals; first += TOGETHER) {
        const double *signal[TOGETHER];
        double s[TOGETHER];
        const size_t lanes = (signals - first < TOGETHER) ? signals - first : TOGETHER;
        size_t k = 0;
        for (size_t l = 0; l < TOGETHER; ++l) {
            signal[l] = u + (first + ((l < lanes) ? l : lanes - 1)) * samples;
            s[l] = signal[l][0];
        }
        for (size_t i = 0; i < count; ++i) {
            for (; k < (size_t)rows[i]; ++k) {
                for (size_t l = 0; l < TOGETHER; ++l) {
                    s[l] += q * (signal[l][k] - s[l]);
                }
            }
            for (size_t l = 0; l < lanes; ++l) {
                out[(first + l) * count + i] = s[l];
            }
        }
    }
}

/* out(k) = the sum over j of s_j(k), before u(k) acts. */
void hysgen_lag_sums(size_t samples, size_t lags, const double *u, const double *q, double *s, double *out)
{
    for (size_t k = 0; k < samples; ++k) {
        double sum = 0.0;
        for (size_t j = 0; j < lags; ++j) {
            sum += s[j];
            s[j] += q[j] * (u[k] - s[j]);
        }
        out[k] = sum;
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

void hysgen_slew(size_t samples, const double *u, double rise, double fall, double start, double *out)
{
    double v = start;
    for (size_t k = 0; k < samples; ++k) {
        const double low = v - fall;
        const double high = v + rise;
        v = (u[k] > high) ? high : u[k];
        v = (v < low) ? low : v;
        out[k] = v;
    }
}
