/* Hysterons that thermal activation switches: each stands for many domains, of which the share `up` is switched on.
 *
 *     d up/dt = a exp(-E (1 - x)^2) (1 - up) - a exp(-E (1 + x)^2) up,     x = (u - bias) / coercive
 *
 * A barrier, E in units of kT without field, is zero for a field beyond it. Exact for a voltage that is held: up goes
 * exponentially to its equilibrium. Source: Neel (1949); Brown (1963).
 */
#include <math.h>

#include "plant.h"

#define NEVER 35.0   /* exp(-35) = 6e-16: a share below the resolution of `up` switches within h_s */

double thermal_hold(hysteresis_t *self, double u_V, double h_s)
{
    const double attempts = self->attempt_per_s * h_s;
    const double highest = h_s > 0.0 ? NEVER + log(attempts) : -1.0;
    double sum = 0.0;
    for (int i = 0; i < self->hysterons; i++) {
        const double x = (u_V - self->bias_V[i]) * self->per_coercive_V[i];
        const double to_up = x < 1.0 ? self->barrier[i] * (1.0 - x) * (1.0 - x) : 0.0;
        const double to_down = x > -1.0 ? self->barrier[i] * (1.0 + x) * (1.0 + x) : 0.0;
        double up = self->up[i];
        /* Nothing moves where each well is empty or too deep to leave. */
        if (!((to_up > highest || up == 1.0) && (to_down > highest || up == 0.0))) {
            const double rise = to_up > highest ? 0.0 : attempts * exp(-to_up);
            const double fall = to_down > highest ? 0.0 : attempts * exp(-to_down);
            const double settled = rise / (rise + fall);
            up = settled + (up - settled) * exp(-(rise + fall));
            self->up[i] = up;
        }
        sum += self->part_um[i] * up;
    }
    self->u_V = u_V;
    return self->slope_um_per_V * u_V + sum;
}
