"""Parameter images: the numbers of a model as bytes for running firmware (firmware/controller/image.h).

words  0 magic, 1 version, 2 bytes, 3 .. 6 structure digest, 7 rules, 8 weights,
       slope[], offset[], gain[] over the rules, weight[] of the terms (float32), CRC-32 of the words before;
words are 32 bits, little-endian
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from typing import Final

import numpy as np

from hysgen.errors import ModelError
from hysgen.firmware.binding import structure_digest
from hysgen.float32.coefficients import Bank, coefficients
from hysgen.model.model import Model

MAGIC: Final = 0x49535948
VERSION: Final = 1
HEADER_WORDS: Final = 9

ANSWERS: Final = {
    0: "accepted",
    1: "refused: bytes are missing, or too many",
    2: "refused: not an image, or of another version",
    3: "refused: the CRC does not fit the bytes",
    4: "refused: numbers of another structure, range or partition",
    5: "refused: a parameter is not finite, denormal or absurdly large",
    7: "refused: the board has no memory that survives power off",
    8: "refused: not certified: too few updates",
    9: "refused: not certified: a parameter beyond its limit",
    10: "refused: not certified: the gain comes too close to zero or changes its sign",
    11: "refused: not certified: the slope comes too close to 1",
}
"""Meaning of the firmware's `image_answer`."""


@dataclass(frozen=True)
class ParameterImage:
    """Content of an image: digest of the structure that it fits, and the numbers of a bank."""

    digest: tuple[int, ...]
    bank: Bank


def encode(model: Model) -> bytes:
    """The image of a model. Raises ModelError for more rules than the learner, and so the firmware, supports."""
    numbers = coefficients(model)
    if numbers.windowed:
        raise ModelError(f"{model.name}: {numbers.rules} rules; the firmware drives models of up to 12, fit with fewer")
    return pack(ParameterImage(structure_digest(model), numbers.bank))


def pack(image: ParameterImage) -> bytes:
    """The bytes of an image."""
    bank = image.bank
    values = np.concatenate([bank.slope, bank.offset, bank.gain, bank.weight]).astype("<f4").tobytes()
    size = 4 * (HEADER_WORDS + 1) + len(values)
    head = struct.pack("<9I", MAGIC, VERSION, size, *image.digest, bank.slope.size, bank.weight.size)
    return head + values + struct.pack("<I", zlib.crc32(head + values))


def decode(data: bytes, source: str = "image") -> ParameterImage:
    """The inverse of `pack`. Raises ModelError for bytes that are too few, no image, of wrong size, or damaged."""
    if len(data) < 4 * (HEADER_WORDS + 1):
        raise ModelError(f"{source}: {len(data)} bytes are no parameter image; write it with hysgen image")
    magic, version, size, *digest, rules, weights = struct.unpack_from("<9I", data)
    if magic != MAGIC or version != VERSION:
        raise ModelError(f"{source}: is not a parameter image of version {VERSION}; write it with hysgen image")
    if size != len(data) or size != 4 * (HEADER_WORDS + 3 * rules + weights + 1):
        raise ModelError(f"{source}: {len(data)} bytes, its header says {size}; write it again")
    if zlib.crc32(data[:-4]) != struct.unpack("<I", data[-4:])[0]:
        raise ModelError(f"{source}: its CRC does not fit its bytes; write it again")
    values = np.frombuffer(data, "<f4", 3 * rules + weights, 4 * HEADER_WORDS).astype(np.float32)
    slope, offset, gain = values[: 3 * rules].reshape(3, rules)
    return ParameterImage(tuple(digest), Bank(slope=slope, offset=offset, gain=gain, weight=values[3 * rules :]))
