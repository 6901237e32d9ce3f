"""Client of running firmware: commands over a serial line, with repetition of what is lost (wire.py has the frames)."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from typing import Any, Final, Protocol, Self

from hysgen.errors import HysgenError, ModelError
from hysgen.firmware.host import State
from hysgen.firmware.image import ANSWERS, NO_KEY, Label, encode
from hysgen.firmware.wire import ANSWER, CODES, PROTOCOL, Command, Identity, LinkStatus, command, payload, pieces
from hysgen.model.model import Model

BAUD: Final = 115_200
TIMEOUT_S: Final = 0.5
"""Time for an answer; a certification of a few thousand samples delays it by some 0.1 s."""
TRIES: Final = 4
INSTALL_S: Final = 10.0
"""Time for the firmware to check, write and install an image while the stage is off."""


class Line(Protocol):
    """A serial line, such as a `serial.Serial` with a short timeout."""

    def read(self, size: int = 1) -> bytes:
        """Up to `size` bytes, fewer or none at a timeout."""
        ...

    def write(self, data: bytes) -> int | None:
        """Send bytes."""
        ...

    def close(self) -> None:
        """Give the line back."""
        ...


def open_line(port: str, baud: int = BAUD) -> Line:
    """The serial port by pyserial: a device, or a URL such as socket://host:port.

    Raises HysgenError if pyserial is not installed or the port cannot be opened.
    """
    try:
        import serial  # an optional dependency
    except ImportError:
        raise HysgenError("hysgen link needs pyserial: pip install 'hysgen[link]'") from None
    try:
        line: Line = serial.serial_for_url(port, baudrate=baud, timeout=0.05)
    except (OSError, ValueError) as fault:
        raise HysgenError(f"{port}: cannot be opened ({fault}); name the port of the board's UART2") from fault
    return line


class Client:
    """Commands to running firmware. Every method raises HysgenError if no answer comes or the firmware refuses."""

    def __init__(self, line: Line, timeout_s: float = TIMEOUT_S) -> None:
        self._line, self._timeout_s = line, timeout_s
        self._number, self._buffer = 0, b""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._line.close()

    def identity(self) -> Identity:
        """What the firmware was built from."""
        found = Identity.unpack(self._ask(Command.IDENTIFY))
        if found.protocol != PROTOCOL:
            raise HysgenError(f"the firmware speaks version {found.protocol} of the link, this hysgen {PROTOCOL}")
        return found

    def status(self) -> LinkStatus:
        """State, status and counters now."""
        return LinkStatus.unpack(self._ask(Command.STATUS))

    def request(self, request: int) -> None:
        """Ask for START, STOP or CLEAR (`hysgen.firmware.host.Request`), which the next sample takes."""
        self._ask(Command.REQUEST, bytes([request]))

    def reference(self, reference_um: float | None) -> None:
        """Follow a constant reference in um in place of the board's; None: the board's again."""
        self._ask(Command.REFERENCE, b"" if reference_um is None else struct.pack("<f", reference_um))

    def install(self, data: bytes, progress: Callable[[float], None] = lambda _: None) -> LinkStatus:
        """Send a parameter image and wait until the firmware has judged it; the stage must be off.

        Raises ModelError with the reason if the image is refused.
        """
        for piece in pieces(data):
            self._ask(Command.IMAGE, piece)
            progress((struct.unpack("<I", piece[:4])[0] + len(piece) - 4) / len(data))
        end = time.monotonic() + INSTALL_S
        while True:
            status = self.status()
            if not status.image_pending:
                break
            if time.monotonic() > end:
                off = status.state in (State.OFF, State.TRIPPED)
                raise HysgenError("the image waits" + ("; the firmware does not take it" if off else " until STOP"))
        if status.image_answer != 0:
            raise ModelError(f"the image is {ANSWERS.get(status.image_answer, f'answered by {status.image_answer}')}")
        return status

    def install_model(
        self, model: Model, key: bytes = NO_KEY, progress: Callable[[float], None] = lambda _: None
    ) -> LinkStatus:
        """`install` of a model's numbers, labelled for the device, build and counter that the firmware tells."""
        identity, status = self.identity(), self.status()
        label = Label(identity.device, identity.build, status.counter + 1)
        return self.install(encode(model, label, key), progress)

    def _ask(self, kind: Command, data: bytes = b"") -> bytes:
        """The data of the answer; the command is repeated where an answer does not come."""
        self._number = (self._number + 1) & 0xFF
        for _ in range(TRIES):
            self._line.write(command(kind, self._number, data))
            answer = self._answer(bytes([kind | ANSWER, self._number]))
            if answer is not None:
                break
        else:
            raise HysgenError(f"{kind.name}: no answer in {TRIES} tries; is the firmware running, is this its port?")
        if answer[0] != 0:
            reason = CODES[answer[0]] if answer[0] < len(CODES) else f"code {answer[0]}"
            raise HysgenError(f"{kind.name}: refused: {reason}")
        return answer[1:]

    def _answer(self, head: bytes) -> bytes | None:
        """Code and data of the answer that begins with `head`; None at a timeout. Other frames are dropped."""
        end = time.monotonic() + self._timeout_s
        while time.monotonic() < end:
            self._buffer += self._line.read(256)
            *frames, self._buffer = self._buffer.split(b"\0")
            for encoded in frames:
                body = payload(encoded)
                if body is not None and len(body) > 2 and body.startswith(head):
                    return body[2:]
        return None


def to_json(answer: Identity | LinkStatus) -> dict[str, Any]:
    """Plain JSON values."""
    return dict(vars(answer))
