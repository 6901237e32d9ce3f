"""Start: a sensor that does not fit the stage, or is dead, is a fault before the feed-forward relies on its reading."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from fixtures.firmware_bench import REFERENCE_UM, ModelStage, image, model
from hysgen.firmware.wire import FirmwareStatus, Request, Settings, State
from hysgen_lab.firmware.host import FAULTS, HostFirmware


def started(sensor: Callable[[float], float], noise_um: float = 1e-4, settings: Settings | None = None) -> HostFirmware:
    """Started on the model itself as the stage, read through `sensor`."""
    stage = ModelStage(model(), noise_um)
    stage.sensor = sensor
    firmware = HostFirmware(image(), stage, settings or Settings())
    firmware.start(REFERENCE_UM)
    return firmware


@pytest.mark.parametrize("offset_um", [8.0, 1.1, -1.1, -3.5])
def test_an_offset_beyond_its_limit_is_a_fault(offset_um: float) -> None:
    firmware = started(lambda y_um: y_um + offset_um)
    assert firmware.state is State.TRIPPED
    assert FirmwareStatus(firmware.status & FAULTS) == FirmwareStatus.FAULT_OFFSET


@pytest.mark.parametrize("offset_um", [0.0, 0.9, -0.9])
def test_an_offset_within_its_limit_is_measured(offset_um: float) -> None:
    firmware = started(lambda y_um: y_um + offset_um)
    assert firmware.state is State.TRACK
    assert abs(firmware.firmware.controller.offset_um - offset_um) < 1e-3


def test_a_dead_sensor_that_flickers_by_one_bit_is_a_fault() -> None:
    flicker = itertools.cycle((0.0, 0.00025))
    firmware = started(lambda _: next(flicker), noise_um=0.0)
    assert firmware.state is State.TRIPPED
    assert FirmwareStatus(firmware.status & FAULTS) == FirmwareStatus.FAULT_STROKE


def test_a_stage_at_rest_is_a_fault_whatever_offset_the_settings_allow() -> None:
    """Found by the fuzzer: limits of 2 um of stroke and offset let an amplifier pass that did not move."""
    firmware = started(lambda _: 2.0, settings=Settings(offset_um=3.0, follow_um=0.49))
    assert firmware.state is State.TRIPPED
    assert FirmwareStatus(firmware.status & FAULTS) == FirmwareStatus.FAULT_STROKE


@pytest.mark.parametrize("state", [State.LOOP, State.HOLD])
def test_a_clear_on_the_way_does_not_hide_a_sensor_that_repeats_its_reading(state: State) -> None:
    """Found by the fuzzer: CLEAR reset the voltage at which the reading last changed, and nothing moved afterwards."""
    settings = Settings(ramp_V=0.005)
    stage = ModelStage(model(), 0.0)
    firmware = HostFirmware(image(), stage, settings)
    firmware.request(Request.START)
    for _ in range(20_000):
        firmware.run(np.full(1, REFERENCE_UM))
        if firmware.state is state:
            break
    kept_um = stage.y_um
    stage.sensor = lambda _: kept_um
    moved = 0
    while moved < 3 and firmware.state is state:
        firmware.run(np.full(100, REFERENCE_UM))
        firmware.request(Request.CLEAR)
        moved += 1
    count = firmware.firmware.controller.watchdog.same
    assert count >= 100
    firmware.run(np.full(1, REFERENCE_UM))
    assert firmware.firmware.controller.watchdog.same == count + 1


@pytest.mark.parametrize("sensitivity", [-1.0, 0.5, 1.5])
def test_a_sensor_of_another_sensitivity_is_a_fault(sensitivity: float) -> None:
    middle_um = 3.2
    firmware = started(lambda y_um: middle_um + sensitivity * (y_um - middle_um))
    assert firmware.state is State.TRIPPED
    assert FirmwareStatus.FAULT_STROKE in firmware.status


def test_after_a_refused_start_the_stage_comes_to_rest_and_clear_allows_another() -> None:
    firmware = started(lambda y_um: y_um + 8.0)
    assert firmware.board.output_V == 0.0
    firmware.stage.sensor = lambda y_um: y_um  # type: ignore[attr-defined]
    firmware.request(Request.CLEAR)
    firmware.run(np.full(2, REFERENCE_UM))
    assert firmware.state is State.OFF
    firmware.start(REFERENCE_UM)
    assert firmware.state is State.TRACK
