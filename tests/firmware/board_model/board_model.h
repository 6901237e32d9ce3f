/* The C6748 as the firmware sees it from its core, and the parts on its board, register by register.
 *
 * Read by the C compiler and by cffi: declarations only. One model serves the host, where the drivers are compiled with CHIP_MODEL, and
 * the simulated C674x, whose loads and stores outside its memory come here. Time passes with the cycles of the core, whose clock is
 * what PLL0 makes of the crystal. Nothing here was compared with silicon. */

typedef struct {
    /* Set before board_model_reset. */
    double crystal_Hz;
    uint8_t *flash;                             /* content of the W25Q64JV, 8 MiB */
    double erase_s, program_s, conversion_s;    /* times of flash and A/D */
    double (*plant)(void *plant_state, double u_V); /* the stage, one sample of the A/D: displacement [um] */
    void *plant_state;
    double adc_zero_um, adc_step_um, dac_low_V, dac_per_V; /* scales of sensor and amplifier */
    uint32_t input_pins;                        /* levels of GP0[0..15] from outside; the A/D's BUSY is added */
    uint32_t flash_absent, pll_fails, power_fails; /* 1: no flash, GO of PLL0 does not end, modules do not follow their command */

    /* Time. */
    uint64_t cycle;             /* of the core */
    double ticks;               /* periods of the crystal since power on */
    double core_ratio;          /* cycles of the core per period of the crystal */

    /* SYSCFG0, PLL0, PSC. */
    uint32_t kick[2], pinmux[20], cfgchip0;
    uint32_t pll_control, pll_multiplier, pll_prediv, pll_postdiv, pll_divider[8], pll_active[8];
    double pll_go_until, pll_reset_since, pll_lock_since;
    uint32_t power_next[2][32], power_state[2][32];
    double power_until[2];

    /* GPIO banks 0 and 1, interrupt controller, EMIFA. */
    uint32_t gpio_direction, gpio_output, intmux1, expmask3, emifa_config[2];

    uint16_t shared[65536];     /* the shared RAM, in words of 16 bits */

    /* Timer64P0 and Timer64P1. */
    uint32_t timer_tgcr[2], timer_tcr[2], timer_period[2][2], timer_intctl;
    double timer_from[2];       /* when the count was 0 */
    uint32_t timer_level;       /* of TM64P0_OUT12 in clock mode */
    uint32_t dog;               /* watchdog: 0 off, 1 first word seen, 2 active, 3 active with the first word seen */
    uint64_t dog_served;
    uint32_t dog_bitten;        /* the watchdog resets the chip */
    uint32_t reset_under_power; /* resets behind the first, which is power on */
    uint64_t interrupts;        /* of Timer64P0 */

    /* UART2, and the adapter at its other end, 115200 bit/s. */
    uint32_t uart_ier, uart_fcr, uart_lcr, uart_mcr, uart_divisor, uart_power, uart_mdr, uart_overrun;
    uint8_t uart_received[16], uart_sending[16];
    uint32_t uart_received_count, uart_sending_count;
    double uart_sent_at, line_next_at;
    uint8_t line_in[8192], line_out[65536];
    uint32_t line_in_first, line_in_last, line_out_count;

    /* SPI1 and W25Q64JV. */
    uint32_t spi_gcr0, spi_gcr1, spi_pc0, spi_fmt0, spi_delay, spi_def, spi_buffer, spi_arriving;
    double spi_done_at, flash_busy_until;
    uint32_t flash_selected, flash_instruction, flash_count, flash_address, flash_enabled;
    uint8_t flash_page[256], flash_latched[256];
    uint32_t flash_erased, flash_programmed;

    /* AD7606C-16 and AD5547. */
    double adc_done_at, adc_reset_since;
    uint32_t adc_resets;        /* RESET is high */
    uint32_t adc_ready;         /* a reset has ended since power on */
    int32_t adc_code[2];        /* the conversion before, the one that runs */
    int32_t adc_back;           /* of V2 */
    uint32_t adc_reads, dac_code, dac_writes;
    uint64_t conversions;

    /* What the chip, or a part, would not do or answer: how often, and the first of each kind. */
    uint32_t violations;
    const char *violation[16];
} board_model_t;

/* Reset of the chip: its devices, not the parts beside it. */
void board_model_reset(board_model_t *model);

/* Accesses of the core, and what interrupts it: bits of IFR, bit 0 for a reset of the chip; `next`: the cycle of the next call. */
uint64_t device_load(void *model, uint64_t cycle, uint32_t address, uint32_t size);
void device_store(void *model, uint64_t cycle, uint32_t address, uint32_t size, uint64_t value);
uint32_t device_events(void *model, uint64_t cycle, uint64_t *next);

/* The voltage at the amplifier's output, and whether the enable pin GP0[2] is driven high. */
double board_model_output_V(const board_model_t *model);
uint32_t board_model_pin(const board_model_t *model, uint32_t pin);
