"""What binds firmware to one generated model: model.h, the hand-written C, parameter images.

A parameter image holds the numbers of a model as bytes for running firmware, with SipHash-2-4 as authentication code:

words  0 magic, 1 version, 2 bytes, 3 .. 6 structure digest, 7 rules, 8 weights, 9 and 10 device, 11 build, 12 counter,
       slope[], offset[], gain[] over the rules, weight[] of the terms, half the integral of the feedback (float32),
       settings, CRC-32 of the words before, SipHash-2-4 of all words before (two words);
words are 32 bits, little-endian
"""

import json
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from hysgen.certify.certificates import certify
from hysgen.codegen import Options, generate
from hysgen.codegen.parameters import Constant
from hysgen.codegen.render import render
from hysgen.errors import ModelError
from hysgen.firmware.wire import SETTINGS_BYTES
from hysgen.float32.coefficients import Bank, coefficients, commit_numbers
from hysgen.float32.struct_words import Commit
from hysgen.machine.files import data_folder, digest, version
from hysgen.model.file import dump_model
from hysgen.model.learner_settings import LearnerSettings
from hysgen.model.model import Model
from hysgen.model.path import preview

BINDING: Final = "model.h"
TYPES: Final = ("t", "bank_t", "learner_t")
FUNCTIONS: Final = ("init", "simulate", "limits", "inverse", "learn_init", "learn", "commit", "selftest", "correct")
"""Structs and functions of the generated model that the firmware uses, under the names `model_t`, `model_init`, ..."""


def firmware_model(model: Model, *, aligned: bool = False, forced: bool = False) -> dict[str, str]:
    """The files of the model's folder in firmware/models by name: generated C and model.h.

    aligned: whether the learner is aligned for kernels; forced: as in `Options`.

    Raises ModelError if the firmware cannot drive the model, and the errors of `generate`.
    """
    require_drivable(model)
    model = unphased(model)
    return generate(model, Options(aligned=aligned, forced=forced)) | {BINDING: binding(model)}


def unphased(model: Model) -> Model:
    """The model with weight 0 for its periodic disturbances: their phase at the board's START is unknown, and with a
    wrong one they would add to the error."""
    gains = [0.0 if term.timed else 1.0 for term in model.terms for _ in range(term.size)]
    return replace(model, weights=model.weights * gains) if 0.0 in gains else model


def with_learner(model: Model) -> Model:
    """The model with a learner of the rules' consequents.

    alpha is small, so the prior holds the parameters near their identified values, and the forgetting factor is 1 until
    the window is full. One sine does not excite all parameters; without these settings the unexcited ones would drift
    until commit refuses them.
    """
    return replace(model, learner=LearnerSettings(forgetting=1.0, alpha=1e-6))


def require_drivable(model: Model) -> None:
    """Raise ModelError unless the model has a learner and needs no auxiliary channels."""
    if model.learner is None:
        raise ModelError(
            f"{model.name}: has no learner settings, whose commit certifies parameter images; fit or generate with "
            "a learner"
        )
    if model.quantities.other:
        raise ModelError(
            f"{model.name}: has quantities that the firmware's board layer does not set and read ('V', 'um')"
        )
    if model.channels:
        raise ModelError(f"{model.name}: listens to auxiliary channels, which the firmware's board layer does not have")


def binding(model: Model) -> str:
    """The text of model.h."""
    numbers = coefficients(model)
    commit = commit_numbers(model, numbers, certify(model))
    constants = [
        Constant("Y_MIN_UM", numbers.y_min_um),
        Constant("Y_MAX_UM", numbers.y_max_um),
        Constant("U_MIN_V", numbers.u_min_V),
        Constant("U_MAX_V", numbers.u_max_V),
        Constant("PERIOD_NS", np.uint32(round(1e9 * model.Ts_s))),
        Constant("COMMIT_POINTS", np.uint32(commit.points)),
        Constant("COMMIT_MATURE", np.uint32(commit.settings.mature)),
    ]
    facts = {
        "name": model.name,
        "NAME": model.name.upper(),
        "version": version(),
        "weights": len(model.weights),
        "preview": preview(model.blocks),
        "functions": FUNCTIONS[: len(FUNCTIONS) - (model.feedback is None)],
        "types": typedefs(model.name),
        "constants": constants,
        "build": f"0x{build_id(model):08x}u",
        "digest": [f"0x{word:08x}u" for word in structure_digest(model)],
    }
    return render("firmware/model.h.j2", facts)


def typedefs(name: str) -> list[str]:
    """The firmware's names for the structs of model `name`, as C."""
    return [f"typedef {name}_{struct} model_{struct};" for struct in TYPES]


def build_id(model: Model) -> int:
    """One word of the SHA-256 of the model file, never 0: the build of a firmware with these built-in numbers."""
    return int(digest(dump_model(unphased(model)).encode())[:8], 16) or 1


def structure_digest(model: Model) -> tuple[int, ...]:
    """Four words of the SHA-256 of name, sampling period, ranges, partition, and shapes of terms, blocks and feedback.

    Models with equal digests differ only in the numbers of a bank (rules, weights, integral of the feedback) and in
    their history.
    """
    numbers, loop = coefficients(model), model.feedback
    fixed: dict[str, Any] = {
        "name": model.name,
        "Ts_s": model.Ts_s.hex(),
        "rules": numbers.rules,
        "ranges": _hex([numbers.y_min_um, numbers.y_max_um, numbers.u_min_V, numbers.u_max_V]),
        "partition": _hex([numbers.origin_um, numbers.per_step, *numbers.strength]),
        "terms": [[term.kind, term.size, _shapes(term.constants(model.Ts_s))] for term in model.terms],
        "blocks": [[block.kind, _shapes(block.constants(model.Ts_s))] for block in model.blocks],
    }
    if loop is not None:
        filtered = {} if loop.filter is None else _shapes(loop.filter.constants(model.Ts_s))
        fixed["feedback"] = [filtered, _hex([np.float32(loop.limit_um)])]
    whole = digest(json.dumps(fixed, sort_keys=True).encode())
    return tuple(int(whole[8 * i : 8 * i + 8], 16) for i in range(4))


def _shapes(tables: Mapping[str, NDArray[Any]]) -> dict[str, str]:
    return {name: np.ascontiguousarray(values).tobytes().hex() for name, values in tables.items()}


def _hex(values: list[np.float32]) -> str:
    return np.array(values, dtype="<f4").tobytes().hex()


CONTROLLER: Final = "controller"
HOST_BOARD: Final = "board/host"
SIMULATOR_BOARD: Final = "board/simulator"
TARGET_BOARD: Final = "board/c6748"
EMPTY_STORE: Final = ("board", "empty_store.c")
"""Folder and name of the parameter store without memory, of SIMULATOR_BOARD and of boards without flash."""

Sources = list[tuple[str, str]]


def firmware_folder() -> Path:
    """The folder of controller/ and board/. Raises BuildError if the installation lacks them."""
    return data_folder("firmware", holds=CONTROLLER)


def read_sources(folder: str, *patterns: str) -> Sources:
    """(file name, text) of the files in `folder` that match `patterns` (default: the C), sorted by name."""
    paths = [path for pattern in patterns or ("*.[ch]",) for path in (firmware_folder() / folder).glob(pattern)]
    return [(path.name, path.read_text(encoding="utf-8")) for path in sorted(paths)]


_MASK: Final = 0xFFFFFFFFFFFFFFFF
_START: Final = (0x736F6D6570736575, 0x646F72616E646F6D, 0x6C7967656E657261, 0x7465646279746573)


def siphash(key: bytes, message: bytes) -> int:
    """The tag of 64 bits of `message` under `key` of 16 bytes. Raises ValueError for a key of another length."""
    if len(key) != 16:
        raise ValueError(f"a SipHash key has 16 bytes, this one {len(key)}")
    first, second = struct.unpack("<2Q", key)
    v: list[int] = [start ^ half for start, half in zip(_START, (first, second, first, second), strict=True)]
    padded = message + bytes(-(len(message) + 1) % 8) + bytes([len(message) & 0xFF])
    for (word,) in struct.iter_unpack("<Q", padded):
        v[3] ^= word
        _rounds(v, 2)
        v[0] ^= word
    v[2] ^= 0xFF
    _rounds(v, 4)
    return v[0] ^ v[1] ^ v[2] ^ v[3]


def _rounds(v: list[int], count: int) -> None:
    for _ in range(count):
        v[0], v[2] = (v[0] + v[1]) & _MASK, (v[2] + v[3]) & _MASK
        v[1], v[3] = _rotated(v[1], 13) ^ v[0], _rotated(v[3], 16) ^ v[2]
        v[0] = _rotated(v[0], 32)
        v[2], v[0] = (v[2] + v[1]) & _MASK, (v[0] + v[3]) & _MASK
        v[1], v[3] = _rotated(v[1], 17) ^ v[2], _rotated(v[3], 21) ^ v[0]
        v[2] = _rotated(v[2], 32)


def _rotated(x: int, count: int) -> int:
    return ((x << count) | (x >> (64 - count))) & _MASK


MAGIC: Final = 0x49535948
VERSION: Final = 4
_MAKE_KEY: Final = "make a key with: openssl rand -hex 16"
HEADER: Final = "<9IQ2I"
HEADER_WORDS: Final = 13
TAIL_WORDS: Final = 4 + SETTINGS_BYTES // 4
BUILT_IN: Final = bytes(SETTINGS_BYTES)
"""Settings of an image that leaves them to the firmware's build."""
NO_KEY: Final = bytes(16)
"""The key of a firmware without a secret, which takes no image."""

ANSWERS: Final = {
    0: "accepted",
    1: "refused: bytes are missing, or too many",
    2: "refused: not an image, or of another version",
    3: "refused: the CRC does not fit the bytes",
    4: "refused: numbers of another structure, range or partition",
    5: "refused: a parameter is not finite, denormal or absurdly large",
    7: "refused: the board has no memory that survives power off",
    **{
        6 + answer: f"refused: not certified: {answer.meaning}"
        for answer in Commit
        if Commit.COMMITTED < answer < Commit.REFUSED_WORSE  # an image has no trial
    },
    13: "refused: its MAC does not fit its bytes and the firmware's key",
    14: "refused: for another device",
    15: "refused: for another build of the firmware",
    16: "refused: its counter is not larger than the largest so far, or by more than 65536",
    17: "refused: the firmware's key is all zeros, which is no secret; fill in main_owner",
    18: "refused: its settings, or the gain of its feedback, must not run on this board",
}
"""Meaning of the firmware's `image_answer`."""


@dataclass(frozen=True)
class Owner:
    """Whose images a firmware takes: key of the MAC, 16 bytes, and number of the device, 64 bits."""

    key: bytes = NO_KEY
    device: int = 0

    @property
    def key_words(self) -> list[int]:
        """The key as the firmware's four words."""
        return list(struct.unpack("<4I", self.key))

    @property
    def device_words(self) -> list[int]:
        """The device as the firmware's two words, the low one first."""
        return [self.device & 0xFFFFFFFF, self.device >> 32]


@dataclass(frozen=True)
class Label:
    """Where an image belongs: device, 64 bits; build of the firmware, or 0 for any; counter, larger than the last."""

    device: int = 0
    build: int = 0
    counter: int = 1


@dataclass(frozen=True)
class ParameterImage:
    """Content of an image: digest of the structure that it fits, the numbers of a bank, its label, the words of
    settings_t (`Settings.pack`), BUILT_IN: those of the firmware's build, and half the integral of the feedback."""

    digest: tuple[int, ...]
    bank: Bank
    label: Label = Label()
    settings: bytes = BUILT_IN
    half: float = 0.0


def encode(model: Model, key: bytes, label: Label = Label()) -> bytes:
    """The image of a model, authenticated with `key`.

    Raises ModelError for a key of zeros, and for more rules than the learner, and so the firmware, supports.
    """
    numbers = coefficients(unphased(model))
    if numbers.windowed:
        raise ModelError(f"{model.name}: {numbers.rules} rules; the firmware drives models of up to 12, fit with fewer")
    half = 0.0 if model.feedback is None else float(model.feedback.half)
    return pack(ParameterImage(structure_digest(model), numbers.bank, label, half=half), key)


def pack(image: ParameterImage, key: bytes) -> bytes:
    """The bytes of an image. Raises ModelError for a key of zeros, which is no secret."""
    if key == NO_KEY:
        raise ModelError(f"a key of zeros is no secret, and no firmware takes it; {_MAKE_KEY}")
    bank, label = image.bank, image.label
    values = np.concatenate([bank.slope, bank.offset, bank.gain, bank.weight, [image.half]]).astype("<f4").tobytes()
    size = 4 * (HEADER_WORDS + TAIL_WORDS - 1) + len(values)
    counts = (bank.slope.size, bank.weight.size)
    place = (label.device, label.build, label.counter)
    body = struct.pack(HEADER, MAGIC, VERSION, size, *image.digest, *counts, *place) + values + image.settings
    body += struct.pack("<I", zlib.crc32(body))
    return body + struct.pack("<Q", siphash(key, body))


def decode(data: bytes, source: str = "image", key: bytes | None = None) -> ParameterImage:
    """The inverse of `pack`; key: to check the MAC with, None: it is not checked.

    Raises ModelError for bytes that are too few, no image, of wrong size, damaged, or not authenticated by the key.
    """
    if len(data) < 4 * (HEADER_WORDS + TAIL_WORDS):
        raise ModelError(f"{source}: {len(data)} bytes are no parameter image; write it with hysgen image")
    magic, version, size, *digest, rules, weights, device, build, counter = struct.unpack_from(HEADER, data)
    if magic != MAGIC or version != VERSION:
        raise ModelError(f"{source}: is not a parameter image of version {VERSION}; write it with hysgen image")
    if size != len(data) or size != 4 * (HEADER_WORDS + 3 * rules + weights + TAIL_WORDS):
        raise ModelError(f"{source}: {len(data)} bytes, its header says {size}; write it again")
    crc, tag = struct.unpack("<IQ", data[-12:])
    if zlib.crc32(data[:-12]) != crc:
        raise ModelError(f"{source}: its CRC does not fit its bytes; write it again")
    if key is not None and siphash(key, data[:-8]) != tag:
        raise ModelError(
            f"{source}: its MAC does not fit its bytes and this key; write it again with the firmware's key"
        )
    bank, half = bank_of(data[4 * HEADER_WORDS :], rules, weights)
    settings = data[-12 - SETTINGS_BYTES : -12]
    return ParameterImage(tuple(digest), bank, Label(device, build, counter), settings, half)


def bank_of(data: bytes, rules: int, weights: int) -> tuple[Bank, float]:
    """The numbers that begin `data`: those of rules and terms, and half the integral of the feedback."""
    values = np.frombuffer(data, "<f4", 3 * rules + weights + 1).astype(np.float32)
    slope, offset, gain = values[: 3 * rules].reshape(3, rules)
    return Bank(slope=slope, offset=offset, gain=gain, weight=values[3 * rules : -1]), float(values[-1])


def read_key(file: Path) -> bytes:
    """The key in the first line of a file: 32 hexadecimal digits. Raises ModelError for anything else."""
    try:
        key = bytes.fromhex(file.read_text(encoding="ascii").split("\n", 1)[0].strip())
    except OSError as fault:
        raise ModelError(f"{file}: cannot be read ({fault.strerror})") from fault
    except ValueError:
        key = b""
    if len(key) != len(NO_KEY):
        raise ModelError(f"{file}: holds no 32 hexadecimal digits; {_MAKE_KEY}")
    return key
