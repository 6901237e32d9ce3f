"""The boards compiled by the host's compiler: what the C6748's main says and is set to, start-up after a boot loader
that has used every device, and headers in C++."""

import functools
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest

from fixtures.board_drivers import Chip
from fixtures.firmware_bench import model
from fixtures.tools import need
from hysgen.codegen.manifest import write
from hysgen.errors import BuildError
from hysgen.firmware import (
    CONTROLLER,
    EMPTY_STORE,
    HOST_BOARD,
    SIMULATOR_BOARD,
    TARGET_BOARD,
    build_id,
    firmware_model,
    read_sources,
)
from hysgen.machine.native import Library, Toolchain, build, default_toolchain

PLL, UART, SPI1, TIMER0, TIMER1 = 0x01C11000, 0x01D0D000, 0x01F0E000, 0x01C20000, 0x01C21000
PLL_STATUS = PLL + 0x13C
SETTINGS = re.search(r"typedef struct \{.*?\} settings_t;", dict(read_sources(CONTROLLER))["settings.h"], re.DOTALL)
assert SETTINGS is not None

# Everything around main.c and console.c: the line takes a byte at a time, and is busy for `busy` looks behind each.
AROUND_MAIN = """
#include <setjmp.h>
#include "bytes.h"
#include "chip.h"
#include "firmware.h"
#include "flash.h"
static jmp_buf out;
uint32_t start_answer, flash_answer, outputs, busy, waiting, idle, samples, panics, started;
uint8_t line[2048];
uint32_t line_count;
firmware_t found;
const settings_t *settings;
const image_owner_t *owner;
int board_main(void);
void hysgen_main_tick(void);
void hysgen_main_panic(void);
void stopped(void);
int until_it_stops(uint32_t panic);

void stopped(void) { longjmp(out, 1); }
int until_it_stops(uint32_t panic)
{
    if (setjmp(out) == 0) {
        if (panic != 0u) { hysgen_main_panic(); } else { (void)board_main(); }
    }
    return 0;
}
uint32_t hysgen_chip_start(uint32_t pins) { outputs = pins; return start_answer; }
uint32_t hysgen_flash_present(void) { return flash_answer; }
void hysgen_board_start(board_t *board) { (void)board; started = line_count; }
void hysgen_firmware_boot(firmware_t *self, board_t *board, const settings_t *given, const image_owner_t *own)
{
    (void)board;
    *self = found;
    settings = given;
    owner = own;
}
void hysgen_firmware_idle(firmware_t *self, board_t *board)
{
    (void)self; (void)board;
    idle += 1u;
    if (idle == 5u) { stopped(); }
}
void hysgen_firmware_interrupt(firmware_t *self, board_t *board) { (void)board; samples += self->selftest; }
void hysgen_firmware_panic(const firmware_t *self, board_t *board) { (void)self; (void)board; panics += 1u; }
uint32_t chip_read(uint32_t address)
{
    const uint32_t free = (uint32_t)(waiting == 0u);
    waiting -= 1u - free;
    return (address == 0x01D0D014u) ? 0x40u | (free << 5) : 0u;
}
void chip_write(uint32_t address, uint32_t value)
{
    if (address == 0x01D0D000u && waiting == 0u) {
        line[line_count] = (uint8_t)value;
        line_count += 1u;
        waiting = busy;
    }
}
void set_found(uint32_t selftest, const char *wrong, uint32_t counter, uint32_t status);
void set_found(uint32_t selftest, const char *wrong, uint32_t counter, uint32_t status)
{
    found.selftest = selftest; found.settings_wrong = wrong; found.image_status = status;
    found.store.slot = (counter != 0u) ? 1u : STORE_NONE;
    bytes_put(&found.store.bytes[4u * IMAGE_COUNTER], counter);
    found.store.counter = counter + 7u;  /* of an image for another build */
}
"""
DECLARED = """
extern uint32_t start_answer, flash_answer, outputs, busy, waiting, idle, samples, panics, started;
extern uint8_t line[2048];
extern uint32_t line_count;
typedef struct { uint32_t key[4], device[2]; } image_owner_t;
extern const settings_t *settings;
extern const image_owner_t *owner;
int until_it_stops(uint32_t);
void hysgen_main_tick(void);
void set_found(uint32_t, const char *, uint32_t, uint32_t);
"""
ENDLESS = ("/* Without clock or power of the devices", "/* Until the watchdog acts.")


@functools.cache
def generated() -> dict[str, str]:
    return firmware_model(model())


@functools.cache
def main_alone(filled: str = "MAIN_FILLED_IN") -> Library:
    """main.c and console.c; loops without end, which a host cannot leave, call `stopped`."""
    texts = {name: text for name, text in read_sources(TARGET_BOARD) if name.endswith(".h") or name == "console.c"}
    text = dict(read_sources(TARGET_BOARD))["main.c"]
    for comment in ENDLESS:
        assert text.count(comment) == 1
        text = text.replace(comment, f"stopped(); {comment}")
    headers = {name: text for name, text in [*read_sources(CONTROLLER), *generated().items()] if name.endswith(".h")}
    macros = ("__TI_COMPILER_VERSION__=8003000", "CHIP_MODEL", filled, "interrupt=", "main=board_main")
    flags = tuple(f"-D{macro}" for macro in macros)
    around = ("around.c", f"int board_main(void);void stopped(void);\n{AROUND_MAIN}")
    sources = [*texts.items(), ("main.c", f"void stopped(void);\n{text}"), *headers.items(), around]
    return build(sources, SETTINGS[0] + DECLARED, Toolchain(default_toolchain().command, flags))  # type: ignore[index]


def said(library: Library, *found: Any, panic: int = 0) -> str:
    """What main puts on the line until it waits or has run the idle loop five times."""
    lib = library.lib
    lib.line_count = lib.waiting = lib.idle = lib.panics = lib.started = 0
    lib.set_found(*(found or (0, library.ffi.NULL, 0, 0)))
    lib.until_it_stops(panic)
    return bytes(library.ffi.buffer(lib.line, lib.line_count)).decode()


def test_the_text_of_a_good_start_names_the_build_and_ends_before_sampling() -> None:
    library = main_alone()
    library.lib.start_answer, library.lib.flash_answer, library.lib.busy = 0, 1, 99_999
    assert said(library) == (
        f"\r\nhysgen firmware: model {model().name}, build {build_id(model()):08x}\r\ncore 375 MHz, period 20000 ns\r\n"
        "flash W25Q64JV: found\r\nself-test: 0 words differ\r\nsettings: good\r\nparameters: built in\r\n"
        "frames from here on\r\n\0"
    )
    assert (library.lib.idle, library.lib.started) == (5, library.lib.line_count)
    # Amplifier and the converter's reset, which drive; no secret unless filled in.
    assert library.lib.outputs == 0x14
    assert [*library.lib.owner.key, *library.lib.owner.device] == [0] * 6


def test_the_example_does_not_compile_until_it_is_filled_in() -> None:
    with pytest.raises(BuildError, match="fill in main_settings and main_owner"):
        main_alone("NOTHING")


def test_the_text_of_a_start_says_every_fault() -> None:
    library = main_alone()
    library.lib.start_answer, library.lib.flash_answer, library.lib.busy = 0, 0, 0
    wrong = library.ffi.new("char []", b"ramp_V")
    text = said(library, 4_294_967_295, wrong, 1_020_304_050, 0x2000)
    assert re.findall(r": (.*)\r\n", text.partition("period")[2]) == [
        "NOT FOUND, no parameter image can be kept",
        "4294967295 WORDS DIFFER: do not start",
        "REFUSED: ramp_V",
        "image 1020304050",
        "THE NEWEST IMAGE IS DAMAGED, these are older",
    ]
    assert "DAMAGED" not in said(library, 9, wrong, 10, 0xDFFF), "the other bits say nothing of an image"
    library.lib.hysgen_main_tick()
    assert library.lib.samples == 9, "interrupt 4 runs the instance that was booted"


@pytest.mark.parametrize("folder", [HOST_BOARD, SIMULATOR_BOARD, TARGET_BOARD])
def test_cpp_takes_every_header_alone_and_twice_and_calls_every_function_by_its_name_in_c(
    folder: str, tmp_path: Path
) -> None:
    need("g++")
    sources = [*read_sources(CONTROLLER, "*.h"), *read_sources(folder, "*.h"), *generated().items()]
    headers = {name: text for name, text in sources if name.endswith(".h") and "selftest_data" not in name}
    write(headers, tmp_path)
    for name, text in headers.items():
        code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
        functions = set(re.findall(r"\b(\w+)\([^()]*\)(?:;|\n\{)", code))
        taken = "".join(f"reinterpret_cast<void *>(&{function}), " for function in functions)
        caller = f'#include "{name}"\n' * 2 + f"extern void *taken[];\nvoid *taken[] = {{ {taken}nullptr }};\n"
        (tmp_path / "caller.cpp").write_text(caller)
        flags = ("-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-c", "caller.cpp")
        made = subprocess.run(["g++", *flags], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert made.stderr == ""
        assert b"_Z" not in (tmp_path / "caller.o").read_bytes(), f"{name}: names of C++"


@pytest.mark.parametrize(("answer", "text"), [(1, "\r\nPLL0 DOES NOT START\r\n"), (2, "\r\nNO POWER FOR A DEVICE\r\n")])
def test_a_chip_that_does_not_start_is_said_and_nothing_runs(answer: int, text: str) -> None:
    library = main_alone()
    library.lib.start_answer, library.lib.busy = answer, 0
    assert said(library) == text
    assert (library.lib.idle, library.lib.started) == (0, 0)


def test_a_panic_is_handed_on_once_and_a_line_that_hangs_does_not_stop_the_start() -> None:
    library = main_alone()
    assert (said(library, panic=1), library.lib.panics) == ("", 1)
    library.lib.start_answer, library.lib.busy = 0, 0xFFFFFFFF
    assert said(library) == "\r", "the first byte is sent, the others are lost"
    assert library.lib.idle == 5


def test_the_empty_store_reads_as_erased_and_keeps_nothing() -> None:
    headers = [*read_sources(CONTROLLER, "board.h", "linkage.h"), *read_sources(SIMULATOR_BOARD, "board_type.h")]
    declared = """
    void hysgen_board_store_read(void *, uint32_t, uint32_t, uint8_t *, uint32_t);
    uint32_t hysgen_board_store_write(void *, uint32_t, uint32_t, const uint8_t *, uint32_t);
    """
    library = build([*headers, *read_sources(*EMPTY_STORE)], declared)
    data = library.ffi.new("uint8_t []", b"\x01\x02\x03\x04\x05")
    assert library.lib.hysgen_board_store_write(library.ffi.NULL, 1, 0, data, 5) == 0
    library.lib.hysgen_board_store_read(library.ffi.NULL, 1, 0, data, 4)
    assert list(data[0:5]) == [0xFF] * 4 + [5]


def test_start_up_sets_every_register_whatever_a_boot_loader_has_left() -> None:
    chip = Chip(started=False)
    state = chip.state
    registers = "uart_ier uart_mcr uart_mdr uart_fcr spi_gcr0 spi_gcr1 spi_pc0 spi_delay spi_def"
    for name in registers.split():
        setattr(state, name, 0x5555_5555)
    state.pinmux, state.emifa_config = [0xFFFFFFFF] * 20, [0x3FFF_FFFF] * 2
    state.timer_period, state.timer_tcr = [[77, 77], [77, 77]], [0x80, 0x80]
    assert chip.lib.hysgen_chip_start(4) == 0
    chip.lib.hysgen_chip_start_sampling(500)
    assert (state.uart_ier, state.uart_mcr, state.uart_mdr, state.uart_fcr) == (0, 0, 0, 7)
    # On, master with a clock of its own; four pins; 53 ns around a byte; SCS[0] high between transfers.
    assert (state.spi_gcr0, state.spi_gcr1, state.spi_pc0) == (1, 0x01000003, 0xE01)
    assert (state.spi_fmt0 & 0x1F, state.spi_fmt0 >> 16 & 0xFF) == (8, 1), "mode 0 of 8 bits"
    assert (state.spi_delay, state.spi_def) == (0x0A0A0000, 1)
    prescale = state.spi_fmt0 >> 8 & 0xFF
    assert (187.5e6 / (prescale + 1) < 10e6 <= 187.5e6 / prescale, state.spi_fmt0 >> 24) == (True, 10)
    # Strobes of 5 + 1 and 7 + 1 clocks of 10.7 ns, 16 bits.
    places = ((26, 15), (20, 63), (17, 7), (13, 15), (7, 63), (4, 7), (2, 3), (0, 3))
    fields = [[config >> place & mask for place, mask in places] for config in state.emifa_config]
    assert fields == [[0, 4, 1, 0, 6, 1, 2, 1]] * 2
    assert [chip.load(PLL + place) for place in (0x160, 0x168)] == [0x8003, 0x8000]
    assert state.cfgchip0 & 0x10 == 0
    assert [list(each) for each in state.timer_period] == [[499, 77], [250_000, 0]]
    assert (list(state.timer_tcr), list(state.timer_tgcr)) == ([0xB0, 0x80], [5, 0x0B])
    own = {1: 0xFFFFF000, 4: 0x00FF000F, 5: 0xFFFF0FF0, 7: 0x00FF00FF, 8: 0xFFFFFFFF, 9: 0xFFFFFFFF}
    for place in range(20):
        assert state.pinmux[place] & ~own.get(place, 0) == 0xFFFFFFFF & ~own.get(place, 0), "pins of others"


def test_the_clocks_steps_have_the_manuals_order_and_waits() -> None:
    """Between its steps are at least as many looks at PLL0, of a cycle or more, as the sequence asks for cycles."""
    chip = Chip(started=False)
    chip.lib.log_count = 0
    chip.lib.hysgen_chip_start(4)
    looks, steps = 0, []
    for address in chip.touched:
        if address == PLL_STATUS:
            looks += 1
        elif address >> 12 == PLL >> 12:
            if looks > 20:
                steps.append((address & 0xFFF, looks))
            looks = 0
    assert [place for place, _ in steps] == [0x100] * 3
    for (_, waited), least in zip(steps, (32, 256, 4096), strict=True):
        assert least <= waited < 1.05 * least + 4


def test_the_reset_of_the_converter_lasts_5_us_and_conversion_waits_300_us() -> None:
    chip = Chip()
    chip.lib.log_count = 0
    chip.lib.hysgen_chip_pulse(0x10)
    looks = [place for place, address in enumerate(chip.touched) if address != PLL_STATUS]
    assert looks == [0, 1 + 5 * 375]
    assert len(chip.touched) == min(8192, 2 + 305 * 375)


def test_a_voltage_becomes_the_nearest_code_and_the_codes_end_at_the_amplifiers_range() -> None:
    chip = Chip()
    for u_V in (-1e9, -20.0, -19.9968, 0.0, 39.0, 119.9968, 120.0, 1e9, float("inf"), -float("inf")):
        chip.lib.hysgen_board_voltage(chip.board, u_V)
        exact = (min(max(u_V, -20.0), 120.0) + 20.0) * 65535 / 140
        assert abs(chip.state.dac_code - exact) <= 0.51
    assert chip.touched[-1] == 0x6200_0000
