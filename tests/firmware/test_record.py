"""Open-loop play of a table and the record of its readings: what is put out, what is kept, where it ends.

Over the link as `hysgen link record` does it. The last test closes the loop from board to model and back.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fixtures.firmware_bench import Direct, compiled, image
from hysgen.cli.main import main
from hysgen.errors import HysgenError, ModelError
from hysgen.firmware.binding import with_learner
from hysgen.firmware.host import BoardFault, HostFirmware, Request, Settings, State
from hysgen.firmware.link import Client, read_table, record_text
from hysgen.firmware.wire import Command, command, payload
from hysgen.model.file import load_model
from hysgen.model.path import preview
from hysgen_lab.stage import Stage, StageState

TS_S = 20e-6
STEP_V, STEP_UM = 140.0 / 65535, 16.3837 / 65535


def stage(seed: int = 5) -> StageState:
    return StageState(replace(Stage.laboratory(), zero_V=23.0), TS_S, seed)


def board(settings: Settings | None = None) -> tuple[HostFirmware, Client]:
    firmware = HostFirmware(image(), stage(), settings or Settings(ramp_V=0.5))
    return firmware, Client(Direct(firmware, samples=100), timeout_s=5.0)


def wave_V(samples: int) -> np.ndarray:
    """Trains of 100, 50 and 25 Hz around the middle, whose amplitudes fall, rise and fall."""
    k = np.arange(samples)
    share = 0.1 + 0.9 * np.abs(2.0 * ((1.5 * k / samples) % 1.0) - 1.0)
    turns = np.cumsum(np.select([3 * k < samples, 3 * k < 2 * samples], [100.0, 50.0], 25.0)) * TS_S
    return 39.0 + 17.0 * share * np.sin(2.0 * np.pi * turns)


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


@pytest.mark.parametrize(
    ("table_V", "row", "told"),
    [
        ([30.0] * 10 + [33.0] * 10, 10, "OUTPUT_SLEWED"),
        ([58.5, 59.9, 60.9] + [58.0] * 9, 2, "OUTPUT_LIMITED"),
    ],
)
def test_a_table_ends_in_front_of_a_voltage_beyond_the_limits(table_V: list[float], row: int, told: str) -> None:
    firmware, client = board(Settings(ramp_V=0.5, high_V=60.0))
    with pytest.raises(HysgenError, match=f"in front of row {row} of {len(table_V)} .*{told}"):
        client.record(np.arange(len(table_V)) * TS_S, np.array(table_V))
    assert firmware.state is State.OFF
    assert firmware.board.output_V == 0.0


@pytest.mark.parametrize(
    ("fault", "value", "told"),
    [(BoardFault.AMPLIFIER, 0.0, "FAULT_AMPLIFIER"), (BoardFault.STUCK, 0.0, "FAULT_STUCK")],
)
def test_a_fault_ends_the_table_and_brings_the_voltage_down(fault: BoardFault, value: float, told: str) -> None:
    firmware, client = board()
    # 95 commands before the table is played, 180 samples until its first row.
    firmware.fail(fault, value, after=9900)
    with pytest.raises(HysgenError, match=told):
        client.record(np.arange(3000) * TS_S, wave_V(3000))
    assert firmware.state is State.TRIPPED
    assert firmware.board.output_V == 0.0


def test_a_reading_that_is_none_is_no_number_in_the_record() -> None:
    firmware, client = board()
    firmware.fail(BoardFault.READING, float("nan"), pattern=(1, 50))
    *_, reading_um = client.record(np.arange(500) * TS_S, wave_V(500))
    assert 9 <= int(np.isnan(reading_um).sum()) <= 10
    assert "nan" in record_text(np.arange(500.0), reading_um, reading_um)


def test_tables_that_cannot_be_put_out_are_refused_before_anything_moves(tmp_path: Path) -> None:
    firmware, client = board()
    for times_s, table_V, words in (
        ([0.0, 2.0], [30.0, 40.0], "100001 samples; the firmware records 65536"),
        ([0.0, 0.1], [30.0, 140.0], "beyond -20 .. 120 V"),
    ):
        with pytest.raises(ModelError, match=words):
            client.record(np.array(times_s), np.array(table_V))
    assert firmware.state is State.OFF
    file = tmp_path / "table.csv"
    for text, words in (
        ("voltage_V,time_s\n0,1\n", "no table"),
        ("time_s,voltage_V\n0,x\n", "no table"),
        ("time_s,voltage_V\n0,nan\n", "no table"),
        ("time_s,voltage_V\n", "no table"),
        ("time_s,voltage_V\n0,1\n0,2\n", "do not rise"),
    ):
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


def errors_um(chosen: str | Path, references_um: np.ndarray) -> np.ndarray:
    """Tracking errors of the firmware with a model, open loop, on a stage of its own, behind the first period."""
    driven = with_learner(load_model(chosen))
    built = image() if chosen == "appendix_a" else compiled(driven)
    firmware = HostFirmware(built, stage(6), Settings(ramp_V=0.05, follow_um=3.0))
    firmware.start(float(references_um[0]))
    assert firmware.state is State.TRACK
    ahead = preview(driven.blocks) + 1
    log = firmware.run(references_um)
    assert firmware.state is State.TRACK
    return (log.reading_um[ahead:] - references_um[:-ahead])[1000:]


@pytest.mark.slow
def test_from_board_to_record_to_diagnosis_to_image_to_board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The stage is the laboratory's, not a model; the firmware that takes the record drives another one."""
    monkeypatch.chdir(tmp_path)
    table_V = wave_V(24_000)
    rows = zip(np.arange(table_V.size) * TS_S, table_V, strict=True)
    Path("table.csv").write_text("time_s,voltage_V\n" + "".join(f"{t:.9g},{u:.9g}\n" for t, u in rows))
    firmware, _ = board()
    monkeypatch.setattr("hysgen.cli.verbs.link.open_line", lambda *_: Direct(firmware, samples=500))
    assert main(["link", "port", "record", "table.csv", "-o", "record.csv"]) == 0
    assert main(["diagnose", "record.csv", "-o", "stage.json"]) == 0
    references_um = 2.0 + 0.6 * np.sin(2 * np.pi * 50.0 * TS_S * np.arange(5000))
    before_um, after_um = errors_um("appendix_a", references_um), errors_um(Path("stage.json"), references_um)
    assert np.sqrt(np.mean(after_um**2)) < 0.2 * np.sqrt(np.mean(before_um**2))
    print(f"{1e3 * np.sqrt(np.mean(before_um**2)):.1f} -> {1e3 * np.sqrt(np.mean(after_um**2)):.1f} nm")
