/* drivers.c: in place of main.c and the controller, every driver of the C6748's board once: start-up, text, flash, then in the interrupt
 * converters and watchdog, and in the idle loop an echo of the line. */

#include "board.h"
#include "chip.h"
#include "console.h"
#include "flash.h"

#define BYTES 300u   /* across the border of a page */
#define PLACE 200u

static board_t board;
uint32_t drivers_started, drivers_flash_wrong, drivers_ticks, drivers_planted;
float drivers_reading_um, drivers_output_V;

/* What start.s calls. */
void hysgen_start(void);
void hysgen_main_tick(void);
void hysgen_main_panic(void);

/* Erases a slot, writes it twice, reads it back: bits only fall. */
static uint32_t flash_wrong(void)
{
    static uint8_t first[BYTES], second[BYTES], read[BYTES];
    uint32_t wrong = 1u - hysgen_flash_present();

    for (uint32_t i = 0u; i < BYTES; ++i) {
        first[i] = (uint8_t)(i * 7u + 3u);
        second[i] = (uint8_t)(i * 5u + 1u);
    }
    hysgen_board_store_erase(&board, 1u);
    wrong += 1u - hysgen_board_store_write(&board, 1u, PLACE, first, BYTES);
    wrong += 1u - hysgen_board_store_write(&board, 1u, PLACE, second, BYTES);
    hysgen_board_store_read(&board, 1u, PLACE, read, BYTES);
    for (uint32_t i = 0u; i < BYTES; ++i) {
        wrong += (uint32_t)(read[i] != (uint8_t)(first[i] & second[i]));
    }
    return wrong;
}

void hysgen_main_tick(void)
{
    drivers_reading_um = hysgen_board_displacement_um(&board);
    hysgen_board_voltage(&board, drivers_output_V);
    hysgen_board_line_serve(&board);
    hysgen_board_amplifier_enable(&board, 1u);
    hysgen_board_alive(&board);
    drivers_ticks += 1u;
}

void hysgen_main_panic(void)
{
    hysgen_board_voltage(&board, 0.0f);
    hysgen_board_amplifier_enable(&board, 0u);
    for (;;) {
    }
}

void hysgen_start(void)
{
    uint8_t byte = 0u;

    drivers_ticks = 0u;
    drivers_output_V = 40.0f;
    drivers_started = hysgen_chip_start(BOARD_OUTPUTS);
    hysgen_console_text("drivers ");
    hysgen_console_number(1234567890u);
    hysgen_console_text(" ");
    hysgen_console_word(0x09AFu);
    hysgen_console_end();
    drivers_flash_wrong = flash_wrong();
    hysgen_board_calibrate(&board, 0.0f, 1.0f, 0.0f, 1.0f);
    hysgen_board_start(&board);
    for (;;) {
        if (hysgen_board_line_read(&board, &byte, 1u) != 0u) {
            (void)hysgen_board_line_write(&board, &byte, 1u);
        }
    }
}
