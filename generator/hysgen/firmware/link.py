"""Client of running firmware: commands over a serial line, with repetition of what is lost (wire.py has the frames)."""

import json
import struct
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from hysgen.errors import HysgenError, ModelError
from hysgen.firmware import ANSWERS, Label, ParameterImage, bank_of, decode, encode, pack
from hysgen.firmware.wire import (
    ANSWER,
    CODES,
    PROTOCOL,
    SETTINGS_BYTES,
    Command,
    FirmwareStatus,
    Identity,
    LinkStatus,
    Request,
    Settings,
    State,
    command,
    payload,
    pieces,
    shortest,
)
from hysgen.float32.coefficients import Bank
from hysgen.model.model import Model

Floats = NDArray[np.float64]

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


TRACED, TRACE_ROW = 1024, struct.Struct("<3fI")
"""Samples of a trace and words of each (trace.h)."""
CODES_16: Final = 65535
"""Largest code of a voltage or reading on the line (play.h)."""


def read_table(file: Path) -> tuple[Floats, Floats]:
    """Times in s and voltages in V of a text file: `time_s,voltage_V`, then a row of both for each; '#' is a comment.

    Raises ModelError for anything else.
    """
    try:
        rows = [row.split(",") for row in file.read_text(encoding="utf-8").split("\n") if row and row[0] != "#"]
        table = np.array(rows[1:], float)
    except OSError as fault:
        raise ModelError(f"{file}: cannot be read ({fault.strerror})") from fault
    except ValueError:
        rows, table = [], np.zeros(0)
    if not rows or rows[0] != ["time_s", "voltage_V"] or table.ndim != 2 or not np.isfinite(table).all():
        raise ModelError(f"{file}: is no table of voltages; its first row is time_s,voltage_V, its others are numbers")
    if (np.diff(table[:, 0]) <= 0.0).any():
        raise ModelError(f"{file}: its times do not rise")
    return table[:, 0], table[:, 1]


def record_text(time_s: Floats, voltage_V: Floats, reading_um: Floats) -> str:
    """The text of a record, for `hysgen diagnose`; arrays (n,) of `Client.record`."""
    rows = zip(time_s.tolist(), voltage_V.tolist(), reading_um.tolist(), strict=True)
    lines = (f"{t:.9g},{u:.9g},{y:.9g}" for t, u, y in rows)
    return "\n".join(("# hysgen link record", "time_s,voltage_V,displacement_um", *lines, ""))


def kept_text(image: ParameterImage) -> str:
    """Parameters and settings as JSON, for `read_kept`: numbers as the shortest decimals of their float32."""
    numbers = {name: [shortest(float(x)) for x in values] for name, values in vars(image.bank).items()}
    structure = "".join(f"{word:08x}" for word in image.digest)
    settings = vars(Settings.unpack(image.settings))
    result = {"structure": structure, "counter": image.label.counter, "settings": settings, "parameters": numbers}
    result["half_integral"] = shortest(image.half)
    return json.dumps(result, indent=2) + "\n"


def read_kept(file: Path) -> ParameterImage:
    """The inverse of `kept_text`, of a file. Raises ModelError for anything else."""
    try:
        given = json.loads(file.read_text(encoding="utf-8"))
        bank = Bank(**{name: np.array(values, np.float32) for name, values in given["parameters"].items()})
        digest = tuple(struct.unpack(">4I", bytes.fromhex(given["structure"])))
        settings = Settings(**given["settings"]).pack()
        return ParameterImage(digest, bank, settings=settings, half=float(given["half_integral"]))
    except OSError as fault:
        raise ModelError(f"{file}: cannot be read ({fault.strerror})") from fault
    except (ValueError, KeyError, TypeError, AttributeError, struct.error) as fault:
        raise ModelError(f"{file}: is not as hysgen link read writes it ({fault})") from fault


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
        data = self._ask(Command.IDENTIFY)
        (protocol,) = struct.unpack_from("<I", data)
        if protocol != PROTOCOL:
            raise HysgenError(f"the firmware speaks version {protocol} of the link, this hysgen {PROTOCOL}")
        return Identity.unpack(data)

    def status(self) -> LinkStatus:
        """State, status and counters now."""
        return LinkStatus.unpack(self._ask(Command.STATUS))

    def request(self, request: int) -> None:
        """Ask for START, STOP, CLEAR or RECORD (`hysgen.firmware.wire.Request`), which the next sample takes."""
        self._ask(Command.REQUEST, bytes([request]))

    def reference(self, reference_um: float | None, lease: int | None = None) -> None:
        """Follow a constant reference in um in place of the board's; None: the board's again.

        lease: samples without a word from this client after which the firmware stops; None: it follows for ever.
        """
        data = b"" if reference_um is None else struct.pack("<f", reference_um)
        self._ask(Command.REFERENCE, data + (b"" if lease is None else struct.pack("<I", lease)))

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

    def install_model(self, model: Model, key: bytes, progress: Callable[[float], None] = lambda _: None) -> LinkStatus:
        """`keep` of a model's numbers and of the settings that are there."""
        own = decode(encode(model, key))
        return self.keep(replace(own, settings=self.stored().settings), key, progress)

    def stored(self) -> ParameterImage:
        """Parameters with which the next START begins, learnt ones among them, and settings of the next boot.

        Raises HysgenError unless the stage rests.
        """
        identity, status = self.identity(), self.status()
        if status.state not in (State.OFF, State.TRIPPED):
            raise HysgenError("parameters and settings are read at rest; STOP first")
        data, size = self._read(Command.KEPT, 1, 4096, lambda _: None)
        label = Label(identity.device, identity.build, status.counter)
        bank, half = bank_of(data, identity.rules, identity.weights)
        return ParameterImage(identity.digest, bank, label, data[size - SETTINGS_BYTES : size], half)

    def keep(self, image: ParameterImage, key: bytes, progress: Callable[[float], None] = lambda _: None) -> LinkStatus:
        """`install` of parameters and settings, labelled for the device, build and counter that the firmware tells.

        The parameters are those of the next START, the settings those of the next boot.
        """
        identity, status = self.identity(), self.status()
        label = Label(identity.device, identity.build, status.counter + 1)
        return self.install(pack(replace(image, label=label), key), progress)

    def record(
        self, times_s: Floats, voltages_V: Floats, progress: Callable[[float], None] = lambda _: None
    ) -> tuple[Floats, Floats, Floats]:
        """Play a table of voltages, straight lines between its rows, from rest to rest without model and feedback.

        times_s, voltages_V: (rows,), times rising. Returns time [s], voltage as put out [V] and reading [um], NaN for
        none, one row per sample of the firmware: u(k) is put out once y(k) is read. Raises ModelError for a table that
        the converters cannot put out or the firmware's memory cannot hold, HysgenError if it ended early.
        """
        identity = self.identity()
        period_s = 1e-9 * identity.period_ns
        # Half a period more: the last row belongs to the table, whatever its time is rounded to.
        time_s: Floats = np.arange(int((times_s[-1] - times_s[0]) / period_s + 0.5) + 1).astype(np.float64) * period_s
        voltage_V = np.interp(times_s[0] + time_s, times_s, voltages_V)
        if time_s.size > identity.record:
            raise ModelError(f"{time_s[-1]:.6g} s are {time_s.size} samples; the firmware records {identity.record}")
        if voltage_V.min() < identity.low_V or voltage_V.max() > identity.high_V:
            raise ModelError(f"voltages beyond {identity.low_V:g} .. {identity.high_V:g} V, the range of the D/A")
        step_V, step_um = (identity.high_V - identity.low_V) / CODES_16, (identity.high_um - identity.low_um) / CODES_16
        codes = np.rint((voltage_V - identity.low_V) / step_V).astype("<u2")
        for piece in pieces(codes.tobytes()):
            self._ask(Command.TABLE, piece)
            progress(0.5 * struct.unpack_from("<I", piece)[0] / (2 * codes.size))
        self.request(Request.RECORD)
        while (status := self.status()).state not in (State.OFF, State.TRIPPED):
            continue
        data, done = self._read(Command.RECORD, 2, codes.size, lambda share: progress(0.5 + 0.5 * share))
        if done < codes.size:
            bits = FirmwareStatus(status.status).name or "STOP"
            raise HysgenError(f"the table ended in front of row {done} of {codes.size} of its samples: {bits}")
        read = np.frombuffer(data, "<u2", done)
        reading_um = np.where(read == 0, np.nan, identity.low_um + step_um * read)
        return time_s, identity.low_V + step_V * codes, reading_um

    def trace(self, progress: Callable[[float], None] = lambda _: None) -> str:
        """The samples around the first fault as a table of text; the fault is the first sample of TRIP or TRIPPED.

        Raises HysgenError if there was no fault since CLEAR.
        """
        if self.status().first_fault == 0:
            raise HysgenError("there was no fault since CLEAR, around which samples are kept")
        data, count = self._read(Command.TRACE, TRACE_ROW.size, TRACED, progress)
        rows = [*TRACE_ROW.iter_unpack(data)][:count]
        oldest = count % TRACED if count > TRACED else 0
        ordered = enumerate(rows[oldest:] + rows[:oldest], start=max(0, count - TRACED))
        lines = (f"{k},{y:.9g},{u:.9g},{r:.9g},{State(state).name}" for k, (y, u, r, state) in ordered)
        return "\n".join(("sample,displacement_um,voltage_V,reference_um,state", *lines, ""))

    def _read(self, kind: Command, size: int, most: int, progress: Callable[[float], None]) -> tuple[bytes, int]:
        """Memory of rows of `size` bytes, up to `most`, and how many the firmware says there are."""
        data, done = b"", most
        while len(data) < size * min(done, most):
            answer = self._ask(kind, struct.pack("<I", len(data)))
            (done,) = struct.unpack_from("<I", answer)
            data += answer[4:]
            progress(min(1.0, len(data) / (size * most)))
        return data, done

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
