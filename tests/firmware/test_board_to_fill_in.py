"""The C6748's board layer, compiled on the host as for TI's compiler, with its control registers as plain variables."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from fixtures.firmware_bench import WARNINGS
from hysgen.errors import BuildError
from hysgen.firmware.sources import CONTROLLER, EMPTY_STORE, TARGET_BOARD, read_sources
from hysgen.machine.native import Library, Toolchain, build, default_toolchain

C6X = """
extern unsigned int TSCL, ISTP, ICR, IER, CSR, IFR;
"""
REGISTERS = """
#include "c6x.h"
unsigned int TSCL, ISTP, ICR, IER, CSR, IFR;
void vectors(void);
void vectors(void) {}
"""
DECLARED = """
typedef struct board board_t;
void board_link(board_t *, uint8_t, uint32_t);
uint32_t board_receive(board_t *, uint8_t *, uint32_t, uint32_t *);
uint32_t board_store_write(board_t *, uint32_t, uint32_t, const uint8_t *, uint32_t);
uint32_t board_bytes(void);
void board_clear(board_t *);
"""
SIZE = """
#include "board.h"
uint32_t board_bytes(void);
uint32_t board_bytes(void) { return (uint32_t)sizeof(board_t); }
void board_clear(board_t *board);
void board_clear(board_t *board)
{
    board->line_in = 0u; board->line_start = 0u; board->line_begins = 0u;
    board->line_out = 0u; board->line_begun = 0u; board->line_broken = 1u;
}
"""


def compiled(period_ns: int = 20_000) -> Library:
    """The board's library for a model of this sampling period."""
    board = [(name, text) for name, text in read_sources(TARGET_BOARD) if name != "main.c"] + read_sources(*EMPTY_STORE)
    headers = [(name, text) for name, text in read_sources(CONTROLLER) if name in ("board.h", "number.h")]
    own = [("c6x.h", C6X), ("registers.c", REGISTERS), ("size.c", SIZE)]
    model = ("model.h", f"#define MODEL_PERIOD_NS {period_ns}u\n")
    flags = ("-D__TI_COMPILER_VERSION__=8003000", "-I.", "-Wno-pointer-to-int-cast", "-Wno-conversion", "-Werror")
    return build(
        [*board, *headers, *own, model], DECLARED, Toolchain(default_toolchain().command, (*WARNINGS, *flags)), ()
    )


@functools.cache
def library() -> Library:
    return compiled()


class Line:
    """The line between a link's interrupt and the idle loop."""

    def __init__(self) -> None:
        self._ffi, self._lib = library().ffi, library().lib
        self._kept = self._ffi.new("uint8_t []", self._lib.board_bytes())
        self._board = self._ffi.cast("board_t *", self._kept)
        self._lib.board_clear(self._board)

    def put(self, data: bytes, begins: bool) -> None:
        for i, byte in enumerate(data):
            self._lib.board_link(self._board, byte, int(begins and i == 0))

    def take(self, room: int = 64) -> tuple[bytes, int]:
        data, begin = self._ffi.new("uint8_t []", room), self._ffi.new("uint32_t *")
        count = self._lib.board_receive(self._board, data, room, begin)
        return bytes(self._ffi.buffer(data, count)), begin[0]

    def stored(self, data: bytes) -> int:
        """Bytes that the store says it has written."""
        return int(self._lib.board_store_write(self._board, 0, 0, data, len(data)))

    def take_all(self) -> list[tuple[bytes, int]]:
        taken = []
        while (part := self.take())[0]:
            taken.append(part)
        return taken


def test_the_first_byte_of_an_image_is_the_first_of_a_call() -> None:
    line = Line()
    line.put(b"0123456789", begins=True)
    assert line.take(4) == (b"0123", 1)
    line.put(b"next", begins=True)
    assert line.take() == (b"456789", 0)
    assert line.take() == (b"next", 1)
    assert line.take() == (b"", 0)


def test_a_full_line_loses_the_image_and_only_that_image() -> None:
    line = Line()
    line.put(bytes(300), begins=True)
    line.put(b"the rest of it", begins=False)
    received = b"".join(data for data, _ in line.take_all())
    assert len(received) == 256
    line.put(b"still the rest", begins=False)
    assert line.take_all() == []
    line.put(b"next", begins=True)
    assert line.take_all() == [(b"next", 1)]


def test_any_interleaving_hands_every_byte_on_once_with_the_beginnings_marked() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        line, images, parts = Line(), [], []
        for _ in range(20):
            image = rng.bytes(int(rng.integers(1, 120)))
            images.append(image)
            at = 0
            while at < len(image):
                step = int(rng.integers(1, 40))
                line.put(image[at : at + step], begins=at == 0)
                at += step
                parts += [line.take(int(rng.integers(1, 64))) for _ in range(int(rng.integers(0, 3)))]
            parts += line.take_all()
        found: list[bytes] = []
        for data, begin in parts:
            if begin:
                found.append(data)
            elif data:
                found[-1] += data
        assert found == images


def test_without_a_flash_driver_nothing_claims_to_be_stored() -> None:
    line = Line()
    assert line.stored(b"\0\0\0\0") == 0


def test_a_model_of_another_sampling_period_does_not_compile_into_the_image() -> None:
    with pytest.raises(BuildError, match="sampling period"):
        compiled(100_000)
