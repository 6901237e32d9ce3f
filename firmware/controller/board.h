/* board.h: what the firmware asks of a board. One folder of firmware/board/ per board implements it.
 *
 * board_t is the board's own struct, defined in its board_type.h; main owns the only instance.
 * Called in the 50 kHz interrupt: the first ten. Called at boot: the eleventh and the next four. Called in the idle loop: the others. */

#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#include "board_type.h"
#include "linkage.h"

LINKAGE_BEGIN

#define BOARD_AMPLIFIER_LIMITS  0x1u  /* the amplifier is at its current or voltage limit */
#define BOARD_AMPLIFIER_FAILED  0x2u  /* the amplifier reports a fault, or is not on (yet) */
#define BOARD_STOPPED           0x20u /* the stop input asks for what STOP does, for as long as it is there */

/* board_type.h also has BOARD_LOW_V .. BOARD_HIGH_V and BOARD_LOW_UM .. BOARD_HIGH_UM, the ranges of the converters, BOARD_SAFE_V,
 * BOARD_RECORD, a power of two, and BOARD_PERIOD_CYCLES, cycles of the processor from one interrupt to the next. */
#define BOARD_SLOTS       2u
#define BOARD_SLOT_BYTES  4096u

#define BOARD_STACK_FILL  0x5AFE57ACu

/* Words in a row; a count of 0: the board does not know them. */
typedef struct {
    const volatile uint32_t *words;
    uint32_t count;
} board_span_t;

/* Displacement y(k) [um]: the sample that the A/D took at this interrupt. */
float hysgen_board_displacement_um(board_t *board);

/* Reference [um] for the sample MODEL_PREVIEW + 1 after this interrupt. */
float hysgen_board_reference_um(board_t *board);

/* BOARD_AMPLIFIER_ bits and BOARD_STOPPED, 0 if all is well. */
uint32_t hysgen_board_amplifier(board_t *board);

/* Put u(k) [V] out; it acts until the next call. */
void hysgen_board_voltage(board_t *board, float u_V);

/* Free-running counter of processor cycles; it may wrap. */
uint32_t hysgen_board_cycles(board_t *board);

/* 1 if the next period's interrupt is waiting already: this one took too long. */
uint32_t hysgen_board_overrun(board_t *board);

/* Move bytes between the line's hardware and the board's buffers: what arrived since the last call, and what is to be sent. In the
 * interrupt behind hysgen_board_voltage, so that a line of up to 500 kbit/s loses nothing while the idle loop erases memory, and needs no
 * interrupt of its own, which would delay the next voltage. */
void hysgen_board_line_serve(board_t *board);

/* Amplifier: 1 switched on, 0 off. Off from reset on; switched on between START and OFF only. */
void hysgen_board_amplifier_enable(board_t *board, uint32_t on);

/* Restart the hardware watchdog: firmware is alive. */
void hysgen_board_alive(board_t *board);

/* Two words of memory that a reset under power and start-up leave alone. */
uint32_t *hysgen_board_kept(board_t *board);

/* 1 if the power came on, 0 if the processor started again under power. */
uint32_t hysgen_board_power_on(board_t *board);

/* Calibration: displacement_um gives zero_um + gain_um * what it gave as built, voltage puts out zero_V + gain_V * its voltage, as built. */
void hysgen_board_calibrate(board_t *board, float zero_um, float gain_um, float zero_V, float gain_V);

/* Memory for BOARD_RECORD words of 16 bits, see play.h; its content at power on does not matter. */
volatile uint16_t *hysgen_board_record(board_t *board);

/* Code and constants, which nothing changes behind start-up. */
board_span_t hysgen_board_code(board_t *board);

/* The stack from its far end, which is used last, as far as start-up has filled it with BOARD_STACK_FILL. */
board_span_t hysgen_board_stack(board_t *board);

/* Voltage behind the D/A as the board reads it back, by the scale as built; NaN if it does not. */
float hysgen_board_read_back_V(const board_t *board);

/* Bytes that arrived on the line, at most `room`; returns how many. A byte that finds the buffer full is lost. */
uint32_t hysgen_board_line_read(board_t *board, uint8_t *bytes, uint32_t room);

/* Send up to `count` bytes; returns how many found room. */
uint32_t hysgen_board_line_write(board_t *board, const uint8_t *bytes, uint32_t count);

/* Parameter store: memory that survives power off. Writing turns bytes of an erased slot into `bytes`; both may be cut
 * off anywhere by a power failure. Offsets and counts are in bytes and multiples of 4. hysgen_board_store_write returns 0 if the board
 * has no such memory, 1 else; firmware reads back what was written. */
void hysgen_board_store_read(board_t *board, uint32_t slot, uint32_t offset, uint8_t *bytes, uint32_t count);
void hysgen_board_store_erase(board_t *board, uint32_t slot);
uint32_t hysgen_board_store_write(board_t *board, uint32_t slot, uint32_t offset, const uint8_t *bytes, uint32_t count);

LINKAGE_END

#endif
