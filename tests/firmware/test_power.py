"""High voltage: on between START and OFF only, and never by itself behind a reset."""

# Safety case: [S1], [S8]

import numpy as np
import pytest

from fixtures.firmware_bench import REFERENCE_UM, booted, tracking
from hysgen.firmware.wire import FirmwareStatus, Request, Settings, State
from hysgen_lab.firmware.host import BoardFault, HostFirmware

SETTINGS = Settings(power_samples=50, hold_samples=512, ramp_V=0.05)


def run(firmware: HostFirmware, samples: int) -> None:
    firmware.run(np.full(samples, REFERENCE_UM))


@pytest.mark.parametrize("ready_after", [0, 1, 500])
def test_an_amplifier_that_is_good_only_while_it_is_on_gets_on(ready_after: int) -> None:
    firmware = booted(SETTINGS)
    firmware.board.ready_after = ready_after
    run(firmware, 20)
    assert (firmware.state, firmware.status, firmware.board.enabled) == (State.OFF, 0, 0)
    log = firmware.start(REFERENCE_UM)
    assert firmware.state is State.TRACK
    # The amplifier is switched on behind the first sample; the samples in a row count from its first good one on.
    waited = int((log.state == State.POWER).sum())
    assert waited == max(ready_after, 1) + SETTINGS.power_samples - 1
    assert (log.output_V[log.state == State.POWER] == SETTINGS.off_V).all()


def test_an_amplifier_that_never_gets_good_is_a_fault_and_switched_off() -> None:
    firmware = booted(Settings(power_samples=50, hold_samples=512, state_samples=2000, ramp_V=0.1))
    firmware.board.ready_after = 1 << 30
    firmware.start(REFERENCE_UM, 3000)
    assert (firmware.state, firmware.board.enabled) == (State.TRIPPED, 0)
    assert firmware.status & FirmwareStatus.FAULT_TIMEOUT


def test_the_amplifier_is_off_before_start_behind_stop_and_in_tripped() -> None:
    firmware = booted(SETTINGS)
    run(firmware, 10)
    assert firmware.board.enabled == 0
    firmware.start(REFERENCE_UM)
    assert firmware.board.enabled == 1
    firmware.request(Request.STOP)
    run(firmware, 3000)
    assert (firmware.state, firmware.board.enabled) == (State.OFF, 0)
    firmware.fail(BoardFault.OVERRUN, samples=20)
    run(firmware, 30)
    assert (firmware.state, firmware.board.enabled) == (State.TRIPPED, 0)


def test_a_spike_on_the_wire_of_the_amplifiers_failure_trips_nothing() -> None:
    firmware = tracking(SETTINGS)
    firmware.fail(BoardFault.AMPLIFIER, after=5, pattern=(2, 40))
    run(firmware, 400)
    assert firmware.state is State.TRACK
    firmware.fail(BoardFault.AMPLIFIER, samples=3)
    run(firmware, 4)
    assert firmware.state is State.TRIP


def test_behind_a_reset_under_power_the_first_fault_is_told_and_nothing_starts_until_clear() -> None:
    firmware = tracking(SETTINGS)
    firmware.fail(BoardFault.READING, float("nan"))
    run(firmware, 400)
    assert firmware.first_fault == FirmwareStatus.FAULT_SENSOR
    firmware.fail(BoardFault.NONE)
    firmware.boot(power_on=False)
    assert FirmwareStatus.FAULT_RESET in firmware.status
    for request in (Request.START, Request.STOP, Request.START):
        firmware.request(request)
        run(firmware, 20)
        assert (firmware.state, firmware.board.enabled) == (State.TRIPPED, 0)
    assert firmware.first_fault == FirmwareStatus.FAULT_SENSOR
    firmware.request(Request.CLEAR)
    run(firmware, 1)
    assert (firmware.state, firmware.status, firmware.first_fault) == (State.OFF, 0, 0)
    firmware.start(REFERENCE_UM)
    assert firmware.state is State.TRACK


def test_power_on_forgets_what_memory_holds() -> None:
    firmware = tracking(SETTINGS)
    firmware.fail(BoardFault.READING, float("nan"))
    run(firmware, 400)
    firmware.fail(BoardFault.NONE)
    run(firmware, 1)
    firmware.boot()
    run(firmware, 5)
    assert (firmware.state, firmware.status, firmware.first_fault) == (State.OFF, 0, 0)


def test_a_watchdog_reset_without_a_fault_before_is_itself_the_first_fault() -> None:
    firmware = tracking(SETTINGS)
    firmware.boot(power_on=False)
    run(firmware, 1)
    assert (firmware.state, firmware.first_fault) == (State.TRIPPED, FirmwareStatus.FAULT_RESET)


def test_an_exception_is_told_behind_the_reset_that_it_ends_in() -> None:
    firmware = tracking(SETTINGS)
    firmware.image.library.lib.hysgen_firmware_panic(firmware.firmware, firmware.board)
    firmware.boot(power_on=False)
    run(firmware, 1)
    assert firmware.first_fault == FirmwareStatus.FAULT_EXCEPTION


def test_an_exception_before_boot_leaves_the_first_fault() -> None:
    firmware = tracking(SETTINGS)
    firmware.boot(power_on=False)
    run(firmware, 1)
    before = firmware.image.library.ffi.new("firmware_t *")
    firmware.image.library.lib.hysgen_firmware_panic(before, firmware.board)
    firmware.boot(power_on=False)
    run(firmware, 1)
    assert firmware.first_fault == FirmwareStatus.FAULT_RESET | FirmwareStatus.FAULT_EXCEPTION


def test_clear_on_the_way_down_keeps_the_first_fault() -> None:
    firmware = tracking(SETTINGS)
    firmware.fail(BoardFault.AMPLIFIER, samples=3)
    run(firmware, 20)
    firmware.request(Request.CLEAR)
    run(firmware, 5000)
    assert (firmware.state, firmware.status) == (State.TRIPPED, 0)
    assert firmware.first_fault == FirmwareStatus.FAULT_AMPLIFIER


def test_a_panic_switches_off_and_leaves_the_voltage_at_any_time() -> None:
    """Before boot, too, where memory is zero."""
    firmware = tracking(SETTINGS)
    held_V = firmware.board.output_V
    lib, ffi = firmware.image.library.lib, firmware.image.library.ffi
    lib.hysgen_firmware_panic(firmware.firmware, firmware.board)
    assert (firmware.board.enabled, firmware.board.output_V) == (0, held_V)
    lib.hysgen_firmware_panic(ffi.new("firmware_t *"), firmware.board)
    assert (firmware.board.enabled, firmware.board.output_V) == (0, held_V)
