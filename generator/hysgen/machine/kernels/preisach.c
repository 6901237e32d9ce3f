/* Columns of a Preisach operator expanded in play operators, columns of Duhem states, and a rate limiter, float64. */

#include <math.h>
#include <stddef.h>

/* Loops over the samples of one block have no recurrence: gcc selects wider vectors where the processor has them. */
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define WIDEST __attribute__((target_clones("avx2", "default")))
#else
#define WIDEST
#endif

#define INLINE static inline __attribute__((always_inline))
#if defined(__GNUC__) && !defined(__clang__)
#define UNROLLED _Pragma("GCC unroll 8")
#else
#define UNROLLED
#endif

enum { MOST = 128, BLOCK = 64, TOGETHER = 8 };

#define BEND (1.0 / 32.0) /* curvature of the barrier: 4 ln(attempts per sample) = 32 */
#define FROZEN 15.0       /* distance from the threshold, in units of s, from which on a play rests */
#define RELAXED 8.0       /* a play relaxes by this many s beyond 1 - r at most */

/* Relaxation of a play over one sample by thermal activation, v being held; s = share r:
 *
 *     z <- z + s exp(-a (1 + a/32)) sign(v - z),   a = (r - |v - z|) / s,   |z| <= min(1, 1 - r + 8 s)
 */
INLINE double relaxed(double z, double v, double r, double share)
{
    const double s = share * r, way = v - z, inside = (r - fabs(way)) / s, a = inside > 0.0 ? inside : 0.0;
    const double reach = 1.0 - r + RELAXED * s, end = reach < 1.0 ? reach : 1.0;
    if (a > FROZEN) {
        return z;
    }
    const double to = z + copysign(s * exp(-a * (1.0 + BEND * a)), way), most = to < end ? to : end;
    return most > -end ? most : -end;
}

/* z[j][k] for the plays j < count and the samples k < n of a block; state: z before the block, on return after it.
 * Several plays at once, because each step of a play waits for the one before it.
 */
INLINE void moved(const size_t count, size_t n, const double *u, const double *radius, const double share,
                  double *restrict state, double (*restrict z)[BLOCK])
{
    double now[TOGETHER];
    for (size_t j = 0; j < count; j++) {
        now[j] = state[j];
    }
    for (size_t k = 0; k < n; k++) {
        UNROLLED for (size_t j = 0; j < count; j++) {
            const double low = u[k] - radius[j], high = u[k] + radius[j];
            now[j] = now[j] > high ? high : now[j];
            now[j] = now[j] < low ? low : now[j];
            z[j][k] = now[j];
            now[j] = share > 0.0 ? relaxed(now[j], u[k], radius[j], share) : now[j];
        }
    }
    for (size_t j = 0; j < count; j++) {
        state[j] = now[j];
    }
}

/* `moved` for the next TOGETHER plays of those that are left. */
INLINE void moved_together(size_t left, size_t n, const double *u, const double *radius, double share, double *state,
                           double (*z)[BLOCK])
{
    if (left < TOGETHER) {
        moved(left, n, u, radius, share, state, z);
    } else if (share > 0.0) {
        moved(TOGETHER, n, u, radius, share, state, z);
    } else {
        moved(TOGETHER, n, u, radius, 0.0, state, z);
    }
}

/* next[k] = T_(p+1)(z[k]), from now = T_p and before = T_(p-1) on a whole block. */
INLINE void next_polynomial(const double *z, const double *before, const double *now, double *restrict next)
{
    for (size_t k = 0; k < BLOCK; k++) {
        next[k] = 2.0 * z[k] * now[k] - before[k];
    }
}

/* sum[k] += sum over p < degree of weights[p] T_(p+1)(z[k]) on a whole block; one: T_0. */
INLINE void add_series(size_t degree, const double *weights, const double *one, const double *z, double *restrict sum)
{
    double polynomials[3][BLOCK];
    const double *before = one, *now = z;
    for (size_t p = 0; p < degree; p++) {
        double *next = polynomials[p % 3];
        for (size_t k = 0; k < BLOCK; k++) {
            sum[k] += weights[p] * now[k];
            next[k] = 2.0 * z[k] * now[k] - before[k];
        }
        before = now;
        now = next;
    }
}

/* total[k] = or += weight now[k] for k < n. */
INLINE void add(int begins, size_t n, double weight, const double *now, double *restrict total)
{
    if (begins) {
        for (size_t k = 0; k < n; k++) {
            total[k] = weight * now[k];
        }
    } else {
        for (size_t k = 0; k < n; k++) {
            total[k] += weight * now[k];
        }
    }
}

/* out[m][k] for k < samples: T_1(v) .. T_curve(v), then for each power p = 1 .. degree and each hat b
 *
 *     sum_i hat[i][b] T_p(z_i(k)),    z_i(k) = max(v - r_i, min(v + r_i, z_i(k-1)))
 *
 * Block by block of samples: only the plays z_i are a recurrence in k. Each sum adds the plays in the order of i.
 * share > 0: every play relaxes after each sample (`relaxed`).
 */
WIDEST void hysgen_preisach(size_t samples, const double *v, size_t plays, const double *radius, double share,
                            double *state, size_t hats, const double *hat, size_t curve, size_t degree, double *out)
{
    double u[BLOCK] = {0.0}, places[TOGETHER][BLOCK] = {{0.0}}, one[BLOCK], polynomials[3][BLOCK];
    /* A hat is zero outside the few neighbouring plays first .. last - 1. */
    size_t first[MOST], last[MOST];
    for (size_t b = 0; b < hats; b++) {
        first[b] = plays;
        last[b] = 0;
        for (size_t i = 0; i < plays; i++) {
            if (hat[i * hats + b] != 0.0) {
                first[b] = i < first[b] ? i : first[b];
                last[b] = i + 1;
            }
        }
    }
    for (size_t k = 0; k < BLOCK; k++) {
        one[k] = 1.0;
    }
    for (size_t m = 0; m < degree * hats; m++) {
        for (size_t k = 0; first[m % hats] == plays && k < samples; k++) {
            out[(curve + m) * samples + k] = 0.0;
        }
    }
    for (size_t start = 0; start < samples; start += BLOCK) {
        const size_t n = samples - start < BLOCK ? samples - start : BLOCK;
        double *column = out + start;
        for (size_t k = 0; k < n; k++) {
            u[k] = v[start + k];
        }
        const double *before = one, *now = u;
        for (size_t m = 0; m < curve; m++, column += samples) {
            double *next = polynomials[m % 3];
            add(1, n, 1.0, now, column);
            next_polynomial(u, before, now, next);
            before = now;
            now = next;
        }
        for (size_t i = 0; i < plays; i++) {
            const double *z = places[i % TOGETHER];
            if (i % TOGETHER == 0) {
                moved_together(plays - i, n, u, radius + i, share, state + i, places);
            }
            before = one;
            now = z;
            for (size_t p = 0; p < degree; p++) {
                for (size_t b = 0; b < hats; b++) {
                    if (i >= first[b] && i < last[b]) {
                        add(i == first[b], n, hat[i * hats + b], now, column + (p * hats + b) * samples);
                    }
                }
                double *next = polynomials[p % 3];
                next_polynomial(z, before, now, next);
                before = now;
                now = next;
            }
        }
    }
}

/* out[k] = sum over m of terms[m] T_(m+1)(v) + sum over i and p of play[i][p] T_(p+1)(z_i), z_i as in `hysgen_preisach`:
 * the sum of its columns for one set of weights, without the columns.
 */
WIDEST void hysgen_preisach_path(size_t samples, const double *v, size_t plays, const double *radius, double share,
                                 double *state, size_t curve, const double *terms, size_t degree, const double *play,
                                 double *out)
{
    double u[BLOCK] = {0.0}, places[TOGETHER][BLOCK] = {{0.0}}, one[BLOCK], sum[BLOCK];
    for (size_t k = 0; k < BLOCK; k++) {
        one[k] = 1.0;
    }
    for (size_t start = 0; start < samples; start += BLOCK) {
        const size_t n = samples - start < BLOCK ? samples - start : BLOCK;
        for (size_t k = 0; k < n; k++) {
            u[k] = v[start + k];
        }
        for (size_t k = 0; k < BLOCK; k++) {
            sum[k] = 0.0;
        }
        add_series(curve, terms, one, u, sum);
        for (size_t i = 0; i < plays; i++) {
            if (i % TOGETHER == 0) {
                moved_together(plays - i, n, u, radius + i, share, state + i, places);
            }
            add_series(degree, play + i * degree, one, places[i % TOGETHER], sum);
        }
        for (size_t k = 0; k < n; k++) {
            out[start + k] = sum[k];
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

/* Curve and plays as Chebyshev series, and Duhem states with b d + c d |d|:
 *
 *     h = sum_m curve[m] T_m(v) + sum_j sum_p play[j][p] T_(p+1)(z_j) + sum_i (duhem[2 i] d_i + duhem[2 i + 1] d_i |d_i|)
 *
 * share > 0: every play relaxes after each sample (`relaxed`).
 */
typedef struct {
    size_t terms, plays, degree, states;
    double share;
    const double *curve, *radius, *play, *reach, *duhem;
} operator_t;

/* h at the input v after `state`: z_j, then d_i, then the last input. moves: whether the state goes on to v. */
INLINE double operator_at(const operator_t *self, double v, double *state, int moves)
{
    double *z = state, *d = state + self->plays, *last = d + self->states;
    double before = 1.0, now = v, h = self->curve[0];
    for (size_t m = 1; m < self->terms; m++) {
        h += self->curve[m] * now;
        const double next = 2.0 * v * now - before;
        before = now;
        now = next;
    }
    for (size_t j = 0; j < self->plays; j++) {
        const double low = v - self->radius[j], high = v + self->radius[j];
        double place = z[j] > high ? high : z[j];
        place = place < low ? low : place;
        before = 1.0;
        now = place;
        for (size_t p = 0; p < self->degree; p++) {
            h += self->play[j * self->degree + p] * now;
            const double next = 2.0 * place * now - before;
            before = now;
            now = next;
        }
        if (moves) {
            z[j] = self->share > 0.0 ? relaxed(place, v, self->radius[j], self->share) : place;
        }
    }
    const double dv = v - *last;
    for (size_t i = 0; i < self->states; i++) {
        const double e = exp(-fabs(dv) / self->reach[i]);
        const double to = e * d[i] + (dv > 0.0 ? 1.0 - e : e - 1.0);
        h += self->duhem[2 * i] * to + self->duhem[2 * i + 1] * to * fabs(to);
        d[i] = moves ? to : d[i];
    }
    *last = moves ? v : *last;
    return h;
}

/* out[k] = h(k) along v; state: before the first sample, on return that of the last. */
void hysgen_hysteresis(size_t samples, const double *v, size_t terms, const double *curve, size_t plays, size_t degree,
                       const double *radius, double share, const double *play, size_t states, const double *reach,
                       const double *duhem, double *state, double *out)
{
    const operator_t self = {terms, plays, degree, states, share, curve, radius, play, reach, duhem};
    for (size_t k = 0; k < samples; k++) {
        out[k] = operator_at(&self, v[k], state, 1);
    }
}

enum { MOST_TRIALS = 60 };

/* out[k] = the v(k) in -1 .. 1 with h(k) = wanted[k], where h rises or falls with v; the nearer end where there is none.
 * Regula falsi after Anderson and Bjorck, BIT 13 (1973) 253-264, which halves the bracket where it would be slow.
 */
void hysgen_hysteresis_inverse(size_t samples, const double *wanted, size_t terms, const double *curve, size_t plays,
                               size_t degree, const double *radius, double share, const double *play, size_t states,
                               const double *reach, const double *duhem, double *state, double *out)
{
    const operator_t self = {terms, plays, degree, states, share, curve, radius, play, reach, duhem};
    for (size_t k = 0; k < samples; k++) {
        double a = -1.0, b = 1.0;
        double fa = operator_at(&self, a, state, 0) - wanted[k], fb = operator_at(&self, b, state, 0) - wanted[k];
        double v = fabs(fa) < fabs(fb) ? a : b;
        for (size_t n = 0; n < MOST_TRIALS && fa * fb < 0.0 && fabs(b - a) > 1e-15; n++) {
            v = n % 3 == 2 ? 0.5 * (a + b) : b - fb * (b - a) / (fb - fa);
            const double f = operator_at(&self, v, state, 0) - wanted[k];
            if (f * fb < 0.0) {
                a = b;
                fa = fb;
            } else {
                const double slope = 1.0 - f / fb;
                fa *= slope > 0.0 ? slope : 0.5;
            }
            b = v;
            fb = f;
        }
        out[k] = v;
        (void)operator_at(&self, v, state, 1);
    }
}
