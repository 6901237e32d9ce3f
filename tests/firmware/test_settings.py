"""Settings: impossible ones are named at boot and nothing moves; with possible ones no state lasts for ever."""

# Safety case: [S3]

import re
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from fixtures.firmware_bench import REFERENCE_UM, ModelStage, booted, image, model, tracking
from hysgen.firmware import CONTROLLER, read_sources
from hysgen.firmware.wire import FirmwareStatus, Request, Settings, State
from hysgen_lab.firmware.host import HostFirmware

FLOATS = [each.name for each in fields(Settings) if each.type == "float"]
IMPOSSIBLE = [  # the limits of each field alone: test_units.py
    {"low_V": 30.0, "off_V": 31.0, "loop_low_V": 22.0},  # RISE would never end
    {"state_samples": 4096, "ramp_V": 0.04},  # HOLD alone takes as long
    {"step_V": 1e-6, "ramp_V": 1e-6},  # cannot come down
    {"reading_zero_um": -1.0},
    {"state_samples": 0},
]


def refused(wrong: dict[str, Any]) -> str | None:
    """The field that the firmware refuses; the safe voltage of the board is put out, and the watchdog served."""
    firmware = booted(replace(Settings(), **wrong))
    field = firmware.settings_wrong
    if field is not None:
        for request in (Request.START, Request.CLEAR, Request.START):
            firmware.request(request)
            log = firmware.run(np.full(20, REFERENCE_UM))
            assert (log.output_V == 0.0).all()
        assert firmware.state is State.TRIPPED
        assert FirmwareStatus.FAULT_SETTINGS in firmware.status
        assert firmware.board.alive == 60
    return field


@pytest.mark.parametrize("wrong", IMPOSSIBLE, ids=str)
def test_impossible_settings_are_refused_by_name(wrong: dict[str, Any]) -> None:
    field = refused(wrong)
    expected = {"state_samples": {4096: "hold_samples", 0: "ramp_V"}.get(wrong.get("state_samples"), "state_samples")}
    assert field in {expected.get(name, name) for name in wrong}


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_settings_that_are_not_finite_are_refused_by_name(value: float) -> None:
    for name in FLOATS:
        assert refused({name: value}) == name


def test_the_settings_of_the_tests_and_the_reference_board_are_possible() -> None:
    assert booted(Settings()).settings_wrong is None


def test_an_approach_that_never_arrives_is_a_fault() -> None:
    """The reference jumps from end to end at every sample, and nothing can meet it."""
    settings = Settings(state_samples=6000, ramp_V=0.03)
    firmware = booted(settings)
    firmware.request(Request.START)
    jumps = np.where(np.arange(20_000) % 2 == 0, 0.7, 3.7)
    log = firmware.run(jumps)
    assert int((log.state == State.APPROACH).sum()) == pytest.approx(6000, abs=2)
    assert firmware.status & FirmwareStatus.FAULT_TIMEOUT
    assert firmware.state is State.TRIPPED
    assert firmware.board.output_V == settings.off_V


def test_clear_is_taken_where_settings_were_refused_and_starts_nothing() -> None:
    """The request waited for ever, and with it all that is answered at rest only."""
    firmware = booted(Settings(step_V=99.0))
    firmware.boot(power_on=False)
    firmware.request(Request.CLEAR)
    firmware.run(np.full(2, REFERENCE_UM))
    assert (firmware.firmware.controller.request, firmware.firmware.controller.clears) == (0, 1)
    assert firmware.first_fault == firmware.status == FirmwareStatus.FAULT_SETTINGS
    firmware.request(Request.START)
    firmware.run(np.full(2, REFERENCE_UM))
    assert (firmware.state, firmware.firmware.controller.request) == (State.TRIPPED, 0)


def test_a_fall_after_a_fault_that_takes_too_long_ends_at_the_largest_rate() -> None:
    firmware = tracking(Settings(state_samples=6000, ramp_V=0.03))
    firmware._settings.ramp_V = 1e-8  # which hysgen_settings_check refuses
    firmware.firmware.controller.status |= int(FirmwareStatus.FAULT_AMPLIFIER)
    firmware.run(np.full(6100, REFERENCE_UM))
    assert firmware.state is State.TRIPPED
    assert firmware.board.output_V == 0.0


@pytest.mark.slow
def test_a_voltage_within_one_step_is_reached_to_the_bit() -> None:
    """from + (to - from) is not always `to`: RISE across 0 V ended an ulp beside its voltage, told as a rate limit."""
    rng = np.random.default_rng(3)
    # Without the exact end of the step one pair in six misses by an ulp: 40 pairs all hit once in 1500 runs.
    for _ in range(40):
        off_V, low_V = (float(each) for each in rng.uniform(-1.5, 1.5, 2).astype(np.float32))
        settings = Settings(power_samples=1, off_V=off_V, loop_low_V=low_V, loop_high_V=40.0, ramp_V=4.0, step_V=4.0)
        firmware = HostFirmware(image(), ModelStage(model(), 0.0), settings)
        firmware.request(Request.START)
        log = firmware.run(np.full(3, REFERENCE_UM))
        assert float(log.output_V[2]) == low_V
        assert FirmwareStatus.OUTPUT_SLEWED not in firmware.status


class OffScale(ModelStage):
    """The model behind a D/A that puts out 0.4 V + 1.03 u, read by a sensor that gives (y - 0.3 um) / 1.05."""

    def step(self, _: object, u_V: float) -> float:
        return (super().step(_, 0.4 + 1.03 * u_V) - 0.3) / 1.05


def test_converters_off_their_scales_are_calibrated_by_the_settings() -> None:
    wrong_um = []
    right = {"reading_zero_um": 0.3, "reading_gain": 1.05, "output_zero_V": -0.4 / 1.03, "output_gain": 1.0 / 1.03}
    for calibration in (right, {}):
        firmware = HostFirmware(image(), OffScale(model()), Settings(**calibration, follow_um=0.49))
        firmware.start(REFERENCE_UM)
        firmware.run(np.full(2000, REFERENCE_UM))
        assert firmware.state is State.TRACK
        wrong_um.append(abs(firmware.stage.y_um - REFERENCE_UM))
    assert wrong_um[0] < 1e-3
    assert wrong_um[1] > 0.1


def test_there_are_at_most_20_settings_calibration_included() -> None:
    (words,) = re.findall(r"SETTINGS_WORDS (\d+)u", dict(read_sources(CONTROLLER))["settings.h"])
    assert int(words) == booted().image.library.ffi.sizeof("settings_t") // 4 <= 20
