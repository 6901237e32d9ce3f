"""Frames, answers, images and settings in C: each function alone, by hand and at both sides of each limit."""

import functools
import struct
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fixtures.firmware_bench import ModelStage, model
from fixtures.tools import need
from hysgen.codegen.manifest import c_files
from hysgen.firmware import Label, Owner, build_id, decode, encode, firmware_model, pack, siphash
from hysgen.firmware.wire import LinkStatus, Settings, frame, payload
from hysgen.machine.native import Toolchain, build
from hysgen.model.disturbances.periodic import Periodic
from hysgen_lab.firmware import host
from hysgen_lab.firmware.host import HostFirmware, HostImage
from hysgen_lab.firmware.reference_models import extended

FUNCTIONS = (
    *("settings_check", "frame_init", "frame_take", "frame_make", "image_check"),
    *("link_init", "link_answer", "link_add", "link_add_text", "link_close"),
)
OWNER = Owner(bytes(range(3, 19)), 0x1122334455667788)
LEAST, LARGE = 1e-9, 1e30


@functools.cache
def opened() -> HostImage:
    """The host's image, which exports FUNCTIONS as well."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(host, "CALLED", (*host.CALLED, *(f"hysgen_{name}" for name in FUNCTIONS)))
        return HostImage.compile(model().name, firmware_model(model()))


def called(name: str, *arguments: Any) -> Any:
    return getattr(opened().library.lib, f"hysgen_{name}")(*arguments)


def new(kind: str, values: Any = None) -> Any:
    return opened().library.ffi.new(kind, values)


# Settings


def wrong_field(settings: Settings) -> str | None:
    """The field that is refused; settings: as the firmware has them, in float32."""
    firmware = HostFirmware(opened(), ModelStage(model()), settings)
    return firmware.settings_wrong


LOW_V, HIGH_V = model().u_min_V, model().u_max_V
BOARD_V = (-20.0, 120.0)
RANGE_UM = np.float32(model().grid.y_max_um) - np.float32(model().grid.y_min_um)
ROOMY = Settings(loop_low_V=0.0, low_V=BOARD_V[0], high_V=BOARD_V[1])
GAINS = (np.float32(1) - np.float32(0.1), np.float32(1) + np.float32(0.1))
RANGES = {
    "low_V": (BOARD_V[0], None),
    "high_V": (ROOMY.low_V, BOARD_V[1]),
    "off_V": (ROOMY.low_V, ROOMY.high_V),
    "step_V": (LEAST, (HIGH_V - LOW_V) / 16),
    "ramp_V": (140 / ROOMY.state_samples, ROOMY.step_V),
    "loop_low_V": (LOW_V, HIGH_V),
    "loop_high_V": ((HIGH_V - LOW_V) / 64, HIGH_V),
    "offset_um": (LEAST, RANGE_UM),
    "reference_step_um": (LEAST, RANGE_UM),
    "follow_um": (0.0, np.float32(0.16) * RANGE_UM),
    "reading_gain": GAINS,
    "output_gain": GAINS,
    "output_zero_V": (-7.0, 7.0),
}
COUNTS = {
    "state_samples": (None, 30_000_000),
    "hold_samples": (64, ROOMY.state_samples - 1),
    "power_samples": (1, ROOMY.state_samples - 1),
}


@pytest.mark.parametrize("name", RANGES)
def test_a_setting_is_possible_up_to_its_limits_and_refused_by_name_beyond_them(name: str) -> None:
    assert wrong_field(ROOMY) is None
    for limit, way in zip(RANGES[name], (-np.inf, np.inf), strict=True):
        if limit is not None:
            at = np.float32(limit)
            assert wrong_field(replace(ROOMY, **{name: float(at)})) != name
            assert wrong_field(replace(ROOMY, **{name: float(np.nextafter(at, np.float32(way)))})) == name


@pytest.mark.parametrize("name", COUNTS)
def test_a_count_is_possible_up_to_its_limits_and_refused_by_name_beyond_them(name: str) -> None:
    for limit, way in zip(COUNTS[name], (-1, 1), strict=True):
        if limit is not None:
            assert wrong_field(replace(ROOMY, **{name: limit})) != name
            if limit + way < 2**32:
                assert wrong_field(replace(ROOMY, **{name: limit + way})) == name


def test_the_loop_keeps_to_the_limits_of_the_output_where_they_are_the_narrower_ones() -> None:
    narrow = replace(ROOMY, low_V=10.0, high_V=60.0, off_V=10.0, loop_low_V=10.0, loop_high_V=60.0)
    assert wrong_field(narrow) is None
    assert wrong_field(replace(narrow, loop_low_V=9.9)) == "loop_low_V"
    assert wrong_field(replace(narrow, loop_high_V=60.1)) == "loop_high_V"


def test_the_limits_of_the_output_are_inside_the_converters_range_as_calibrated() -> None:
    """What is beyond it the converter leaves out, and tells nobody."""
    narrow = replace(ROOMY, low_V=-19.0, high_V=114.0)
    for calibration in ({"output_gain": 1.05}, {"output_zero_V": 5.0}):
        assert wrong_field(replace(narrow, **calibration)) is None
        assert wrong_field(replace(narrow, high_V=120.0, **calibration)) == "high_V"
    for calibration in ({"output_gain": 1.05}, {"output_zero_V": -5.0}):
        assert wrong_field(replace(narrow, low_V=-20.0, **calibration)) == "low_V"
    for beyond in ({"low_V": -21.0}, {"high_V": 121.0}):
        assert wrong_field(replace(ROOMY, output_gain=0.95, **beyond)) in beyond


def test_a_loop_of_no_stroke_is_refused() -> None:
    """A sensor that repeats its reading has the stroke of such a loop."""
    least_V = (HIGH_V - LOW_V) / 64
    for stroke_V, told in ((0.0, "loop_high_V"), (0.99 * least_V, "loop_high_V"), (1.01 * least_V, None)):
        assert wrong_field(replace(ROOMY, loop_low_V=30.0, loop_high_V=30.0 + stroke_V)) == told


def test_every_option_may_be_set_and_a_fifth_is_refused() -> None:
    assert wrong_field(replace(ROOMY, loop=True, learn=True, keep=True, no_offset=True)) is None
    assert wrong_field(replace(ROOMY, no_offset=2)) == "options"  # type: ignore[arg-type]


# Frames and answers


def taken(line: bytes) -> list[bytes]:
    """The payloads of the good frames on a line."""
    receiver, payloads = new("frame_t *"), []
    called("frame_init", receiver)
    for byte in line:
        count = called("frame_take", receiver, byte)
        if count:
            payloads.append(bytes(receiver.bytes[0:count]))
    return payloads


def made(body: bytes) -> bytes:
    wire = new("uint8_t [134]")
    return bytes(wire[0 : called("frame_make", body, len(body), wire)])


def test_c_and_python_make_the_same_frames_and_read_each_others() -> None:
    rng = np.random.default_rng(3)
    for length in (1, 2, 3, 64, 127, 128):
        for body in (bytes(length), rng.bytes(length), bytes(range(1, 1 + length)), b"\xff" * length):
            assert made(body) == frame(body)
            assert taken(made(body)) == [body]


def test_frames_beside_bad_ones_are_taken_and_bad_ones_are_not() -> None:
    good, long = bytes(range(128)), bytes(range(1, 130))
    cut, empty = frame(b"abcdef")[:-3] + b"\0", frame(b"")
    flipped = frame(b"abcdef").replace(b"c", b"C")
    longer = frame(good)[:-1] + b"\x03xy\0"  # what fits into the receiver is a good frame
    broken = (cut, empty, flipped, longer, b"\0\0", b"\x05\0", b"\xff\0")
    for bad in (frame(long), frame(bytes(129)), frame(b"\1" * 240), *broken):
        assert taken(bad) == []
        assert taken(frame(good) + bad + frame(b"next")) == [good, b"next"]
    assert made(long) == frame(long[:128]), "what is longer than a payload is cut"
    assert payload(frame(b"")[:-1]) is None


def test_an_answer_holds_its_head_words_and_text_and_nothing_beyond_its_room() -> None:
    link = new("link_t *")
    called("link_init", link)
    assert (link.length, link.wire_count, link.wire_sent, link.frame.count, link.frame.left) == (0, 0, 0, 0, 0)

    def sent() -> bytes | None:
        link.wire_sent = 9
        called("link_close", link)
        assert link.wire_sent == 0
        return payload(bytes(link.wire[0 : link.wire_count - 1]))

    called("link_answer", link, 5, 200, 3)
    called("link_add", link, 0x04030201)
    called("link_add_text", link, b"stage")
    assert sent() == bytes([0x85, 200, 3, 1, 2, 3, 4]) + b"stage"
    called("link_answer", link, 1, 2, 0)
    called("link_add_text", link, b"x" * 200)
    called("link_add", link, 7)
    assert sent() == bytes([0x81, 2, 0]) + b"x" * 125
    called("link_answer", link, 1, 2, 0)
    called("link_add_text", link, b"x" * 123)
    called("link_add", link, 0x0807_0605)
    assert sent() == bytes([0x81, 2, 0]) + b"x" * 123 + b"\5\6"


# Images


def resealed(words: dict[int, int], data: bytes) -> bytes:
    """The image with other words, under its right CRC and MAC."""
    body = bytearray(data[:-12])
    for at, word in words.items():
        struct.pack_into("<I", body, 4 * at, word)
    whole = bytes(body) + struct.pack("<I", zlib.crc32(body))
    return whole + struct.pack("<Q", siphash(OWNER.key, whole))


def checked(data: bytes, count: int | None = None) -> int:
    owner = new("image_owner_t *", {"key": OWNER.key_words, "device": OWNER.device_words})
    return int(called("image_check", data, len(data) if count is None else count, owner))


def test_each_word_of_an_images_head_has_the_answer_of_its_own() -> None:
    data = encode(model(), OWNER.key, Label(OWNER.device, build_id(model()), 7))
    assert checked(data) == 0
    assert checked(resealed({11: 0, 12: 99}, data)) == 0, "any build, any counter"
    answers = {0: 2, 1: 2, 2: 4, 3: 4, 4: 4, 5: 4, 6: 4, 7: 4, 8: 4, 9: 14, 10: 14, 11: 15}
    for at, answer in answers.items():
        (word,) = struct.unpack_from("<I", data, 4 * at)
        for other in (word + 1, word ^ 0x8000_0000):
            assert checked(resealed({at: other}, data)) == answer, at
    for count in (0, len(data) - 1, len(data) + 1):
        assert checked(data + bytes(1), count) == 1
    for tail, answer in ((-12, 3), (-9, 3), (-8, 13), (-4, 13), (-1, 13)):
        spoiled = bytearray(data)
        spoiled[tail] ^= 0x40
        assert checked(bytes(spoiled)) == answer


def test_numbers_of_an_image_are_zero_or_normal_and_of_a_size_up_to_a_million() -> None:
    decoded = decode(encode(model(), OWNER.key, Label(OWNER.device)))
    million, normal = np.float32(1e6), np.float32(2.0**-126)
    above, below = np.nextafter(million, np.float32(np.inf)), np.nextafter(normal, np.float32(0))
    rows = (decoded.bank.slope, decoded.bank.offset, decoded.bank.gain)
    for table, at in ((row, at) for row in rows for at in (0, row.size - 1)):
        kept = table[at]
        for number, answer in ((0.0, 0), (-0.0, 0), (million, 0), (above, 5), (normal, 0), (below, 5), (np.nan, 5)):
            for sign in (1.0, -1.0):
                table[at] = np.float32(sign) * np.float32(number)
                assert checked(pack(decoded, OWNER.key)) == answer, (at, number)
        table[at] = kept


def test_weights_of_an_image_become_those_of_the_bank_and_those_without_a_phase_are_zero() -> None:
    """At START the phase of a disturbance is unknown: neither build nor image of its model has a weight for it."""
    disturbed = replace(model(), terms=(Periodic((50.0,)),), weights=np.array([0.01, -0.02]))
    built = HostImage.compile(model().name, firmware_model(disturbed))
    firmware = HostFirmware(built, ModelStage(model()), owner=OWNER)
    weights, given = (
        firmware.firmware.controller.bank.rules.weight,
        decode(encode(disturbed, OWNER.key, Label(OWNER.device))),
    )
    assert [*weights, *given.bank.weight] == [0.0] * 4
    given.bank.weight[:] = [0.03, 0.04]
    assert firmware.send(pack(given, OWNER.key)) == 0
    assert [*weights] == np.float32([0.03, 0.04]).tolist()
    answer = payload(firmware.line(frame(bytes([5, 1])))[:-1])
    assert answer is not None
    assert struct.unpack_from("<2I", answer, 3 + 4 * 12) == (6, 2), "rules and weights of the identity"


@pytest.mark.parametrize("bits", [0x7F800000, 0x7F800001, 0x7FC00000, 0x7FFFFFFF, 0xFF800000, 0xFFBFFFFF])
def test_no_infinity_and_no_nan_is_a_reference_and_the_largest_number_is(bits: int) -> None:
    firmware = HostFirmware(opened(), ModelStage(model()))
    for word, code in ((bits, 3), (0x7F7FFFFF, 0), (0xFF7FFFFF, 0), (0x00000001, 0)):
        answer = payload(firmware.line(frame(bytes([3, 1]) + struct.pack("<I", word)))[:-1])
        assert answer == bytes([0x83, 1, code])


def test_after_power_on_every_number_of_the_status_is_that_of_a_stage_at_rest() -> None:
    """The memory holds arbitrary bytes before."""
    firmware = HostFirmware(opened(), ModelStage(model()), Settings(off_V=3.0))
    answer = payload(firmware.line(frame(bytes([1, 9])))[:-1])
    assert answer is not None
    said = vars(LinkStatus.unpack(answer[3:]))
    assert said.pop("output_V") == 3.0
    assert said.pop("reference_um") == np.float32(model().grid.y_min_um)
    assert {name: value for name, value in said.items() if value} == {}


@pytest.mark.parametrize("name", ["appendix_a", "extended"])
@pytest.mark.parametrize("level", ["-O2", "-O3"])
def test_the_self_test_passes_under_link_time_optimisation(name: str, level: str) -> None:
    """73 words differ, with all inlined, where the hash reads floats of a struct through a pointer to uint32_t."""
    need("gcc")
    toolchain = Toolchain("gcc", (level, "-flto", "-finline-limit=100000"))
    sources = c_files(firmware_model(model() if name == "appendix_a" else extended()))
    caller = f"#include <stdint.h>\nuint32_t {name}_selftest(void);\nuint32_t differing(void);\n"
    caller += f"uint32_t differing(void) {{ return {name}_selftest(); }}\n"
    built = build([*sources.items(), ("caller.c", caller)], "uint32_t differing(void);", toolchain)
    assert built.lib.differing() == 0
