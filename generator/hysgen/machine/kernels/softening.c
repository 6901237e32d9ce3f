/* Modes whose poles follow a bounded amplitude of their own motion (`model.path.softening`); over a record, float64.
 *
 *     zeta = Re sum_m z_m c_m,   env <- min(env + rate (|zeta| - env), most),   s = env / (1 + env)
 *     lam_m(k) = lam_m + s f_m,  d_m = sum_j Q_mj v_j,   y = Re sum_m c_m
 *     c_m(k+1) = d_m + lam_m(k) (c_m - d_m) + s sum_j R_mj (v_j(k) - v_j(k-1))
 *
 * A row of numbers for each mode: lam, f, z (Re, Im of each), Re Q (drives), Im Q, Re R, Im R.
 */

#include <stddef.h>

#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define WIDEST __attribute__((target_clones("avx2", "default")))
#else
#define WIDEST
#endif

enum { MOST_MODES = 64, MOST_DRIVES = 16, TOGETHER = 32 };
enum { LAM = 0, FALL = 2, SEEN = 4, SHARE = 6 };

static double dot(size_t n, const double *a, const double *b)
{
    double sum = 0.0;
    for (size_t j = 0; j < n; ++j) {
        sum += a[j] * b[j];
    }
    return sum;
}

/* v: (samples, drives). From rest under v(0). c: (samples, 2 modes); moved: (samples, 3) y, zeta and s. */
void hysgen_softening(size_t samples, size_t modes, size_t drives, const double *numbers, double rate, double most,
                      const double *v, double *c, double *moved)
{
    const size_t width = SHARE + 4 * drives;
    double env = 0.0;

    for (size_t k = 0; k < samples; ++k) {
        const double *now = v + k * drives, *last = (k > 0) ? now - drives : now;
        double step[MOST_DRIVES], *x = c + k * 2 * modes, zeta = 0.0, y = 0.0;

        for (size_t j = 0; j < drives; ++j) {
            step[j] = now[j] - last[j];
        }
        for (size_t m = 0; m < modes; ++m) {
            const double *own = numbers + m * width;

            if (k == 0) {
                x[2 * m] = dot(drives, own + SHARE, now);
                x[2 * m + 1] = dot(drives, own + SHARE + drives, now);
            }
            zeta += own[SEEN] * x[2 * m] - own[SEEN + 1] * x[2 * m + 1];
            y += x[2 * m];
        }
        const double size = (zeta < 0.0) ? -zeta : zeta, next = (k == 0) ? size : env + rate * (size - env);

        env = (next > most) ? most : next;
        const double s = env / (1.0 + env);

        moved[3 * k] = y;
        moved[3 * k + 1] = (next > most) ? 0.0 : zeta; /* a limited amplitude does not move with the states */
        moved[3 * k + 2] = s;
        for (size_t m = 0; (k + 1 < samples) && (m < modes); ++m) {
            const double *own = numbers + m * width, *Q = own + SHARE, *R = Q + 2 * drives;
            const double re = own[LAM] + s * own[FALL], im = own[LAM + 1] + s * own[FALL + 1];
            const double d = dot(drives, Q, now), e = dot(drives, Q + drives, now);
            const double a = x[2 * m] - d, b = x[2 * m + 1] - e;

            x[2 * (modes + m)] = d + re * a - im * b + s * dot(drives, R, step);
            x[2 * (modes + m) + 1] = e + re * b + im * a + s * dot(drives, R + drives, step);
        }
    }
}

/* J: (samples, count) dy/d(number) of the numbers first .. first + count - 1, count <= TOGETHER, along a run of
 * `hysgen_softening`; zero at the first sample. */
WIDEST void hysgen_softening_slopes(size_t samples, size_t modes, size_t drives, const double *numbers, double rate,
                                    const double *v, const double *c, const double *moved, size_t first, size_t count,
                                    float *J)
{
    const size_t width = SHARE + 4 * drives;
    float re[MOST_MODES][TOGETHER] = {{0.0f}}, im[MOST_MODES][TOGETHER] = {{0.0f}};
    float env[TOGETHER] = {0.0f}, s[TOGETHER], zeta[TOGETHER];

    for (size_t k = 0; k < samples; ++k) {
        const double *now = v + k * drives, *last = (k > 0) ? now - drives : now, *x = c + k * 2 * modes;
        const double at = moved[3 * k + 1], amplitude = moved[3 * k + 2];
        const float up = (float)((at > 0.0) ? rate : (at < 0.0) ? -rate : 0.0);
        const float stays = (at == 0.0) ? 0.0f : (float)(1.0 - rate), flat = (float)((1.0 - amplitude) * (1.0 - amplitude));
        float y[TOGETHER] = {0.0f};

        for (size_t q = 0; q < TOGETHER; ++q) {
            zeta[q] = 0.0f;
        }
        for (size_t m = 0; m < modes; ++m) {
            const float a = (float)numbers[m * width + SEEN], b = (float)numbers[m * width + SEEN + 1];

            for (size_t q = 0; q < TOGETHER; ++q) {
                zeta[q] += a * re[m][q] - b * im[m][q];
                y[q] += re[m][q];
            }
        }
        for (size_t q = 0; q < count; ++q) {
            const size_t m = (first + q) / width, i = (first + q) % width;

            zeta[q] += (i == SEEN) ? (float)x[2 * m] : (i == SEEN + 1) ? (float)-x[2 * m + 1] : 0.0f;
            J[k * count + q] = y[q];
        }
        for (size_t q = 0; q < TOGETHER; ++q) {
            env[q] = stays * env[q] + up * zeta[q];
            s[q] = flat * env[q];
        }
        for (size_t m = 0; m < modes; ++m) {
            const double *own = numbers + m * width, *Q = own + SHARE, *R = Q + 2 * drives;
            const double a = x[2 * m] - dot(drives, Q, now), b = x[2 * m + 1] - dot(drives, Q + drives, now);
            double forward = own[FALL] * a - own[FALL + 1] * b, turn = own[FALL] * b + own[FALL + 1] * a;
            const float left = (float)(own[LAM] + amplitude * own[FALL]);
            const float turned = (float)(own[LAM + 1] + amplitude * own[FALL + 1]);

            for (size_t j = 0; j < drives; ++j) {
                forward += R[j] * (now[j] - last[j]);
                turn += R[drives + j] * (now[j] - last[j]);
            }
            const float of_re = (float)forward, of_im = (float)turn;

            for (size_t q = 0; q < TOGETHER; ++q) {
                const float p = re[m][q], r = im[m][q];

                re[m][q] = left * p - turned * r + of_re * s[q];
                im[m][q] = left * r + turned * p + of_im * s[q];
            }
        }
        for (size_t q = 0; q < count; ++q) {
            const size_t m = (first + q) / width, i = (first + q) % width;
            const double *own = numbers + m * width, *Q = own + SHARE;

            if (i < SEEN) {
                const double by = (i < FALL) ? 1.0 : amplitude;
                const double a = by * (x[2 * m] - dot(drives, Q, now));
                const double b = by * (x[2 * m + 1] - dot(drives, Q + drives, now));

                re[m][q] += (float)((i % 2 == 0) ? a : -b);
                im[m][q] += (float)((i % 2 == 0) ? b : a);
            } else if (i >= SHARE) {
                const size_t place = i - SHARE, j = place % drives;
                const int share = place < 2 * drives, whole = (place / drives) % 2 == 0;
                const double left = 1.0 - own[LAM] - amplitude * own[FALL];
                const double turned = -(own[LAM + 1] + amplitude * own[FALL + 1]);
                const double a = share ? left * now[j] : amplitude * (now[j] - last[j]);
                const double b = share ? turned * now[j] : 0.0;

                re[m][q] += (float)(whole ? a : -b);
                im[m][q] += (float)(whole ? b : a);
            }
        }
    }
}
