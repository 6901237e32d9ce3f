#include "trim.h"

#include "number.h"

void hysgen_trim_init(trim_t *self)
{
    self->correction_um = 0.0f;
}

uint32_t hysgen_trim_step(trim_t *self, const settings_t *settings, float residual_um, int32_t limited)
{
    const float limit = settings->trim_limit_um;
    const uint32_t winds = (uint32_t)(((limited > 0) && (residual_um > 0.0f))
                                      || ((limited < 0) && (residual_um < 0.0f)));
    const float moved = self->correction_um + settings->trim_integral * residual_um;

    if (winds == 0u) {
        self->correction_um = number_limited(moved, -limit, limit);
    }
    return (uint32_t)(number_size(self->correction_um) >= limit);
}
