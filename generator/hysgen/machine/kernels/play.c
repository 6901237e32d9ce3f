/* Play operators over a whole record, float64:  z_j(k) = max(u(k) - r_j, min(u(k) + r_j, z_j(k-1))). */

#include <stddef.h>

void hysgen_play(size_t samples, size_t plays, const double *u, const double *half_width, double *state, double *out)
{
    for (size_t k = 0; k < samples; ++k) {
        for (size_t j = 0; j < plays; ++j) {
            const double low = u[k] - half_width[j];
            const double high = u[k] + half_width[j];
            double z = state[j];
            z = (z > high) ? high : z;
            z = (z < low) ? low : z;
            state[j] = z;
            out[k * plays + j] = z;
        }
    }
}
