#include "console.h"

#include "chip.h"

#define CONSOLE_WAITS   100000u  /* polls until a byte counts as lost: a UART that hangs does not stop the start */

static void console_byte(uint8_t byte)
{
    uint32_t waits = 0u;

    while (((chip_read(CHIP_UART2 + CHIP_UART_LSR) & CHIP_UART_EMPTY) == 0u) && (waits < CONSOLE_WAITS)) {
        waits += 1u;
    }
    if (waits < CONSOLE_WAITS) {
        chip_write(CHIP_UART2 + CHIP_UART_DATA, byte);
    }
}

void hysgen_console_text(const char *text)
{
    for (uint32_t i = 0u; text[i] != '\0'; ++i) {
        console_byte((uint8_t)text[i]);
    }
}

/* By subtraction: the C674x divides by a call of a library. */
void hysgen_console_number(uint32_t number)
{
    static const uint32_t powers[] = { 1000000000u, 100000000u, 10000000u, 1000000u, 100000u, 10000u, 1000u, 100u, 10u, 1u };
    uint32_t left = number;
    uint32_t begun = 0u;

    for (uint32_t i = 0u; i < (uint32_t)(sizeof powers / sizeof powers[0]); ++i) {
        uint8_t digit = 0x30u;

        while (left >= powers[i]) {
            left -= powers[i];
            digit += 1u;
        }
        begun |= (uint32_t)((digit != 0x30u) || (powers[i] == 1u));
        if (begun != 0u) {
            console_byte(digit);
        }
    }
}

void hysgen_console_word(uint32_t word)
{
    for (uint32_t shift = 32u; shift != 0u; shift -= 4u) {
        const uint32_t digit = (word >> (shift - 4u)) & 0xFu;

        console_byte((uint8_t)(digit + ((digit < 10u) ? 0x30u : 0x57u)));
    }
}

void hysgen_console_end(void)
{
    console_byte(0u);
}
