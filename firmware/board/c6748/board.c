/* board.c: the C6748's board, to be filled in where board_type.h says so. The store is flash.c. */

#include "board.h"

#include "chip.h"
#include "model.h"
#include "number.h"

#if MODEL_PERIOD_NS != BOARD_PERIOD_NS
#error "the model was identified at another sampling period than this board's timer has: see BOARD_PERIOD"
#endif

#if defined(__TI_COMPILER_VERSION__)
#include <c6x.h>

extern void hysgen_vectors(void);  /* of a vector table of yours */

static uint32_t board_counter(void)
{
    return TSCL;
}

static void board_enable(void)
{
    TSCL = 0u;             /* any write starts it */
    ISTP = (uint32_t)hysgen_vectors;
    ICR = 0xFFF0u;
    TSR |= 12u;            /* GEE, XEN: exceptions go to the NMI slot; start.s sets them for gcc */
    IER |= (1u << 4) | 2u; /* interrupt 4, and NMI */
    CSR |= 1u;             /* global enable */
}

static uint32_t board_waiting(void)
{
    return (IFR >> 4) & 1u;
}
#else
static uint32_t board_counter(void)
{
    uint32_t count;

    __asm__ volatile("mvc .S2 TSCL, %0" : "=b"(count));
    return count;
}

static void board_enable(void)
{
    const uint32_t start = 0u;
    const uint32_t clear = 0xFFF0u;
    const uint32_t some = (1u << 4) | 2u;
    uint32_t control;

    __asm__ volatile("mvc .S2 %0, TSCL" : : "b"(start));
    __asm__ volatile("mvc .S2 %0, ICR" : : "b"(clear));
    __asm__ volatile("mvc .S2 %0, IER" : : "b"(some));
    __asm__ volatile("mvc .S2 CSR, %0" : "=b"(control));
    control |= 1u;
    /* Interrupts come from here on: what was written before must be in memory. */
    __asm__ volatile("mvc .S2 %0, CSR" : : "b"(control) : "memory");
}

static uint32_t board_waiting(void)
{
    uint32_t flags;

    __asm__ volatile("mvc .S2 IFR, %0" : "=b"(flags));
    return (flags >> 4) & 1u;
}
#endif

/* Of c6748.ld: behind the stack, which no start-up clears. */
extern uint32_t hysgen_start_kept[];

void hysgen_board_start(board_t *board)
{
    board->next = 0u;
    board->received.in = 0u;
    board->received.out = 0u;
    board->sent.in = 0u;
    board->sent.out = 0u;
    hysgen_chip_pulse(BOARD_ADC_RESET);
    hysgen_chip_start_sampling(BOARD_PERIOD);
    board_enable();
}

float hysgen_board_displacement_um(board_t *board)
{
    uint32_t polls = 0u;
    float reading_um = number_of(NUMBER_NAN);

    while (((chip_read(CHIP_GPIO + CHIP_GPIO_IN) & BOARD_ADC_BUSY) != 0u) && (polls < BOARD_ADC_POLLS)) {
        polls += 1u;
    }
    if (polls < BOARD_ADC_POLLS) {
        /* Two's complement of 16 bits: as offset binary, less the offset. */
        const uint16_t word = chip_bus_read(BOARD_ADC_ADDRESS);
        const uint32_t code = (uint32_t)word ^ 0x8000u;
        const int32_t steps = (int32_t)code - 0x8000;

        /* At a rail it is none, whatever the calibration makes of it. */
        if ((code != 0u) && (code != 0xFFFFu)) {
            reading_um = board->adc_zero_um + board->adc_step_um * (float)steps;
        }
#if BOARD_READS_BACK
        board->read_back = (uint32_t)chip_bus_read(BOARD_ADC_ADDRESS) ^ 0x8000u;
#endif
    }
    return reading_um;
}

float hysgen_board_reference_um(board_t *board)
{
    const float reference_um = board->reference_um[board->next];

    board->next = (board->next + 1u) & (BOARD_REFERENCES - 1u);
    return reference_um;
}

uint32_t hysgen_board_amplifier(board_t *board)
{
    uint32_t bits = ~chip_read(CHIP_GPIO + CHIP_GPIO_IN) & (BOARD_AMPLIFIER_PINS | BOARD_STOP_PIN);

#if BOARD_READS_BACK
    if ((board->read_back + BOARD_READ_BACK_CODES) - board->written > 2u * BOARD_READ_BACK_CODES) {
        bits |= BOARD_AMPLIFIER_FAILED;
    }
#else
    (void)board;
#endif
    return bits;
}

void hysgen_board_voltage(board_t *board, float u_V)
{
    const float built_V = u_V * board->dac_gain + board->dac_zero_V;
    const uint32_t code = (uint32_t)number_limited((built_V - BOARD_DAC_LOW_V) * BOARD_DAC_PER_V + 0.5f, 0.0f, BOARD_DAC_CODES);

    chip_bus_write(BOARD_DAC_ADDRESS, (uint16_t)code);
#if BOARD_READS_BACK
    board->written = code;
#endif
}

uint32_t hysgen_board_cycles(board_t *board)
{
    (void)board;
    return board_counter();
}

uint32_t hysgen_board_overrun(board_t *board)
{
    (void)board;
    return board_waiting();
}

/* One word of a ring is written by one side only: `in` by the side that puts bytes in, `out` by the other. */
static uint32_t ring_put(board_ring_t *ring, uint8_t byte)
{
    const uint32_t in = ring->in;
    const uint32_t fits = (uint32_t)((in - ring->out) < BOARD_LINE);

    if (fits != 0u) {
        ring->bytes[in & (BOARD_LINE - 1u)] = byte;
        ring->in = in + 1u;
    }
    return fits;
}

static uint32_t ring_take(board_ring_t *ring, uint8_t *byte)
{
    const uint32_t out = ring->out;
    const uint32_t holds = (uint32_t)(out != ring->in);

    if (holds != 0u) {
        *byte = ring->bytes[out & (BOARD_LINE - 1u)];
        ring->out = out + 1u;
    }
    return holds;
}

void hysgen_board_line_serve(board_t *board)
{
    const uint32_t line = chip_read(CHIP_UART2 + CHIP_UART_LSR);
    uint8_t byte = 0u;

    if ((line & CHIP_UART_RECEIVED) != 0u) {
        (void)ring_put(&board->received, (uint8_t)(chip_read(CHIP_UART2 + CHIP_UART_DATA) & 0xFFu));
    }
    if (((line & CHIP_UART_EMPTY) != 0u) && (ring_take(&board->sent, &byte) != 0u)) {
        chip_write(CHIP_UART2 + CHIP_UART_DATA, byte);
    }
}

void hysgen_board_amplifier_enable(board_t *board, uint32_t on)
{
    (void)board;
    chip_write(CHIP_GPIO + ((on != 0u) ? CHIP_GPIO_SET : CHIP_GPIO_CLEAR), BOARD_AMPLIFIER_ENABLE);
}

uint32_t *hysgen_board_kept(board_t *board)
{
    (void)board;
    return hysgen_start_kept;
}

uint32_t hysgen_board_power_on(board_t *board)
{
    (void)board;
    return chip_read(CHIP_RESET_TYPE) & CHIP_RESET_POWER_ON;
}

void hysgen_board_calibrate(board_t *board, float zero_um, float gain_um, float zero_V, float gain_V)
{
    board->adc_zero_um = zero_um + gain_um * BOARD_ADC_ZERO_UM;
    board->adc_step_um = gain_um * BOARD_ADC_STEP_UM;
    board->dac_zero_V = zero_V;
    board->dac_gain = gain_V;
}

float hysgen_board_read_back_V(const board_t *board)
{
#if BOARD_READS_BACK
    return BOARD_DAC_LOW_V + ((BOARD_HIGH_V - BOARD_DAC_LOW_V) / BOARD_DAC_CODES) * (float)board->read_back;
#else
    (void)board;
    return number_of(NUMBER_NAN);
#endif
}

/* Of c6748.ld: the shared RAM. */
extern volatile uint16_t hysgen_start_shared[];

volatile uint16_t *hysgen_board_record(board_t *board)
{
    (void)board;
    return hysgen_start_shared;
}

/* Of c6748.ld: vectors, code and constants; the stack. */
extern const volatile uint32_t hysgen_start_code[];
extern const volatile uint32_t hysgen_start_code_end[];
extern const volatile uint32_t hysgen_start_stack[];

board_span_t hysgen_board_code(board_t *board)
{
    const board_span_t code = { hysgen_start_code, (uint32_t)((uintptr_t)hysgen_start_code_end - (uintptr_t)hysgen_start_code) >> 2 };

    (void)board;
    return code;
}

board_span_t hysgen_board_stack(board_t *board)
{
    const board_span_t stack = { hysgen_start_stack, BOARD_STACK };

    (void)board;
    return stack;
}

void hysgen_board_alive(board_t *board)
{
    (void)board;
    chip_write(CHIP_TIMER1 + CHIP_TIMER_WDTCR, CHIP_WATCHDOG_FIRST);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_WDTCR, CHIP_WATCHDOG_SECOND);
}

uint32_t hysgen_board_line_read(board_t *board, uint8_t *bytes, uint32_t room)
{
    uint32_t count = 0u;

    while ((count < room) && (ring_take(&board->received, &bytes[count]) != 0u)) {
        count += 1u;
    }
    return count;
}

uint32_t hysgen_board_line_write(board_t *board, const uint8_t *bytes, uint32_t count)
{
    uint32_t taken = 0u;

    while ((taken < count) && (ring_put(&board->sent, bytes[taken]) != 0u)) {
        taken += 1u;
    }
    return taken;
}
