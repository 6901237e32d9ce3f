/* Everett function of a Preisach density on a mesh: constant in each cell, for a density of any kind.
 *
 *     E(M, m) = integral over m <= beta <= alpha <= M of mu(alpha, beta)
 *             = D(M) - D(m) - (C(M, m) - C(m, m)),
 *     C(x, y) = integral over alpha <= x, beta <= y of mu,    D' (x) = dC/dx at y = x
 *
 * Inside a cell C is bilinear and D is quadratic, both exactly. The density must be given on both sides of the diagonal;
 * what lies above it (beta > alpha) has no part in E.
 */
#include <math.h>

#include "plant.h"

/* Number of the cell that u lies in, and its place in the cell, 0 to 1. */
static long cell_of(const hysteresis_t *self, double u_V, double *place)
{
    const double at = (u_V - self->grid_low_V) / self->grid_step_V;
    double whole = floor(at);
    if (whole < 0.0) whole = 0.0;
    if (whole > self->grid_n - 2) whole = self->grid_n - 2;
    *place = at - whole;
    return (long)whole;
}

static double relays_within(const hysteresis_t *self, double x_V, double y_V)   /* C(x, y) */
{
    double s, t;
    const long row = cell_of(self, x_V, &s), column = cell_of(self, y_V, &t);
    const double *low = self->corner + row * self->grid_n + column;
    const double *high = low + self->grid_n;
    const double left = low[0] + t * (low[1] - low[0]);
    const double right = high[0] + t * (high[1] - high[0]);
    return left + s * (right - left);
}

static double along_diagonal(const hysteresis_t *self, double x_V)   /* D(x) */
{
    double s;
    const long cell = cell_of(self, x_V, &s);
    const double *low = self->corner + cell * self->grid_n + cell;
    const double *high = low + self->grid_n;
    const double mass = high[1] - high[0] - low[1] + low[0];
    return self->diagonal[cell] + s * (high[0] - low[0]) + 0.5 * s * s * mass;
}

double mesh_everett(const hysteresis_t *self, double high_V, double low_V)
{
    return along_diagonal(self, high_V) - along_diagonal(self, low_V)
         - (relays_within(self, high_V, low_V) - relays_within(self, low_V, low_V));
}
