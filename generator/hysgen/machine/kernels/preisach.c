/* Columns of a Preisach operator expanded in play operators, columns of Duhem states, and a rate limiter, float64. */

#include <math.h>
#include <stddef.h>

/* out[m][k] for k < samples: T_1(v) .. T_curve(v), then for each power p = 1 .. degree and each hat b
 *
 *     sum_i hat[i][b] T_p(z_i(k)),    z_i(k) = max(v - r_i, min(v + r_i, z_i(k-1)))
 */
void hysgen_preisach(size_t samples, const double *v, size_t plays, const double *radius, double *state, size_t hats,
                     const double *hat, size_t curve, size_t degree, double *out)
{
    /* A hat is zero outside the few neighbouring plays first .. last - 1. */
    size_t first[64], last[64];
    double weight[64][64];
    for (size_t b = 0; b < hats; b++) {
        first[b] = plays;
        last[b] = 0;
        for (size_t i = 0; i < plays; i++) {
            weight[b][i] = hat[i * hats + b];
            if (weight[b][i] != 0.0) {
                first[b] = i < first[b] ? i : first[b];
                last[b] = i + 1;
            }
        }
    }
    for (size_t k = 0; k < samples; k++) {
        double *column = out + k, chebyshev[64][64], before = 1.0, now = v[k];
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
        }
        for (size_t i = 0; i < plays; i++) {
            double t0 = 1.0, t1 = state[i];
            for (size_t p = 0; p < degree; p++) {
                chebyshev[p][i] = t1;
                const double t2 = 2.0 * state[i] * t1 - t0;
                t0 = t1;
                t1 = t2;
            }
        }
        for (size_t p = 0; p < degree; p++) {
            for (size_t b = 0; b < hats; b++) {
                double sum = 0.0;
                for (size_t i = first[b]; i < last[b]; i++) {
                    sum += weight[b][i] * chebyshev[p][i];
                }
                *column = sum;
                column += samples;
            }
        }
    }
}

/* out[2 j][k] = d_j,  out[2 j + 1][k] = d_j |d_j|, the states d_j, which decay with the way of v and not with time:
 *
 *     d_j(k) = e d_j(k-1) + (1 - e) sign(dv),    dv = v(k) - v(k-1),  e = exp(-|dv| / reach_j)
 */
void hysgen_duhem(size_t samples, const double *v, size_t states, const double *reach, double *out)
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

/* out[k] = h of one path: curve and plays as Chebyshev series, Duhem states with b d + c d |d|.
 *
 *     h = sum_m curve[m] T_m(v) + sum_j sum_p play[j][p] T_(p+1)(z_j) + sum_i (duhem[2 i] d_i + duhem[2 i + 1] d_i |d_i|)
 *
 * state: z_j, then d_i, then the input before the first sample; on return those of the last sample.
 */
void hysgen_hysteresis(size_t samples, const double *v, size_t terms, const double *curve, size_t plays, size_t degree,
                       const double *radius, const double *play, size_t states, const double *reach,
                       const double *duhem, double *state, double *out)
{
    double *z = state, *d = state + plays, *last = d + states;
    for (size_t k = 0; k < samples; k++) {
        double before = 1.0, now = v[k], h = curve[0];
        for (size_t m = 1; m < terms; m++) {
            h += curve[m] * now;
            const double next = 2.0 * v[k] * now - before;
            before = now;
            now = next;
        }
        for (size_t j = 0; j < plays; j++) {
            const double low = v[k] - radius[j], high = v[k] + radius[j];
            z[j] = z[j] > high ? high : z[j];
            z[j] = z[j] < low ? low : z[j];
            before = 1.0;
            now = z[j];
            for (size_t p = 0; p < degree; p++) {
                h += play[j * degree + p] * now;
                const double next = 2.0 * z[j] * now - before;
                before = now;
                now = next;
            }
        }
        const double dv = v[k] - *last;
        for (size_t i = 0; i < states; i++) {
            const double e = exp(-fabs(dv) / reach[i]);
            d[i] = e * d[i] + (dv > 0.0 ? 1.0 - e : e - 1.0);
            h += duhem[2 * i] * d[i] + duhem[2 * i + 1] * d[i] * fabs(d[i]);
        }
        *last = v[k];
        out[k] = h;
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
