/* Firing strengths and weighted consequents at one displacement, float64, shared by the kernels.
 *
 *   s = (y - first)/h,  n = the nearest centre,  t = s - n,  |t| <= 1/2
 *   mu_{n+j} = exp(-(t - j)^2/2)  is proportional to  W_j r^j,  W_j = exp(-j^2/2),  r = exp(t)
 *
 * The factor exp(-t^2/2), common to all rules, drops out of p_l, so one exponential serves all of them. Only the rules
 * |j| <= 9 are visited: at |t| <= 1/2 the other rules weigh less than 2 W_10 exp(5) (1 + 1e-4) = 5.8e-20 of the nearest rule. */

#ifndef HYSGEN_RULES_H
#define HYSGEN_RULES_H

#include <math.h>
#include <stddef.h>

#define REACH 9
#define WINDOW (2 * REACH + 1)

typedef struct {
    size_t rules;
    double y_min, y_max; /* the range that the displacement is clamped to */
    double step, first;  /* distance of the centres, and the first of them: y_min unless the range was restricted */
    const double *q; /* (rules, 3): q1 [um/um], q2 [um/V], q3 [um] */
} partition_t;

typedef struct {
    double y;         /* the displacement, clamped to the grid */
    int clamped;      /* 1 if y lay outside the grid, else 0 */
    size_t first;     /* first rule of the window */
    size_t count;     /* rules in the window */
    double p[WINDOW]; /* their normalised firing strengths */
} firing_t;

typedef struct {
    double a, b, c; /* y+ = a y + b u + c at this displacement */
} local_t;

/* exp(-j^2/2) for j = 0..9 */
static const double RULE_DECAY[REACH + 1] = {
    1.0,
    0.60653065971263342,
    0.1353352832366127,
    0.011108996538242306,
    0.00033546262790251185,
    3.7266531720786709e-06,
    1.5229979744712629e-08,
    2.2897348456454528e-11,
    1.2664165549094176e-14,
    2.5767571091549807e-18,
};

static inline void fire(const partition_t *grid, double y, firing_t *out)
{
    out->clamped = !(y >= grid->y_min && y <= grid->y_max);
    y = (y < grid->y_min) ? grid->y_min : y;
    y = (y > grid->y_max) ? grid->y_max : y;
    out->y = y;
    const double s = (y - grid->first) / grid->step;
    size_t nearest = (size_t)(s + 0.5);
    nearest = (nearest < grid->rules) ? nearest : grid->rules - 1;
    const double r = exp(s - (double)nearest);
    const size_t below = (nearest < REACH) ? nearest : REACH;
    const size_t above = (grid->rules - 1 - nearest < REACH) ? grid->rules - 1 - nearest : REACH;
    out->first = nearest - below;
    out->count = below + 1 + above;
    double *mu = out->p + below;
    double sum = 1.0;
    mu[0] = 1.0;
    double power = 1.0;
    for (size_t j = 1; j <= above; ++j) {
        power *= r;
        mu[j] = RULE_DECAY[j] * power;
        sum += mu[j];
    }
    const double inverse = 1.0 / r;
    power = 1.0;
    for (size_t j = 1; j <= below; ++j) {
        power *= inverse;
        mu[-(ptrdiff_t)j] = RULE_DECAY[j] * power;
        sum += mu[-(ptrdiff_t)j];
    }
    const double scale = 1.0 / sum;
    for (size_t i = 0; i < out->count; ++i) {
        out->p[i] *= scale;
    }
}

static inline local_t consequent(const partition_t *grid, const firing_t *f)
{
    local_t sum = {0.0, 0.0, 0.0};
    const double *q = grid->q + 3 * f->first;
    for (size_t i = 0; i < f->count; ++i) {
        sum.a += f->p[i] * q[3 * i];
        sum.b += f->p[i] * q[3 * i + 1];
        sum.c += f->p[i] * q[3 * i + 2];
    }
    return sum;
}

static inline double step_ahead(const partition_t *grid, double y, double u, double w, int *clamped)
{
    firing_t f;
    fire(grid, y, &f);
    const local_t q = consequent(grid, &f);
    *clamped = f.clamped;
    return q.a * f.y + q.b * u + q.c + w;
}

/* df/dy at fixed u inside the grid, 0 outside it, where the clamp makes the model constant in y:
 *   df/dy = E[q1] + (1/h) E[(l - E l)(v_l - E v)],   v_l = q1 y + q2 u + q3 */
static inline double slope(const partition_t *grid, const firing_t *f, const local_t *mean, double u)
{
    if (f->clamped) {
        return 0.0;
    }
    const double *q = grid->q + 3 * f->first;
    const double value = mean->a * f->y + mean->b * u + mean->c;
    double covariance = 0.0;
    for (size_t i = 0; i < f->count; ++i) {
        /* sum p (v - E v) = 0, so any origin of l will do. */
        covariance += f->p[i] * (double)i * (q[3 * i] * f->y + q[3 * i + 1] * u + q[3 * i + 2] - value);
    }
    return mean->a + covariance / grid->step;
}

#endif
