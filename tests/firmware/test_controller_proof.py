"""Frama-C Eva and MISRA over the hand-written firmware: any settings that pass the validator, any readings, any bytes.

The generated model is replaced by functions that return any number that the real ones may return; `hysgen prove` covers
the real ones. The board returns anything.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fixtures.tools import need
from hysgen.checking.proof.eva.frama import analyse
from hysgen.checking.proof.misra import misra
from hysgen.firmware.sources import CONTROLLER, EMPTY_STORE, TARGET_BOARD, read_sources

MODEL = Path(__file__).resolve().parents[2] / "firmware" / "models" / "extended"
ADVISORY = {
    "8.11": "extern arrays without a size: symbols of the linker",
    "11.4": "a number becomes a pointer: registers of the chip",
}
BOARD_TYPE = "#ifndef BOARD_TYPE_H\n#define BOARD_TYPE_H\ntypedef struct { int any; } board_t;\n#endif\n"
ANY_FLOAT = "number_of(Frama_C_unsigned_int_interval(0u, 0xFFFFFFFFu))"
MODEL_STUBS = f"""
#include "__fc_builtin.h"
#include "model.h"
#include "number.h"

static float any_um(void) {{ return Frama_C_float_interval(-1.0e3f, 1.0e3f); }}
static void any_bank(model_bank_t *bank) {{ Frama_C_make_unknown((char *)bank, sizeof *bank); }}
static uint32_t any_word(void) {{ return Frama_C_unsigned_int_interval(0u, 0xFFFFFFFFu); }}

void extended_init(extended_t *self, float y_um, float u_V)
{{
    any_bank(&self->bank[0]);
    any_bank(&self->bank[1]);
    self->active = 0u;
    self->status = 0u;
    self->y_um = any_um();
}}
void extended_limits(extended_t *self, float low_V, float high_V, float step_V) {{ (void)self; }}
float extended_simulate(extended_t *self, float u_V) {{ self->y_um = any_um(); return self->y_um; }}
float extended_inverse(extended_t *self, float y_um, float y_next_um)
{{
    self->status = any_word();
    self->y_um = any_um();
    return {ANY_FLOAT};
}}
void extended_learn_init(extended_learner_t *self, const extended_t *model)
{{
    self->age = 0u;
    self->updates = 0u;
    self->rejected = 0u;
}}
void extended_learn(extended_learner_t *self, float y_um, float u_V) {{ self->updates = any_word(); }}
uint32_t extended_commit(extended_t *self, extended_learner_t *learner)
{{
    self->active = Frama_C_unsigned_int_interval(0u, 1u);
    return Frama_C_unsigned_int_interval(0u, 6u);
}}
uint32_t extended_selftest(void) {{ return Frama_C_unsigned_int_interval(0u, 9u); }}
"""
BOARD_STUBS = f"""
#include "__fc_builtin.h"
#include "board.h"
#include "number.h"

float output_V;
static uint32_t any(void) {{ return Frama_C_unsigned_int_interval(0u, 0xFFFFFFFFu); }}
float board_displacement_um(board_t *b) {{ return {ANY_FLOAT}; }}
float board_reference_um(board_t *b) {{ return {ANY_FLOAT}; }}
uint32_t board_amplifier(board_t *b) {{ return any(); }}
void board_voltage(board_t *b, float u_V) {{ output_V = u_V; }}
uint32_t board_cycles(board_t *b) {{ return any(); }}
uint32_t board_overrun(board_t *b) {{ return Frama_C_unsigned_int_interval(0u, 1u); }}
void board_line_serve(board_t *b) {{ }}
void board_amplifier_enable(board_t *b, uint32_t on) {{ }}
void board_alive(board_t *b) {{ }}
uint32_t board_line_read(board_t *b, uint8_t *bytes, uint32_t room)
{{
    Frama_C_make_unknown((char *)bytes, room);
    return Frama_C_unsigned_int_interval(0u, room);
}}
uint32_t board_line_write(board_t *b, const uint8_t *bytes, uint32_t count)
{{
    return Frama_C_unsigned_int_interval(0u, count);
}}
void board_store_read(board_t *b, uint32_t slot, uint32_t offset, uint8_t *bytes, uint32_t count)
{{
    //@ check slot: slot < BOARD_SLOTS;
    //@ check inside: offset + count <= BOARD_SLOT_BYTES;
    Frama_C_make_unknown((char *)bytes, count);
}}
void board_store_erase(board_t *b, uint32_t slot)
{{
    //@ check slot: slot < BOARD_SLOTS;
}}
uint32_t board_store_write(board_t *b, uint32_t slot, uint32_t offset, const uint8_t *bytes, uint32_t count)
{{
    //@ check slot: slot < BOARD_SLOTS;
    //@ check inside: offset + count <= BOARD_SLOT_BYTES;
    return Frama_C_unsigned_int_interval(0u, 1u);
}}
"""
ENTRY = """
%s
settings_t settings;
image_owner_t owner;
board_t board;
firmware_t firmware;

int main(void)
{
    /*@ widen_hints global:"all", 1, 4, 64, 128, 132, 134, 136; */
    %s
    Frama_C_make_unknown((char *)&owner, sizeof owner);
    firmware_boot(&firmware, &board, &settings, &owner);
    while (Frama_C_interval(0, 1)) {
        firmware.controller.request = any();
        firmware_interrupt(&firmware, &board);
        %s
        firmware_idle(&firmware, &board);
    }
    firmware_panic(&firmware, &board);
    return 0;
}
"""
ANY_SETTINGS = "Frama_C_make_unknown((char *)&settings, sizeof settings);"
EVA = (
    "-eva-precision",
    "0",
    "-eva-slevel",
    "4",
    "-eva-slevel-function",
    "frame_make:300,link_add_text:64,siphash:300,siphash_word:16,image_word:2,store_load:16",
)
"""Cases to keep apart: few, but where an index follows from a loop."""

LIMITS = r"//@ check limits: \is_finite(output_V) && -20.0 <= output_V <= 120.0;"


def sources(settings: str, check: str) -> dict[str, str]:
    """The firmware as one unit in `entry.c`, with stubs for model and board."""
    controller = dict(read_sources(CONTROLLER))
    generated = {path.name: path.read_text(encoding="utf-8") for path in MODEL.glob("*.h")}
    own = [name for name in controller if name.endswith(".c")]
    units = "\n".join(f'#include "{name}"' for name in ["board_stubs.c", "model_stubs.c", *own])
    stubs = {"board_stubs.c": BOARD_STUBS, "model_stubs.c": MODEL_STUBS, "board_type.h": BOARD_TYPE}
    return {**controller, **generated, **stubs, "entry.c": ENTRY % (units, settings, check)}


def shipped_settings() -> str:
    """Assignments of the settings in main.c, with every option on."""
    main = dict(read_sources(TARGET_BOARD))["main.c"]
    values = re.findall(r"^    \.(\w+) = ([-\d.]+[fu]),$", main, re.MULTILINE)
    assert len(values) > 30
    return " ".join(f"settings.{name} = {'7u' if name == 'options' else value};" for name, value in values)


@pytest.mark.slow
def test_no_settings_that_pass_and_no_readings_make_the_firmware_fail() -> None:
    need("frama-c")
    verdict = analyse(sources(ANY_SETTINGS, ""), "entry.c", "any", options=EVA)
    assert not verdict.alarms
    assert verdict.held == verdict.checks >= 5


@pytest.mark.slow
def test_with_the_shipped_settings_the_output_stays_inside_its_limits() -> None:
    need("frama-c")
    verdict = analyse(sources(shipped_settings(), LIMITS), "entry.c", "any", options=EVA)
    assert not verdict.alarms
    assert verdict.held == verdict.checks >= 6


def test_the_firmware_follows_every_required_rule_of_misra() -> None:
    need("cppcheck")
    generated = [(path.name, path.read_text(encoding="utf-8")) for path in MODEL.glob("*.h")]
    board = [*read_sources(TARGET_BOARD), *read_sources(*EMPTY_STORE)]
    found = misra("firmware", dict([*read_sources(CONTROLLER), *board, *generated]))
    assert found.required == 0, "\n".join(found.lines())
    assert {finding.rule for finding in found.findings} == set(ADVISORY)
