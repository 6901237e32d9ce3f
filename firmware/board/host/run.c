/* run.c: the image at work on the host, many samples per call. */

#include <stddef.h>

#include "firmware.h"

/* `count` samples: interrupt, then idle loop, as on the target. Logs what was read, put out, applied, and the state. */
void hysgen_host_run(firmware_t *firmware, board_t *board, size_t count, float *reading_um, float *output_V, uint8_t *state)
{
    for (size_t k = 0u; k < count; ++k) {
        reading_um[k] = board->reading_um;
        hysgen_firmware_interrupt(firmware, board);
        hysgen_firmware_idle(firmware, board);
        output_V[k] = board->output_V;
        state[k] = (uint8_t)firmware->controller.state;
    }
}
