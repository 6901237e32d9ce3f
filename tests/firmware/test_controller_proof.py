"""Frama-C Eva over the controller, with any settings and any readings, and MISRA over the hand-written firmware.

The generated model is replaced by functions that return any number; `hysgen prove` covers the real ones. Image code,
frames and link are not analysed: the fuzzer and the tests of images and link try them.
"""

from __future__ import annotations

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
ENTRY = f"""
#include <stddef.h>
#include "model_stubs.c"
#include "controller.c"
#include "settings.c"
#include "trim.c"
#include "watchdog.c"

settings_t settings;
controller_t controller;
float output_V;
static uint32_t any(void) {{ return Frama_C_unsigned_int_interval(0u, 0xFFFFFFFFu); }}

int main(void)
{{
    Frama_C_make_unknown((char *)&settings, sizeof settings);
    controller_init(&controller, &settings);
    if (settings_check(&settings) != NULL) {{
        controller.status |= STATUS_FAULT_SETTINGS;
    }}
    while (Frama_C_interval(0, 1)) {{
        controller.request = any();
        controller.committing = any();
        controller.installing = any();
        output_V = controller_step(&controller, {ANY_FLOAT}, {ANY_FLOAT}, any());
        controller_learn(&controller);
        controller_time(&controller, any(), any(), any());
    }}
    return 0;
}}
"""
OPTIONS = ("-eva-precision", "0", "-eva-slevel", "20")


def sources(old: str = "", new: str = "") -> dict[str, str]:
    """The controller as one unit in `entry.c`, with stubs for the model; old, new: a change of controller.c."""
    controller = dict(read_sources(CONTROLLER))
    assert old in controller["controller.c"]
    controller["controller.c"] = controller["controller.c"].replace(old, new)
    generated = {path.name: path.read_text(encoding="utf-8") for path in MODEL.glob("*.h")}
    return {**controller, **generated, "model_stubs.c": MODEL_STUBS, "board_type.h": BOARD_TYPE, "entry.c": ENTRY}


@pytest.mark.slow
def test_no_settings_and_no_readings_make_the_controller_fail() -> None:
    """Any bits as settings, readings, references, requests: no index out of bounds, nothing uninitialised."""
    need("frama-c")
    assert not analyse(sources(), "entry.c", "any", options=OPTIONS).alarms


@pytest.mark.slow
def test_an_index_that_goes_too_far_is_an_alarm() -> None:
    need("frama-c")
    planted = sources("(now + 1u < CONTROLLER_LINE)", "(now < CONTROLLER_LINE)")
    assert analyse(planted, "entry.c", "any", options=OPTIONS).alarms


def test_the_firmware_follows_every_required_rule_of_misra() -> None:
    need("cppcheck")
    generated = [(path.name, path.read_text(encoding="utf-8")) for path in MODEL.glob("*.h")]
    board = [*read_sources(TARGET_BOARD), *read_sources(*EMPTY_STORE)]
    found = misra("firmware", dict([*read_sources(CONTROLLER), *board, *generated]))
    assert found.required == 0, "\n".join(found.lines())
    assert {finding.rule for finding in found.findings} == set(ADVISORY)
