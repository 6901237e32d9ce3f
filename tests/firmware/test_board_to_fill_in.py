"""The C6748's board layer on the host, over the model of chip and parts: every register against TI's manual.

The simulated C674x runs the same drivers over the same model (test_drivers_on_simulator.py).
"""

# Safety case: [S13]

import numpy as np
import pytest

from fixtures.board_drivers import Chip, drivers
from hysgen.errors import BuildError

PLL, PSC0, PSC1, SYSCFG, UART, GPIO = 0x01C11000, 0x01C10000, 0x01E27000, 0x01C14000, 0x01D0D000, 0x01E26000
TIMER0, TIMER1 = 0x01C20000, 0x01C21000
PERIOD = 7500


def test_start_up_gives_375_MHz_power_pins_bus_and_line() -> None:
    chip = Chip()
    load = chip.load
    assert load(SYSCFG + 0x38) == 0x83E70B13
    assert load(SYSCFG + 0x3C) == 0x95A4F1E0
    assert chip.core_Hz == pytest.approx(375e6)
    # Out of reset, powered, not disabled, selected; the core undivided, UART2 at half, the bus at a quarter.
    assert load(PLL + 0x100) & 0x13B == 0x009
    assert [load(PLL + place) for place in (0x114, 0x118, 0x11C, 0x120, 0x128)] == [
        0x8000,
        0x8000,
        0x8001,
        0x8003,
        0x8000,
    ]
    for psc, module in ((PSC0, 3), (PSC1, 3), (PSC1, 13), (PSC1, 10)):
        assert load(psc + 0x800 + 4 * module) & 0x1F == 3
    # UART2 and the timer's pin on PINMUX4, GP0[0] to GP0[4] on PINMUX1, SPI1 on 5, the bus on 5, 7, 8, 9.
    pins = {1: 0x88888000, 4: 0x00220002, 5: 0x11110110, 7: 0x00110011, 8: 0x11111111, 9: 0x11111111}
    assert {place: load(SYSCFG + 0x120 + 4 * place) for place in pins} == pins
    divisor = load(UART + 0x20) + 256 * load(UART + 0x24)
    assert 187_500_000 / (16 * divisor) == pytest.approx(115_200, rel=0.01)
    assert (load(UART + 0x0C), load(UART + 0x30)) == (3, 0x6001)
    assert chip.violations == []


def test_the_amplifiers_pin_is_low_before_it_drives() -> None:
    chip = Chip(started=False)
    chip.state.gpio_output = 0xFFFFFFFF
    chip.lib.hysgen_chip_start(4)
    order = chip.touched
    assert chip.load(GPIO + 0x14) & 4 == 0
    assert chip.load(GPIO + 0x10) == 0xFFFFFFFB
    assert (
        order.index(SYSCFG + 0x38) < order.index(GPIO + 0x1C) < order.index(GPIO + 0x10) < order.index(SYSCFG + 0x124)
    )


@pytest.mark.parametrize(("part", "answer"), [("pll_fails", 1), ("power_fails", 2)])
def test_a_clock_or_a_device_that_does_not_start_is_told_and_does_not_hang_the_start(part: str, answer: int) -> None:
    chip = Chip(started=False)
    setattr(chip.state, part, 1)
    assert chip.lib.hysgen_chip_start(4) == answer


def test_sampling_starts_behind_a_running_watchdog() -> None:
    chip = Chip()
    chip.lib.hysgen_chip_start_sampling(500)
    assert (chip.load(TIMER0 + 0x18), chip.load(TIMER0 + 0x20), chip.state.timer_intctl) == (499, 0xB0, 1)
    assert chip.load(0x01800104) & 0x7F == 4
    # Of events 96 to 127 those of memory faults and bus errors are exceptions.
    assert [96 + bit for bit in range(32) if not chip.state.expmask3 >> bit & 1] == [119, 120, 122, 124, 126, 127]
    # 64-bit watchdog mode, 10 ms of the crystal, armed by both words.
    assert (chip.load(TIMER1 + 0x24), chip.load(TIMER1 + 0x18), chip.state.dog) == (0x0B, 250_000, 2)
    assert chip.touched[-1] == TIMER0 + 0x20
    assert chip.violations == []


def test_with_tis_compiler_interrupt_4_NMI_and_exceptions_are_enabled() -> None:
    chip = Chip()
    chip.lib.TSR = chip.lib.IER = chip.lib.CSR = 0
    chip.lib.hysgen_board_start(chip.board)
    assert (chip.lib.TSR, chip.lib.IER, chip.lib.CSR) == (12, 0x12, 1)


def test_the_watchdog_gets_both_words_in_their_order() -> None:
    chip = Chip()
    chip.lib.hysgen_chip_start_sampling(500)
    chip.lib.log_count = 0
    chip.lib.hysgen_board_alive(chip.board)
    assert chip.touched == [TIMER1 + 0x28] * 2
    assert chip.state.dog_served == 1
    assert not chip.state.dog_bitten


def test_the_reset_of_the_converter_is_one_pulse_of_3_us_and_ends_low() -> None:
    chip = Chip(started=False)
    chip.lib.hysgen_chip_start(0x14)
    chip.lib.hysgen_chip_pulse(0x10)
    assert (chip.state.adc_ready, chip.state.adc_resets, chip.load(GPIO + 0x14) & 0x14) == (1, 0, 0)
    assert chip.load(GPIO + 0x10) == 0xFFFFFFEB


@pytest.mark.parametrize(("pins", "told"), [(3, 0), (2, 1), (1, 2), (0, 3)])
def test_a_broken_wire_to_the_amplifier_reads_as_failure(pins: int, told: int) -> None:
    """The pins have pull-downs: limit 1 and failure 2 are told by a 0."""
    chip = Chip()
    chip.state.input_pins = pins
    assert chip.lib.hysgen_board_amplifier(chip.board) == told


def test_the_amplifier_is_switched_by_set_and_clear() -> None:
    chip = Chip()
    assert not chip.enabled
    chip.lib.hysgen_board_amplifier_enable(chip.board, 1)
    assert chip.enabled
    chip.lib.hysgen_board_amplifier_enable(chip.board, 0)
    assert not chip.enabled
    assert chip.touched == [GPIO + 0x18, GPIO + 0x1C]


def test_any_interleaving_of_interrupt_and_idle_loop_hands_every_byte_on_once() -> None:
    chip, rng = Chip(), np.random.default_rng(2)
    incoming, outgoing = rng.bytes(1000), rng.bytes(1000)
    chip.send(incoming)
    received, sent, taken = b"", b"", 0
    data = chip.ffi.new("uint8_t []", 64)
    for _ in range(20_000):
        for _ in range(int(rng.integers(0, 30))):
            chip.wait(PERIOD)
            chip.lib.hysgen_board_line_serve(chip.board)
        sent += chip.sent()
        count = chip.lib.hysgen_board_line_read(chip.board, data, int(rng.integers(0, 64)))
        received += bytes(chip.ffi.buffer(data, count))
        piece = outgoing[taken : taken + int(rng.integers(0, 40))]
        taken += chip.lib.hysgen_board_line_write(chip.board, piece, len(piece))
        if len(received) == len(incoming) and len(sent) == len(outgoing):
            break
    assert received == incoming
    assert sent == outgoing
    assert chip.violations == []


def test_a_byte_that_finds_the_buffer_full_is_lost_and_no_other() -> None:
    chip = Chip()
    chip.send(bytes(byte & 0xFF for byte in range(300)))
    for _ in range(300 * 5):
        chip.wait(PERIOD)
        chip.lib.hysgen_board_line_serve(chip.board)
    data = chip.ffi.new("uint8_t []", 400)
    assert chip.lib.hysgen_board_line_read(chip.board, data, 400) == 256
    assert list(data[0:256]) == [byte & 0xFF for byte in range(256)]


def test_with_spi_that_does_not_answer_nothing_claims_to_be_stored() -> None:
    chip = Chip(started=False)
    assert chip.lib.hysgen_board_store_write(chip.board, 0, 0, b"\0\0\0\0", 4) == 0


@pytest.mark.parametrize(("word", "reading_um"), [(0, 4.916), (0x7FFE, 13.1075), (-0x7FFF, -3.27575), (-1, 4.91575)])
def test_a_word_of_the_converter_is_twos_complement(word: int, reading_um: float) -> None:
    chip = Chip()
    chip.state.adc_code[1] = word
    assert chip.lib.hysgen_board_displacement_um(chip.board) == pytest.approx(reading_um, abs=1e-6)
    assert chip.touched[-1] == 0x6000_0000
    assert chip.violations == []


@pytest.mark.parametrize("rail", [0x7FFF, -0x8000])
def test_a_reading_at_a_rail_is_none_whatever_the_calibration_makes_of_it(rail: int) -> None:
    """A broken wire: with another gain it lay inside the range."""
    chip = Chip()
    chip.lib.hysgen_board_calibrate(chip.board, 0.0, 0.95, 0.0, 1.0)
    chip.state.adc_code[1] = rail
    assert np.isnan(chip.lib.hysgen_board_displacement_um(chip.board))


def test_a_converter_that_stays_busy_gives_no_number_and_is_not_read() -> None:
    chip = Chip()
    chip.state.adc_done_at = 1e300
    assert np.isnan(chip.lib.hysgen_board_displacement_um(chip.board))
    assert chip.state.adc_reads == 0
    assert 50 < len(chip.touched) < 400


def test_a_model_of_another_sampling_period_does_not_compile_into_the_image() -> None:
    with pytest.raises(BuildError, match="sampling period"):
        drivers(period_ns=100_000)


@pytest.mark.parametrize(
    ("code", "told"), [(1000, 0), (1000 + 655, 0), (1000 - 655, 0), (1000 + 656, 2), (1000 - 656, 2)]
)
def test_a_converter_that_does_not_put_out_what_it_was_given_is_a_failure_where_it_is_read_back(
    code: int, told: int
) -> None:
    chip = Chip(drivers("board_type.h", "BOARD_READS_BACK       0 ", "BOARD_READS_BACK       1 "))
    low_V, per_V = -20.0, 65535 / 140
    chip.lib.hysgen_board_voltage(chip.board, low_V + 1000 / per_V)
    assert chip.state.dac_code == 1000
    chip.state.adc_back = code - 32768
    assert chip.lib.hysgen_board_displacement_um(chip.board) == pytest.approx(4.916)
    assert chip.lib.hysgen_board_amplifier(chip.board) == told
    assert chip.lib.hysgen_board_read_back_V(chip.board) == pytest.approx(low_V + code / per_V, abs=1e-5)
    bare = Chip()
    assert np.isnan(bare.lib.hysgen_board_read_back_V(bare.board)), "not wired"


def test_readings_and_voltages_are_as_calibrated() -> None:
    chip = Chip()
    chip.lib.hysgen_board_calibrate(chip.board, -0.25, 1.0625, 0.5, 0.96875)
    chip.state.adc_code[1] = 4000
    assert chip.lib.hysgen_board_displacement_um(chip.board) == pytest.approx(-0.25 + 1.0625 * (4.916 + 1.0), abs=1e-5)
    chip.lib.hysgen_board_voltage(chip.board, 40.0)
    assert chip.output_V == pytest.approx(0.5 + 0.96875 * 40.0, abs=0.002)
