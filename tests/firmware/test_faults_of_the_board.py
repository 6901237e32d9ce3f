"""Faults outside the firmware: the voltage stays within its limits, status bits are set, the stage comes to rest."""

# Safety case: [S2], [S4], [S6], [S7]

from dataclasses import replace

import numpy as np
import pytest

from fixtures.firmware_bench import REFERENCE_UM, booted, on_itself, sine, tracking
from hysgen.firmware.wire import FirmwareStatus, Request, Settings, State
from hysgen_lab.firmware.host import FAULTS, BoardFault, HostFirmware, Log

SETTINGS = Settings(low_V=-5.0, high_V=60.0, step_V=1.0)
BAD, ASTRAY = 8, 50


def assert_limits(log: Log, before_V: float, settings: Settings = SETTINGS) -> None:
    """The voltage is finite, within its range, and within its rate at every sample."""
    u_V = np.concatenate([[before_V], log.output_V]).astype(np.float64)
    assert np.isfinite(u_V).all()
    assert u_V.min() >= settings.low_V
    assert u_V.max() <= settings.high_V
    # A float32 sum below 64 V is rounded by at most 2^-19 V.
    assert np.abs(np.diff(u_V)).max() <= settings.step_V + 2.0**-18


def suffered(
    fault: BoardFault,
    value: float = 0.0,
    after: int = 700,
    samples: int = 0xFFFFFFFF,
    reference_um: np.ndarray | None = None,
) -> tuple[HostFirmware, Log]:
    """Track the sine of section 4.3 with the fault; the limits hold throughout."""
    firmware = tracking(SETTINGS)
    assert firmware.state is State.TRACK
    firmware.request(Request.CLEAR)
    firmware.run(np.full(1, REFERENCE_UM))
    before_V = firmware.board.output_V
    assert FirmwareStatus(firmware.status & ~FirmwareStatus.OUTPUT_SLEWED) == 0
    firmware.fail(fault, value, after, samples)
    log = firmware.run(sine(8000) if reference_um is None else reference_um)
    assert_limits(log, before_V)
    return firmware, log


@pytest.mark.parametrize(
    ("fault", "value", "told", "within"),
    [
        (BoardFault.STUCK, 0.0, FirmwareStatus.FAULT_STUCK, 400),
        (BoardFault.READING, np.nan, FirmwareStatus.FAULT_SENSOR | FirmwareStatus.SENSOR_INVALID, 12),
        (BoardFault.READING, np.inf, FirmwareStatus.FAULT_SENSOR | FirmwareStatus.SENSOR_INVALID, 12),
        (BoardFault.READING, 14.0, FirmwareStatus.FAULT_SENSOR | FirmwareStatus.SENSOR_RANGE, 12),
        (BoardFault.SATURATED, 33.0, FirmwareStatus.FAULT_FOLLOW, 800),
        (BoardFault.LIMITS, 0.0, FirmwareStatus.FAULT_AMPLIFIER | FirmwareStatus.AMPLIFIER_LIMITS, 12),
        (BoardFault.AMPLIFIER, 0.0, FirmwareStatus.FAULT_AMPLIFIER, 3),
        (BoardFault.LATE, 7501.0, FirmwareStatus.FAULT_DEADLINE | FirmwareStatus.DEADLINE_MISSED, 12),
        (BoardFault.OVERRUN, 0.0, FirmwareStatus.FAULT_DEADLINE | FirmwareStatus.DEADLINE_MISSED, 12),
        (BoardFault.LOST, 15_000.0, FirmwareStatus.FAULT_DEADLINE | FirmwareStatus.INTERRUPT_LOST, 12),
    ],
    ids=lambda each: each.name if isinstance(each, BoardFault) else None,
)
@pytest.mark.slow
def test_a_lasting_fault_is_named_and_brings_the_stage_to_rest(
    fault: BoardFault, value: float, told: FirmwareStatus, within: int
) -> None:
    firmware, log = suffered(fault, value)
    assert firmware.state is State.TRIPPED
    assert firmware.board.output_V == SETTINGS.off_V
    assert firmware.board.enabled == 0
    faults = FirmwareStatus(firmware.status & FAULTS)
    assert told in firmware.status
    assert faults == FirmwareStatus(told & FAULTS), f"{faults!r}: one cause, one fault"
    tripped = int(np.argmax(log.state == State.TRIP))
    assert 700 <= tripped <= 700 + within
    # The stage stays off until CLEAR, and starts again after the fault has ended.
    firmware.request(Request.START)
    firmware.fail(BoardFault.NONE)
    assert set(firmware.run(sine(1000)).output_V.tolist()) == {SETTINGS.off_V}
    firmware.request(Request.CLEAR)
    firmware.run(sine(2))
    assert firmware.state is State.OFF
    firmware.start(REFERENCE_UM)
    assert firmware.state is State.TRACK
    assert firmware.board.enabled == 1


@pytest.mark.parametrize(
    ("fault", "value", "told"),
    [
        (BoardFault.READING, np.nan, FirmwareStatus.SENSOR_INVALID),
        (BoardFault.READING, -9.0, FirmwareStatus.SENSOR_RANGE),
        (BoardFault.LIMITS, 0.0, FirmwareStatus.AMPLIFIER_LIMITS),
        (BoardFault.LATE, 7501.0, FirmwareStatus.DEADLINE_MISSED),
    ],
    ids=lambda each: each.name if isinstance(each, BoardFault) else None,
)
def test_a_few_bad_samples_set_the_status_and_do_not_trip(
    fault: BoardFault, value: float, told: FirmwareStatus
) -> None:
    firmware, log = suffered(fault, value, samples=BAD - 2)
    assert told in firmware.status
    assert not firmware.status & FAULTS
    assert (log.state == State.TRACK).all()


@pytest.mark.parametrize("pattern", [(7, 8), (1, 2), (1, 8), (2, 16)], ids=str)
@pytest.mark.parametrize(
    ("fault", "value", "told"),
    [
        (BoardFault.READING, np.nan, FirmwareStatus.FAULT_SENSOR),
        # Followed at 7 in 8, where the reading behind confirms the first; a jump that none confirms is no reading.
        (BoardFault.READING, 5.0, FirmwareStatus.FAULT_FOLLOW | FirmwareStatus.FAULT_SENSOR),
        (BoardFault.LIMITS, 0.0, FirmwareStatus.FAULT_AMPLIFIER),
        (BoardFault.LATE, 7501.0, FirmwareStatus.FAULT_DEADLINE),
    ],
    ids=lambda each: each.name if isinstance(each, BoardFault) else None,
)
def test_a_share_of_bad_samples_above_one_in_nine_trips(
    fault: BoardFault, value: float, told: FirmwareStatus, pattern: tuple[int, int]
) -> None:
    firmware = tracking(SETTINGS)
    firmware.fail(fault, value, after=1, pattern=pattern)
    # At (1, 8) the count grows by one in 64 samples: 1 - 7/8 of eight.
    firmware.run(sine(64 * (ASTRAY + 1) if FirmwareStatus.FAULT_FOLLOW in told else 64 * 9))
    assert firmware.status & told
    assert firmware.state in (State.TRIP, State.TRIPPED)


def test_one_bad_sample_in_ten_is_told_and_survived() -> None:
    for fault, value in (
        (BoardFault.READING, np.nan),
        (BoardFault.READING, 5.0),
        (BoardFault.LIMITS, 0.0),
        (BoardFault.LATE, 7501.0),
    ):
        firmware = tracking(SETTINGS)
        firmware.fail(fault, value, after=1, pattern=(1, 10))
        firmware.run(sine(20_000))
        assert firmware.state is State.TRACK


def test_a_reading_that_jumps_and_comes_back_moves_nothing_and_is_told() -> None:
    """Every tenth reading 9 um, with feedback: the stage was 0.26 um off for ever. A step of the stage is no jump."""
    firmware = on_itself(Settings(loop=True))
    firmware.run(np.full(3000, REFERENCE_UM))
    firmware.fail(BoardFault.READING, 9.0, after=1, pattern=(1, 10))
    log = firmware.run(np.full(5000, REFERENCE_UM))
    assert FirmwareStatus.SENSOR_JUMP in firmware.status
    assert firmware.state is State.TRACK
    assert np.ptp(log.output_V) < 0.1
    firmware = on_itself(Settings(step_V=8.0, reference_step_um=3.0, follow_um=0.49))
    firmware.run(np.repeat([1.0, 3.4, 1.0, 3.4], 500))
    assert (firmware.state, FirmwareStatus.SENSOR_JUMP in firmware.status) == (State.TRACK, False)


def test_a_reading_that_is_no_number_confirms_no_jump() -> None:
    firmware = on_itself(Settings(loop=True))
    firmware.fail(BoardFault.READING, np.nan, samples=2)
    firmware.run(np.full(1, REFERENCE_UM))
    firmware.fail(BoardFault.READING, 9.0, samples=2)
    log = firmware.run(np.full(2, REFERENCE_UM))
    assert log.reading_um[1] == 9.0
    assert FirmwareStatus.SENSOR_INVALID | FirmwareStatus.SENSOR_JUMP in firmware.status
    assert abs(firmware.firmware.controller.watchdog.reading_um - REFERENCE_UM) < 0.1


@pytest.mark.parametrize("state", [State.LOOP, State.HOLD, State.TRACK])
def test_a_model_that_is_no_number_is_a_fault(state: State) -> None:
    """Nothing is larger than a limit that NaN is held against: the guards demanded a difference beyond it."""
    firmware = reached(state)
    firmware.firmware.controller.model.y_um = np.nan
    firmware.run(np.full(6000, REFERENCE_UM))
    assert firmware.state in (State.TRIP, State.TRIPPED)


def test_the_status_of_the_model_is_that_of_the_way_it_drives() -> None:
    """It was set by every start, and CLEAR left it."""
    firmware = on_itself(Settings(high_V=58.0))
    assert FirmwareStatus.MODEL not in firmware.status
    for reference_um, told in ((3.7, True), (REFERENCE_UM, False)):
        firmware.run(np.full(2000, reference_um))
        firmware.request(Request.CLEAR)
        firmware.run(np.full(2, reference_um))
        assert (FirmwareStatus.MODEL in firmware.status) is told


def test_the_stop_input_stops_and_keeps_from_starting() -> None:
    firmware = tracking(SETTINGS)
    firmware.fail(BoardFault.STOPPED, samples=3000)
    log = firmware.run(np.full(3000, REFERENCE_UM))
    assert np.abs(np.diff(log.output_V)).max() <= SETTINGS.ramp_V * (1 + 1e-3)
    assert firmware.state is State.OFF
    firmware.fail(BoardFault.STOPPED)
    firmware.request(Request.START)
    firmware.run(np.full(20, REFERENCE_UM))
    assert (firmware.state, firmware.board.enabled, firmware.status & FAULTS) == (State.OFF, 0, 0)


@pytest.mark.parametrize("level_um", [50.0, -50.0, 3e38, -3e38])
def test_a_reference_step_beyond_the_range_is_followed_as_far_and_as_fast_as_allowed(level_um: float) -> None:
    reference_um = np.concatenate([sine(1000), np.full(3000, level_um), np.full(3000, REFERENCE_UM)])
    settings = replace(SETTINGS, follow_um=0.49)
    firmware = on_itself(settings)
    before_V = firmware.board.output_V
    log = firmware.run(reference_um)
    assert_limits(log, before_V, settings)
    assert FirmwareStatus.REFERENCE_LIMITED | FirmwareStatus.REFERENCE_SLEWED in firmware.status
    assert firmware.state is State.TRACK
    assert abs(float(log.reading_um[-200:].mean()) - REFERENCE_UM) < 0.3


@pytest.mark.parametrize("level", [np.nan, np.inf, -np.inf])
def test_a_reference_that_is_no_number_holds_the_last_one(level: float) -> None:
    reference_um = np.concatenate([np.full(500, 2.1), np.full(2000, level)])
    firmware, log = suffered(BoardFault.NONE, reference_um=reference_um)
    assert FirmwareStatus.REFERENCE_INVALID in firmware.status
    assert firmware.state is State.TRACK
    assert float(np.ptp(log.output_V[1500:])) < 0.05


def test_any_bits_from_sensor_and_reference_keep_the_voltage_in_its_limits() -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        firmware = tracking(replace(SETTINGS, loop=True, follow_um=0.49))
        before_V = firmware.board.output_V
        firmware.fail(
            BoardFault.READING, float(rng.integers(0, 1 << 32, dtype=np.uint32).view(np.float32)), 10, pattern=(1, 10)
        )
        log = firmware.run(rng.integers(0, 1 << 32, 300, dtype=np.uint32).view(np.float32))
        assert_limits(log, before_V)
        assert firmware.state is State.TRACK


TRANSITIONS = {
    (State.OFF, Request.START): State.POWER,
    (State.OFF, Request.STOP): State.OFF,
    (State.POWER, Request.STOP): State.OFF,
    (State.RISE, Request.STOP): State.FALL,
    (State.PLAY, Request.STOP): State.FALL,
    (State.LOOP, Request.STOP): State.FALL,
    (State.HOLD, Request.STOP): State.FALL,
    (State.APPROACH, Request.STOP): State.FALL,
    (State.TRACK, Request.STOP): State.FALL,
    (State.FALL, Request.STOP): State.FALL,
    (State.TRIP, Request.STOP): State.TRIP,
    (State.TRIPPED, Request.STOP): State.TRIPPED,
    (State.TRIPPED, Request.START): State.TRIPPED,
    (State.TRIPPED, Request.CLEAR): State.OFF,
    **{(state, Request.START): state for state in State if state not in (State.OFF, State.TRIPPED)},
    **{(state, Request.CLEAR): state for state in State if state is not State.TRIPPED},
}


def reached(state: State) -> HostFirmware:
    """A firmware in `state`, reached by requests and faults only."""
    firmware = booted(SETTINGS)
    if state is State.OFF:
        return firmware
    firmware.request(Request.RECORD if state is State.PLAY else Request.START)
    # 60 ms at one voltage inside the limits.
    firmware.firmware.controller.play.count, firmware.board.record[0:3000] = 3000, [20_000] * 3000
    if state in (State.FALL, State.TRIP, State.TRIPPED):
        firmware.run(np.full(900, REFERENCE_UM))
        if state is State.FALL:
            firmware.request(Request.STOP)
        else:
            firmware.fail(BoardFault.AMPLIFIER, samples=3)
    for _ in range(10_000):
        firmware.run(np.full(1, REFERENCE_UM))
        if firmware.state is state:
            firmware.run(np.full(2 if state is State.RISE else 0, REFERENCE_UM))
            return firmware
    raise AssertionError(f"{state!r} is never reached")


@pytest.mark.parametrize(("before", "asked"), list(TRANSITIONS), ids=lambda each: each.name)
def test_every_state_answers_every_request_as_the_table_says(before: State, asked: Request) -> None:
    firmware = reached(before)
    firmware.request(asked)
    firmware.run(np.full(1, REFERENCE_UM))
    assert firmware.state is TRANSITIONS[before, asked]


@pytest.mark.parametrize("before", [state for state in State if state not in (State.TRIP, State.TRIPPED)])
def test_a_fault_trips_every_state(before: State) -> None:
    firmware = reached(before)
    firmware.fail(BoardFault.OVERRUN)
    firmware.run(np.full(BAD + 1, REFERENCE_UM))
    assert firmware.state in (State.TRIP, State.TRIPPED)
    assert FirmwareStatus.FAULT_DEADLINE in firmware.status


def test_the_ways_up_and_down_are_ramps_through_the_loop() -> None:
    firmware = booted(SETTINGS)
    up = firmware.start(REFERENCE_UM)
    visited = [State(int(up.state[0])), *(State(int(s)) for s in up.state[1:][np.diff(up.state) != 0])]
    assert visited == [State.POWER, State.RISE, State.LOOP, State.HOLD, State.APPROACH, State.TRACK]
    ramped = np.isin(up.state, (State.RISE, State.LOOP, State.HOLD))
    steps = np.abs(np.diff(up.output_V.astype(np.float64)))[ramped[1:]]
    assert steps.max() <= SETTINGS.ramp_V * (1 + 1e-3)
    assert up.output_V[up.state == State.LOOP].max() == SETTINGS.loop_high_V
    firmware.request(Request.STOP)
    down = firmware.run(np.full(4000, REFERENCE_UM))
    assert np.abs(np.diff(down.output_V)).max() <= SETTINGS.ramp_V * (1 + 1e-3)
    assert down.output_V[-1] == SETTINGS.off_V


def test_an_idle_loop_that_hangs_is_left_to_the_hardware_watchdog() -> None:
    """The interrupt restarts the watchdog for a second behind the last pass of the idle loop."""
    firmware = booted(SETTINGS)
    firmware.run(np.full(10, REFERENCE_UM))
    board, lib = firmware.board, firmware.image.library.lib
    reference_um, restarted = firmware.image.library.ffi.new("float []", [REFERENCE_UM]), board.alive
    assert restarted == 10
    for _ in range(51_000):
        board.sample, board.reference_um = 0, reference_um
        lib.hysgen_firmware_interrupt(firmware.firmware, board)
    assert board.alive == restarted + 50_000 - 1
    lib.hysgen_firmware_idle(firmware.firmware, board)
    lib.hysgen_firmware_interrupt(firmware.firmware, board)
    assert board.alive == restarted + 50_000


def test_a_failed_selftest_keeps_the_stage_off_for_good() -> None:
    firmware = booted(SETTINGS)
    firmware.firmware.controller.status |= int(FirmwareStatus.FAULT_SELFTEST)
    firmware.request(Request.START)
    firmware.run(np.full(10, REFERENCE_UM))
    firmware.request(Request.CLEAR)
    firmware.run(np.full(10, REFERENCE_UM))
    firmware.request(Request.START)
    log = firmware.run(np.full(2000, REFERENCE_UM))
    assert firmware.state is State.TRIPPED
    assert FirmwareStatus.FAULT_SELFTEST in firmware.status
    assert set(log.output_V.tolist()) == {SETTINGS.off_V}
