/* The virtual stage: the continuous-time plant over one D/A period, and the reading of the A/D at its end.
 *
 * D/A -> amplifier -> hysteresis -> creep -> friction -> modes and lag -> delay -> disturbances -> sensor -> A/D
 *
 * All memory belongs to the caller. Python fills the constants, `plant_rest` sets the state, `plant_step` moves it on.
 * Declarations only: this file is read by the compiler and, without its preprocessor lines, by cffi.
 */
#ifndef HYSGEN_STAGE_PLANT_H
#define HYSGEN_STAGE_PLANT_H

#define KIND_CURVE 0
#define KIND_EVERETT 1
#define KIND_RELAYS 2
#define KIND_BOUC_WEN 3
#define KIND_MESH 4
#define KIND_JILES_ATHERTON 5
#define KIND_THERMAL 6

#define TABLE_COLUMNS 6
#define TURN_COLUMNS 5
#define MOST_STATES 16
#define MOST_CHANNELS 16
#define MOST_LINES 16
#define FLICKER_STATES 8

/* Hysteresis: displacement w [um] from the path of the voltage u [V]; only KIND_THERMAL depends on the rate. */
typedef struct {
    int kind;
    int failed;               /* 1: more nested turning points than `capacity` */
    double u_V, w_um;         /* present input and output */
    double slope_um_per_V;    /* reversible part */
    double offset_um;         /* subtracted, so that the zeroed stage reads 0 */

    /* curve: w at uniform voltages. Everett: G, G', H, H', K, K' at uniform voltages */
    double grid_low_V, grid_step_V;
    int grid_n;
    const double *table;

    /* Everett: turning points (u, G, H, K, sum up to there); index even = minimum, odd = maximum */
    int depth, capacity;
    double *turns;

    /* relays: sorted by the voltage that switches on, and an index sorted by the voltage that switches off */
    int relays, below_up, below_down;
    const double *up_V, *down_V, *weight_um;
    const int *down_order;
    unsigned char *on;

    /* Bouc-Wen: dz/du = a - beta s |z|^(n-1) z - gamma |z|^n,  s = sign(du),  w = slope u - z */
    double bw_a, bw_beta, bw_gamma, bw_n, z_um;

    /* mesh: C at the nodes, (grid_n, grid_n), and D at the nodes, (grid_n,); see preisach_mesh.c */
    const double *corner, *diagonal;

    /* Jiles-Atherton: field u - ja_centre_V; magnetisation of full scale ja_height_um, and its irreversible part */
    double ja_centre_V, ja_shape_V, ja_coupling_V, ja_pinning_V, ja_reversible, ja_height_um, magnetisation, pinned;

    /* thermally activated hysterons: (hysterons,) each; `up`: share of each that is switched on */
    int hysterons;
    const double *bias_V, *per_coercive_V, *barrier, *part_um;
    double *up;
    double attempt_per_s, dwell_s;    /* dwell: how long each voltage of a path without time is held */
} hysteresis_t;

/* x' = A x + B v, y = c x + d v; exact over each substep for v that changes linearly over it. */
typedef struct {
    int n;
    const double *phi;        /* (substeps, n, n) */
    const double *g0, *g1;    /* (substeps, n): weights of v at the substep's begin and end */
    const double *c, *rest;   /* (n,): output row; state at rest under v = 1 */
    double d;
    double *x;                /* (n,) */
} linear_t;

typedef struct {
    double Ts_s;
    int substeps, tap;        /* the A/D samples after substep `tap`, `late` whole periods ago */
    const double *h_s;        /* (substeps,) */

    double dac_low_V, dac_high_V, dac_step_V;     /* step 0: ideal */
    double clip_low_V, clip_high_V;
    double slew_V_per_s;                          /* 0: no limit */
    double ramp_V;
    linear_t amplifier;                           /* n = 0: ideal */

    hysteresis_t hysteresis;
    double age_fraction, age_s;

    int creeps;                                   /* relaxations that sample the spectrum */
    const double *creep_keep, *creep_g0, *creep_g1;   /* (substeps, creeps) */
    const double *creep_share;
    double *creep_x;
    double crept_um, creep_rest_um;               /* creep since the record began; creep of the rest before it */

    int channels;
    const double *coupling_um;                    /* (channels,) um per unit of the channel */
    double *channel;                              /* (channels,) values during the coming period */

    double stick_um, stick_left, stick_scatter;   /* stick_um 0: no friction */
    double stuck_at_um, break_um;
    unsigned long long slips;

    linear_t mechanics;                           /* modes and lag */
    int late;
    double *ring;                                 /* (late + 1,) */
    int ring_at;

    double drift_um_per_s, walk_um_per_rt_s;
    int lines;
    const double *line_Hz, *line_um, *line_rad;

    double added_um;                              /* by effects that act in Python, at the coming instant */
    double white_um, flicker_um;
    const double *flicker_keep;                   /* (FLICKER_STATES,) */
    double flicker_x[FLICKER_STATES];
    double outlier_rate, outlier_um;
    double sensor_step_um, adc_low_um, adc_step_um;   /* steps 0: ideal */
    double adc_codes;

    unsigned long long seed, k;
    double drift_um, true_um, reading_um;
    int outlier;
} plant_t;

double mesh_everett(const hysteresis_t *self, double high_V, double low_V);
double jiles_atherton_move(hysteresis_t *self, double u_V);
double thermal_hold(hysteresis_t *self, double u_V, double h_s);

double hysteresis_move(hysteresis_t *self, double u_V);
double hysteresis_hold(hysteresis_t *self, double u_V, double h_s);
void hysteresis_clear(hysteresis_t *self);
void hysteresis_path(hysteresis_t *self, long n, const double *u_V, double *w_um);

double chance_uniform(unsigned long long seed, unsigned long long source, unsigned long long k);
double chance_normal(unsigned long long seed, unsigned long long source, unsigned long long k);

void plant_rest(plant_t *self, double u_V);
double plant_step(plant_t *self, double u_V);
int plant_run(plant_t *self, long n, const double *u_V, const double *channels, double *reading_um, double *true_um,
              double *actuator_V, double *drift_um, unsigned char *outlier);

#endif
