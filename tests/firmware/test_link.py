"""The command link: the client drives the firmware over a pseudo-terminal, and over a line that spoils bytes."""

# Safety case: [S11]

import contextlib
import json
import os
import pty
import threading
import tty
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fixtures.c674x_compiler import need_compiler
from fixtures.firmware_bench import Direct, ModelStage, image, model
from fixtures.tools import library
from hysgen.cli.main import main
from hysgen.errors import HysgenError, ModelError
from hysgen.firmware import ANSWERS, Label, Owner, build_id, encode, firmware_model, structure_digest
from hysgen.firmware.link import Client
from hysgen.firmware.wire import (
    ANSWER,
    Command,
    LinkStatus,
    Request,
    Settings,
    State,
    command,
    frame,
    image_frames,
    payload,
)
from hysgen_c674x.firmware.target import compile_image
from hysgen_lab.firmware.host import BoardFault, HostFirmware

OWNER = Owner(bytes(range(16)), 0xABCDEF)
QUICK = Settings(hold_samples=256, ramp_V=0.5)


def owned(settings: Settings = QUICK) -> HostFirmware:
    return HostFirmware(image(), ModelStage(model()), settings, OWNER)


@contextlib.contextmanager
def on_a_terminal(firmware: HostFirmware) -> Iterator[str]:
    """The firmware running at the other end of a pseudo-terminal; yields its port."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    end = threading.Event()

    def runs() -> None:
        while not end.is_set():
            with contextlib.suppress(BlockingIOError):
                os.write(master, firmware.line(os.read(master, 256)))
            firmware.run(np.full(20, 2.0))

    thread = threading.Thread(target=runs)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        end.set()
        thread.join()
        os.close(master)
        os.close(slave)


def answered(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, object]:
    assert main(["link", *words, "--json", "-"]) == 0
    told = capsys.readouterr().out
    return dict(json.loads(told[told.index("{") :]))


def until(
    capsys: pytest.CaptureFixture[str], port: str, reached: Callable[[dict[str, object]], bool], tries: int = 60
) -> None:
    """Ask for the status until it is as wanted."""
    told: dict[str, object] = {}
    for _ in range(tries):
        told = answered(capsys, port)
        if reached(told):
            return
    raise AssertionError(told)


@pytest.mark.slow
def test_the_verb_drives_firmware_over_a_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    library("serial")
    firmware = owned()
    (tmp_path / "key").write_text(OWNER.key.hex())
    softer = replace(model(), consequents=model().consequents * [1.0, 0.98, 1.0])
    file = tmp_path / "image"
    file.write_bytes(encode(softer, OWNER.key, Label(OWNER.device, 0, 1)))
    with on_a_terminal(firmware) as port:
        told = answered(capsys, port, "identify")
        assert told["name"] == model().name
        assert told["device"] == OWNER.device
        assert told["keyed"] is True
        assert answered(capsys, port, "image", str(file))["counter"] == 1
        answered(capsys, port, "start")
        until(capsys, port, lambda told: told["state"] == State.TRACK)
        answered(capsys, port, "reference", "2.2")
        until(capsys, port, lambda told: abs(float(str(told["reading_um"])) - 2.2) < 0.1)
        answered(capsys, port, "reference")
        answered(capsys, port, "stop")
        until(capsys, port, lambda told: told["state"] == State.OFF)
        # The same image again is in use: accepted. An unknown action and a wrong number are one line each.
        assert answered(capsys, port, "image", str(file))["image_answer"] == 0
        assert main(["link", port, "reference", "high"]) == 2
        assert "is no number" in capsys.readouterr().err


def test_a_line_that_loses_and_changes_bytes_neither_starts_nor_installs_anything_else() -> None:
    firmware = owned()
    data = encode(model(), OWNER.key, Label(OWNER.device, build_id(model()), 7))
    client = Client(Direct(firmware, loss=0.01), timeout_s=0.002)
    for _ in range(20):
        with contextlib.suppress(HysgenError):
            client.install(data)
            break
    assert firmware.firmware.store.counter == 7
    assert firmware.state is State.OFF
    assert firmware.bank() == HostFirmware(image(), ModelStage(model())).bank()


def test_any_bytes_on_the_line_change_nothing() -> None:
    firmware, rng = owned(), np.random.default_rng(9)
    bank = firmware.bank()
    for _ in range(300):
        firmware.line(rng.bytes(int(rng.integers(1, 400))))
        firmware.line(frame(bytes([9, 0]) + rng.bytes(int(rng.integers(0, 126)))))
    firmware.run(np.full(10, 2.0))
    assert firmware.state is State.OFF
    assert firmware.bank() == bank
    assert Client(Direct(firmware)).status().state == State.OFF


@pytest.mark.parametrize(
    ("kind", "data", "code"),
    [
        (Command.REQUEST, b"", 2),
        (Command.REQUEST, b"\x05", 3),
        (Command.RECORD, b"", 2),
        (Command.REQUEST, b"\x01\x01", 2),
        (Command.REFERENCE, b"\0\0\0\xff\xff", 2),
        (Command.REFERENCE, b"\0\0\x80\x7f", 3),
        (Command.STATUS, b"\0", 2),
        (Command.IMAGE, b"\0\0\0\0", 2),
        (Command.IMAGE, b"\0\0\0\0" + bytes(65), 2),
        (Command.IMAGE, b"\x08\0\0\0" + bytes(8), 3),
        (Command.IMAGE, b"\xff\xff\xff\xff" + bytes(8), 3),
        (10, b"", 1),
        (Command.KEPT, b"", 2),
    ],
    ids=lambda value: value.hex() if isinstance(value, bytes) else str(value),
)
def test_a_wrong_command_is_answered_and_changes_nothing(kind: int, data: bytes, code: int) -> None:
    firmware = owned()
    answer = payload(firmware.line(frame(bytes([kind, 77]) + data))[:-1])
    assert answer == bytes([kind | ANSWER, 77, code])
    firmware.run(np.full(3, 2.0))
    assert firmware.state is State.OFF


def test_the_identity_is_that_of_the_build() -> None:
    found = Client(Direct(owned())).identity()
    assert found.digest == structure_digest(model())
    assert found.build == build_id(model())
    assert (found.period_ns, found.preview, found.rules) == (20_000, 0, 6)
    assert found.image_bytes == len(encode(model(), OWNER.key))


def test_the_last_piece_once_more_is_done_and_installs_nothing_again() -> None:
    """Its answer was lost: the repeat was refused, and the client said that the image was."""
    firmware = owned()
    frames = list(image_frames(encode(model(), OWNER.key, Label(OWNER.device, 0, 1))))
    codes = [payload(firmware.line(each)[:-1]) for each in [*frames, frames[-1]]]
    assert {code[2] for code in codes if code is not None} == {0}
    assert (firmware.firmware.store.counter, firmware.firmware.image_pending) == (1, 0)


def test_stop_is_obeyed_in_a_flood_of_other_commands() -> None:
    """The line takes a byte an interrupt each way; an answer to STATUS is ten times as long as the question."""
    firmware = owned()
    firmware.start(2.0)
    flood, stop = command(Command.STATUS), command(Command.REQUEST, 1, bytes([Request.STOP]))
    for byte in 20 * flood + stop + 20 * flood:
        taken = firmware.image.library.ffi.new("uint8_t []", [byte])
        firmware.board.incoming, firmware.board.incoming_count, firmware.board.outgoing_count = taken, 1, 511
        firmware.image.library.lib.hysgen_firmware_idle(firmware.firmware, firmware.board)
    firmware.run(np.full(3000, 2.0))
    assert firmware.state is State.OFF


def test_a_reference_with_a_lease_ends_in_a_stop_once_nobody_speaks() -> None:
    firmware = owned()
    client = Client(Direct(firmware))
    firmware.start(2.0)
    client.reference(2.2, lease=1000)
    for _ in range(5):
        firmware.run(np.full(990, 2.0))
        assert client.status().state == State.TRACK
    log = firmware.run(np.full(3000, 2.0))
    assert int(np.argmax(log.state == State.FALL)) == pytest.approx(1000, abs=3)
    assert firmware.state is State.OFF


def test_a_frame_that_ends_behind_an_interrupt_is_a_word_of_the_host() -> None:
    """Heard behind the idle loop's look at the samples, it was taken for a long silence, and stopped."""
    firmware = owned()
    client = Client(Direct(firmware))
    firmware.start(2.0)
    client.reference(2.2, lease=1000)
    firmware.preempt_store(Request.CLEAR)
    asked = command(Command.STATUS)
    line = firmware.image.library.ffi.new("uint8_t []", asked)
    firmware.board.incoming, firmware.board.incoming_count, firmware.board.preempts_line = line, len(asked), 1
    firmware.image.library.lib.hysgen_firmware_idle(firmware.firmware, firmware.board)
    assert firmware.firmware.controller.request == 0


def test_the_boards_reference_has_no_lease() -> None:
    firmware = owned()
    client = Client(Direct(firmware))
    firmware.start(2.0)
    client.reference(2.2, lease=1000)
    client.reference(None)
    firmware.run(np.full(3000, 2.0))
    assert firmware.state is State.TRACK


def test_a_refused_image_is_an_error_with_its_reason() -> None:
    client = Client(Direct(owned()))
    with pytest.raises(ModelError, match="MAC"):
        client.install(encode(model(), OWNER.key[::-1], Label(OWNER.device)))
    with pytest.raises(ModelError, match="another device"):
        client.install(encode(model(), OWNER.key, Label(0)))
    assert client.install_model(model(), OWNER.key).counter == 1
    assert client.install_model(model(), OWNER.key).counter == 2


def test_frames_read_back_whatever_they_hold() -> None:
    rng = np.random.default_rng(10)
    for length in (1, 2, 60, 127, 128):
        for zeros in (0.0, 0.5, 1.0):
            body = bytes(0 if rng.random() < zeros else int(rng.integers(256)) for _ in range(length))
            encoded = frame(body)
            assert encoded.index(0) == len(encoded) - 1
            assert payload(encoded[:-1]) == body


def test_a_command_with_any_bit_flipped_has_no_answer_and_no_effect() -> None:
    firmware = owned()
    sound = command(Command.REQUEST, 7, bytes([Request.START]))
    for bit in range(8 * len(sound)):
        flipped = bytearray(sound)
        flipped[bit // 8] ^= 1 << bit % 8
        assert firmware.line(bytes(flipped) + b"\0") == b"", bit
        assert firmware.firmware.controller.request == 0, bit
    assert firmware.line(sound) != b""
    assert firmware.firmware.controller.request == Request.START


class Simulated:
    """The firmware on the simulated C674x, on a board without flash, and the bytes of its line."""

    def __init__(self) -> None:
        need_compiler()
        self.machine = compile_image(firmware_model(model())).machine()
        self.machine.call("hysgen_simulated_boot")

    def line(self, data: bytes) -> bytes:
        """The answers to `data`, without the zeros between them."""
        answers = b""
        for byte in data:
            self.machine.call("hysgen_simulated_send", byte)
            self.machine.call("hysgen_simulated_idle")
        for _ in range(6):
            self.machine.call("hysgen_simulated_idle")
            while (byte := self.machine.call("hysgen_simulated_sent").bits) < 256:
                answers += bytes([byte])
        return answers[:-1]

    def status(self) -> LinkStatus:
        body = payload(self.line(command(Command.STATUS, 5)))
        assert body is not None
        assert body[:3] == bytes([Command.STATUS | ANSWER, 5, 0])
        return LinkStatus.unpack(body[3:])


def test_a_board_without_flash_refuses_every_image() -> None:
    simulated = Simulated()
    for each in image_frames(encode(model(), bytes([1, *bytes(15)]))):
        simulated.line(each)
    status = simulated.status()
    assert ANSWERS[status.image_answer] == ANSWERS[7]
    assert status.counter == 0


@pytest.mark.parametrize("before", [0, 2**32 - 500, 2**32 - 1000])
def test_the_trace_has_the_samples_around_the_first_fault_and_begins_anew_with_clear(before: int) -> None:
    """before: samples of the trace, more in a day than a word counts: it wraps in front of the fault, or behind."""
    firmware = owned()
    client = Client(Direct(firmware))
    with pytest.raises(HysgenError, match="no fault since CLEAR"):
        client.trace()
    firmware.start(2.0)
    firmware.firmware.controller.trace.count = before
    logs = [firmware.run(np.full(900, 2.0))]
    firmware.fail(BoardFault.READING, value=float("nan"))
    logs.append(firmware.run(np.full(900, 2.0)))
    voltage_V, reading_um = (
        np.concatenate([getattr(log, name) for log in logs]) for name in ("output_V", "reading_um")
    )
    table = [row.split(",") for row in client.trace().split("\n")[1:-1]]
    trip = next(k for k, row in enumerate(table) if row[4] == "TRIP")
    fault = int(np.flatnonzero(np.isnan(reading_um))[0]) + 8 - 1
    assert (len(table), trip) == (1024, 768)
    around = slice(fault - 768, fault + 256)
    read = np.array([[float(word) for word in row[:4]] for row in table])
    assert np.array_equal(np.float32(read[:, 1]), reading_um[around], equal_nan=True)
    assert np.array_equal(np.float32(read[:, 2]), voltage_V[around])
    assert (np.diff(read[:, 0]) == 1).all()
    firmware.board.fault = BoardFault.NONE
    firmware.run(np.full(4000, 2.0))
    client.request(Request.CLEAR)
    assert client.status().first_fault == 0
