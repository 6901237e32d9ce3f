"""Skips one execute packet of the firmware on the simulated C674x at a time, and counts what must not happen.

    python benchmarks/skipped_packets.py

Unsafe is: the amplifier is on and the D/A gets a voltage outside low_V .. high_V, in the interrupt with the skip or in
the next, with a reference beyond the range; or other numbers than the built-in ones drive the stage behind an image
without the right MAC, at the next START or at that of the next boot. A run that the simulator ends (a wild address, an
endless loop) is one that the panic or the watchdog ends with the amplifier off; what it has put out by then counts.
docs/firmware.md has the figures.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from hysgen.errors import TargetError
from hysgen.firmware import CONTROLLER, SIMULATOR_BOARD, Label, encode, firmware_model, read_sources
from hysgen.firmware.wire import State, image_frames
from hysgen_c674x.cycles import c_texts
from hysgen_c674x.firmware.target import compile_placed, virtual_stage
from hysgen_c674x.machine import Machine
from hysgen_c674x.processor import NEVER, AccessKind
from hysgen_lab.firmware.reference_models import firmware_models

LOW_V, HIGH_V = -1.0, 55.0
"""Limits inside those of the converters, and close to the voltages of the way: the loop's highest is 54 V."""
BEYOND_UM = np.float32(9.0)
SAMPLES = 2000
START = 47
"""Samples from START to the way back of LOOP: 16 of POWER, 13 of RISE, 16 on the way up, and two to spare."""
KEY = bytes([1, *bytes(15)])
"""Of the simulator's board."""
SPARSE = 41
"""Inside the link's frames, hashes and certificates every so many packets are skipped, a prime; elsewhere each."""
DENSE = ("hysgen_siphash", "hysgen_crc32", "hysgen_frame", "appendix_a")
BOARD = {
    "static firmware_t": "firmware_t",
    "static board_t": "board_t",
    '#include "board.h"': '#include "board.h"\nvoid judge(float u_V);',
    "ramp_V = 0.5f": "ramp_V = 2.0f",
    "output_V = u_V;": "output_V = u_V; judge(u_V);",
    "-20.0f,\n    .high_V = 120.0f": f"{LOW_V}f,\n    .high_V = {HIGH_V}f",
}
MEMORY = f"""
#include "bank.h"
#include "bytes.h"
#include "firmware.h"
extern firmware_t simulated;
extern board_t simulated_board;
static uint32_t slots[BOARD_SLOTS][BOARD_SLOT_BYTES / 4u];
static uint32_t beyond;
static uint32_t words_left = 0xFFFFFFFFu;
static uint32_t last_bits;
/* After so many words more the power fails; of the last one only these bits change. */
void cut(uint32_t words, uint32_t bits);
void cut(uint32_t words, uint32_t bits) {{ words_left = words; last_bits = bits; }}
static void change(uint32_t slot, uint32_t at, uint32_t word)
{{
    uint32_t *place = &slots[slot & 1u][at & 1023u];
    if (words_left != 0u) {{
        *place ^= (*place ^ word) & ((words_left == 1u) ? last_bits : 0xFFFFFFFFu);
        words_left -= 1u;
    }}
}}
void hysgen_board_store_read(board_t *board, uint32_t slot, uint32_t offset, uint8_t *bytes, uint32_t count)
{{
    (void)board;
    for (uint32_t i = 0u; i < count; i += 4u) {{ bytes_put(&bytes[i], slots[slot & 1u][((offset + i) >> 2) & 1023u]); }}
}}
void hysgen_board_store_erase(board_t *board, uint32_t slot)
{{
    (void)board;
    for (uint32_t i = 0u; i < 1024u; ++i) {{ change(slot, i, 0xFFFFFFFFu); }}
}}
uint32_t hysgen_board_store_write(board_t *board, uint32_t slot, uint32_t offset, const uint8_t *bytes, uint32_t count)
{{
    (void)board;
    for (uint32_t i = 0u; i < count; i += 4u) {{ change(slot, (offset + i) >> 2, bytes_word(&bytes[i])); }}
    return 1u;
}}
void judge(float u_V);
void judge(float u_V)
{{
    const uint32_t inside = (uint32_t)(u_V >= {LOW_V}f) & (uint32_t)(u_V <= {HIGH_V}f);
    beyond += simulated_board.enabled & (inside ^ 1u);
}}
uint32_t codes_beyond(void);
uint32_t codes_beyond(void) {{ return beyond; }}
uint32_t driven(void);
uint32_t driven(void)
{{
    bank_t taken;

    hysgen_bank_take(&taken, &simulated.controller.model);
    return (simulated.controller.state == CONTROLLER_LOOP) ? hysgen_bank_check(&taken) : 0u;
}}
uint32_t counter(void);
uint32_t counter(void) {{ return simulated.store.counter; }}
uint32_t words_changed(void);
uint32_t words_changed(void) {{ return 0xFFFFFFFFu - words_left; }}
void panic(void);
void panic(void) {{ hysgen_firmware_panic(&simulated, &simulated_board); }}
uint32_t first_fault(void);
uint32_t first_fault(void) {{ return simulated.controller.first; }}
void ask(void);
void ask(void) {{ simulated.controller.request = CONTROLLER_START; }}
"""

MODEL = firmware_models()[0]


def machine(further: Mapping[str, str] | None = None) -> Machine:
    """Controller, model, and the simulator's board with a store and with limits of its own.

    further: texts of the board to be replaced.
    """
    board = dict(read_sources(SIMULATOR_BOARD))
    for old, new in (BOARD | dict(further or {})).items():
        if board["board.c"].count(old) != 1:
            raise SystemExit(f"board.c: no longer has {old!r} once")
        board["board.c"] = board["board.c"].replace(old, new)
    sources = [*read_sources(CONTROLLER), *board.items(), ("memory.c", MEMORY), *c_texts(firmware_model(MODEL))]
    return compile_placed(sources).machine()


def with_a_skip(target: Machine, function: str, *arguments: np.float32) -> Iterator[tuple[str, bool]]:
    """Function and address of each packet that was skipped in a call, and whether the call came back."""
    symbols = sorted((symbol.address, symbol.name) for symbol in target.image.symbols.values() if symbol.function)
    starts = np.array([address for address, _ in symbols])
    before = bytes(target.processor.memory)
    outcome, trace = target.trace(function, *arguments, room=1 << 21)
    words = trace.words[: trace.count]
    fetched = words[(words >> np.uint64(32)) & np.uint64(3) == AccessKind.FETCH] & np.uint64(0xFFFFFFFF)
    for number, address in enumerate(fetched.tolist()):
        name = symbols[int(np.searchsorted(starts, address, "right")) - 1][1]
        if name == "judge" or (number % SPARSE and name.startswith(DENSE)):
            continue
        target.processor.memory[:] = before
        target.processor.skipped = number
        try:
            target.call(function, *arguments, cycle_limit=4 * outcome.cycles)
            back = True
        except TargetError:
            back = False
        target.processor.skipped = NEVER
        yield f"{name} {address:08x}", back
    target.processor.memory[:] = before


def report(place: str, target: Machine, unsafe: Callable[[bool], bool], function: str, *arguments: np.float32) -> None:
    """Print a place: skips, those that did not come back, and the unsafe ones by name."""
    ends, broken, tried = 0, list[str](), 0
    for name, back in with_a_skip(target, function, *arguments):
        tried, ends = tried + 1, ends + (not back)
        if unsafe(back):
            broken.append(name)
    print(f"{place}: {tried} skips, {ends} ended by a fault, {len(broken)} unsafe", *broken, sep="\n  ", flush=True)


def interrupts(target: Machine) -> None:
    """The second sample of every state on the way to TRACK, and the fortieth in it."""
    stage, state = virtual_stage(MODEL)
    y_um, seen = MODEL.grid.y_min_um, dict.fromkeys(State, 0)
    target.call("hysgen_simulated_boot")
    for _ in range(SAMPLES):
        reading = np.float32(y_um)

        def unsafe(back: bool, reading: np.float32 = reading) -> bool:
            if back:
                with contextlib.suppress(TargetError):  # a fault of the processor, as above
                    target.call("hysgen_simulated_interrupt", reading, BEYOND_UM)
            return target.call("codes_beyond").bits != 0

        now = State(target.call("hysgen_simulated_state").bits & 0xFF)
        seen[now] += 1
        if seen[now] in ((2, 40) if now is State.TRACK else (2,)):
            place = f"interrupt, sample {seen[now]} of {now.name}"
            report(place, target, unsafe, "hysgen_simulated_interrupt", reading, BEYOND_UM)
        u_V = target.call("hysgen_simulated_interrupt", reading, BEYOND_UM).float32
        target.call("hysgen_simulated_idle")
        y_um = stage.call("simulate", state, u_V)
        if seen[State.TRACK] > 40:
            break


def driven(target: Machine) -> int:
    """The check word of the parameters that drive behind a START, 0 if none do."""
    target.call("ask")
    for sample in range(START):
        reading = np.float32(MODEL.grid.y_min_um + 0.001 * (sample % 2))
        target.call("hysgen_simulated_interrupt", reading, BEYOND_UM)
    return target.call("driven").bits


def image(gain: float, counter: int) -> bytes:
    """A good image of the model with another gain."""
    return encode(replace(MODEL, consequents=MODEL.consequents * [1.0, gain, 1.0]), KEY, Label(counter=counter))


def send(target: Machine, data: bytes) -> None:
    """All bytes of an image to the line; the next pass of the idle loop gets the last one."""
    line = b"".join(image_frames(data))
    for byte in line[:-1]:
        target.call("hysgen_simulated_send", byte)
        target.call("hysgen_simulated_idle")
    target.call("hysgen_simulated_send", line[-1])


def images(target: Machine) -> None:
    """The pass of the idle loop that gets the last byte of a good image with one wrong bit in its MAC."""

    target.call("hysgen_simulated_boot")
    built_in = driven(target)
    assert built_in != 0
    target.call("hysgen_simulated_boot")
    good = image(1.01, 1)
    forged = good[:-1] + bytes([good[-1] ^ 1])
    before = bytes(target.processor.memory)
    send(target, good)
    target.call("hysgen_simulated_idle")
    assert driven(target) not in (built_in, 0), "with its right MAC it is taken"
    target.processor.memory[:] = before
    send(target, forged)

    def unsafe(back: bool) -> bool:
        at_once = driven(target) if back else 0
        target.call("hysgen_simulated_boot")
        return not {at_once, driven(target)} <= {built_in, 0}

    report("idle loop, an image with a wrong MAC", target, unsafe, "hysgen_simulated_idle")


if __name__ == "__main__":
    interrupts(machine())
    images(machine())
