/* A mode driven by hysteretic states that follow the displacement it adds to; over a record, float64.
 *
 * In each of `parts` steps of a sample
 *     x <- lam x + sum_r e_r h_r,   zeta = y + Re x,   d = the change of zeta, s = its sign
 *     w_r = s h_r,   dw/d|zeta| = 1 - p w for w > 0, 1 - q w for w < 0,   h_r = s w_r, held between -box and box
 * by one step of Heun's method. y runs through the samples `y` and, between two of them, through a cubic of the last four.
 */

#include <stddef.h>

enum { MOST = 3 };

static double slope(double w, const double *shape)
{
    return 1.0 - ((w > 0.0) ? shape[0] : shape[1]) * w;
}

/* lam: its two parts; e: (states, 2); shape: (states, 3) p, q and box. out: (samples, 1 + states) Re x and every h at each
 * sample, from rest with h = 0. */
void hysgen_loop(size_t samples, size_t parts, size_t states, const double *y, const double *lam, const double *e,
                 const double *shape, double *out)
{
    double re = 0.0, im = 0.0, h[MOST] = {0.0}, zeta = y[0];

    for (size_t k = 0; k < samples; ++k) {
        const double y1 = y[(k < 1) ? 0 : k - 1], y2 = y[(k < 2) ? 0 : k - 2], y3 = y[(k < 3) ? 0 : k - 3];

        for (size_t i = 1; i <= parts; ++i) {
            const double at = (i < parts) ? 0.0625 * (5.0 * y[k] + 15.0 * y1 - 5.0 * y2 + y3) : y[k];
            double position = lam[0] * re - lam[1] * im, velocity = lam[0] * im + lam[1] * re;

            for (size_t r = 0; r < states; ++r) {
                position += e[2 * r] * h[r];
                velocity += e[2 * r + 1] * h[r];
            }
            re = position;
            im = velocity;
            const double d = at + re - zeta, sign = (d < 0.0) ? -1.0 : 1.0, size = sign * d;

            zeta = at + re;
            for (size_t r = 0; r < states; ++r) {
                const double *own = shape + 3 * r;
                const double w = sign * h[r], first = slope(w, own);
                const double to = w + 0.5 * size * (first + slope(w + size * first, own));

                h[r] = sign * ((to > own[2]) ? own[2] : (to < -own[2]) ? -own[2] : to);
            }
        }
        out[k * (1 + states)] = re;
        for (size_t r = 0; r < states; ++r) {
            out[k * (1 + states) + 1 + r] = h[r];
        }
    }
}
