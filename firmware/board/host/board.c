/* board.c: the host's board, for tests and for the tracking benchmark. */

#include "board.h"

#include <stddef.h>
#include <string.h>

static uint32_t faulty(const board_t *board, uint32_t fault)
{
    const uint32_t since = board->sample - board->fault_from;
    const uint32_t on = (board->fault_period == 0u) || (since % board->fault_period < board->fault_length);

    return (uint32_t)(board->fault == fault) & (uint32_t)(board->sample >= board->fault_from)
        & (uint32_t)(board->sample < board->fault_until) & on;
}

/* The byte that power allows to be changed next: 1 as long as there is power. */
static uint32_t powered(board_t *board)
{
    if (board->bytes_to_cut == HOST_NO_CUT) {
        return 1u;
    }
    if (board->bytes_to_cut == 0u) {
        return 0u;
    }
    board->bytes_to_cut -= 1u;
    return 1u;
}

/* The interrupts that come while the idle loop is inside the store or reads the line. */
static void preempted(board_t *board)
{
    if (board->preempt != NULL) {
        board->preempt(board->preempt_with);
    }
}

float hysgen_board_displacement_um(board_t *board)
{
    return board->reading_um;
}

float hysgen_board_reference_um(board_t *board)
{
    return board->reference_um[board->sample];
}

uint32_t hysgen_board_amplifier(board_t *board)
{
    return (faulty(board, HOST_FAULT_STOPPED) * BOARD_STOPPED) | (faulty(board, HOST_FAULT_LIMITS) != 0u ? BOARD_AMPLIFIER_LIMITS : 0u)
        | (((faulty(board, HOST_FAULT_AMPLIFIER) != 0u) || (board->enabled == 0u) || (board->enabled_for < board->ready_after))
               ? BOARD_AMPLIFIER_FAILED : 0u);
}

void hysgen_board_voltage(board_t *board, float u_V)
{
    const uint32_t clips = faulty(board, HOST_FAULT_SATURATED);
    const float built_V = board->zero_V + board->gain_V * u_V;
    float reading_um;

    board->output_V = u_V;
    board->applied_V = ((clips != 0u) & (built_V > board->fault_value)) ? board->fault_value : built_V;
    reading_um = board->zero_um + board->gain_um * (float)board->step(board->plant, (double)board->applied_V);
    if (faulty(board, HOST_FAULT_LATE) != 0u) {
        board->cycles += (uint32_t)board->fault_value;
    }
    board->sample += 1u;
    if (faulty(board, HOST_FAULT_READING) != 0u) {
        board->reading_um = board->fault_value;
    } else if (faulty(board, HOST_FAULT_STUCK) == 0u) {
        board->reading_um = reading_um;
    }
}

/* A host has no cycles of a C6748 to show: time passes only where a test says so. */
uint32_t hysgen_board_cycles(board_t *board)
{
    return board->cycles;
}

uint32_t hysgen_board_overrun(board_t *board)
{
    if (faulty(board, HOST_FAULT_LOST) != 0u) {
        board->cycles += (uint32_t)board->fault_value;
    }
    return faulty(board, HOST_FAULT_OVERRUN);
}

void hysgen_board_line_serve(board_t *board)
{
    board->served += 1u;
}

void hysgen_board_amplifier_enable(board_t *board, uint32_t on)
{
    board->enabled_for = (on != 0u) ? board->enabled_for + 1u : 0u;
    board->enabled = on;
}

uint32_t *hysgen_board_kept(board_t *board)
{
    return board->kept;
}

uint32_t hysgen_board_power_on(board_t *board)
{
    return (uint32_t)(board->restarted == 0u);
}

void hysgen_board_calibrate(board_t *board, float zero_um, float gain_um, float zero_V, float gain_V)
{
    board->zero_um = zero_um;
    board->gain_um = gain_um;
    board->zero_V = zero_V;
    board->gain_V = gain_V;
}

float hysgen_board_read_back_V(const board_t *board)
{
    return board->applied_V;
}

volatile uint16_t *hysgen_board_record(board_t *board)
{
    return board->record;
}

board_span_t hysgen_board_code(board_t *board)
{
    const board_span_t code = { board->code, board->watched };

    return code;
}

board_span_t hysgen_board_stack(board_t *board)
{
    const board_span_t stack = { board->stack, board->watched };

    return stack;
}

void hysgen_board_alive(board_t *board)
{
    board->alive += 1u;
}

uint32_t hysgen_board_line_read(board_t *board, uint8_t *bytes, uint32_t room)
{
    const uint32_t count = (board->incoming_count < room) ? board->incoming_count : room;

    if (board->preempts_line != 0u) {
        preempted(board);
    }
    if (count != 0u) {
        memcpy(bytes, board->incoming, count);
        board->incoming += count;
    }
    board->incoming_count -= count;
    return count;
}

uint32_t hysgen_board_line_write(board_t *board, const uint8_t *bytes, uint32_t count)
{
    uint32_t taken = 0u;

    while ((taken < count) && (board->outgoing_count < HOST_LINE)) {
        board->outgoing[board->outgoing_count] = bytes[taken];
        board->outgoing_count += 1u;
        taken += 1u;
    }
    return taken;
}

void hysgen_board_store_read(board_t *board, uint32_t slot, uint32_t offset, uint8_t *bytes, uint32_t count)
{
    memcpy(bytes, &board->store[slot][offset], count);
}

void hysgen_board_store_erase(board_t *board, uint32_t slot)
{
    preempted(board);
    for (uint32_t i = 0u; i < BOARD_SLOT_BYTES; ++i) {
        if (powered(board) != 0u) {
            board->store[slot][i] = 0xFFu;
        }
    }
}

uint32_t hysgen_board_store_write(board_t *board, uint32_t slot, uint32_t offset, const uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0u; i < count; ++i) {
        if (powered(board) != 0u) {
            board->store[slot][offset + i] = bytes[i];
        }
    }
    preempted(board);
    return 1u;
}
