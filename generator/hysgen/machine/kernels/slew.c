/* Rate limiter over a whole record, float64:  v(k) = max(v(k-1) - fall, min(v(k-1) + rise, u(k))). */

#include <stddef.h>

void hysgen_slew(size_t samples, const double *u, double rise, double fall, double start, double *out)
{
    double v = start;
    for (size_t k = 0; k < samples; ++k) {
        const double low = v - fall;
        const double high = v + rise;
        v = (u[k] > high) ? high : u[k];
        v = (v < low) ? low : v;
        out[k] = v;
    }
}
