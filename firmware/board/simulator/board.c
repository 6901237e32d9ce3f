/* board.c: the board of the simulated C674x, and the three calls by which its caller runs the image.
 *
 * The store is ../empty_store.c. The same file runs on the host, for the same bits. */

#include "board.h"
#include "firmware.h"

static firmware_t simulated;
static board_t simulated_board;

/* Short ways, so that a few thousand samples go through every state. */
static settings_t simulated_settings = {
    .options = SETTINGS_LOOP | SETTINGS_LEARN,
    .off_V = 0.0f,
    .low_V = -20.0f,
    .high_V = 120.0f,
    .step_V = 2.0f,
    .ramp_V = 0.5f,
    .loop_low_V = 24.0f,
    .loop_high_V = 54.0f,
    .power_samples = 16u,
    .hold_samples = 64u,
    .offset_um = 1.0f,
    .state_samples = 250000u,
    .reference_step_um = 0.05f,
    .follow_um = 0.45f,
    .reading_gain = 1.0f,
    .output_gain = 1.0f,
};

static const image_owner_t simulated_owner = { { 1u, 0u, 0u, 0u }, { 0u, 0u } };

float hysgen_board_displacement_um(board_t *board)
{
    return board->reading_um;
}

float hysgen_board_reference_um(board_t *board)
{
    return board->reference_um;
}

uint32_t hysgen_board_amplifier(board_t *board)
{
    return (board->enabled != 0u) ? 0u : BOARD_AMPLIFIER_FAILED;
}

void hysgen_board_voltage(board_t *board, float u_V)
{
    board->output_V = u_V;
}

uint32_t hysgen_board_cycles(board_t *board)
{
    (void)board;
    return 0u;
}

uint32_t hysgen_board_overrun(board_t *board)
{
    (void)board;
    return 0u;
}

void hysgen_board_line_serve(board_t *board)
{
    (void)board;
}

void hysgen_board_amplifier_enable(board_t *board, uint32_t on)
{
    board->enabled = on;
}

uint32_t *hysgen_board_kept(board_t *board)
{
    return board->kept;
}

uint32_t hysgen_board_power_on(board_t *board)
{
    (void)board;
    return 1u;
}

void hysgen_board_calibrate(board_t *board, float zero_um, float gain_um, float zero_V, float gain_V)
{
    (void)board;
    (void)zero_um;
    (void)gain_um;
    (void)zero_V;
    (void)gain_V;
}

float hysgen_board_read_back_V(const board_t *board)
{
    return board->output_V;
}

volatile uint16_t *hysgen_board_record(board_t *board)
{
    return board->record;
}

/* No code, but words to look at, for the cycles. */
board_span_t hysgen_board_code(board_t *board)
{
    static const uint32_t words[256] = { 1u };
    const board_span_t code = { words, 256u };

    (void)board;
    return code;
}

board_span_t hysgen_board_stack(board_t *board)
{
    const board_span_t stack = { board->stack, 64u };

    for (uint32_t i = 0u; i < stack.count; ++i) {
        board->stack[i] = BOARD_STACK_FILL;
    }
    return stack;
}

void hysgen_board_alive(board_t *board)
{
    (void)board;
}

uint32_t hysgen_board_line_read(board_t *board, uint8_t *bytes, uint32_t room)
{
    uint32_t count = 0u;

    while ((count < room) && (board->in_first != board->in_last)) {
        bytes[count] = board->in[board->in_first & (SIMULATED_LINE - 1u)];
        board->in_first += 1u;
        count += 1u;
    }
    return count;
}

uint32_t hysgen_board_line_write(board_t *board, const uint8_t *bytes, uint32_t count)
{
    uint32_t taken = 0u;

    while ((taken < count) && (board->out_last - board->out_first < SIMULATED_LINE)) {
        board->out[board->out_last & (SIMULATED_LINE - 1u)] = bytes[taken];
        board->out_last += 1u;
        taken += 1u;
    }
    return taken;
}

void hysgen_simulated_options(uint32_t options);
uint32_t hysgen_simulated_boot(void);
float hysgen_simulated_interrupt(float reading_um, float reference_um);
uint32_t hysgen_simulated_idle(void);
uint32_t hysgen_simulated_state(void);
void hysgen_simulated_send(uint32_t byte);
uint32_t hysgen_simulated_sent(void);

/* SETTINGS_ bits of the next boot. */
void hysgen_simulated_options(uint32_t options)
{
    simulated_settings.options = options;
}

/* Returns the mismatches that the self-test found. */
uint32_t hysgen_simulated_boot(void)
{
    hysgen_firmware_boot(&simulated, &simulated_board, &simulated_settings, &simulated_owner);
    simulated.controller.request = CONTROLLER_START;
    return simulated.selftest;
}

float hysgen_simulated_interrupt(float reading_um, float reference_um)
{
    simulated_board.reading_um = reading_um;
    simulated_board.reference_um = reference_um;
    hysgen_firmware_interrupt(&simulated, &simulated_board);
    return simulated_board.output_V;
}

/* Returns the status word. */
uint32_t hysgen_simulated_idle(void)
{
    hysgen_firmware_idle(&simulated, &simulated_board);
    return hysgen_firmware_status(&simulated);
}

/* State, and commits above it. */
uint32_t hysgen_simulated_state(void)
{
    return (uint32_t)simulated.controller.state | (simulated.commits << 8);
}

/* A byte to the firmware's line. */
void hysgen_simulated_send(uint32_t byte)
{
    simulated_board.in[simulated_board.in_last & (SIMULATED_LINE - 1u)] = (uint8_t)byte;
    simulated_board.in_last += 1u;
}

/* The next byte from the firmware's line, or 256 if there is none. */
uint32_t hysgen_simulated_sent(void)
{
    uint32_t byte = 256u;

    if (simulated_board.out_first != simulated_board.out_last) {
        byte = simulated_board.out[simulated_board.out_first & (SIMULATED_LINE - 1u)];
        simulated_board.out_first += 1u;
    }
    return byte;
}
