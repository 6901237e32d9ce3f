/* chip.c: start-up of the C6748.
 *
 * Where the values come from. TI's manuals were not seen; their sections, tables and pages are those that public projects cite:
 *   [79]  SPRUH79C, technical reference of this device, in the hardware notes of the project c6748-hearing-aid; SPRUH79A, chapter 30, in a
 *         UART driver of Chubu University and Firmlogics
 *   [91]  SPRUH91D, technical reference of the C6745 and C6747, which have the same timers and SPI, in the models of the project
 *         cdj2000-emulator
 * Pins and modules were compared with Linux (arch/arm/mach-davinci/da850.c) and U-Boot (da850_pinmux.c, davinci_spi.h).
 * None of it ran on silicon.
 *
 *   SYSCFG  [79] KICK0R, KICK1R 10.2.2, p. 204 (without effect from silicon revision 2 on); register table p. 207, PINMUX1 p. 223, PINMUX4
 *           p. 229, PINMUX5 Table 10-27, p. 230
 *   PLL0    [79] sequence 7.2.2.2, p. 136; registers 7.3, p. 137; PLLCTL Table 7-8, p. 141; PLLM Table 7-12, p. 145; PREDIV p. 145; PLLDIVn,
 *           POSTDIV p. 151-152; clock domains Table 6-1, p. 118; PLLCMD [91] 7.4.16; PLLSTAT: same chapter
 *           RSTYPE, whose bit POR is 1 behind power on and 0 behind a reset by watchdog or pin: same chapter, page not known
 *   PSC     [79] module numbers Table 8-2, p. 166; PTCMD, PTSTAT, MDSTATn, MDCTLn: same chapter, page not known
 *   GPIO    [79] register table p. 902, 19.3.3 to 19.3.5, p. 904-908
 *   EMIFA   CE2CFG, CE3CFG: page not known; fields as Linux (drivers/memory/ti-aemif.c) and TI's E2E thread 144454 (0x087443AD, decoded) have
 *           them; strobe timing in SPRUH77 (OMAP-L138), Table 20-21, after E2E thread 292497
 *   UART2   [79] chapter 30: divisor Table 30-1, order of initialisation and registers as in the driver named above; pages not known
 *   SPI1    [91] SPIFLG 27.3.5, SPIBUF 27.3.14, chip select between transfers Table 27-21; fields of DAT1, FMT0 and DELAY as Linux
 *           (drivers/spi/spi-davinci.c) has them; pages not known
 *   Timer   [91] 32-bit unchained 28.1.5.4.2.2.4, p. 1238; TCR Table 28-17, p. 1252; TGCR Table 28-18, p. 1254; INTCTLSTAT Table 28-24,
 *           p. 1258; watchdog and its two words 28.1.6, p. 1240-1242
 *   EXPMASK SPRUFK5, "Interrupt Controller", and SPRUFE8, TSR.XEN: pages not known; events as Linux (arch/c6x/kernel/traps.c) names them.
 *           What raises which event was not tried on the chip
 *   INTMUX  [91] event 4 is T64P0_TINT12: Table 2-1, p. 70; INTMUX1: SPRUFK5 (megamodule), "Interrupt Controller", page not known */

#include "chip.h"

#define SYSCFG0          0x01C14000u
#define SYSCFG_KICK0     0x038u
#define SYSCFG_KICK1     0x03Cu
#define SYSCFG_PINMUX    0x120u         /* PINMUX0; four bits a pin */
#define SYSCFG_CFGCHIP0  0x17Cu         /* bit 4: PLL0 locked against writing */

#define PLL0             0x01C11000u
#define PLL_CTL          0x100u
#define PLL_MULTIPLIER   0x110u
#define PLL_PREDIVIDER   0x114u
#define PLL_DIVIDER1     0x118u
#define PLL_DIVIDER2     0x11Cu
#define PLL_DIVIDER3     0x120u
#define PLL_DIVIDER4     0x160u
#define PLL_DIVIDER6     0x168u
#define PLL_POSTDIV      0x128u
#define PLL_COMMAND      0x138u
#define PLL_STATUS       0x13Cu
#define PLL_DIVIDES      0x8000u
#define PLL_ENABLE       0x001u         /* PLLEN: the core runs from the PLL, not from the crystal */
#define PLL_POWER_DOWN   0x002u
#define PLL_RESET        0x008u         /* 0: in reset */
#define PLL_DISABLE      0x010u
#define PLL_SOURCE       0x020u         /* PLLENSRC: 0, so that PLLEN acts */
#define PLL_CLOCK_MODE   0x100u         /* 0: crystal */

#define PSC0             0x01C10000u
#define PSC1             0x01E27000u
#define PSC_COMMAND      0x120u
#define PSC_PENDING      0x128u
#define PSC_STATE        0x800u         /* MDSTAT0 */
#define PSC_CONTROL      0xA00u         /* MDCTL0 */
#define PSC_ON           3u
#define PSC0_EMIFA       3u
#define PSC1_GPIO        3u
#define PSC1_SPI1        10u
#define PSC1_UART2       13u

#define EMIFA            0x68000000u
#define EMIFA_CE2CFG     0x10u
#define EMIFA_CE3CFG     0x14u
#define EMIFA_BUS        0x00420319u    /* 16 bits; clocks of 10.7 ns: write 1 + 5 + 2, read 1 + 7 + 2, turn around 3 */

#define INTC_INTMUX1     0x01800104u
#define EVENT_TIMER0     4u             /* T64P0_TINT12 */
#define INTC_EXPMASK3    0x018000CCu    /* events 96 .. 127; 0: is an exception */
#define EVENT_FAULTS     0xD5800000u    /* 119, 120, 122, 124, 126: memory faults of the CPU; 127: bus error */

#define CHIP_WAITS       100000u        /* polls until a step counts as failed */

/* Where a pin is multiplexed: register, place of its four bits, function. */
typedef struct {
    uint32_t pinmux;
    uint32_t mask;
    uint32_t function;
} chip_pins_t;

static const chip_pins_t chip_pins[] = {
    { 1u, 0xFFFFF000u, 0x88888000u },  /* GP0[0] .. GP0[4] */
    { 4u, 0x00FF000Fu, 0x00220002u },  /* UART2_TXD, UART2_RXD; TM64P0_OUT12, which starts the A/D */
    { 5u, 0xFFFF0FF0u, 0x11110110u },  /* EMA_BA0, EMA_BA1; SPI1_SIMO, SPI1_SOMI, SPI1_CLK, SPI1_SCS[0] */
    { 7u, 0x00FF00FFu, 0x00110011u },  /* EMA_CS2, EMA_CS3, EMA_WE, EMA_OE */
    { 8u, 0xFFFFFFFFu, 0x11111111u },  /* EMA_D8 .. EMA_D15 */
    { 9u, 0xFFFFFFFFu, 0x11111111u },  /* EMA_D0 .. EMA_D7 */
};

static void chip_change(uint32_t address, uint32_t clear, uint32_t set)
{
    chip_write(address, (chip_read(address) & ~clear) | set);
}

/* 1 once the bits of `mask` are `value`, 0 if that takes too long. */
static uint32_t chip_waited(uint32_t address, uint32_t mask, uint32_t value)
{
    uint32_t waits = 0u;

    while (((chip_read(address) & mask) != value) && (waits < CHIP_WAITS)) {
        waits += 1u;
    }
    return (uint32_t)(waits < CHIP_WAITS);
}

/* At least `count` cycles of the core. */
static void chip_rest(uint32_t count)
{
    for (uint32_t i = 0u; i < count; ++i) {
        (void)chip_read(PLL0 + PLL_STATUS);
    }
}

/* PLL0 by the sequence of [79] 7.2.2.2, from power down: CHIP_CORE_HZ for the core, half for SYSCLK2 (UART2),
 * a quarter for EMIFA and SYSCLK4. */
static uint32_t chip_start_clock(void)
{
    uint32_t done;

    chip_change(SYSCFG0 + SYSCFG_CFGCHIP0, 0x10u, 0u);
    chip_change(PLL0 + PLL_CTL, PLL_SOURCE | PLL_ENABLE | PLL_CLOCK_MODE, 0u);
    chip_rest(32u);
    chip_change(PLL0 + PLL_CTL, PLL_RESET, PLL_DISABLE);
    chip_change(PLL0 + PLL_CTL, PLL_POWER_DOWN, 0u);
    chip_change(PLL0 + PLL_CTL, PLL_DISABLE, 0u);
    chip_write(PLL0 + PLL_MULTIPLIER, CHIP_MULTIPLIER - 1u);
    chip_write(PLL0 + PLL_PREDIVIDER, PLL_DIVIDES | 0u);
    chip_write(PLL0 + PLL_POSTDIV, PLL_DIVIDES | 0u);
    done = chip_waited(PLL0 + PLL_STATUS, 1u, 0u);
    chip_write(PLL0 + PLL_DIVIDER1, PLL_DIVIDES | 0u);
    chip_write(PLL0 + PLL_DIVIDER2, PLL_DIVIDES | 1u);
    chip_write(PLL0 + PLL_DIVIDER3, PLL_DIVIDES | 3u);
    chip_write(PLL0 + PLL_DIVIDER4, PLL_DIVIDES | 3u);
    chip_write(PLL0 + PLL_DIVIDER6, PLL_DIVIDES | 0u);
    chip_change(PLL0 + PLL_COMMAND, 0u, 1u);
    done &= chip_waited(PLL0 + PLL_STATUS, 1u, 0u);
    chip_rest(256u);
    chip_change(PLL0 + PLL_CTL, 0u, PLL_RESET);
    chip_rest(4096u);                                         /* lock: 2000 / sqrt(multiplier) ticks of the crystal */
    chip_change(PLL0 + PLL_CTL, 0u, PLL_ENABLE);
    return done;
}

static uint32_t chip_power(uint32_t psc, uint32_t module)
{
    uint32_t done;

    chip_change(psc + PSC_CONTROL + 4u * module, 0x1Fu, PSC_ON);
    chip_write(psc + PSC_COMMAND, 1u);
    done = chip_waited(psc + PSC_PENDING, 1u, 0u);
    return done & chip_waited(psc + PSC_STATE + 4u * module, 0x3Fu, PSC_ON);
}

/* UART2, [79] chapter 30: 8 data bits, no parity, one stop bit, FIFOs, no interrupt of its own: hysgen_board_line_serve runs in interrupt 4. */
static void chip_start_line(void)
{
    const uint32_t divisor = (CHIP_CORE_HZ / 2u + 8u * CHIP_LINE_HZ) / (16u * CHIP_LINE_HZ);

    chip_write(CHIP_UART2 + CHIP_UART_POWER, 0u);             /* reset of sender and receiver */
    chip_write(CHIP_UART2 + CHIP_UART_IER, 0u);
    chip_write(CHIP_UART2 + CHIP_UART_FCR, 0x07u);            /* FIFOs on, empty */
    chip_write(CHIP_UART2 + CHIP_UART_MDR, 0u);               /* 16 clocks a bit */
    chip_write(CHIP_UART2 + CHIP_UART_DLL, divisor & 0xFFu);
    chip_write(CHIP_UART2 + CHIP_UART_DLH, divisor >> 8);
    chip_write(CHIP_UART2 + CHIP_UART_LCR, 0x03u);            /* 8N1 */
    chip_write(CHIP_UART2 + CHIP_UART_MCR, 0u);
    chip_write(CHIP_UART2 + CHIP_UART_POWER, 0x6001u);        /* sender and receiver on; runs on while a debugger halts */
}

/* SPI1, [91] 27.3, as master, mode 0, 8 bits, the most significant first; chip select 0 is low from a byte with CHIP_SPI_HOLD to one without. */
static void chip_start_flash(void)
{
    const uint32_t prescale = (CHIP_CORE_HZ / 2u) / CHIP_FLASH_HZ;

    chip_write(CHIP_SPI1 + CHIP_SPI_GCR0, 0u);                /* reset */
    chip_write(CHIP_SPI1 + CHIP_SPI_GCR0, 1u);
    chip_write(CHIP_SPI1 + CHIP_SPI_GCR1, 0x00000003u);       /* master, clock of its own */
    chip_write(CHIP_SPI1 + CHIP_SPI_PC0, 0x00000E01u);        /* SIMO, SOMI, CLK, SCS[0] are SPI pins */
    chip_write(CHIP_SPI1 + CHIP_SPI_FMT0, 0x0A010008u | (prescale << 8)); /* chip select high between instructions: 64 ns */
    chip_write(CHIP_SPI1 + CHIP_SPI_DELAY, 0x0A0A0000u);      /* chip select to clock and back: 53 ns and more */
    chip_write(CHIP_SPI1 + CHIP_SPI_DEF, 0x00000001u);        /* SCS[0] high between transfers */
    chip_write(CHIP_SPI1 + CHIP_SPI_GCR1, 0x01000003u);       /* on */
}

/* Timer64P1 as a watchdog of 64 bits, [91] 28.1.6. Behind the second word nothing but hysgen_board_alive keeps the chip from a reset. */
static void chip_start_watchdog(void)
{
    chip_write(CHIP_TIMER1 + CHIP_TIMER_TCR, 0u);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_TGCR, 0u);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_TGCR, 0x0Bu);         /* watchdog mode, both halves out of reset */
    chip_write(CHIP_TIMER1 + CHIP_TIMER_TIM12, 0u);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_TIM34, 0u);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_PRD12, CHIP_WATCHDOG_TICKS);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_PRD34, 0u);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_TCR, 0x80u);          /* continuous */
    chip_write(CHIP_TIMER1 + CHIP_TIMER_WDTCR, CHIP_WATCHDOG_FIRST);
    chip_write(CHIP_TIMER1 + CHIP_TIMER_WDTCR, CHIP_WATCHDOG_SECOND);
}

uint32_t hysgen_chip_start(uint32_t outputs)
{
    uint32_t clock;
    uint32_t power;

    chip_write(SYSCFG0 + SYSCFG_KICK0, 0x83E70B13u);
    chip_write(SYSCFG0 + SYSCFG_KICK1, 0x95A4F1E0u);
    clock = chip_start_clock();
    power = chip_power(PSC1, PSC1_GPIO);
    /* The amplifier is off before its pin drives. */
    chip_write(CHIP_GPIO + CHIP_GPIO_CLEAR, outputs);
    chip_change(CHIP_GPIO + CHIP_GPIO_DIRECTION, outputs, 0u);
    for (uint32_t i = 0u; i < (uint32_t)(sizeof chip_pins / sizeof chip_pins[0]); ++i) {
        chip_change(SYSCFG0 + SYSCFG_PINMUX + 4u * chip_pins[i].pinmux, chip_pins[i].mask, chip_pins[i].function);
    }
    power &= chip_power(PSC0, PSC0_EMIFA) & chip_power(PSC1, PSC1_UART2) & chip_power(PSC1, PSC1_SPI1);
    chip_write(EMIFA + EMIFA_CE2CFG, EMIFA_BUS);
    chip_write(EMIFA + EMIFA_CE3CFG, EMIFA_BUS);
    chip_start_line();
    chip_start_flash();
    return (clock == 0u) ? 1u : ((power == 0u) ? 2u : 0u);
}

void hysgen_chip_pulse(uint32_t outputs)
{
    chip_write(CHIP_GPIO + CHIP_GPIO_SET, outputs);
    chip_rest(5u * (CHIP_CORE_HZ / 1000000u));
    chip_write(CHIP_GPIO + CHIP_GPIO_CLEAR, outputs);
    chip_rest(300u * (CHIP_CORE_HZ / 1000000u));
}

void hysgen_chip_start_sampling(uint32_t period)
{
    chip_write(CHIP_TIMER0 + CHIP_TIMER_TGCR, 0u);
    chip_write(CHIP_TIMER0 + CHIP_TIMER_TGCR, 0x05u);         /* unchained 32 bit, TIM12 out of reset */
    chip_write(CHIP_TIMER0 + CHIP_TIMER_TIM12, 0u);
    chip_write(CHIP_TIMER0 + CHIP_TIMER_PRD12, period - 1u);
    chip_write(CHIP_TIMER0 + CHIP_TIMER_INTCTL, 1u);          /* PRDINTEN12 */
    chip_change(INTC_INTMUX1, 0x7Fu, EVENT_TIMER0);
    chip_write(INTC_EXPMASK3, ~EVENT_FAULTS);                 /* [S13] */
    chip_start_watchdog();
    chip_write(CHIP_TIMER0 + CHIP_TIMER_TCR, 0xB0u);          /* continuous; the pin is high for 4 ticks */
}
