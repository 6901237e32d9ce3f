/* board.c: the C6748's board, to be filled in where board_type.h says so. The store is ../empty_store.c. */

#include "board.h"

#include "model.h"
#include "number.h"

#if MODEL_PERIOD_NS != BOARD_PERIOD_NS
#error "the model was identified at another sampling period than this board's timer has: see BOARD_PERIOD"
#endif

#define TIMER0            0x01C20000u
#define TIMER_TIM12       0x10u
#define TIMER_PRD12       0x18u
#define TIMER_TCR         0x20u
#define TIMER_TGCR        0x24u
#define INTC_INTMUX1      0x01800104u
#define EVENT_TIMER0      4u            /* T64P0_TINT12 */

static volatile uint32_t *board_register(uint32_t address)
{
    return (volatile uint32_t *)(uintptr_t)address;
}

#if defined(__TI_COMPILER_VERSION__)
#include <c6x.h>

extern void vectors(void);  /* vectors.asm */

static uint32_t board_counter(void)
{
    return TSCL;
}

static void board_enable(void)
{
    TSCL = 0u;             /* any write starts it */
    ISTP = (uint32_t)vectors;
    ICR = 0xFFF0u;
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

void board_start(board_t *board)
{
    board->next = 0u;
    board->line_in = 0u;
    board->line_start = 0u;
    board->line_begins = 0u;
    board->line_out = 0u;
    board->line_begun = 0u;
    board->line_broken = 1u;
    /* Timer64P0 as one 32-bit timer that reloads; its event to interrupt 4. */
    *board_register(TIMER0 + TIMER_TGCR) = 0u;
    *board_register(TIMER0 + TIMER_TGCR) = 0x5u; /* unchained 32 bit, TIM12 out of reset */
    *board_register(TIMER0 + TIMER_TIM12) = 0u;
    *board_register(TIMER0 + TIMER_PRD12) = BOARD_PERIOD - 1u;
    *board_register(INTC_INTMUX1) = (*board_register(INTC_INTMUX1) & ~0x7Fu) | EVENT_TIMER0;
    *board_register(TIMER0 + TIMER_TCR) = 0x80u; /* continuous */
    board_enable();
}

float board_displacement_um(board_t *board)
{
    const uint32_t code = *(volatile uint16_t *)(uintptr_t)BOARD_ADC_ADDRESS;

    (void)board;
    return BOARD_ADC_LOW_UM + BOARD_ADC_STEP_UM * (float)(int32_t)code;
}

float board_reference_um(board_t *board)
{
    const float reference_um = board->reference_um[board->next];

    board->next = (board->next + 1u) & (BOARD_REFERENCES - 1u);
    return reference_um;
}

uint32_t board_amplifier(board_t *board)
{
    (void)board;
    return *board_register(BOARD_AMPLIFIER_PINS) & 3u;
}

void board_voltage(board_t *board, float u_V)
{
    const float code = number_limited((u_V - BOARD_DAC_LOW_V) * BOARD_DAC_PER_V + 0.5f, 0.0f, BOARD_DAC_CODES);

    (void)board;
    *board_register(BOARD_DAC_ADDRESS) = (uint32_t)(int32_t)code;
}

uint32_t board_cycles(board_t *board)
{
    (void)board;
    return board_counter();
}

uint32_t board_overrun(board_t *board)
{
    (void)board;
    return board_waiting();
}

void board_link(board_t *board, uint8_t byte, uint32_t begins)
{
    const uint32_t in = board->line_in;

    if (begins != 0u) {
        board->line_broken = 0u;
    }
    if ((in - board->line_out) >= BOARD_LINE) {
        board->line_broken = 1u;
    }
    if (board->line_broken == 0u) {
        board->line[in & (BOARD_LINE - 1u)] = byte;
        board->line_in = in + 1u;
        if (begins != 0u) {
            board->line_start = in;
            board->line_begins += 1u;
        }
    }
}

uint32_t board_receive(board_t *board, uint8_t *bytes, uint32_t room, uint32_t *begin)
{
    /* In this order: an image that begins in between lies behind `in`. */
    const uint32_t in = board->line_in;
    const uint32_t begins = board->line_begins;
    const uint32_t start = board->line_start;
    uint32_t out = board->line_out;
    uint32_t count = 0u;

    *begin = 0u;
    /* Bytes of the image before, whole or not, come first: a call ends where the next image begins. */
    if ((board->line_begun != begins) & (out == start) & (out != in)) {
        *begin = 1u;
        board->line_begun = begins;
    }
    while ((count < room) & (out != in) & ((board->line_begun == begins) | (out != start))) {
        bytes[count] = board->line[out & (BOARD_LINE - 1u)];
        out += 1u;
        count += 1u;
    }
    board->line_out = out;
    return count;
}
