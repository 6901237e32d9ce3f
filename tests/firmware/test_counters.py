"""Counters and their limits: what they hold at, one below and one above the limit, and where they wrap."""

import struct
import zlib

import numpy as np
import pytest

from fixtures.firmware_bench import KEY, REFERENCE_UM, booted, model
from hysgen.firmware import Label, encode
from hysgen.firmware.wire import FirmwareStatus, Request, Settings, State
from hysgen_lab.firmware.host import SLOT_BYTES, BoardFault, HostFirmware

PERIOD = 7500
BAD = 8
MAGIC = 0x4C414553


def sealed(counter: int, sequence: int, build: int = 0) -> bytes:
    """A slot with an image under `counter` and its seal under `sequence` (store.h)."""
    image = encode(model(), KEY, Label(build=build, counter=counter))
    # Behind the image's CRC are two words of its MAC.
    seal = struct.pack("<3I", MAGIC, sequence, struct.unpack("<I", image[-12:-8])[0])
    seal += struct.pack("<I", zlib.crc32(seal))
    return image.ljust(SLOT_BYTES - len(seal), b"\xff") + seal


@pytest.mark.parametrize(
    ("older", "newer"), [(1, 2), (0xFFFFFFFF, 0), (0xFFFFFFFE, 1), (0x7FFFFFFF, 0x80000000), (5, 0x80000004)]
)
@pytest.mark.parametrize("newer_slot", [0, 1])
def test_the_newer_of_two_sealed_images_drives_also_where_the_sequence_wraps(
    older: int, newer: int, newer_slot: int
) -> None:
    firmware = booted()
    firmware.slot(newer_slot)[:] = sealed(8, newer)
    firmware.slot(1 - newer_slot)[:] = sealed(7, older)
    firmware.boot()
    assert (firmware.firmware.store.counter, firmware.firmware.store.sequence) == (8, newer)
    assert firmware.firmware.store.slot == newer_slot
    assert firmware.send(encode(model(), KEY, Label(counter=9))) == 0
    assert firmware.firmware.store.sequence == (newer + 1) & 0xFFFFFFFF
    assert firmware.firmware.store.slot == 1 - newer_slot


def test_an_image_behind_one_for_another_build_is_the_newest() -> None:
    """Its sequence began anew: every boot told IMAGE_FALLBACK, and the other build took the older image back."""
    firmware = booted()
    firmware.slot(1)[:] = sealed(50, 7, build=1)
    firmware.boot()
    assert firmware.send(encode(model(), KEY, Label(counter=51))) == 0
    firmware.boot()
    assert (firmware.status, firmware.firmware.store.slot, firmware.firmware.store.sequence) == (0, 0, 8)


def spent(firmware: HostFirmware, fault: BoardFault, cycles: int) -> FirmwareStatus:
    """Status after one interrupt that takes, or comes after, so many cycles; CLEAR and a quiet sample before it."""
    firmware.fail(BoardFault.NONE)
    firmware.request(Request.CLEAR)
    firmware.run(np.full(2, REFERENCE_UM))
    firmware.fail(fault, cycles, after=1, samples=1)
    firmware.run(np.full(3, REFERENCE_UM))
    return FirmwareStatus(firmware.status)


def test_cycles_most_is_the_largest_of_all_and_cycles_last_the_latest() -> None:
    firmware = booted()
    for cycles, most in ((100, 100), (700, 700), (300, 700), (701, 701), (0, 701)):
        firmware.fail(BoardFault.LATE, cycles, samples=1)
        firmware.run(np.full(1, REFERENCE_UM))
        assert (firmware.firmware.cycles_last, firmware.firmware.cycles_most) == (cycles, most)


def test_an_interrupt_counts_as_lost_beyond_one_and_a_half_periods() -> None:
    firmware = booted()
    # The counter runs before the first interrupt, which comes after none.
    firmware.board.cycles = 10 * PERIOD
    lost = FirmwareStatus.INTERRUPT_LOST | FirmwareStatus.DEADLINE_MISSED
    firmware.run(np.full(1, REFERENCE_UM))
    assert firmware.status == 0
    assert spent(firmware, BoardFault.LOST, PERIOD) == 0
    assert spent(firmware, BoardFault.LOST, PERIOD + PERIOD // 2) == 0
    assert spent(firmware, BoardFault.LOST, PERIOD + PERIOD // 2 + 1) == lost
    assert spent(firmware, BoardFault.LOST, 2 * PERIOD) == lost


def test_an_interrupt_is_late_beyond_its_budget() -> None:
    firmware = booted()
    assert spent(firmware, BoardFault.LATE, PERIOD) == 0
    assert spent(firmware, BoardFault.LATE, PERIOD + 1) == FirmwareStatus.DEADLINE_MISSED


@pytest.mark.parametrize(
    ("fault", "value", "status"),
    [
        (BoardFault.READING, np.nan, FirmwareStatus.FAULT_SENSOR),
        (BoardFault.OVERRUN, 0.0, FirmwareStatus.FAULT_DEADLINE),
    ],
)
def test_the_last_bad_sample_that_is_allowed_is_survived_and_the_next_is_a_fault(
    fault: BoardFault, value: float, status: FirmwareStatus
) -> None:
    for samples, faulty in ((BAD - 1, False), (BAD, True)):
        firmware = booted()
        firmware.fail(fault, value, after=1, samples=samples)
        firmware.run(np.full(samples + 2, REFERENCE_UM))
        assert (status in firmware.status) is faulty


@pytest.mark.parametrize("pause", [55, 56])
def test_a_leaky_count_falls_by_one_for_eight_good_samples(pause: int) -> None:
    """Seven bad samples leave the count at 7: 56 good ones forget it, 55 leave one."""
    bad = BAD
    firmware = booted()
    for _ in range(2):
        firmware.fail(BoardFault.OVERRUN, after=1, samples=bad - 1)
        firmware.run(np.full(bad - 1 + pause, REFERENCE_UM))
    # Of the second seven the last makes eight where one was left.
    assert (FirmwareStatus.FAULT_DEADLINE in firmware.status) is (pause == 55)


def test_readings_at_the_limits_of_the_sensor_count_and_beyond_them_do_not() -> None:
    """The first of two is a jump, which the second confirms."""
    confirmed, beyond = FirmwareStatus.SENSOR_JUMP, FirmwareStatus.SENSOR_RANGE
    for limit, away in ((-3.276, -np.inf), (13.1077, np.inf)):
        outside = np.nextafter(np.float32(limit), np.float32(away))
        for reading, status in ((np.float32(limit), confirmed), (outside, beyond)):
            firmware = booted()
            firmware.fail(BoardFault.READING, float(reading), after=1, samples=2)
            firmware.run(np.full(3, REFERENCE_UM))
            assert firmware.status == status
            assert bool(firmware.firmware.controller.watchdog.reading_um == reading) is (status == confirmed)


def test_a_stuck_sensor_is_a_fault_only_at_both_its_limits() -> None:
    """RISE from 0 V: sample k comes with k times the ramp on the output, and is the k-th that repeats the reading; 64
    of them and a 64th of the model's 140 V are needed."""
    for ramp_V, expected in ((1 / 16, 64), (35 / 1024, 64), (1 / 32, 70)):
        firmware = booted(Settings(power_samples=1, ramp_V=ramp_V))
        firmware.request(Request.START)
        firmware.run(np.full(2, REFERENCE_UM))
        firmware.fail(BoardFault.STUCK)
        state = firmware.run(np.full(90, REFERENCE_UM)).state
        assert int(np.argmax(state == State.TRIP)) == expected


def test_every_interrupt_serves_the_line_and_restarts_the_watchdog_once() -> None:
    firmware = booted()
    assert (firmware.board.enabled, firmware.board.served, firmware.board.alive) == (0, 0, 0)
    firmware.run(np.full(37, REFERENCE_UM))
    assert (firmware.board.enabled, firmware.board.served, firmware.board.alive) == (0, 37, 37)
    assert firmware.firmware.controller.samples == 37
