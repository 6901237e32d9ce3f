"""Frames and commands of the firmware's line (frame.h, link.h).

    COBS(payload, CRC-32 of the payload, little-endian) 0x00
    command: kind, number, data;   answer: kind + ANSWER, number, code, data

Consistent overhead byte stuffing (Cheshire and Baker, 1999) removes every zero from a frame, so a zero ends each.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, fields
from enum import IntEnum, IntFlag
from typing import Final

import numpy as np

PROTOCOL: Final = 6
ANSWER: Final = 0x80
CHUNK: Final = 64
"""Bytes of a parameter image, table or record in one frame."""


class Command(IntEnum):
    """Kind of a command (link.h)."""

    STATUS = 1
    REQUEST = 2
    REFERENCE = 3
    IMAGE = 4
    IDENTIFY = 5
    TABLE = 6
    RECORD = 7
    TRACE = 8
    KEPT = 9


CODES: Final = ("done", "no such command", "too few or too many data", "a value out of range or order")
"""Meaning of the code of an answer."""


@dataclass(frozen=True)
class LinkStatus:
    """Answer to STATUS: the firmware now, words in the order of the frame.

    state, status, samples: of the controller. first_fault: bits of the first fault, kept over a reset. reading_um,
    output_V, reference_um, offset_um: of the last sample.
    image_answer, image_pending, received: of the parameter image that arrived last. counter: of the image in use, 0 for
    none. commits, commit_answer, updates, rejected: of learning. cycles_last, cycles_most: of the interrupt. selftest:
    mismatches at boot. stack_bytes: of the stack that were never used. read_back_V: voltage behind the D/A by the scale
    as built, None where the board does not read it.
    """

    state: int
    status: int
    first_fault: int
    samples: int
    reading_um: float
    output_V: float
    reference_um: float
    offset_um: float
    image_answer: int
    image_pending: int
    received: int
    counter: int
    commits: int
    commit_answer: int
    updates: int
    rejected: int
    cycles_last: int
    cycles_most: int
    selftest: int
    stack_bytes: int
    read_back_V: float | None

    @classmethod
    def unpack(cls, data: bytes) -> LinkStatus:
        """Raises struct.error for data of another length."""
        *words, read_back_V = struct.unpack("<4I4f12If", data)
        return cls(*(*words, None if math.isnan(read_back_V) else read_back_V))


@dataclass(frozen=True)
class Settings:
    """The settings_t of settings.h, options as booleans, in its order.

    Defaults: the virtual stage, amplifier -20 .. 120 V, sensor -3.3 .. 13.1 um.
    """

    loop: bool = False
    learn: bool = False
    keep: bool = False
    no_offset: bool = False
    off_V: float = 0.0
    low_V: float = -20.0
    high_V: float = 120.0
    step_V: float = 1.5
    ramp_V: float = 0.02
    power_samples: int = 100
    loop_low_V: float = 22.0
    loop_high_V: float = 56.0
    hold_samples: int = 4096
    offset_um: float = 1.0
    state_samples: int = 250_000
    reference_step_um: float = 0.02
    follow_um: float = 0.0
    reading_zero_um: float = 0.0
    reading_gain: float = 1.0
    output_zero_V: float = 0.0
    output_gain: float = 1.0

    def pack(self) -> bytes:
        """The words of settings_t."""
        values = vars(self)
        options = sum(values[name] << bit for bit, name in enumerate(OPTIONS))
        return SETTINGS.pack(options, *(value for name, value in values.items() if name not in OPTIONS))

    @classmethod
    def unpack(cls, data: bytes) -> Settings:
        """Raises struct.error for data of another length."""
        options, *words = SETTINGS.unpack(data)
        return cls(*(bool(options >> bit & 1) for bit in range(len(OPTIONS))), *map(shortest, words))


OPTIONS: Final = ("loop", "learn", "keep", "no_offset")
SETTINGS: Final = struct.Struct(
    "<I" + "".join({"float": "f", "int": "I"}.get(str(field.type), "") for field in fields(Settings))
)
SETTINGS_BYTES: Final = SETTINGS.size


def shortest(number: float) -> float:
    """A float32, or a whole number, as the shortest decimal that is read back as the same float32."""
    return float(str(np.float32(number))) if isinstance(number, float) else number


IDENTITY: Final = struct.Struct("<6IQ?3x5I8fI")
"""Words of the answer to IDENTIFY, in front of the model's name."""


@dataclass(frozen=True)
class Identity:
    """Answer to IDENTIFY: the firmware as built.

    digest: of the structure that parameter images must fit. build, device, keyed: see `Label` and `Owner` of
    `hysgen.firmware`. image_bytes: size of a parameter image. low_V .. high_V, low_um .. high_um: of the
    converters. record: samples that a record holds.
    """

    protocol: int
    digest: tuple[int, int, int, int]
    build: int
    device: int
    keyed: bool
    period_ns: int
    preview: int
    image_bytes: int
    rules: int
    weights: int
    y_min_um: float
    y_max_um: float
    u_min_V: float
    u_max_V: float
    low_V: float
    high_V: float
    low_um: float
    high_um: float
    record: int
    name: str

    @classmethod
    def unpack(cls, data: bytes) -> Identity:
        """Raises struct.error for too few data."""
        protocol, *words = IDENTITY.unpack_from(data)
        values = (protocol, tuple(words[:4]), *words[4:], data[IDENTITY.size :].decode("ascii", "replace"))
        return cls(**dict(zip(cls.__dataclass_fields__, values, strict=True)))


def frame(payload: bytes) -> bytes:
    """The frame of a payload as it goes on the line."""
    body = payload + struct.pack("<I", zlib.crc32(payload))
    return b"".join(bytes([len(part) + 1]) + part for part in body.split(b"\0")) + b"\0"


def payload(encoded: bytes) -> bytes | None:
    """The payload of a frame without its last zero; None if it is damaged."""
    parts, at = [], 0
    while at < len(encoded):
        code = encoded[at]
        parts.append(encoded[at + 1 : at + code])
        if code == 0 or len(parts[-1]) != code - 1:
            return None
        at += code
    body = b"\0".join(parts)
    if len(body) <= 4 or zlib.crc32(body[:-4]) != struct.unpack("<I", body[-4:])[0]:
        return None
    return body[:-4]


def command(kind: Command, number: int = 0, data: bytes = b"") -> bytes:
    """The frame of a command."""
    return frame(bytes([kind, number & 0xFF]) + data)


def pieces(data: bytes, offset: int = 0) -> Iterator[bytes]:
    """The data of the IMAGE commands that send `data`, which begins at `offset` of the image."""
    for at in range(0, len(data), CHUNK):
        yield struct.pack("<I", offset + at) + data[at : at + CHUNK]


def image_frames(data: bytes, offset: int = 0) -> Iterator[bytes]:
    """The frames that send `data`, which begins at `offset` of a parameter image."""
    return (command(Command.IMAGE, number, piece) for number, piece in enumerate(pieces(data, offset)))


State = IntEnum("State", "OFF POWER RISE LOOP HOLD APPROACH TRACK FALL TRIP TRIPPED PLAY", start=0)
"""State of the controller (controller.h)."""


Request = IntEnum("Request", "START STOP CLEAR RECORD")
"""Requests to the controller (controller.h)."""


class FirmwareStatus(IntFlag):
    """Bits of the firmware's status word (status.h)."""

    SENSOR_INVALID = 0x1
    SENSOR_RANGE = 0x2
    REFERENCE_INVALID = 0x4
    REFERENCE_LIMITED = 0x8
    REFERENCE_SLEWED = 0x10
    OUTPUT_LIMITED = 0x20
    OUTPUT_SLEWED = 0x40
    AMPLIFIER_LIMITS = 0x80
    LOOP_LIMITED = 0x100
    DEADLINE_MISSED = 0x200
    MODEL = 0x400
    LEARN_SKIPPED = 0x800
    IMAGE_REFUSED = 0x1000
    IMAGE_FALLBACK = 0x2000
    INTERRUPT_LOST = 0x4000
    SENSOR_JUMP = 0x8000
    FAULT_SELFTEST = 0x10000
    FAULT_SENSOR = 0x20000
    FAULT_STUCK = 0x40000
    FAULT_FOLLOW = 0x80000
    FAULT_AMPLIFIER = 0x100000
    FAULT_DEADLINE = 0x200000
    FAULT_OFFSET = 0x400000
    FAULT_STROKE = 0x800000
    FAULT_SETTINGS = 0x1000000
    FAULT_TIMEOUT = 0x2000000
    FAULT_RESET = 0x4000000
    FAULT_EXCEPTION = 0x8000000
    FAULT_MEMORY = 0x10000000
