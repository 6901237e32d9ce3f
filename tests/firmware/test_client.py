"""The client: what it asks, how long it waits, what it says of each answer; numbers that Python shares with C."""

import hashlib
import re
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fixtures.firmware_bench import KEY, model
from hysgen.errors import HysgenError, ModelError
from hysgen.firmware import (
    ANSWERS,
    CONTROLLER,
    HOST_BOARD,
    Label,
    Owner,
    ParameterImage,
    build_id,
    decode,
    encode,
    link,
    pack,
    read_key,
    read_sources,
)
from hysgen.firmware.link import Client
from hysgen.firmware.wire import (
    ANSWER,
    CHUNK,
    CODES,
    SETTINGS_BYTES,
    Command,
    FirmwareStatus,
    Identity,
    LinkStatus,
    Request,
    State,
    frame,
    payload,
)
from hysgen.float32.coefficients import Bank
from hysgen.model.file import dump_model
from hysgen_lab.firmware.host import FAULTS, BoardFault

WORDS = (5, 0x13, 0x40000, 77, *(0,) * 4, 0, 0, 640, 8, 1, 2, 300, 4, 500, 600, 7, 6000, 0x7FC00000)


def status(**fields: int) -> bytes:
    names = list(LinkStatus.__dataclass_fields__)
    words = list(WORDS)
    for name, value in fields.items():
        words[names.index(name)] = value
    return struct.pack("<21I", *words)


class Scripted:
    """A line whose other end answers (kind, number, data) by `reply`: code and data, or None for silence."""

    def __init__(self, reply: Callable[[int, int, bytes], bytes | None]) -> None:
        self.reply, self.asked, self.answers, self.closed = reply, list[tuple[int, int, bytes]](), b"", False

    def write(self, data: bytes) -> int:
        body = payload(data[:-1])
        assert body is not None
        self.asked.append((body[0], body[1], body[2:]))
        answer = self.reply(*self.asked[-1])
        if answer is not None:
            self.answers += frame(bytes([body[0] | ANSWER, body[1]]) + answer)
        return len(data)

    def read(self, size: int = 1) -> bytes:
        taken, self.answers = self.answers[:size], self.answers[size:]
        return taken

    def close(self) -> None:
        self.closed = True


def client(reply: Callable[[int, int, bytes], bytes | None]) -> tuple[Client, Scripted]:
    line = Scripted(reply)
    return Client(line, timeout_s=0.002), line


def test_commands_carry_their_data_and_numbers_that_wrap() -> None:
    asking, line = client(lambda kind, *_: b"\0" + (status() if kind == Command.STATUS else b""))
    with asking:
        asking.request(Request.STOP)
        asking.reference(2.5)
        asking.reference(None)
        assert asking.status() == LinkStatus(5, 0x13, 0x40000, 77, 0.0, 0.0, 0.0, 0.0, *WORDS[8:-1], None)
        for _ in range(252):
            asking.status()
    assert line.asked[:3] == [(2, 1, b"\x02"), (3, 2, struct.pack("<f", 2.5)), (3, 3, b"")]
    assert [number for _, number, _ in line.asked[253:]] == [254, 255, 0]
    assert line.closed


@pytest.mark.parametrize("silent", [0, 3, 4])
def test_a_command_is_sent_four_times_under_one_number(silent: int) -> None:
    calls = iter(range(9))
    asking, line = client(lambda *_: None if next(calls) < silent else b"\0")
    if silent < 4:
        asking.request(Request.START)
    else:
        with pytest.raises(HysgenError, match="REQUEST: no answer in 4 tries"):
            asking.request(Request.START)
    assert line.asked == [(2, 1, b"\x01")] * min(silent + 1, 4)


def test_an_answer_is_waited_for_half_a_second_in_each_try(monkeypatch: pytest.MonkeyPatch) -> None:
    line, now = Scripted(lambda *_: None), [100.0]

    def read(size: int = 1) -> bytes:
        now[0] += 0.125
        return b""

    monkeypatch.setattr(line, "read", read)
    monkeypatch.setattr(link.time, "monotonic", lambda: now[0])
    with pytest.raises(HysgenError, match="no answer in 4 tries"):
        Client(line).status()
    assert now[0] == 100.0 + 4 * 0.5


def test_every_refusal_is_an_error_with_its_reason() -> None:
    for code in range(len(CODES) + 1):
        asking, _ = client(lambda *_, code=code: bytes([code]))
        if code == 0:
            asking.reference(1.0)
            continue
        reason = CODES[code] if code < len(CODES) else f"code {code}"
        with pytest.raises(HysgenError, match=f"^REFERENCE: refused: {reason}$"):
            asking.reference(1.0)


def test_answers_to_another_command_and_noise_are_passed_over() -> None:
    asking, line = client(lambda *_: b"\0" + status(state=2))
    line.answers = b"noise\0" + frame(bytes([0x81, 9, 0])) + frame(b"\x81\x01") + frame(bytes([0x82, 1, 0]))
    assert asking.status().state == 2


def test_the_identity_of_another_version_is_refused() -> None:
    for protocol in (link.PROTOCOL, 3):
        own = (20_000, 3, 640, 6, 2, 0.5, 4.0, -20.0, 120.0, -20.0, 120.0, -3.0, 13.0, 4096)
        words = struct.pack("<6IQI5I8fI", protocol, 1, 2, 3, 4, 5, 6, 1, *own)[: None if protocol != 3 else 80]
        asking, _ = client(lambda *_, words=words: b"\0" + words + b"stage")
        if protocol != 3:
            found = asking.identity()
            expected = Identity(protocol, (1, 2, 3, 4), 5, 6, True, *own, "stage")
            assert found == expected
            assert vars(found) == vars(expected)
        else:
            with pytest.raises(HysgenError, match="version 3 of the link, this hysgen 6"):
                asking.identity()


def installing(pending: int, state: int, answer: int = 0) -> tuple[Client, Scripted]:
    """A client of firmware that has an image waiting at the first `pending` times that it is asked."""
    left = iter(range(10**6))

    def reply(kind: int, number: int, data: bytes) -> bytes:
        if kind != Command.STATUS:
            return b"\0"
        return b"\0" + status(state=state, image_pending=int(next(left) < pending), image_answer=answer)

    return client(reply)


def test_an_image_is_sent_in_pieces_waited_for_and_its_answer_is_said() -> None:
    shares: list[float] = []
    asking, line = installing(2, State.OFF)
    data = bytes(range(150))
    assert asking.install(data, shares.append).image_pending == 0
    pieces = [data for kind, _, data in line.asked if kind == Command.IMAGE]
    assert pieces == [struct.pack("<I", at) + data[at : at + CHUNK] for at in (0, 64, 128)]
    assert shares == pytest.approx([64 / 150, 128 / 150, 1.0])
    assert [kind for kind, *_ in line.asked[3:]] == [Command.STATUS] * 3
    for answer, words in ((13, "the image is refused: its MAC"), (99, "the image is answered by 99")):
        with pytest.raises(ModelError, match=words):
            installing(0, State.OFF, answer)[0].install(data)


@pytest.mark.parametrize(
    ("state", "words"),
    [(State.TRACK, "waits until STOP"), (State.OFF, "does not take it"), (State.TRIPPED, "does not take it")],
)
def test_an_image_is_waited_for_ten_seconds(state: State, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    waiting = LinkStatus.unpack(status(state=state, image_pending=1))

    def a_second_later() -> LinkStatus:
        now[0] += 1.0
        return waiting

    asking, _ = installing(0, state)
    monkeypatch.setattr(link.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(asking, "status", a_second_later)
    with pytest.raises(HysgenError, match=words):
        asking.install(bytes(10))
    assert now[0] == 111.0, "ten seconds are waited, at eleven it is over"


def test_a_models_image_is_labelled_as_the_firmware_tells() -> None:
    parts: list[bytes] = []
    words = struct.pack("<6IQI5I8fI", link.PROTOCOL, 1, 2, 3, 4, 55, 1 << 40, 1, *(0,) * 14)

    def reply(kind: int, number: int, data: bytes) -> bytes:
        parts.append(data[4:] if kind == Command.IMAGE else b"")
        answers = {Command.IDENTIFY: words, Command.STATUS: status(counter=8, state=0)}
        answers[Command.KEPT] = struct.pack("<I", SETTINGS_BYTES) + settings[data[0] if data else 0 :][:64]
        return b"\0" + answers.get(Command(kind), b"")

    key, settings = bytes(range(16)), bytes(range(100, 172))
    client(reply)[0].install_model(model(), key)
    sent = decode(b"".join(parts), key=key)
    assert (sent.label, sent.settings) == (Label(1 << 40, 55, 9), settings)


# Images


def test_an_image_gives_back_every_number_with_more_weights_than_rules() -> None:
    slope, offset, gain = np.arange(1, 7, dtype=np.float32).reshape(3, 2)
    bank = Bank(slope=slope, offset=offset, gain=gain, weight=np.arange(7, 12, dtype=np.float32))
    data = pack(ParameterImage((1, 2, 3, 4), bank, Label(1 << 33, 5, 6)), KEY)
    assert struct.unpack_from("<9IQ2I", data) == (0x49535948, 4, len(data), 1, 2, 3, 4, 2, 5, 1 << 33, 5, 6)
    assert struct.unpack_from("<11f", data, 52) == tuple(range(1, 12))
    assert len(data) == 4 * (13 + 11 + 1 + 18 + 3)
    back = decode(data, key=KEY)
    assert (back.digest, back.label) == ((1, 2, 3, 4), Label(1 << 33, 5, 6))
    for name in ("slope", "offset", "gain", "weight"):
        assert getattr(back.bank, name).tolist() == getattr(bank, name).tolist()
    with pytest.raises(ModelError, match="47 bytes are no parameter image"):
        decode(bytes(47))
    for at, words in (
        (0, "not a parameter image of version 4"),
        (4, "version 4"),
        (28, "its header says"),
        (60, "CRC"),
    ):
        spoiled = bytearray(data)
        spoiled[at] ^= 1
        with pytest.raises(ModelError, match=words):
            decode(bytes(spoiled))


def test_a_key_is_the_first_line_of_its_file(tmp_path: Path) -> None:
    file = tmp_path / "key"
    file.write_text("  000102030405060708090a0b0c0d0eFF \nnote\n")
    assert read_key(file) == bytes([*range(15), 255])
    for text in ("00" * 15, "00" * 17, "xy" * 16, ""):
        file.write_text(text)
        with pytest.raises(ModelError, match="no 32 hexadecimal digits"):
            read_key(file)
    with pytest.raises(ModelError, match="cannot be read"):
        read_key(tmp_path / "none")
    owner = Owner(bytes(range(16)), 0x1122334455667788)
    assert owner.key_words == [0x03020100, 0x07060504, 0x0B0A0908, 0x0F0E0D0C]
    assert owner.device_words == [0x55667788, 0x11223344]


# Numbers of the C


def defined(prefix: str) -> dict[str, int]:
    """Numbers of the macros and enumerators of the firmware that begin with `prefix`, by the rest of their names."""
    text = "\n".join(text for folder in (CONTROLLER, HOST_BOARD) for _, text in read_sources(folder))
    found = re.findall(rf"^(?:#define|   ) *{prefix}(\w+) +(?:= )?(0x\w+?|\d+)u?,?(?: |$)", text, re.M)
    return {name: int(number, 0) for name, number in found}


def test_states_bits_and_faults_are_those_of_the_c() -> None:
    status = defined("STATUS_")
    assert status.pop("FAULTS") == FAULTS
    assert status == {each.name: each.value for each in FirmwareStatus}
    controller = defined("CONTROLLER_")
    assert {name: controller[name] for name in State.__members__} == {each.name: each.value for each in State}
    assert {name: controller[name] for name in Request.__members__} == {each.name: each.value for each in Request}
    faults = defined("HOST_FAULT_")
    assert faults == {each.name: each.value for each in BoardFault}


def test_commands_codes_and_answers_are_those_of_the_c() -> None:
    wire = defined("LINK_")
    assert {name: wire[name] for name in Command.__members__} == {each.name: each.value for each in Command}
    assert (wire["ANSWER"], wire["CHUNK"], wire["VERSION"]) == (ANSWER, CHUNK, link.PROTOCOL)
    assert [CODES[wire[name]] for name in ("DONE", "UNKNOWN", "LENGTH", "VALUE")] == list(CODES)
    assert (wire["STATUS_WORDS"], wire["IDENTITY_WORDS"]) == (len(LinkStatus.__dataclass_fields__), 23)
    names = ("GOOD", "INCOMPLETE", "UNKNOWN", "DAMAGED", "FOREIGN", "NO_NUMBER", "NOT_STORED")
    names += ("FORGED", "STRANGE", "OTHER_BUILD", "REPLAYED", "KEYLESS", "RISKY")
    image = defined("IMAGE_")
    # Of the model's commit, answers 2 to 5 refuse (image.h).
    assert set(ANSWERS) == {image[name] for name in names} | {image["UNCERTIFIED"] + answer for answer in range(2, 6)}
    words = {"INCOMPLETE": "bytes are missing", "DAMAGED": "CRC", "FORGED": "MAC", "STRANGE": "another device"}
    words |= {"OTHER_BUILD": "another build", "REPLAYED": "counter", "NOT_STORED": "no memory", "NO_NUMBER": "finite"}
    words |= {"KEYLESS": "all zeros", "RISKY": "settings"}
    for name, phrase in words.items():
        assert phrase in ANSWERS[image[name]]


def test_a_build_is_the_first_word_of_the_digest_of_its_model_file() -> None:
    assert build_id(model()) == int(hashlib.sha256(dump_model(model()).encode()).hexdigest()[:8], 16)
    assert encode(model(), KEY, Label(build=build_id(model())))[44:48] == struct.pack("<I", build_id(model()))
