/* trim.h: feedback trim, an integral controller on the residual of the feed-forward.
 *
 *     e(k) = r(k) - y(k),   c(k) = c(k-1) + integral e(k), limited to +-limit
 *
 * c [um] is added to the reference that the inverse is asked for: the correction passes through the model, so the
 * model's memory sees the voltage that the stage sees. Anti-windup: while the output is at a limit the integral does not
 * move towards displacements beyond the limit. */

#ifndef TRIM_H
#define TRIM_H

#include <stdint.h>

#include "linkage.h"
#include "settings.h"

LINKAGE_BEGIN

typedef struct {
    float correction_um;
} trim_t;

void hysgen_trim_init(trim_t *self);

/* One sample. limited: 1 if the output cannot raise the displacement further, -1 if it cannot lower it, 0 else. Returns 1 if the correction
 * is at its limit. */
uint32_t hysgen_trim_step(trim_t *self, const settings_t *settings, float residual_um, int32_t limited);

LINKAGE_END

#endif
