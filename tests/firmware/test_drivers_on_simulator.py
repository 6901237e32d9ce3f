"""Drivers of the C6748's board on the simulated C674x: start-up, converters, flash, line, watchdog, NMI.

They, `start.s` and a short main run from reset over a model of chip and parts. `complaints` compares what the parts
got with what they should get; every planted fault must raise one.
"""

import functools
import itertools
from pathlib import Path

import numpy as np
import pytest

from fixtures.board_model import SLOTS, BoardModel, library
from fixtures.c674x_compiler import need_compiler
from hysgen.firmware import CONTROLLER, TARGET_BOARD, read_sources
from hysgen_c674x import toolchain
from hysgen_c674x.processor import Devices
from hysgen_c674x.toolchain import Firmware

PERIOD = 7500
ECHOED = bytes(range(1, 60))
# What `drivers.c` writes over each other, at byte 200 of slot 1.
WRITTEN = np.array([(i * 7 + 3) & (i * 5 + 1) & 0xFF for i in range(300)], np.uint8)


# name: (file, what stands there, what is put there, complaint). PLANT is true in the run that has this fault.
PLANTED = {
    "multiplier": ("chip.c", "CHIP_MULTIPLIER - 1u", "CHIP_MULTIPLIER - (PLANT ? 2u : 1u)", "the core runs at 350 MHz"),
    "unlock": ("chip.c", "0x95A4F1E0u);", "PLANT ? 0u : 0x95A4F1E0u);", "SYSCFG written while locked"),
    "lock": ("chip.c", "chip_rest(4096u);", "chip_rest(PLANT ? 1u : 4096u);", "before it has locked"),
    "power": ("chip.c", "psc + PSC_COMMAND, 1u", "psc + (PLANT ? PSC_PENDING : PSC_COMMAND), 1u", "used without power"),
    "pins": ("chip.c", "chip_pins[i].function)", "PLANT ? 0u : chip_pins[i].function)", "does not convert"),
    "bus": ("chip.c", "0x00420319u ", "(PLANT ? 0x00420318u : 0x00420319u) ", "the bus is not 16 bits wide"),
    "strobe": (
        "chip.c",
        "EMIFA_CE2CFG, EMIFA_BUS",
        "EMIFA_CE2CFG, PLANT ? 1u : EMIFA_BUS",
        "a strobe of the bus is too short",
    ),
    "pulse": ("chip.c", "0xB0u);", "PLANT ? 0xB8u : 0xB0u);", "the A/D does not convert at every period"),
    "code": ("board.c", "(uint32_t)word ^ 0x8000u", "(uint32_t)word ^ (PLANT ? 0u : 0x8000u)", "not the last sample's"),
    "BUSY": ("board.c", "& BOARD_ADC_BUSY) != 0u", "& (PLANT ? 0u : BOARD_ADC_BUSY)) != 0u", "read while it converts"),
    "flash busy": (
        "flash.c",
        "        good = flash_ready();",
        "        good = PLANT ? 1u : flash_ready();",
        "while it is busy",
    ),
    "reset": (
        "board.c",
        "hysgen_chip_pulse(BOARD_ADC_RESET)",
        "hysgen_chip_pulse(PLANT ? 0u : BOARD_ADC_RESET)",
        "the A/D converts without a reset",
    ),
    "deselection": ("flash.c", "hold : CHIP_SPI_PAUSE", "hold : (PLANT ? 0u : CHIP_SPI_PAUSE)", "deselected for less"),
    "interrupt": ("chip.c", "CHIP_TIMER_INTCTL, 1u", "CHIP_TIMER_INTCTL, PLANT ? 0u : 1u", "reset by the watchdog"),
    "baud": ("chip.c", "(16u * CHIP_LINE_HZ)", "((PLANT ? 13u : 16u) * CHIP_LINE_HZ)", "text is unreadable"),
    "dog": (
        "board.c",
        "CHIP_WATCHDOG_SECOND);",
        "PLANT ? CHIP_WATCHDOG_FIRST : CHIP_WATCHDOG_SECOND);",
        "reset by the watchdog",
    ),
    "NMI": (
        "drivers.c",
        "hysgen_board_voltage(&board, 0.0f);",
        "hysgen_board_voltage(&board, PLANT ? 9.0f : 0.0f);",
        "NMI does not bring",
    ),
}


@functools.cache
def firmware() -> Firmware:
    """The drivers and drivers.c with all planted faults, of which the word `drivers_planted` selects one; 0: none."""
    need_compiler()
    board = dict(read_sources(TARGET_BOARD, "*.[chs]"))
    del board["main.c"]
    board["drivers.c"] = (Path(__file__).parent / "drivers" / "drivers.c").read_text(encoding="utf-8")
    for number, (file, old, new, _) in enumerate(PLANTED.values(), start=1):
        assert board[file].count(old) == 1, f"{file} does not hold: {old}"
        board[file] = board[file].replace(old, new.replace("PLANT", f"(drivers_planted == {number}u)"))
    for file in {file for file, *_ in PLANTED.values()}:
        board[file] = "#include <stdint.h>\nextern uint32_t drivers_planted;\n" + board[file]
    own = dict(read_sources(CONTROLLER, "board.h", "number.h", "linkage.h"))
    own["model.h"] = "#define MODEL_PERIOD_NS 20000u\n"
    script = dict(read_sources(TARGET_BOARD, "*.ld"))["c6748.ld"]
    return toolchain.compile([*board.items(), *own.items()], script=script)


def complaints(planted: int) -> list[str]:
    """Run the drivers from reset for some 40 ms with the planted fault of that number; what is not as it should be."""
    ramp = itertools.count()
    board = BoardModel(library(), lambda _: 1.0 + 0.01 * next(ramp))
    system = board.reset(firmware().image, firmware().packets)
    system.view("drivers_planted", 1, np.uint32)[0] = planted
    found: list[str] = []

    def check(right: bool, text: str) -> None:
        if not right:
            found.append(text)

    def word(name: str, dtype: type = np.uint32) -> float:
        return float(system.view(name, 1, dtype)[0])

    while board.state.interrupts == 0 and system.cycle < 12_000_000:
        check(system.run(PERIOD), "reset before the first interrupt")
    check(abs(board.core_Hz - 375e6) < 1.0, f"the core runs at {board.core_Hz / 1e6:g} MHz")
    check(board.sent() == b"drivers 1234567890 000009af\0", "text is unreadable")
    check(word("drivers_started") == 0, "start-up failed")
    check(word("drivers_flash_wrong") == 0, "the flash does not keep what was written")
    slot = board.flash[SLOTS + 4096 + 200 :][:300]
    check(bool((slot == WRITTEN).all()) and int((board.flash != 0xFF).sum()) == int((WRITTEN != 0xFF).sum()), "flash")
    board.send(ECHOED)
    began, conversions = system.cycle, board.state.conversions
    for _ in range(50):
        if not system.run(10 * PERIOD):
            check(False, "reset by the watchdog")
            break
        wanted = 1.0 + 0.01 * (board.state.conversions - 1)
        check(abs(word("drivers_reading_um", np.float32) - wanted) < 0.0002, "the reading is not the last sample's")
    periods = (system.cycle - began) / PERIOD
    check(abs(board.state.conversions - conversions - periods) <= 1, "the A/D does not convert at every period")
    check(abs(board.output_V - 40.0) < 0.002, "the D/A does not put out the voltage")
    check(board.enabled and board.voltages[-1:] > [39.9], "the amplifier is not switched on")
    check(board.sent() == ECHOED, "the line loses bytes")
    check(abs(board.state.dog_served - word("drivers_ticks")) <= 1, "the watchdog is not served at every interrupt")
    system.raise_nmi()
    check(system.run(5000), "reset before an NMI was served")
    check(abs(board.output_V) < 0.002 and not board.enabled, "NMI does not bring the output to rest")
    served, interrupts = board.state.dog_served, board.state.interrupts
    check(not system.run(500 * PERIOD), "the watchdog does not reset a chip that hangs")
    check(board.state.dog_served == served and board.state.interrupts > interrupts + 400, "behind an NMI code runs on")
    return sorted(set(found + board.violations))


def test_every_driver_does_on_the_simulated_chip_what_its_part_needs() -> None:
    assert complaints(0) == []


@pytest.mark.parametrize(("number", "name"), list(enumerate(PLANTED, start=1)))
def test_a_fault_of_a_driver_is_seen_on_the_simulated_chip(number: int, name: str) -> None:
    found = complaints(number)
    assert any(PLANTED[name][3] in each for each in found), found


def test_interpreter_and_engine_reach_the_devices_alike() -> None:
    """Start-up as a call: the same cycles, registers and time of the devices."""
    found = []
    for interpreted in (False, True):
        board, machine = BoardModel(library()), firmware().machine(interpreted)
        machine.processor.devices = Devices(library(), board.state)
        outcome = machine.call("hysgen_chip_start", 4)
        state = board.state
        found.append((outcome.bits, outcome.cycles, state.ticks, list(state.pinmux), state.uart_divisor, board.core_Hz))
        assert board.violations == []
    assert found[0] == found[1]
