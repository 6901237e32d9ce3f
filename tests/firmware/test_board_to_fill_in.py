"""The C6748's board layer, compiled on the host as for TI's compiler, over a model of the chip's registers.

The model keeps every access in order and answers reads as the chip would: a device's state follows its power command,
the line's data register takes and gives bytes, pins read what the test sets.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest

from fixtures.firmware_bench import WARNINGS
from hysgen.errors import BuildError
from hysgen.firmware.sources import CONTROLLER, TARGET_BOARD, read_sources
from hysgen.machine.native import Library, Toolchain, build, default_toolchain

C6X = """
extern unsigned int TSCL, ISTP, ICR, IER, CSR, IFR;
"""
REGISTERS = """
#include "board.h"
#include "chip.h"
#include "c6x.h"
unsigned int TSCL, ISTP, ICR, IER, CSR, IFR;
void vectors(void);
void vectors(void) {}

#define LOG 8192
#define PLACES 256
uint32_t log_address[LOG];
uint32_t log_before[LOG];
uint32_t log_count;
uint32_t place_address[PLACES];
volatile uint32_t place_value[PLACES];
uint32_t places;
uint32_t stuck;

/* The register, and a note that it was looked at; devices' states follow their commands. */
volatile uint32_t *chip_register(uint32_t address)
{
    uint32_t i = 0u;

    while (i < places && place_address[i] != address) {
        ++i;
    }
    if (i == places) {
        place_address[places] = address;
        place_value[places] = 0u;
        places += 1u;
    }
    if ((address & 0xFFFFFF00u) == 0x01C10800u || (address & 0xFFFFFF00u) == 0x01E27800u) {
        place_value[i] = (stuck != 0u) ? 0u : *chip_register(address + 0x200u) & 0x1Fu;
    }
    if (log_count < LOG) {
        log_address[log_count] = address;
        log_count += 1u;
    }
    return &place_value[i];
}
/* A word on the bus, and the number of words read or written. */
uint16_t bus_word;
uint32_t bus_address, bus_count;
volatile uint16_t *chip_bus(uint32_t address)
{
    bus_address = address;
    bus_count += 1u;
    return &bus_word;
}
uint32_t board_bytes(void);
uint32_t board_bytes(void) { return (uint32_t)sizeof(board_t); }
void board_clear(board_t *board);
void board_clear(board_t *board)
{
    board->next = 0u;
    board->received.in = 0u; board->received.out = 0u;
    board->sent.in = 0u; board->sent.out = 0u;
}
"""
DECLARED = """
typedef struct board board_t;
uint32_t chip_start(uint32_t);
void chip_start_sampling(uint32_t);
volatile uint32_t *chip_register(uint32_t);
extern uint32_t log_address[8192], log_count, places, stuck, bus_address, bus_count;
extern uint16_t bus_word;
float board_displacement_um(board_t *);
void board_voltage(board_t *, float);
void board_line_serve(board_t *);
uint32_t board_line_read(board_t *, uint8_t *, uint32_t);
uint32_t board_line_write(board_t *, const uint8_t *, uint32_t);
uint32_t board_amplifier(board_t *);
void board_amplifier_enable(board_t *, uint32_t);
void board_alive(board_t *);
uint32_t board_store_write(board_t *, uint32_t, uint32_t, const uint8_t *, uint32_t);
uint32_t board_bytes(void);
void board_clear(board_t *);
"""
PLL, PSC0, PSC1, SYSCFG, UART, GPIO = 0x01C11000, 0x01C10000, 0x01E27000, 0x01C14000, 0x01D0D000, 0x01E26000
TIMER0, TIMER1, SPI1 = 0x01C20000, 0x01C21000, 0x01F0E000


def compiled(period_ns: int = 20_000) -> Library:
    """The board's library for a model of this sampling period."""
    board = [(name, text) for name, text in read_sources(TARGET_BOARD) if name != "main.c"]
    headers = [(name, text) for name, text in read_sources(CONTROLLER) if name in ("board.h", "number.h")]
    own = [("c6x.h", C6X), ("registers.c", REGISTERS)]
    model = ("model.h", f"#define MODEL_PERIOD_NS {period_ns}u\n")
    flags = ("-D__TI_COMPILER_VERSION__=8003000", "-DCHIP_MODEL", "-I.", "-Wno-pointer-to-int-cast", "-Wno-conversion")
    toolchain = Toolchain(default_toolchain().command, (*WARNINGS, *flags, "-Werror"))
    return build([*board, *headers, *own, model], DECLARED, toolchain, ())


@functools.cache
def library() -> Library:
    return compiled()


class Chip:
    """The chip's registers and the board's state, as after power on."""

    def __init__(self) -> None:
        self.ffi, self.lib = library().ffi, library().lib
        self.lib.places, self.lib.log_count, self.lib.stuck = 0, 0, 0
        self._kept = self.ffi.new("uint8_t []", self.lib.board_bytes())
        self.board: Any = self.ffi.cast("board_t *", self._kept)
        self.lib.board_clear(self.board)

    def __getitem__(self, address: int) -> int:
        return int(self.lib.chip_register(address)[0])

    def __setitem__(self, address: int, value: int) -> None:
        self.lib.chip_register(address)[0] = value

    @property
    def touched(self) -> list[int]:
        """Addresses in the order of their use."""
        return list(self.lib.log_address[0 : self.lib.log_count])


def test_start_up_gives_375_MHz_power_pins_bus_and_line() -> None:
    chip = Chip()
    assert chip.lib.chip_start(4) == 0
    assert chip[SYSCFG + 0x38] == 0x83E70B13
    assert chip[SYSCFG + 0x3C] == 0x95A4F1E0
    assert 25_000_000 * (chip[PLL + 0x110] + 1) == 375_000_000
    # Out of reset, powered, not disabled, selected; the core undivided, UART2 at half, the bus at a quarter.
    assert chip[PLL + 0x100] & 0x13B == 0x009
    assert [chip[PLL + place] for place in (0x118, 0x11C, 0x120, 0x128)] == [0x8000, 0x8001, 0x8003, 0x8000]
    for psc, module in ((PSC0, 3), (PSC1, 3), (PSC1, 13), (PSC1, 10)):
        assert chip[psc + 0xA00 + 4 * module] & 0x1F == 3
    # UART2 and the timer's pin on PINMUX4, GP0[0] to GP0[3] on PINMUX1, SPI1 on 5, the bus on 5, 7, 8, 9.
    pins = {1: 0x88880000, 4: 0x00220002, 5: 0x11110110, 7: 0x00110011, 8: 0x11111111, 9: 0x11111111}
    assert {place: chip[SYSCFG + 0x120 + 4 * place] for place in pins} == pins
    divisor = chip[UART + 0x20] + 256 * chip[UART + 0x24]
    assert 187_500_000 / (16 * divisor) == pytest.approx(115_200, rel=0.01)
    assert (chip[UART + 0x0C], chip[UART + 0x30]) == (3, 0x6001)


def test_the_amplifiers_pin_is_low_before_it_drives() -> None:
    chip = Chip()
    chip[GPIO + 0x10] = 0xFFFFFFFF
    chip.lib.log_count = 0
    chip.lib.chip_start(4)
    order = chip.touched
    assert chip[GPIO + 0x1C] == 4
    assert chip[GPIO + 0x10] == 0xFFFFFFFB
    assert (
        order.index(SYSCFG + 0x38) < order.index(GPIO + 0x1C) < order.index(GPIO + 0x10) < order.index(SYSCFG + 0x124)
    )


def test_a_device_without_power_is_told_and_does_not_hang_the_start() -> None:
    chip = Chip()
    chip.lib.stuck = 1
    assert chip.lib.chip_start(4) == 2


def test_sampling_starts_behind_a_running_watchdog() -> None:
    chip = Chip()
    chip.lib.chip_start_sampling(500)
    assert (chip[TIMER0 + 0x18], chip[TIMER0 + 0x20]) == (499, 0xB0)
    assert chip[0x01800104] & 0x7F == 4
    # 64-bit watchdog mode, 10 ms of the crystal, armed by both words.
    assert (chip[TIMER1 + 0x24], chip[TIMER1 + 0x18], chip[TIMER1 + 0x28]) == (0x0B, 250_000, 0xDA7E4000)
    order = chip.touched
    last = len(order) - 1 - order[::-1].index(TIMER1 + 0x28)
    assert last < len(order)


def test_the_watchdog_gets_both_words_in_their_order() -> None:
    chip = Chip()
    chip.lib.board_alive(chip.board)
    assert chip.touched == [TIMER1 + 0x28] * 2
    assert chip[TIMER1 + 0x28] == 0xDA7E4000


@pytest.mark.parametrize(("pins", "told"), [(3, 0), (2, 1), (1, 2), (0, 3)])
def test_a_broken_wire_to_the_amplifier_reads_as_failure(pins: int, told: int) -> None:
    """The pins have pull-downs: limit 1 and failure 2 are told by a 0."""
    chip = Chip()
    chip[GPIO + 0x20] = pins
    assert chip.lib.board_amplifier(chip.board) == told


def test_the_amplifier_is_switched_by_set_and_clear() -> None:
    chip = Chip()
    chip.lib.board_amplifier_enable(chip.board, 1)
    chip.lib.board_amplifier_enable(chip.board, 0)
    assert chip.touched == [GPIO + 0x18, GPIO + 0x1C]
    assert chip[GPIO + 0x18] == chip[GPIO + 0x1C] == 4


def test_any_interleaving_of_interrupt_and_idle_loop_hands_every_byte_on_once() -> None:
    chip, rng = Chip(), np.random.default_rng(2)
    incoming, outgoing = rng.bytes(3000), rng.bytes(3000)
    received, sent, at, taken = b"", b"", 0, 0
    data = chip.ffi.new("uint8_t []", 64)
    while len(received) < len(incoming) or len(sent) < len(outgoing):
        for _ in range(int(rng.integers(0, 30))):
            arrives = at < len(incoming) and rng.random() < 0.5 and at - len(received) < 256
            free = rng.random() < 0.5
            chip[UART + 0x14] = int(arrives) | (0x20 if free else 0)
            chip[UART] = incoming[at] if arrives else 0x1FF
            chip.lib.board_line_serve(chip.board)
            at += arrives
            if free and taken > len(sent):
                sent += bytes([chip[UART] & 0xFF])
        count = chip.lib.board_line_read(chip.board, data, int(rng.integers(0, 64)))
        received += bytes(chip.ffi.buffer(data, count))
        piece = outgoing[taken : taken + int(rng.integers(0, 40))]
        taken += chip.lib.board_line_write(chip.board, piece, len(piece))
    assert received == incoming
    assert sent == outgoing


def test_a_byte_that_finds_the_buffer_full_is_lost_and_no_other() -> None:
    chip = Chip()
    chip[UART + 0x14] = 1
    for byte in range(300):
        chip[UART] = byte & 0xFF
        chip.lib.board_line_serve(chip.board)
    data = chip.ffi.new("uint8_t []", 400)
    assert chip.lib.board_line_read(chip.board, data, 400) == 256
    assert list(data[0:256]) == [byte & 0xFF for byte in range(256)]


def test_the_flash_gets_mode_0_of_8_bits_below_10_MHz() -> None:
    chip = Chip()
    assert chip.lib.chip_start(4) == 0
    format_0 = chip[SPI1 + 0x50]
    assert (format_0 & 0x1F, format_0 >> 16) == (8, 1)
    assert 187_500_000 / ((format_0 >> 8 & 0xFF) + 1) == pytest.approx(10_000_000, rel=0.02)
    # Out of reset, master, on; SIMO, SOMI, CLK and SCS[0] are pins of SPI1, the last one high at rest.
    assert (chip[SPI1], chip[SPI1 + 4], chip[SPI1 + 0x14], chip[SPI1 + 0x4C]) == (1, 0x01000003, 0xE01, 1)


def test_with_spi_that_does_not_answer_nothing_claims_to_be_stored() -> None:
    chip = Chip()
    chip[SPI1 + 0x40] = 0x8000_0000
    assert chip.lib.board_store_write(chip.board, 0, 0, b"\0\0\0\0", 4) == 0


@pytest.mark.parametrize(("word", "reading_um"), [(0, 4.916), (0x7FFF, 13.10775), (0x8000, -3.276), (0xFFFF, 4.91575)])
def test_a_word_of_the_converter_is_twos_complement(word: int, reading_um: float) -> None:
    chip = Chip()
    chip.lib.bus_word = word
    assert chip.lib.board_displacement_um(chip.board) == pytest.approx(reading_um, abs=1e-6)
    assert chip.lib.bus_address == 0x6000_0000


def test_a_converter_that_stays_busy_gives_no_number_and_is_not_read() -> None:
    chip = Chip()
    chip[GPIO + 0x20] = 8
    chip.lib.bus_count, chip.lib.log_count = 0, 0
    assert np.isnan(chip.lib.board_displacement_um(chip.board))
    assert chip.lib.bus_count == 0
    assert 50 < len(chip.touched) < 400


@pytest.mark.parametrize(("u_V", "code"), [(-20.0, 0), (120.0, 65535), (50.0, 32768), (-1e9, 0), (1e9, 65535)])
def test_a_voltage_becomes_the_code_of_the_converter(u_V: float, code: int) -> None:
    chip = Chip()
    chip.lib.board_voltage(chip.board, u_V)
    assert (chip.lib.bus_word, chip.lib.bus_address) == (code, 0x6200_0000)


def test_a_model_of_another_sampling_period_does_not_compile_into_the_image() -> None:
    with pytest.raises(BuildError, match="sampling period"):
        compiled(100_000)
