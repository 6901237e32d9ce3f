/* main.c: owns the one instance of everything. Interrupt 4 comes to hysgen_main_tick: from start.s, or, with TI's tools, from a
 * vector table of yours (docs/firmware.md). */

#include <stddef.h>

#include "bytes.h"
#include "chip.h"
#include "console.h"
#include "firmware.h"
#include "flash.h"
#include "model.h"

static firmware_t main_firmware;
static board_t main_board;

#if !defined(MAIN_FILLED_IN)
#error "fill in main_settings and main_owner with your stage's numbers and your key, and define MAIN_FILLED_IN"
#endif

/* The stage of docs/firmware.md: fill in yours. */
static const settings_t main_settings = {
    .options = 0u,
    .off_V = 0.0f,
    .low_V = -20.0f,
    .high_V = 120.0f,
    .step_V = 1.5f,
    .ramp_V = 0.02f,
    .loop_low_V = 22.0f,
    .loop_high_V = 56.0f,
    .power_samples = 100u,
    .hold_samples = 4096u,
    .offset_um = 1.0f,
    .state_samples = 250000u,
    .reference_step_um = 0.02f,
    .follow_um = 0.0f,
    .reading_zero_um = 0.0f,
    .reading_gain = 1.0f,
    .output_zero_V = 0.0f,
    .output_gain = 1.0f,
};

/* Fill in: your key (`hysgen image --key`), and the number of this stage and its electronics. A key of zeros takes no image. */
static const image_owner_t main_owner = { { 0u, 0u, 0u, 0u }, { 0u, 0u } };

#if defined(__TI_COMPILER_VERSION__)
#define MAIN_INTERRUPT interrupt
#else
#define MAIN_INTERRUPT

/* Where start.s goes with a stack: variables without initial values become 0, the stack is filled, then main. */
extern uint32_t hysgen_start_bss[];
extern uint32_t hysgen_start_bss_end[];
extern uint32_t hysgen_start_stack[];
int main(void);
void hysgen_start(void);

void hysgen_start(void)
{
    uint32_t *word = hysgen_start_bss;

    while (word != hysgen_start_bss_end) {
        *word = 0u;
        ++word;
    }
    for (uint32_t i = 0u; i < BOARD_STACK; ++i) {
        hysgen_start_stack[i] = BOARD_STACK_FILL;
    }
    (void)main();
}
#endif

MAIN_INTERRUPT void hysgen_main_tick(void);
MAIN_INTERRUPT void hysgen_main_tick(void)
{
    hysgen_firmware_interrupt(&main_firmware, &main_board);
}

/* From the NMI slot, for exceptions and NMI alike: amplifier off; then the watchdog resets the chip. */
void hysgen_main_panic(void);
void hysgen_main_panic(void)
{
    hysgen_firmware_panic(&main_firmware, &main_board);
    for (;;) {
        /* Until the watchdog acts. */
    }
}

/* What was built, before anything else can fail. */
static void main_print_build(void)
{
    hysgen_console_text("\r\nhysgen firmware: model " MODEL_NAME ", build ");
    hysgen_console_word(MODEL_BUILD);
    hysgen_console_text("\r\ncore ");
    hysgen_console_number(CHIP_CORE_HZ / 1000000u);
    hysgen_console_text(" MHz, period ");
    hysgen_console_number(BOARD_PERIOD_NS);
    hysgen_console_text(" ns\r\nflash W25Q64JV: ");
    hysgen_console_text((hysgen_flash_present() != 0u) ? "found\r\n" : "NOT FOUND, no parameter image can be kept\r\n");
    hysgen_console_text("self-test: ");
}

/* What the boot has found. */
static void main_print_boot(const firmware_t *firmware)
{
    hysgen_console_number(firmware->selftest);
    hysgen_console_text((firmware->selftest == 0u) ? " words differ\r\n" : " WORDS DIFFER: do not start\r\n");
    hysgen_console_text("settings: ");
    if (firmware->settings_wrong == NULL) {
        hysgen_console_text("good\r\n");
    } else {
        hysgen_console_text("REFUSED: ");
        hysgen_console_text(firmware->settings_wrong);
        hysgen_console_text("\r\n");
    }
    hysgen_console_text("parameters: ");
    if (firmware->store.slot == STORE_NONE) {
        hysgen_console_text("built in\r\n");
    } else {
        hysgen_console_text("image ");
        hysgen_console_number(bytes_word(&firmware->store.bytes[4u * IMAGE_COUNTER]));
        hysgen_console_text("\r\n");
    }
    if ((firmware->image_status & STATUS_IMAGE_FALLBACK) != 0u) {
        hysgen_console_text("parameters: THE NEWEST IMAGE IS DAMAGED, these are older\r\n");
    }
    hysgen_console_text("frames from here on\r\n");
    hysgen_console_end();
}

int main(void)
{
    const uint32_t failed = hysgen_chip_start(BOARD_OUTPUTS);

    if (failed != 0u) {
        hysgen_console_text((failed == 1u) ? "\r\nPLL0 DOES NOT START\r\n" : "\r\nNO POWER FOR A DEVICE\r\n");
        for (;;) {
            /* Without clock or power of the devices nothing can be driven: the amplifier stays off. */
        }
    }
    main_print_build();
    hysgen_firmware_boot(&main_firmware, &main_board, &main_settings, &main_owner);
    main_print_boot(&main_firmware);
    hysgen_board_start(&main_board);
    for (;;) {
        hysgen_firmware_idle(&main_firmware, &main_board);
    }
}
