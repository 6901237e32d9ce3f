/* The linear part of a stage over many columns at once, float64: slow states, then parallel filters, then a delay.
 *
 *     c(k)   = direct x(k) + creep * sum_i s_i(k) / 2,          x(k) = h(k) - h(0)
 *     s_i(k+1) = intake_i x(k) + decay_i s_i(k),         s_i(0) = 0
 *     y(k)   = h(0) + sum_j share_j F_j c(k - delay)
 *
 * F_j: numerator_j / denominator_j in z^-1, from rest. Before the record the stage stood at h(0). With a
 * negative delay the last value is held at the end.
 */

#include <stddef.h>
#include <stdint.h>

/* One vector lane per column, because a recurrence cannot be vectorised along time. The vectors are GNU C (gcc, clang);
 * gcc selects wider ones at run time where the processor has them. Each lane computes as a scalar would: equal bits.
 * Several vectors go through a recurrence together, because each of its operations waits for the one before it. */
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define WIDEST __attribute__((target_clones("avx2", "default")))
enum { LANES = 4 };
#define ACROSS(c, k) ((Lanes){(c)[0][k], (c)[1][k], (c)[2][k], (c)[3][k]})
#else
#define WIDEST
enum { LANES = 2 };
#define ACROSS(c, k) ((Lanes){(c)[0][k], (c)[1][k]})
#endif
typedef double Lanes __attribute__((vector_size(LANES * sizeof(double))));

enum { MOST_STATES = 64, MOST_BRANCHES = 8, MOST_ORDER = 4, TAPS = MOST_ORDER + 1, MOST_VECTORS = 2 };
enum { BLOCK = 32, TOGETHER = 3 };

struct linear {
    size_t states;
    double direct, creep;
    const double *decay, *intake;
    size_t branches;
    const double *share;
    const size_t *order;
    const double *numerator, *denominator;
};

/* States of all columns of a pass, and the signals of one block of samples. */
struct pass {
    Lanes start[MOST_VECTORS], slow[MOST_STATES][MOST_VECTORS], filter[MOST_BRANCHES][TAPS][MOST_VECTORS];
    Lanes x[BLOCK][MOST_VECTORS], crept[BLOCK][MOST_VECTORS], y[BLOCK][MOST_VECTORS];
};

#define INLINE static inline __attribute__((always_inline))

/* crept(k) += s_i(k) of n samples, for the states i = first .. first + count - 1. */
INLINE void slow_states(const struct linear *linear, size_t first, const size_t count, const size_t vectors, size_t n,
                        struct pass *at)
{
    Lanes s[TOGETHER][MOST_VECTORS];
    for (size_t i = 0; i < count; i++) {
        for (size_t v = 0; v < vectors; v++) {
            s[i][v] = at->slow[first + i][v];
        }
    }
    for (size_t k = 0; k < n; k++) {
        for (size_t v = 0; v < vectors; v++) {
            const Lanes x = at->x[k][v];
            Lanes crept = at->crept[k][v];
            for (size_t i = 0; i < count; i++) {
                crept += s[i][v];
                s[i][v] = linear->intake[first + i] * x + linear->decay[first + i] * s[i][v];
            }
            at->crept[k][v] = crept;
        }
    }
    for (size_t i = 0; i < count; i++) {
        for (size_t v = 0; v < vectors; v++) {
            at->slow[first + i][v] = s[i][v];
        }
    }
}

/* crept(k) = direct x(k) + creep * sum_i s_i(k) / 2 of n samples. */
INLINE void creep(const struct linear *linear, const size_t vectors, size_t n, struct pass *at)
{
    for (size_t k = 0; k < n; k++) {
        for (size_t v = 0; v < vectors; v++) {
            at->crept[k][v] = (Lanes){0.0};
        }
    }
    size_t first = 0;
    for (; first + TOGETHER <= linear->states; first += TOGETHER) {
        slow_states(linear, first, TOGETHER, vectors, n, at);
    }
    for (; first < linear->states; first++) {
        slow_states(linear, first, 1, vectors, n, at);
    }
    for (size_t k = 0; k < n; k++) {
        for (size_t v = 0; v < vectors; v++) {
            at->crept[k][v] = linear->direct * at->x[k][v] + linear->creep * (0.5 * at->crept[k][v]);
        }
    }
}

/* y(k) += share_j F_j c(k) of n samples, for the filters j = first .. first + count - 1 of at most this order. */
INLINE void filters(const struct linear *linear, size_t first, const size_t count, const size_t order,
                    const size_t vectors, size_t n, struct pass *at)
{
    const double *b = linear->numerator + first * TAPS, *a = linear->denominator + first * TAPS;
    Lanes state[2][TAPS][MOST_VECTORS];
    for (size_t j = 0; j < count; j++) {
        for (size_t i = 0; i <= order; i++) {
            for (size_t v = 0; v < vectors; v++) {
                state[j][i][v] = at->filter[first + j][i][v];
            }
        }
    }
    for (size_t k = 0; k < n; k++) {
        for (size_t v = 0; v < vectors; v++) {
            const Lanes in = at->crept[k][v];
            Lanes y = at->y[k][v];
            for (size_t j = 0; j < count; j++) {
                const Lanes out = b[j * TAPS] * in + state[j][0][v];
                y += linear->share[first + j] * out;
                for (size_t i = 1; i <= order; i++) {
                    state[j][i - 1][v] = b[j * TAPS + i] * in - a[j * TAPS + i] * out + state[j][i][v];
                }
            }
            at->y[k][v] = y;
        }
    }
    for (size_t j = 0; j < count; j++) {
        for (size_t i = 0; i < order; i++) {
            for (size_t v = 0; v < vectors; v++) {
                at->filter[first + j][i][v] = state[j][i][v];
            }
        }
    }
}

/* y of n samples, before the delay. */
INLINE void block(const struct linear *linear, const size_t vectors, size_t n, struct pass *at)
{
    creep(linear, vectors, n, at);
    for (size_t k = 0; k < n; k++) {
        for (size_t v = 0; v < vectors; v++) {
            at->y[k][v] = at->start[v];
        }
    }
    size_t first = 0;
    for (; vectors == 1 && first + 2 <= linear->branches; first += 2) {
        filters(linear, first, 2, MOST_ORDER, vectors, n, at);
    }
    for (; first < linear->branches; first++) {
        if (linear->order[first] <= 2) {
            filters(linear, first, 1, 2, vectors, n, at);
        } else {
            filters(linear, first, 1, MOST_ORDER, vectors, n, at);
        }
    }
}

/* Samples of the result that are written: rows[i] for i < count, rising, to out[l * row + i * sample] for column l;
 * rows 0: every sample, rows[i] = i. */
struct written {
    size_t count;
    const int64_t *rows;
    size_t row, sample;
};

INLINE long at_row(const struct written *written, size_t i)
{
    return written->rows ? (long)written->rows[i] : (long)i;
}

INLINE void write(const struct written *written, size_t i, size_t columns, const Lanes *value, double *out)
{
    for (size_t l = 0; l < columns; l++) {
        out[l * written->row + i * written->sample] = value[l / LANES][l % LANES];
    }
}

/* The samples first .. first + n - 1 of the result, as far as they exist: their number. */
INLINE size_t write_block(const struct written *written, long first, size_t n, size_t columns,
                          Lanes (*const value)[MOST_VECTORS], double *out)
{
    const size_t from = first < 0 ? (size_t)-first : 0, room = written->count - (size_t)(first + (long)from);
    const size_t end = n < from + room ? n : from + room;
    for (size_t l = 0; l < columns; l++) {
        for (size_t k = from; k < end; k++) {
            out[l * written->row + k + (size_t)first] = value[k][l / LANES][l % LANES];
        }
    }
    return end > from ? end - from : 0;
}

/* `columns` columns from `h` on, in `vectors` vectors; the lanes left over repeat the first column. */
INLINE void columns_in(const size_t vectors, const struct linear *linear, size_t columns, size_t samples,
                       const double *h, long delay, const struct written *written, double *out)
{
    struct pass at;
    const double *column[MOST_VECTORS * LANES];
    size_t next = 0, n = 0;

    for (size_t i = 0; i < linear->states; i++) {
        for (size_t v = 0; v < vectors; v++) {
            at.slow[i][v] = (Lanes){0.0};
        }
    }
    for (size_t j = 0; j < linear->branches; j++) {
        for (size_t i = 0; i < TAPS; i++) {
            for (size_t v = 0; v < vectors; v++) {
                at.filter[j][i][v] = (Lanes){0.0};
            }
        }
    }
    for (size_t l = 0; l < vectors * LANES; l++) {
        column[l] = h + (l < columns ? l : 0) * samples;
        at.start[l / LANES][l % LANES] = *column[l];
    }
    for (; next < written->count && at_row(written, next) < delay; next++) {
        write(written, next, columns, at.start, out);
    }
    for (size_t first = 0; first < samples && next < written->count; first += n) {
        n = samples - first < BLOCK ? samples - first : BLOCK;
        for (size_t v = 0; v < vectors; v++) {
            for (size_t k = 0; k < n; k++) {
                at.x[k][v] = ACROSS(column + v * LANES, first + k) - at.start[v];
            }
        }
        block(linear, vectors, n, &at);
        if (!written->rows) {
            next += write_block(written, (long)first + delay, n, columns, at.y, out);
        }
        for (; next < written->count && at_row(written, next) < (long)(first + n) + delay; next++) {
            write(written, next, columns, at.y[at_row(written, next) - delay - (long)first], out);
        }
    }
    for (; next < written->count; next++) {
        write(written, next, columns, at.y[n - 1], out);
    }
}

WIDEST static void pass(const struct linear *linear, size_t columns, size_t samples, const double *h, long delay,
                        const struct written *written, double *out)
{
    size_t taken = 0;
    for (size_t first = 0; first < columns; first += taken) {
        const size_t left = columns - first, room = MOST_VECTORS * LANES;
        const double *from = h + first * samples;
        double *to = out + first * written->row;
        taken = left < room ? left : room;
        if (taken <= LANES) {
            columns_in(1, linear, taken, samples, from, delay, written, to);
        } else {
            columns_in(MOST_VECTORS, linear, taken, samples, from, delay, written, to);
        }
    }
}

/* Column m of h starts at h[m * samples], column m of the result at out[m * row]. */
void hysgen_respond(size_t columns, size_t samples, const double *h, size_t states, double direct, double creep, const double *decay,
                    const double *intake, size_t branches, const double *share, const size_t *order,
                    const double *numerator, const double *denominator, long delay, size_t row, double *out)
{
    const struct linear linear = {states, direct, creep, decay, intake, branches, share, order, numerator, denominator};
    const struct written every = {samples, NULL, row, 1};

    pass(&linear, columns, samples, h, delay, &every, out);
}

/* The same for some samples: sample rows[i] of column m at out[m * row + i * sample], i < count, rows rising. */
void hysgen_respond_rows(size_t columns, size_t samples, const double *h, size_t states, double direct, double creep,
                         const double *decay, const double *intake, size_t branches, const double *share,
                         const size_t *order, const double *numerator, const double *denominator, long delay,
                         size_t count, const int64_t *rows, size_t row, size_t sample, double *out)
{
    const struct linear linear = {states, direct, creep, decay, intake, branches, share, order, numerator, denominator};
    const struct written written = {count, rows, row, sample};

    pass(&linear, columns, samples, h, delay, &written, out);
}
