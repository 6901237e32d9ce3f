/* chip.h: the C6748's own devices, from reset to sampling, and the registers that board.c uses.
 *
 * The head of chip.c names document, section and page of each; limits of clocks are those of SPRS590 (data sheet). None
 * of it ran on silicon; tests/firmware/test_board_to_fill_in.py holds every write against a model of the registers. */

#ifndef CHIP_H
#define CHIP_H

#include <stdint.h>

#include "linkage.h"

LINKAGE_BEGIN

/* Fill in: the crystal. 375 MHz need 25 MHz; from the 24 MHz of TI's LCDK and EVM the PLL makes 360 MHz at most, 7200 cycles in 20 us. */
#define CHIP_OSCILLATOR_HZ   25000000u
#define CHIP_MULTIPLIER      15u          /* PLL0: 375 MHz, inside 300 .. 600 */
#define CHIP_CORE_HZ         (CHIP_OSCILLATOR_HZ * CHIP_MULTIPLIER)
#define CHIP_LINE_HZ         115200u
#define CHIP_FLASH_HZ        10000000u

#define CHIP_RESET_TYPE      0x01C110E4u  /* RSTYPE of PLL0 */
#define CHIP_RESET_POWER_ON  0x01u

#define CHIP_TIMER0          0x01C20000u  /* sampling */
#define CHIP_TIMER1          0x01C21000u  /* watchdog */
#define CHIP_TIMER_TIM12     0x10u
#define CHIP_TIMER_TIM34     0x14u
#define CHIP_TIMER_PRD12     0x18u
#define CHIP_TIMER_PRD34     0x1Cu
#define CHIP_TIMER_TCR       0x20u
#define CHIP_TIMER_TGCR      0x24u
#define CHIP_TIMER_WDTCR     0x28u
#define CHIP_TIMER_INTCTL    0x44u        /* INTCTLSTAT */
#define CHIP_WATCHDOG_FIRST  0xA5C64000u  /* the two words that restart the watchdog, WDEN set in both */
#define CHIP_WATCHDOG_SECOND 0xDA7E4000u
#define CHIP_WATCHDOG_TICKS  (CHIP_OSCILLATOR_HZ / 100u)  /* 10 ms: 500 interrupts that did not come */

#define CHIP_UART2           0x01D0D000u
#define CHIP_UART_DATA       0x00u        /* read: byte received, write: byte to send */
#define CHIP_UART_IER        0x04u
#define CHIP_UART_FCR        0x08u
#define CHIP_UART_LCR        0x0Cu
#define CHIP_UART_MCR        0x10u
#define CHIP_UART_LSR        0x14u
#define CHIP_UART_DLL        0x20u
#define CHIP_UART_DLH        0x24u
#define CHIP_UART_POWER      0x30u
#define CHIP_UART_MDR        0x34u
#define CHIP_UART_RECEIVED   0x01u
#define CHIP_UART_EMPTY      0x20u

#define CHIP_SPI1            0x01F0E000u  /* flash on chip select 0 */
#define CHIP_SPI_GCR0        0x00u
#define CHIP_SPI_GCR1        0x04u
#define CHIP_SPI_PC0         0x14u
#define CHIP_SPI_DAT1        0x3Cu
#define CHIP_SPI_BUF         0x40u
#define CHIP_SPI_DELAY       0x48u
#define CHIP_SPI_DEF         0x4Cu
#define CHIP_SPI_FMT0        0x50u
#define CHIP_SPI_HOLD        0x10000000u  /* DAT1: the chip select stays active behind this byte */
#define CHIP_SPI_PAUSE       0x04000000u  /* DAT1: WDEL, the chip select stays high for FMT0's delay behind this byte */
#define CHIP_SPI_FULL        0x20000000u  /* BUF: the byte before is not sent yet */
#define CHIP_SPI_EMPTY       0x80000000u  /* BUF: nothing received */

#define CHIP_GPIO            0x01E26000u
#define CHIP_GPIO_DIRECTION  0x10u        /* banks 0 and 1; 1: input */
#define CHIP_GPIO_SET        0x18u
#define CHIP_GPIO_CLEAR      0x1Cu
#define CHIP_GPIO_IN         0x20u

/* The only accesses of the drivers: registers of 32 bits, words on the 16-bit bus. */
#if defined(CHIP_MODEL)
/* A test's model of chip and parts in place of them. */
uint32_t chip_read(uint32_t address);
void chip_write(uint32_t address, uint32_t value);
uint16_t chip_bus_read(uint32_t address);
void chip_bus_write(uint32_t address, uint16_t value);
#else
static inline uint32_t chip_read(uint32_t address)
{
    return *(const volatile uint32_t *)(uintptr_t)address;
}

static inline void chip_write(uint32_t address, uint32_t value)
{
    *(volatile uint32_t *)(uintptr_t)address = value;
}

static inline uint16_t chip_bus_read(uint32_t address)
{
    return *(const volatile uint16_t *)(uintptr_t)address;
}

static inline void chip_bus_write(uint32_t address, uint16_t value)
{
    *(volatile uint16_t *)(uintptr_t)address = value;
}
#endif

/* Behind reset: clocks, pins, power of the devices, bus, line, flash, amplifier's pins, watchdog. outputs: pins of GPIO bank 0 that drive;
 * they are low. Returns 0, or the number of the step that did not finish: 1 PLL, 2 power of a device. */
uint32_t hysgen_chip_start(uint32_t outputs);

/* The output pins `outputs` of GPIO bank 0 high for 5 us, then 300 us low. */
void hysgen_chip_pulse(uint32_t outputs);

/* Timer64P0 as one 32-bit timer of `period` oscillator ticks, to interrupt 4 and, as a pulse of 4 ticks, to its pin. */
void hysgen_chip_start_sampling(uint32_t period);

LINKAGE_END

#endif
