"""Parameter images: running firmware accepts complete, fitting, certified ones and else keeps its parameters."""

# Safety case: [S9], [S10]

import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest

from fixtures.firmware_bench import KEY, ModelStage, booted, compiled, image, model, sine, tracking
from hysgen.api.models import design_loop
from hysgen.errors import ModelError
from hysgen.firmware import (
    ANSWERS,
    NO_KEY,
    Label,
    Owner,
    build_id,
    decode,
    encode,
    firmware_model,
    pack,
    siphash,
    structure_digest,
    with_learner,
)
from hysgen.firmware.wire import FirmwareStatus, Request, Settings, State
from hysgen.fitting import FitSettings
from hysgen.fitting.refit import refit
from hysgen.model.model import Model
from hysgen.record import Record
from hysgen_lab.firmware.host import FAULTS, SLOT_BYTES, HostFirmware, HostImage
from hysgen_lab.firmware.reference_models import TS_S, identified, laboratory, measured
from hysgen_lab.stage import StageState
from hysgen_lab.stage.signals import nested_amplitudes

STIFFER, SOFTER = np.array([1.0, 1.02, 1.0]), np.array([1.0, 0.98, 1.0])


def changed(consequents: np.ndarray) -> Model:
    """The model with its consequents q1, q2, q3 scaled."""
    return replace(model(), consequents=model().consequents * consequents)


def test_an_image_reads_back_and_its_numbers_become_the_bank_bit_for_bit() -> None:
    new = changed(STIFFER)
    data = encode(new, KEY)
    bank = decode(data).bank
    firmware = booted()
    before = firmware.bank()
    assert firmware.send(data) == 0
    values = np.concatenate([bank.slope, bank.offset, bank.gain, np.float32([0.002])])
    assert firmware.bank() == values.tobytes() != before


def test_an_image_brings_the_gain_of_the_feedback_up_to_half_of_its_margin() -> None:
    own, firmware = model().feedback, booted(Settings(loop=True))
    assert own is not None
    tried = [replace(own, integral=share * own.integral) for share in (1.41, 0.5, 1.39)]
    for counter, (loop, answer) in enumerate(
        [*zip(tried, (18, 0, 0), strict=True), (replace(own, limit_um=0.2), 4), (None, 4)], start=1
    ):
        assert firmware.send(encode(replace(model(), feedback=loop), KEY, Label(counter=counter))) == answer
    firmware.start(2.0)
    assert firmware.firmware.controller.model.loop.half == np.float32(0.002 * 1.39)
    assert firmware.firmware.controller.model.loop.correction_um != 0.0
    turned = replace(decode(encode(model(), KEY, Label(counter=9))), half=-1e-9)
    stop(firmware)
    assert firmware.send(pack(turned, KEY)) == 18


def test_an_image_cut_at_any_byte_or_with_any_bit_flipped_changes_nothing() -> None:
    firmware, data = booted(), encode(changed(STIFFER), KEY)
    good = firmware.bank()
    for length in range(len(data)):
        firmware.send(data[:length])
        assert firmware.bank() == good
    for bit in range(8 * len(data)):
        flipped = bytearray(data)
        flipped[bit // 8] ^= 1 << (bit % 8)
        assert firmware.send(bytes(flipped)) in (2, 3, 13)
        assert firmware.bank() == good
    assert FirmwareStatus.IMAGE_REFUSED in firmware.status
    assert firmware.send(data) == 0
    assert firmware.bank() != good


def test_bytes_of_a_broken_transfer_do_not_leak_into_the_next_one() -> None:
    firmware, data = booted(), encode(changed(STIFFER), KEY)
    firmware.send(data[:90])
    assert firmware.send(data) == 0
    firmware.send(data[:90])
    good = firmware.bank()
    other = encode(changed(SOFTER), KEY, Label(counter=2))
    assert firmware.send(other[90:], offset=90) == 3
    assert firmware.bank() == good


@pytest.mark.slow
def test_power_cut_at_any_byte_of_the_store_leaves_the_old_or_the_new_parameters() -> None:
    firmware = booted()
    first, second = encode(changed(STIFFER), KEY), encode(changed(SOFTER), KEY, Label(counter=2))
    assert firmware.send(first) == 0
    old = firmware.bank()
    kept = [bytes(firmware.slot(slot)) for slot in (0, 1)]
    whole = SLOT_BYTES + len(second) + 16
    outcomes = []
    for changes in range(whole + 1):
        for slot in (0, 1):
            firmware.slot(slot)[:] = kept[slot]
        firmware.boot()
        assert firmware.bank() == old
        firmware.board.bytes_to_cut = changes
        firmware.send(second)
        firmware.board.bytes_to_cut = 0xFFFFFFFF
        firmware.boot()
        outcomes.append(firmware.bank() == old)
    # The old parameters are valid until the last byte of the seal is written.
    assert outcomes == [True] * whole + [False]


def test_any_flipped_bit_of_the_newest_stored_image_falls_back_to_the_one_before() -> None:
    firmware = booted()
    first, second = encode(changed(STIFFER), KEY), encode(changed(SOFTER), KEY, Label(counter=2))
    firmware.send(first)
    old = firmware.bank()
    firmware.send(second)
    new = firmware.bank()
    slot = firmware.slot(firmware.firmware.store.slot)
    places = [*range(8 * len(second)), *range(8 * (SLOT_BYTES - 16), 8 * SLOT_BYTES)]
    for bit in places:
        was = slot[bit // 8]
        slot[bit // 8] = bytes([was[0] ^ (1 << (bit % 8))])
        firmware.boot()
        assert firmware.bank() == old
        slot[bit // 8] = was
    firmware.boot()
    assert firmware.bank() == new


def test_without_any_good_image_the_built_in_parameters_drive() -> None:
    firmware = booted()
    built_in = firmware.bank()
    firmware.send(encode(changed(STIFFER), KEY))
    rng = np.random.default_rng(6)
    firmware.slot(0)[:] = rng.bytes(SLOT_BYTES)
    firmware.slot(1)[:] = rng.bytes(SLOT_BYTES)
    firmware.boot()
    assert firmware.bank() == built_in


@pytest.mark.parametrize(
    ("consequents", "answer"),
    [((1.0, 0.03, 1.0), 10), ((1.0, -1.0, 1.0), 10), ((1.1, 1.0, 1.0), 11), ((1.0, 1.0, 1e4), 9)],
)
def test_whole_and_right_but_not_certified_is_refused(consequents: tuple[float, ...], answer: int) -> None:
    firmware = booted()
    good = firmware.bank()
    assert firmware.send(encode(changed(np.array(consequents)), KEY)) == answer, ANSWERS[answer]
    assert firmware.bank() == good
    assert FirmwareStatus.IMAGE_REFUSED in firmware.status


def test_numbers_of_another_partition_or_range_are_refused() -> None:
    own = model()
    wider = replace(own, grid=replace(own.grid, y_max_um=own.grid.y_max_um + 0.001))
    higher = replace(own, u_max_V=own.u_max_V - 1.0)
    for foreign in (wider, higher, replace(own, name="other")):
        assert booted().send(encode(foreign, KEY)) == 4


def test_an_image_that_arrives_while_the_stage_moves_waits_until_it_is_off() -> None:
    firmware = tracking()
    good, data = firmware.bank(), encode(changed(STIFFER), KEY)
    firmware.send(data)
    firmware.run(sine(2000))
    assert firmware.state is State.TRACK
    assert firmware.bank() == good
    stop(firmware)
    assert firmware.bank() != good
    assert firmware.firmware.image_answer == 0


@pytest.mark.slow
def test_a_refit_over_the_same_range_is_an_image_that_running_firmware_takes() -> None:
    drive_V = nested_amplitudes(TS_S, (100.0, 50.0), 40.0, 15.0, 4)
    old = with_learner(identified(drive_V, FitSettings(name="refitted", method="batch")))
    old = design_loop(old).around(old)
    # A second record inside the range of the first, of a stage that has lost 3 % of its gain.
    again_V = nested_amplitudes(TS_S, (70.0,), 40.0, 12.0, 5)
    record = measured(again_V)
    weaker = Record.from_arrays(again_V, 0.97 * record.segments[0].y_um + 0.04, TS_S, source="weaker")
    new, _ = refit(old, weaker, same_range=True)
    assert structure_digest(new) == structure_digest(old)
    assert structure_digest(refit(old, weaker)[0]) != structure_digest(old)
    refitted = HostImage.compile(old.name, firmware_model(old))
    firmware = HostFirmware(refitted, StageState(laboratory(), TS_S, 1), owner=Owner(KEY))
    before = firmware.bank()
    assert firmware.send(encode(new, KEY)) == 0
    assert firmware.bank() != before


def stop(firmware: HostFirmware) -> None:
    """Stop, and run until the state is OFF."""
    firmware.request(Request.STOP)
    firmware.run(np.full(4000, 2.0))
    assert firmware.state is State.OFF


@pytest.mark.parametrize("asked", [Request.START, Request.RECORD])
def test_a_start_during_the_writing_of_an_image_waits_until_its_numbers_drive(asked: Request) -> None:
    firmware = booted()
    firmware.firmware.controller.play.count = 9
    old, data = firmware.bank(), encode(changed(STIFFER), KEY)
    firmware.preempt_store(asked)
    assert firmware.send(data) == 0
    new = firmware.bank()
    assert new != old
    assert firmware.state is State.OFF
    firmware.run(np.full(4, 2.0))
    assert firmware.state is State.POWER
    firmware.boot()
    assert firmware.bank() == new


def test_a_fault_during_the_writing_of_an_image_does_not_lose_it() -> None:
    firmware = booted()
    old, data = firmware.bank(), encode(changed(STIFFER), KEY)
    firmware.firmware.controller.status |= int(FirmwareStatus.FAULT_SENSOR)
    firmware.preempt_store(Request.STOP)
    assert firmware.send(data) == 0
    assert firmware.bank() != old


def test_a_refusal_behind_a_clear_is_told() -> None:
    """The interrupt takes the CLEAR while the image is being written: the next idle loop took the refusal with it."""
    firmware, data = booted(), encode(changed(STIFFER), KEY)
    firmware.preempt_store(Request.CLEAR)
    firmware.board.bytes_to_cut = 9
    assert firmware.send(data) != 0
    firmware.run(np.full(2, 2.0))
    assert FirmwareStatus.IMAGE_REFUSED in firmware.status


def test_memory_that_keeps_another_bit_than_it_was_given_is_told_and_changes_nothing() -> None:
    firmware = booted()
    old, slot = firmware.bank(), firmware.slot(0)
    ffi = firmware.image.library.ffi
    flip = ffi.callback("void(void *)", lambda _: ffi.memmove(slot, bytes(slot[:80]) + bytes([slot[80][0] ^ 1]), 81))
    firmware.board.preempt = flip
    assert firmware.send(encode(changed(STIFFER), KEY)) == 3, ANSWERS[3]
    firmware.boot()
    assert (firmware.bank(), firmware.firmware.store.counter) == (old, 0)


def test_stray_bytes_behind_a_waiting_image_do_no_harm() -> None:
    firmware, data = tracking(), encode(changed(STIFFER), KEY)
    good = firmware.bank()
    firmware.send(data)
    firmware.line(b"\n\0\xff\0")
    firmware.send(b"\n", offset=len(data))
    assert FirmwareStatus.IMAGE_REFUSED not in firmware.status
    stop(firmware)
    assert firmware.bank() != good
    firmware.line(b"noise\0")
    firmware.send(b"noise", offset=len(data) - 5)
    assert FirmwareStatus.IMAGE_REFUSED not in firmware.status


def test_a_refused_image_is_told_until_clear_and_no_longer() -> None:
    firmware, data = booted(), encode(changed(STIFFER), KEY)
    firmware.send(b"x" * len(data))
    assert FirmwareStatus.IMAGE_REFUSED in firmware.status
    firmware.request(Request.CLEAR)
    firmware.run(np.full(2, 2.0))
    assert firmware.status == 0
    assert firmware.send(data) == 0


def test_an_image_that_is_in_use_is_not_written_again() -> None:
    firmware, data = booted(), encode(changed(STIFFER), KEY)
    assert firmware.send(data) == 0
    kept = [bytes(firmware.slot(slot)) for slot in (0, 1)]
    bank = firmware.bank()
    for _ in range(3):
        assert firmware.send(data) == 0
    assert [bytes(firmware.slot(slot)) for slot in (0, 1)] == kept
    assert firmware.bank() == bank
    # With a damaged seal it is no longer in use.
    firmware.slot(firmware.firmware.store.slot)[SLOT_BYTES - 1 : SLOT_BYTES] = b"\0"
    assert firmware.send(data) == 0
    firmware.boot()
    assert firmware.bank() == bank


OWNER = Owner(KEY, 0x1122334455667788)


def owned() -> HostFirmware:
    """The image of an owner with a key and a device number, which has taken an image with counter 5."""
    firmware = HostFirmware(image(), ModelStage(model()), owner=OWNER)
    assert firmware.send(encode(changed(STIFFER), KEY, Label(OWNER.device, build_id(model()), 5))) == 0
    return firmware


SOFT = changed(SOFTER)
ATTACKS = {
    "flipped, CRC made right": (lambda: forged(encode(SOFT, KEY, Label(OWNER.device, 0, 6))), 13),
    "without the key": (lambda: keyless(encode(SOFT, KEY, Label(OWNER.device, 0, 6))), 13),
    "another key": (lambda: encode(SOFT, KEY[::-1], Label(OWNER.device, 0, 6)), 13),
    "of another device": (lambda: encode(SOFT, KEY, Label(OWNER.device ^ 1, 0, 6)), 14),
    "of a device with another high word": (lambda: encode(SOFT, KEY, Label(OWNER.device ^ 1 << 40, 0, 6)), 14),
    "of a device without a number": (lambda: encode(SOFT, KEY, Label(0, 0, 6)), 14),
    "for another build": (lambda: encode(SOFT, KEY, Label(OWNER.device, build_id(SOFT), 6)), 15),
    "same counter": (lambda: encode(SOFT, KEY, Label(OWNER.device, 0, 5)), 16),
    "an older one, replayed": (lambda: encode(SOFT, KEY, Label(OWNER.device, 0, 4)), 16),
    "cut": (lambda: encode(SOFT, KEY, Label(OWNER.device, 0, 6))[:-9], 0),
    "of another structure": (lambda: encode(replace(SOFT, u_max_V=50.0), KEY, Label(OWNER.device, 0, 6)), 4),
    "of wild numbers": (lambda: encode(changed(np.array([1.0, -1.0, 1.0])), KEY, Label(OWNER.device, 0, 6)), 10),
}


def forged(data: bytes) -> bytes:
    """The image with one bit of a number flipped and its CRC computed anew, by someone without the key."""
    body = bytearray(data[:-12])
    body[-6] ^= 1
    return bytes(body) + struct.pack("<I", zlib.crc32(bytes(body))) + data[-8:]


def keyless(data: bytes) -> bytes:
    """The image with the MAC under a key of zeros."""
    return data[:-8] + struct.pack("<Q", siphash(NO_KEY, data[:-8]))


def test_a_key_of_zeros_takes_no_image_and_no_image_is_made_with_it() -> None:
    firmware = HostFirmware(image(), ModelStage(model()), owner=Owner(NO_KEY))
    assert firmware.send(keyless(encode(SOFT, KEY))) == 17, ANSWERS[17]
    with pytest.raises(ModelError, match="a key of zeros is no secret"):
        encode(SOFT, NO_KEY)


@pytest.mark.parametrize("attack", ATTACKS)
def test_an_attackers_image_is_refused_and_changes_nothing(attack: str) -> None:
    made, answer = ATTACKS[attack]
    firmware = owned()
    bank = firmware.bank()
    kept = [bytes(firmware.slot(slot)) for slot in (0, 1)]
    assert firmware.send(made()) == answer, ANSWERS[answer]
    assert firmware.bank() == bank
    assert [bytes(firmware.slot(slot)) for slot in (0, 1)] == kept
    firmware.boot()
    assert firmware.bank() == bank
    assert firmware.send(encode(SOFT, KEY, Label(OWNER.device, 0, 5))) == 16, "the counter survives power off"
    assert firmware.send(encode(SOFT, KEY, Label(OWNER.device, 0, 6))) == 0
    assert firmware.bank() != bank


@pytest.mark.parametrize("row", ["slope", "offset", "gain", "half"])
def test_start_drives_with_no_parameters_but_those_that_were_meant(row: str) -> None:
    """A skipped instruction of the idle loop made a pointer wild, which moved the bank by a word: START took it."""
    firmware = booted()
    bank = firmware.firmware.controller.bank
    if row == "half":
        bank.half = np.nextafter(np.float32(bank.half), np.float32(9.0))
    else:
        words = getattr(bank.rules, row)
        words[3] = np.nextafter(np.float32(words[3]), np.float32(9.0))
    for _ in range(2):
        firmware.start(2.0)
        assert (firmware.state, firmware.status & FAULTS) == (State.TRIPPED, FirmwareStatus.FAULT_MEMORY)
        firmware.request(Request.CLEAR)
        firmware.run(np.full(2, 2.0))
    assert firmware.send(encode(changed(STIFFER), KEY)) == 0
    firmware.start(2.0)
    assert firmware.state is State.TRACK


def test_learned_parameters_are_kept_over_stop_if_the_settings_say_so() -> None:
    for keep in (False, True):
        settings = Settings(learn=True, keep=keep)
        firmware = HostFirmware(image(), ModelStage(changed(SOFTER)), settings)
        built_in = firmware.bank()
        firmware.start(2.0)
        firmware.run(sine(12_000))
        assert firmware.firmware.commits > 0
        stop(firmware)
        assert (firmware.bank() != built_in) == keep
        firmware.boot()
        assert firmware.bank() == built_in


def test_the_counter_survives_a_new_build_and_cannot_be_used_up() -> None:
    """An image for the build before is refused at boot, but its counter holds."""
    firmware = owned()
    assert firmware.send(encode(SOFT, KEY, Label(OWNER.device, build_id(model()), 50))) == 0
    newer = replace(model(), consequents=model().consequents * [1.0, 0.99, 1.0])
    rebuilt = HostFirmware(compiled(newer), ModelStage(model()), owner=OWNER)
    for slot in (0, 1):
        rebuilt.slot(slot)[:] = bytes(firmware.slot(slot))
    rebuilt.boot()
    assert (rebuilt.firmware.store.counter, rebuilt.firmware.store.slot) == (50, 0xFFFFFFFF)
    for counter, answer in ((2, 16), (50, 16), (51 + 65_536, 16), (0xFFFFFFFF, 16), (50 + 65_536, 0)):
        assert rebuilt.send(encode(SOFT, KEY, Label(OWNER.device, 0, counter))) == answer, counter
