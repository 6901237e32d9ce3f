"""Code, constants and the end of the stack, which nothing may change while the firmware runs."""

# Safety case: [S14]

import numpy as np
import pytest

from fixtures.firmware_bench import Direct, booted
from hysgen.firmware.link import Client
from hysgen.firmware.wire import FirmwareStatus, Request, State
from hysgen_lab.firmware.host import FAULTS, HostFirmware

FILL, WORDS, ROUND = 0x5AFE57AC, 64, 11
"""A round reads eight of the code's and the settings' words a sample."""


def watched() -> HostFirmware:
    """Booted with words that stand for code and stack."""
    firmware = booted()
    firmware.board.watched, firmware.board.stack = WORDS, [FILL] * WORDS
    firmware.board.code = list(range(WORDS))
    firmware.boot()
    return firmware


def told(firmware: HostFirmware) -> FirmwareStatus:
    return FirmwareStatus(firmware.status & FAULTS)


@pytest.mark.parametrize("word", [0, 17, WORDS - 1])
@pytest.mark.parametrize("bit", [0, 31])
def test_a_bit_of_the_code_that_turns_is_told_within_a_round_and_until_the_next_boot(word: int, bit: int) -> None:
    firmware = watched()
    firmware.start(2.0)
    assert (firmware.state, firmware.status) == (State.TRACK, 0)
    firmware.board.code[word] ^= 1 << bit
    firmware.run(np.full(2 * ROUND + 1, 2.0))
    assert (firmware.state, told(firmware)) == (State.TRIP, FirmwareStatus.FAULT_MEMORY)
    firmware.run(np.full(8000, 2.0))
    for request in (Request.CLEAR, Request.START):
        firmware.request(request)
        firmware.run(np.full(3, 2.0))
        assert (firmware.state, told(firmware)) == (State.TRIPPED, FirmwareStatus.FAULT_MEMORY)
    firmware.boot()
    assert firmware.state is State.OFF


@pytest.mark.parametrize("byte", [0, 71])
def test_a_bit_of_the_settings_that_turns_is_told(byte: int) -> None:
    firmware = watched()
    ffi = firmware.image.library.ffi
    settings = ffi.buffer(ffi.addressof(firmware.firmware, "settings"))
    settings[byte] = bytes([settings[byte][0] ^ 0x80])
    firmware.run(np.full(2 * ROUND + 1, 2.0))
    assert told(firmware) == FirmwareStatus.FAULT_MEMORY


def test_the_end_of_the_stack_stays_as_it_is_and_what_was_never_used_is_counted() -> None:
    firmware = watched()
    client = Client(Direct(firmware))
    assert client.status().stack_bytes == 4 * WORDS
    for deepest in (60, 33, 2):
        firmware.board.stack[deepest] = 1
        firmware.run(np.full(3 * ROUND, 2.0))
        assert (client.status().stack_bytes, firmware.status) == (4 * deepest, 0)
    firmware.board.stack[1] ^= 1
    firmware.run(np.full(2, 2.0))
    assert told(firmware) == FirmwareStatus.FAULT_MEMORY
