/* Columns of a Preisach operator written with play operators, and linear filters over many columns, in float64. */

#include <math.h>
#include <stddef.h>

/* out[m][k] for k < samples: T_1(v) .. T_curve(v), then for each power p = 1 .. degree and each hat b
 *
 *     sum_i hat[i][b] T_p(z_i(k)),    z_i(k) = max(v - r_i, min(v + r_i, z_i(k-1)))
 */
void hysgen_preisach(size_t samples, const double *v, size_t plays, const double *radius, double *state, size_t hats,
                     const double *hat, size_t curve, size_t degree, double *out)
{
    /* Hats overlap in pairs: a play adds to the few hats from first to last only. */
    size_t first[64], last[64];
    for (size_t i = 0; i < plays; i++) {
        first[i] = hats;
        last[i] = 0;
        for (size_t b = 0; b < hats; b++) {
            if (hat[i * hats + b] != 0.0) {
                first[i] = b < first[i] ? b : first[i];
                last[i] = b + 1;
            }
        }
    }
    for (size_t k = 0; k < samples; k++) {
        double *column = out + k;
        double sum[64] = {0.0}, before = 1.0, now = v[k];
        for (size_t m = 0; m < curve; m++) {
            *column = now;
            column += samples;
            const double next = 2.0 * v[k] * now - before;
            before = now;
            now = next;
        }
        for (size_t i = 0; i < plays; i++) {
            const double low = v[k] - radius[i], high = v[k] + radius[i];
            double z = state[i];
            z = z > high ? high : z;
            z = z < low ? low : z;
            state[i] = z;
            double t0 = 1.0, t1 = z;
            for (size_t p = 0; p < degree; p++) {
                for (size_t b = first[i]; b < last[i]; b++) {
                    sum[p * hats + b] += hat[i * hats + b] * t1;
                }
                const double t2 = 2.0 * z * t1 - t0;
                t0 = t1;
                t1 = t2;
            }
        }
        for (size_t m = 0; m < hats * degree; m++) {
            column[m * samples] = sum[m];
        }
    }
}

/* y[m][k] = sum_i b[i] x[m][k-i] - sum_{i>0} a[i] y[m][k-i], from rest; a[0] = 1, order <= 7.
 *
 * A recurrence waits for its own last result; eight columns side by side keep the processor busy meanwhile.
 */
void hysgen_filter(size_t columns, size_t samples, size_t order, const double *b, const double *a, const double *x,
                   double *y)
{
    for (size_t first = 0; first < columns; first += 8) {
        const size_t lanes = columns - first < 8 ? columns - first : 8;
        double state[9][8] = {{0.0}};
        for (size_t k = 0; k < samples; k++) {
            double in[8] = {0.0}, out[8];
            for (size_t l = 0; l < lanes; l++) {
                in[l] = x[(first + l) * samples + k];
            }
            for (size_t l = 0; l < 8; l++) {
                out[l] = b[0] * in[l] + state[0][l];
            }
            for (size_t i = 1; i <= order; i++) {
                for (size_t l = 0; l < 8; l++) {
                    state[i - 1][l] = b[i] * in[l] - a[i] * out[l] + state[i][l];
                }
            }
            for (size_t l = 0; l < lanes; l++) {
                y[(first + l) * samples + k] = out[l];
            }
        }
    }
}

/* out[2 j][k] = d_j,  out[2 j + 1][k] = d_j |d_j|, where d_j forgets along the path, not in time:
 *
 *     d_j(k) = e d_j(k-1) + (1 - e) sign(dv),    dv = v(k) - v(k-1),  e = exp(-|dv| / reach_j)
 */
void hysgen_dahl(size_t samples, const double *v, size_t states, const double *reach, double *out)
{
    for (size_t j = 0; j < states; j++) {
        double d = 0.0, *first = out + 2 * j * samples, *second = first + samples;
        first[0] = second[0] = 0.0;
        for (size_t k = 1; k < samples; k++) {
            const double dv = v[k] - v[k - 1];
            const double e = exp(-fabs(dv) / reach[j]);
            d = e * d + (dv > 0.0 ? 1.0 - e : e - 1.0);
            first[k] = d;
            second[k] = d * fabs(d);
        }
    }
}

/* v(k) = v(k-1) + clamp(u(k) - v(k-1), -step, step), from v(0) = u(0). */
void hysgen_rate_limit(size_t samples, const double *u, double step, double *out)
{
    double v = u[0];
    for (size_t k = 0; k < samples; k++) {
        double gap = u[k] - v;
        gap = gap > step ? step : gap;
        gap = gap < -step ? -step : gap;
        v += gap;
        out[k] = v;
    }
}
