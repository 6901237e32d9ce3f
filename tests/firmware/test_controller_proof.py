"""Frama-C Eva over the controller, with any settings and any readings, and MISRA over the hand-written firmware.

The generated model is replaced by functions that return any number; `hysgen prove` covers the real ones. Three more
analyses cover images and store, frames, and link with idle loop and interrupt, each with any bytes from outside and
with stubs of the others. An access that leaves an array but not its struct is no alarm of Eva's.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fixtures.eva_firmware import ANY_FLOAT, MODEL, eva_sources
from fixtures.tools import need
from hysgen.checking.proof.eva.frama import Verdict, analyse
from hysgen.checking.proof.static import misra
from hysgen.firmware import CONTROLLER, TARGET_BOARD, read_sources

ADVISORY = {
    "8.11": "extern arrays without a size: symbols of the linker",
    "11.4": "a number becomes a pointer: registers of the chip",
}
ENTRY = f"""
#include <stddef.h>
#include "model_stubs.c"
#include "board.h"
#include "bank.c"
#include "controller.c"
#include "play.c"
#include "settings.c"
#include "watchdog.c"

settings_t settings;
controller_t controller;
float output_V;
volatile uint16_t record[BOARD_RECORD];
static uint32_t any(void) {{ return Frama_C_unsigned_int_interval(0u, 0xFFFFFFFFu); }}

int main(void)
{{
    Frama_C_make_unknown((char *)&settings, sizeof settings);
    hysgen_controller_init(&controller, &settings, BOARD_SAFE_V);
    hysgen_play_init(&controller.play, record);
    if (hysgen_settings_check(&settings) != NULL) {{
        controller.status |= STATUS_FAULT_SETTINGS;
    }}
    while (Frama_C_interval(0, 1)) {{
        controller.request = any();
        controller.play.count = any();
        controller.committing = any();
        controller.installing = any();
        output_V = hysgen_controller_step(&controller, {ANY_FLOAT}, {ANY_FLOAT}, any());
        hysgen_controller_learn(&controller);
        hysgen_controller_time(&controller, any(), any(), any());
    }}
    return 0;
}}
"""
IMAGE_ENTRY = """#include <stddef.h>
#include "model_stubs.c"
#include "board_stubs.c"
#include "bank.c"
#include "image.c"
#include "settings.c"
#include "store.c"
#include "siphash.c"
#include "crc32.c"

image_owner_t owner;
image_bench_t bench;
bank_t bank;
store_t store;
board_t board;
uint32_t answer;

int main(void)
{
    Frama_C_make_unknown((char *)&owner, sizeof owner);
    any_bank(&bank);
    answer = hysgen_store_load(&store, &board, &owner, &bench, &bank);
    while (Frama_C_interval(0, 1)) {
        Frama_C_make_unknown((char *)store.bytes, sizeof store.bytes);
        answer = hysgen_store_keep(&store, &board, &bench, &bank, any_word());
    }
    return 0;
}
"""
LINE_ENTRY = """#include <stddef.h>
#include "model_stubs.c"
#include "board_stubs.c"
#include "controller_stubs.c"
#include "frame_stubs.c"
#include "firmware.c"
#include "integrity.c"
#include "link.c"

settings_t settings;
image_owner_t owner;
firmware_t firmware;
board_t board;

int main(void)
{
    Frama_C_make_unknown((char *)&settings, sizeof settings);
    Frama_C_make_unknown((char *)&owner, sizeof owner);
    hysgen_firmware_boot(&firmware, &board, &settings, &owner);
    while (Frama_C_interval(0, 1)) {
        any_controller(&firmware.controller);
        if (Frama_C_interval(0, 1)) {
            hysgen_firmware_interrupt(&firmware, &board);
        } else {
            hysgen_firmware_idle(&firmware, &board);
        }
    }
    hysgen_firmware_panic(&firmware, &board);
    return 0;
}
"""
FRAME_ENTRY = """
#include "__fc_builtin.h"
#include "frame.c"
#include "crc32.c"
frame_t frame;
uint8_t payload[FRAME_PAYLOAD];
uint8_t wire[FRAME_WIRE];
uint32_t count;
int main(void)
{
    hysgen_frame_init(&frame);
    /*@ loop widen_hints "all", 132, 255; */
    while (Frama_C_interval(0, 1)) {
        count = hysgen_frame_take(&frame, (uint8_t)Frama_C_unsigned_int_interval(0u, 255u));
        //@ assert count <= FRAME_PAYLOAD;
        Frama_C_make_unknown((char *)payload, sizeof payload);
        count = hysgen_frame_make(payload, Frama_C_unsigned_int_interval(0u, 0xFFFFFFFFu), wire);
        //@ assert 1 <= count <= FRAME_WIRE;
    }
    return 0;
}
"""
OPTIONS = ("-eva-precision", "0", "-eva-slevel", "20")
PAGE = Path(__file__).resolve().parents[2] / "docs" / "firmware.md"


@pytest.fixture
def verdict(once_per_run: Callable[[str, Callable[[], Any]], Any]) -> Callable[[str], Verdict]:
    """`verdict(name)`: that of one of PROVED."""
    need("frama-c")

    def analysed(name: str) -> Verdict:
        entry, options = PROVED[name]
        found: Verdict = once_per_run(
            f"eva-{name}", lambda: analyse(eva_sources(entry), "entry.c", "any", options=options)
        )
        return found

    return analysed


@pytest.mark.slow
def test_no_settings_and_no_readings_make_the_controller_fail(verdict: Callable[[str], Verdict]) -> None:
    """Any bits as settings, readings, references, requests: no index out of bounds, nothing uninitialised."""
    assert not verdict("controller").alarms


@pytest.mark.slow
@pytest.mark.proof
def test_an_index_that_goes_too_far_is_an_alarm() -> None:
    need("frama-c")
    planted = eva_sources(ENTRY, "controller.c", "(now + 1u < CONTROLLER_LINE)", "(now < CONTROLLER_LINE)")
    assert analyse(planted, "entry.c", "any", options=OPTIONS).alarms


UNROLLED = ("-eva-precision", "0", "-eva-slevel", "0", "-eva-auto-loop-unroll", "150")
"""hysgen_frame_make writes at places that grow by one in each turn of its loop of at most 132."""
PROVED = {
    "controller": (ENTRY, OPTIONS),
    "image": (IMAGE_ENTRY, OPTIONS),
    "frame": (FRAME_ENTRY, UNROLLED),
    "line": (LINE_ENTRY, OPTIONS),
}


@pytest.mark.slow
def test_no_image_and_no_content_of_the_store_make_the_image_code_fail(verdict: Callable[[str], Verdict]) -> None:
    assert not verdict("image").alarms


@pytest.mark.slow
def test_no_bytes_make_a_frame_leave_its_buffers(verdict: Callable[[str], Verdict]) -> None:
    found = verdict("frame")
    assert not found.alarms
    assert found.held == found.checks == 2


@pytest.mark.proof
def test_no_command_makes_link_idle_loop_and_interrupt_fail(verdict: Callable[[str], Verdict]) -> None:
    assert not verdict("line").alarms


@pytest.mark.golden
@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.proof] * (name == "line")) for name in PROVED])
def test_the_page_states_the_operations(name: str, verdict: Callable[[str], Verdict]) -> None:
    operations = verdict(name).operations
    assert f"| 0 alarms at {operations} operations" in PAGE.read_text(encoding="utf-8"), operations


@pytest.mark.slow
@pytest.mark.parametrize(
    ("entry", "options", "change"),
    [
        pytest.param(
            IMAGE_ENTRY, OPTIONS, ("store.c", "1u - first", "2u - first"), marks=pytest.mark.proof, id="image"
        ),
        pytest.param(
            FRAME_ENTRY, UNROLLED, ("frame.c", "self->count < FRAME_BYTES", "self->count <= FRAME_BYTES"), id="frame in"
        ),
        pytest.param(
            FRAME_ENTRY,
            UNROLLED,
            ("frame.c", "count < FRAME_PAYLOAD", "count < FRAME_WIRE"),
            marks=pytest.mark.proof,
            id="frame out",
        ),
    ],
)
def test_an_access_out_of_bounds_is_an_alarm(
    entry: str, options: tuple[str, ...], change: tuple[str, str, str]
) -> None:
    need("frama-c")
    assert analyse(eva_sources(entry, *change), "entry.c", "any", options=options).alarms


@pytest.mark.slow
def test_the_firmware_follows_every_required_rule_of_misra() -> None:
    need("cppcheck")
    generated = [(path.name, path.read_text(encoding="utf-8")) for path in MODEL.glob("*.h")]
    found = misra("firmware", dict([*read_sources(CONTROLLER), *read_sources(TARGET_BOARD), *generated]))
    assert found.required == 0, "\n".join(found.lines())
    assert {finding.rule for finding in found.findings} == set(ADVISORY)
