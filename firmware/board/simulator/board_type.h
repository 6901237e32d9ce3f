/* board_type.h: the board of the simulated C674x: no hardware, one sample at a time from the caller. */

#ifndef BOARD_TYPE_H
#define BOARD_TYPE_H

#include <stdint.h>

typedef struct {
    float reading_um;
    float reference_um;
    float output_V;
} board_t;

#endif
