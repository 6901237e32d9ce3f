"""Open-loop play of a table and the record of its readings: what is put out, what is kept, where it ends.

Over the link as `hysgen link record` does it.
"""

# Safety case: [S12]

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fixtures.firmware_bench import Direct, image, wave_V
from hysgen.errors import HysgenError, ModelError
from hysgen.firmware.link import Client, read_table, record_text
from hysgen.firmware.wire import Command, Request, Settings, State, command, payload
from hysgen_lab.firmware.host import BoardFault, HostFirmware
from hysgen_lab.stage import Stage, StageState

TS_S = 20e-6
STEP_V, STEP_UM = 140.0 / 65535, 16.3837 / 65535


def stage(seed: int = 5) -> StageState:
    return StageState(replace(Stage.laboratory(), zero_V=23.0), TS_S, seed)


def board(settings: Settings | None = None) -> tuple[HostFirmware, Client]:
    firmware = HostFirmware(image(), stage(), settings or Settings(ramp_V=0.5))
    return firmware, Client(Direct(firmware, samples=100), timeout_s=5.0)


def test_a_record_holds_the_voltages_that_were_put_out_and_the_readings_before_them() -> None:
    firmware, client = board()
    put, read = [], []
    runs = firmware.run

    def run(reference_um: np.ndarray) -> object:
        log = runs(reference_um)
        played = log.state == State.PLAY
        put.extend(log.output_V[played].tolist())
        read.extend(log.reading_um[played].tolist())
        return log

    firmware.run = run  # type: ignore[assignment, method-assign]
    table_V = wave_V(3000)
    time_s, voltage_V, reading_um = client.record(np.arange(3000) * TS_S, table_V)
    assert time_s.size == 3000
    assert time_s[-1] == pytest.approx(2999 * TS_S)
    assert np.abs(voltage_V - table_V).max() <= 0.5 * STEP_V * (1 + 1e-6)
    # The state is PLAY from the end of RISE, under the first voltage already, until the last voltage is out.
    assert np.abs(np.array(put)[1:] - voltage_V[:-1]).max() < 1e-4
    assert np.abs(np.array(read)[1:] - reading_um[:-1]).max() <= 0.5 * STEP_UM + 1e-6
    assert firmware.state is State.OFF
    assert firmware.board.enabled == 0


def test_a_table_between_whose_rows_are_many_samples_is_followed_in_straight_lines() -> None:
    _, client = board()
    time_s, voltage_V, _ = client.record(np.array([1.0, 1.002, 1.004]), np.array([30.0, 50.0, 40.0]))
    assert time_s.size == 201
    assert np.abs(voltage_V - np.interp(time_s, [0.0, 0.002, 0.004], [30.0, 50.0, 40.0])).max() < STEP_V


STEPS_V, EDGE_V = np.repeat([30.0, 33.0], 10), np.array([58.5, 59.9, 60.9, 58.0])


@pytest.mark.parametrize(
    ("table_V", "fault", "told"),
    [
        (STEPS_V, BoardFault.NONE, "row 10 of 20 .*OUTPUT_SLEWED"),
        (EDGE_V, BoardFault.NONE, "row 2 of 4 .*OUTPUT_LIMITED"),
        (wave_V(3000), BoardFault.AMPLIFIER, "row 2.. of 3000 .*FAULT_AMPLIFIER"),
        (wave_V(3000), BoardFault.STUCK, "row 2.. of 3000 .*FAULT_STUCK"),
    ],
    ids=["step", "edge", "amplifier", "stuck"],
)
def test_a_table_ends_at_a_fault_and_before_a_voltage_beyond_limits(
    table_V: np.ndarray, fault: BoardFault, told: str
) -> None:
    firmware, client = board(Settings(ramp_V=0.5, high_V=60.0))
    # 95 commands of 100 samples before the table is played, 180 samples until its first row.
    firmware.fail(fault, after=9900)
    with pytest.raises(HysgenError, match=told):
        client.record(np.arange(table_V.size) * TS_S, table_V)
    assert firmware.state is (State.TRIPPED if fault else State.OFF)
    assert (firmware.board.output_V, firmware.board.enabled) == (0.0, 0)


def test_a_reading_that_is_none_is_no_number_in_the_record() -> None:
    firmware, client = board()
    firmware.fail(BoardFault.READING, float("nan"), pattern=(1, 50))
    *_, reading_um = client.record(np.arange(500) * TS_S, wave_V(500))
    assert 9 <= int(np.isnan(reading_um).sum()) <= 10
    assert "nan" in record_text(np.arange(500.0), reading_um, reading_um)


def test_tables_that_cannot_be_put_out_are_refused_before_anything_moves(tmp_path: Path) -> None:
    firmware, client = board()
    with pytest.raises(ModelError, match="100001 samples; the firmware records 65536"):
        client.record(np.array([0.0, 2.0]), np.array([30.0, 40.0]))
    with pytest.raises(ModelError, match=r"beyond -20 \.\. 120 V"):
        client.record(np.array([0.0, 0.1]), np.array([30.0, 140.0]))
    assert firmware.state is State.OFF
    file = tmp_path / "table.csv"
    head = "time_s,voltage_V\n"
    texts = {"voltage_V,time_s\n0,1\n": "no table", f"{head}0,x\n": "no table", f"{head}0,nan\n": "no table"}
    for text, words in (texts | {head: "no table", f"{head}0,1\n0,2\n": "do not rise"}).items():
        file.write_text(text)
        with pytest.raises(ModelError, match=words):
            read_table(file)
    with pytest.raises(ModelError, match="cannot be read"):
        read_table(tmp_path / "none")
    file.write_text("# hysgen\ntime_s,voltage_V\n0,1\n0.5,2\n")
    assert [column.tolist() for column in read_table(file)] == [[0.0, 0.5], [1.0, 2.0]]


def code(firmware: HostFirmware, kind: Command, data: bytes) -> int:
    answer = payload(firmware.line(command(kind, 1, data))[:-1])
    assert answer is not None
    return answer[2]


def test_a_table_is_taken_at_rest_only_and_played_once() -> None:
    firmware, _ = board()
    record, piece = bytes([Request.RECORD]), bytes(4) + bytes([0, 0x80] * 32)
    assert code(firmware, Command.REQUEST, record) == 3, "no table"
    assert code(firmware, Command.TABLE, piece) == 0
    assert code(firmware, Command.TABLE, b"\x80\0\0\0" + piece[4:]) == 3, "a piece is missing"
    assert code(firmware, Command.TABLE, b"\0\0\2\0" + piece[4:]) == 3, "beyond the memory"
    assert code(firmware, Command.TABLE, piece[:5]) == 2
    assert code(firmware, Command.REQUEST, record) == 0
    assert code(firmware, Command.TABLE, piece) == 3, "a request waits"
    firmware.run(np.full(50, 2.0))
    assert firmware.state is State.POWER
    assert code(firmware, Command.TABLE, piece) == 3
    assert code(firmware, Command.REQUEST, record) == 0, "a command whose answer was lost"
    firmware.run(np.full(1000, 2.0))
    assert firmware.state is State.OFF
    assert code(firmware, Command.REQUEST, record) == 3, "the readings are no table"
    firmware.request(Request.RECORD)
    firmware.run(np.full(9, 2.0))
    assert firmware.state is State.OFF


def test_a_start_that_would_not_be_taken_is_not_answered_by_done() -> None:
    firmware, _ = board()
    start, stop = bytes([Request.START]), bytes([Request.STOP])
    assert code(firmware, Command.REQUEST, start) == 0
    firmware.run(np.full(200, 2.0))
    assert code(firmware, Command.REQUEST, start) == 0, "on its way: a command whose answer was lost"
    assert code(firmware, Command.REQUEST, stop) == 0
    firmware.run(np.full(2, 2.0))
    assert firmware.state is State.FALL
    assert code(firmware, Command.REQUEST, start) == 3


def test_a_request_that_waits_for_the_interrupt_gives_way_to_stop_only() -> None:
    """STOP behind it was lost, CLEAR too."""
    firmware, _ = board()
    firmware.request(Request.START)
    firmware.run(np.full(200, 2.0))
    for asked, answer in (("CLEAR", 0), ("START", 3), ("CLEAR", 0), ("STOP", 0), ("START", 3), ("CLEAR", 3)):
        assert code(firmware, Command.REQUEST, bytes([Request[asked]])) == answer
    firmware.run(np.full(2, 2.0))
    assert firmware.state is State.FALL


def test_a_table_whose_play_ended_early_is_a_record_and_is_not_played_again() -> None:
    firmware, client = board(Settings(ramp_V=0.5, high_V=60.0))
    with pytest.raises(HysgenError, match="row 2 of 4"):
        client.record(np.arange(4) * TS_S, EDGE_V)
    firmware.request(Request.RECORD)
    firmware.run(np.full(9, 2.0))
    assert firmware.state is State.OFF
