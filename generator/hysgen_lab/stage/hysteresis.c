/* Hysteresis as a path functional: Preisach by its Everett function, Preisach by relays, Bouc-Wen, a plain curve.
 * Further kinds: preisach_mesh.c, jiles_atherton.c, thermal.c.
 *
 * Preisach, relay density a(alpha) b(beta) on alpha >= beta:
 *     Everett:  E(M, m) = integral over m <= beta <= alpha <= M of a(alpha) b(beta)
 *                       = G(M) (H(M) - H(m)) - (K(M) - K(m)),   G' = a,  H' = b,  K' = G b
 *     output:   w = slope u + sum over the monotone pieces between remembered turning points of  +E (up), -E (down)
 */
#include <math.h>

#include "plant.h"

enum { COL_G = 0, COL_H = 2, COL_K = 4 };
enum { TURN_U = 0, TURN_G, TURN_H, TURN_K, TURN_SUM };

static double curve_value(const hysteresis_t *self, double u_V)
{
    double place = (u_V - self->grid_low_V) / self->grid_step_V;
    double whole = floor(place);
    if (whole < 0.0) whole = 0.0;
    if (whole > self->grid_n - 2) whole = self->grid_n - 2;
    const double *row = self->table + (long)whole;
    return row[0] + (place - whole) * (row[1] - row[0]);
}

/* G, H and K at u by cubic Hermite interpolation: their derivatives are known exactly at the nodes. */
static void everett_functions(const hysteresis_t *self, double u_V, double *point)
{
    point[TURN_U] = u_V;
    if (self->kind == KIND_MESH) return;
    double place = (u_V - self->grid_low_V) / self->grid_step_V;
    double whole = floor(place);
    if (whole < 0.0) whole = 0.0;
    if (whole > self->grid_n - 2) whole = self->grid_n - 2;
    const double *left = self->table + TABLE_COLUMNS * (long)whole;
    const double *right = left + TABLE_COLUMNS;
    const double t = place - whole;
    const double r = 1.0 - t;
    const double from_left = r * r * (1.0 + 2.0 * t);
    const double from_right = t * t * (3.0 - 2.0 * t);
    const double bend_left = t * r * r * self->grid_step_V;
    const double bend_right = -t * t * r * self->grid_step_V;
    point[TURN_G] = from_left * left[COL_G] + from_right * right[COL_G]
                  + bend_left * left[COL_G + 1] + bend_right * right[COL_G + 1];
    point[TURN_H] = from_left * left[COL_H] + from_right * right[COL_H]
                  + bend_left * left[COL_H + 1] + bend_right * right[COL_H + 1];
    point[TURN_K] = from_left * left[COL_K] + from_right * right[COL_K]
                  + bend_left * left[COL_K + 1] + bend_right * right[COL_K + 1];
}

static double everett_piece(const hysteresis_t *self, const double *high, const double *low)
{
    if (self->kind == KIND_MESH) return mesh_everett(self, high[TURN_U], low[TURN_U]);
    return high[TURN_G] * (high[TURN_H] - low[TURN_H]) - (high[TURN_K] - low[TURN_K]);
}

static double everett_sum(const hysteresis_t *self, const double *here)
{
    const double *turn = self->turns + TURN_COLUMNS * (self->depth - 1);
    const int rising = self->depth % 2 == 1;
    return turn[TURN_SUM] + (rising ? everett_piece(self, here, turn) : -everett_piece(self, turn, here));
}

static double everett_move(hysteresis_t *self, double u_V)
{
    const double top_V = self->grid_low_V + self->grid_step_V * (self->grid_n - 1);
    double here[TURN_COLUMNS];
    if (u_V < self->grid_low_V) u_V = self->grid_low_V;
    if (u_V > top_V) u_V = top_V;

    const int rising = self->depth % 2 == 1;
    if (rising ? u_V < self->u_V : u_V > self->u_V) {
        if (self->depth == self->capacity) {
            self->failed = 1;
            return NAN;
        }
        double *turn = self->turns + TURN_COLUMNS * self->depth;
        everett_functions(self, self->u_V, turn);
        turn[TURN_SUM] = everett_sum(self, turn);
        self->depth++;
    }
    /* Wiping out: an extreme that is passed takes itself and the turning point after it away. */
    if (self->depth % 2 == 1) {
        while (self->depth >= 3 && u_V >= self->turns[TURN_COLUMNS * (self->depth - 2)]) self->depth -= 2;
    } else {
        while (self->depth >= 2 && self->depth % 2 == 0 && u_V <= self->turns[TURN_COLUMNS * (self->depth - 2)])
            self->depth = self->depth > 2 ? self->depth - 2 : 1;
    }
    everett_functions(self, u_V, here);
    self->u_V = u_V;
    return everett_sum(self, here) + self->slope_um_per_V * u_V;
}

static double relays_move(hysteresis_t *self, double u_V)
{
    double sum = self->w_um + self->offset_um - self->slope_um_per_V * self->u_V;
    while (self->below_up < self->relays && self->up_V[self->below_up] <= u_V) {
        const int i = self->below_up++;
        if (!self->on[i]) sum += self->weight_um[i];
        self->on[i] = 1;
    }
    while (self->below_up > 0 && self->up_V[self->below_up - 1] > u_V) self->below_up--;
    while (self->below_down > 0 && self->down_V[self->down_order[self->below_down - 1]] >= u_V) {
        const int i = self->down_order[--self->below_down];
        if (self->on[i]) sum -= self->weight_um[i];
        self->on[i] = 0;
    }
    while (self->below_down < self->relays && self->down_V[self->down_order[self->below_down]] < u_V)
        self->below_down++;
    self->u_V = u_V;
    return sum + self->slope_um_per_V * u_V;
}

static double bouc_wen_slope(const hysteresis_t *self, double z_um, double sign)
{
    const double size = self->bw_n == 1.0 ? fabs(z_um) : pow(fabs(z_um), self->bw_n);
    return self->bw_a - size * ((z_um < 0.0 ? -sign : sign) * self->bw_beta + self->bw_gamma);
}

static double bouc_wen_move(hysteresis_t *self, double u_V)
{
    const double way_V = u_V - self->u_V;
    const double sign = way_V < 0.0 ? -1.0 : 1.0;
    const int pieces = 1 + (int)(fabs(way_V) / 0.25);   /* V; Runge-Kutta: 4th order in the piece's length */
    const double du = way_V / pieces;
    double z = self->z_um;
    for (int i = 0; i < pieces; i++) {
        const double k1 = bouc_wen_slope(self, z, sign);
        const double k2 = bouc_wen_slope(self, z + 0.5 * du * k1, sign);
        const double k3 = bouc_wen_slope(self, z + 0.5 * du * k2, sign);
        const double k4 = bouc_wen_slope(self, z + du * k3, sign);
        z += du / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    self->z_um = z;
    self->u_V = u_V;
    return self->slope_um_per_V * u_V - z;
}

double hysteresis_move(hysteresis_t *self, double u_V)
{
    if (u_V == self->u_V && self->kind != KIND_THERMAL) return self->w_um;
    double w_um;
    switch (self->kind) {
    case KIND_EVERETT:
    case KIND_MESH: w_um = everett_move(self, u_V); break;
    case KIND_RELAYS: w_um = relays_move(self, u_V); break;
    case KIND_BOUC_WEN: w_um = bouc_wen_move(self, u_V); break;
    case KIND_JILES_ATHERTON: w_um = jiles_atherton_move(self, u_V); break;
    case KIND_THERMAL: w_um = thermal_hold(self, u_V, self->dwell_s); break;
    default: w_um = curve_value(self, u_V) + self->slope_um_per_V * u_V; self->u_V = u_V; break;
    }
    return self->w_um = w_um - self->offset_um;
}

/* u held for h_s from now on: hysteresis_move where time has no part. */
double hysteresis_hold(hysteresis_t *self, double u_V, double h_s)
{
    if (self->kind != KIND_THERMAL) return hysteresis_move(self, u_V);
    return self->w_um = thermal_hold(self, u_V, h_s) - self->offset_um;
}

/* Every relay off, no history: the state below the lowest voltage of the table. */
void hysteresis_clear(hysteresis_t *self)
{
    self->failed = 0;
    self->u_V = self->grid_low_V;
    self->z_um = self->magnetisation = self->pinned = 0.0;
    self->below_up = self->below_down = 0;
    for (int i = 0; i < self->relays; i++) self->on[i] = 0;
    for (int i = 0; i < self->hysterons; i++) self->up[i] = 0.0;
    self->w_um = self->slope_um_per_V * self->u_V - self->offset_um;
    if (self->kind == KIND_CURVE) self->w_um += curve_value(self, self->u_V);
    if (self->kind == KIND_EVERETT || self->kind == KIND_MESH) {
        self->depth = 1;
        everett_functions(self, self->u_V, self->turns);
        self->turns[TURN_SUM] = 0.0;
    }
}

void hysteresis_path(hysteresis_t *self, long n, const double *u_V, double *w_um)
{
    for (long i = 0; i < n; i++) w_um[i] = hysteresis_move(self, u_V[i]);
}
