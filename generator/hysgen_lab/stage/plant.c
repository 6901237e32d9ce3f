/* One D/A period of the virtual stage, see plant.h.
 *
 * Between the D/A's instants the signals run on a mesh of substeps. The hysteresis is evaluated at its nodes; the linear
 * parts are exact for an input that changes linearly between nodes, so an ideal amplifier (constant voltage over the
 * period) gives the exact continuous-time answer at any sampling period.
 */
#include <math.h>

#include "plant.h"

/* Each random source has its own stream: switching an effect does not change the numbers of the others. */
enum { CHANCE_WHITE = 1, CHANCE_WALK, CHANCE_OUTLIER, CHANCE_OUTLIER_SIZE, CHANCE_SLIP, CHANCE_FLICKER };

static unsigned long long scrambled(unsigned long long z)   /* splitmix64's finaliser */
{
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
}

/* A number in (0, 1) that depends on (seed, source, k) only: equal in a run and step by step. */
double chance_uniform(unsigned long long seed, unsigned long long source, unsigned long long k)
{
    const unsigned long long golden = 0x9E3779B97F4A7C15ULL;
    const unsigned long long stream = scrambled(scrambled(seed + golden) + source * golden);
    return ((double)(scrambled(stream + (k + 1) * golden) >> 11) + 0.5) * 0x1p-53;
}

double chance_normal(unsigned long long seed, unsigned long long source, unsigned long long k)   /* Box-Muller */
{
    const double radius = sqrt(-2.0 * log(chance_uniform(seed, source, 2 * k)));
    return radius * cos(6.283185307179586 * chance_uniform(seed, source, 2 * k + 1));
}

static double limited(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

static double linear_output(const linear_t *self, double v)
{
    double y = self->d * v;
    for (int i = 0; i < self->n; i++) y += self->c[i] * self->x[i];
    return y;
}

static double linear_step(linear_t *self, int substep, double v0, double v1)
{
    const int n = self->n;
    const double *phi = self->phi + (long)substep * n * n;
    const double *g0 = self->g0 + (long)substep * n;
    const double *g1 = self->g1 + (long)substep * n;
    double next[MOST_STATES];
    for (int i = 0; i < n; i++) {
        double sum = g0[i] * v0 + g1[i] * v1;
        for (int j = 0; j < n; j++) sum += phi[i * n + j] * self->x[j];
        next[i] = sum;
    }
    for (int i = 0; i < n; i++) self->x[i] = next[i];
    return linear_output(self, v1);
}

static double dac_output(const plant_t *self, double u_V)
{
    double out_V = limited(u_V, self->dac_low_V, self->dac_high_V);
    if (self->dac_step_V > 0.0)
        out_V = self->dac_low_V + self->dac_step_V * floor((out_V - self->dac_low_V) / self->dac_step_V + 0.5);
    return limited(out_V, self->clip_low_V, self->clip_high_V);
}

static double aged(const plant_t *self, double t_s)
{
    if (self->age_fraction == 0.0) return 1.0;
    return 1.0 + self->age_fraction * limited(t_s / self->age_s, 0.0, 1.0);
}

static double creep_step(plant_t *self, int substep, double w0_um, double w1_um)
{
    const long row = (long)substep * self->creeps;
    double sum = 0.0;
    for (int i = 0; i < self->creeps; i++) {
        self->creep_x[i] = self->creep_keep[row + i] * self->creep_x[i] + self->creep_g0[row + i] * w0_um
                         + self->creep_g1[row + i] * w1_um;
        sum += self->creep_share[i] * self->creep_x[i];
    }
    return self->crept_um = sum - self->creep_rest_um;
}

static double coupled(const plant_t *self)
{
    double sum = 0.0;
    for (int i = 0; i < self->channels; i++) sum += self->coupling_um[i] * self->channel[i];
    return sum;
}

static void next_breakaway(plant_t *self)
{
    const double spread = 2.0 * chance_uniform(self->seed, CHANCE_SLIP, self->slips) - 1.0;
    self->break_um = self->stick_um * (1.0 + self->stick_scatter * spread);
}

/* Sticks until the spring force reaches the breakaway force, then jumps and sticks again short of equilibrium. */
static double slipped(plant_t *self, double v_um)
{
    if (self->stick_um == 0.0) return v_um;
    const double pull_um = v_um - self->stuck_at_um;
    if (fabs(pull_um) > self->break_um) {
        const double left_um = self->stick_left * self->break_um;
        self->stuck_at_um = v_um - (pull_um > 0.0 ? left_um : -left_um);
        self->slips++;
        next_breakaway(self);
    }
    return self->stuck_at_um;
}

static double flicker(plant_t *self)
{
    double sum = 0.0;
    for (int i = 0; i < FLICKER_STATES; i++) {
        const double keep = self->k == 0 ? 0.0 : self->flicker_keep[i];
        const double fresh = chance_normal(self->seed, CHANCE_FLICKER + (unsigned long long)i, self->k);
        self->flicker_x[i] = keep * self->flicker_x[i] + sqrt(1.0 - keep * keep) * fresh;
        sum += self->flicker_x[i];
    }
    return self->flicker_um * sum / sqrt((double)FLICKER_STATES);
}

static int struck(const plant_t *self, unsigned long long k)
{
    return chance_uniform(self->seed, CHANCE_OUTLIER, k) < self->outlier_rate;
}

/* Disturbances, noise, outliers and both quantisers, at instant k. */
static void sense(plant_t *self)
{
    const double t_s = (double)self->k * self->Ts_s;
    double here_um = self->ring[self->ring_at] + self->drift_um + self->added_um;
    for (int i = 0; i < self->lines; i++)
        here_um += self->line_um[i] * sin(6.283185307179586 * self->line_Hz[i] * t_s + self->line_rad[i]);
    self->true_um = here_um;

    if (self->white_um > 0.0) here_um += self->white_um * chance_normal(self->seed, CHANCE_WHITE, self->k);
    if (self->flicker_um > 0.0) here_um += flicker(self);
    self->outlier = 0;
    if (self->outlier_rate > 0.0 && struck(self, self->k) && (self->k == 0 || !struck(self, self->k - 1))) {
        const double size = 2.0 * chance_uniform(self->seed, CHANCE_OUTLIER_SIZE, self->k) - 1.0;
        here_um += self->outlier_um * (size < 0.0 ? size - 0.5 : size + 0.5);
        self->outlier = 1;
    }
    if (self->sensor_step_um > 0.0) here_um = self->sensor_step_um * floor(here_um / self->sensor_step_um + 0.5);
    if (self->adc_step_um > 0.0) {
        const double code = floor((here_um - self->adc_low_um) / self->adc_step_um + 0.5);
        here_um = self->adc_low_um + self->adc_step_um * limited(code, 0.0, self->adc_codes - 1.0);
    }
    self->reading_um = here_um;
}

/* Equilibrium at u; creep counts from here, the hysteresis keeps its history. */
void plant_rest(plant_t *self, double u_V)
{
    self->k = 0;
    self->slips = 0;
    self->drift_um = 0.0;
    self->ramp_V = dac_output(self, u_V);
    for (int i = 0; i < self->amplifier.n; i++) self->amplifier.x[i] = self->amplifier.rest[i] * self->ramp_V;
    const double w_um = hysteresis_move(&self->hysteresis, self->ramp_V);
    self->crept_um = self->creep_rest_um = 0.0;
    for (int i = 0; i < self->creeps; i++) {
        self->creep_x[i] = w_um;
        self->creep_rest_um += self->creep_share[i] * w_um;
    }
    self->stuck_at_um = w_um + coupled(self);
    next_breakaway(self);
    for (int i = 0; i < self->mechanics.n; i++) self->mechanics.x[i] = self->mechanics.rest[i] * self->stuck_at_um;
    for (int i = 0; i <= self->late; i++) self->ring[i] = linear_output(&self->mechanics, self->stuck_at_um);
    self->ring_at = 0;
    sense(self);
}

/* Hold u(k) for one period; returns the reading at its end, y(k+1). A NaN holds the last voltage. */
double plant_step(plant_t *self, double u_V)
{
    const double target_V = u_V == u_V ? dac_output(self, u_V) : self->ramp_V;
    const int limiter = self->slew_V_per_s > 0.0;
    const double other_um = coupled(self);
    double t_s = (double)self->k * self->Ts_s;
    double ramp_V = limiter ? self->ramp_V : target_V;
    double volts = self->amplifier.n ? linear_output(&self->amplifier, ramp_V) : ramp_V;
    double w_um = hysteresis_hold(&self->hysteresis, volts, 0.0) * aged(self, t_s);
    double force_um = slipped(self, w_um + self->crept_um + other_um);
    double tapped_um = 0.0;

    for (int i = 0; i < self->substeps; i++) {
        const double way_V = self->slew_V_per_s * self->h_s[i];
        const double next_V = limiter ? ramp_V + limited(target_V - ramp_V, -way_V, way_V) : target_V;
        volts = self->amplifier.n ? linear_step(&self->amplifier, i, ramp_V, next_V) : next_V;
        t_s += self->h_s[i];
        const double next_w_um = hysteresis_hold(&self->hysteresis, volts, self->h_s[i]) * aged(self, t_s);
        const double crept_um = self->creeps ? creep_step(self, i, w_um, next_w_um) : 0.0;
        const double next_um = slipped(self, next_w_um + crept_um + other_um);
        const double moved_um = linear_step(&self->mechanics, i, force_um, next_um);
        if (i == self->tap) tapped_um = moved_um;
        ramp_V = next_V;
        w_um = next_w_um;
        force_um = next_um;
    }
    self->ramp_V = ramp_V;
    self->ring[self->ring_at] = tapped_um;
    self->ring_at = self->ring_at == self->late ? 0 : self->ring_at + 1;

    self->drift_um += self->drift_um_per_s * self->Ts_s;
    if (self->walk_um_per_rt_s > 0.0)
        self->drift_um += self->walk_um_per_rt_s * sqrt(self->Ts_s) * chance_normal(self->seed, CHANCE_WALK, self->k);
    self->k++;
    sense(self);
    return self->hysteresis.failed ? NAN : self->reading_um;
}

/* n instants: row k holds the signals when u(k) is put out. Returns 1 if the hysteresis ran out of turning points. */
int plant_run(plant_t *self, long n, const double *u_V, const double *channels, double *reading_um, double *true_um,
              double *actuator_V, double *drift_um, unsigned char *outlier)
{
    for (long k = 0; k < n; k++) {
        reading_um[k] = self->reading_um;
        true_um[k] = self->true_um;
        actuator_V[k] = self->hysteresis.u_V;
        drift_um[k] = self->drift_um;
        outlier[k] = (unsigned char)self->outlier;
        if (k == n - 1) break;
        for (int i = 0; i < self->channels; i++) self->channel[i] = channels[k * self->channels + i];
        (void)plant_step(self, u_V[k]);
    }
    return self->hysteresis.failed;
}
