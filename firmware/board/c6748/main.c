/* main.c: owns the one instance of everything. Interrupt 4 comes to main_tick: from start.s, or, with TI's tools, from the
 * vector table of your project. */

#include "chip.h"
#include "firmware.h"

static firmware_t main_firmware;
static board_t main_board;

/* The stage of docs/firmware.md: fill in yours. */
static const settings_t main_settings = {
    .options = 0u,
    .off_V = 0.0f,
    .low_V = -20.0f,
    .high_V = 120.0f,
    .step_V = 1.5f,
    .ramp_V = 0.02f,
    .fall_V = 0.05f,
    .loop_low_V = 22.0f,
    .loop_high_V = 56.0f,
    .loop_middle_V = 39.0f,
    .hold_samples = 4096u,
    .stroke_um = 0.5f,
    .offset_smoothing = 0.001953125f,
    .offset_um = 1.0f,
    .approach_um = 0.001f,
    .state_samples = 250000u,
    .reference_step_um = 0.02f,
    .low_um = -3.2f,
    .high_um = 13.0f,
    .stuck_V = 0.5f,
    .stuck_samples = 64u,
    .follow_um = 0.5f,
    .follow_samples = 50u,
    .bad_samples = 8u,
    .period_cycles = 7500u,
    .budget_cycles = 7500u,
    .trim_integral = 0.004f,
    .trim_proportion = 0.05f,
    .trim_smoothing = 0.05f,
    .trim_limit_um = 0.25f,
    .commit_pause = 25000u,
};

/* Fill in: your key (`hysgen image --key`), and the number of this stage and its electronics. All zeros: no secret. */
static const image_owner_t main_owner = { { 0u, 0u, 0u, 0u }, { 0u, 0u } };

#if defined(__TI_COMPILER_VERSION__)
#define MAIN_INTERRUPT interrupt
#else
#define MAIN_INTERRUPT

/* Where start.s goes with a stack: variables without initial values become 0, then main. */
extern uint32_t start_bss[];
extern uint32_t start_bss_end[];
int main(void);
void start(void);

void start(void)
{
    uint32_t *word = start_bss;

    while (word != start_bss_end) {
        *word = 0u;
        ++word;
    }
    (void)main();
}
#endif

MAIN_INTERRUPT void main_tick(void);
MAIN_INTERRUPT void main_tick(void)
{
    firmware_interrupt(&main_firmware, &main_board);
}

/* From the NMI slot, for exceptions and NMI alike: output to off_V, amplifier off; then the watchdog resets the chip. */
void main_panic(void);
void main_panic(void)
{
    firmware_panic(&main_firmware, &main_board);
    for (;;) {
        /* Until the watchdog acts. */
    }
}

int main(void)
{
    if (chip_start(BOARD_AMPLIFIER_ENABLE) != 0u) {
        for (;;) {
            /* Without clock or power of the devices nothing can be driven: the amplifier stays off. */
        }
    }
    firmware_boot(&main_firmware, &main_board, &main_settings, &main_owner);
    board_start(&main_board);
    for (;;) {
        firmware_idle(&main_firmware, &main_board);
    }
}
