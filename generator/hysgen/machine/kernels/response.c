/* The linear part of a stage over many columns at once, float64: slow states, then parallel filters, then a delay.
 *
 *     c(k)   = x(k) + creep * sum_i s_i(k) / 2,          x(k) = h(k) - h(0)
 *     s_i(k+1) = intake_i x(k) + decay_i s_i(k),         s_i(0) = 0
 *     y(k)   = h(0) + sum_j share_j F_j c(k - delay)
 *
 * F_j: numerator_j / denominator_j in z^-1, from rest. Before the record the stage stood at h(0). With a
 * negative delay the last value is held at the end.
 */

#include <stddef.h>

/* One vector lane per column, because a recurrence cannot be vectorised along time. The vectors are GNU C (gcc, clang);
 * gcc selects wider ones at run time where the processor has them. Each lane computes as a scalar would: equal bits. */
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define WIDEST __attribute__((target_clones("avx2", "default")))
enum { LANES = 4 };
#else
#define WIDEST
enum { LANES = 2 };
#endif
typedef double Lanes __attribute__((vector_size(LANES * sizeof(double))));

enum { MOST_STATES = 64, MOST_BRANCHES = 8, MOST_ORDER = 4, TAPS = MOST_ORDER + 1 };

struct linear {
    size_t states;
    double creep;
    const double *decay, *intake;
    size_t branches;
    const double *share;
    const size_t *order;
    const double *numerator, *denominator;
};

/* y(k) before the delay, of `columns` lanes. */
static inline __attribute__((always_inline)) void step(const struct linear *linear, size_t columns, size_t samples,
                                                       const double *x, const Lanes *start, Lanes *slow,
                                                       Lanes (*state)[TAPS], Lanes *y_before_delay)
{
    Lanes in = {0.0}, crept = {0.0}, total = *start;

    for (size_t l = 0; l < columns; l++) {
        in[l] = x[l * samples];
    }
    in -= *start;
    for (size_t i = 0; i < linear->states; i++) {
        crept += 0.5 * slow[i];
        slow[i] = linear->intake[i] * in + linear->decay[i] * slow[i];
    }
    crept = in + linear->creep * crept;
    for (size_t j = 0; j < linear->branches; j++) {
        const double *b = linear->numerator + j * TAPS, *a = linear->denominator + j * TAPS;
        const Lanes y = b[0] * crept + state[j][0];
        total += linear->share[j] * y;
        for (size_t i = 1; i <= linear->order[j]; i++) {
            state[j][i - 1] = b[i] * crept - a[i] * y + state[j][i];
        }
    }
    *y_before_delay = total;
}

/* Samples of the result that are written: rows[i] for i < count, rising, to out[l * row + i * sample]. */
struct written {
    size_t count;
    const long long *rows;
    size_t row, sample;
};

/* `columns` columns, at most LANES, from `x` on; the other lanes compute with zeros and are not written. */
WIDEST static void pass_rows(const struct linear *linear, size_t columns, size_t samples, const double *x, long delay,
                             const struct written *written, double *out)
{
    Lanes slow[MOST_STATES] = {{0.0}}, state[MOST_BRANCHES][TAPS] = {{{0.0}}}, total = {0.0}, start = {0.0};
    const long end = (long)samples;
    size_t next = 0;

    for (size_t l = 0; l < columns; l++) {
        start[l] = x[l * samples];
    }
    for (; next < written->count && written->rows[next] < delay; next++) {
        for (size_t l = 0; l < columns; l++) {
            out[l * written->row + next * written->sample] = start[l];
        }
    }
    for (long k = 0; k < end; k++) {
        step(linear, columns, samples, x + k, &start, slow, state, &total);
        if (next < written->count && written->rows[next] == k + delay) {
            for (size_t l = 0; l < columns; l++) {
                out[l * written->row + next * written->sample] = total[l];
            }
            next++;
        }
    }
    for (; next < written->count; next++) {
        for (size_t l = 0; l < columns; l++) {
            out[l * written->row + next * written->sample] = total[l];
        }
    }
}

/* `pass_rows` for every sample, with out[l * row + k]. */
WIDEST static void pass(const struct linear *linear, size_t columns, size_t samples, const double *x, long delay,
                        size_t row, double *out)
{
    Lanes slow[MOST_STATES] = {{0.0}}, state[MOST_BRANCHES][TAPS] = {{{0.0}}}, total = {0.0}, start = {0.0};
    const long end = (long)samples;

    for (size_t l = 0; l < columns; l++) {
        start[l] = x[l * samples];
        for (long k = 0; k < delay && k < end; k++) {
            out[l * row + (size_t)k] = start[l];
        }
    }
    for (long k = 0; k < end; k++) {
        step(linear, columns, samples, x + k, &start, slow, state, &total);
        if (k + delay >= 0 && k + delay < end) {
            for (size_t l = 0; l < columns; l++) {
                out[l * row + (size_t)(k + delay)] = total[l];
            }
        }
    }
    for (long k = end + delay < 0 ? 0 : end + delay; k < end; k++) {
        for (size_t l = 0; l < columns; l++) {
            out[l * row + (size_t)k] = total[l];
        }
    }
}

/* Column m of h starts at h[m * samples], column m of the result at out[m * row]. */
void hysgen_respond(size_t columns, size_t samples, const double *h, size_t states, double creep, const double *decay,
                    const double *intake, size_t branches, const double *share, const size_t *order,
                    const double *numerator, const double *denominator, long delay, size_t row, double *out)
{
    const struct linear linear = {states, creep, decay, intake, branches, share, order, numerator, denominator};

    for (size_t first = 0; first < columns; first += LANES) {
        const size_t left = columns - first < LANES ? columns - first : LANES;
        pass(&linear, left, samples, h + first * samples, delay, row, out + first * row);
    }
}

/* The same for some samples: sample rows[i] of column m at out[m * row + i * sample], i < count, rows rising. */
void hysgen_respond_rows(size_t columns, size_t samples, const double *h, size_t states, double creep,
                         const double *decay, const double *intake, size_t branches, const double *share,
                         const size_t *order, const double *numerator, const double *denominator, long delay,
                         size_t count, const long long *rows, size_t row, size_t sample, double *out)
{
    const struct linear linear = {states, creep, decay, intake, branches, share, order, numerator, denominator};
    const struct written written = {count, rows, row, sample};

    for (size_t first = 0; first < columns; first += LANES) {
        const size_t left = columns - first < LANES ? columns - first : LANES;
        pass_rows(&linear, left, samples, h + first * samples, delay, &written, out + first * row);
    }
}
