"""The complete firmware on the host: controller, generated model and host board, driving the virtual stage.

Only the board layer differs from the target. The same C reads the sensor, supervises, inverts, learns, commits, and
keeps parameter images in a store whose power can fail at any byte.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import IntEnum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.codegen.manifest import c_files
from hysgen.codegen.operations.text import preprocessed
from hysgen.codegen.structs import interface_of
from hysgen.firmware import CONTROLLER, HOST_BOARD, Owner, read_sources, typedefs
from hysgen.firmware.wire import SETTINGS_BYTES, FirmwareStatus, Request, Settings, State, image_frames
from hysgen.machine.native import Library, Toolchain, build
from hysgen.model.file import parse_model
from hysgen.model.path import preview
from hysgen_lab.stage import StageState

Floats32 = NDArray[np.float32]

HEADERS: Final = (
    *("linkage.h", "board_type.h", "board.h", "settings.h", "status.h", "play.h", "bank.h", "watchdog.h", "trace.h"),
    *("controller.h", "image.h", "store.h", "frame.h", "link.h", "integrity.h", "firmware.h"),
)
"""Hand-written headers that declare what is used from here, each behind those that it includes."""

CALLED: Final = (
    *(f"hysgen_firmware_{name}" for name in ("boot", "interrupt", "idle", "status", "panic")),
    "hysgen_host_run",
)
"""Functions of the image that are called from here."""

SLOT_BYTES: Final = 4096
NO_CUT: Final = 0xFFFFFFFF


FAULTS: Final = 0x1FFF0000
"""Mask of the bits of FirmwareStatus that bring the voltage down (STATUS_FAULTS of status.h)."""


BoardFault = IntEnum("BoardFault", "NONE STUCK READING SATURATED LIMITS AMPLIFIER LATE OVERRUN LOST STOPPED", start=0)
"""Faults that the host's board can simulate (board/host/board_type.h)."""


@dataclass(frozen=True)
class Log:
    """A run, arrays (n,): reading at the start of each sample [um], output voltage at its end [V], State."""

    reading_um: Floats32
    output_V: Floats32
    state: NDArray[np.uint8]


@dataclass(frozen=True)
class HostImage:
    """The compiled host image of one model."""

    name: str
    library: Library = field(repr=False)

    @classmethod
    def compile(cls, name: str, texts: Mapping[str, str], toolchain: Toolchain | None = None) -> HostImage:
        """Compile controller, model and host board. texts: generated C and model.h by file name.

        Raises BuildError if there is no compiler or it reports an error.
        """
        own = dict([*read_sources(CONTROLLER), *read_sources(HOST_BOARD)])
        generated = c_files(texts)
        declared = _declarations(name, texts, own)
        return cls(name, build([*own.items(), *generated.items()], declared, toolchain, (), CALLED))


class HostFirmware:
    """The image booted on a board with a stage. `firmware`, `board`: the C structs, through cffi.

    stage: or any plant with its displacement `y_um` at the start, in um, and its `address`, as `StageState` has them.
    """

    def __init__(
        self, image: HostImage, stage: StageState, settings: Settings | None = None, owner: Owner | None = None
    ) -> None:
        self.image = image
        self.stage = stage
        self._ffi, self._lib = image.library.ffi, image.library.lib
        self.board = self._ffi.new("board_t *")
        self.firmware = self._ffi.new("firmware_t *")
        self._settings = self._ffi.new("settings_t *")
        self._ffi.memmove(self._settings, (settings or Settings()).pack(), SETTINGS_BYTES)
        owner = owner or Owner()
        self._owner = self._ffi.new("image_owner_t *", {"key": owner.key_words, "device": owner.device_words})
        self._kept: list[Any] = []
        step, plant = stage.address
        self.board.step = self._ffi.cast("double (*)(void *, double)", step)
        self.board.plant = self._ffi.cast("void *", plant)
        self.board.reading_um = stage.y_um
        self.board.bytes_to_cut = NO_CUT
        self._ffi.memmove(self.board.store, b"\xff" * (2 * SLOT_BYTES), 2 * SLOT_BYTES)
        self.boot()

    def boot(self, power_on: bool = True) -> None:
        """Power on, or a reset under power: all memory but the store starts with arbitrary bytes (0xA5)."""
        self.board.restarted = not power_on
        self._ffi.memmove(self.firmware, b"\xa5" * self._ffi.sizeof("firmware_t"), self._ffi.sizeof("firmware_t"))
        self._lib.hysgen_firmware_boot(self.firmware, self.board, self._settings, self._owner)

    @property
    def state(self) -> State:
        return State(self.firmware.controller.state)

    @property
    def status(self) -> FirmwareStatus:
        return FirmwareStatus(self._lib.hysgen_firmware_status(self.firmware))

    @property
    def first_fault(self) -> FirmwareStatus:
        """The faults of the first sample that had any, since the last CLEAR in OFF or TRIPPED."""
        return FirmwareStatus(self.firmware.controller.first)

    @property
    def settings_wrong(self) -> str | None:
        """Name of the settings_t field that the firmware refused at boot; None: no field."""
        field = self.firmware.settings_wrong
        return self._ffi.string(field).decode() if field else None

    def request(self, request: Request) -> None:
        """Set a request, which the controller takes at the next sample."""
        self.firmware.controller.request = int(request)

    def run(self, reference_um: NDArray[np.float64] | Floats32) -> Log:
        """Run one sample, interrupt and idle loop, for each reference, (n,) in um."""
        wanted = np.ascontiguousarray(reference_um, dtype=np.float32)
        n = wanted.size
        log = Log(np.empty(n, np.float32), np.empty(n, np.float32), np.empty(n, np.uint8))
        self.board.reference_um = self._ffi.from_buffer("float const *", wanted)
        self.board.fault_from = max(0, self.board.fault_from - self.board.sample)
        self.board.fault_until = max(0, self.board.fault_until - self.board.sample)
        self.board.sample = 0
        self._lib.hysgen_host_run(
            self.firmware,
            self.board,
            n,
            self._ffi.from_buffer("float *", log.reading_um),
            self._ffi.from_buffer("float *", log.output_V),
            self._ffi.from_buffer("uint8_t *", log.state),
        )
        return log

    def start(self, reference_um: float, most: int = 100_000) -> Log:
        """Request a start and run until the state is TRACK or TRIPPED, at most `most` samples."""
        self.request(Request.START)
        logs = []
        for _ in range(-(-most // 1000)):
            logs.append(self.run(np.full(1000, reference_um)))
            if self.state in (State.TRACK, State.TRIPPED):
                break
        joined = (np.concatenate([getattr(log, column.name) for log in logs]) for column in fields(Log))
        return Log(*joined)

    def fail(
        self,
        fault: BoardFault,
        value: float = 0.0,
        after: int = 0,
        samples: int = 0xFFFFFFFF,
        pattern: tuple[int, int] = (0, 0),
    ) -> None:
        """Simulate `fault` on the board for `samples` samples, from sample `after` of the next run on.

        pattern: (length, period): the fault acts on the first `length` of every `period` samples; (0, 0): on all.
        """
        self.board.sample = 0
        self.board.fault = int(fault)
        self.board.fault_value = value
        self.board.fault_from = after
        self.board.fault_until = min(after + samples, 0xFFFFFFFF)
        self.board.fault_length, self.board.fault_period = pattern

    def line(self, data: bytes) -> bytes:
        """Put bytes on the line to the firmware, and run the idle loop until it has taken them. Returns its answers."""
        buffer = self._ffi.new("uint8_t []", data or b"\0")
        self.board.incoming, self.board.incoming_count = buffer, len(data)
        answers = b""
        while self.board.incoming_count:
            self._lib.hysgen_firmware_idle(self.firmware, self.board)
            answers += self._taken()
        # The last answer, and a certification that a complete image waits for.
        for _ in range(4):
            self._lib.hysgen_firmware_idle(self.firmware, self.board)
            answers += self._taken()
        return answers

    def send(self, data: bytes, offset: int = 0) -> int:
        """Send bytes of a parameter image, which begin at `offset` of it. Returns `image_answer`."""
        for frame in image_frames(data, offset):
            self.line(frame)
        return int(self.firmware.image_answer)

    def _taken(self) -> bytes:
        """The bytes from the firmware so far."""
        count = self.board.outgoing_count
        self.board.outgoing_count = 0
        return bytes(self._ffi.buffer(self.board.outgoing, count))

    def preempt_store(self, request: Request) -> None:
        """Let interrupts come while the store erases and after it has written; set `request` before each."""
        reference_um = self._ffi.new("float []", 1)

        def interrupt(_: object) -> None:
            self.request(request)
            self.board.sample, self.board.reference_um = 0, reference_um
            self._lib.hysgen_firmware_interrupt(self.firmware, self.board)

        self._kept = [reference_um, self._ffi.callback("void(void *)", interrupt)]
        self.board.preempt = self._kept[1]

    def bank(self) -> bytes:
        """The parameters that the next start will use, as bytes of the C struct."""
        return bytes(self._ffi.buffer(self._ffi.addressof(self.firmware.controller, "bank")))

    def slot(self, slot: int) -> Any:
        """The bytes of one slot of the store, as a writable view."""
        return self._ffi.buffer(self.board.store[slot], SLOT_BYTES)


def _declarations(name: str, texts: Mapping[str, str], own: Mapping[str, str]) -> str:
    """The declarations for cffi: structs of model, controller and board, and the functions called from here.

    texts: generated for model `name`; own: hand-written files of controller and board, read as a preprocessor does.
    """
    model = parse_model(texts[f"{name}.json"], f"{name}.json")
    sizes = {"RULES": model.grid.rules, "WEIGHTS": len(model.weights), "PREVIEW": preview(model.blocks)}
    macros = {f"MODEL_{word}": f"{size}u" for word, size in sizes.items()}
    macros["BANK_WORDS"] = f"{3 * model.grid.rules + len(model.weights) + 1}u"
    headers = [preprocessed(own[file], macros) for file in HEADERS]
    return "\n".join(
        [
            interface_of(name, texts).declarations(),
            *typedefs(name),
            *headers,
            "void hysgen_host_run(firmware_t *, board_t *, size_t, float *, float *, uint8_t *);",
        ]
    )
