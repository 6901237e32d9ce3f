/* Jiles-Atherton hysteresis in its susceptibility form, over the field x = u - centre; m = 1 at saturation.
 *
 *     m      = r L(xe / shape) + (1 - r) p,     xe = x + coupling m,     L(s) = coth s - 1/s
 *     dp/dxe = max(delta (L - p), 0) / pinning,                          delta = sign(dx)
 *     w      = slope u + height m
 *
 * The irreversible part p rests while it lies ahead of the anhysteretic curve L, so that dm/dx is never negative.
 * Source: Jiles and Atherton (1986); Deane (1994) for the rule of sign.
 */
#include <math.h>

#include "plant.h"

static double langevin(double s)
{
    if (fabs(s) < 0.05) return s * (1.0 / 3.0 - s * s * (1.0 / 45.0 - s * s * (2.0 / 945.0)));
    return 1.0 / tanh(s) - 1.0 / s;
}

static double langevin_slope(double s)
{
    if (fabs(s) < 0.05) return 1.0 / 3.0 - s * s * (1.0 / 15.0 - s * s * (2.0 / 189.0));
    if (fabs(s) > 300.0) return 1.0 / (s * s);
    const double sine = sinh(s);
    return 1.0 / (s * s) - 1.0 / (sine * sine);
}

/* m for the field x and the irreversible part p, by Newton's iteration from `m`; it contracts if coupling < 3 shape / r. */
static double magnetised(const hysteresis_t *self, double x_V, double p, double m)
{
    for (int i = 0; i < 4; i++) {
        const double s = (x_V + self->ja_coupling_V * m) / self->ja_shape_V;
        const double left = self->ja_reversible * langevin(s) + (1.0 - self->ja_reversible) * p - m;
        const double slope = self->ja_reversible * self->ja_coupling_V / self->ja_shape_V * langevin_slope(s) - 1.0;
        const double step = left / slope;
        m -= step;
        if (fabs(step) < 1e-14) break;
    }
    return m;
}

/* dp/dx at the field x: dp/dxe (1 + coupling dm/dx), with dm/dx from both equations. */
static double pinned_slope(const hysteresis_t *self, double x_V, double p, double delta)
{
    const double m = magnetised(self, x_V, p, self->magnetisation);
    const double s = (x_V + self->ja_coupling_V * m) / self->ja_shape_V;
    const double ahead = delta * (langevin(s) - p);
    if (ahead <= 0.0) return 0.0;
    const double r = self->ja_reversible, by_field = ahead / self->ja_pinning_V;
    const double together = r * langevin_slope(s) / self->ja_shape_V + (1.0 - r) * by_field;
    return by_field / (1.0 - self->ja_coupling_V * together);
}

double jiles_atherton_move(hysteresis_t *self, double u_V)
{
    const double way_V = u_V - self->u_V;
    const double delta = way_V < 0.0 ? -1.0 : 1.0;
    const int pieces = 1 + (int)(fabs(way_V) / 0.2);   /* V; Runge-Kutta: 4th order in the piece's length */
    const double dx = way_V / pieces;
    for (int i = 0; i < pieces; i++) {
        const double x = self->u_V - self->ja_centre_V + i * dx, p = self->pinned;
        const double k1 = pinned_slope(self, x, p, delta);
        const double k2 = pinned_slope(self, x + 0.5 * dx, p + 0.5 * dx * k1, delta);
        const double k3 = pinned_slope(self, x + 0.5 * dx, p + 0.5 * dx * k2, delta);
        const double k4 = pinned_slope(self, x + dx, p + dx * k3, delta);
        self->pinned = p + dx / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        self->magnetisation = magnetised(self, x + dx, self->pinned, self->magnetisation);
    }
    self->u_V = u_V;
    return self->slope_um_per_V * u_V + self->ja_height_um * self->magnetisation;
}
